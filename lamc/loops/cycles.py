"""The short cycles of a mechanism: closed ways over hinges from a body back to itself, a basis of least length.

In: a `Tree`. Out: `Cycle`s, as many as it has cuts, in which each closure equation knows its own few hinges and no
others. In a sheet they are its inner vertices: a way around several of them may be as short, but takes six equations
where that around one takes three. Never: looks at angles; depends on which hinges are cut, or on the order or the
names of what is given.

Cycles of a graph are a vector space over {0, 1}. Horton's candidates, by increasing length, hold a basis of least
total length: an edge and the shortest ways from its ends to a root (J. D. Horton, "A polynomial-time algorithm to
find the shortest cycle basis of a graph", SIAM J. Comput. 16, 1987, 358). Of these, those of three equations come
first.
"""

from collections import deque
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from enum import Enum
from functools import lru_cache

import numpy as np

from lamc.basics.groups import unite
from lamc.basics.once import kept_with
from lamc.mechanism.spanning import geometric_key
from lamc.mechanism.tree import WORLD, Tree
from lamc.records.mechanism import Array
from lamc.records.network import SAME

Ring = tuple[int, ...]  # indices of edges in the order of a closed way

# Of the largest sine: of lines that meet, the first that leans so far from the first one tells the plane of z. The line
# that leans farthest would be another one at another fold angle, and with it the zeros of the equations; neighbours in
# a facet keep their angle.
CLEAR = 0.5
MOST_LOOKED_AROUND = 400  # hinges: of more, longer ways than make a basis take seconds to look for
FIRST_REACH = 3  # hinges from a root: cycles of 6 and most of 7 are among the first candidates
# Hinges from a root, of so many hinges: what is left then are ways around holes, up to so many, whose candidates would
# be all ways as long.
FAR_REACH, FEW_LEFT = 12, 8


class Kind(Enum):
    """What the lines of a cycle's hinges have in common."""

    SPHERICAL = "spherical"  # they meet in a point: three rotations
    PLANAR = "planar"  # they are parallel: one rotation, two displacements
    SPATIAL = "spatial"  # nothing: three rotations, three displacements

    @property
    def equations(self) -> int:
        """How many equations close the cycle."""
        return 6 if self is Kind.SPATIAL else 3


@dataclass(frozen=True, eq=False)
class Cycle:
    """One closed way over hinges, as drawn.

    joints  indices (k,) in the order of the way: tree joints as `tree.links`, then the cut ones as `tree.cuts`
    signs   (k,): +1 where the way goes from the joint's parent to its child, -1 the other way
    kind    what their lines have in common
    centre  (3,), m, world: where they meet; on the first line otherwise
    frame   (3, 3), world from the cycle's frame: columns are its axes. z is normal to all lines where they are
            coplanar, and along them where they are parallel
    """

    joints: tuple[int, ...]
    signs: tuple[int, ...]
    kind: Kind
    centre: Array
    frame: Array


@dataclass(frozen=True)
class Edge:
    """A joint between two nodes of the graph; fixed bodies are one node, WORLD."""

    parent: int
    child: int


def short_cycles(tree: Tree) -> tuple[Cycle, ...]:
    """A basis of least length of the cycles of `tree`, in an order that the geometry gives; found once for each."""
    return kept_with(tree, "_short_cycles", _short_cycles)


def _short_cycles(tree: Tree) -> tuple[Cycle, ...]:
    joints = [link.joint for link in tree.links] + [cut.joint for cut in tree.cuts]
    place = {link.body.name: index for index, link in enumerate(tree.links)}
    edges = [Edge(place.get(j.parent, WORLD), place.get(j.child, WORLD)) for j in joints]
    keys = [geometric_key(joint, tree.mechanism.size) for joint in joints]
    rank = {
        index: position for position, index in enumerate(sorted(range(len(joints)), key=keys.__getitem__))
    }
    axes = np.array([joint.axis for joint in joints]).reshape(-1, 3)
    points = np.array([joint.point for joint in joints]).reshape(-1, 3)
    size = tree.mechanism.size
    ways = shortest_basis(
        tuple(edges),
        tuple(rank[index] for index in range(len(joints))),
        lambda rings: _equations(rings, axes, points, size),
    )
    return tuple(_cycle(way, edges, axes, points, size) for way in ways)


