"""The bodies of a mechanism as faces and lines, ready to be posed and drawn.

In: a `Mechanism`. Out: `Solid`, the faces, edges, sticks and hinge lines in the drawn configuration. Layers that lie
on one another with the same outline become one plate, and faces between them, which nobody sees, are left out. It poses
and draws nothing.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from shapely.geometry import LineString, Polygon
from shapely.geometry.base import BaseGeometry
from shapely.geometry.polygon import orient

from lamc.records.mechanism import Array, Body, Joint, Mechanism, Slab

_FINEST = 1 / 2500  # of the device's size: detail and gaps below it are not drawn
_SHARP = np.cos(np.radians(25.0))  # corners turned by less carry no upright edge


@dataclass(frozen=True, eq=False)
class Face:
    """A plane polygon: rings (the outer one first), each (k, 3), m, and the outward unit normal."""

    body: int
    rings: tuple[Array, ...]
    normal: Array
    area: float  # m²


@dataclass(frozen=True, eq=False)
class Lines:
    """Line segments (k, 2, 3), m, and the index of the body that each moves with, (k,)."""

    segments: Array
    bodies: Array


@dataclass(frozen=True, eq=False)
class Solid:
    """A mechanism's shape as drawn, m, world axes. Bodies are numbered as in the mechanism.

    sticks  for bodies without an outline: from their hinges to their centres of mass
    """

    mechanism: Mechanism
    size: float  # m
    faces: tuple[Face, ...]
    edges: Lines
    sticks: Lines
    hinges: Lines


def solid_of(mechanism: Mechanism) -> Solid:
    """The shape of all bodies and hinges."""
    size = _size(mechanism)
    faces: list[Face] = []
    edges: list[tuple[int, Array]] = []
    sticks: list[tuple[int, Array]] = []
    for index, body in enumerate(mechanism.bodies):
        if body.outline:
            plates = _merged(body.outline, _FINEST * size)
            for plate in plates:
                faces += _lids(index, plate, plates, _FINEST * size)
                faces += _sides(index, plate)
                edges += [(index, edge) for edge in _edges(plate)]
        else:
            sticks += [(index, segment) for segment in _sticks(body, mechanism, size)]
    hinges = _hinge_segments(mechanism, size)
    return Solid(mechanism, size, tuple(faces), _lines(edges), _lines(sticks), _lines(hinges))


def _lines(items: Sequence[tuple[int, Array]]) -> Lines:
    segments = np.array([segment for _, segment in items]).reshape(-1, 2, 3)
    return Lines(segments, np.array([body for body, _ in items], dtype=int))


def _size(mechanism: Mechanism) -> float:
    """Diagonal of the box around all outlines, hinge points and centres, m."""
    points = [j.point for j in mechanism.joints] + [b.com for b in mechanism.bodies if not b.fixed]
    for body in mechanism.bodies:
        for plate in body.outline:
            x0, y0, x1, y1 = plate.polygon.bounds
            points += [np.array([x0, y0, plate.z_bottom]), np.array([x1, y1, plate.z_top])]
    return float(np.linalg.norm(np.ptp(np.array(points), axis=0))) or 1.0 if points else 1.0


def _merged(outline: Sequence[Slab], finest: float) -> list[Slab]:
    """Plates on one another with the same outline as one; outlines without invisible detail."""
    merged: list[Slab] = []
    for plate in sorted(outline, key=lambda p: (p.z_bottom, p.polygon.bounds)):
        polygon = _thinned(plate.polygon, finest)
        for k, below in enumerate(merged):
            touches = abs(below.z_top - plate.z_bottom) < finest
            if touches and _nothing(below.polygon.symmetric_difference(polygon), finest):
                merged[k] = Slab(below.polygon, below.z_bottom, plate.z_top)
                break
        else:
            merged.append(Slab(polygon, plate.z_bottom, plate.z_top))
    return merged


def _thinned(polygon: Polygon, finest: float) -> Polygon:
    simple = shapely.simplify(polygon, finest / 2)
    return simple if isinstance(simple, Polygon) and not simple.is_empty else polygon


def _nothing(geometry: BaseGeometry, finest: float) -> bool:
    """True if what there is of it is too thin to be seen."""
    return bool(geometry.buffer(-finest).is_empty)


def _lids(index: int, plate: Slab, plates: Sequence[Slab], finest: float) -> Iterator[Face]:
    """The top and bottom of a plate, without what other plates of the body cover."""
    for z, up in ((plate.z_top, True), (plate.z_bottom, False)):
        covers = [p.polygon for p in plates if p is not plate and _covers(p, z, up, finest)]
        left = plate.polygon.difference(shapely.union_all(covers)) if covers else plate.polygon
        for part in shapely.get_parts(left):
            if isinstance(part, Polygon) and not _nothing(part, finest / 4):
                rings = (part.exterior, *part.interiors)
                normal = np.array([0.0, 0.0, 1.0 if up else -1.0])
                yield Face(index, tuple(_raised(ring.coords, z)[:-1] for ring in rings), normal, part.area)


def _covers(plate: Slab, z: float, up: bool, finest: float) -> bool:
    slack = min(finest, (plate.z_top - plate.z_bottom) / 4)
    if up:
        return plate.z_bottom - slack <= z < plate.z_top - slack
    return plate.z_bottom + slack < z <= plate.z_top + slack


def _sides(index: int, plate: Slab) -> Iterator[Face]:
    """The upright faces; they look to the right of their ring's direction."""
    rotated = orient(plate.polygon)
    for ring in (rotated.exterior, *rotated.interiors):
        bottom, top = _raised(ring.coords, plate.z_bottom), _raised(ring.coords, plate.z_top)
        for k in range(len(bottom) - 1):
            dx, dy, _ = bottom[k + 1] - bottom[k]
            length = float(np.hypot(dx, dy))
            if length > 0.0:
                corners = np.array([bottom[k], bottom[k + 1], top[k + 1], top[k]])
                area = length * (plate.z_top - plate.z_bottom)
                yield Face(index, (corners,), np.array([dy, -dx, 0.0]) / length, area)


