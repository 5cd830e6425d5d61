"""Servos in exported C: a command that jumps from outside takes the torque off its limit and on to it at once."""

from pathlib import Path

import numpy as np
import pytest

import lamc
from lamc.export.options import ExportOptions
from lamc.records.scene import Scene
from tests.export.test_export_inputs import INERTIA, flap, inputs_of
from tests.support.ctools import needs_cc
from tests.support.exported import Exported, c_files

STIFFNESS, DAMPING, STALL, SPEED = 0.02, 2e-4, 1e-3, 40.0  # N·m/rad, N·m·s/rad, N·m, rad/s
COMMANDS = (0.3, -0.3, 0.001, 0.2, -0.02)  # rad, 20 ms each


def driven() -> Scene:
    servo = lamc.Servo(
        "h 1", "goal", STIFFNESS, DAMPING, stall_torque=STALL, no_load_speed=SPEED, dead_band=0.005
    )
    return Scene(effects=(servo,), inputs={"goal": lamc.Input(unit="rad")})


def by_steps() -> np.ndarray:
    """Angle and rate at the end, by the classical Runge-Kutta method in steps of 10 µs."""

    def slope(y: np.ndarray, command: float) -> np.ndarray:
        error = command - y[0]
        error = max(error - 0.005, 0.0) + min(error + 0.005, 0.0)
        lost = STALL * y[1] / SPEED
        torque = min(max(STIFFNESS * error - DAMPING * y[1], -STALL - lost), STALL - lost)
        return np.array([y[1], torque / INERTIA])

    y, h = np.zeros(2), 1e-5
    for command in COMMANDS:
        for _ in range(2000):
            a = slope(y, command)
            b = slope(y + 0.5 * h * a, command)
            c = slope(y + 0.5 * h * b, command)
            y = y + h / 6 * (a + 2 * b + 2 * c + slope(y + h * c, command))
    return y


@pytest.mark.slow
@needs_cc
def test_a_command_that_jumps_acts_at_once(tmp_path: Path) -> None:
    """Also where the caller stands short of where the integrator went, and a run begins with the modes of its start."""
    exported = Exported(c_files(flap(scene=driven())), tmp_path)
    it = exported.instance(rtol=1e-10, atol=1e-12)
    for k, command in enumerate(COMMANDS):
        assert exported.call("set_inputs", it, inputs_of(exported, goal=command)) == 0
        for part in (0.37, 1.0):
            assert exported.call("step", it, 0.02 * (k + part)) == 0
    expected = by_steps()
    assert it.q[0] == pytest.approx(
        expected[0], abs=1e-7
    )  # kinks within steps of the method above, h² times 50/s²
    assert it.u[0] == pytest.approx(expected[1], abs=1e-5)


@needs_cc
@pytest.mark.parametrize("precision", ["double", "float"])
def test_steps_of_fixed_length_meet_the_limits_too(precision: str, tmp_path: Path) -> None:
    """Corners are met at the ends of steps: of the first order in the step."""
    options = ExportOptions(real_time=True, precision=precision, libm=precision == "double")
    exported = Exported(c_files(flap(scene=driven()), options=options), tmp_path)
    it = exported.instance()
    for command in COMMANDS:
        assert exported.call("set_inputs", it, inputs_of(exported, goal=command)) == 0
        for _ in range(400):
            assert exported.call("step_fixed", it, 5e-5) == 0
    expected = by_steps()
    assert it.q[0] == pytest.approx(expected[0], abs=1e-3)  # 50 rad/s² over 5e-5 s, at some twenty corners
    assert it.u[0] == pytest.approx(expected[1], abs=5e-2)
