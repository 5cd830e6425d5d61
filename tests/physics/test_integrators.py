"""Implicit integrators, the choice of `auto`, and the derivatives that they stand on."""

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import null_space

import lamc
from lamc import Body, Gravity, HingeDamping, HingeStiffness, Joint, Mechanism, Scene
from lamc.mechanics.linearise import MAX_RATES
from lamc.reference.newton_euler import NewtonEuler
from lamc.run.simulator import Simulator
from tests.support.mechanisms import chain, from_reference, random_state

LENGTH, MASS, STANDARD = 0.1, 0.01, 9.81  # m, kg, m/s²
WEIGHT = MASS * STANDARD * LENGTH  # N·m, the scale of hinge stiffness
IMPLICIT = ("rodas5p", "radau5")


def triple(stiffness: float, damping: float = 0.0) -> Simulator:
    """Three rods on hinges, the first without spring, straight and 1 rad from hanging."""
    inertia = np.diag([MASS * LENGTH**2 / 12, 1e-9, MASS * LENGTH**2 / 12])
    links = tuple(Body(f"l{i}", MASS, (0.0, -(i + 0.5) * LENGTH, 0.0), inertia) for i in range(3))
    names = ("ground", "l0", "l1", "l2")
    joints = tuple(
        Joint(
            f"j{i}",
            names[i],
            names[i + 1],
            (0.0, -i * LENGTH, 0.0),
            (0.0, 0.0, 1.0),
            stiffness=stiffness if i else 0.0,
            damping=damping if i else 0.0,
        )
        for i in range(3)
    )
    scene = Scene(
        effects=(Gravity((0.0, -STANDARD, 0.0)), HingeStiffness(), HingeDamping()), angles={"j0": 1.0}
    )
    return lamc.compile(Mechanism((Body("ground", fixed=True), *links), joints), scene)


def rigid_angle(t: float) -> float:
    """The three as one rod of 3 LENGTH: θ'' = -(3 g / 2 L) sin θ from 1 rad."""
    omega2 = 1.5 * STANDARD / (3 * LENGTH)
    solution = solve_ivp(
        lambda _, y: [y[1], -omega2 * math.sin(y[0])],
        (0.0, t),
        [1.0, 0.0],
        method="DOP853",
        rtol=1e-12,
        atol=1e-14,
    )
    return float(solution.y[0, -1])


@pytest.fixture(scope="module")
def cases(shared: Path) -> dict[str, Any]:
    text = (shared / "reference" / "dynamics.json").read_text(encoding="utf-8")
    return {case["id"]: case for case in json.loads(text)["cases"]}


# ---- derivatives ----------------------------------------------------------------------------------------------


