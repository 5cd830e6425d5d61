"""Rank and freedoms of published mechanisms, where they are, and of drawings as people have them."""

import math
import re
from dataclasses import replace

import numpy as np
import pytest

import lamc
from lamc.effects import Gravity
from lamc.loops.at_start import drawn_loops, loops_of
from lamc.loops.geometry import LoopGeometry
from lamc.loops.linear import DENSE, WEAK
from lamc.loops.rank import count_loops
from lamc.mechanism.plan import plan
from lamc.records.mechanism import Array, Mechanism
from lamc.records.scene import Scene
from tests.physics.test_loop_analysis import compiled, vertex
from tests.support.closed_mechanisms import closed_mechanism
from tests.support.ctools import needs_cc
from tests.support.sheets import chain, flat_miura, folded_miura, sheet

Line = tuple[Array, Array]


def bennett(a: float, alpha: float, beta: float, first: float) -> list[Line]:
    """Lines of Bennett's loop A, B, C, D whose link AB is of length `a` (m) and twist `alpha` from the origin along x,
    with its A along z and its angle there `first` (J. E. Baker, The Bennett linkage, Mech. Mach. Theory 14, 1979)."""
    b = a * math.sin(beta) / math.sin(alpha)
    ratio = math.sin(0.5 * (beta + alpha)) / math.sin(0.5 * (beta - alpha))
    second = 2.0 * math.atan(ratio / math.tan(0.5 * first))
    frame, point, lines = np.eye(3), np.zeros(3), []
    steps = ((a, alpha, second), (b, beta, -first), (a, alpha, -second), (b, beta, first))
    for length, twist, angle in steps:
        lines.append((point.copy(), frame[:, 2].copy()))
        point = point + length * frame[:, 0]
        c, s = math.cos(twist), math.sin(twist)
        frame = frame @ np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])
        c, s = math.cos(angle), math.sin(angle)
        frame = frame @ np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    assert np.abs(point).max() < 1e-12, "the loop closes"
    return lines


def goldberg(alpha: float, first_beta: float, second_beta: float, angles: tuple[float, float]) -> Mechanism:
    """Two Bennett loops with one link AB in common, the links behind B made one, and AB taken out (M. Goldberg, New
    five-bar and six-bar linkages in three dimensions, Trans. ASME 65, 1943, 649): five hinges, one freedom."""
    one, two = (
        bennett(1.0, alpha, beta, angle)
        for beta, angle in zip((first_beta, second_beta), angles, strict=True)
    )
    return chain([one[0], one[3], one[2], two[2], two[3]])


def waldron(first: float, second: float) -> Mechanism:
    """Two Bennett loops with one axis in common, turned and shifted along it, each link there made one with a link of
    the other loop, and the common hinge taken out (K. J. Waldron, Hybrid overconstrained linkages, J. Mechanisms 3,
    1968): six hinges, one freedom."""
    one, two = bennett(1.0, 0.7, 1.4, first), bennett(0.8, 0.5, 1.9, second)
    # The second loop's hinge A lies along z at the origin: put there the first loop's D.
    point, axis = one[3]
    side = np.cross(axis, [0.36, 0.48, 0.8])
    side /= np.linalg.norm(side)
    turned = np.column_stack([side, np.cross(axis, side), axis])
    moved = [(point + 0.3 * axis + turned @ p, turned @ d) for p, d in two[1:]]
    return chain([*one[:3], *moved])


SPATIAL = {
    "Bennett": (lambda: chain(bennett(1.0, 0.7, 1.4, 1.1)), 3),
    "Goldberg's five": (lambda: goldberg(0.7, 1.4, 1.9, (1.1, 2.0)), 4),
    "Myard's five": (lambda: goldberg(0.6, 0.5 * math.pi, 0.5 * math.pi, (1.2, -1.2)), 4),
    "Waldron's two loops on one axis": (lambda: waldron(1.1, 2.0), 5),
    "Bricard, line-symmetric": (lambda: closed_mechanism("bricard", 3).mechanism, 5),
    "Sarrus": (lambda: closed_mechanism("sarrus", 3).mechanism, 5),
    "seven hinges anywhere": (lambda: closed_mechanism("spatial", 3).mechanism, 6),
}


@pytest.mark.parametrize("name", sorted(SPATIAL))
def test_overconstrained_loops_have_their_published_freedom(name: str) -> None:
    make, rank = SPATIAL[name]
    count = count_loops(plan(make()))
    assert (count.rank, count.freedoms, count.misfit) == (rank, 1, None)


@pytest.mark.parametrize("count", [2, 3, 4, 8, 16])
@pytest.mark.quick("4", "16")
def test_a_miura_sheet_of_any_size_has_one_freedom(count: int) -> None:
    """Folded: 3 (count - 1)² equations, of which all but one hinge count. From 60 hinges on by sparse elimination."""
    mechanism = sheet(folded_miura(count))
    found = count_loops(plan(mechanism))
    assert (found.freedoms, found.rank) == (1, len(mechanism.joints) - 1)
    assert (len(mechanism.joints) > DENSE) == (count >= 8)


