"""The Miura-ori's in-plane stiffness and Poisson ratio against closed forms (M. Schenk and S. D. Guest, Geometry of
Miura-folded metamaterials, PNAS 110, 2013, 3276).

One cell about an inner vertex: facets are parallelograms of sides a and b at the acute angle γ, and slope by θ. Then

    H = a sin θ sin γ        S = b cos θ tan γ / sqrt(1 + cos² θ tan² γ)
    V = b / sqrt(1 + cos² θ tan² γ)        L = a sqrt(1 - sin² θ sin² γ)

the vertex' neighbours lie at (±S, V, 0) and (0, ±L, -H), the cell is 2 S by 2 L, and it has ν_SL = -cos² θ tan² γ.
Creases of b fold by 2 θ, those of a by 2 atan(cos γ tan θ).
"""

import math

import numpy as np
import pytest
from scipy.optimize import brentq

import lamc
from lamc import Body, HingeStiffness, Joint, Mechanism, OutputPoint, RestAngle, Scene, Simulator, Spring
from lamc.run.linear_model import LinearModel
from tests.support.ctools import needs_cc

pytestmark = needs_cc

A, B, GAMMA = 0.03, 0.025, math.radians(62.0)
K_A, K_B = 2e-3, 1.3e-3  # N·m/rad, of a crease of a and one of b
CLOSED_FORM = 1e-6  # relative: what is promised; the positions are known to 1e-12


def sizes(theta: float) -> tuple[float, float, float, float]:
    """H, S, V, L."""
    root = math.sqrt(1.0 + (math.cos(theta) * math.tan(GAMMA)) ** 2)
    return (
        A * math.sin(theta) * math.sin(GAMMA),
        B * math.cos(theta) * math.tan(GAMMA) / root,
        B / root,
        A * math.sqrt(1.0 - (math.sin(theta) * math.sin(GAMMA)) ** 2),
    )


def cell(theta: float, rest: dict[str, float], along: str) -> tuple[Simulator, list[str]]:
    """The cell drawn at θ, and the names of its ends along "S" or "L", between which a spring of no stiffness is drawn.

    rest  of the creases "a" and "b", rad, how much more they would be folded"""
    h, s, v, length = sizes(theta)
    ends = {
        "east": np.array([s, v, 0.0]),
        "north": np.array([0.0, length, -h]),
        "west": np.array([-s, v, 0.0]),
        "south": np.array([0.0, -length, -h]),
    }
    names = list(ends)
    bodies, joints = [], []
    for k, name in enumerate(names):
        following = ends[names[(k + 1) % 4]]
        middle = 0.5 * (ends[name] + following)
        bodies.append(Body(f"f{k}", 1e-3, middle, 1e-7 * np.eye(3), fixed=k == 0))
        before, side = ends[names[(k - 1) % 4]], "b" if name in ("east", "west") else "a"
        # Folded further is where the normals turn further apart; the angle is of the facet behind the crease, or it is
        # told the other way round.
        axis = ends[name] / np.linalg.norm(ends[name])
        normals = np.cross(before, ends[name]), np.cross(ends[name], following)
        sign = math.copysign(1.0, float(np.cross(*normals) @ axis))
        joints.append(
            Joint(
                name,
                f"f{(k - 1) % 4}",
                f"f{k}",
                point=np.zeros(3),
                axis=axis,
                stiffness=K_B if side == "b" else K_A,
                rest_angle=sign * rest[side],
            )
        )
    pair = ("east", "west") if along == "S" else ("north", "south")
    of = {"east": "f0", "north": "f1", "west": "f2", "south": "f3"}
    first, second = (tuple(float(x) for x in ends[name]) for name in pair)
    effects = (HingeStiffness(), RestAngle(), Spring(of[pair[0]], first, of[pair[1]], second, 0.0))
    outputs = tuple(OutputPoint(name, of[name], tuple(float(x) for x in ends[name])) for name in names)
    mechanism = Mechanism(tuple(bodies), tuple(joints), name="miura_cell")
    return lamc.compile(mechanism, Scene(effects=effects, outputs=outputs)), list(pair)


def span(model: LinearModel, pair: tuple[str, str] | list[str]) -> tuple[float, np.ndarray]:
    """The distance of two points, and its row of C."""
    values = dict(zip(model.outputs, zip(model.offset, model.C, strict=True), strict=True))
    between = np.array([values[f"{pair[0]}.{x}"][0] - values[f"{pair[1]}.{x}"][0] for x in "xyz"])
    rows = np.array([values[f"{pair[0]}.{x}"][1] - values[f"{pair[1]}.{x}"][1] for x in "xyz"])
    length = float(np.linalg.norm(between))
    return length, between @ rows / length


