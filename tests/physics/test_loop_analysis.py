"""Loops read from their geometry: ranks, misfits, branches and starts, against answers that nobody here computed."""

import json
import math
import pickle
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

import lamc
from lamc.cli import main
from lamc.loops.branches import find_branches
from lamc.loops.geometry import LoopGeometry
from lamc.loops.rank import check_freedom, count_loops
from lamc.loops.tangents import tangents
from lamc.mechanism.plan import plan
from lamc.readers.mechanism_file import write_mechanism
from lamc.records.mechanism import Body, Joint, Mechanism
from lamc.records.scene import Scene
from lamc.reference.closing import settled
from lamc.reference.newton_euler import NewtonEuler
from lamc.run.simulator import Simulator
from tests.support.mechanisms import from_reference
from tests.support.quick import tries
from tests.support.screws import joint_screws

FLAT = ("vertex4_flatfoldable", "waterbomb6", "miura22", "miura33")  # drawn flat, where they are singular


@pytest.fixture(scope="module")
def cases(shared: Path) -> dict[str, Any]:
    text = (shared / "reference" / "dynamics.json").read_text(encoding="utf-8")
    return {case["id"]: case for case in json.loads(text)["cases"]}


def vertex(sectors: Sequence[float], shift: float = 0.0) -> Mechanism:
    """Creases c0, c1, … that meet in a point, at azimuths that grow by the sector angles (rad), between plates of
    0.04 m. The last crease is drawn `shift` (m) beside the point."""
    azimuths = np.concatenate([[0.0], np.cumsum(sectors)[:-1]])
    count = len(sectors)
    middle = azimuths + 0.5 * np.asarray(sectors)
    bodies = [
        Body(
            f"p{i}",
            1e-3,
            np.array([0.02 * math.cos(a), 0.02 * math.sin(a), 0.0]),
            1e-7 * np.diag([1.0, 1.0, 2.0]),
            fixed=i == 0,
        )
        for i, a in enumerate(middle)
    ]
    joints = [
        Joint(f"c{i}", f"p{(i - 1) % count}", f"p{i}", axis=np.array([math.cos(a), math.sin(a), 0.0]))
        for i, a in enumerate(azimuths)
    ]
    beside = shift * np.array([-math.sin(azimuths[-1]), math.cos(azimuths[-1]), 0.0])
    joints[-1] = replace(joints[-1], point=beside)
    return Mechanism(tuple(bodies), tuple(joints), name="vertex")


def tilted(case: dict[str, Any], tilt: float) -> tuple[Mechanism, Scene]:
    """The four-bar whose hinge C is turned by `tilt` (rad) about y, and its scene."""
    mechanism, scene = from_reference(case["spec"])
    axis = np.array([math.sin(tilt), 0.0, math.cos(tilt)])
    joints = tuple(replace(j, axis=axis) if j.name == "C" else j for j in mechanism.joints)
    return replace(mechanism, joints=joints), scene


def compiled(mechanism: Mechanism, **scene: Any) -> Simulator:
    return lamc.compile(mechanism, Scene(**{"effects": (), **scene}))


def test_screws_have_the_published_singular_values(cases: dict[str, Any]) -> None:
    """Of the joint-screw matrix [axis; p × axis] about the world's origin, p in units of the largest coordinate."""
    for name, expected in cases["loop_ranks"]["expected"].items():
        if not expected["loops"]:
            continue
        mechanism, scene = from_reference(cases[name]["spec"])
        unit = max(float(np.abs(joint.point).max()) for joint in mechanism.joints) or 1.0
        tree = plan(mechanism)
        angles = np.array([scene.angles.get(joint.name, 0.0) for joint in tree.hinges])
        values = np.linalg.svd(joint_screws(tree, angles, np.zeros(3), unit), compute_uv=False)
        # The file's digits, 15 of them, of numbers up to 3.
        assert values[0] == pytest.approx(expected["max_sv"], abs=1e-13)
        assert values[expected["rank"] - 1] == pytest.approx(expected["min_nonzero_sv"], abs=1e-12)


