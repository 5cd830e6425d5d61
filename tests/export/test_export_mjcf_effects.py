"""Effects in MJCF, by the word of MuJoCo and by closed forms: stops, torques, the ground, and what is lost."""

import runpy
from pathlib import Path

import numpy as np
import pytest
from shapely.geometry import box

import lamc
from lamc.basics.errors import UnsupportedError
from lamc.examples import path
from lamc.export import mjcf
from lamc.export.options import ExportOptions
from lamc.records.mechanism import Body, Joint, Mechanism, Slab
from tests.support.engines import InMujoco, end_errors, mujoco
from tests.support.every_effect import SAMPLES
from tests.support.every_effect import mechanism as two_links

MAPPED = {
    "external_torque",
    "free_base",
    "gravity",
    "ground_contact",
    "hinge_damping",
    "hinge_stiffness",
    "joint_limits",
    "rest_angle",
    "spring",
    "torque",
}


def test_a_joint_beyond_its_limit_feels_the_spring_and_damper_of_its_stop(tmp_path: Path) -> None:
    limits = lamc.JointLimits(stiffness=300.0, damping=2.0)
    scene = lamc.Scene(effects=(lamc.Gravity(), lamc.HingeStiffness(), limits))
    simulator = lamc.compile(two_links(), scene)
    engine = InMujoco(two_links(), scene, tmp_path)
    engine.put(simulator, np.array([1.25, -1.1]), np.array([0.5, -0.2]))  # limits are -1 and 1.2 rad
    mujoco.mj_forward(engine.model, engine.data)
    expected = np.array([-(300.0 * 0.05 + 2.0 * 0.5), 300.0 * 0.1 + 2.0 * 0.2])
    # 1e-4, MuJoCo's smallest impedance, of the other torques, and A is not as drawn: 1e-3 holds both
    assert np.abs(engine.data.qfrc_constraint / expected - 1.0).max() < 1e-3


def test_undamped_stops_return_a_swing_as_in_lamc(tmp_path: Path) -> None:
    effects = (lamc.Gravity(), lamc.HingeStiffness(), lamc.JointLimits(stiffness=300.0))
    scene = lamc.Scene(effects=effects, angles={"h1": 0.9, "h2": 0.5})
    (error,) = end_errors(two_links(), scene, tmp_path, 0.8, (2.5e-4,))
    # 1e-4 of the swing, for the impedance; h1 meets its stop at 0.30 and leaves it before 0.5 s
    assert error < 1e-4


def test_a_torque_in_time_acts_by_the_control_callback_beside_the_model(tmp_path: Path) -> None:
    effects = (lamc.Gravity(), lamc.Torque({"h1": "3*sin(5*t) - rate*rate", "h2": 0.2}))
    scene = lamc.Scene(effects=effects)
    simulator = lamc.compile(two_links(), scene)
    result = simulator.run(0.5, rtol=1e-12, atol=1e-14, t_eval=[0.0, 0.5])
    engine = InMujoco(two_links(), scene, tmp_path)
    assert "3\\*sin(5\\*t) - rate\\*rate" in engine.readme
    mujoco.set_mjcb_control(runpy.run_path(str(tmp_path / "torques.py"))["control"])
    try:
        engine.end(0.5, 1e-3)
    finally:
        mujoco.set_mjcb_control(None)
    # 1e-8 rad: RK4 at 1 ms on motions of some 10 rad/s, (0.01)⁴
    assert np.abs(engine.data.qpos - result.q[-1]).max() < 1e-8


def test_inputs_of_the_scene_are_those_of_the_callback(tmp_path: Path) -> None:
    drive = lamc.Torque({"h1": "gain*sin(5*t) + offset"})
    inputs = {"gain": lamc.Input(unit="N*m", default=3.0), "offset": lamc.Input(unit="N*m")}
    scene = lamc.Scene(effects=(drive, lamc.ExternalTorque(("h2",))), inputs=inputs)
    result = lamc.compile(two_links(), scene).run(
        0.4, rtol=1e-12, atol=1e-14, t_eval=[0.4], parameters={"offset": 0.5, "h2.torque": 0.25}
    )
    engine = InMujoco(two_links(), scene, tmp_path)
    torques = runpy.run_path(str(tmp_path / "torques.py"))
    torques["inputs"]["offset"] = 0.5
    mujoco.mj_resetDataKeyframe(engine.model, engine.data, 0)
    engine.data.ctrl[engine.model.actuator("h2").id] = 0.25
    engine.model.opt.timestep = 1e-3
    mujoco.set_mjcb_control(torques["control"])
    try:
        mujoco.mj_step(engine.model, engine.data, 400)
    finally:
        mujoco.set_mjcb_control(None)
    # 1e-8 rad: RK4 at 1 ms on motions of some 10 rad/s, (0.01)⁴
    assert np.abs(engine.data.qpos - result.q[-1]).max() < 1e-8