def central(acceleration: Any, q: np.ndarray, u: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Central differences with one Richardson step: errors of h⁴."""
    n = len(q)
    parts = []
    for which in range(2):
        columns = []
        for j in range(n):
            step = np.zeros(n)
            step[j] = 1.0
            moved = [
                (q + h * step, u) if which == 0 else (q, u + h * step) for h in (3e-4, -3e-4, 6e-4, -6e-4)
            ]
            a, b, c, d = (acceleration(*state) for state in moved)
            columns.append((8 * (a - b) - (c - d)) / 3.6e-3)
        parts.append(np.column_stack(columns))
    return parts[0], parts[1]


@pytest.mark.parametrize("kind", ["parallel", "laminate", "space"])
@pytest.mark.parametrize("count", [1, 3, 6])
@pytest.mark.quick("1-space", "3-laminate")
def test_derivatives_are_those_of_the_independent_formulation(kind: str, count: int) -> None:
    mechanism = chain(count, kind, seed=count)
    sim = lamc.compile(mechanism)
    independent = NewtonEuler(mechanism, sim.effects)
    q, u = random_state(count, seed=5)
    found = sim.jacobian(q, u)
    expected = central(lambda a, b: independent.acceleration(a, b), q, u)
    for mine, theirs in zip(found, expected, strict=True):
        # analytic ones against differences with an error of h^4, 1e-9 of the largest; where they would be too long to
        # write out, forward differences of 1e-8 rad
        limit = 1e-7 if "jacobian" in sim.program.functions else 1e-5
        assert np.abs(mine - theirs).max() <= limit * max(1.0, np.abs(theirs).max())


@pytest.mark.parametrize(
    "name", ["fourbar_crank", "fivebar", "vertex4_flatfoldable", "bricard", "sarrus", "waterbomb6"]
)
@pytest.mark.quick("fourbar_crank", "fivebar", "vertex4_flatfoldable")
def test_derivatives_hold_the_loops(cases: dict[str, Any], name: str) -> None:
    """Along all directions in which closed states remain closed to first order."""
    mechanism, scene = from_reference(cases[name]["spec"])
    sim = lamc.compile(mechanism, scene)
    n = len(sim.joints)
    q = sim.start[:n]
    free = null_space(sim.closure(q)[1], rcond=1e-9)
    assert free.shape[1] == sim.loops.freedoms
    u = free @ np.random.default_rng(3).uniform(-1.0, 1.0, free.shape[1])
    by_q, by_u = sim.jacobian(q, u)
    h = 1e-6  # beyond first order the states are open, where equations that disagree give way in turns: errors of h
    for direction in free.T:
        # rates that keep J u = 0 while the angles move: J w = -dJ u
        change = (sim.closure(q + h * direction)[1] - sim.closure(q - h * direction)[1]) / (2 * h)
        w = -np.linalg.pinv(sim.closure(q)[1], rcond=1e-9) @ (change @ u)
        for dq, du in ((direction, w), (np.zeros(n), direction)):
            ahead, behind = (sim.acceleration(q + s * dq, u + s * du) for s in (h, -h))
            expected = (ahead - behind) / (2 * h)
            found = by_q @ dq + by_u @ du
            assert np.abs(found - expected).max() <= 1e-5 * max(1.0, np.abs(expected).max())


def test_long_chains_take_differences() -> None:
    sim = lamc.compile(chain(MAX_RATES + 1, "parallel", seed=1))
    q, u = random_state(MAX_RATES + 1, seed=2)
    assert "jacobian" not in sim.program.functions
    expected = central(lambda a, b: sim.acceleration(a, b), q, u)
    found = sim.jacobian(q, u)
    assert (
        np.abs(found[0] - expected[0]).max() <= 1e-5 * np.abs(expected[0]).max()
    )  # forward differences: 1e-8 of size²


# ---- stiff hinges ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize("integrator", IMPLICIT)
def test_very_stiff_hinges_make_one_rod_of_three(integrator: str) -> None:
    sim = triple(1e10 * WEIGHT)
    result = sim.run(t_end=1.0, rtol=1e-5, atol=1e-7, t_eval=[1.0], integrator=integrator)
    assert result.success
    # rtol times the steps; Rosenbrock methods lose some of their order at such stiffness
    assert result.angle("j0")[0] == pytest.approx(rigid_angle(1.0), abs=3e-5)
    assert result.stats.steps < 200  # explicit steps would be a millionth of a second long


def test_stiffness_costs_no_more_than_ten_times() -> None:
    """k / (m g L) = 1e8 at 1e-5, against 1e4: the count of evaluations, which the time follows."""
    results = {k: triple(k * WEIGHT).run(t_end=1.0, rtol=1e-5, atol=1e-7, t_eval=[1.0]) for k in (1e4, 1e8)}
    stiff = results[1e8]
    assert stiff.angle("j0")[0] == pytest.approx(rigid_angle(1.0), abs=1e-5)
    assert stiff.stats.evaluations < 10 * results[1e4].stats.evaluations


def test_auto_says_when_it_switches() -> None:
    stiff = triple(1e9 * WEIGHT).run(t_end=1.0, rtol=1e-5, atol=1e-7, t_eval=[1.0])
    assert [name for _, name in stiff.stats.switches] == ["rodas5p", "radau5"]
    times = [t for t, _ in stiff.stats.switches]
    assert 0.0 < times[0] <= times[1] < 0.1
    assert stiff.stats.integrator == "rk45, rodas5p, radau5"
    soft = triple(1e2 * WEIGHT).run(t_end=1.0, rtol=1e-9, t_eval=[1.0])
    assert soft.stats.switches == ()
    assert soft.stats.integrator == "dop853"


@pytest.mark.parametrize(("relative", "damping"), [(1e6, 1e-2), (1146362.6662674244, 1e-1)])
def test_auto_chooses_alike_whatever_rows_are_asked_for(relative: float, damping: float) -> None:
    """Trials that come out near the bound: rows between steps cost evaluations, which are none of the motion's."""
    sim = triple(relative * WEIGHT, damping)
    runs = [
        sim.run(t_end=0.1, rtol=1e-6, atol=1e-8, t_eval=times)
        for times in (None, np.linspace(0.0, 0.1, 40001))
    ]
    assert runs[0].stats.switches == runs[1].stats.switches
    np.testing.assert_array_equal(runs[0].q[-1], runs[1].q[-1])


def test_damped_stiff_hinges_are_left_to_the_implicit_method() -> None:
    """Damping ratio 2 of the fast modes: they die, and the rest is one slow swing."""
    stiffness = 1e7 * WEIGHT
    sim = triple(stiffness, 4.0 * math.sqrt(stiffness * MASS * LENGTH**2 / 12))
    result = sim.run(t_end=1.0, rtol=1e-8, atol=1e-10, t_eval=[1.0])
    assert result.angle("j0")[0] == pytest.approx(
        rigid_angle(1.0), abs=1e-6
    )  # the springs still give by 1e-7 rad
    assert result.stats.steps < 3000
    assert result.stats.switches


@pytest.mark.parametrize("damping", [0.1, 10.0, 1e3])  # N·m·s/rad: rates of 3e3 to 3e7 1/s
def test_auto_creeps_through_a_viscous_hinge(damping: float) -> None:
    """A rod so damped that c θ' = -m g L / 2 sin θ: tan(θ/2) falls as exp(-m g L t / (2 c))."""
    moment = MASS * LENGTH**2 / 12
    rod = Body("rod", MASS, (0.0, -LENGTH / 2, 0.0), np.diag([moment, 1e-9, moment]))
    hinge = Joint("h", "ground", "rod", axis=(0.0, 0.0, 1.0), damping=damping)
    scene = Scene(effects=(Gravity((0.0, -STANDARD, 0.0)), HingeDamping()), angles={"h": 1.0})
    sim = lamc.compile(Mechanism((Body("ground", fixed=True), rod), (hinge,)), scene)
    result = sim.run(t_end=3.0, t_eval=[3.0], max_steps=2000)
    assert result.success, result.message
    half = math.tan(0.5) * math.exp(-WEIGHT * 3.0 / (2.0 * damping))
    lag = (MASS * LENGTH**2 / 3) / damping  # s: the rod starts from rest, which the creep leaves out
    fastest = WEIGHT / (2.0 * damping)  # rad/s
    assert result.angle("h")[0] == pytest.approx(2.0 * math.atan(half), abs=lag * fastest + 1e-8)


@pytest.mark.parametrize("integrator", IMPLICIT)
def test_implicit_methods_know_of_the_stabilisation(cases: dict[str, Any], integrator: str) -> None:
    """A Jacobian without Baumgarte's terms would cost them their order, and four times the steps."""
    mechanism, scene = from_reference(cases["fivebar"]["spec"])
    sim = lamc.compile(mechanism, scene)
    plain, stabilised = (
        sim.run(t_end=1.0, t_eval=[1.0], integrator=integrator, baumgarte=rate) for rate in (None, 50.0)
    )
    assert stabilised.stats.steps <= 1.5 * plain.stats.steps
    # Both are within the global error of a run at the default 1e-9, measured against each other.
    np.testing.assert_allclose(stabilised.q, plain.q, rtol=0, atol=1e-8)


@pytest.mark.parametrize("integrator", IMPLICIT)
@pytest.mark.parametrize("name", ["fivebar", "vertex4_flatfoldable", "waterbomb6", "bricard"])
def test_implicit_methods_keep_loops_closed(cases: dict[str, Any], name: str, integrator: str) -> None:
    case = cases[name]
    mechanism, scene = from_reference(case["spec"])
    times = [row["t"] for row in case["expected"]]
    result = lamc.compile(mechanism, scene).run(
        t_end=times[-1], rtol=1e-7, atol=1e-9, t_eval=times, integrator=integrator
    )
    assert result.success, result.message
    assert result.constraint_error.max() <= 1e-9 * mechanism.size
    for k, (row, tol) in enumerate(zip(case["expected"], case["tol"], strict=True)):
        for joint, angle in row["theta"].items():
            difference = math.remainder(result.angle(joint)[k] - angle, 2 * math.pi)
            assert abs(difference) <= max(tol, 3e-5), (
                joint
            )  # between what the file accepts at 1e-6 and at 1e-9


def test_a_stiff_loop_rests_where_its_springs_balance(cases: dict[str, Any]) -> None:
    """A five-bar with springs 1e6 times as stiff and heavily damped: explicit steps would be microseconds long."""
    mechanism, scene = from_reference(cases["fivebar"]["spec"])
    stiffened = Mechanism(
        mechanism.bodies,
        tuple(
            Joint(j.name, j.parent, j.child, j.point, j.axis, stiffness=1e3, damping=10.0)
            for j in mechanism.joints
        ),
    )
    sim = lamc.compile(stiffened, Scene(effects=(HingeStiffness(), HingeDamping()), angles=scene.angles))
    result = sim.run(t_end=10.0, rtol=1e-6, atol=1e-8, t_eval=[10.0])
    assert result.success
    assert result.stats.steps < 3000
    assert np.abs(result.q[-1]).max() < 1e-6  # the drawn position, where all springs are relaxed
    assert result.constraint_error.max() <= 1e-9 * mechanism.size


# ---- Baumgarte ------------------------------------------------------------------------------------------------


def test_baumgarte_drifts_where_projection_does_not(cases: dict[str, Any]) -> None:
    mechanism, scene = from_reference(cases["fourbar_crank"]["spec"])
    sim = lamc.compile(mechanism, scene)
    projected = sim.run(t_end=2.0, rtol=1e-5, atol=1e-7, integrator="rk45")
    pulled = sim.run(t_end=2.0, rtol=1e-5, atol=1e-7, integrator="rk45", baumgarte=50.0)
    assert pulled.success
    assert projected.constraint_error.max() < 1e-9 * mechanism.size < pulled.constraint_error.max()
    assert pulled.constraint_error.max() < 1e-3 * mechanism.size  # it is held, if loosely
    assert np.abs(pulled.q[-1] - projected.q[-1]).max() < 1e-2


def test_baumgarte_can_step_at_a_fixed_cost(cases: dict[str, Any]) -> None:
    mechanism, scene = from_reference(cases["fourbar_crank"]["spec"])
    sim = lamc.compile(mechanism, scene)
    step = 2e-4  # s
    result = sim.run(t_end=0.5, rtol=1.0, atol=1e6, max_step=step, integrator="rk45", baumgarte=200.0)
    assert result.stats.rejected == 0
    steps = np.diff(result.t)[10:-2]  # the first ones grow, and the last is what is left
    assert steps == pytest.approx(step, rel=1e-9)
    assert result.constraint_error.max() < 1e-5 * mechanism.size  # steps of 2e-4 s, of fifth order
    exact = sim.run(t_end=0.5, rtol=1e-10, t_eval=[0.5])
    assert np.abs(result.q[-1] - exact.q[-1]).max() < 1e-4


@pytest.mark.parametrize("rate", [0.0, -1.0, math.nan, "fast", True])
def test_rates_of_baumgarte_that_make_no_sense_are_refused(cases: dict[str, Any], rate: Any) -> None:
    sim = lamc.compile(*from_reference(cases["fourbar_crank"]["spec"]))
    with pytest.raises(lamc.RequestError, match="baumgarte is"):
        sim.run(t_end=0.1, baumgarte=rate)


def test_baumgarte_without_loops_is_refused() -> None:
    with pytest.raises(lamc.RequestError, match="no loops to stabilise"):
        triple(WEIGHT).run(t_end=0.1, baumgarte=10.0)