@pytest.mark.parametrize("tilt", ["0", "1e-08", "1e-06", "0.0001", "0.01"])
def test_a_misaligned_hinge_shows_in_the_singular_values(cases: dict[str, Any], tilt: str) -> None:
    case = cases["misaligned_fourbar"]
    mechanism, _ = tilted(cases["fourbar_crank"], float(tilt))
    values = np.linalg.svd(joint_screws(plan(mechanism), np.zeros(4), np.zeros(3), 0.08), compute_uv=False)
    assert np.abs(values - case["expected"][tilt]).max() <= case["tol"]


@pytest.mark.parametrize("name", [*FLAT, "fourbar_crank", "fivebar", "bricard", "sarrus", "nfourbar2"])
def test_the_rank_is_that_of_the_compiled_closure(cases: dict[str, Any], name: str) -> None:
    """Two formulations: screws of all joints in world axes, and residuals of short cycles."""
    mechanism, scene = from_reference(cases[name]["spec"])
    sim = lamc.compile(mechanism, replace(scene, rates={} if name == "nfourbar2" else scene.rates))
    assert sim.loops.rank == cases["loop_ranks"]["expected"][name]["rank"]
    geometry = LoopGeometry(plan(mechanism))
    angles = geometry_angles(sim, geometry)
    residual, jacobian = sim.closure(sim.start[: len(sim.joints)])
    assert np.abs(residual).max() <= 1e-11  # both closed to round-off; the file has 15 digits
    basis = geometry.linear(angles).free()
    assert np.abs(jacobian @ basis.T).max() <= 1e-11  # the same null space
    assert np.linalg.matrix_rank(jacobian, tol=1e-9) == sim.loops.rank


def geometry_angles(sim: Simulator, geometry: LoopGeometry) -> np.ndarray[Any, Any]:
    """All joints' angles where a simulator starts."""
    row = sim.run(t_end=0.0, t_eval=[0.0])
    return np.array([row.angle(name)[0] for name in geometry.names])


def test_a_loop_that_fits_badly_is_refused_with_its_misfit(cases: dict[str, Any]) -> None:
    mechanism, scene = tilted(cases["fourbar_crank"], 1e-3)
    with pytest.raises(
        lamc.DesignError, match=r"hinge '[A-D]' closes only within [\d.]+ µm .*closure_tolerance of"
    ):
        lamc.compile(mechanism, scene)


@pytest.mark.parametrize("tilt", [1e-8, 1e-6, 1e-4, 1e-3])
@pytest.mark.quick("1e-06", "0.001")
def test_an_accepted_misfit_runs_as_smoothly_as_none(cases: dict[str, Any], tilt: float) -> None:
    case = cases["fourbar_crank"]
    mechanism, scene = tilted(case, tilt)
    reported = count_loops(plan(mechanism)).misfit
    assert reported is not None
    # An axis that is off by the tilt leaves a gap of no more than its double times the size, and no less than a tenth.
    assert 0.1 * tilt * mechanism.size < reported.gap < 2.1 * tilt * mechanism.size
    aligned = lamc.compile(*from_reference(case["spec"])).run(t_end=1.0, rtol=1e-9, atol=1e-11)
    sim = lamc.compile(mechanism, replace(scene, closure_tolerance=1.01 * reported.gap))
    assert (sim.loops.rank, sim.loops.freedoms) == (3, 1)
    result = sim.run(t_end=1.0, rtol=1e-9, atol=1e-11)
    assert result.success, result.message
    assert result.constraint_error.max() <= 1.01 * reported.gap
    assert result.stats.accepted + (result.stats.rejected or 0) <= 1.1 * aligned.stats.steps
    drift = np.abs(result.energy - result.energy[0]).max() / abs(result.energy[0])
    # Positions that move across an open gap do work of the second order in it; 1e-9 is what the tolerance leaves.
    assert drift <= 1e-9 + 10.0 * tilt**2


def test_the_tolerance_is_the_users(cases: dict[str, Any]) -> None:
    mechanism, scene = tilted(cases["fourbar_crank"], 1e-8)
    assert (
        lamc.compile(mechanism, scene).loops.freedoms == 1
    )  # a gap of 1e-4 of the size passes unless said otherwise
    with pytest.raises(lamc.DesignError, match=r"closes only within [\d.]+ nm"):
        lamc.compile(mechanism, replace(scene, closure_tolerance=0.0))
    with pytest.raises(lamc.DesignError, match="closure_tolerance of a scene is -1"):
        Scene(closure_tolerance=-1.0)


