"""A mechanism whose bodies are facets of one sheet: their common corners, and which hinge lies on which edge.

In: a mechanism with outlines. Out: vertices, faces, edges, and what is not that of a sheet of one card. It moves
nothing: facets keep their corners to the last digit.
"""

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree
from shapely.geometry import Polygon
from shapely.geometry.polygon import orient

from lamc.basics.errors import UnsupportedError
from lamc.design.mass import body_properties
from lamc.readers.fold_groups import pieces_of
from lamc.records.card import Card
from lamc.records.mechanism import Array, Body, Mechanism
from lamc.records.network import listed_names

_NEAR = 1e-9  # of the size: corners that are one
_SAME = 1e-9  # of masses and inertias: what is read back is the same device

Corner = tuple[int, int]  # a face, and which of its corners


@dataclass(frozen=True)
class Edge:
    """ends: vertices. joint: index of the mechanism's; None: within a body, or on the rim. inner: between two faces
    that hold together. face: one beside it; is_left: to the left, from the first end to the second."""

    ends: tuple[int, int]
    joint: int | None
    inner: bool
    face: int
    is_left: bool


class CreasedSheet:
    """Facets of a mechanism with their common corners.

    vertices  (n, 2), m; owner: a face of each
    faces     by vertices; bodies: the body of each, an index
    edges     each once; those of two facets that are apart twice, with vertices of their own
    spots     by vertex: the row of `places`, (k, 2), m, that all vertices at one place share
    height    m, of the hinges' lines
    card      that all bodies are of
    lost      what is not that of a sheet of one card, in words; faults: of it what makes the mechanism no sheet
    windows   rings of holes within facets, m
    """

    def __init__(self, mechanism: Mechanism, what: str) -> None:
        """what: that is written, "FOLD holds". Raises UnsupportedError where there is no outline."""
        self.mechanism = mechanism
        outlined = [(k, p) for k, body in enumerate(mechanism.bodies) for p in _facets(body)]
        if not outlined:
            raise UnsupportedError(f"no body has an outline, so there is nothing to draw; {what} flat facets")
        self.bodies = [k for k, _ in outlined]
        self.rings = [np.array(orient(p).exterior.coords)[:-1, :2] for _, p in outlined]
        self.windows = [np.array(ring.coords)[:-1, :2] for _, p in outlined for ring in p.interiors]
        self.card, self.lost = _card(mechanism)
        self.faults = [] if self.card else list(self.lost)
        self.height = 0.5 * self.card.thickness if self.card else 0.0
        self._between: dict[frozenset[str], list[int]] = {}
        for k, joint in enumerate(mechanism.joints):
            self._between.setdefault(frozenset((joint.parent, joint.child)), []).append(k)
        self._join()
        drawn = {edge.joint for edge in self.edges}
        bare = [joint.name for k, joint in enumerate(mechanism.joints) if k not in drawn]
        if bare:
            self.faults.append(
                f"hinges without a common side of their bodies, as gaps leave them: {listed_names(bare)}"
            )
            self.lost.append(self.faults[-1])
        middle = _middle(mechanism)
        high = [j.name for j in mechanism.joints if abs(j.point[2] - middle) > _NEAR * mechanism.size]
        if self.card and high:
            self.lost.append(f"hinges elsewhere than in the middle of the card: {listed_names(high)}")
        self.lost += [f"limits of hinge {joint.name!r}" for joint in mechanism.joints if joint.is_limited]

    def _join(self) -> None:
        """`vertices` (n, 2), m; `faces`, by vertices; `edges`."""
        corners = [(f, k) for f, ring in enumerate(self.rings) for k in range(len(ring))]
        index = {corner: k for k, corner in enumerate(corners)}
        places = np.concatenate(self.rings)
        size = float(np.linalg.norm(np.ptp(places, axis=0)))
        near = cKDTree(places).query_pairs(_NEAR * size)
        spot = {k: group[0] for group in pieces_of(range(len(corners)), near) for k in group}
        sides: dict[tuple[int, int], tuple[Corner, Corner]] = {}
        for face, ring in enumerate(self.rings):
            for k in range(len(ring)):
                a, b = (face, k), (face, (k + 1) % len(ring))
                sides[spot[index[a]], spot[index[b]]] = (a, b)
        pairs: list[tuple[int, int]] = []
        joined: dict[tuple[Corner, Corner], int | None] = {}
        for (p, q), (a, b) in sides.items():
            other = sides.get((q, p))
            if other is None:
                continue
            one, two = self.bodies[a[0]], self.bodies[other[0][0]]
            joint = None if one == two else self._joint(one, two, places[p], places[q], size)
            if one == two or joint is not None:
                pairs += [(index[a], index[other[1]]), (index[b], index[other[0]])]
                joined[a, b] = joint
        number: dict[int, int] = {}
        for group, found in enumerate(pieces_of(range(len(corners)), pairs)):
            number |= dict.fromkeys(found, group)
        first = {number[k]: k for k in reversed(range(len(corners)))}
        self.vertices = places[[first[v] for v in range(len(first))]]
        self.places = places
        self.spots = [spot[first[v]] for v in range(len(first))]
        self.owner = [corners[first[v]][0] for v in range(len(first))]
        self.faces = [[number[index[f, k]] for k in range(len(ring))] for f, ring in enumerate(self.rings)]
        edges: dict[tuple[int, int], Edge] = {}
        for a, b in sides.values():
            ends = (number[index[a]], number[index[b]])
            key = (min(ends), max(ends))
            if key not in edges or (a, b) in joined:
                known = (a, b) in joined
                edges[key] = Edge(key, joined.get((a, b)), known, a[0], ends == key)
        self.edges = list(edges.values())

    def _joint(self, one: int, two: int, start: Array, end: Array, size: float) -> int | None:
        names = frozenset(self.mechanism.bodies[k].name for k in (one, two))
        along = np.array([*(end - start), 0.0])
        for k in self._between.get(names, ()):
            joint = self.mechanism.joints[k]
            arm = np.array([*start, joint.point[2]]) - joint.point
            apart = np.linalg.norm(np.cross(arm, joint.axis)) + np.linalg.norm(np.cross(along, joint.axis))
            if apart <= 1e-6 * size:
                return k
        return None

    def sign(self, edge: Edge) -> float:
        """1 where a positive angle of the edge's hinge is a valley, seen from above, -1 where it is a mountain: the
        child lies to the left of the axis, or to its right."""
        assert edge.joint is not None
        joint = self.mechanism.joints[edge.joint]
        start, end = self.vertices[list(edge.ends)]
        is_along = float((end - start) @ joint.axis[:2]) > 0.0
        is_child = self.mechanism.bodies[self.bodies[edge.face]].name == joint.child
        return 1.0 if is_along == (is_child == edge.is_left) else -1.0


