"""Derivatives of runs that begin at rest, where errors of states are zero: by the matrix exponential, and statics."""

import numpy as np
import pytest
from scipy.linalg import expm

import lamc
from lamc import examples
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
    assert "steps of radau5 are too long for its derivatives: max_step=0.0021" in note
    run = flaps.run(1.0, **given, max_step=0.0021)
    assert not run.notes
    assert run.sensitivity("left", "angles.left") == pytest.approx(exponential(flaps, TIMES), abs=1e-5)


def test_nothing_is_bounded_where_something_moves(flaps: lamc.Simulator) -> None:
    moving = lamc.compile(
        flaps.mechanism, lamc.Scene(effects=flaps.effects, angles={"left": 0.3, "right": -0.2})
    )
    plain, taped = moving.run(1.0), moving.run(1.0, taped=True)
    assert np.array_equal(plain.t, taped.t)
    assert not moving.run(1.0, sensitivities=["angles.left"], integrator="radau5").notes


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