@pytest.mark.parametrize("shift", [1e-6, 1e-4])
def test_a_vertex_whose_creases_do_not_meet_is_reported(shift: float) -> None:
    mechanism = vertex(np.radians([60.0, 75.0, 120.0, 105.0]), shift)
    count = count_loops(plan(mechanism), 0.0)
    assert count.misfit is not None
    assert (count.rank, count.misfit.rank) == (4, 3)
    assert (
        0.1 * shift < count.misfit.gap < 4.0 * shift
    )  # the crease's own offset, and its image by the others
    accepted = count_loops(plan(mechanism), 4.0 * shift)
    assert (accepted.rank, accepted.freedoms, accepted.accepted_gap) == (3, 1, 4.0 * shift)


def test_freedom_that_is_left_without_the_misfit_is_used() -> None:
    """Six creases, one beside the point: exactly taken it costs one of three freedoms."""
    count = count_loops(plan(vertex(np.radians([50.0, 65.0, 70.0, 55.0, 75.0, 45.0]), 1e-4)))
    assert count.misfit is not None
    assert (count.misfit.rank, count.rank, count.freedoms) == (3, 4, 2)
    check_freedom(count)


def test_a_mechanism_without_freedom_is_refused() -> None:
    bodies = (
        Body("ground", fixed=True),
        *(Body(n, 1.0, np.array([0.5, 0.5, 0.0]), np.eye(3)) for n in ("left", "right")),
    )
    z = np.array([0.0, 0.0, 1.0])
    joints = (
        Joint("a", "ground", "left", np.zeros(3), z),
        Joint("b", "ground", "right", np.array([1.0, 0.0, 0.0]), z),
        Joint("c", "left", "right", np.array([0.4, 0.9, 0.0]), z),
    )
    with pytest.raises(
        lamc.DesignError, match="no degree of freedom: its loops put 3 independent equations on 3"
    ):
        lamc.compile(Mechanism(bodies, joints), Scene(effects=()))


@pytest.mark.parametrize("key", ["60,75,120,105", "70,95,80,115"])
def test_a_flat_vertex_has_the_two_published_branches(cases: dict[str, Any], key: str) -> None:
    case = cases["vertex4_flat_branches"]
    sim = compiled(vertex([math.radians(float(angle)) for angle in key.split(",")]))
    found = [[branch.rates[f"c{i}"] for i in range(4)] for branch in sim.branches]
    assert len(found) == 2
    assert np.abs(np.array(found) - case["expected"][key]).max() <= case["tol"]


@settings(max_examples=tries(40), deadline=None)
@given(st.lists(st.floats(20.0, 160.0), min_size=3, max_size=3))
def test_any_flat_vertex_of_four_creases_has_two_branches(three: list[float]) -> None:
    """Below 360° in all, every sector under 180° and no two creases in line: generic. Each branch solves the first and
    second order, which are written out here: Σ ρ e = 0, Σ_{i<j} ρ_i ρ_j e_i × e_j = 0."""
    sectors = np.radians([*three, 360.0 - sum(three)])
    azimuths = np.concatenate([[0.0], np.cumsum(sectors)[:-1]])
    assume(math.radians(20.0) < sectors[3] < math.radians(160.0))
    between = [abs(math.sin(a - b)) for i, a in enumerate(azimuths) for b in azimuths[:i]]
    assume(min(between) > 0.05)
    mechanism = vertex(sectors)
    geometry = LoopGeometry(plan(mechanism))
    branches = find_branches(geometry, np.zeros(4))
    assert len(branches) == 2
    axes = np.array([[math.cos(a), math.sin(a), 0.0] for a in azimuths])
    for branch in branches:
        rho = np.array([branch.rates[f"c{i}"] for i in range(4)])
        assert np.abs(rho).max() == pytest.approx(1.0, abs=1e-12)
        assert np.abs(rho @ axes).max() <= 1e-12  # round-off of four terms of 1
        second = sum(rho[i] * rho[j] * np.cross(axes[i], axes[j]) for j in range(4) for i in range(j))
        assert np.abs(second).max() <= 1e-10  # likewise, over the angle between two creases, 0.05 at least


