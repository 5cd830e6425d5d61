"""Inputs that follow series: closed forms, orders of the methods across kinks, steps, and three cross-checks."""

import math
import pickle
import warnings
from collections.abc import Callable

import numpy as np
import numpy.typing as npt
import pytest
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline

import lamc
from lamc import Body, Gravity, Input, Joint, JointLimits, Mechanism, Scene, Series, Torque
from lamc.basics.errors import DesignError, DesignWarning, RequestError, UnsupportedError
from lamc.effects import HingeDamping
from lamc.effects.base_motion import BaseMotion
from lamc.effects.external_torque import ExternalTorque
from lamc.ledger.bench import measure
from lamc.reference.check import check
from lamc.reference.interpreter import Interpreter
from lamc.run.simulator import Simulator
from tests.support.closed_mechanisms import closed_mechanism
from tests.support.ctools import needs_cc
from tests.support.ensembles import assert_alike
from tests.support.mechanisms import chain, random_state

pytestmark = needs_cc

Array = npt.NDArray[np.float64]

M, L, G, IY = 0.4, 0.25, 9.81, 0.006  # kg, m, m/s², kg·m² about the hinge's axis at the centre of mass
ABOUT = IY + M * L * L  # kg·m², about the hinge
TIMES = np.array([0.0, 0.13, 0.31, 0.32, 0.57, 0.9, 1.1])
VALUES = np.array([0.0, 0.4, -0.3, 0.5, 0.2, -0.6, 0.1])
EXPLICIT, IMPLICIT = ("rk45", "dop853"), ("rodas5p", "radau5")


def pendulum() -> Mechanism:
    bob = Body("bob", M, [0.0, 0.0, -L], np.diag([0.004, IY, 0.003]))
    joint = Joint("h", "ground", "bob", point=[0.0, 0.0, 0.0], axis=[0.0, 1.0, 0.0])
    return Mechanism((Body("ground", fixed=True), bob), (joint,))


def driven(series: Series, *others: object, text: str = "command") -> Simulator:
    effects = (Torque({"h": text}), *others)
    scene = Scene(effects=effects, inputs={"command": Input(unit="N*m", series=series)})  # type: ignore[arg-type]
    return lamc.compile(pendulum(), scene)


def twice_integrated(series: Series, t: float) -> float:
    """∫∫ of the table, by pieces: the angle of a free link times its inertia."""
    angle = rate = 0.0
    for a, b, v, w in zip(series.t, series.t[1:], series.values, series.values[1:], strict=False):
        h = min(b, t) - a
        if h <= 0.0:
            break
        slope = (w - v) / (b - a) if series.hold == "linear" else 0.0
        angle += rate * h + v * h * h / 2 + slope * h**3 / 6
        rate += v * h + slope * h * h / 2
    return angle


@pytest.mark.parametrize("hold", ["previous", "linear"])
@pytest.mark.parametrize("method", ["auto", *EXPLICIT, *IMPLICIT, "scipy:DOP853", "scipy:Radau"])
def test_a_free_link_turns_by_the_table_integrated_twice(hold: str, method: str) -> None:
    series = Series(TIMES, VALUES, hold)
    sim = driven(series)
    result = sim.run(t_end=1.1, integrator=method)
    expected = twice_integrated(series, 1.1) / ABOUT
    # Every piece is a polynomial of degree 3 at most, which all of these methods integrate exactly: what is left is
    # round-off, and of scipy's Radau the Newton iteration, which ends at a share of the tolerance.
    assert result.q[-1, 0] == pytest.approx(expected, rel=1e-9 if method == "scipy:Radau" else 1e-12)
    assert np.isin(TIMES, result.t).all()  # a step ends at every kink


