"""Hinges between bodies of one plate as lines: the links reach up to the line, and a spring stands for the strip.

In: the hinges, regions of equal stack in which the strips that bend are regions of their own, and the plate's outline.
Out: regions without strips, each half given to the stack beside it; a `HingeLine` for each hinge. Never: meshes.

The strip that bends is two hinge widths wide, and its rotation is that of a spring at its middle. What the links gain
in length, one width each, bends as they do. The line's axis is in the plate's reference surface.
"""

from collections.abc import Callable, Mapping, Sequence

import numpy as np
import shapely
from shapely.geometry import LineString, MultiLineString, MultiPoint, MultiPolygon
from shapely.geometry.base import BaseGeometry

from lamc.basics.checks import Array
from lamc.plates.answers.hinge_stiffness import hinge_stiffness
from lamc.plates.designs.hinge_edges import PlateHinge
from lamc.plates.designs.materials import ply_angle
from lamc.plates.designs.overlay import Stack, areas_of, polygons_of
from lamc.plates.hinge_lines import HingeLine
from lamc.plates.laminates.laminate import Laminate
from lamc.plates.laminates.materials import Material
from lamc.plates.laminates.plies import Ply
from lamc.records.design import Design

_WIDE = 1.5  # hinge widths beside the line that surely hold half a strip
_STRAIGHT = 1e-10  # of the size: corners nearer to a straight edge are left over from a strip's ends
_GRID = 1e-6  # hinge widths between coordinates of what is joined
_BESIDE = 1e-2  # of a hinge width: what is nearer touches
_STRIP = "hinge "  # how names of strips begin

Stacks = Mapping[str, tuple[Stack, MultiPolygon]]


def strip_name(joint: str) -> str:
    """What the region of a strip is called."""
    return f"{_STRIP}{joint}"


def is_strip(region: str) -> bool:
    """Whether a region of a body is called as a strip is; layers are called otherwise."""
    return region.startswith(_STRIP)


def without_strips(stacks: Stacks, hinges: Sequence[PlateHinge]) -> dict[str, tuple[Stack, MultiPolygon]]:
    """Each half of a strip goes to the stack with which it shares most of its edge; where none is, it stays."""
    found = dict(stacks)
    for hinge in hinges:
        name = strip_name(hinge.name)
        if name not in found:
            continue
        layers, strip = found.pop(name)
        given: dict[str, list[BaseGeometry]] = {}
        for side in (1.0, -1.0):
            half = shapely.intersection(strip, hinge.band(0.0, side * _WIDE))
            for piece in polygons_of(half):
                near = shapely.buffer(piece, _BESIDE * hinge.width)
                shared = [(shapely.intersection(near, area).area, key) for key, (_, area) in found.items()]
                most, key = max(shared, key=lambda pair: pair[0], default=(0.0, name))
                given.setdefault(key if most > 0.0 else name, []).append(piece)
        for key, pieces in given.items():
            stack, area = found.get(key, (layers, MultiPolygon()))
            grid = _GRID * hinge.width
            joined = shapely.union_all([area, *pieces], grid_size=grid)
            # Back to where the neighbours' corners are: borders that part by a grid's step are meshed as gaps.
            beside = shapely.get_coordinates([a for name, (_, a) in found.items() if name != key])
            joined = shapely.snap(joined, MultiPoint(beside), grid)
            straight = _STRAIGHT * float(np.ptp(np.reshape(joined.bounds, (2, 2)), axis=0).max())
            found[key] = (stack, areas_of(shapely.simplify(joined, straight)))
    return found


def line_of(
    hinge: PlateHinge,
    regions: Mapping[str, BaseGeometry],
    design: Design,
    materials: Callable[[Sequence[int]], Mapping[str, Material]],
    tolerance: float,
) -> tuple[HingeLine, str]:
    """The line of a hinge within the plate, with the stiffness of the joint over its length, or else of its strip by
    the formula of `hinge_stiffness`; and a note, "" for none.

    tolerance  m: by so little corners of regions may lie beside the line, which then goes through them
    """
    outline = shapely.union_all(list(regions.values()))
    corners = np.unique(shapely.get_coordinates(list(regions.values())), axis=0)
    parts = [shapely.intersection(part, outline) for part in hinge.free]
    lines = [
        _through(line, corners, tolerance)
        for part in parts
        for line in shapely.get_parts(part)
        if line.length > 2.0 * tolerance
    ]
    where = lines[0] if len(lines) == 1 else MultiLineString(lines)
    length = float(where.length)
    if hinge.properties.stiffness > 0.0:
        return HingeLine(where, hinge.properties.stiffness / length, hinge.name), ""
    layer = design.layers[hinge.layer]
    (x0, y0), (x1, y1) = np.array(LineString(hinge.free[0]).coords)[[0, -1]]
    angle = ply_angle(layer, float(np.degrees(np.arctan2(y1 - y0, x1 - x0))) - 90.0)
    material = materials([hinge.layer])[layer.material.name]
    strip = Laminate([Ply(material, layer.thickness, angle)])
    found = hinge_stiffness(strip, 2.0 * hinge.width, length, cells=0)
    note = (
        f"hinge {hinge.name!r} has no stiffness of its own; its line has that of its strip by the formula of a "
        f"{found.formula}, {found.value:.4g} N·m/rad"
    )
    return HingeLine(where, found.value / length, hinge.name), note


def _through(line: LineString, corners: Array, tolerance: float) -> LineString:
    """A straight line by way of the corners (k, 2) beside it, in place of its ends where these are near."""
    ends = np.array(line.coords)[[0, -1]]
    near = corners[shapely.dwithin(line, shapely.points(corners), tolerance)]
    apart = np.linalg.norm(ends[:, None] - near[None], axis=2)
    kept = ends[(apart > tolerance).all(axis=1)]
    points = np.concatenate([near, kept])
    along = (points - ends[0]) @ (ends[1] - ends[0])
    order = np.argsort(along, kind="stable")
    return LineString(points[order])
