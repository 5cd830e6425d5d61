"""Angles of joints that close loops are reported within ±180°: where that matters, it is said, and never computed
with."""

from dataclasses import replace

import numpy as np
import pytest

import lamc
from lamc import Body, Gravity, HingeStiffness, Joint, JointLimits, Mechanism, RestAngle, Scene
from lamc.basics.errors import DesignError
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


def test_a_joint_with_a_spring_carries_a_body_and_its_mirror_image_moves_alike() -> None:
    t = np.linspace(0.0, 1.0, 201)
    runs = [spun(mirror, "B").run(t_end=1.0, rtol=1e-10, atol=1e-12, t_eval=t) for mirror in (1, -1)]
    assert all(run.success for run in runs)
    assert np.abs(runs[0].angle("B")).max() > 2.0 * np.pi  # it counts turns
    # the same motion through the same operations, but for signs
    np.testing.assert_allclose(runs[0].angle("A"), runs[1].angle("A"), rtol=0, atol=1e-10)
    assert all(np.abs(r.energy - r.energy[0]).max() < 1e-9 * r.energies["kinetic"].max() for r in runs)


@pytest.mark.parametrize("integrator", ["auto", "rk45", "rodas5p", "radau5"])
def test_a_run_ends_where_an_angle_that_a_spring_reads_jumps(integrator: str) -> None:
    sim = spun(-1, "BC")
    assert sim.cut_joints == ("B",)
    result = sim.run(t_end=1.0, rtol=1e-8, atol=1e-10, integrator=integrator)
    assert result.status == Status.ANGLE_WRAPPED
    assert "'B'" in result.message
    assert abs(abs(result.angle("B")[-1]) - np.pi) < 1e-5  # one step after 1e-6 was not reached yet, at most
    # the energy balance of the spring hold up to there: nothing was computed beyond the jump
    assert np.abs(result.energy - result.energy[0]).max() < 1e-5 * result.energies["kinetic"].max()
    # the same machine cut at another joint agrees
    other = spun(1, "BC")
    assert other.cut_joints == ("C",)
    beside = other.run(t_end=float(result.t[-1]), rtol=1e-10, atol=1e-12)
    np.testing.assert_allclose(beside.angle("A")[-1], result.angle("A")[-1], rtol=0, atol=1e-5)


def test_a_jump_that_nothing_reads_is_a_note() -> None:
    for mirror in (1, -1):
        result = spun(mirror, "").run(t_end=0.3)
        assert result.success
        jumps = any(np.abs(np.diff(result.angle(name))).max() > np.pi for name in ("B", "C"))
        assert any("passes ±180°" in note for note in result.notes) == jumps
    assert "passes ±180°" in " ".join(spun(-1, "C").run(t_end=0.3).notes)


def test_steps_of_fixed_length_say_so_too() -> None:
    mechanism = crank_rocker(-1, "BC")
    sim = lamc.compile(mechanism, Scene(effects=SPRINGS, rates={"A": 120.0}))
    lib, ffi = sim._model.lib, sim._model.ffi
    with sim._model.motion({}).opened() as handle:
        ode = ffi.new("lamc_ode *", lib.lamc_motion_ode(handle))
        y = np.array(sim.run(t_end=0.0).y[:, 0])
        scratch = np.zeros(int(lib.lamc_fixed_scratch(ode)))
        status, t, h = 0, 0.0, 1e-5
        while status == 0 and t < 0.1:
            status = lib.lamc_fixed_step(
                ode,
                t,
                h,
                ffi.from_buffer("double[]", y, require_writable=True),
                ffi.from_buffer("double[]", scratch),
            )
            t += h
    assert status == Status.ANGLE_WRAPPED
    end = sim.run(t_end=1.0, rtol=1e-10, atol=1e-12).t[-1]
    assert 0.0 < t - end < 2.0 * h  # of the step over the jump


@pytest.mark.slow
def test_check_does_not_vouch_for_what_all_cross_checks_share() -> None:
    sim = spun(-1, "BC")
    report = check(sim, states=3, t_end=0.02)
    rows = [c for c in report.comparisons if not c.compared and "beyond ±180°" in c.quantity]
    assert len(rows) == 1
    assert "unchecked" in rows[0].reason
    assert not any(
        "beyond ±180°" in c.quantity for c in check(spun(1, "B"), states=3, t_end=0.02).comparisons
    )


def test_stops_that_could_never_act_are_refused() -> None:
    mechanism = crank_rocker(1, "")
    with pytest.raises(DesignError, match=r"closes a loop, and its limit of -180° would never act"):
        lamc.compile(mechanism, Scene(effects=(JointLimits(stiffness=1.0, flat_fold=True),)))
    cut = lamc.compile(mechanism, Scene(effects=(GRAVITY,))).cut_joints[0]
    joints = tuple(
        replace(j, limits=(-3.0, np.pi)) if j.name in (cut, "B", "C") else j for j in mechanism.joints
    )
    scene = Scene(effects=(JointLimits(stiffness=1.0),))
    assert lamc.compile(replace(mechanism, joints=joints), scene).run(t_end=0.0).success


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
