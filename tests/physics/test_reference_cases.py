"""Every case of reference/dynamics.json is met: which test covers which, and those that have no other place.

Tolerances are each case's own `tol`. What is compared comes from its source or from closed forms, never from lamc.
"""

import importlib
import inspect
import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.special import ellipj, ellipk

import lamc
from lamc import Body, Gravity, HingeDamping, HingeStiffness, Joint, Mechanism, Scene
from tests.support.ctools import needs_cc

pytestmark = needs_cc

Z = (0.0, 0.0, 1.0)
DOWN = Gravity((0.0, -9.81, 0.0))

FOLDERS = {"test_popupcad_pendulum": "unit"}  # of tests that are not beside this one
LOOPS = "test_loops:test_loops_move_as_computed_independently"
CROSS_CHECKS = "test_three_cross_checks:test_reference_cases_are_met_within_what_they_accept"
STIFF = "test_reference_cases:test_stiff_hinges_hold_a_triple_pendulum_straight"
LIMITS = "test_joint_limits:test_a_plate_swings_against_its_stop_as_computed_independently"
COVERED_BY = {
    "popupcad_pendulum": "test_popupcad_pendulum:"
    "test_popupcad_pendulum_swings_as_computed_from_its_geometry_alone",
    "fourbar_crank": LOOPS,
    "nfourbar2": "test_loops:test_a_mechanism_passes_through_its_singular_position_on_its_branch",
    "fivebar": LOOPS,
    "vertex4_flatfoldable": LOOPS,
    "waterbomb6": LOOPS,
    "miura22": LOOPS,
    "miura33": LOOPS,
    "bricard": LOOPS,
    "sarrus": LOOPS,
    "double_pendulum": CROSS_CHECKS,
    "mass_ratio": CROSS_CHECKS,
    "triple_stiff_e2": CROSS_CHECKS,
    "iftomm_A01": "test_reference_cases:test_point_mass_on_a_massless_rod_keeps_time_for_2000_s",
    "iftomm_A02_N2": "test_reference_cases:test_thin_rods_pass_their_singular_positions",
    "andrews_squeezer": "test_spring:test_andrews_squeezer_meets_the_published_digits",
    "loop_ranks": "test_loops:test_loops_are_counted_as_in_the_field",
    "misaligned_fourbar": "test_loop_analysis:test_a_misaligned_hinge_shows_in_the_singular_values",
    "vertex4_flat_branches": "test_loop_analysis:test_a_flat_vertex_has_the_two_published_branches",
    "joint_limit_penalty_elastic": LIMITS,
    "joint_limit_restitution": LIMITS,
    "triple_stiff_smooth_k1e+02": STIFF,
    "triple_stiff_smooth_k1e+04": STIFF,
    "triple_stiff_smooth_k1e+06": STIFF,
    "triple_stiff_damped_k1e+02": STIFF,
    "triple_stiff_damped_k1e+04": STIFF,
}


@pytest.fixture(scope="module")
def cases(shared: Path) -> dict[str, Any]:
    text = (shared / "reference" / "dynamics.json").read_text(encoding="utf-8")
    return {case["id"]: case for case in json.loads(text)["cases"]}


def test_every_case_is_claimed_by_a_test(cases: dict[str, Any]) -> None:
    assert sorted(COVERED_BY) == sorted(cases)
    for case, where in COVERED_BY.items():
        module_name, function = where.split(":")
        module = importlib.import_module(f"tests.{FOLDERS.get(module_name, 'physics')}.{module_name}")
        assert callable(getattr(module, function)), (case, where)
        assert function.startswith("test_"), (case, where)  # else pytest does not collect it
        assert f'"{case}"' in inspect.getsource(module), (case, where)


def ball_on_a_rod() -> Mechanism:
    """IFToMM A01: 1 kg without extent, 1 m from its pin, drawn level."""
    ball = Body("ball", mass=1.0, com=(1.0, 0.0, 0.0), inertia=np.zeros((3, 3)))
    return Mechanism((Body("wall", fixed=True), ball), (Joint("pin", "wall", "ball", axis=Z),))


def swing(t: Any) -> tuple[Any, Any]:
    """The ball's place (x, y), m, at times t: Jacobi's solution of a pendulum released level, amplitude 90°."""
    modulus = math.sin(math.pi / 4) ** 2
    sine = ellipj(ellipk(modulus) + math.sqrt(9.81) * np.asarray(t), modulus)[0]
    from_hanging = 2 * np.arcsin(math.sqrt(modulus) * sine)
    return np.sin(from_hanging), -np.cos(from_hanging)


@pytest.mark.slow
def test_point_mass_on_a_massless_rod_keeps_time_for_2000_s(cases: dict[str, Any]) -> None:
    """845 swings. What is left at this step is round-off, 2e-10 m; the time must be summed without bias for that."""
    case = cases["iftomm_A01"]
    times = [float(row["t"]) for row in case["expected"]]
    expected = np.array([(row["x"], row["y"]) for row in case["expected"]])
    np.testing.assert_allclose(
        np.transpose(swing(times)), expected, rtol=0, atol=1e-11
    )  # round-off of t = 2000
    sim = lamc.compile(ball_on_a_rod(), Scene(effects=(DOWN,)))
    result = sim.run(
        t_end=2000.0,
        rtol=1e-13,
        atol=1e-15,
        t_eval=times,
        integrator="rk45",
        max_step=1e-3,
        max_steps=3_000_000,
    )
    assert result.success, result.message
    place = np.transpose([np.cos(result.angle("pin")), np.sin(result.angle("pin"))])
    np.testing.assert_allclose(place, expected, rtol=0, atol=case["tol"])