def _edges(plate: Slab) -> Iterator[Array]:
    """The outlines of top and bottom, and the upright edges at sharp corners."""
    for ring in (plate.polygon.exterior, *plate.polygon.interiors):
        bottom, top = _raised(ring.coords, plate.z_bottom), _raised(ring.coords, plate.z_top)
        for k in range(len(bottom) - 1):
            yield bottom[k : k + 2]
            yield top[k : k + 2]
            before, after = bottom[k] - bottom[k - 1 if k else -2], bottom[k + 1] - bottom[k]
            if before @ after < _SHARP * np.linalg.norm(before) * np.linalg.norm(after):
                yield np.array([bottom[k], top[k]])


def _raised(coordinates: Sequence[Sequence[float]], z: float) -> Array:
    xy = np.array(coordinates)[:, :2]
    return np.column_stack([xy, np.full(len(xy), z)])


def _sticks(body: Body, mechanism: Mechanism, size: float) -> Iterator[Array]:
    """From each hinge of the body to its centre of mass; a short upright post for a fixed body."""
    for joint in mechanism.joints:
        if body.name in (joint.parent, joint.child):
            end = joint.point - np.array([0.0, 0.0, 0.04 * size]) if body.fixed else body.com
            yield np.array([joint.point, end])


def _hinge_segments(mechanism: Mechanism, size: float) -> list[tuple[int, Array]]:
    """Per joint: the part of its axis where the two bodies meet; it moves with the parent."""
    names = [body.name for body in mechanism.bodies]
    regions = [shapely.union_all([p.polygon for p in body.outline]) for body in mechanism.bodies]
    return [
        (
            names.index(joint.parent),
            _hinge_segment(
                joint, regions[names.index(joint.parent)], regions[names.index(joint.child)], size
            ),
        )
        for joint in mechanism.joints
    ]


def _hinge_segment(joint: Joint, one: BaseGeometry, other: BaseGeometry, size: float) -> Array:
    """The axis within reach of both outlines, else a short piece around the joint's point."""
    if abs(joint.axis[2]) < 1e-6 and not one.is_empty and not other.is_empty:
        far = 2 * size * joint.axis[:2]
        axis = LineString([joint.point[:2] - far, joint.point[:2] + far])
        reach = size / 200
        shared = axis.intersection(one.buffer(reach)).intersection(other.buffer(reach))
        if not shared.is_empty:
            along = [
                (np.array(c) - joint.point[:2]) @ joint.axis[:2] for c in shapely.get_coordinates(shared)
            ]
            return joint.point + np.outer([min(along) + reach, max(along) - reach], joint.axis)
    return joint.point + np.outer([-0.03 * size, 0.03 * size], joint.axis)
