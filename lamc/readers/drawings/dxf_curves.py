"""Entities of DXF as the lines and curves that they draw, each in its object coordinates taken to the world's.

In: ezdxf's entities. Out: `Course`s. Never: knows layers, blocks or roles.

Object coordinates by the arbitrary axis algorithm, AutoCAD's DXF Reference.
"""

import math
from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np

from lamc.basics.errors import DesignError
from lamc.readers.drawings.courses import SAME, Arc, Course, Points, Spline
from lamc.records.mechanism import Array

_MOST_FIT = 500  # points that a spline passes through: ezdxf solves for them all at once, densely


def object_frame(extrusion: Any, elevation: float = 0.0) -> Array:
    """Object to world coordinates, (4, 4)."""
    from ezdxf.math import OCS

    frame, found = OCS(extrusion), np.eye(4)
    found[:3, :3] = [frame.ux.xyz, frame.uy.xyz, frame.uz.xyz]
    found[3, :3] = elevation * found[2, :3]
    return found


def courses_of(entity: Any) -> list[Course]:
    """An entity's lines, in world coordinates or those of its block. Raises DesignError for what it lacks."""
    return list(_READERS[entity.dxftype()](entity))


def _needed(entity: Any, *names: str) -> list[Any]:
    for name in names:
        if not entity.dxf.hasattr(name):
            raise DesignError(f"it has no {name.replace('_', ' ')}")
    return [entity.dxf.get(name) for name in names]


def _row(point: Any) -> Array:
    return np.array([point[0], point[1], point[2] if len(point) > 2 else 0.0], dtype=float)


def _extrusion(entity: Any) -> Array:
    return object_frame(entity.dxf.extrusion)


def _line(entity: Any) -> Iterator[Course]:
    start, end = _needed(entity, "start", "end")
    yield Course((Points(np.array([_row(start), _row(end)])),))


def _turned(centre: Array, along: Array, across: Array, start: float, end: float) -> Course:
    """An arc with its ends, or all of a circle where its ends are one."""
    arc = Arc(centre, along, across, start, end)
    if abs(end - start) >= 2.0 * math.pi * (1.0 - 1e-12):
        arc = Arc(centre, along, across, start, start + 2.0 * math.pi)
        return Course((Points(arc.at(np.array([start]))), arc), closed=True)
    ends = arc.at(np.array([start, end]))
    return Course((Points(ends[:1]), arc, Points(ends[1:])))


def _circle(entity: Any) -> Iterator[Course]:
    centre, radius = _needed(entity, "center", "radius")
    span = (0.0, 360.0)
    if entity.dxftype() == "ARC":
        start, end = _needed(entity, "start_angle", "end_angle")
        span = (start, start + ((end - start) % 360.0 or 360.0))
    course = _round(_row(centre), np.array([radius, 0.0, 0.0]), 1.0, span)
    yield course.moved(_extrusion(entity))


def _round(centre: Array, along: Array, ratio: float, degrees: tuple[float, float]) -> Course:
    """In a plane of constant z, counterclockwise."""
    across = ratio * np.array([-along[1], along[0], 0.0])
    return _turned(centre, along, across, math.radians(degrees[0]), math.radians(degrees[1]))


def _ellipse(entity: Any) -> Iterator[Course]:
    centre, major, ratio = _needed(entity, "center", "major_axis", "ratio")
    along, normal = _row(major), _row(entity.dxf.extrusion)
    across = np.cross(normal / np.linalg.norm(normal), along) * ratio
    start, end = entity.dxf.start_param, entity.dxf.end_param
    turn = 2.0 * math.pi
    yield _turned(_row(centre), along, across, start, start + ((end - start) % turn or turn))


def _bulged(corners: Sequence[tuple[float, float, float]], closed: bool, z: float = 0.0) -> Course:
    """A polyline of x, y, bulge: the tangent of a quarter of the angle of the arc to the next corner, positive for
    counterclockwise."""
    rows = np.array([(x, y, z) for x, y, _ in corners], dtype=float).reshape(-1, 3)
    parts: list[Points | Arc | Spline] = []
    begun = 0
    for k in range(len(rows) if closed else len(rows) - 1):
        bulge, start, end = corners[k][2], rows[k], rows[(k + 1) % len(rows)]
        chord = end - start
        if bulge == 0.0 or not chord.any():
            continue
        left = np.array([-chord[1], chord[0], 0.0])
        centre = 0.5 * (start + end) + left * (0.25 / bulge - 0.25 * bulge)
        along = start - centre
        across = math.copysign(1.0, bulge) * np.array([-along[1], along[0], 0.0])
        parts += [Points(rows[begun : k + 1]), Arc(centre, along, across, 0.0, 4.0 * abs(math.atan(bulge)))]
        begun = k + 1
    if begun < len(rows):
        parts.append(Points(rows[begun:]))
    return Course(tuple(parts), closed)


