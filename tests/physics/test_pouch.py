"""Pouches against the volume of their film, by its own geometry: torque, work, energy; tables; what is refused."""

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.interpolate import CubicSpline
from scipy.optimize import brentq

import lamc
from lamc.basics.errors import DesignError, ExpressionError, RequestError
from lamc.effects import Pouch
from lamc.readers.load_scene import load_scene
from lamc.records.scene import Scene
from lamc.reference.check import check
from tests.physics.test_effects import ABOUT_HINGE, pendulum, simulator
from tests.support.ctools import needs_cc

pytestmark = needs_cc

LENGTH, WIDTH, PRESSURE = 0.02, 0.05, 2e4  # m, m, Pa
AREA = LENGTH**2 * WIDTH
FINE = {"rtol": 1e-11, "atol": 1e-13}


def pouch(pressure: float | str = PRESSURE, **more: Any) -> Pouch:
    return Pouch("hip", pressure, LENGTH, WIDTH, **more)


def volume(bent: float) -> float:
    """Over length² width: the triangle of the links, less where they stand into the pouch, and the arc's segment."""
    chord, triangle = math.cos(0.5 * abs(bent)), math.sin(bent) / 8
    if abs(bent) < 1e-6:
        return triangle + math.sqrt(3.0) / 12 * abs(bent)
    arc = brentq(lambda a: math.sin(a) / a - chord, 1e-9, math.pi, xtol=1e-16, rtol=1e-15)
    return triangle + (arc - math.sin(arc) * math.cos(arc)) / (4 * arc**2)


def torque(sim: lamc.Simulator, angle: float, t: float = 0.0, **parameters: float) -> float:
    named = {name.replace("__", "."): value for name, value in parameters.items()}
    return float(sim.acceleration([angle], [0.0], t, named)[0] * ABOUT_HINGE)


@pytest.mark.parametrize("angle", [-2.0, -0.3, 0.2, 1.0, 2.0, 3.0])
def test_its_torque_is_the_slope_of_the_volume(angle: float) -> None:
    """Central differences of order 4 of a volume that knows no slope: 1e-3⁴ and round-off over it, some 1e-11."""
    step = 1e-3
    slope = (
        8 * (volume(angle + step) - volume(angle - step))
        - volume(angle + 2 * step)
        + volume(angle - 2 * step)
    )
    expected = PRESSURE * AREA * slope / (12 * step)
    assert torque(simulator(pendulum(), pouch()), angle) == pytest.approx(
        expected, abs=1e-10 * PRESSURE * AREA
    )


def test_flat_it_bends_towards_the_pouch_with_the_closed_form() -> None:
    """dV/dφ = 1/8 + √3/12 at φ = 0; and at half a turn, where the arc is a circle, -1/8 - 1/(4 π), from there on."""
    flat = (1 / 8 + math.sqrt(3.0) / 12) * PRESSURE * AREA
    sim = simulator(pendulum(), pouch())
    assert torque(sim, 0.0) == pytest.approx(flat, rel=1e-13)
    folded = (-1 / 8 - 1 / (4 * math.pi)) * PRESSURE * AREA
    for angle in (math.pi, 4.0, 9.0):
        assert torque(sim, angle) == pytest.approx(folded, rel=1e-13)
    mirrored = simulator(pendulum(), pouch(reverse=True, flat_angle=0.4))
    assert torque(mirrored, 0.4) == pytest.approx(-flat, rel=1e-13)
    assert torque(mirrored, 0.4 - 0.7) == pytest.approx(-torque(sim, 0.7), rel=1e-13)


@pytest.mark.parametrize("start", [0.0, 0.3])
def test_its_work_is_pressure_times_the_change_of_volume(start: float) -> None:
    sim = simulator(pendulum(), pouch(), lamc.Gravity((0.0, 0.0, -9.81)), angle=start)
    result = sim.run(t_end=1.5, energy_balance=True, **FINE)
    work = result.energy_balance.supplied["pouch"]
    expected = [PRESSURE * AREA * (volume(angle) - volume(start)) for angle in result.angle("hip")]
    assert work == pytest.approx(
        np.array(expected), abs=1e-11
    )  # rtol times some hundred steps, of some 0.01 J
    assert result.energy_balance.balance < 1e-10
    assert np.abs(work).max() > 1e-3


def test_a_pressure_over_time_supplies_the_integral_of_p_dv() -> None:
    sim = simulator(pendulum(), pouch("3e4*sin(4*t)"), angle=0.5)
    t = np.linspace(0.0, 2.0, 20001)
    result = sim.run(t_end=2.0, t_eval=t, energy_balance=True, **FINE)
    assert {event.name for event in result.events} >= {"hip.pouch is under pressure"}
    volumes = AREA * np.array([volume(angle) for angle in result.angle("hip")])
    pressure = np.maximum(3e4 * np.sin(4 * t), 0.0)  # empty below zero
    work = float((0.5 * (pressure[1:] + pressure[:-1]) * np.diff(volumes)).sum())
    # the trapezium rule at 1e-4 s: squares of it times slopes of some 100 per s
    assert result.energy_balance.supplied["pouch"][-1] == pytest.approx(work, abs=1e-6)
    assert result.energy_balance.balance < 1e-10


