"""What acts on exported C from outside, by closed forms: a body that only torques move has θ'' = torque / inertia."""

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from lamc import Body, ExportError, ExternalTorque, Input, Joint, JointLimits, Mechanism, Scene, Torque
from lamc.export.options import ExportOptions
from tests.support.ctools import needs_cc
from tests.support.exported import Exported, c_files

INERTIA = 2e-5  # kg·m²


def flap(scene: Scene | None = None, **joint: Any) -> Mechanism:
    """One body about its own centre."""
    wall = Body("wall", fixed=True)
    body = Body("flap", 0.01, (0.0, 0.0, 0.0), np.diag([INERTIA] * 3))
    hinge = Joint("h 1", "wall", "flap", axis=(0.0, 0.0, 1.0), **joint)
    return Mechanism((wall, body), (hinge,), name="flap", scene=scene)


def inputs_of(exported: Exported, **values: float) -> Any:
    inputs = exported.new("inputs")
    exported.call("default_inputs", inputs)
    for name, value in values.items():
        setattr(inputs, name, value)
    return inputs


@pytest.fixture(scope="module")
def exported(tmp_path_factory: pytest.TempPathFactory) -> Exported:
    return Exported(c_files(flap()), tmp_path_factory.mktemp("flap"))


@needs_cc
def test_a_torque_acts_from_where_it_is_set_until_it_is_changed(exported: Exported) -> None:
    """Every millisecond another torque, and targets between. The integrator is exact for a constant one, so only
    round-off of some hundred steps remains."""
    it = exported.instance()
    theta, omega = 0.0, 0.0
    for k in range(100):
        torque = 1e-3 * math.sin(0.3 * k)
        assert exported.call("set_inputs", it, inputs_of(exported, h_1_torque=torque)) == 0
        for part in (0.25, 1.0):
            assert exported.call("step", it, 1e-3 * (k + part)) == 0
        theta += 1e-3 * omega + 0.5e-6 * torque / INERTIA
        omega += 1e-3 * torque / INERTIA
        assert it.q[0] == pytest.approx(theta, rel=1e-12, abs=1e-14)
        assert it.u[0] == pytest.approx(omega, rel=1e-12, abs=1e-12)


@needs_cc
def test_a_torque_set_after_the_integrator_ran_ahead(exported: Exported) -> None:
    """Steps of a body at rest grow long; the change must act at the caller's time, not at the end of such a step."""
    it = exported.instance()
    assert exported.call("step", it, 0.1) == 0
    assert exported.call("set_inputs", it, inputs_of(exported, h_1_torque=1e-3)) == 0
    assert exported.call("step", it, 0.2) == 0
    assert it.q[0] == pytest.approx(0.5 * 1e-3 / INERTIA * 0.1**2, rel=1e-12)


@needs_cc
def test_what_is_set_already_leaves_the_run_alone(tmp_path: Path) -> None:
    """A controller that says the same every millisecond: every byte is that of a run that was reported once."""
    stops = Scene(effects=(JointLimits(stiffness=1.0, damping=1e-5),))  # it bounces on the upper one
    exported = Exported(c_files(flap(limits=(-0.2, 0.2)), scene=stops), tmp_path)
    parameters = exported.new("parameters")
    exported.call("default_parameters", parameters)
    inputs = inputs_of(exported, h_1_torque=1e-3)
    told_once, told_often = exported.instance(t_stop=0.5), exported.instance(t_stop=0.5)
    assert exported.call("set_inputs", told_once, inputs) == 0
    for k in range(1, 501):
        assert exported.call("set_inputs", told_often, inputs) == 0
        assert exported.call("set_parameters", told_often, parameters) == 0
        assert exported.call("step", told_once, 1e-3 * k) == exported.call("step", told_often, 1e-3 * k) == 0
        assert bytes(exported.ffi.buffer(told_once)) == bytes(exported.ffi.buffer(told_often))
    assert told_once.u[0] < 1.0  # rad/s: 25 but for the stop


@needs_cc
def test_derivatives_by_inputs(exported: Exported) -> None:
    """Differences of what is linear in the torque: round-off over a step of 6e-6."""
    ffi, it = exported.ffi, exported.instance()
    by_q, by_u, by_inputs = (ffi.new("double[1]") for _ in range(3))
    assert exported.call("jacobian", it, by_q, by_u, by_inputs) == 0
    assert by_inputs[0] == pytest.approx(1.0 / INERTIA, rel=1e-9)
    assert (by_q[0], by_u[0]) == (0.0, 0.0)
    assert ffi.string(exported.call("input_name", 0)) == b"h 1.torque"
    assert ffi.string(exported.call("input_unit", 0)).decode() == "N·m"


@needs_cc
def test_an_input_that_is_no_number_changes_nothing(exported: Exported) -> None:
    it = exported.instance()
    before = bytes(exported.ffi.buffer(it))
    for value in (math.nan, math.inf):
        status = exported.call("set_inputs", it, inputs_of(exported, h_1_torque=value))
        assert status == exported.status("BAD_INPUT")
    assert bytes(exported.ffi.buffer(it)) == before


@needs_cc
@pytest.mark.slow
def test_named_inputs_of_a_scene(tmp_path: Path) -> None:
    """torque = -gain θ: an oscillator whose frequency is an input."""
    gain = Input(default=INERTIA, unit="N*m/rad", meaning="of the controller")
    scene = Scene(effects=(Torque({"h 1": "-gain*angle"}),), inputs={"gain": gain}, angles={"h 1": 1.0})
    exported = Exported(c_files(flap(scene), options=ExportOptions(inputs="none")), tmp_path)
    it = exported.instance()
    assert exported.constant("input_count") == 1
    assert exported.call("step", it, math.pi / 2) == 0
    assert it.q[0] == pytest.approx(0.0, abs=1e-7)  # a tolerance of 1e-9 over a hundred steps
    assert exported.call("set_inputs", it, inputs_of(exported, gain=4.0 * INERTIA)) == 0
    assert exported.call("step", it, math.pi) == 0  # half a period of the faster one: from (0, -1) to (0, 1)
    assert it.q[0] == pytest.approx(0.0, abs=1e-7)
    assert it.u[0] == pytest.approx(1.0, abs=1e-7)


def header(mechanism: Mechanism, scene: Scene | None = None, **options: Any) -> str:
    files = c_files(mechanism, scene=scene, options=ExportOptions(**options))
    return next(text for name, text in files.items() if name.endswith(".h")).decode()


@needs_cc
@pytest.mark.slow
def test_who_says_which_hinges_take_torques() -> None:
    said = Scene(effects=(ExternalTorque(("h 1",)),))
    assert "h_1_torque" in header(flap())
    assert "h_1_torque" in header(flap(), inputs=("h 1",))
    assert "h_1_torque" not in header(flap(), inputs="none")
    assert "h_1_torque" not in header(flap(), inputs=())
    assert "h_1_torque" in header(flap(), said)
    with pytest.raises(ExportError, match=r"--inputs \(inputs\).*external_torque"):
        header(flap(), said, inputs="none")


def test_a_hinge_that_is_not_there_is_named() -> None:
    with pytest.raises(ExportError, match=r"'h2', which is not there; .*there are h 1"):
        c_files(flap(), options=ExportOptions(inputs=("h2",)))
