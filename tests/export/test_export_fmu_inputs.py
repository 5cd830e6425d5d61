"""Inputs of FMUs: torques on hinges and what a scene names, held from one communication point to the next."""

import zipfile
from pathlib import Path

import numpy as np
import pytest

import lamc
from lamc.effects import ExternalTorque, Gravity, HingeStiffness, Torque
from lamc.records.mechanism import Mechanism
from lamc.records.scene import Scene
from tests.support.ctools import needs_cc
from tests.support.fmus import VERSIONS, Fmu, need_fmpy, written
from tests.support.mechanisms import chain

pytestmark = needs_cc


@pytest.fixture(scope="module")
def opened(tmp_path_factory: pytest.TempPathFactory):
    """opened(simulator, fmi) -> file and unzipped folder of its FMU."""

    def open_(simulator, fmi: int) -> tuple[Path, Path]:
        file = written(simulator, fmi, tmp_path_factory.mktemp("inputs"))
        with zipfile.ZipFile(file) as archive:
            archive.extractall(file.with_suffix(""))
        return file, file.with_suffix("")

    return open_


def wheel() -> tuple[Mechanism, float]:
    """One body on one hinge, and its moment of inertia about it, kg·m²."""
    mechanism = chain(1, "parallel", seed=2)
    (joint,) = mechanism.joints
    body = next(b for b in mechanism.bodies if not b.fixed)
    axis = np.array(joint.axis) / np.linalg.norm(joint.axis)
    arm = np.array(body.com) - np.array(joint.point)
    across = np.cross(axis, arm)
    return mechanism, float(axis @ np.array(body.inertia) @ axis + body.mass * across @ across)


@pytest.mark.parametrize("fmi", VERSIONS)
@pytest.mark.quick("3")
def test_a_torque_in_steps_turns_a_wheel_by_parabolas(opened, fmi):
    mechanism, inertia = wheel()
    joint = mechanism.joints[0]
    simulator = lamc.compile(mechanism, Scene(effects=(ExternalTorque(),)))
    _, folder = opened(simulator, fmi)
    name = f"{joint.name}.torque"
    fmu = Fmu(folder).begin(stop=1.0)
    angle = rate = t = 0.0
    for k, torque in enumerate((0.3, -0.7, 0.0, 1.1)):
        fmu.put({name: torque})
        assert fmu.get(f"der({joint.name}.rate)") == pytest.approx([torque / inertia], rel=1e-13)
        fmu.step(t, 0.25)
        angle += rate * 0.25 + torque / inertia * 0.25**2 / 2
        rate += torque / inertia * 0.25
        t = 0.25 * (k + 1)
        # Runge-Kutta is exact for parabolas, but for round-off
        reported = fmu.get(f"{joint.name}.angle", f"{joint.name}.rate")
        assert reported == pytest.approx([angle, rate], abs=1e-13)
    reported = fmu.derivative([f"der({joint.name}.rate)"], [name], [2.0])
    assert reported == pytest.approx([2.0 / inertia], rel=1e-9)  # a difference over 6e-6 of what is linear
    fmu.free()


@pytest.mark.parametrize("fmi", VERSIONS)
@pytest.mark.quick("3", others="campaign")
def test_a_held_input_is_the_parameter_of_a_run(opened, fmi):
    """Named inputs in an expression and torques on hinges, given before initialisation, to the last bit."""
    mechanism = chain(2, "space", seed=4)
    a, b = (joint.name for joint in mechanism.joints)
    scene = Scene(
        effects=(
            Gravity((0.0, 0.0, -9.81)),
            HingeStiffness(),
            ExternalTorque((a,)),
            Torque({b: "drive*sin(5*t)"}),
        ),
        inputs={"drive": lamc.Input(default=0.1, unit="N*m", meaning="amplitude")},
    )
    simulator = lamc.compile(mechanism, scene)
    _, folder = opened(simulator, fmi)
    fmu = Fmu(folder)
    inputs = {v.name: v for v in fmu.by_name.values() if v.causality == "input"}
    assert {(v.name, v.unit, float(v.start)) for v in inputs.values()} == {
        (f"{a}.torque", "N.m", 0.0),
        ("drive", "N.m", 0.1),
    }
    given = {f"{a}.torque": 0.4, "drive": -0.2}
    fmu.put(given)
    times = np.linspace(0.0, 1.0, 11)
    rows = fmu.begin(stop=1.0).walk(times, f"{a}.angle", f"{b}.angle")
    assert np.array_equal(rows, simulator.run(1.0, t_eval=times, parameters=given).q)
    fmu.fmu.reset()
    rows = fmu.begin(stop=1.0).walk(times, f"{a}.angle", f"{b}.angle")
    assert np.array_equal(rows, simulator.run(1.0, t_eval=times).q)
    with fmu.refusing(f"{a}.torque", "finite"):
        fmu.put({f"{a}.torque": float("nan")})
    fmu.free()


@pytest.mark.parametrize("fmi", VERSIONS)
@pytest.mark.slow
def test_an_input_changed_on_the_way_is_in_a_saved_state(opened, fmi):
    mechanism = chain(2, "space", seed=4)
    a, _ = (joint.name for joint in mechanism.joints)
    simulator = lamc.compile(mechanism, Scene(effects=(Gravity((0.0, 0.0, -9.81)), ExternalTorque())))
    _, folder = opened(simulator, fmi)
    fmu = Fmu(folder).begin(stop=1.0)
    fmu.step(0.0, 0.2)
    fmu.put({f"{a}.torque": 0.5})
    state = fmu.fmu.getFMUState()  # set, but not yet stepped with
    fmu.step(0.2, 0.3)
    expected = fmu.all_values()
    fmu.put({f"{a}.torque": -0.5})
    fmu.step(0.5, 0.1)
    fmu.fmu.setFMUState(state)
    assert fmu.get(f"{a}.torque") == [0.5]
    fmu.step(0.2, 0.3)
    assert fmu.all_values() == expected
    fmu.fmu.freeFMUState(state)
    fmu.free()


@pytest.mark.parametrize("fmi", VERSIONS)
@pytest.mark.quick("3")
def test_fmpy_feeds_a_signal(opened, fmi):
    """A torque that holds a body against gravity: the body stays where it starts."""
    mechanism, _ = wheel()
    (joint,) = mechanism.joints
    scene = Scene(effects=(Gravity((0.0, 0.0, -9.81)), ExternalTorque()))
    # The torque of gravity about the axis, as drawn; positive on the child.
    body = next(b for b in mechanism.bodies if not b.fixed)
    axis = np.array(joint.axis) / np.linalg.norm(joint.axis)
    weight = body.mass * np.array([0.0, 0.0, -9.81])
    moment = float(axis @ np.cross(np.array(body.com) - np.array(joint.point), weight))
    sign = 1.0 if joint.child == body.name else -1.0
    assert abs(moment) > 0.1
    file, _ = opened(lamc.compile(mechanism, scene), fmi)
    name = f"{joint.name}.torque"
    signal = np.array([(0.0, -sign * moment), (0.5, -sign * moment)], dtype=[("time", float), (name, float)])
    rows = need_fmpy().simulate_fmu(str(file), stop_time=0.5, input=signal, output=[f"{joint.name}.angle"])
    # balanced to round-off, 1e-16 of 10 N·m on 1 kg·m², for half a second
    assert np.abs(rows[f"{joint.name}.angle"]).max() < 1e-14