def shortest_basis(
    edges: tuple[Edge, ...], rank: tuple[int, ...], equations: Callable[[Sequence[Ring]], Sequence[int]]
) -> tuple[Ring, ...]:
    """Cycles as rings of edge indices, of least numbers of `equations` of those looked at, then of edges; ties are
    broken by `rank` of these. Those looked at are short ways from some node to both ends of an edge, and the shortest
    ones around few holes."""
    reach, basis, cost = FIRST_REACH, None, 0
    while True:
        candidates = _candidates(edges, rank, reach)
        counts = tuple(equations(candidates))
        wider = _basis(edges, rank, reach, counts)
        if len(wider) < _wanted(edges) and reach >= FAR_REACH and len(edges) > MOST_LOOKED_AROUND:
            wider = _completed(edges, rank, wider, equations)
        if len(wider) == _wanted(edges):
            known = dict(zip(candidates, counts, strict=True))
            costs = [known.get(ring) or equations([ring])[0] for ring in wider]
            if basis is not None and sum(costs) >= cost:
                return basis
            basis, cost = wider, sum(costs)
            # A way of six equations may stand for one of three that is too long to be seen, as around a vertex of many
            # creases.
            if max(costs, default=0) < Kind.SPATIAL.equations or len(edges) > MOST_LOOKED_AROUND:
                return basis
        reach *= 2


@lru_cache(maxsize=4)  # drawings of one topology have one, whatever their numbers
def _basis(
    edges: tuple[Edge, ...], rank: tuple[int, ...], reach: int, equations: tuple[int, ...]
) -> tuple[Ring, ...]:
    """That of the candidates within reach, which may be too few."""
    candidates = _candidates(edges, rank, reach)
    order = sorted(range(len(candidates)), key=equations.__getitem__)  # stable: the shorter ones first
    return tuple(_independent([candidates[k] for k in order], _wanted(edges)))


@lru_cache(maxsize=4)
def _wanted(edges: tuple[Edge, ...]) -> int:
    """How many cycles a basis has."""
    nodes = _nodes(edges)
    return len(edges) - len(nodes) + _pieces(nodes, edges)


def _completed(
    edges: tuple[Edge, ...],
    rank: tuple[int, ...],
    basis: tuple[Ring, ...],
    equations: Callable[[Sequence[Ring]], Sequence[int]],
) -> tuple[Ring, ...]:
    """The basis with the few rings that it lacks, of least equations and then of edges among the shortest ones through
    each node; as it is where they are many.

    Of independent sets of edges that meet each ring of the basis evenly often, a ring that meets one of them oddly
    often is independent of the basis. The others are changed to meet it evenly (J. C. de Pina, "Applications of
    shortest path methods", 1995; T. Kavitha et al., "Cycle bases in graphs", 2009, section 4).
    """
    if _wanted(edges) - len(basis) > FEW_LEFT:
        return basis
    at = _incidence(_nodes(edges), edges, rank)
    sets, found = _across(edges, rank, basis), list(basis)
    for number, across in enumerate(sets):
        odd = {edge for edge in range(len(edges)) if across >> rank[edge] & 1}
        ways = (_odd_way(node, at, odd) for node in {edges[edge].parent for edge in odd})
        rings = list({_from_least(way, rank) for way in ways if way is not None})
        counts = dict(zip(rings, equations(rings), strict=True))
        found.append(min(rings, key=lambda ring: (counts[ring], len(ring), [rank[edge] for edge in ring])))
        met = sum(1 << rank[edge] for edge in found[-1])
        for later in range(number + 1, len(sets)):
            if (sets[later] & met).bit_count() % 2:
                sets[later] ^= across
    return tuple(found)


def _across(edges: Sequence[Edge], rank: Sequence[int], basis: Sequence[Ring]) -> list[int]:
    """Independent sets of edges that meet each ring of the basis evenly often, and not all rings; as whole numbers with
    a bit at the rank of each edge. None has an edge of a spanning tree, so that there are as many as rings lack."""
    nodes = _nodes(edges)
    place, head = {node: index for index, node in enumerate(nodes)}, list(range(len(nodes)))
    beside = 0  # edges beside the tree
    for index in sorted(range(len(edges)), key=rank.__getitem__):
        if not unite(head, place[edges[index].parent], place[edges[index].child]):
            beside |= 1 << rank[index]
    rows: dict[int, int] = {}  # by leading bit; no other row has it
    for ring in basis:
        row = sum(1 << rank[edge] for edge in ring) & beside
        for lead, known in rows.items():
            if row >> lead & 1:
                row ^= known
        lead = row.bit_length() - 1
        for other, known in rows.items():
            if known >> lead & 1:
                rows[other] = known ^ row
        rows[lead] = row
    free = [k for k in range(len(edges)) if beside >> k & 1 and k not in rows]
    return [(1 << k) | sum(1 << lead for lead, row in rows.items() if row >> k & 1) for k in free]


