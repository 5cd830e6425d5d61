"""A folded sheet laid flat: facets in space turned into one plane about their creases, and the angles that it had.

In: corners in space, faces, the creases between them. Out: corners in the plane for each face, and the fold angle of
each crease. Never: stretches a facet: a sheet that does not lie flat without a tear is an error that names the crease.
"""

import math
from collections import deque
from collections.abc import Callable, Mapping, Sequence

import numpy as np

from lamc.basics.errors import DesignError
from lamc.readers.fold_faces import Edge, Face
from lamc.records.mechanism import Array

ROUNDING = 1e-4  # of the sheet's size: files have four digits or more of a folded corner
STRETCHED = 0.05  # of the sheet's size: tears beyond are no strain of facets that a program of bars stretched
_BACK = 1e-3  # rad from 180 degrees: which way it was folded is no more to be seen

Beside = Sequence[tuple[int | None, int | None]]
Corners = list[dict[int, Array]]  # for each face, places (2,) by vertex


class TornError(DesignError):
    """A folded sheet that cannot be laid flat: none that was folded from one flat piece, or of too few digits."""


def pair_of(beside: Beside, k: int) -> tuple[int, int]:
    """The faces to the left and right of a joined edge."""
    left, right = beside[k]
    assert left is not None, "a joined edge has two faces"
    assert right is not None, "a joined edge has two faces"
    return left, right


def normals_of(points: Array, faces: Sequence[Face], size: float) -> Array:
    """Unit normals (n, 3), by Newell's sum. Raises DesignError for a face without area or off its plane."""
    found = np.zeros((len(faces), 3))
    for index, face in enumerate(faces):
        ring = points[list(face)]
        from_first = ring - ring[0]
        normal = np.cross(from_first, np.roll(from_first, -1, axis=0)).sum(axis=0)
        length = float(np.linalg.norm(normal))
        if not length > (1e-9 * size) ** 2:
            raise DesignError(f"face {index} has no area")
        found[index] = normal / length
        off = np.abs((ring - ring.mean(axis=0)) @ found[index])
        worst = int(off.argmax())
        if off[worst] > ROUNDING * size:
            raise DesignError(
                f"face {index} is not flat: vertex {face[worst]} lies {off[worst]:.2g} m off its plane; part it by "
                "edges F, U, M or V, or correct the vertex"
            )
    return found


def angles_of(
    points: Array,
    normals: Array,
    edges: Sequence[Edge],
    beside: Beside,
    joined: Sequence[int],
    signs: Mapping[int, float],
) -> dict[int, float]:
    """Fold angles of joined edges, rad, positive for a valley; signs: ±1 by edge, for what is folded by 180 degrees."""
    found = {}
    for k in joined:
        left, right = pair_of(beside, k)
        along = points[edges[k][1]] - points[edges[k][0]]
        if not along.any():
            a, b = edges[k]
            raise DesignError(
                f"edge {k} has no length: its vertices {a} and {b} are at one place; make one vertex of them"
            )
        # A face to the left of an axis along the edge turns about it by the fold angle.
        sine = float(np.cross(normals[right], normals[left]) @ along) / float(np.linalg.norm(along))
        angle = math.atan2(sine, float(normals[right] @ normals[left]))
        if math.pi - abs(angle) < _BACK and k in signs:
            angle = math.copysign(angle, signs[k])
        found[k] = angle
    return found


def laid_flat(
    points: Array,
    faces: Sequence[Face],
    normals: Array,
    edges: Sequence[Edge],
    beside: Beside,
    joined: Sequence[int],
    roots: Sequence[int],
    size: float,
    number: Callable[[int], int] = int,
) -> Corners:
    """Corners in the plane; each root lies where its own plane's axes put it, and pieces side by side along x.
    number: of an edge, as messages name it.

    Raises DesignError where the two sides of a joined edge come to lie apart.
    """
    neighbours: dict[int, list[tuple[int, int]]] = {}
    for k in joined:
        left, right = pair_of(beside, k)
        neighbours.setdefault(left, []).append((right, k))
        neighbours.setdefault(right, []).append((left, k))
    corners: Corners = [{} for _ in faces]
    shift = 0.0
    for root in roots:
        first, second = points[faces[root][0]], points[faces[root][1]]
        length = float(np.linalg.norm(second - first))
        placed = [root]
        start = np.zeros(2)
        corners[root] = _placed(
            points,
            faces[root],
            normals[root],
            (faces[root][0], faces[root][1]),
            start,
            np.array([length, 0.0]),
        )
        queue = deque([root])
        while queue:
            face = queue.popleft()
            for other, k in neighbours.get(face, []):
                if not corners[other]:
                    ends = edges[k]
                    corners[other] = _placed(
                        points,
                        faces[other],
                        normals[other],
                        ends,
                        corners[face][ends[0]],
                        corners[face][ends[1]],
                    )
                    placed.append(other)
                    queue.append(other)
        low = min(float(p[0]) for f in placed for p in corners[f].values())
        high = max(float(p[0]) for f in placed for p in corners[f].values())
        for f in placed:
            corners[f] = {v: p + np.array([shift - low, 0.0]) for v, p in corners[f].items()}
        shift += high - low + 0.1 * size
    _check_closed(corners, edges, beside, joined, size, number)
    return corners


def _placed(
    points: Array, face: Face, normal: Array, ends: Edge, start: Array, end: Array
) -> dict[int, Array]:
    """The face in the plane, its normal up, with the ends of one of its sides given."""
    along = points[ends[1]] - points[ends[0]]
    along = along / np.linalg.norm(along)
    across = np.cross(normal, along)
    flat = (end - start) / np.linalg.norm(end - start)
    aside = np.array([-flat[1], flat[0]])
    offsets = [(v, points[v] - points[ends[0]]) for v in face]
    return {v: start + float(d @ along) * flat + float(d @ across) * aside for v, d in offsets}


def _check_closed(
    corners: Corners,
    edges: Sequence[Edge],
    beside: Beside,
    joined: Sequence[int],
    size: float,
    number: Callable[[int], int],
) -> None:
    for k in joined:
        left, right = pair_of(beside, k)
        for vertex in edges[k]:
            gap = float(np.linalg.norm(corners[left][vertex] - corners[right][vertex]))
            if gap > ROUNDING * size:
                way_out = "cut it along an edge (assignment C), as nets of boxes are"
                if gap < STRETCHED * size:
                    way_out += (
                        "; or take the flat crease pattern, if facets were stretched by the program that folded it, as "
                        "Origami Simulator does"
                    )
                raise TornError(
                    f"the sheet cannot be laid flat: about vertex {vertex} it tears by {gap:.2g} m at edge "
                    f"{number(k)}, so it is none that was folded from one flat piece; {way_out}"
                )
