"""Derivatives of runs that keep an energy balance, are made to an accuracy, pull loops together, or are scipy's."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import lamc
from lamc.records.mechanism import Mechanism
from tests.physics.test_sensitivities import EXACT, PLACES, WEIGHTS, Array, example, oscillator, states
from tests.support.mechanisms import chain

# As in test_sensitivities: runs at 1e-13 and differences of order 6 over 1e-3 of a number
CLOSE = 1e-8


def differences(sim: lamc.Simulator, name: str, times: Array, **asked: Any) -> Array:
    """d state / d parameter by runs at 1e-13, (m, nq + nu), of order 6."""
    value, total = sim.parameters[name], np.zeros((len(times), sim.start.size))
    tight = {"t_end": float(times[-1]), "rtol": 1e-13, "atol": 1e-15, "t_eval": times, **asked}
    for place, weight in zip(PLACES, WEIGHTS, strict=True):
        run = sim.run(**tight, parameters={name: value * (1.0 + 1e-3 * place)})
        total += weight / (1e-3 * value) * states(run)
    return total


def check(
    device: lamc.Design | Mechanism, names: Sequence[str], t_end: float, asked: Any, also: Any = None
) -> lamc.Result:
    """The run keeps its bits, and its derivatives are those of differences. also: what the latter are asked for."""
    sim, times = lamc.compile(device), np.linspace(0.0, t_end, 11)
    asked = {"t_end": t_end, "t_eval": times, **({} if "accuracy" in asked else EXACT), **asked}
    plain, found = sim.run(**asked), sim.run(**asked, sensitivities=names)
    assert np.array_equal(states(plain), states(found))
    assert found.sensitivities is not None
    assert found.sensitivities.lost is None
    for k, name in enumerate(names):
        expected = differences(sim, name, times, **(also or {}))
        error = np.abs(found.sensitivities.values[:, :, k] - expected).max()
        assert error <= CLOSE * np.abs(expected).max(), name
    return found


def test_beside_an_energy_balance() -> None:
    found = check(example("four_bar"), ["link.stiffness"], 0.3, {"energy_balance": True})
    # The balance of a run at 1e-12 closes to some 1e-12 of what was moved
    assert np.abs(found.energy_balance.residual).max() <= 1e-10 * found.energy_balance.scale
    sim = lamc.compile(example("four_bar"))
    alone = sim.run(t_end=0.3, t_eval=found.t, **EXACT, energy_balance=True)
    assert all(np.array_equal(found.work[name], alone.work[name]) for name in alone.work)


def test_of_a_run_to_an_accuracy() -> None:
    found = check(example("four_bar"), ["link.stiffness"], 0.3, {"accuracy": 1e-9})
    assert found.accuracy is not None
    assert found.accuracy.reached


def test_with_baumgartes_stabilisation() -> None:
    """The loops drift, and the derivatives with them: the terms that pull them together count."""
    rate = {"baumgarte": 20.0}
    check(example("four_bar"), ["link.stiffness", "link.mass"], 0.3, rate, also=rate)


@pytest.mark.quick("DOP853")
@pytest.mark.parametrize("method", ["DOP853", "LSODA"])
def test_by_an_integrator_of_scipy(method: str) -> None:
    check(chain(3), ["body1.mass"], 0.2, {"integrator": f"scipy:{method}"})


def saturating() -> Mechanism:
    servo = lamc.Servo(
        joint="h", command=1.0, stiffness=2.0, damping=0.02, stall_torque=0.3, no_load_speed=20.0
    )
    return replace(oscillator(), scene=lamc.Scene(effects=(servo,), angles={"h": 0.1}))


def test_switches_within_a_step_of_scipy_count() -> None:
    found = check(saturating(), ["h.servo.stiffness", "link.mass"], 0.3, {"integrator": "scipy:DOP853"})
    assert not found.events  # scipy goes over them


def test_a_switch_between_two_steps_of_scipy_ends_derivatives(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where the modes of guards are others than those that the step before ended with, a jump was missed."""
    from lamc.run import native

    whole = native.integrate

    def forgetful(*given: Any) -> Any:
        used, found = whole(*given)
        return used, replace(found, modes=(found.modes[0], tuple(1.0 - mode for mode in found.modes[1])))

    monkeypatch.setattr(native, "integrate", forgetful)
    sim = lamc.compile(saturating())
    found = sim.run(t_end=0.1, integrator="scipy:DOP853", sensitivities=["link.mass"])
    assert found.sensitivities is not None
    assert found.sensitivities.lost is not None
    assert "between two steps" in found.sensitivities.lost.reason
    assert np.isnan(found.sensitivities.values[-1]).all()
    assert any("no derivative" in note for note in found.notes)


def test_a_cancelled_run_tells_where_derivatives_end() -> None:
    def stop(_t: float, _end: float) -> None:
        raise KeyboardInterrupt

    sim = lamc.compile(example("four_bar"))
    found = sim.run(t_end=30.0, energy_balance=True, sensitivities=["link.stiffness"], progress=stop)
    assert found.status == -4
    assert found.sensitivities is not None
    assert found.sensitivities.lost is not None
    assert "cancelled" in found.sensitivities.lost.reason
    assert np.isnan(found.sensitivities.values).all()


def test_what_scipy_cannot_do_is_refused_with_derivatives_too() -> None:
    free = oscillator()
    stopped = replace(free, joints=(replace(free.joints[0], limits=(-1.0, 0.5)),))
    sim = lamc.compile(stopped, lamc.Scene(effects=(lamc.JointLimits(restitution=0.5),)))
    with pytest.raises(lamc.RequestError, match="finds no impacts"):
        sim.run(t_end=0.1, integrator="scipy:LSODA", sensitivities=["link.mass"])
