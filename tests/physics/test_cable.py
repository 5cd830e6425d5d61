"""Cables through points: geometry by virtual work, slack as free flight, drives, capstan friction; what is refused."""

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import lamc
from lamc import Body, Joint, Mechanism, Scene
from lamc.basics.errors import DesignError, ExpressionError
from lamc.effects import Cable, Gravity
from lamc.readers.load_scene import load_scene
from lamc.reference.check import check
from tests.support.ctools import needs_cc

pytestmark = needs_cc

MOMENT, STIFFNESS = 4e-3, 40.0  # kg·m² of the bar about its pin, N/m
ANCHOR, PULLEY, TIP = (-0.1, 0.2, 0.0), (0.05, 0.3, 0.0), (0.2, 0.0, 0.0)
FINE = {"rtol": 1e-11, "atol": 1e-13}
DOWN = Gravity((0.0, -9.81, 0.0))


def arm() -> Mechanism:
    """A bar of 0.2 m that turns about z at the origin."""
    bar = Body("bar", 0.1, (0.1, 0.0, 0.0), np.diag([1e-4, 3e-3, 3e-3]))
    return Mechanism((Body("wall", fixed=True), bar), (Joint("pin", "wall", "bar", axis=(0.0, 0.0, 1.0)),))


def over_a_pulley(length: float | str | None = 0.3, **more: Any) -> Cable:
    return Cable(("wall", "wall", "bar"), (ANCHOR, PULLEY, TIP), STIFFNESS, length, **more)


def way(angle: float) -> float:
    """From the anchor over the pulley to the tip, m."""
    return math.dist(ANCHOR[:2], PULLEY[:2]) + math.dist(
        PULLEY[:2], (0.2 * math.cos(angle), 0.2 * math.sin(angle))
    )


def way_slope(angle: float) -> float:
    """m/rad: of the tip, 0.2 (-sin, cos), along the line from the pulley."""
    x, y = 0.2 * math.cos(angle) - PULLEY[0], 0.2 * math.sin(angle) - PULLEY[1]
    return 0.2 * (-math.sin(angle) * x + math.cos(angle) * y) / math.hypot(x, y)


@pytest.mark.parametrize("angle", [-0.5, 0.2, 1.0, 2.5])
def test_its_torque_is_tension_times_the_rate_of_the_way(angle: float) -> None:
    """By virtual work; with a damper, on the rate of the way."""
    rate, damping = -0.7, 0.3
    sim = lamc.compile(arm(), Scene(effects=(over_a_pulley(damping=damping),)))
    tension = max(STIFFNESS * (way(angle) - 0.3) + damping * way_slope(angle) * rate, 0.0) * (
        way(angle) > 0.3
    )
    expected = -tension * way_slope(angle) / MOMENT
    assert sim.acceleration([angle], [rate])[0] == pytest.approx(expected, rel=1e-12)  # a few roundings
    stored = 0.5 * STIFFNESS * max(way(angle) - 0.3, 0.0) ** 2
    assert sim.energy([angle], [0.0]) == pytest.approx(stored, rel=1e-12)


def test_left_out_its_length_is_as_drawn() -> None:
    sim = lamc.compile(arm(), Scene(effects=(over_a_pulley(None),)))
    assert sim.parameters["cable.wall.bar.length"] == pytest.approx(way(0.0), rel=1e-15)


