"""Angles of joints that close loops count turns, and springs, stops and checks take them as those of any other."""

import importlib
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import lamc
from lamc import (
    Body,
    Gravity,
    HingeStiffness,
    Joint,
    JointLimits,
    Mechanism,
    RestAngle,
    Scene,
    TwistCompliance,
)
from lamc.reference.check import check
from lamc.run.request import Status

GRAVITY = Gravity((0.0, -9.81, 0.0))
SPRINGS = (GRAVITY, HingeStiffness(), RestAngle())


def crank_rocker(mirror: int, springs: str) -> Mechanism:
    """A crank-rocker, or its mirror image; with springs at the joints named. B turns round and round."""
    crank, coupler, rocker, ground = 0.03, 0.07, 0.06, 0.08
    a, d = np.zeros(3), np.array([ground, 0.0, 0.0])
    b = crank * np.array([np.cos(1.2), np.sin(1.2), 0.0])
    length = float(np.linalg.norm(d - b))
    along = (d - b) / length
    x = (coupler**2 - rocker**2 + length**2) / (2.0 * length)
    c = b + x * along + np.sqrt(coupler**2 - x**2) * np.array([-along[1], along[0], 0.0])
    a, b, c, d = (np.array([mirror, 1, 1]) * p for p in (a, b, c, d))

    def bar(name: str, p: np.ndarray, q: np.ndarray, mass: float) -> Body:
        return Body(name, mass=mass, com=(p + q) / 2, inertia=np.diag([1e-7, 1e-6, 1e-6]))

    def hinge(name: str, parent: str, child: str, point: np.ndarray) -> Joint:
        k = 2e-3 if name in springs else 0.0
        return Joint(name, parent, child, point, (0, 0, mirror), stiffness=k, rest_angle=0.2 if k else 0.0)

    bodies = (bar("crank", a, b, 0.004), bar("coupler", b, c, 0.006), bar("rocker", c, d, 0.005))
    joints = (
        hinge("A", "ground", "crank", a),
        hinge("B", "crank", "coupler", b),
        hinge("C", "coupler", "rocker", c),
        hinge("D", "ground", "rocker", d),
    )
    return Mechanism((Body("ground", fixed=True), *bodies), joints)


def spun(mirror: int, springs: str) -> lamc.Simulator:
    effects = SPRINGS if springs else (GRAVITY,)
    return lamc.compile(crank_rocker(mirror, springs), Scene(effects=effects, rates={"A": 120.0}))


@pytest.mark.parametrize("mirror", [1, -1])
@pytest.mark.quick("-1")
def test_a_crank_turns_a_thousand_times_against_springs_on_all_hinges(mirror: int) -> None:
    """Springs so soft that a thousand turns store a tenth of the energy; each step may lose rtol of it."""
    mechanism = crank_rocker(mirror, "")
    joints = tuple(replace(j, stiffness=1e-10, rest_angle=0.2) for j in mechanism.joints)
    scene = Scene(effects=SPRINGS, rates={"A": 120.0})
    sim = lamc.compile(replace(mechanism, joints=joints), scene)
    result = sim.run(t_end=90.0, rtol=1e-9, atol=1e-11, t_eval=np.linspace(0.0, 90.0, 91))
    assert result.success
    for joint in "AB":
        assert np.abs(result.angle(joint)[-1]) > 2000.0 * np.pi
    allowed = 1e-9 * result.stats.accepted * result.energies["kinetic"].max()
    assert np.abs(result.energy - result.energy[0]).max() <= allowed
    assert result.energies["hinge_stiffness"][-1] > 1e-3  # J


@pytest.mark.parametrize("springs", ["", "B", "BC", "ABCD"])
def test_a_body_and_its_mirror_image_move_alike(springs: str) -> None:
    """The same motion whichever joint closes the loop: within ten times what each step may err, of the angle that has
    counted most turns."""
    t = np.linspace(0.0, 1.0, 201)
    sims = [spun(mirror, springs) for mirror in (1, -1)]
    assert [sim.cut_joints for sim in sims] == [("C",), ("B",)]
    runs = [sim.run(t_end=1.0, rtol=1e-10, atol=1e-12, t_eval=t) for sim in sims]
    assert all(run.success for run in runs)
    limit = 1e-9 * max(1.0, *(float(np.abs(run.q).max()) for run in runs))
    for joint in "ABCD":
        angles = [run.angle(joint) for run in runs]
        np.testing.assert_allclose(angles[0], angles[1], rtol=0, atol=limit)
        assert np.abs(np.diff(angles)).max() < np.pi  # nothing jumps
    assert np.abs(runs[0].angle("B")).max() > np.pi
    for run in runs:
        assert np.abs(run.energy - run.energy[0]).max() < 1e-9 * run.energies["kinetic"].max()