def pendulum_by_hand(torque: Callable[[float], float], knots: Array, t_end: float, start: float) -> Array:
    """The angle and rate at t_end of I θ̈ = τ(t) - m g l sin θ, by scipy, from knot to knot."""
    y, ends = np.array([start, 0.0]), [*knots[(knots > 0.0) & (knots < t_end)], t_end]
    begin = 0.0
    for end in ends:
        middle = 0.5 * (begin + end)  # rows hold to the end of each part, where the next begins

        def right(t: float, y: Array, lo: float = begin, hi: float = end, mid: float = middle) -> list[float]:
            inside = min(max(t, np.nextafter(lo, mid)), np.nextafter(hi, mid))
            return [y[1], (torque(inside) - M * G * L * math.sin(y[0])) / ABOUT]

        y = solve_ivp(right, (begin, end), y, method="DOP853", rtol=1e-13, atol=1e-15).y[:, -1]
        begin = end
    return y


def table(hold: str, t0: Array = TIMES) -> Callable[[float], float]:
    """The torque by numpy and scipy alone."""
    if hold == "linear":
        return lambda t: float(np.interp(t, t0, VALUES))
    if hold == "cubic":
        spline = CubicSpline(t0, VALUES)
        return lambda t: float(spline(t))
    return lambda t: float(VALUES[np.searchsorted(t0, t, side="right") - 1])


# Orders by Hairer, Nørsett & Wanner: a step across a kink that no step ends at errs by h² (a jump: by h), whatever the
# method, and halving steps would then divide the error by some 4 (2). Not Radau IIA: its Newton iteration ends at a
# share of the tolerance, of which there is none here.
@pytest.mark.parametrize("hold", ["previous", "linear", "cubic"])
@pytest.mark.parametrize(("method", "order"), [("rk45", 5), ("rodas5p", 5), ("dop853", 8)])
def test_no_method_loses_its_order_to_kinks(hold: str, method: str, order: int) -> None:
    knots = np.array(
        [0.0, 0.1, 0.3, 0.4, 0.6, 0.9, 1.1]
    )  # multiples of the steps, which then are of one length
    sim = driven(Series(knots, 5.0 * VALUES, hold), Gravity((0.0, 0.0, -G)))
    torque = table(hold, knots)
    exact = pendulum_by_hand(lambda t: 5.0 * torque(t), knots, 1.1, 0.0)
    errors = []
    for longest in (0.1, 0.025):
        # tolerances that accept every step: the longest step alone decides
        done = sim.run(t_end=1.1, rtol=1e-6, atol=1e6, max_step=longest, integrator=method)
        errors.append(np.abs([done.q[-1, 0] - exact[0], 0.1 * (done.u[-1, 0] - exact[1])]).max())
    # Twice halved is divided by 4^order in the end; the first steps, which grow to that length, are uneven still.
    assert math.log2(errors[0] / errors[1]) / 2 > order - 0.5


@pytest.mark.parametrize("hold", ["previous", "linear", "cubic"])
@pytest.mark.parametrize("method", [*EXPLICIT, *IMPLICIT])
def test_a_driven_pendulum_agrees_with_scipy(hold: str, method: str) -> None:
    sim = driven(Series(TIMES, VALUES, hold), Gravity((0.0, 0.0, -G)))
    result = sim.run(t_end=1.1, integrator=method, rtol=1e-10, atol=1e-12)
    exact = pendulum_by_hand(table(hold), TIMES, 1.1, 0.0)
    # global errors: some hundred steps at 1e-10 each
    assert result.q[-1, 0] == pytest.approx(exact[0], abs=5e-9)
    assert result.u[-1, 0] == pytest.approx(exact[1], abs=5e-8)


@pytest.mark.parametrize("method", [*EXPLICIT, *IMPLICIT])
def test_rows_within_steps_do_not_see_what_follows_a_jump(method: str) -> None:
    series = Series(TIMES, VALUES, "previous")
    times = np.unique(np.concatenate([np.linspace(0.0, 1.1, 57), TIMES]))
    result = driven(series).run(t_end=1.1, integrator=method, t_eval=times)
    expected = [twice_integrated(series, t) / ABOUT for t in times]
    # polynomials of degree 2: continuous extensions hold them to round-off
    assert np.allclose(result.q[:, 0], expected, rtol=0.0, atol=1e-12)


