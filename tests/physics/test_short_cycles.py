"""Short cycles of mechanisms, and what closes along them against another formulation: both sides of the hinges that a
spanning tree leaves out meet."""

import random
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

import lamc
from lamc.examples.miura import miura
from lamc.loops import cycles
from lamc.loops.cycles import Edge, Kind, short_cycles, shortest_basis
from lamc.mechanism.plan import plan
from lamc.readers.load import load_text
from lamc.records.mechanism import Mechanism
from lamc.reference.constrained import split
from lamc.reference.kinematics import motion
from lamc.reference.newton_euler import NewtonEuler
from tests.support.ctools import needs_cc

EXAMPLES = Path(lamc.__file__).parent / "examples"
LOOPS = (
    "bricard",
    "five_bar",
    "folding_box",
    "four_bar",
    "sarrus",
    "six_bar",
    "two_loops",
    "vertex",
    "waterbomb",
)


def mechanism_of(name: str) -> Mechanism:
    design = load_text(miura(3, 3), "miura") if name == "miura" else lamc.load(EXAMPLES / f"{name}.yaml")
    return design if isinstance(design, Mechanism) else lamc.split(design)


@pytest.mark.parametrize(
    ("name", "kinds"),
    [
        ("four_bar", {(Kind.PLANAR, 4): 1}),
        ("six_bar", {(Kind.PLANAR, 4): 2}),
        ("bricard", {(Kind.SPATIAL, 6): 1}),
        ("waterbomb", {(Kind.SPHERICAL, 6): 1}),
        ("folding_box", {(Kind.SPHERICAL, 5): 4}),
        ("miura", {(Kind.SPHERICAL, 4): 4}),
    ],
)
def test_cycles_are_those_that_the_drawing_shows(name: str, kinds: dict[tuple[Kind, int], int]) -> None:
    cycles = short_cycles(plan(mechanism_of(name)))
    assert Counter((cycle.kind, len(cycle.joints)) for cycle in cycles) == kinds


def test_a_basis_is_as_short_as_can_be() -> None:
    """A square net of 4 × 4 nodes has nine faces; a ring of 20 with a chord across has cycles of 11."""
    net = [Edge(4 * i + j, 4 * i + j + 1) for i in range(4) for j in range(3)]
    net += [Edge(4 * i + j, 4 * i + j + 4) for i in range(3) for j in range(4)]
    assert [len(ring) for ring in shortest_basis(tuple(net), tuple(range(len(net))), alike)] == [4] * 9
    ring = [Edge(k, (k + 1) % 20) for k in range(20)] + [Edge(0, 10)]
    assert [len(way) for way in shortest_basis(tuple(ring), tuple(range(21)), alike)] == [11, 11]


def alike(rings: Sequence[tuple[int, ...]]) -> list[int]:
    """As many equations for each ring."""
    return [6] * len(rings)


