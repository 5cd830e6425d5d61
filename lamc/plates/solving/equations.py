"""What supports ask for: equations between the unknowns of one node.

In: a problem's supports. Out: equations in their order, which may repeat and contradict each other. Never: makes them
independent; `constraints.py` does.

At a node the unknowns (u, v) and (w_x, w_y) are vectors, and a support may hold a part of one along any direction. See
`supports.py` for how edges give directions.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from lamc.basics.checks import Array
from lamc.basics.errors import about
from lamc.plates.dofs import Dofs
from lamc.plates.functions import values_at
from lamc.plates.meshing.mesh import Integers
from lamc.plates.problem import Problem
from lamc.plates.solving.curves import CurveNodes, curve_nodes
from lamc.plates.solving.directions import EdgeNodes, edge_nodes_on
from lamc.plates.supports import Clamped, Hinged, SimplySupported, Support, Symmetry, Where, support_text

PLANE, ACROSS, SLOPE, TWIST = range(4)  # (u, v), w, (w_x, w_y), w_xy
_KIND_OF = {"u": PLANE, "v": PLANE, "w": ACROSS, "w_x": SLOPE, "w_y": SLOPE, "w_xy": TWIST}
_SECOND = ("v", "w_y")
_CORNER_ACROSS = 30.0  # degrees by which edges turn: of two planes of symmetry, of which both hold
# Both slopes vanish where two simple edges meet, but in a blunt corner so slowly, as r^(π/angle - 1), that holding both
# there makes an octagon stiffer by 8 % on 25 cells across; holding the mean direction is within 0.5 %.
_CORNER_ALONG = 80.0


@dataclass(frozen=True, eq=False)
class Equations:
    """direction · (unknowns of that kind at that node) = value; arrays of one length."""

    node: Integers
    kind: Integers
    direction: Array  # (k, 2)
    value: Array
    owner: Integers  # which of the supports asks for it; -1: none does, it keeps a free piece in place


def support_equations(problem: Problem) -> Equations:
    """All that the supports ask for, in their order."""
    found: list[Equations] = []
    for index, support in enumerate(problem.supports):
        with about(support):
            found.extend(_of_support(problem, support, index))
    hard = [
        (index, support.where)
        for index, support in enumerate(problem.supports)
        if isinstance(support, Hinged) or (isinstance(support, SimplySupported) and support.kind == "hard")
    ]
    mirrors = [
        (i, support.where) for i, support in enumerate(problem.supports) if isinstance(support, Symmetry)
    ]
    found.extend(_of_edges(problem, hard, (SLOPE,), across=False))
    found.extend(_of_edges(problem, mirrors, (SLOPE, PLANE), across=True))
    return joined(found)


def held_curves(problem: Problem) -> CurveNodes:
    """Nodes on curved edges along which only the deflection is held."""
    return curve_nodes(
        problem.places, [s.where for s in problem.supports if isinstance(s, SimplySupported | Hinged)]
    )


def joined(parts: Iterable[Equations]) -> Equations:
    """One after the other."""
    items = list(parts)
    if not items:
        none = np.zeros(0, dtype=np.int32)
        return Equations(none, none, np.zeros((0, 2)), np.zeros(0), none)
    return Equations(
        *(
            np.concatenate([getattr(item, name) for item in items])
            for name in ("node", "kind", "direction", "value", "owner")
        )
    )


def equations_of(name: str, nodes: Integers, value: Array | float, owner: int) -> Equations:
    """The unknown `name` of all `nodes` is `value`."""
    direction = (0.0, 1.0) if name in _SECOND else (1.0, 0.0)
    count = len(nodes)
    return Equations(
        np.asarray(nodes, dtype=np.int32),
        np.full(count, _KIND_OF[name], dtype=np.int32),
        np.tile(direction, (count, 1)),
        np.array(np.broadcast_to(value, (count,)), dtype=float),
        np.full(count, owner, dtype=np.int32),
    )


def _of_support(problem: Problem, support: object, index: int) -> list[Equations]:
    """What a support asks for that has no direction of an edge."""
    assert isinstance(support, Support | Clamped | SimplySupported | Symmetry | Hinged)
    nodes = problem.places.nodes(support.where, support_text(support))
    if isinstance(support, Support):
        value = values_at(support.value, problem.dofs.points[nodes], "the value of a Support")
        return [equations_of(name, nodes, value, index) for name in support.dofs]
    names: Sequence[str] = ()
    if isinstance(support, Clamped):
        names = ("u", "v", "w", "w_x", "w_y")
    elif isinstance(support, SimplySupported):
        names = ("w",)
    elif isinstance(support, Hinged):
        names = ("u", "v", "w")
    found = [equations_of(name, nodes, 0.0, index) for name in names]
    if isinstance(support, Clamped | Symmetry):  # the slope across the edge is zero all along it
        found.append(
            equations_of(
                "w_xy", _edge_nodes(problem.dofs, problem.places.edges_on(support.where)), 0.0, index
            )
        )
    return found


def _edge_nodes(dofs: Dofs, edges: Integers) -> Integers:
    return np.unique(dofs.on_edges(edges[:, 0], edges[:, 1])).astype(np.int32)


def _of_edges(
    problem: Problem, wheres: Sequence[tuple[int, Where]], kinds: Sequence[int], *, across: bool
) -> list[Equations]:
    """Along the edges of all `wheres`, or across them, nothing of these kinds; at corners nothing at all."""
    on = edge_nodes_on(problem.places, wheres, _CORNER_ACROSS if across else _CORNER_ALONG)
    first, second = (on.across, on.along) if across else (on.along, on.across)
    if not across and len(on.nodes):
        first, second = _along_curves(problem, on)
    node = np.concatenate([on.nodes, on.nodes[on.corner]])
    direction = np.concatenate([first, second[on.corner]])
    owner = np.concatenate([on.owners, on.owners[on.corner]])
    return [
        Equations(node, np.full(len(node), kind, dtype=np.int32), direction, np.zeros(len(node)), owner)
        for kind in kinds
    ]


def _along_curves(problem: Problem, on: EdgeNodes) -> tuple[Array, Array]:
    """Directions along and across, where a curve is drawn as a polygon those of the curve."""
    curve = held_curves(problem)
    place = np.minimum(np.searchsorted(curve.nodes, on.nodes), max(len(curve.nodes) - 1, 0))
    if not len(curve.nodes):
        return on.along, on.across
    there = ((curve.nodes[place] == on.nodes) & ~on.corner)[:, None]
    return np.where(there, curve.along[place], on.along), np.where(there, curve.across[place], on.across)