def test_a_run_in_slices_gives_the_same_bits() -> None:
    sim = driven(Series(TIMES, VALUES, "linear"), Gravity((0.0, 0.0, -G)))
    first, again = (sim.run(t_end=1.1, progress=told) for told in (None, lambda t, t_end: None))
    assert np.array_equal(first.q, again.q)
    sim.run(t_end=1.0)  # another run in between leaves no trace
    assert np.array_equal(sim.run(t_end=1.1).q, first.q)


def sine(rows: int, hold: str = "linear", noise: float = 0.0) -> Series:
    t = np.linspace(0.0, 2.0, rows)
    values = 0.3 * np.sin(2 * np.pi * t)
    return Series(t, values + noise * np.random.default_rng(0).standard_normal(rows), hold)


@pytest.mark.slow
def test_a_million_rows_take_no_more_steps_than_the_signal_does() -> None:
    gravity = Gravity((0.0, 0.0, -G))
    smooth = driven(sine(101, "cubic"), gravity)
    usual = smooth.run(t_end=2.0, rtol=1e-7, atol=1e-9)
    for rows, hold in ((1_000_000, "linear"), (1_000_000, "cubic"), (10_000, "cubic")):
        many = smooth.run(t_end=2.0, rtol=1e-7, atol=1e-9, series={"command": sine(rows, hold)})
        assert many.stats.accepted <= usual.stats.accepted
        exact = driven(sine(101), gravity, text="0.3*sin(2*pi*t) + 0*command").run(t_end=2.0, rtol=1e-11)
        assert many.q[-1, 0] == pytest.approx(exact.q[-1, 0], abs=1e-6)  # ten times rtol · steps · size


def test_a_noisy_table_says_what_it_costs() -> None:
    sim = driven(sine(101))
    with pytest.warns(DesignWarning, match=r"'command' jumps or has a kink at 19998 times .*hold: cubic"):
        result = sim.run(t_end=2.0, series={"command": sine(20_000, noise=0.01)})
    assert result.success
    with pytest.raises(RequestError, match="max_steps is 1000"):
        sim.run(t_end=2.0, series={"command": sine(20_000, noise=0.01)}, max_steps=1000)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        sim.run(t_end=2.0, series={"command": sine(5_000, noise=0.01)})


def test_another_recording_compiles_nothing_and_is_told() -> None:
    a, b = Series(TIMES, VALUES), Series(TIMES[:5], VALUES[:5] * 2, "previous", "hold")
    one, two = driven(a), driven(b)
    assert one.structure == two.structure
    assert one.source_dir == two.source_dir
    given = one.run(t_end=1.1, series={"command": b})
    assert np.array_equal(given.q, two.run(t_end=1.1).q)
    assert given.provenance.series == {"command": b.digest}
    assert one.run(t_end=1.1).provenance.series == {"command": a.digest}
    assert given.provenance.digest == one.run(t_end=1.1).provenance.digest
    held = one.run(t_end=1.1, series={"command": Series.constant(0.2)})
    assert held.q[-1, 0] == pytest.approx(0.2 * 1.1**2 / 2 / ABOUT, rel=1e-12)  # a parabola


@pytest.mark.parametrize("text", ["command", "0.5*command*cos(angle) + 0.01*t"])
def test_an_expression_holds_a_series_as_any_input(text: str) -> None:
    sim = driven(Series(TIMES, VALUES), text=text)
    t = np.array([0.2, 0.5, 1.0])
    angle = np.array([[0.1], [0.4], [-1.0]])
    torque = np.interp(t, TIMES, VALUES)
    expected = torque if text == "command" else 0.5 * torque * np.cos(angle[:, 0]) + 0.01 * t
    # a product or two, and a quotient
    assert sim.acceleration(angle, np.zeros((3, 1)), t)[:, 0] == pytest.approx(expected / ABOUT, rel=1e-14)