def test_a_vertex_of_many_creases_is_found_behind_a_short_way_around_all() -> None:
    """Nine facets around a vertex, nine around these, and three around all, next to one another: three hinges lead
    around all, with six equations; nine around the vertex, with three."""
    inner = [Edge(k, (k + 1) % 9) for k in range(9)]
    spokes = [Edge(k, 12 + k) for k in range(9)] + [Edge(12 + k, 9 + k // 3) for k in range(9)]
    outer = [Edge(9 + k, 9 + (k + 1) % 3) for k in range(3)]
    edges = (*inner, *spokes, *outer)
    faces = {frozenset(range(9))}
    for k in range(9):
        after = (k + 1) % 9
        crossed = {k, 9 + k, 18 + k, 9 + after, 18 + after} | ({27 + k // 3} if k % 3 == 2 else set())
        faces.add(frozenset(crossed))

    def equations(rings: Sequence[tuple[int, ...]]) -> list[int]:
        return [3 if frozenset(ring) in faces else 6 for ring in rings]

    basis = shortest_basis(edges, tuple(range(len(edges))), equations)
    assert len(basis) == len(edges) - 21 + 1
    assert {frozenset(ring) for ring in basis} == faces


def annuli(around: int, rows: int, count: int) -> list[Edge]:
    """Rings of facets about holes, each with the next at one facet."""
    edges = []
    for number in range(count):
        first = number * around * rows
        for i in range(rows):
            for k in range(around):
                node = first + i * around + k
                edges.append(Edge(node, first + i * around + (k + 1) % around))
                if i + 1 < rows:
                    edges.append(Edge(node, node + around))
        if number:
            edges.append(Edge(first, first - 1))
    return edges


@pytest.mark.parametrize(("around", "rows", "count"), [(9, 3, 1), (12, 2, 3), (15, 1, 4), (30, 4, 2)])
def test_ways_around_holes_are_as_short_without_all_ways_as_long(
    around: int, rows: int, count: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Horton's candidates within half of the way around a hole hold a basis of least length, as he proved. The few that
    lack within a shorter reach are found by sets of edges that they meet oddly often; whatever the order of edges."""
    edges = annuli(around, rows, count)
    widest = shortest_basis(tuple(edges), tuple(range(len(edges))), alike)
    assert Counter(map(len, widest)) == Counter({4: count * around * (rows - 1), around: count})
    monkeypatch.setattr(cycles, "MOST_LOOKED_AROUND", 0)
    monkeypatch.setattr(cycles, "FAR_REACH", 3)
    rank, chance = list(range(len(edges))), random.Random(3)
    ways = set()
    for _ in range(3):
        basis = shortest_basis(tuple(edges), tuple(rank), alike)
        assert Counter(map(len, basis)) == Counter(map(len, widest))
        assert np.linalg.matrix_rank([[edge in ring for edge in range(len(edges))] for ring in basis]) == len(
            basis
        )
        for ring in basis:
            ends = Counter(end for edge in ring for end in (edges[edge].parent, edges[edge].child))
            assert set(ends.values()) == {2}
            for one, after in zip(ring, (*ring[1:], ring[0]), strict=True):  # in the order of the way
                a, b = edges[one], edges[after]
                assert {a.parent, a.child} & {b.parent, b.child}
        ways.add(frozenset(frozenset(rank[edge] for edge in ring) for ring in basis))
        together = list(zip(edges, rank, strict=True))
        chance.shuffle(together)
        edges, rank = [edge for edge, _ in together], [number for _, number in together]
    assert len(ways) == 1


def test_of_ways_around_a_hole_one_of_few_equations_is_taken(monkeypatch: pytest.MonkeyPatch) -> None:
    """The one farther out, as of a hub: it is not the first of those that are as long."""
    monkeypatch.setattr(cycles, "MOST_LOOKED_AROUND", 0)
    monkeypatch.setattr(cycles, "FAR_REACH", 3)
    edges = tuple(annuli(10, 3, 1))
    outer = frozenset(k for k, edge in enumerate(edges) if min(edge.parent, edge.child) >= 20)
    assert len(outer) == 10

    def equations(rings: Sequence[tuple[int, ...]]) -> list[int]:
        return [3 if frozenset(ring) == outer or len(ring) == 4 else 6 for ring in rings]

    assert outer in {frozenset(ring) for ring in shortest_basis(edges, tuple(range(len(edges))), equations)}


@needs_cc
@pytest.mark.parametrize("name", [*LOOPS, "miura"])
@pytest.mark.quick("five_bar", "four_bar", "sarrus", "six_bar", "two_loops", "vertex", "waterbomb")
def test_positions_rates_and_accelerations_close_the_loops(name: str) -> None:
    mechanism = mechanism_of(name)
    sim = lamc.compile(mechanism)
    other = NewtonEuler(mechanism, (), sim.joints)
    result = sim.run(0.4, rtol=1e-10, atol=1e-12, t_eval=[0.1, 0.2, 0.3, 0.4])
    accelerations = result.motion.accelerations(result.t, np.hstack([result.q, result.u]))
    for q, u, udot in zip(result.q, result.u, accelerations, strict=True):
        closed = other.closure.at(motion(other.links, q, u), q)
        jacobian = closed.jacobian() / mechanism.size
        # Round-off of a projection on other equations of the same closure; rates are some rad/s, accelerations 1e3.
        assert np.abs(closed.residual()).max() < 1e-12 * mechanism.size
        assert np.abs(jacobian @ u).max() < 1e-11 * max(1.0, np.abs(u).max())
        missed = jacobian @ udot + closed.bias() / mechanism.size
        assert np.abs(missed).max() < 1e-10 * max(1.0, np.abs(udot).max())
        assert split(jacobian).rank == sim.loops.rank
