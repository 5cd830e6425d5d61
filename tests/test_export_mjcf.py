"""MJCF by the word of MuJoCo, which nobody here wrote: mass matrices, accelerations, stops and trajectories."""

import runpy
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from shapely.geometry import box

import lamc
from lamc.errors import ExportError, UnsupportedError
from lamc.examples import path
from lamc.export import mjcf
from lamc.export.options import ExportOptions
from lamc.mechanism.records import Array, Body, Joint, Mechanism, Plate
from tests.closed_mechanisms import closed_mechanism
from tests.engines import InMujoco, load, mujoco
from tests.every_effect import SAMPLES
from tests.every_effect import mechanism as two_links
from tests.floating import with_base
from tests.mechanisms import ALL_PASSIVE, KINDS, random_state, random_tree

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


def energy_mass_matrix(simulator: lamc.Simulator, q: Array) -> Array:
    """M by the kinetic energy of one rate and of two together, from the compiled energies."""
    count = len(simulator.rates)
    still = simulator.energy(q, np.zeros(count))
    unit = np.eye(count)
    own = np.array([simulator.energy(q, e) - still for e in unit])
    pairs = np.array([[simulator.energy(q, a + b) - still for b in unit] for a in unit])
    return np.asarray(pairs - own[:, None] - own[None, :])


def scene_of(mechanism: Mechanism) -> lamc.Scene:
    """Everything that MuJoCo has as well, on some joints and bodies."""
    first, last = mechanism.joints[0].name, mechanism.joints[-1].name
    moving = [body for body in mechanism.bodies if not body.fixed]
    spring = lamc.Spring("ground", (0.1, 0.2, -0.3), moving[-1].name, tuple(moving[-1].com), 2.0, 0.4, 0.1)
    torques: dict[str, float | str] = {first: 0.3, last: "0.2 - 0.1*angle - 0.05*rate"}
    return lamc.Scene(effects=(*ALL_PASSIVE, spring, lamc.Torque(torques)))


def end_errors(
    mechanism: Mechanism, scene: lamc.Scene, folder: Path, t_end: float, steps: Sequence[float]
) -> list[float]:
    """Largest difference of any angle at t_end, s, rad, from lamc at round-off, for each step, s."""
    simulator = lamc.compile(mechanism, scene)
    result = simulator.run(t_end, rtol=1e-12, atol=1e-14, t_eval=[0.0, t_end])
    assert result.success
    engine = InMujoco(mechanism, scene, folder)
    errors = []
    for step in steps:
        engine.end(t_end, step)
        ends = [
            engine.data.qpos[engine.place(j.name)[0]] - result.angle(j.name)[-1] for j in mechanism.joints
        ]
        errors.append(float(np.abs(np.remainder(np.array(ends) + np.pi, 2.0 * np.pi) - np.pi).max()))
    return errors


@pytest.mark.parametrize("kind", KINDS)
def test_trees_accelerate_in_mujoco_as_they_do_in_lamc(tmp_path: Path, kind: str) -> None:
    for n, seed in ((1, 1), (4, 2), (7, 3)):
        mechanism = random_tree(n, seed, kind)
        scene = scene_of(mechanism)
        simulator = lamc.compile(mechanism, scene)
        engine = InMujoco(mechanism, scene, tmp_path / f"{kind}{n}")
        for state in range(3):
            q, u = random_state(n, seed=10 * seed + state)
            M = energy_mass_matrix(simulator, q)
            # 1e-11 of the largest: sheets without thickness are made thicker by 1e-12, the others stay at round-off
            assert np.abs(engine.mass_matrix(simulator, q) - M).max() < 1e-11 * np.abs(M).max()
            expected = simulator.acceleration(q, u)
            # 1e-10: the same, times the condition of M where it shows; 2e-12 was the worst of eighty states
            error = np.abs(engine.accelerations(simulator, q, u) - expected).max()
            assert error < 1e-10 * np.abs(expected).max()