def test_a_body_rests_on_the_ground_at_its_height(tmp_path: Path) -> None:
    sheet = Slab(box(-0.05, -0.03, 0.05, 0.03), 0.0, 0.002)
    inertia = 0.01 * np.diag([3e-4, 8.3e-4, 1.13e-3])
    bodies = (
        Body("block", 0.01, (0.0, 0.0, 0.001), inertia, fixed=True, outline=(sheet,)),
        Body("flap", 0.001, (0.06, 0.0, 0.001), 0.1 * inertia),
    )
    joint = Joint("h", "block", "flap", (0.05, 0.0, 0.001), (0.0, 1.0, 0.0), stiffness=0.1, damping=1e-4)
    ground = lamc.GroundContact(height=-0.01, bodies=("block",))
    base = lamc.FreeBase(position=(0.0, 0.0, 0.0))
    scene = lamc.Scene(added=(base, ground))
    engine = InMujoco(Mechanism(bodies, (joint,)), scene, tmp_path)
    engine.end(2.0, 5e-4)
    # It falls by 9 mm and lies with its centre 1 mm above the ground, give or take a few times the sinking of 1e-3 of
    # the size that the ground's stiffness is chosen for, 0.12 mm
    assert abs(engine.data.qpos[2] - (-0.009)) < 5e-4


def test_a_block_slides_as_far_as_friction_lets_it(tmp_path: Path) -> None:
    sheet = Slab(box(-0.05, -0.05, 0.05, 0.05), 0.0, 0.01)
    inertia = np.diag([9.2e-4, 9.2e-4, 1.7e-3])
    bodies = (
        Body("block", 1.0, (0.0, 0.0, 0.005), inertia, fixed=True, outline=(sheet,)),
        Body("speck", 1e-6, (0.0, 0.0, 0.005), 1e-6 * inertia),
    )
    joint = Joint("h", "block", "speck", (0.0, 0.0, 0.005), (0.0, 0.0, 1.0))
    contact = lamc.GroundContact(friction=0.3, bodies=("block",), damping=10.0)
    scene = lamc.Scene(added=(lamc.FreeBase(velocity=(0.5, 0.0, 0.0)), contact))
    engine = InMujoco(Mechanism(bodies, (joint,)), scene, tmp_path)
    engine.end(0.4, 2e-4)  # it stops after v / (mu g) = 0.17 s
    # v² / (2 mu g); 3 %: while it sinks in at first it is pressed down by less than its weight, and MuJoCo's friction
    # lets it creep
    assert abs(engine.data.qpos[0] / (0.5**2 / (2.0 * 0.3 * 9.81)) - 1.0) < 0.03


@pytest.mark.parametrize("name", sorted(SAMPLES))
def test_no_effect_is_left_out_unnoticed(tmp_path: Path, name: str) -> None:
    effect = SAMPLES[name]
    scene = lamc.Scene(effects=(effect,))
    if name in MAPPED:
        InMujoco(two_links(), scene, tmp_path)
        return
    with pytest.raises(
        UnsupportedError, match=name if name != "nonlinear_stiffness" else "stiffness of hinge 'h1'"
    ):
        mjcf.files(two_links(), scene, ExportOptions())
    engine = InMujoco(two_links(), scene, tmp_path, ExportOptions(lossy=True))
    assert "Left out" in engine.readme


def test_a_linear_law_of_a_hinge_is_its_spring(tmp_path: Path) -> None:
    scene = lamc.Scene(added=(lamc.NonlinearStiffness({"h1": [5.0], "h2": [5.0, 0.0]}),))
    engine = InMujoco(two_links(), scene, tmp_path)
    assert list(engine.model.jnt_stiffness) == [5.0, 5.0]
    assert list(engine.model.qpos_spring) == [0.2, 0.2]  # the joints' rest angle


def test_a_rest_angle_without_its_spring_is_a_torque(tmp_path: Path) -> None:
    engine = InMujoco(two_links(), lamc.Scene(effects=(lamc.RestAngle(),)), tmp_path)
    mujoco.mj_forward(engine.model, engine.data)
    # k q₀ = 0.7 · 0.2 N·m; 1e-15: round-off of that product
    assert np.abs(engine.data.qfrc_actuator - 0.14).max() < 1e-15


def test_limits_that_strike_are_refused_and_named() -> None:
    scene = lamc.Scene(added=(lamc.JointLimits(restitution=0.5),))
    with pytest.raises(UnsupportedError, match=r"restitution of joint limits, 0\.5"):
        mjcf.files(two_links(), scene, ExportOptions())


def test_what_a_file_asks_for_and_mjcf_has_not_is_reported_at_its_line() -> None:
    design = lamc.load(path("flapping_wing"))
    with pytest.raises(UnsupportedError, match="no place for blade_element_drag") as refusal:
        lamc.export(design, "mjcf")
    place = refusal.value.place
    assert place is not None
    line = path("flapping_wing").read_text(encoding="utf-8").splitlines()[place.line - 1]
    assert "blade_element_drag" in line