def test_iftomm_a01_is_solved_to_the_benchmarks_high_precision_in_4000_outputs() -> None:
    times = np.linspace(0.0, 2000.0, 4000)
    sim = lamc.compile(ball_on_a_rod(), Scene(effects=(DOWN,)))
    result = sim.run(t_end=2000.0, rtol=1e-10, atol=1e-12, t_eval=times)
    assert result.success, result.message
    x, y = swing(times)
    error = np.hypot(np.cos(result.q[:, 0]) - x, np.sin(result.q[:, 0]) - y)
    assert error.max() < 1e-3  # m, the benchmark's threshold for its high-precision solutions


def stiff_chain(stiffness: float, damping: float) -> Mechanism:
    """Three rods of 0.1 m and 0.01 kg that hang; the first hinge is free."""
    length, mass = 0.1, 0.01
    bodies = [Body("ground", fixed=True)]
    joints = []
    for i in range(3):
        moment = mass * length**2 / 12
        com = (0.0, -length * (i + 0.5), 0.0)
        bodies.append(Body(f"rod{i}", mass, com, np.diag([moment, 0.0, moment])))
        values = {"stiffness": stiffness, "damping": damping} if i else {}
        joints.append(Joint(f"h{i}", bodies[i].name, f"rod{i}", (0.0, -length * i, 0.0), axis=Z, **values))
    return Mechanism(tuple(bodies), tuple(joints))


@pytest.mark.parametrize("case_id", [case for case, where in COVERED_BY.items() if where == STIFF])
def test_stiff_hinges_hold_a_triple_pendulum_straight(cases: dict[str, Any], case_id: str) -> None:
    case = cases[case_id]
    absolute = (1.0, 1.01 if case["c"] else 1.0, 1.0)  # rad, from hanging, at rest; as the cases' notes say
    angles = dict(zip(("h0", "h1", "h2"), np.diff([0.0, *absolute]).tolist(), strict=True))
    effects = (DOWN, HingeStiffness(), *((HingeDamping(),) if case["c"] else ()))
    sim = lamc.compile(stiff_chain(case["k"], case["c"]), Scene(effects=effects, angles=angles))
    end = case["expected"]["t"]
    result = sim.run(t_end=end, rtol=1e-9, atol=1e-11, t_eval=[end], integrator="auto")
    assert result.success, result.message
    # An angle from hanging is the sum of the joint angles up to there, and so is its rate.
    angle_error = np.abs(np.cumsum(result.q[0]) - case["expected"]["abs_angles"]).max()
    rate_error = np.abs(np.cumsum(result.u[0]) - case["expected"]["abs_rates"]).max()
    assert angle_error <= case["tol"]["angles"]
    assert rate_error <= case["tol"]["rates"]


def thin_rods() -> Mechanism:
    """IFToMM A02 with N = 2: three upright and two level rods of 1 m and 1 kg, without extent about their lengths."""
    moment = 1 / 12
    bodies = [Body("ground", fixed=True)]
    joints = []
    for i in range(3):
        bodies.append(Body(f"v{i}", 1.0, (i, 0.5, 0.0), np.diag([moment, 0.0, moment])))
        joints.append(Joint(f"g{i}", "ground", f"v{i}", (i, 0.0, 0.0), axis=Z))
    for i in range(2):
        bodies.append(Body(f"h{i}", 1.0, (i + 0.5, 1.0, 0.0), np.diag([0.0, moment, moment])))
        joints.append(Joint(f"p{i}", f"v{i}", f"h{i}", (i, 1.0, 0.0), axis=Z))
        joints.append(Joint(f"r{i}", f"h{i}", f"v{i + 1}", (i + 1, 1.0, 0.0), axis=Z))
    return Mechanism(tuple(bodies), tuple(joints))


@pytest.mark.parametrize("rtol", [1e-12, 1e-13])
def test_thin_rods_pass_their_singular_positions(cases: dict[str, Any], rtol: float) -> None:
    """Flat five times in 10 s, where the mobility grows from 1 to 3."""
    case = cases["iftomm_A02_N2"]
    start = {"g0": -1.0, "g1": -1.0, "g2": -1.0, "p0": 1.0, "p1": 1.0}  # rad/s: 1 m/s to the right at the top
    sim = lamc.compile(thin_rods(), Scene(effects=(DOWN,), rates=start))
    times = [row["t"] for row in case["expected"]]
    result = sim.run(t_end=times[-1], rtol=rtol, atol=1e-2 * rtol, t_eval=times, integrator="rk45")
    assert result.success, result.message
    angle, rate = result.angle("g0"), result.rate("g0")
    names = ("x", "y", "vx", "vy")  # of the top of the first rod
    found = np.transpose([-np.sin(angle), np.cos(angle), -np.cos(angle) * rate, -np.sin(angle) * rate])
    expected = [[row[name] for name in names] for row in case["expected"]]
    np.testing.assert_allclose(found, expected, rtol=0, atol=case["tol"])