@pytest.mark.parametrize("count", [2, 4, 8])
def test_a_triangulated_sheet_has_three_freedoms_fewer_than_vertices_on_its_edge(count: int) -> None:
    """Of a disk of triangles in general position: creases less three for each inner vertex."""
    points = folded_miura(count) + 0.1 * np.random.default_rng(7).normal(size=(count + 1, count + 1, 3))
    found = count_loops(plan(sheet(points, diagonals=True)))
    assert (found.rank, found.freedoms) == (3 * (count - 1) ** 2, 4 * count - 3)


@pytest.mark.slow
def test_sparse_and_dense_algebra_agree() -> None:
    """Of a closure of 480 hinges near its flat position: small singular values, null space, least change."""
    geometry = LoopGeometry(plan(sheet(folded_miura(16, theta=1e-2))))
    linear = geometry.linear(np.zeros(len(geometry.names)))
    values = np.linalg.svd(linear.matrix.toarray(), compute_uv=False)[::-1]
    known = int(np.count_nonzero(values < WEAK * linear.scale))  # what is beyond is known less exactly
    assert known > 4
    found = linear.weak[0][:known] * linear.scale
    # An iterated value is too large by its share of what is beyond the block, which three rounds leave.
    assert found == pytest.approx(values[:known], rel=1e-5, abs=1e-12)
    goal = linear.matrix @ np.random.default_rng(1).normal(size=linear.count)
    least = np.linalg.lstsq(linear.matrix.toarray(), goal, rcond=1e-9)[0]
    # Twice damped: (1e-5 / 3e-4)^4 of what is weakest.
    assert np.abs(linear.least_change(goal, 1e-9) - least).max() <= 1e-4 * np.abs(least).max()


def map_fold() -> Mechanism:
    """Three facets by two of 10 mm, all creases straight: z{0,1}_{1,2} across, s1_{0,1,2} along."""
    return sheet(1e-2 * np.array([[[j, i, 0.0] for j in range(4)] for i in range(3)]))


def test_a_map_folded_along_its_two_parallel_lines_has_two_freedoms_there() -> None:
    """What folds at a vertex keeps its other two creases flat; of those of two vertices one is the same."""
    scene = Scene(effects=(), angles={"z0_1": 0.7, "z0_2": -0.4, "s1_0": 0.0})
    count = loops_of(plan(map_fold()), scene)
    assert (count.rank, count.freedoms) == (5, 2)
    # The gap that tells the rank: the last singular value that counts, and the first that does not.
    assert count.singular_values[4] > 1e-2
    assert count.singular_values[5] < 1e-14


@needs_cc
def test_a_map_runs_along_its_mode_of_two_freedoms() -> None:
    scene = {"angles": {"z0_1": 0.7, "z0_2": -0.4, "s1_0": 0.0}, "rates": {"z0_1": 1.0, "z0_2": 2.0}}
    sim = compiled(map_fold(), effects=(Gravity((0.0, 0.0, -1.0)),), **scene)
    assert sim.loops.freedoms == 2
    result = sim.run(t_end=0.3)
    assert result.success, result.message
    assert result.stats.singular_steps == 0
    assert np.abs(result.angle("s1_1")).max() <= 1e-12  # the third line stays flat
    assert np.ptp(result.angle("z0_1")) > 0.2
    assert result.constraint_error.max() <= 1e-9 * sim.mechanism.size


RIGID = {
    "three creases": (120.0, 100.0, 140.0),
    "four within half a plane": (30.0, 40.0, 50.0, 240.0),
    "five within half a plane": (30.0, 40.0, 30.0, 50.0, 210.0),
}


@pytest.mark.parametrize("name", sorted(RIGID))
def test_flat_vertices_that_only_shake_are_told_as_rigid(name: str) -> None:
    """Their creases have rates that close to first order, and the second order is definite (R. J. Lang, Twists, Tilings
    and Tessellations, 2018, ch. 9: a vertex folds if its creases are not within half a plane, four at the least)."""
    mechanism = vertex(np.radians(RIGID[name]))
    assert count_loops(plan(mechanism)).freedoms == 0
    with pytest.raises(
        lamc.DesignError, match=r"no degree of freedom.* to first order \d rates? .*none of them goes on"
    ):
        compiled(mechanism)


def test_three_creases_two_of_which_are_one_line_fold_along_it() -> None:
    count = count_loops(plan(vertex(np.radians((180.0, 70.0, 110.0)))))
    assert (count.rank, count.freedoms) == (2, 1)


ROUNDED = [(17.0, decimals) for decimals in (3, 4, 5, 6, 7)] + [(0.0, 3), (61.3, 4), (90.0, 6)]