@pytest.mark.parametrize("integrator", ["rk45", "dop853", "rodas5p", "radau5"])
def test_every_integrator_carries_an_angle_past_half_a_turn(integrator: str) -> None:
    sim = spun(-1, "BC")
    assert sim.cut_joints == ("B",)
    result = sim.run(t_end=0.2, rtol=1e-8, atol=1e-10, integrator=integrator)
    assert result.success, result.message
    assert not result.notes
    exact = sim.run(t_end=0.2, rtol=1e-11, atol=1e-13)
    assert abs(exact.angle("B")[-1]) > np.pi
    # 1e-8 in each of some hundred steps
    assert result.angle("B")[-1] == pytest.approx(exact.angle("B")[-1], abs=1e-6)
    assert np.abs(result.energy - result.energy[0]).max() < 1e-6 * result.energies["kinetic"].max()


def test_steps_of_fixed_length_count_turns_too() -> None:
    sim = spun(-1, "BC")
    lib, ffi = sim._model.lib, sim._model.ffi
    with sim._model.motion({}).opened() as handle:
        ode = ffi.new("lamc_ode *", lib.lamc_motion_ode(handle))
        y = np.array(sim.run(t_end=0.0).y[:, 0])
        scratch = np.zeros(int(lib.lamc_fixed_scratch(ode)))
        memory = [ffi.from_buffer("double[]", each, require_writable=True) for each in (y, scratch)]
        for step in range(10_000):
            assert lib.lamc_fixed_step(ode, 1e-5 * step, 1e-5, *memory) == Status.REACHED_END
    expected = sim.run(t_end=0.1, rtol=1e-11, atol=1e-13).q[-1]
    assert np.abs(expected).max() > np.pi
    np.testing.assert_allclose(y[: len(expected)], expected, rtol=0, atol=1e-8)


