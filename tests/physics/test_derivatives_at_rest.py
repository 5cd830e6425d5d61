"""Derivatives of what stands still, whose error bounds no step: by the matrix exponential, statics and short steps."""

import numpy as np
import pytest
from scipy.linalg import expm

import lamc
from lamc import examples
from lamc.run.request import Status
from tests.support.ctools import needs_cc
from tests.support.mechanisms import chain

pytestmark = needs_cc

TIMES = np.linspace(0.0, 1.0, 6)


@pytest.fixture(scope="module")
def flaps() -> lamc.Simulator:
    path = examples.path("flaps")
    return lamc.compile(lamc.load(path), lamc.Scene(effects=(lamc.HingeStiffness(), lamc.HingeDamping())))


def exponential(sim: lamc.Simulator, times: np.ndarray) -> np.ndarray:
    """The angle of `left` by its start, about the balance in which all angles are zero."""
    model = sim.linearise(sim.equilibrium(), inputs=[])
    k = model.states.index("left")
    return np.array([expm(model.A * t)[k, k] for t in times])


@pytest.mark.parametrize("method", ["auto", "dop853", "rk45"])
@pytest.mark.parametrize("count", [6, 401])
def test_rows_within_long_steps_have_their_derivatives(
    flaps: lamc.Simulator, method: str, count: int
) -> None:
    """They were 1e16, and those at ends of steps right. Steps of their own hold the error to a millionth each."""
    times = np.linspace(0.0, 1.0, count)
    run = flaps.run(1.0, t_eval=times, sensitivities=["angles.left"], integrator=method)
    assert run.stats.accepted < 12
    assert run.sensitivity("left", "angles.left") == pytest.approx(exponential(flaps, times), abs=2e-6)
    assert not run.notes


def test_a_tape_has_steps_that_are_short_enough(flaps: lamc.Simulator) -> None:
    run = flaps.run(1.0, taped=True)
    found = run.gradient("left[-1]", ["angles.left"])["angles.left"]
    assert found == pytest.approx(exponential(flaps, TIMES)[-1], rel=1e-7)  # of 470 steps, 5e-11 each


def test_what_an_implicit_method_makes_of_long_steps_is_told(flaps: lamc.Simulator) -> None:
    given = {"t_eval": TIMES, "sensitivities": ["angles.left"], "integrator": "radau5"}
    (note,) = flaps.run(1.0, **given).notes
    assert "steps of radau5 are too long for derivatives of modes that do not move here" in note
    assert note.endswith("max_step=0.0021 does")
    run = flaps.run(1.0, **given, max_step=0.0021)
    assert not run.notes
    assert run.sensitivity("left", "angles.left") == pytest.approx(exponential(flaps, TIMES), abs=1e-5)


def test_nothing_is_bounded_where_all_modes_move(flaps: lamc.Simulator) -> None:
    moving = lamc.compile(
        flaps.mechanism, lamc.Scene(effects=flaps.effects, angles={"left": 0.3, "right": -0.2})
    )
    plain, taped = moving.run(1.0), moving.run(1.0, taped=True)
    assert np.array_equal(plain.t, taped.t)
    assert not moving.run(1.0, sensitivities=["angles.left"], integrator="radau5").notes


AXIS = np.array([0.0, 0.0, 1.0])


def pair(
    stiffness: float, damping: float = 0.01, limits: tuple[float, float] | None = None
) -> lamc.Mechanism:
    """Two bodies of 0.35 kg·m² about hinges that have nothing to do with each other."""
    bodies = [lamc.Body(name, 1.0, np.array([0.5, 0.0, 0.0]), np.diag([0.01, 0.1, 0.1])) for name in "ab"]
    slow = {"limits": limits} if limits else {"stiffness": 1.0}
    return lamc.Mechanism(
        name="pair",
        bodies=(lamc.Body("ground", fixed=True), *bodies),
        joints=(
            lamc.Joint("slow", "ground", "a", point=np.zeros(3), axis=AXIS, **slow),
            lamc.Joint(
                "fast", "ground", "b", point=np.zeros(3), axis=AXIS, stiffness=stiffness, damping=damping
            ),
        ),
    )


@pytest.mark.parametrize("start", [0.0, 1e-12, 1e-6, 0.1])
def test_a_mode_that_stands_still_beside_one_that_moves(start: float) -> None:
    """Its gradient was 1e104, of some ten steps that are long for it."""
    end, stiffness, damping, inertia = 1.2, 1e5, 0.01, 0.35
    scene = lamc.Scene(effects=(lamc.HingeStiffness(), lamc.HingeDamping()), angles={"slow": start})
    sim = lamc.compile(pair(stiffness, damping), scene)
    expected = expm(end * np.array([[0.0, 1.0], [-stiffness / inertia, -damping / inertia]]))[0, 0]
    taped = sim.run(end, taped=True).gradient("fast[-1]", ["angles.fast"])["angles.fast"]
    assert taped == pytest.approx(expected, abs=1e-6)  # of 2100 steps, 5e-11 each, and of 640 turns
    along = sim.run(end, sensitivities=["angles.fast"]).sensitivity("fast", "angles.fast")[-1]
    assert along == pytest.approx(expected, abs=1e-6)