@settings(max_examples=tries(40), deadline=None)
@given(st.floats(30.0, 150.0), st.floats(30.0, 150.0))
def test_flat_foldable_vertices_fold_by_the_published_multipliers(alpha: float, beta: float) -> None:
    """Kawasaki: opposite sectors sum to 180°. Opposite creases then turn alike, in one pair with opposite signs, and
    half-angle tangents keep the ratio of the rates: p = sin((α-β)/2)/sin((α+β)/2) or its cosine (Evans et al. 2015)."""
    assume(abs(alpha - beta) > 5.0)
    assume(abs(alpha + beta - 180.0) > 5.0)
    a, b = math.radians(alpha), math.radians(beta)
    branches = find_branches(LoopGeometry(plan(vertex([a, b, math.pi - a, math.pi - b]))), np.zeros(4))
    assert len(branches) == 2
    sine = abs(math.sin(0.5 * (a - b)) / math.sin(0.5 * (a + b)))
    cosine = abs(math.cos(0.5 * (a + b)) / math.cos(0.5 * (a - b)))
    expected = sorted([min(sine, 1.0 / sine), min(cosine, 1.0 / cosine)])
    found = []
    for branch in branches:
        rho = [branch.rates[f"c{i}"] for i in range(4)]
        assert abs(rho[0]) == pytest.approx(abs(rho[2]), abs=1e-10)
        assert abs(rho[1]) == pytest.approx(abs(rho[3]), abs=1e-10)
        assert (
            rho[0] * rho[1] * rho[2] * rho[3] < 0.0
        )  # three folds of one sign and one of the other (Maekawa)
        found.append(min(abs(rho[0]), abs(rho[1])))
    assert sorted(found) == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize("name", FLAT)
@pytest.mark.quick("vertex4_flatfoldable", "miura22")
def test_branches_of_flat_origami_are_directions_of_motion(cases: dict[str, Any], name: str) -> None:
    mechanism, _ = from_reference(cases[name]["spec"])
    sim = compiled(mechanism)
    geometry = LoopGeometry(plan(mechanism))
    drawn = np.zeros(len(geometry.names))
    assert geometry.linear(drawn).rank() < sim.loops.rank
    assert sim.branches
    for branch in sim.branches:
        rates = branch.row(geometry.names)
        assert max(branch.rates.values()) == pytest.approx(1.0, abs=1e-12)
        assert np.abs(geometry.linear(drawn).matrix @ rates).max() <= 1e-12  # first order
        assert tangents(geometry, drawn).residual(rates) <= 1e-10  # second order
        # Along a motion the gap at a small angle is of the third order; off all branches it is of the second.
        for rotation in (1e-2, 1e-3):
            assert np.abs(geometry.closure(rotation * rates)[0]).max() <= 2.0 * rotation**2


@pytest.mark.parametrize("name", FLAT)
@pytest.mark.quick("vertex4_flatfoldable", "miura22")
@pytest.mark.ci("vertex4_flatfoldable", "miura*")
def test_a_run_leaves_a_flat_start_on_the_branch_that_was_chosen(cases: dict[str, Any], name: str) -> None:
    mechanism, _ = from_reference(cases[name]["spec"])
    branches = compiled(mechanism).branches
    for number in (k * way for k in range(1, len(branches) + 1) for way in (1, -1)):
        branch = branches[abs(number) - 1]
        lead = max(branch.rates, key=lambda joint: abs(branch.rates[joint]))
        rate = math.copysign(1.0, number) * branch.rates[lead]
        sim = compiled(mechanism, branch=number, rates={lead: rate})
        assert np.abs(sim.start[: len(sim.joints)]).max() == 0.0  # at the singular position itself
        result = sim.run(t_end=0.2, rtol=1e-9, atol=1e-11)
        assert result.success, result.message
        assert result.constraint_error.max() <= 1e-9 * mechanism.size
        early = int(np.searchsorted(result.t, 1e-3))
        for joint, ratio in branch.rates.items():  # after 1e-3 rad: bent by less than a hundredth
            assert result.angle(joint)[early] == pytest.approx(
                result.t[early] * ratio * math.copysign(1.0, number), abs=1e-2 * result.t[early]
            )