def test_an_effect_s_own_input_follows_a_series() -> None:
    series = Series(TIMES, VALUES)
    scene = Scene(effects=(ExternalTorque(("h",)),), inputs={"h.torque": Input(unit="N*m", series=series)})
    sim = lamc.compile(pendulum(), scene)
    assert "h.torque" not in sim.parameters
    assert sim.run(t_end=1.1).q[-1, 0] == pytest.approx(twice_integrated(series, 1.1) / ABOUT, rel=1e-12)
    wrong = Scene(effects=(ExternalTorque(),), inputs={"g.torque": Input(unit="N*m", series=series)})
    with pytest.raises(DesignError, match=r"no effect of the scene has an input 'g\.torque'"):
        lamc.compile(pendulum(), wrong)


def test_a_base_follows_a_cubic_and_its_second_derivative() -> None:
    t = np.linspace(0.0, 1.0, 400)
    values = 0.01 * np.sin(2 * np.pi * 3 * t)
    base = BaseMotion(displacement=("path", 0.0, 0.0))
    gravity = Gravity((0.0, 0.0, -G))
    scene = Scene(
        effects=(gravity, base), inputs={"path": Input(unit="m", series=Series(t, values, "cubic"))}
    )
    sim = lamc.compile(pendulum(), scene)
    spline = CubicSpline(t, values)
    # (I + m l²) θ̈ = m l (ẍ cos θ - g sin θ) for a pivot moved along x by the table, θ about y
    times, state = np.array([0.2, 0.7]), np.array([[0.3, 0.0], [0.9, 0.0]])
    push = M * L * (spline(times, 2) * np.cos(state[:, 0]) - G * np.sin(state[:, 0])) / ABOUT
    # second derivatives of a table with 1/400 s between its rows: round-off of 1e-16 · 400²
    assert sim.acceleration(state[:, :1], state[:, 1:], times)[:, 0] == pytest.approx(push, rel=1e-9)
    told = BaseMotion(displacement=("0.01*sin(2*pi*3*t)", 0.0, 0.0))
    exact = lamc.compile(pendulum(), Scene(effects=(gravity, told))).run(t_end=1.0)
    # not-a-knot splines err by h⁴ of the fourth derivative in value: 1e-7 of the path
    assert sim.run(t_end=1.0).q[-1, 0] == pytest.approx(exact.q[-1, 0], abs=1e-6)


@pytest.mark.parametrize("hold", ["previous", "linear"])
def test_a_base_has_no_acceleration_where_a_table_jumps(hold: str) -> None:
    base = BaseMotion(displacement=("path", 0.0, 0.0))
    with pytest.raises(DesignError, match=r"'path' holds .* needs its acceleration, .*take hold: cubic"):
        Scene(effects=(base,), inputs={"path": Input(unit="m", series=Series(TIMES, VALUES, hold))})
    scene = Scene(effects=(base,), inputs={"path": Input(unit="m", series=Series(TIMES, VALUES, "cubic"))})
    sim = lamc.compile(pendulum(), scene)
    with pytest.raises(RequestError, match="take hold: cubic"):
        sim.run(t_end=1.0, series={"path": Series(TIMES, VALUES, hold)})


def test_a_series_that_does_not_reach_over_the_run_is_refused() -> None:
    sim = driven(Series(TIMES, VALUES))
    with pytest.raises(DesignError, match=r"ends at t = 1.1 s, before the run does at 2 s; .*beyond: hold"):
        sim.run(t_end=2.0)
    with pytest.raises(RequestError, match=r"starts at t = 0.5 s, after the run does at 0 s"):
        sim.run(t_end=1.0, series={"command": Series(TIMES + 0.5, VALUES)})
    with pytest.raises(RequestError, match="no value at t = 3 s"):
        sim.acceleration([0.0], [0.0], 3.0)
    held = sim.run(t_end=2.0, series={"command": Series(TIMES, VALUES, beyond="hold")})
    longer = Series([*TIMES, 2.0], [*VALUES, VALUES[-1]])
    assert held.q[-1, 0] == pytest.approx(twice_integrated(longer, 2.0) / ABOUT, rel=1e-12)
    assert 1.1 in held.t