@pytest.mark.slow
def test_check_vouches_for_angles_beyond_half_a_turn(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(
        importlib.import_module("lamc.reference.check"), "SECONDS", 60.0
    )  # however busy it is here
    report = check(spun(-1, "BC"), states=3, t_end=0.05)  # six radians of the crank
    assert report.passed, report.table()
    assert all(c.compared for c in report.comparisons)
    assert not report.notes


@pytest.mark.parametrize("flat_fold", [True, False])
def test_stops_act_on_whichever_joint_closes_the_loop(flat_fold: bool) -> None:
    """B runs against a stop, at -180° or at a limit of its own, and comes back; a stop of 50 N·m/rad takes all of the
    crank's energy, some 0.02 J, within 0.05 rad."""
    most = np.pi if flat_fold else 1.0
    runs = []
    for mirror in (1, -1):
        drawn = crank_rocker(mirror, "")
        limits = {"B": (-most, most)}
        joints = tuple(replace(j, limits=limits.get(j.name, j.limits)) for j in drawn.joints)
        effects = (GRAVITY, JointLimits(stiffness=50.0, damping=0.0, flat_fold=flat_fold))
        sim = lamc.compile(replace(drawn, joints=joints), Scene(effects=effects, rates={"A": 120.0}))
        runs.append(sim.run(t_end=0.2, rtol=1e-10, atol=1e-12, t_eval=np.linspace(0.0, 0.2, 2001)))
        assert runs[-1].success, runs[-1].message
        assert most < np.abs(runs[-1].angle("B")).max() < most + 0.05
    # 1e-10 in each step, and each stop throws back what it was hit by a little earlier or later
    np.testing.assert_allclose(runs[0].angle("B"), runs[1].angle("B"), rtol=0, atol=1e-6)


FILM = {"width": 5e-3, "length": 1e-3, "thickness": 1e-4, "E": 2.5e9, "nu": 0.3, "normal": (1.0, 0.0, 0.0)}


def yielding(
    mirror: int, *effects: Any, joint: str = "B", rate: float = 120.0, **given: Any
) -> lamc.Simulator:
    """The crank-rocker with a strip of film for B: of the tree in one, and what closes the loop in its mirror image."""
    strip = TwistCompliance(joints=(joint,), **FILM, retardation=1e-4)
    scene = Scene(effects=(*SPRINGS, strip, *effects), rates={"A": rate}, **given)
    return lamc.compile(crank_rocker(mirror, "BC"), scene)


@pytest.mark.slow
@pytest.mark.parametrize("effects", [(), (JointLimits(stiffness=50.0, damping=0.0, flat_fold=True),)])
def test_a_hinge_that_yields_and_closes_the_loop_counts_turns(effects: tuple[Any, ...]) -> None:
    t = np.linspace(0.0, 0.2, 401)
    sims = [yielding(mirror, *effects) for mirror in (1, -1)]
    assert ["B" in sim.joints for sim in sims] == [True, False]
    runs = [sim.run(0.2, rtol=1e-9, atol=1e-11, t_eval=t) for sim in sims]
    most = float(np.abs(runs[1].angle("B")).max())
    assert most > np.pi
    assert (most < np.pi + 0.05) is bool(effects)  # a stop of 50 N·m/rad takes the crank's 0.02 J within that
    for joint in "ABCD":
        # 1e-9 in each step; stops throw back what they are hit by a little earlier or later
        np.testing.assert_allclose(runs[0].angle(joint), runs[1].angle(joint), rtol=0, atol=1e-8)
        pace = np.abs(runs[0].rate(joint)).max()
        np.testing.assert_allclose(runs[0].rate(joint), runs[1].rate(joint), rtol=0, atol=1e-6 * pace)
    with pytest.raises(KeyError, match="there are D, C, A, B"):
        runs[1].angle("E")


@pytest.mark.parametrize("joint", "ACD")
@pytest.mark.quick("C")
def test_a_strip_yields_alike_whichever_way_the_tree_passes_it(joint: str) -> None:
    """What yields rides on the joint's parent: with C the tree comes from there in one image and not in the other, at
    angles of a rad and more."""
    t = np.linspace(0.0, 0.2, 101)
    runs = [yielding(mirror, joint=joint).run(0.2, rtol=1e-9, atol=1e-11, t_eval=t) for mirror in (1, -1)]
    for each in "ABCD":
        np.testing.assert_allclose(
            runs[0].angle(each), runs[1].angle(each), rtol=0, atol=1e-8
        )  # 1e-9 in each step


@pytest.mark.parametrize("integrator", ["rodas5p", "radau5"])
def test_implicit_methods_carry_it_too(integrator: str) -> None:
    exact, found = (yielding(-1).run(0.05, **how) for how in ({"rtol": 1e-11, "atol": 1e-13}, {
        "rtol": 1e-9, "atol": 1e-11, "integrator": integrator}))  # fmt: skip
    assert found.success, found.message
    assert abs(found.angle("B")[-1]) > np.pi
    for joint in "ABCD":
        assert found.angle(joint)[-1] == pytest.approx(exact.angle(joint)[-1], abs=1e-6)


def test_check_compares_a_yielding_hinge_beyond_half_a_turn() -> None:
    report = check(yielding(-1), states=4, t_end=0.1)
    assert report.passed, report.table()


@pytest.mark.parametrize("turns", [0, 1, -2])
def test_a_yielding_hinge_starts_with_the_turns_it_is_given(turns: int) -> None:
    given = 0.1 + 2.0 * np.pi * turns
    sim = yielding(-1, rate=0.0, angles={"B": given})
    result = sim.run(0.0)
    assert result.angle("B")[0] == pytest.approx(given, abs=1e-6)  # rad; rigid loops are closed to some 1e-9
    stored = result.energies["hinge_stiffness"][0] + result.energies["rest_angle"][0]
    c = float(result.angle("C")[0])
    assert stored == pytest.approx(1e-3 * ((given - 0.2) ** 2 + (c - 0.2) ** 2), rel=1e-5)


@pytest.mark.parametrize(("rate", "reported"), [(1e-10, True), (1.0, False)])
def test_a_rank_that_only_other_postures_have_is_a_note(rate: float, reported: bool) -> None:
    """A vertex of four creases, drawn flat: there two of its equations are independent, and three where it is folded.
    At 1e-10 rad/s it has turned by 1e-11 rad at the end, and is flat for all that a double can tell."""
    azimuths = np.radians([0.0, 60.0, 150.0, 270.0])  # sectors of 60, 90, 120, 90 degrees: it folds flat
    middle = 0.5 * (azimuths + np.append(azimuths[1:], 2.0 * np.pi))
    bodies = [
        Body(
            f"p{i}",
            1e-3,
            0.02 * np.array([np.cos(a), np.sin(a), 0.0]),
            1e-7 * np.diag([1, 1, 2]),
            fixed=i == 0,
        )
        for i, a in enumerate(middle)
    ]
    joints = [
        Joint(f"c{i}", f"p{(i - 1) % 4}", f"p{i}", axis=(np.cos(a), np.sin(a), 0.0))
        for i, a in enumerate(azimuths)
    ]
    sim = lamc.compile(
        Mechanism(tuple(bodies), tuple(joints)), Scene(effects=(), branch=1, rates={"c0": rate})
    )
    assert sim.loops.rank == 3
    result = sim.run(t_end=0.1, t_eval=np.linspace(0.0, 0.1, 11))
    assert result.success, result.message
    notes = [note for note in result.notes if "the rank was taken from elsewhere" in note]
    assert bool(notes) == reported
    if reported:
        assert "3 independent equations in other postures, and 2 at the 5 rows" in notes[0]