def _lwpolyline(entity: Any) -> Iterator[Course]:
    corners = entity.get_points("xyb")
    if len(corners) < 2:
        raise DesignError("it has fewer than two corners")
    yield _bulged(corners, bool(entity.closed), entity.dxf.elevation).moved(_extrusion(entity))


def _polyline(entity: Any) -> Iterator[Course]:
    if entity.is_polygon_mesh or entity.is_poly_face_mesh:
        raise DesignError("it is a mesh; draw its outline")
    # 16: corners of the frame that a spline was made of, which is not drawn.
    corners = [vertex for vertex in entity.vertices if not vertex.dxf.flags & 16]
    if len(corners) < 2:
        raise DesignError("it has fewer than two corners")
    rows = [_row(_needed(vertex, "location")[0]) for vertex in corners]
    if entity.is_3d_polyline:
        yield Course((Points(np.array(rows)),), bool(entity.is_closed))
        return
    z = float(_row(entity.dxf.elevation)[2]) if entity.dxf.hasattr("elevation") else float(rows[0][2])
    flat = [(row[0], row[1], vertex.dxf.bulge) for row, vertex in zip(rows, corners, strict=True)]
    yield _bulged(flat, bool(entity.is_closed), z).moved(_extrusion(entity))


def _spline(entity: Any) -> Iterator[Course]:
    if not entity.control_point_count() and entity.fit_point_count() > _MOST_FIT:
        raise DesignError(f"it has no control points, and more than {_MOST_FIT} points to pass through")
    curve = _curve(entity.construction_tool())
    rows = curve.flat(None)
    apart = float(np.abs(rows[-1] - rows[0]).max())
    yield Course((curve,), closed=apart <= SAME * float(np.abs(rows).max()))


def _curve(tool: Any) -> Spline:
    control = np.array([_row(point) for point in tool.control_points])
    weights = np.array(tool.weights() or np.ones(len(control)), dtype=float)
    knots, degree = np.array(tool.knots(), dtype=float), int(tool.degree)
    if len(knots) != len(control) + degree + 1 or len(weights) != len(control) or degree < 1:
        raise DesignError("its knots, weights and control points do not go together")
    if not (np.isfinite(knots).all() and np.isfinite(weights).all()):
        raise DesignError("its knots and weights must be finite")
    if (np.diff(knots) < 0.0).any() or not knots[degree] < knots[-degree - 1] or not (weights > 0.0).all():
        raise DesignError("its knots must not fall, and its weights must be positive")
    return Spline(np.column_stack([control * weights[:, None], weights]), knots, degree)


def _solid(entity: Any) -> Iterator[Course]:
    rows = np.array([_row(point) for point in entity.wcs_vertices()])
    if len(rows) < 3:
        raise DesignError("it has fewer than three corners")
    yield Course((Points(rows),), closed=True)


def _hatch(entity: Any) -> Iterator[Course]:
    place = object_frame(entity.dxf.extrusion, float(_row(entity.dxf.elevation)[2]))
    for path in entity.paths:
        if path.path_type_flags & 8:  # around a text
            continue
        if hasattr(path, "vertices"):
            if len(path.vertices) > 1:
                yield _bulged(path.vertices, True).moved(place)
        else:
            for edge in path.edges:
                yield _hatch_edge(edge).moved(place)


def _hatch_edge(edge: Any) -> Course:
    kind = edge.EDGE_TYPE
    if kind == "LineEdge":
        return Course((Points(np.array([_row(edge.start), _row(edge.end)])),))
    if kind == "SplineEdge":
        return Course((_curve(edge.construction_tool()),))
    if kind == "ArcEdge":
        along, ratio = np.array([edge.radius, 0.0, 0.0]), 1.0
        span = (edge.start_angle, edge.end_angle)
    else:
        along, ratio = _row(edge.major_axis), edge.ratio
        span = (math.degrees(edge.start_param), math.degrees(edge.end_param))
    return _round(
        _row(edge.center), along, ratio, (span[0], span[0] + ((span[1] - span[0]) % 360.0 or 360.0))
    )


_READERS: dict[str, Callable[[Any], Iterator[Course]]] = {
    "LINE": _line,
    "CIRCLE": _circle,
    "ARC": _circle,
    "ELLIPSE": _ellipse,
    "LWPOLYLINE": _lwpolyline,
    "POLYLINE": _polyline,
    "SPLINE": _spline,
    "SOLID": _solid,
    "TRACE": _solid,
    "HATCH": _hatch,
}
DRAWN = frozenset(_READERS)