def test_work_of_a_series_balances_the_energy() -> None:
    sim = driven(Series(TIMES, VALUES, "previous"), Gravity((0.0, 0.0, -G)))
    result = sim.run(t_end=1.1, energy_balance=True)
    plain = sim.run(t_end=1.1)
    assert np.array_equal(result.q, plain.q)
    # I θ̇² / 2 + m g l (1 - cos θ) is the work of the torque, ∫ τ θ̇ dt: as the states, to 1e-9 of it
    q, u = result.q[:, 0], result.u[:, 0]
    stored = ABOUT * u**2 / 2 + M * G * L * (1 - np.cos(q))
    assert np.abs(stored - result.work["torque"]).max() < 1e-8 * stored.max()


@pytest.mark.slow
@pytest.mark.parametrize("hold", ["previous", "linear"])
def test_a_stop_is_struck_within_a_kinked_torque(hold: str) -> None:
    stop, times = 0.4, np.array([0.0, 0.1, 0.2, 1.0])
    series = Series(times, [0.5, 0.5, 0.2, 0.2], hold)
    scene = Scene(
        effects=(Torque({"h": "command"}), JointLimits(restitution=0.5)),
        inputs={"command": Input(unit="N*m", series=series)},
    )
    free = pendulum()
    joint = Joint("h", "ground", "bob", point=[0.0, 0.0, 0.0], axis=[0.0, 1.0, 0.0], limits=(-stop, stop))
    sim = lamc.compile(Mechanism(free.bodies, (joint,)), scene)
    result = sim.run(t_end=0.6)
    times_of = np.linspace(0.0, 0.6, 600_001)
    reached = next(t for t in times_of if twice_integrated(series, t) / ABOUT >= stop)
    assert result.events[0].t == pytest.approx(reached, abs=2e-6)  # the spacing of the times looked at


@pytest.mark.parametrize("hold", ["previous", "linear", "cubic"])
@pytest.mark.parametrize("integrator", ["rk45", "dop853", "auto"])
def test_an_ensemble_follows_as_single_runs_do(hold: str, integrator: str) -> None:
    """Side by side, each at times of its own; rows lie at breaks, beside them and between."""
    sim = driven(Series(TIMES, VALUES, hold), Gravity((0.0, 0.0, -G)), HingeDamping())
    rows = np.unique(np.concatenate([np.linspace(0.0, 1.1, 45), TIMES]))
    parameters = {"bob.mass": M * np.linspace(0.9, 1.1, 11)}
    how = {"t_end": 1.1, "rtol": 1e-8, "integrator": integrator}
    many = sim.ensemble(t_eval=rows, parameters=parameters, **how)
    assert many.stats.lanes in (2, 4, 8)
    assert many.stats.why_alone == ""
    assert_alike(sim, many, parameters, **how)
    with pytest.raises(DesignError, match="before the run does"):
        sim.ensemble(t_end=3.0)


def test_instances_that_follow_reach_what_is_known() -> None:
    sim = driven(Series(TIMES, VALUES), Gravity((0.0, 0.0, -G)), HingeDamping())
    many = sim.ensemble(t_end=1.1, angles={"h": np.array([0.0, 0.1, 0.2])})
    exact = pendulum_by_hand(table("linear"), TIMES, 1.1, 0.2)
    assert many.q[2, -1, 0] == pytest.approx(exact[0], abs=1e-7)  # some hundred steps at 1e-9