def _odd_way(start: int, at: dict[int, list[tuple[int, int]]], odd: set[int]) -> list[int] | None:
    """The shortest closed way from a node that passes edges of a set oddly often; None where it passes a node twice."""
    before: dict[tuple[int, bool], tuple[int, tuple[int, bool]]] = {(start, False): (-1, (start, False))}
    queue, goal = deque(before), (start, True)
    while queue and goal not in before:
        state = queue.popleft()
        for edge, far in at[state[0]]:
            reached = far, state[1] ^ (edge in odd)
            if reached not in before:
                before[reached] = edge, state
                queue.append(reached)
    way, nodes, state = [], set(), goal
    while state in before and before[state][0] >= 0:
        edge, state = before[state]
        way.append(edge)
        nodes.add(state[0])
    return way if way and len(nodes) == len(way) else None


def _from_least(way: list[int], rank: Sequence[int]) -> Ring:
    """The same closed way from its edge of least rank on, towards that of its neighbours of lesser rank."""
    first = min(range(len(way)), key=lambda k: rank[way[k]])
    turned = way[first:] + way[:first]
    return tuple(turned if rank[turned[1]] < rank[turned[-1]] else [turned[0], *reversed(turned[1:])])


def _independent(candidates: Sequence[Ring], wanted: int) -> list[Ring]:
    """The first `wanted` of the candidates that are independent over {0, 1}, by elimination on whole numbers."""
    pivots: dict[int, int] = {}
    basis: list[Ring] = []
    for ring in candidates:
        if len(basis) == wanted:
            break
        rest = sum(1 << edge for edge in ring)
        while rest:
            lead = rest.bit_length()
            if lead not in pivots:
                pivots[lead] = rest
                basis.append(ring)
                break
            rest ^= pivots[lead]
    return basis


@lru_cache(maxsize=4)
def _candidates(edges: tuple[Edge, ...], rank: tuple[int, ...], reach: int) -> tuple[Ring, ...]:
    """Rings of at most 2 reach + 1 edges that a root and an edge give, the shortest first."""
    nodes = _nodes(edges)
    at = _incidence(nodes, edges, rank)
    found: dict[frozenset[int], Ring] = {}
    for root in nodes:
        for ring in _rings(root, edges, at, reach):
            found.setdefault(frozenset(ring), ring)
    return tuple(sorted(found.values(), key=lambda ring: (len(ring), sorted(rank[edge] for edge in ring))))


def _nodes(edges: Sequence[Edge]) -> list[int]:
    return sorted({end for edge in edges for end in (edge.parent, edge.child)})


def _rings(
    root: int, edges: Sequence[Edge], at: dict[int, list[tuple[int, int]]], reach: int
) -> Iterator[Ring]:
    """Rings of an edge and the ways from its ends to `root`, where these share nothing but the root."""
    before: dict[int, tuple[int, int]] = {
        root: (-1, root)
    }  # node → the edge that reached it, the node before
    depth = {root: 0}
    limb = {root: -1}  # the first edge of the way from the root
    queue = deque([root])
    while queue:
        node = queue.popleft()
        if depth[node] == reach:
            continue
        for edge, far in at[node]:
            if far not in depth:
                before[far], depth[far] = (edge, node), depth[node] + 1
                limb[far] = edge if node == root else limb[node]
                queue.append(far)
    for index in sorted({edge for node in depth for edge, _ in at[node]}):
        a, b = edges[index].parent, edges[index].child
        if a not in depth or b not in depth or index in (before[a][0], before[b][0]):
            continue
        if limb[a] != limb[b] or root in (a, b):
            yield (*reversed(_way(a, before)), index, *_way(b, before))


def _way(node: int, before: dict[int, tuple[int, int]]) -> list[int]:
    """Edges from a node back to the root."""
    way = []
    while before[node][0] >= 0:
        edge, node = before[node]
        way.append(edge)
    return way


def _incidence(
    nodes: Sequence[int], edges: Sequence[Edge], rank: Sequence[int]
) -> dict[int, list[tuple[int, int]]]:
    """Node → (edge, node at its other end), in the order of `rank`."""
    at: dict[int, list[tuple[int, int]]] = {node: [] for node in nodes}
    for index in sorted(range(len(edges)), key=rank.__getitem__):
        edge = edges[index]
        at[edge.parent].append((index, edge.child))
        at[edge.child].append((index, edge.parent))
    return at