def test_an_input_is_its_pressure() -> None:
    scene = Scene(effects=(pouch("1e3*p"),), inputs={"p": lamc.Input(20.0)})
    sim = lamc.compile(pendulum(), scene)
    assert torque(sim, 0.7) == pytest.approx(torque(simulator(pendulum(), pouch()), 0.7), rel=1e-13)
    assert torque(sim, 0.7, p=-1.0) == 0.0


ANGLES, PRESSURES = (-0.5, 0.0, 0.4, 1.2), (1e4, 3e4)
TORQUES = ((0.06, 0.05, 0.03, 0.0), (0.17, 0.15, 0.1, 0.02))


@pytest.mark.parametrize("pressure", [0.0, 5e3, 1e4, 2.2e4, 3e4, 5e4])
@pytest.mark.parametrize("angle", [-1.0, -0.2, 0.4, 0.9, 2.0])
def test_a_table_is_read_by_splines_and_lines(pressure: float, angle: float) -> None:
    measured = Pouch("hip", 0.0, angles=ANGLES, pressures=PRESSURES, torques=TORQUES)
    sim = simulator(pendulum(), measured)
    curve = CubicSpline(ANGLES, np.array([(0.0,) * 4, *TORQUES]), axis=1, bc_type="natural")
    near = min(max(angle, ANGLES[0]), ANGLES[-1])
    rows = curve(near) + (angle - near) * curve(near, 1)
    if pressure <= PRESSURES[-1]:
        expected = np.interp(pressure, (0.0, *PRESSURES), rows)
    else:
        expected = rows[2] + (pressure - 3e4) / 2e4 * (rows[2] - rows[1])
    assert torque(sim, angle, hip__pouch__pressure=pressure) == pytest.approx(float(expected), abs=1e-14)


def test_pouches_agree_with_the_independent_cross_checks() -> None:
    measured = Pouch("hip", "4e4*sin(3*t)", angles=ANGLES, pressures=PRESSURES, torques=TORQUES)
    both = (pouch("1e4*(1 + cos(5*t))", flat_angle=-0.5), pouch(reverse=True, flat_angle=0.8), measured)
    sim = simulator(pendulum(), *both)
    assert {"hip.pouch.length", "hip.pouch.2.pressure"} <= set(sim.parameters)
    report = check(sim, states=20, t_end=0.3)
    assert report.passed, report
    for integrator in ("dop853", "radau5"):
        run = sim.run(t_end=1.0, integrator=integrator, energy_balance=True, rtol=1e-9, atol=1e-11)
        assert run.energy_balance.balance < 1e-7  # rtol times some hundred steps


FILM = "joint: hip, pressure: 20 kPa, length: 20 mm, width: 50 mm"
TABLE = "joint: hip, pressure: 1, angles: [0, 1], pressures: [1, 2], torques: [[0, 1], [0, 2]]"
BAD = [
    (FILM.replace("hip", "knee"), "no joint is named 'knee'"),
    (FILM.replace("20 kPa", "-1"), "pressure.* at least 0"),
    (FILM.replace("20 kPa", "pump"), "'pump' is not known.*declared in the scene's inputs"),
    (FILM.replace("20 kPa", "3 N"), "pressure"),
    (FILM.replace("20 mm", "0"), "length.* above 0"),
    (FILM.replace(", width: 50 mm", ""), "is given by length; give length and width, or"),
    ("joint: hip, pressure: 1", "is given by nothing; give"),
    (f"{TABLE}, width: 1", "is given by width, angles, pressures, torques; give"),
    (TABLE.replace("[0, 2]]", "[0]]"), "torques must have as many rows and columns"),
    (TABLE.replace("pressures: [1, 2]", "pressures: [2, 1]"), "ascending: sort the rows"),
    (TABLE.replace("pressures: [1, 2]", "pressures: [0, 1]"), "pressures.* above 0"),
    (TABLE.replace("angles: [0, 1]", "angles: [1, 0]"), "angles must ascend"),
]


@pytest.mark.parametrize(("text", "reported"), BAD)
def test_bad_pouches_are_refused_at_their_line(tmp_path: Path, text: str, reported: str) -> None:
    path = tmp_path / "scene.yaml"
    path.write_text(f"kind: scene\neffects:\n  - gravity\n  - pouch: {{{text}}}\n")
    with pytest.raises((DesignError, ExpressionError), match=reported) as caught:
        lamc.compile(pendulum(), load_scene(path))
    assert "scene.yaml:4" in str(caught.value)


def test_sweeps_refuse_a_pressure_below_zero() -> None:
    with pytest.raises(RequestError, match=r"'hip\.pouch\.pressure' is -1 Pa"):
        simulator(pendulum(), pouch()).run(t_end=0.1, parameters={"hip.pouch.pressure": -1.0})
