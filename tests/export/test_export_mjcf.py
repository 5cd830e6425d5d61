"""MJCF by the word of MuJoCo, which nobody here wrote: mass matrices, accelerations, stops and trajectories."""

import re
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner, Result

import lamc
from lamc.basics.errors import ExportError, UnsupportedError
from lamc.cli import main
from lamc.commands.examples import mechanism_of_example
from lamc.examples import find
from lamc.export import mjcf
from lamc.export.options import ExportOptions
from lamc.records.mechanism import Array, Body, Joint, Mechanism
from tests.support.closed_mechanisms import closed_mechanism
from tests.support.engines import InMujoco, end_errors, load
from tests.support.every_effect import mechanism as two_links
from tests.support.floating import with_base
from tests.support.mechanisms import ALL_PASSIVE, KINDS, random_state, random_tree


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
@pytest.mark.quick("planar-1", "bennett-1")
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


def test_floating_loops_move_as_in_lamc(tmp_path: Path) -> None:
    mechanism = with_base(closed_mechanism("spherical", 11, sprung=True).mechanism)
    free = lamc.FreeBase(velocity=(0.5, 0.1, -0.2), spin=(0.3, 1.0, -0.6))
    scene = lamc.Scene(added=(free,))
    coarse, fine = end_errors(mechanism, scene, tmp_path, 0.5, (1e-3, 5e-4))
    assert 3.0 < coarse / fine < 6.0  # 2² = 4, as on a fixed world
    assert fine < 1e-5  # rad


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


def test_the_command_line_writes_what_python_does(tmp_path: Path) -> None:
    def call(*words: str) -> Result:
        return CliRunner().invoke(main, ["export", "--to", "mjcf", *words], catch_exceptions=False)

    written_by = call("--example", "four_bar", "--step", "5e-4", "--out", str(tmp_path / "cli"))
    assert written_by.exit_code == 0, written_by.stderr
    lamc.export(mechanism_of_example(find("four_bar")), "mjcf", out=tmp_path / "python", step=5e-4)
    for name in ("four_bar.xml", "README.md", "names.json", "meshes/shelf.stl"):
        assert (tmp_path / "cli" / name).read_bytes() == (tmp_path / "python" / name).read_bytes()
    refused = call("--example", "flapping_wing", "--out", str(tmp_path / "wing"))
    assert refused.exit_code == 2
    assert re.search(r"flapping_wing\.yaml:\d+:\d+: MJCF has no place for blade_element_drag", refused.stderr)
    assert call("--example", "flapping_wing", "--lossy", "--out", str(tmp_path / "wing")).exit_code == 0


def test_a_folder_is_written_by_the_public_name(tmp_path: Path) -> None:
    folder = lamc.export(two_links(), "mjcf", lamc.Scene(), tmp_path / "out", prefix="leg", step=1e-3)
    model = (folder / "leg.xml").read_text(encoding="utf-8")
    assert 'timestep="0.001"' in model
    assert {path.name for path in folder.iterdir()} >= {"README.md", "names.json", "meshes"}
    with pytest.raises(ExportError, match=r"--step \(step\) is 0"):
        lamc.export(two_links(), "mjcf", out=tmp_path / "none", step=0.0)