def test_a_branch_without_rates_starts_at_rest_a_little_way_out(cases: dict[str, Any]) -> None:
    mechanism, _ = from_reference(cases["miura22"]["spec"])
    first, second = (compiled(mechanism, branch=number) for number in (1, -2))
    for sim, number in ((first, 1), (second, -2)):
        q, u = np.split(sim.start, 2)
        branch = sim.branches[abs(number) - 1]
        ratios = np.array([branch.rates[joint] for joint in sim.joints])
        assert np.abs(u).max() == 0.0
        assert (
            np.abs(q - 1e-3 * math.copysign(1.0, number) * ratios).max() <= 1e-5
        )  # bent by the second order
        assert np.abs(sim.closure(q)[0]).max() <= 1e-13 * mechanism.size


def test_a_crease_whose_sides_run_against_each_other_does_not_close(cases: dict[str, Any]) -> None:
    """Distances and sines between the two sides of a hinge vanish for axes half a turn apart as for none."""
    mechanism, _ = from_reference(cases["vertex4_flatfoldable"]["spec"])
    sim = compiled(mechanism)
    start = np.array([{"c0": 0.9133, "c1": -4.1636, "c2": -3.5428, "c3": 0.0}[joint] for joint in sim.joints])
    hinge = NewtonEuler(mechanism, (), sim.joints)
    q, _, gap = settled(hinge, start, np.zeros(4))
    assert np.abs(hinge.gaps(q)[0]).max() <= 1e-8 * mechanism.size  # what such equations see: nought
    assert gap == math.inf
    assert np.abs(sim.closure(q)[0]).max() > 1.0  # the compiled ones are far from closed there
    angles = {joint: angle for joint, angle in zip(sim.joints, q.tolist(), strict=True) if joint != "c3"}
    with pytest.raises(
        lamc.DesignError, match=r"no position closes the loops .* nearest comes within [\d.]+ m"
    ):
        compiled(mechanism, angles=angles).run(t_end=0.1)


@pytest.mark.parametrize(
    ("scene", "message"),
    [
        ({"branch": 3}, "branch is 3, and the start has 2"),
        ({"rates": {"c1": 1.0}}, "fit 2 of its branches"),
        ({"rates": {"c0": 1.0, "c1": 1.0}}, "lie on none of its branches"),
        ({"branch": 1, "rates": {"c0": 1.0, "c1": 1.0}}, "no motion on branch 1 has the rates given"),
        ({"branch": 1, "angles": {"c0": 0.5}}, "the start is not singular"),
        (
            {"angles": {"c0": 0.5, "c1": 0.5}},
            r"nearest comes within .* m; joint 'c\d' resists: left out, it comes to .* rad instead of 0.5",
        ),
        (
            {"angles": {"c0": 0.5}, "rates": {"c0": 1.0, "c1": 1.0}},
            r"misses them by .* rad/s; joint 'c\d' resists: left out, it comes to .* rad/s instead of 1",
        ),
    ],
)
def test_starts_that_cannot_be_had_are_refused_with_the_reason(scene: dict[str, Any], message: str) -> None:
    sim = compiled(vertex(np.radians([60.0, 75.0, 120.0, 105.0])), **scene)
    with pytest.raises(lamc.DesignError, match=message):
        _ = sim.start


def test_rates_that_fix_the_branch_need_no_choice() -> None:
    sim = compiled(vertex(np.radians([60.0, 75.0, 120.0, 105.0])), rates={"c1": 2.0, "c3": 2.0})
    rates = dict(zip(sim.joints, sim.start[4:], strict=True))
    assert rates["c1"] == pytest.approx(2.0, abs=1e-12)
    assert abs(rates["c0"]) == pytest.approx(2.0 * 0.14128053239285, abs=1e-12)  # the published ratio