def test_a_floating_base_moves_in_mujoco_as_it_does_in_lamc(tmp_path: Path) -> None:
    mechanism = with_base(random_tree(4, 5, "space"))
    free = lamc.FreeBase((0.3, 0.1, 1.0), (0.4, -0.2, 0.3), (0.5, 0.1, -0.2), (0.3, 1.0, -0.6))
    scene = lamc.Scene(effects=(*(scene_of(mechanism).effects or ()), free))
    simulator = lamc.compile(mechanism, scene)
    engine = InMujoco(mechanism, scene, tmp_path)
    assert np.abs(engine.data.qpos[:7] - simulator.start[4:11]).max() == 0.0
    for seed in range(3):
        q, u = random_state(11, seed)[0], random_state(10, seed)[1]
        q[7:] /= np.linalg.norm(q[7:])
        expected = simulator.acceleration(q, u)
        # 1e-10: as for trees
        assert np.abs(engine.accelerations(simulator, q, u) - expected).max() < 1e-10 * np.abs(expected).max()


def test_trajectories_of_trees_differ_by_the_error_of_rk4(tmp_path: Path) -> None:
    mechanism = random_tree(4, 7, "mixed")
    scene = lamc.Scene(effects=scene_of(mechanism).effects, angles={mechanism.joints[1].name: 0.8})
    coarse, fine = end_errors(mechanism, scene, tmp_path, 1.0, (4e-3, 2e-3))
    # 2⁴ = 16 for fourth order; within 12 and 20, since the next order still shows at these steps
    assert 12.0 < coarse / fine < 20.0
    assert fine < 1e-6  # rad: that there is so much to compare, and no constant difference


@pytest.mark.parametrize(
    ("family", "seed"), [("planar", 1), ("spherical", 2), ("spatial", 1), ("bennett", 1)]
)
def test_trajectories_of_loops_differ_by_the_softness_of_welds(
    tmp_path: Path, family: str, seed: int
) -> None:
    mechanism = closed_mechanism(family, seed).mechanism
    steps = (2e-3, 1e-3, 5e-4)
    coarse, middle, fine = end_errors(mechanism, lamc.Scene(), tmp_path, 0.5, steps)
    # Welds yield by their acceleration times the square of their time constant, two steps: 2² = 4 from step to step;
    # between 3 and 6, since the error of RK4 (2⁴) adds to it where the steps are coarse
    assert 3.0 < coarse / middle < 6.0
    assert 3.0 < middle / fine < 6.0
    assert fine < 1e-4  # rad


def test_starts_of_loops_are_those_of_lamc(tmp_path: Path) -> None:
    mechanism = closed_mechanism("planar", 3).mechanism
    given = mechanism.joints[0].name
    scene = lamc.Scene(angles={given: 0.3}, rates={given: -0.7})
    simulator = lamc.compile(mechanism, scene)
    start = simulator.run(1e-3, t_eval=[0.0])
    engine = InMujoco(mechanism, scene, tmp_path)
    for joint in mechanism.joints:
        angle, rate = engine.place(joint.name)
        # 1e-9: closed to that by either
        assert abs(engine.data.qpos[angle] - start.angle(joint.name)[0]) < 1e-9
        assert abs(engine.data.qvel[rate] - start.rate(joint.name)[0]) < 1e-9


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
    assert "3&#42;sin(5&#42;t) - rate&#42;rate" in engine.readme
    mujoco.set_mjcb_control(runpy.run_path(str(tmp_path / "torques.py"))["control"])
    try:
        engine.end(0.5, 1e-3)
    finally:
        mujoco.set_mjcb_control(None)
    # 1e-8 rad: RK4 at 1 ms on motions of some 10 rad/s, (0.01)⁴
    assert np.abs(engine.data.qpos - result.q[-1]).max() < 1e-8


def test_a_body_rests_on_the_ground_at_its_height(tmp_path: Path) -> None:
    sheet = Plate(box(-0.05, -0.03, 0.05, 0.03), 0.0, 0.002)
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
    sheet = Plate(box(-0.05, -0.05, 0.05, 0.05), 0.0, 0.01)
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