def _pieces(nodes: Sequence[int], edges: Sequence[Edge]) -> int:
    """How many pieces the graph has."""
    place = {node: index for index, node in enumerate(nodes)}
    head = list(range(len(nodes)))
    for edge in edges:
        unite(head, place[edge.parent], place[edge.child])
    return sum(each == index for index, each in enumerate(head))


def _cycle(ring: Ring, edges: Sequence[Edge], axes: Array, points: Array, size: float) -> Cycle:
    signs = _directions(ring, edges)
    axes, points = axes[list(ring)], points[list(ring)]
    kind, centre = _kind(axes, points, size)
    return Cycle(ring, signs, kind, centre, _frame(kind, axes, points - centre, size))


def _directions(ring: Ring, edges: Sequence[Edge]) -> tuple[int, ...]:
    """Whether each edge of a ring is passed from its parent to its child."""
    if len(ring) == 2:  # two joints between the same bodies: out by the first, back by the second
        back = -1 if edges[ring[1]].parent == edges[ring[0]].parent else 1
        return (1, back)
    first, second = edges[ring[0]], edges[ring[1]]
    node = first.child if first.child in (second.parent, second.child) else first.parent
    signs = [1 if node == first.child else -1]
    for index in ring[1:]:
        forth = edges[index].parent == node
        signs.append(1 if forth else -1)
        node = edges[index].child if forth else edges[index].parent
    return tuple(signs)


def _equations(rings: Sequence[Ring], axes: Array, points: Array, size: float) -> list[int]:
    """How many equations close each ring: as `_kind` would say of it, thousands at once."""
    found = np.full(len(rings), Kind.SPATIAL.equations)
    across = np.eye(3) - axes[:, :, None] * axes[:, None, :]
    feet = np.einsum("jab,jb->ja", across, points)
    lengths = np.array([len(ring) for ring in rings])
    for length in sorted(set(lengths.tolist())):
        rows = np.flatnonzero(lengths == length)
        own = np.array([rings[row] for row in rows.tolist()])
        leans = np.abs(np.cross(axes[own], axes[own[:, :1]])).max(axis=(1, 2)) > SAME
        found[rows[~leans]] = Kind.PLANAR.equations
        rows, own = rows[leans], own[leans]
        # As in `_kind`, lines that are hardly not parallel included, of which any point will do.
        centre = np.linalg.pinv(across[own].sum(axis=1), hermitian=True) @ feet[own].sum(axis=1)[..., None]
        apart = np.linalg.norm((across[own] @ centre[:, None])[..., 0] - feet[own], axis=2).max(axis=1)
        found[rows[apart <= SAME * size]] = Kind.SPHERICAL.equations
    return found.tolist()


def _kind(axes: Array, points: Array, size: float) -> tuple[Kind, Array]:
    """What lines have in common, and where they meet, m."""
    if np.abs(np.cross(axes, axes[0])).max() <= SAME:
        return Kind.PLANAR, points[0]
    across = np.eye(3) - axes[:, :, None] * axes[:, None, :]
    centre = np.linalg.lstsq(across.sum(axis=0), np.einsum("jab,jb->a", across, points), rcond=None)[0]
    apart = np.linalg.norm(np.einsum("jab,jb->ja", across, centre - points), axis=1).max()
    return (Kind.SPHERICAL, centre) if apart <= SAME * size else (Kind.SPATIAL, points[0])


def _frame(kind: Kind, axes: Array, arms: Array, size: float) -> Array:
    """Axes that leave zeros: z normal to the plane of all lines, if there is one, else along the first line."""
    first = axes[0]
    if kind is Kind.PLANAR:
        z, x = first, _perpendicular(first)
    else:
        crossed = np.cross(first, axes)
        sines = np.linalg.norm(crossed, axis=1)
        clear = CLEAR if kind is Kind.SPHERICAL else 1.0
        z = crossed[int(np.argmax(sines >= clear * sines.max()))]
        z, x = z / np.linalg.norm(z), first
        flat = np.abs(axes @ z).max() <= SAME and np.abs(arms @ z).max() <= SAME * size
        if not flat:
            z, x = first, z
    return np.column_stack([x, np.cross(z, x), z])


def _perpendicular(z: Array) -> Array:
    """A unit vector across z."""
    least = np.eye(3)[int(np.argmin(np.abs(z)))]
    x = np.cross(z, least)
    return np.asarray(x / np.linalg.norm(x))