@pytest.mark.parametrize("theta", [0.4, 0.9, 1.3])
def test_the_cell_has_the_poisson_ratio_of_its_closed_form(theta: float) -> None:
    sim, _ = cell(theta, {"a": 0.0, "b": 0.0}, "S")
    model = sim.linearise(sim.equilibrium())
    (s, by_s), (length, by_l) = span(model, ("east", "west")), span(model, ("north", "south"))
    assert (s, length) == pytest.approx((2.0 * sizes(theta)[1], 2.0 * sizes(theta)[3]), rel=1e-12)
    ratio = -(by_l[0] / length) / (by_s[0] / s)
    assert ratio == pytest.approx(-((math.cos(theta) * math.tan(GAMMA)) ** 2), rel=CLOSED_FORM)


def folds(theta: float) -> dict[str, float]:
    return {"a": 2.0 * math.atan(math.cos(GAMMA) * math.tan(theta)), "b": 2.0 * theta}


def first_and_second(theta: float, drawn: float, rest: dict[str, float]) -> tuple[float, float]:
    """dU/dθ and d²U/dθ², N·m, of U = Σ k (ρ - ρ_rest)² of two creases of each kind."""
    c, s, g = math.cos(theta), math.sin(theta), math.cos(GAMMA)
    below = c**2 + (g * s) ** 2
    by = {"a": 2.0 * g / below, "b": 2.0}
    twice = {"a": 4.0 * g * s * c * (1.0 - g**2) / below**2, "b": 0.0}
    strain = {name: folds(theta)[name] - folds(drawn)[name] - rest[name] for name in by}
    stiffness = {"a": 2.0 * K_A, "b": 2.0 * K_B}
    first = sum(stiffness[n] * strain[n] * by[n] for n in by)
    return first, sum(stiffness[n] * (by[n] ** 2 + strain[n] * twice[n]) for n in by)


@pytest.mark.quick("strained-S")
@pytest.mark.parametrize("along", ["S", "L"])
@pytest.mark.parametrize("rest", [{"a": 0.0, "b": 0.0}, {"a": 0.5, "b": -0.3}], ids=["relaxed", "strained"])
def test_the_cell_yields_to_small_end_loads_as_its_closed_form(along: str, rest: dict[str, float]) -> None:
    """F = κ x of a spring of no rest length between the ends, with κ from none: dx/dF = (dx/dκ) / x, by A, B and C."""
    drawn = 0.8
    sim, pair = cell(drawn, rest, along)
    point = sim.equilibrium()
    theta = brentq(lambda x: first_and_second(x, drawn, rest)[0], 0.2, 1.4, xtol=1e-15)
    h, s, _, length = sizes(theta)
    (name,) = [name for name in sim.parameters if name.startswith("spring.") and name.endswith(".stiffness")]
    model = sim.linearise(point, inputs=[name])
    x, by_state = span(model, pair)
    assert x == pytest.approx(2.0 * (s if along == "S" else length), rel=1e-9)
    by_kappa = by_state[0] * (-model.B[1, 0] / model.A[1, 0])
    stiffness = -x / by_kappa
    root = math.sqrt(1.0 + (math.cos(theta) * math.tan(GAMMA)) ** 2)
    slopes = {
        "S": -2.0 * B * math.sin(theta) * math.tan(GAMMA) / root**3,
        "L": -2.0 * h * math.cos(theta) * math.sin(GAMMA) * A / length,
    }
    expected = first_and_second(theta, drawn, rest)[1] / slopes[along] ** 2
    assert stiffness == pytest.approx(expected, rel=CLOSED_FORM)


def test_the_cell_yields_to_loads_that_are_not_small_as_its_energy_says() -> None:
    drawn, rest = 0.8, {"a": 0.0, "b": 0.0}
    sim, _ = cell(drawn, rest, "S")
    (name,) = [name for name in sim.parameters if name.startswith("spring.") and name.endswith(".stiffness")]
    kappa = 3.0

    def slope(theta: float) -> float:
        root = math.sqrt(1.0 + (math.cos(theta) * math.tan(GAMMA)) ** 2)
        by_theta = -2.0 * B * math.sin(theta) * math.tan(GAMMA) / root**3
        return first_and_second(theta, drawn, rest)[0] + kappa * 2.0 * sizes(theta)[1] * by_theta

    theta = brentq(slope, drawn, 1.5, xtol=1e-15)
    point = sim.equilibrium(parameters={name: kappa})
    model = sim.linearise(point)
    assert span(model, ("east", "west"))[0] == pytest.approx(2.0 * sizes(theta)[1], rel=1e-9)