@pytest.mark.parametrize("hold", ["previous", "linear", "cubic"])
def test_the_interpreted_program_agrees(hold: str) -> None:
    series = Series(TIMES, VALUES, hold)
    mechanism = chain(3)
    joint = mechanism.joints[0].name
    effects = (Torque({joint: "2*command + 0.1*angle"}), Gravity())
    sim = lamc.compile(mechanism, Scene(effects=effects, inputs={"command": Input(series=series)}))
    voice = Interpreter(sim.program, {"command": series})
    constants = voice.constants()
    for seed, t in enumerate((0.0, 0.05, 0.31, 0.7, 1.1)):
        q, u = random_state(3, seed)
        expected = voice.acceleration(t, q, u, constants)
        # the same operations, but for contraction by the compiler
        assert sim.acceleration(q, u, t) == pytest.approx(expected, rel=1e-11, abs=1e-11)


@pytest.mark.parametrize("rows", [1, 2, 3, 1000])
@pytest.mark.parametrize("even", [True, False])
def test_c_looks_up_what_numpy_does(rows: int, even: bool) -> None:
    rng = np.random.default_rng(rows)
    t = np.linspace(-0.5, 2.0, rows) if even else np.cumsum(rng.exponential(size=rows) ** 4 + 1e-9)
    series = Series(t, rng.standard_normal(rows), "previous", "hold")
    sim = driven(series)
    wanted = np.concatenate([t, np.nextafter(t, -9.0), rng.uniform(t[0] - 1.0, t[-1] + 1.0, 300)])
    got = sim.acceleration(np.zeros((len(wanted), 1)), np.zeros((len(wanted), 1)), wanted)[:, 0] * ABOUT
    place = np.searchsorted(t, wanted, side="right") - 1
    assert got == pytest.approx(series.values[np.maximum(place, 0)], rel=1e-14)  # a quotient and a product


@pytest.mark.parametrize("hold", ["previous", "linear", "cubic"])
@pytest.mark.quick("linear", others="campaign")
def test_all_cross_checks_follow_a_series(hold: str) -> None:
    sim = driven(Series(TIMES, VALUES, hold), Gravity((0.0, 0.0, -G)), text="2*command*cos(angle)")
    assert check(sim, states=5, t_end=1.0).passed


def test_all_cross_checks_follow_a_base_and_torques_from_outside() -> None:
    mechanism = chain(3)
    moved = BaseMotion(displacement=("path", 0.0, "0.5*path"), angle="path")
    scene = Scene(
        effects=(Gravity(), moved, ExternalTorque()),
        inputs={
            "path": Input(unit="m", series=Series(TIMES, 0.1 * VALUES, "cubic")),
            f"{mechanism.joints[1].name}.torque": Input(unit="N*m", series=Series(TIMES, VALUES)),
        },
    )
    report = check(lamc.compile(mechanism, scene), states=5, t_end=1.0)
    assert report.passed
    assert {"Lagrange", "Newton-Euler"} <= {c.cross_checks[1] for c in report.comparisons}


def test_what_a_base_does_along_a_series_is_booked() -> None:
    moved = BaseMotion(displacement=("path", 0.0, 0.0))
    series = Series(TIMES, 0.1 * VALUES, "cubic")
    scene = Scene(effects=(Gravity((0.0, 0.0, -G)), moved), inputs={"path": Input(unit="m", series=series)})
    result = lamc.compile(pendulum(), scene).run(t_end=1.0, energy_balance=True)
    total = result.energy.sum(axis=1) if result.energy.ndim > 1 else result.energy
    # all that the pendulum has gained is the work of its base; as the states, to 1e-9 of it
    assert np.abs(total - total[0] - result.work["base_motion"]).max() < 1e-7 * np.ptp(total)


def test_a_result_goes_to_another_process_with_its_series() -> None:
    sim = driven(Series(TIMES, VALUES))
    result = sim.run(t_end=1.0, series={"command": Series(TIMES, 2.0 * VALUES)})
    again = pickle.loads(pickle.dumps(result))
    assert np.array_equal(
        again.motion.accelerations(result.t, np.hstack([result.q, result.u])),
        result.motion.accelerations(result.t, np.hstack([result.q, result.u])),
    )