def test_a_slack_cable_leaves_flight_free_until_it_is_taut() -> None:
    """A bar that falls from 1.2 rad: m g a (sin 1.2 - sin q) = ½ I u², up to where the way is the length."""
    length = way(0.5)
    sim = lamc.compile(arm(), Scene(effects=(over_a_pulley(length), DOWN), angles={"pin": 1.2}))
    free = lamc.compile(arm(), Scene(effects=(DOWN,), angles={"pin": 1.2}))
    result = sim.run(t_end=1.0, energy_balance=True, **FINE)
    taut = result.events[0].t
    assert "is taut" in result.events[0].name
    alone = free.run(t_end=taut, t_eval=[0.3 * taut, 0.9 * taut, taut], **FINE)
    before = sim.run(t_end=taut, t_eval=[0.3 * taut, 0.9 * taut, taut], **FINE)
    assert before.q == pytest.approx(alone.q, abs=1e-12)  # rtol times some ten steps
    assert alone.q[-1, 0] == pytest.approx(0.5, abs=1e-10)
    fallen = 0.1 * 9.81 * 0.1 * (math.sin(1.2) - math.sin(0.5))
    assert alone.u[-1, 0] == pytest.approx(-math.sqrt(2 * fallen / MOMENT), abs=1e-9)
    assert result.energy == pytest.approx(result.energy[0], abs=1e-10)  # without a damper all is kept
    assert result.energy_balance.balance < 1e-10


@pytest.mark.slow
def test_a_damped_cable_never_pushes() -> None:
    """As scipy has it, with the tension clipped at zero, in steps so short that corners do not show."""
    effects = (over_a_pulley(way(0.5), damping=4.0), DOWN)
    sim = lamc.compile(arm(), Scene(effects=effects, angles={"pin": 1.2}))

    def rhs(_: float, y: np.ndarray) -> list[float]:
        stretch, slope = way(y[0]) - way(0.5), way_slope(y[0])
        tension = max(STIFFNESS * stretch + 4.0 * slope * y[1], 0.0) if stretch > 0.0 else 0.0
        return [y[1], (-tension * slope - 0.1 * 9.81 * 0.1 * math.cos(y[0])) / MOMENT]

    t = np.linspace(0.0, 1.5, 16)
    result = sim.run(t_end=1.5, t_eval=t, energy_balance=True, **FINE)
    # Where it becomes taut the tension jumps by some 8 N; a step of 2e-5 s cannot place that better than by its error
    solved = solve_ivp(rhs, (0.0, 1.5), [1.2, 0.0], t_eval=t, rtol=1e-11, atol=1e-12, max_step=1e-4)
    assert result.angle("pin") == pytest.approx(solved.y[0], abs=1e-6)
    assert {event.name for event in result.events} == {"cable.wall.bar is taut", "cable.wall.bar pulls"}
    assert result.energy_balance.balance < 1e-10
    assert result.energy_balance.supplied["cable"][-1] < 0.0


def test_a_drive_supplies_what_it_winds_against() -> None:
    """Supplied: the integral of tension times the rate at which the length falls."""
    cable = over_a_pulley("0.45 - 0.15*t")
    sim = lamc.compile(arm(), Scene(effects=(cable, DOWN), angles={"pin": 0.0}))
    t = np.linspace(0.0, 1.0, 20001)
    result = sim.run(t_end=1.0, t_eval=t, energy_balance=True, rtol=1e-11, atol=1e-13)
    ways = np.array([way(angle) for angle in result.angle("pin")])
    tension = STIFFNESS * np.maximum(ways - (0.45 - 0.15 * t), 0.0)
    work = float(((tension[1:] + tension[:-1]) / 2).sum() * (t[1] - t[0])) * 0.15
    # the trapezium rule at 5e-5 s, of tensions that swing in some 0.05 s
    assert result.energy_balance.supplied["cable"][-1] == pytest.approx(work, rel=1e-5)
    assert result.energy_balance.balance < 1e-10


