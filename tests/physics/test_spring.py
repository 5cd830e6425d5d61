"""The spring between two points: closed forms, and Andrews' squeezing mechanism with its published digits."""

import json
import math
from pathlib import Path

import numpy as np
import pytest

import lamc
from lamc import Body, Joint, Mechanism, Scene, Spring
from tests.support.ctools import needs_cc

pytestmark = needs_cc

Z = (0.0, 0.0, 1.0)


def arm() -> Mechanism:
    """A bar of 0.2 m that turns about z at the origin; I about the hinge 4e-3 kg·m²."""
    bar = Body("bar", 0.1, (0.1, 0.0, 0.0), np.diag([1e-4, 3e-3, 3e-3]))
    return Mechanism((Body("wall", fixed=True), bar), (Joint("pin", "wall", "bar", axis=Z),))


def test_a_spring_of_no_rest_length_is_linear_in_the_force_vector() -> None:
    """Torque about the pin: k b a sin(angle) towards the anchor at (b, 0) from a tip at radius a."""
    sim = lamc.compile(arm(), Scene(effects=(Spring("wall", (0.5, 0, 0), "bar", (0.2, 0, 0), 7.0),)))
    angle = 0.7
    expected = -7.0 * 0.5 * 0.2 * math.sin(angle) / 4e-3
    assert sim.acceleration([angle], [0.0])[0] == pytest.approx(expected, rel=1e-13)  # a few roundings


def test_a_spring_with_length_and_damping_pulls_along_its_line() -> None:
    k, rest, c = 7.0, 0.25, 0.3
    spring = Spring("wall", (0.5, 0.1, 0), "bar", (0.2, 0, 0), k, rest, c)
    sim = lamc.compile(arm(), Scene(effects=(spring,)))
    angle, rate = -0.4, 1.7
    tip = 0.2 * np.array([math.cos(angle), math.sin(angle)])
    velocity = 0.2 * rate * np.array([-math.sin(angle), math.cos(angle)])
    line = tip - np.array([0.5, 0.1])
    length = float(np.linalg.norm(line))
    force = -(k * (length - rest) + c * float(line @ velocity) / length) * line / length
    expected = (tip[0] * force[1] - tip[1] * force[0]) / 4e-3
    assert sim.acceleration([angle], [rate])[0] == pytest.approx(expected, rel=1e-13)  # a few roundings
    assert sim.energy([angle], [0.0]) == pytest.approx(0.5 * k * (length - rest) ** 2, rel=1e-13)


def test_several_springs_act_together_and_have_their_own_parameters() -> None:
    one = Spring("wall", (0.5, 0, 0), "bar", (0.2, 0, 0), 7.0)
    two = Spring("wall", (0, 0.5, 0), "bar", (0.2, 0, 0), 3.0, 0.1)
    both = lamc.compile(arm(), Scene(effects=(one, two)))
    alone = [lamc.compile(arm(), Scene(effects=(s,))).acceleration([0.3], [0.0])[0] for s in (one, two)]
    assert both.acceleration([0.3], [0.0])[0] == pytest.approx(sum(alone), rel=1e-13)  # a few roundings
    assert len([name for name in both.parameters if name.startswith("spring.")]) == 3


@pytest.mark.parametrize("field", ["stiffness", "rest_length", "damping"])
def test_springs_that_no_shop_sells_are_refused(field: str) -> None:
    values = {"stiffness": 1.0, "rest_length": 0.1, "damping": 0.0, field: -1.0}
    with pytest.raises(lamc.DesignError, match=rf"spring\.{field}: the .*at least 0"):
        Spring("wall", (0, 0, 0), "bar", (1, 0, 0), **values)


def squeezer(p: dict[str, float], m: list[float], inertia: list[float], q: list[float]) -> Mechanism:
    """Andrews' seven-body mechanism, drawn in its start; the equations of the test set give points and centres."""
    beta, theta, gamma, phi, delta, omega, eps = q
    bt, pd, oe = beta + theta, phi + delta, omega + eps
    a, b = np.array([p["xa"], p["ya"]]), np.array([p["xb"], p["yb"]])

    def along(angle: float) -> np.ndarray:
        return np.array([math.cos(angle), math.sin(angle)])

    def across(angle: float) -> np.ndarray:
        return np.array([math.sin(angle), -math.cos(angle)])

    tip = p["rr"] * along(beta)
    meeting = tip - p["d"] * along(bt)
    knee5, knee7 = a + p["zt"] * along(delta), a + p["u"] * across(eps)
    coms = [
        p["ra"] * along(beta),
        tip - p["da"] * along(bt),
        b + p["sa"] * across(gamma) + p["sb"] * along(gamma),
        knee5 + (p["e"] - p["ea"]) * across(pd),
        a + p["ta"] * along(delta) - p["tb"] * across(delta),
        knee7 + (p["zf"] - p["fa"]) * along(oe),
        a + p["ua"] * across(eps) - p["ub"] * along(eps),
    ]
    bodies = [Body("ground", fixed=True)]
    for i, (mass, moment, com) in enumerate(zip(m, inertia, coms, strict=True), 1):
        bodies.append(Body(f"k{i}", mass, (*com, 0.0), np.diag([moment, moment, moment])))
    joints = [
        ("beta", "ground", "k1", np.zeros(2)),
        ("theta", "k1", "k2", tip),
        ("gamma", "ground", "k3", b),
        ("p3", "k2", "k3", meeting),
        ("delta", "ground", "k5", a),
        ("phi", "k5", "k4", knee5),
        ("p4", "k2", "k4", meeting),
        ("eps", "ground", "k7", a),
        ("omega", "k7", "k6", knee7),
        ("p6", "k2", "k6", meeting),
    ]
    return Mechanism(
        tuple(bodies), tuple(Joint(n, x, y, (*at, 0.0), Z) for n, x, y, at in joints), name="squeezer"
    )


def test_andrews_squeezer_meets_the_published_digits(shared: Path) -> None:
    cases = json.loads((shared / "reference" / "dynamics.json").read_text(encoding="utf-8"))["cases"]
    case = next(c for c in cases if c["id"] == "andrews_squeezer")
    p, q0 = dict(case["parameters"]), case["q0"]
    mechanism = squeezer(p, p.pop("m"), p.pop("I"), q0)
    gamma = q0[2]
    anchor = (
        p["xb"] + p["sc"] * math.sin(gamma) + p["sd"] * math.cos(gamma),
        p["yb"] - p["sc"] * math.cos(gamma) + p["sd"] * math.sin(gamma),
        0.0,
    )
    spring = Spring("ground", (p["xc"], p["yc"], 0.0), "k3", anchor, p["c0"], p["l0"])
    sim = lamc.compile(mechanism, Scene(effects=(spring, lamc.Torque({"beta": p["mom"]}))))
    assert (sim.loops.loops, sim.loops.freedoms) == (3, 1)
    result = sim.run(t_end=0.03, rtol=1e-11, atol=1e-11, t_eval=[0.03])
    assert result.success, result.message
    names = ("beta", "theta", "gamma", "phi", "delta", "omega", "eps")
    for name, start, end in zip(names, q0, case["expected"]["q"], strict=True):
        difference = math.remainder(start + result.angle(name)[0] - end, 2 * math.pi)
        assert abs(difference) < case["tol"], name  # the case's own tolerance