def test_an_accuracy_is_reached_with_a_series() -> None:
    sim = driven(Series(TIMES, VALUES), Gravity((0.0, 0.0, -G)))
    result = sim.run(t_end=1.1, accuracy=1e-7)
    exact = pendulum_by_hand(table("linear"), TIMES, 1.1, 0.0)
    assert result.q[-1, 0] == pytest.approx(exact[0], abs=1e-7 * np.ptp(result.q))


@pytest.mark.parametrize("hold", ["previous", "linear"])
@pytest.mark.parametrize("method", ["rk45", "dop853", "radau5"])
def test_derivatives_of_a_run_go_through_jumps(hold: str, method: str) -> None:
    """θ̈ = (k τ(t) cos θ - m g l sin θ) / I: by k, the variational equation by scipy, from knot to knot."""
    series = Series(TIMES, VALUES, hold)
    scene = Scene(
        effects=(Torque({"h": "gain*command*cos(angle)"}), Gravity((0.0, 0.0, -G))),
        inputs={"command": Input(unit="N*m", series=series), "gain": Input(1.5)},
    )
    sim = lamc.compile(pendulum(), scene)
    rows = np.unique(np.concatenate([TIMES, np.linspace(0.0, 1.1, 23)]))
    result = sim.run(
        t_end=1.1, integrator=method, rtol=1e-10, atol=1e-12, sensitivities=["gain"], t_eval=rows
    )
    plain = sim.run(t_end=1.1, integrator=method, rtol=1e-10, atol=1e-12, t_eval=rows)
    assert np.array_equal(result.q, plain.q)
    step = 1e-4
    ahead, behind = (
        sim.run(
            t_end=1.1, rtol=1e-13, atol=1e-15, integrator="dop853", parameters={"gain": 1.5 + d}, t_eval=rows
        )
        for d in (step, -step)
    )
    differences = (ahead.q[:, 0] - behind.q[:, 0]) / (2 * step)
    # differences err by step² / 6 times third derivatives, of order one; both runs by 1e-13 / step
    assert result.sensitivity("h", "gain") == pytest.approx(differences, abs=2e-8)


def test_what_takes_numbers_for_inputs_refuses_a_series() -> None:
    scene = driven(Series(TIMES, VALUES)).scene
    with pytest.raises(UnsupportedError, match="the input 'command' follows a series"):
        measure(pendulum(), scene, lamc.CompileOptions(), lambda _stage: None)


@pytest.mark.parametrize("hold", ["previous", "cubic"])
@pytest.mark.quick("cubic", others="campaign")
def test_loops_follow_a_series(hold: str) -> None:
    made = closed_mechanism("planar", 3)
    mechanism = made.mechanism
    joint = mechanism.joints[0].name
    effects: tuple[object, ...] = (Torque({joint: "command"}), Gravity(), HingeDamping())
    inputs = {"command": Input(unit="N*m", series=Series(TIMES, VALUES, hold))}
    if hold == "cubic":
        effects = (*effects, BaseMotion(displacement=("0.05*path", 0.0, "0.02*sin(path)")))
        inputs["path"] = Input(unit="m", series=Series(TIMES, VALUES[::-1].copy(), "cubic"))
    scene = Scene(effects=effects, inputs=inputs)  # type: ignore[arg-type]
    sim = lamc.compile(mechanism, scene)
    assert check(sim, states=5, t_end=0.5).passed
    runs = [sim.run(t_end=0.5, integrator=each, rtol=1e-10, atol=1e-12) for each in (*EXPLICIT, *IMPLICIT)]
    for run in runs:
        assert run.success
        assert run.q[-1] == pytest.approx(
            runs[0].q[-1], abs=1e-7
        )  # some hundred steps at 1e-10 each, and loops
