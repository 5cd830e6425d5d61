"""Shapes of the bodies as STL files, for other engines' pictures.

In: a mechanism, and where each body's frame lies. Out: binary STL, m, in the body's frame. Never: computes inertia, or
writes a file.
"""

from collections.abc import Iterator, Mapping

import numpy as np
import shapely
from shapely.geometry import Polygon

from lamc.records.mechanism import Array, Mechanism
from lamc.report.solid import Face, solid_of

_STICK = 0.01  # of the size: half the width of the sticks that stand for bodies without an outline
_TRIANGLE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


def body_meshes(mechanism: Mechanism, origins: Mapping[str, Array]) -> Mapping[str, bytes]:
    """STL by body, for bodies in `origins` that have a shape: (3,), m, world, drawn, where their frames lie."""
    solid = solid_of(mechanism)
    triangles: dict[str, list[Array]] = {name: [] for name in origins}
    for face in solid.faces:
        name = mechanism.bodies[face.body].name
        if name in triangles:
            triangles[name] += _triangles(face)
    for (a, b), index in zip(solid.sticks.segments, solid.sticks.bodies, strict=True):
        name = mechanism.bodies[index].name
        if name in triangles:
            triangles[name] += _stick(a, b, _STICK * solid.size)
    return {name: _stl(np.array(corners) - origins[name]) for name, corners in triangles.items() if corners}


def _triangles(face: Face) -> Iterator[Array]:
    """The face as triangles (3, 3), m, anticlockwise around its outward normal."""
    outer, *holes = face.rings
    if abs(face.normal[2]) < 0.5:  # an upright rectangle
        yield from (outer[[0, 1, 2]], outer[[0, 2, 3]])
        return
    z = outer[0, 2]
    polygon = Polygon(outer[:, :2], [hole[:, :2] for hole in holes])
    for part in shapely.get_parts(shapely.constrained_delaunay_triangles(polygon)):
        corners = np.column_stack([shapely.get_coordinates(part)[:3], np.full(3, z)])
        up = float(np.cross(corners[1] - corners[0], corners[2] - corners[0])[2])
        yield corners if up * face.normal[2] > 0.0 else corners[::-1]


def _stick(a: Array, b: Array, half: float) -> Iterator[Array]:
    """A square bar from a to b, twice `half` wide, as triangles; nothing where the ends meet."""
    along = b - a
    length = float(np.linalg.norm(along))
    if length < half:
        return
    x = np.cross(along, np.eye(3)[int(np.argmin(np.abs(along)))])
    x *= half / float(np.linalg.norm(x))
    y = np.cross(along / length, x)
    low, high = ([end + x, end + y, end - x, end - y] for end in (a, b))
    for quad in (
        low[::-1],
        high,
        *([low[k - 1], low[k], high[k], high[k - 1]] for k in range(4)),
    ):
        yield np.array(quad)[[0, 1, 2]]
        yield np.array(quad)[[0, 2, 3]]


def _stl(corners: Array) -> bytes:
    """Triangles (k, 3, 3), m, as binary STL."""
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    facets = np.zeros(len(corners), dtype=_TRIANGLE)
    facets["normal"] = np.divide(normals, lengths, out=np.zeros_like(normals), where=lengths > 0.0)
    facets["corners"] = corners
    count = len(facets).to_bytes(4, "little")
    return b"made by lamc".ljust(80) + count + bytes(facets.tobytes())