def test_floating_loops_move_as_in_lamc(tmp_path: Path) -> None:
    mechanism = with_base(closed_mechanism("spherical", 11, sprung=True).mechanism)
    free = lamc.FreeBase(velocity=(0.5, 0.1, -0.2), spin=(0.3, 1.0, -0.6))
    scene = lamc.Scene(added=(free,))
    coarse, fine = end_errors(mechanism, scene, tmp_path, 0.5, (1e-3, 5e-4))
    assert 3.0 < coarse / fine < 6.0  # 2² = 4, as on a fixed world
    assert fine < 1e-5  # rad


def test_limits_that_strike_are_refused_and_named() -> None:
    scene = lamc.Scene(added=(lamc.JointLimits(restitution=0.5),))
    with pytest.raises(UnsupportedError, match=r"restitution of joint limits, 0\.5"):
        mjcf.files(two_links(), scene, ExportOptions())


def test_what_a_file_asks_for_and_mjcf_has_not_is_told_at_its_line() -> None:
    design = lamc.load(path("flapping_wing"))
    with pytest.raises(UnsupportedError, match="no place for blade_element_drag") as refusal:
        lamc.export(design, "mjcf")
    place = refusal.value.place
    assert place is not None
    line = path("flapping_wing").read_text(encoding="utf-8").splitlines()[place.line - 1]
    assert "blade_element_drag" in line


def test_bodies_too_light_for_mujoco_are_named() -> None:
    bodies = (Body("ground", fixed=True), Body("speck", 1e-9, np.zeros(3), 1e-17 * np.eye(3)))
    with pytest.raises(
        UnsupportedError, match=r"'speck' has a mass of 1e-09 kg and a principal moment of 1e-17"
    ):
        mjcf.files(Mechanism(bodies, (Joint("h", "ground", "speck"),)), lamc.Scene(), ExportOptions())


def test_hostile_names_load_and_are_told_apart(tmp_path: Path) -> None:
    names = ['a"b', "a<b", "a&b", "A_B", "🦋", "../../x", "world", "'", "ground_plane", "-->", "|`*"]
    bodies = [Body('grund "<&', fixed=True)]
    joints = []
    for k, name in enumerate(names):
        bodies.append(Body(name, 1.0, (float(k), 0.0, 0.5), np.eye(3)))
        joints.append(
            Joint(name, bodies[k].name, name, (float(k), 0.0, 0.0), (0.0, 1.0, 0.0), stiffness=k + 1.0)
        )
    mechanism = Mechanism(tuple(bodies), tuple(joints), name="<!-- & '\" ]]>")
    files = mjcf.files(mechanism, lamc.Scene(), ExportOptions())
    assert all(
        set(name) <= set("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-./")
        for name in files
    )
    assert not any(".." in name for name in files)
    assert len({name.casefold() for name in files}) == len(files)
    model = load(files, tmp_path)
    assert model.njnt == len(names)
    assert list(model.jnt_stiffness) == [
        k + 1.0 for k in range(len(names))
    ]  # a chain: their order is the design's


def test_the_same_design_gives_the_same_bytes() -> None:
    mechanism = closed_mechanism("several", 3).mechanism
    assert mjcf.files(mechanism, lamc.Scene(), ExportOptions()) == mjcf.files(
        mechanism, lamc.Scene(), ExportOptions()
    )


def test_a_folder_is_written_by_the_public_name(tmp_path: Path) -> None:
    folder = lamc.export(two_links(), "mjcf", lamc.Scene(), tmp_path / "out", prefix="arm", step=1e-3)
    model = (folder / "arm.xml").read_text(encoding="utf-8")
    assert 'timestep="0.001"' in model
    assert {path.name for path in folder.iterdir()} >= {"README.md", "names.json", "meshes"}
    with pytest.raises(ExportError, match="the step of an export is 0"):
        lamc.export(two_links(), "mjcf", out=tmp_path / "none", step=0.0)