def test_a_drive_that_is_zero_at_the_start_and_damped_modes_ask_for_no_shorter_steps() -> None:
    """A run of 179 steps had come to its end at a million, as nothing moves at its begin and one mode is fast."""
    end = 2.0
    mechanism = pair(1.0, 1e5)
    scene = lamc.Scene(
        effects=(lamc.HingeStiffness(), lamc.HingeDamping(), lamc.Torque({"fast": "0.05*sin(2*pi*t)"}))
    )
    sim = lamc.compile(mechanism, scene)
    for method in ("auto", "radau5"):
        taped = sim.run(end, taped=True, integrator=method)
        assert taped.success
        assert taped.stats.accepted < 2000
        along = sim.run(end, sensitivities=["fast.stiffness"], integrator=method)
        assert not along.notes
        expected = along.sensitivity("fast", "fast.stiffness")[-1]
        found = taped.gradient("fast[-1]", ["fast.stiffness"])["fast.stiffness"]
        assert found == pytest.approx(expected, rel=1e-6, abs=1e-12)


@pytest.mark.parametrize("method", ["dop853", "rk45"])
def test_rows_before_an_event_at_the_end_of_a_long_step_know_nothing_of_it(method: str) -> None:
    """The stop of one hinge acted before it was met, in rows within a step that is long for the other."""
    scene = lamc.Scene(
        effects=(
            lamc.HingeStiffness(),
            lamc.HingeDamping(),
            lamc.JointLimits(),
            lamc.Torque({"slow": 0.5}),
        )
    )
    sim = lamc.compile(pair(1e5, limits=(-0.3, 0.3)), scene)
    times = np.array([0.0, 0.2, 0.4, 0.6, 0.63, 0.648, 0.7])
    run = sim.run(0.7, t_eval=times, sensitivities=["angles.slow", "angles.fast"], integrator=method)
    short = sim.run(
        0.7, t_eval=times, sensitivities=["angles.slow", "angles.fast"], integrator=method, max_step=1e-3
    )
    assert 0.648 < run.events[0].t < 0.7
    assert run.sensitivity("slow", "angles.slow")[:-1] == pytest.approx(np.ones(6), abs=1e-9)
    for name in ("slow", "fast"):
        expected = short.sensitivity(name, "angles.slow")
        assert run.sensitivity(name, "angles.slow") == pytest.approx(
            expected, abs=2e-5
        )  # of short steps of rk45


def test_a_balance_under_gravity_moves_with_its_stiffness() -> None:
    """Long afterwards, of a damped hinge: by the balances beside."""
    sim = lamc.compile(
        chain(1), lamc.Scene(effects=(lamc.Gravity(), lamc.HingeStiffness(), lamc.HingeDamping()))
    )
    point = sim.equilibrium()
    q, k = point.angles["h0"], sim.parameters["h0.stiffness"]
    at_rest = lamc.compile(sim.mechanism, lamc.Scene(effects=sim.effects, angles={"h0": q}))
    step = 1e-4 * k
    beside = [sim.equilibrium(parameters={"h0.stiffness": k + d}).angles["h0"] for d in (step, -step)]
    expected = (beside[0] - beside[1]) / (2 * step)  # to step² of the third derivative, some 1e-8
    end = 40.0
    run = at_rest.run(end, t_eval=np.linspace(0.0, end, 5), sensitivities=["h0.stiffness"])
    assert run.sensitivity("h0", "h0.stiffness")[-1] == pytest.approx(expected, rel=1e-5)
    taped = at_rest.run(end, taped=True, max_steps=2_000_000)
    assert taped.gradient("h0[-1]", ["h0.stiffness"])["h0.stiffness"] == pytest.approx(expected, rel=1e-5)


@pytest.fixture(scope="module")
def beside() -> lamc.Simulator:
    """A fast hinge at rest beside a slow one that moves."""
    scene = lamc.Scene(effects=(lamc.HingeStiffness(), lamc.HingeDamping()), angles={"slow": 0.1})
    return lamc.compile(pair(1e5), scene)


@pytest.mark.parametrize("rows", [[1.2], [1.199, 1.2], [0.0, 0.6, 1.2], None])
def test_steps_are_seen_whatever_rows_are_asked_for(beside: lamc.Simulator, rows: list[float] | None) -> None:
    taped = beside.run(1.2, taped=True, t_eval=rows)
    found = taped.gradient("fast[-1]", ["angles.fast"])["angles.fast"]
    assert found == pytest.approx(0.8420914, abs=1e-6)


def test_a_run_that_is_cancelled_is_not_made_again(beside: lamc.Simulator) -> None:
    calls: list[float] = []

    def stop(t: float, _: float) -> None:
        calls.append(t)
        raise KeyboardInterrupt

    taped = beside.run(200.0, taped=True, progress=stop)
    assert taped.status == Status.CANCELLED
    assert len(calls) == 1


def test_a_run_that_may_take_no_more_steps_stays_as_it_was_with_a_warning(beside: lamc.Simulator) -> None:
    with pytest.warns(
        lamc.DesignWarning, match=r"too long for derivatives of modes that do not move here.*max_step="
    ):
        taped = beside.run(1.2, taped=True, max_steps=100)
    assert taped.success
    assert taped.stats.accepted == 9


def test_motion_that_comes_to_rest_is_not_made_again() -> None:
    """Each mode has moved: the error of the state has bounded steps by it, and its derivatives have decayed too."""
    mechanism = pair(30.0, 3.0)
    scene = lamc.Scene(
        effects=(lamc.HingeStiffness(), lamc.HingeDamping()), angles={"slow": 0.5, "fast": 0.3}
    )
    sim = lamc.compile(mechanism, scene)
    for method in ("auto", "dop853", "radau5"):
        plain, taped = sim.run(300.0, integrator=method), sim.run(300.0, taped=True, integrator=method)
        assert taped.stats.accepted == plain.stats.accepted
