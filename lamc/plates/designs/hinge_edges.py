"""Hinges of a body, seen as edges of a plate: the strip that bends, and the line where the plate ends.

In: the steps of a splitting, and which bodies are the plate. Out: for each hinge, the part of its strip that is added
to the plate, and the stretches of the plate's edge along it. Never: laminates.
"""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from shapely.geometry import LineString, MultiLineString, MultiPolygon, Polygon
from shapely.geometry.base import BaseGeometry

from lamc.design.contact import free_parts
from lamc.design.cutting import SLIT
from lamc.design.steps import Connection, SplitBody, SplitSteps
from lamc.plates.designs.overlay import areas_of

# In hinge widths: how deep beside the slit there surely is material of the body; contacts are read off there.
_TOUCH = 1.5 * SLIT
_PARALLEL = 0.2  # sine of the largest angle between a hinge line and an edge that counts as being along it


@dataclass(frozen=True, eq=False)
class HingeEdge:
    """Where a plate meets a hinge that joins it to a body outside.

    line  m, on the plate's edge; empty where nothing of the edge lies along the hinge
    """

    joint: str
    neighbour: str
    line: LineString | MultiLineString


class PlateHinge:
    """A hinge of the chosen bodies.

    properties  of its hinge set
    free       the stretches of its line that no hole has taken
    inner      those of its two bodies that belong to the plate, and on which side of the line each lies (`sides`)
    neighbour  the other body; "" where both belong to the plate
    """

    def __init__(self, steps: SplitSteps, connection: Connection, bodies: Sequence[SplitBody]) -> None:
        hinge = connection.hinge
        self.name, self.properties = hinge.name, hinge.properties
        self.width, self.layer = hinge.properties.width, hinge.properties.layer
        self.free = [part for part in free_parts(hinge, steps.holes[self.layer]) if part.length > 0.0]
        ends = (connection.parent, connection.child)
        self.inner = [part for part in bodies if part.name in ends]
        self.neighbour = next((name for name in ends if name not in [part.name for part in bodies]), "")
        self.sides = [self._side(part) for part in self.inner]
        self.drawn = shapely.difference(steps.design.layers[self.layer].geometry, steps.holes[self.layer])
        # Only what lies against the flexible layer stiffens it: other sheets may pass above or below.
        against = [k for k in (self.layer - 1, self.layer + 1) if 0 <= k < len(steps.holes)]
        own, beyond = (
            shapely.union_all([p for part in parts for k in against for p in part.polygons[k]])
            for parts in (self.inner, [part for part in steps.bodies if part.name == self.neighbour])
        )
        self.own, self.beyond = own, beyond  # what stiffens the strip

    def _side(self, part: SplitBody) -> int:
        """1 where the body lies to the left of the line, -1 to the right."""
        own = MultiPolygon(part.polygons[self.layer])
        left, right = (
            shapely.intersection(self.band(sign * SLIT, sign * _TOUCH), own).area for sign in (1, -1)
        )
        return 1 if left >= right else -1

    def band(self, start: float, end: float) -> BaseGeometry:
        """Between two parallels of the line, distances in hinge widths, positive to the left."""
        return shapely.union_all([_band(part, start * self.width, end * self.width) for part in self.free])

    def strip(self) -> MultiPolygon:
        """The flexible layer within a hinge width of the line, up to where the neighbour is stiff."""
        within = shapely.intersection(self.band(-1.0, 1.0), self.drawn)
        return areas_of(shapely.difference(within, self.beyond))

    def changed(self, area: BaseGeometry, hinges: str) -> MultiPolygon:
        """The plate's part of the flexible layer, from what the bodies have of it."""
        if hinges == "none":
            return areas_of(area)
        if hinges == "strips" or not self.neighbour:  # between bodies of this plate its strip is part of it
            return areas_of(shapely.union(area, self.strip()))
        bending = shapely.difference(self.band(0.0, float(self.sides[0])), self.own)
        return areas_of(shapely.difference(area, bending))

    def edge(self, hinges: str, layer: BaseGeometry, tolerance: float) -> HingeEdge:
        """The stretches along the hinge of the edge of `layer`: the plate's part of the flexible layer."""
        side = self.sides[0]
        # In hinge widths. A strip ends nearer to the line where stiff layers begin earlier.
        at, reach = {"none": (SLIT, 0.2 * SLIT), "lines": (0.5, 0.55), "strips": (-1.0, 0.95)}[hinges]
        lines = [
            piece
            for part in self.free
            for piece in edges_along(
                layer.boundary, _parallel(part, side * at * self.width), reach * self.width
            )
        ]
        merged = shapely.line_merge(shapely.union_all(lines))
        kept = [line for line in shapely.get_parts(merged) if line.length > tolerance]
        return HingeEdge(self.name, self.neighbour, kept[0] if len(kept) == 1 else MultiLineString(kept))


def _parallel(line: LineString, distance: float) -> LineString:
    """The line shifted by `distance` m, positive to the left."""
    a, b = np.array(line.coords)
    along = (b - a) / np.linalg.norm(b - a)
    return LineString(np.array([a, b]) + distance * np.array([-along[1], along[0]]))


def _band(line: LineString, start: float, end: float) -> Polygon:
    near, far = (np.array(_parallel(line, distance).coords) for distance in (start, end))
    return Polygon([*near, *far[::-1]])


def edges_along(boundary: BaseGeometry, line: LineString, reach: float) -> list[BaseGeometry]:
    """The pieces of a boundary that run along a line within `reach` m of it."""
    near = shapely.intersection(boundary, shapely.buffer(line, reach, cap_style="flat"))
    a, b = np.array(line.coords)
    along = (b - a) / np.linalg.norm(b - a)
    pieces = []
    for part in shapely.get_parts(shapely.line_merge(near)):
        points = np.array(part.coords)
        for start, end in itertools.pairwise(points):
            step = end - start
            if abs(along[0] * step[1] - along[1] * step[0]) <= _PARALLEL * np.linalg.norm(step):
                pieces.append(LineString([start, end]))
    return pieces