@pytest.mark.parametrize(("turned", "decimals"), ROUNDED)
@pytest.mark.quick("17.0-3", "17.0-5")
def test_a_rounded_sheet_has_the_branches_and_freedoms_of_the_exact_one(turned: float, decimals: int) -> None:
    exact, branches = drawn_loops(plan(sheet(flat_miura(3, 3))))
    found, rounded = drawn_loops(plan(sheet(flat_miura(3, 3, turned, decimals))))
    assert (exact.rank, found.rank) == (11, 11)
    assert sorted(found.branch_ranks) == sorted(exact.branch_ranks)

    for ours, theirs in zip(rounded, branches, strict=True):  # numbered alike
        assert ours.freedoms == theirs.freedoms
        if ours.freedoms == 1:
            # Vertices off by half a unit of the last decimal, of 25 mm; a root of that where zeros are nearly double.
            allowed = 20.0 * math.sqrt(0.5 * 10.0**-decimals / 25.0)
            apart = [abs(ours.rates[name] - rate) for name, rate in theirs.rates.items()]
            assert max(apart) <= allowed


@needs_cc
@pytest.mark.parametrize("decimals", [3, 5, 7])
@pytest.mark.parametrize("start", ["flat", "folded"])
@pytest.mark.quick("flat-3")
@pytest.mark.ci("flat-3", "flat-7", "folded-5")
def test_a_rounded_sheet_runs_with_no_option(start: str, decimals: int) -> None:
    angles = {} if start == "flat" else {"z0_1": -0.5, "z0_2": 0.5}
    sim = compiled(sheet(flat_miura(3, 3, 17.0, decimals)), effects=(Gravity(),), angles=angles)
    result = sim.run(t_end=0.05, rtol=1e-6, atol=1e-8)
    assert result.success, result.message
    assert result.stats.singular_steps <= 0.1 * result.stats.accepted
    assert result.constraint_error.max() <= sim.loops.accepted_gap


def test_beyond_what_is_accepted_the_message_names_the_place_and_the_gap() -> None:
    """One vertex of a folded sheet, 0.4 mm off."""
    points = 0.02 * folded_miura(3)
    points[1, 2] += (0.0, 0.0, 4e-4)
    with pytest.raises(
        lamc.DesignError,
        match=r"closes only within [\d.]+ mm .*worst around \([-\d., ]+\) mm; .*closure_tolerance",
    ) as caught:
        compiled(sheet(points))
    assert "nothing moves" in str(caught.value)


@pytest.mark.parametrize("name", sorted(set(SPATIAL) - {"seven hinges anywhere"}))
@pytest.mark.parametrize("decimals", [3, 4, 5])
def test_rounded_linkages_in_space_have_their_freedom(name: str, decimals: int) -> None:
    """A tenth of the size, some 100 mm, with hinges between points 20 mm apart that are given in millimetres."""
    make, rank = SPATIAL[name]
    exact = make()

    def rounded(joint: lamc.Joint) -> lamc.Joint:
        ends = [1e-3 * np.round(1e3 * (0.1 * joint.point + k * joint.axis), decimals) for k in (0.0, 0.02)]
        return replace(joint, point=ends[0], axis=ends[1] - ends[0])

    bodies = tuple(replace(body, com=0.1 * body.com) for body in exact.bodies)
    count = count_loops(plan(Mechanism(bodies, tuple(rounded(joint) for joint in exact.joints))))
    assert (count.rank, count.freedoms) == (rank, 1)
    assert count.misfit is not None
    assert 0.0 < count.misfit.gap <= count.tolerance


@needs_cc
def test_a_larger_rounded_sheet_stays_as_closed_as_it_is_accepted() -> None:
    """Sixteen facets, folded by all creases of one row, vertices to a micrometre: 23 equations hold, and what the
    others leave open is within what is accepted."""
    angles = {f"z0_{i}": -0.5 if i % 2 else 0.5 for i in range(1, 4)}
    sim = compiled(sheet(flat_miura(4, 4, 17.0, 3)), effects=(Gravity(),), angles=angles)
    assert (sim.loops.rank, sim.loops.freedoms) == (23, 1)
    result = sim.run(t_end=0.1, rtol=1e-6, atol=1e-8)
    assert result.success, result.message
    assert result.constraint_error.max() <= sim.loops.accepted_gap


@pytest.mark.slow
@needs_cc
def test_a_rounded_sheet_that_cannot_go_on_says_where_and_why() -> None:
    """Three decimals of a millimetre let a falling 3 x 3 sheet fold up to some 170 degrees: there the drawing's misfit
    has grown beyond what any position closes."""
    mechanism = sheet(flat_miura(3, 3, 17.0, 3))
    sim = compiled(mechanism, effects=(Gravity((0.3, 0.2, -9.81)),))
    result = sim.run(t_end=0.5, rtol=1e-6, atol=1e-8)
    assert not result.success
    assert "came apart" in result.message
    found = re.search(r"open by ([\d.]+) µm there, most around \(([^)]+)\) mm as drawn", result.message)
    assert found, result.message
    place = 1e-3 * np.array([float(x) for x in found.group(2).split(",")])
    inner = flat_miura(3, 3, 17.0, 3)[1:-1, 1:-1].reshape(-1, 3)  # m
    assert np.linalg.norm(inner - place, axis=1).min() < 1e-6
    assert "the drawing closes only within" in result.message
    assert np.degrees(np.abs(result.q[-1]).max()) > 160.0