def test_a_mechanism_without_loops_has_no_branches() -> None:
    bodies = (Body("ground", fixed=True), Body("flap", 1.0, np.array([0.5, 0.0, 0.0]), np.eye(3)))
    mechanism = Mechanism(bodies, (Joint("h", "ground", "flap"),))
    assert compiled(mechanism).branches == ()
    with pytest.raises(lamc.DesignError, match="branch is 1, and a mechanism without loops has none"):
        compiled(mechanism, branch=1).run(t_end=0.1)
    for wrong in (0, 1.5, True, "1"):
        with pytest.raises(lamc.DesignError, match="branch of a scene is"):
            Scene(branch=wrong)  # type: ignore[arg-type]


def test_starts_are_completed_to_the_nearest_position(cases: dict[str, Any]) -> None:
    """Nearest by squares: the way back to what was wanted is across all motions that the given angle leaves."""
    mechanism, _ = from_reference(cases["fivebar"]["spec"])
    sim = compiled(mechanism, angles={"j1": 0.4})
    geometry = LoopGeometry(plan(mechanism))
    angles = geometry_angles(sim, geometry)
    free = np.array([name != "j1" for name in geometry.names])
    assert angles[np.logical_not(free)][0] == 0.4
    motions = geometry.linear(angles).columns(free).free()
    assert len(motions) == 1  # five joints, one given, three equations
    assert (
        np.abs(motions @ angles[free]).max() <= 1e-7
    )  # rad: a minimum of squares is met to the root of round-off


def test_given_angles_of_cut_joints_count_modulo_a_turn(cases: dict[str, Any]) -> None:
    mechanism, scene = from_reference(cases["fourbar_crank"]["spec"])
    cut = lamc.compile(mechanism, scene).cut_joints[0]
    start = compiled(mechanism, angles={cut: 0.3}).start
    again = compiled(mechanism, angles={cut: 0.3 + 2.0 * math.pi}).start
    assert np.abs(np.remainder(start - again + math.pi, 2.0 * math.pi) - math.pi).max() <= 1e-9  # rad


def test_scenes_carry_branch_and_tolerance_through_files_and_pickles(tmp_path: Path) -> None:
    scene = Scene(effects=(), branch=-2, closure_tolerance=2e-6)
    assert pickle.loads(pickle.dumps(scene)) == scene
    mechanism = replace(vertex(np.radians([60.0, 75.0, 120.0, 105.0])), scene=scene)
    path = tmp_path / "vertex.yaml"
    write_mechanism(mechanism, path)
    loaded = lamc.load(path)
    assert loaded.scene is not None
    assert (loaded.scene.branch, loaded.scene.closure_tolerance) == (-2, 2e-6)


def test_split_and_run_tell_loops_and_branches(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "vertex.yaml"
    write_mechanism(vertex(np.radians([60.0, 75.0, 120.0, 105.0])), path)
    out = ["--out", str(tmp_path / "out")]
    assert main(["split", str(path), *out], standalone_mode=False) == 0
    reported = capsys.readouterr().out
    assert "1 loop: 6 equations of rank 3, 3 redundant" in reported
    assert "branch 1: c0 -0.1413, c1 +1, c2 +0.1413, c3 +1" in reported  # the published ratios
    assert "branch 2: c0 +1, c1 -0.386, c2 +1, c3 +0.386" in reported
    run = ["run", str(path), "--t-end", "0.01", *out]
    assert main(run, standalone_mode=False) == 0
    told = capsys.readouterr().out
    assert "the start is singular and at rest; it takes branch" in told
    assert told.count("the loads do most work; others") == 1
    assert main([*run, "--branch", "-2"], standalone_mode=False) == 0
    assert "branch 2: c0 +1" in capsys.readouterr().out
    manifest = json.loads((tmp_path / "out" / "manifest.json").read_text(encoding="utf-8"))
    assert (manifest["loops"]["rank"], len(manifest["loops"]["branches"])) == (3, 2)


def test_a_misfit_is_told_by_split(
    cases: dict[str, Any], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    mechanism, _ = tilted(cases["fourbar_crank"], 1e-3)
    path = tmp_path / "four_bar.yaml"
    write_mechanism(mechanism, path)
    assert main(["split", str(path), "--out", str(tmp_path / "out")], standalone_mode=False) == 0
    assert "closes only within 77 µm over its motion" in capsys.readouterr().out