def _middle(mechanism: Mechanism) -> float:
    """m, of the card's height, where a sheet's hinges are; of several heights, of any."""
    slab = next(slab for body in mechanism.bodies for slab in body.outline)
    return 0.5 * (slab.z_bottom + slab.z_top)


def _facets(body: Body) -> list[Polygon]:
    """Polygons of a body as seen from above: the slabs between two heights that have the largest area in all."""
    levels: dict[tuple[float, float], list[Polygon]] = {}
    for slab in body.outline:
        levels.setdefault((slab.z_bottom, slab.z_top), []).append(slab.polygon)
    return max(levels.values(), key=lambda found: sum(p.area for p in found), default=[])


def _card(mechanism: Mechanism) -> tuple[Card | None, list[str]]:
    """The card that all bodies are of, and what keeps them from it."""
    slabs = [slab for body in mechanism.bodies for slab in body.outline]
    heights = {(slab.z_bottom, slab.z_top) for slab in slabs}
    if len(heights) > 1:
        return None, ["layers of several heights"]
    (bottom, top) = next(iter(heights))
    masses = [
        (b.mass, sum(s.polygon.area for s in b.outline)) for b in mechanism.bodies if b.mass and b.outline
    ]
    density = masses[0][0] / (masses[0][1] * (top - bottom)) if masses else Card().density
    other = []
    for body in mechanism.bodies:
        if not body.fixed and body.outline:
            mass, com, inertia = body_properties([(slab, density) for slab in body.outline])
            scale = float(np.abs(inertia).max())
            same = abs(mass - body.mass) <= _SAME * mass and np.abs(com - body.com).max() <= _SAME
            if not (same and np.abs(inertia - body.inertia).max() <= _SAME * scale):
                other.append(body.name)
    lost = [f"masses that are not those of one card: {listed_names(other)}"] if other else []
    if bottom != 0.0:
        lost.append("facets that do not lie on z = 0")
    return Card(top - bottom, density), lost