@pytest.mark.parametrize("rate", [-2.0, 2.0])
def test_friction_loses_tension_by_the_angle_of_wrap(rate: float) -> None:
    """At a thousand slip speeds: T exp(-μ θ) beyond the pulley where the cable is pulled in, T exp(μ θ) back."""
    friction, angle = 0.3, 0.2
    sim = lamc.compile(arm(), Scene(effects=(over_a_pulley(friction=friction, slip_speed=1e-4),)))
    first = np.array(PULLEY) - ANCHOR
    second = np.array([0.2 * math.cos(angle), 0.2 * math.sin(angle), 0.0]) - PULLEY
    wrap = math.acos(first @ second / np.linalg.norm(first) / np.linalg.norm(second))
    sliding = math.copysign(1.0, -way_slope(angle) * rate)
    tension = STIFFNESS * (way(angle) - 0.3) * math.exp(-friction * wrap * sliding)
    expected = -tension * way_slope(angle) / MOMENT
    assert sim.acceleration([angle], [rate])[0] == pytest.approx(expected, rel=1e-11)


def test_friction_only_takes_energy_and_a_straight_cable_has_none() -> None:
    rubbing = (over_a_pulley(friction=0.4, slip_speed=0.01), DOWN)
    sim = lamc.compile(arm(), Scene(effects=rubbing, angles={"pin": 0.9}))
    balance = sim.run(t_end=2.0, rtol=1e-10, atol=1e-12, energy_balance=True).energy_balance
    assert balance.balance < 1e-9
    assert (np.diff(balance.supplied["cable"]) <= 1e-9 * balance.scale).all()  # what integration leaves
    assert balance.supplied["cable"][-1] < -1e-3
    points = ((-0.2, 0.1, 0.0), (-0.1, 0.1, 0.0), (0.2, 0.1, 0.0))
    straight = Cable(("wall", "wall", "bar"), points, STIFFNESS, 0.3, friction=0.4)
    for integrator in ("dop853", "rodas5p"):  # whose Jacobian has the derivative of the wrap
        run = lamc.compile(arm(), Scene(effects=(straight,))).run(t_end=0.2, integrator=integrator)
        assert run.success


@pytest.mark.slow
def test_cables_agree_with_the_independent_cross_checks() -> None:
    cables = (
        over_a_pulley("0.4 - 0.1*sin(3*t)", damping=0.2, friction=0.2, slip_speed=0.2),
        over_a_pulley(0.5),
    )
    sim = lamc.compile(arm(), Scene(effects=(*cables, DOWN)))
    assert {"cable.wall.bar.stiffness", "cable.wall.bar.2.length"} <= set(sim.parameters)
    report = check(sim, states=20, t_end=0.5)
    assert report.passed, report


GOOD = "bodies: [wall, bar], points: [[0, 0.3, 0], [0.2, 0, 0]], stiffness: 1"
BAD = [
    (GOOD.replace("bar]", "rod]"), "no body is named 'rod'"),
    (GOOD.replace("[wall, bar]", "[wall]"), "1 bodies and 2 points"),
    ("bodies: [bar], points: [[0, 0, 0]], stiffness: 1", "at least 2 points"),
    (GOOD.replace("bar]", "wall]"), "acts on nothing"),
    (GOOD.replace("[0.2, 0, 0]", "[0, 0.3, 0]"), "two points in one place"),
    (GOOD.replace("stiffness: 1", "stiffness: 0"), "stiffness.* above 0"),
    (f"{GOOD}, damping: -1", "damping.* at least 0"),
    (f"{GOOD}, length: 0", "length of the cable is 0 m; it must be above 0"),
    (f"{GOOD}, length: drum - 1", "'drum' is not known.*declared in the scene's inputs"),
    (f"{GOOD}, friction: 0.1", "no point between its ends"),
    (f"{GOOD}, slip_speed: 0", "slip speed.* above 0"),
]


@pytest.mark.parametrize(("text", "reported"), BAD)
def test_bad_cables_are_refused_at_their_line(tmp_path: Path, text: str, reported: str) -> None:
    path = tmp_path / "scene.yaml"
    path.write_text(f"kind: scene\neffects:\n  - gravity\n  - cable: {{{text}}}\n")
    with pytest.raises((DesignError, ExpressionError), match=reported) as caught:
        lamc.compile(arm(), load_scene(path)).run(t_end=0.01)
    assert "scene.yaml:4" in str(caught.value)
