"""Planes that effects ask to be drawn, such as the ground: a sheet with a grid, and the shadows of what is above it.

In: a plane, and the points of the mechanism at all instants. Out: faces and lines on a canvas. It knows no effect.
"""

import math
from collections.abc import Sequence

import numpy as np

from lamc.records.effect import PlaneMark
from lamc.records.mechanism import Array
from lamc.report.raster import Camera, Canvas

SHEET, SHADOW, GRID = (236, 239, 243), (208, 213, 221), (198, 204, 213)
_MARGIN = 0.12  # of the extent, around what is above the plane
_CELLS = 9  # of the grid along the longer side, at most
_BELOW = 2e-3  # of the extent: the sheet is drawn that much lower, so that it does not hide what sinks in


class Sheet:
    """The part of a plane that is drawn: a rectangle of whole grid cells below all points.

    corners  (4, 3), m, world, anticlockwise about the normal
    lines    (k, 2, 3), m: the grid
    """

    def __init__(self, plane: PlaneMark, points: Array) -> None:
        self.normal = np.array(plane.normal, dtype=float)
        across = np.array([1.0, 0.0, 0.0]) if abs(self.normal[0]) < 0.9 else np.array([0.0, 1.0, 0.0])
        along = across - (across @ self.normal) * self.normal
        along /= np.linalg.norm(along)
        self.axes = np.stack([along, np.cross(self.normal, along)])
        point = np.array(plane.point, dtype=float)
        flat = (points - point) @ self.axes.T
        low, high = flat.min(axis=0), flat.max(axis=0)
        extent = float((high - low).max()) or 1.0
        self.point = point - _BELOW * extent * self.normal
        self._lift = 0.5 * _BELOW * extent * self.normal
        cell = _round_up((1.0 + 2.0 * _MARGIN) * extent / _CELLS)
        first = np.floor((low - _MARGIN * extent) / cell).astype(int)
        last = np.ceil((high + _MARGIN * extent) / cell).astype(int)
        (x0, y0), (x1, y1) = first * cell, last * cell
        self.corners = self._placed([(x0, y0), (x1, y0), (x1, y1), (x0, y1)])
        grid = [[(k * cell, y0), (k * cell, y1)] for k in range(first[0], last[0] + 1)]
        grid += [[(x0, k * cell), (x1, k * cell)] for k in range(first[1], last[1] + 1)]
        self.lines = np.array([self._placed(line) for line in grid])

    def _placed(self, flat: Sequence[tuple[float, float]]) -> Array:
        placed: Array = self.point + np.array(flat) @ self.axes
        return placed

    def draw(self, canvas: Canvas, camera: Camera, rings: Sequence[Sequence[Array]]) -> None:
        """The sheet with its grid, and shadows of faces, each a sequence of rings (k, 3), m; nothing from below."""
        normal = np.array([self.normal @ camera.right, self.normal @ camera.up, self.normal @ camera.towards])
        if normal[2] <= 1e-3:
            return
        canvas.face([camera.project(self.corners)], normal, SHEET)
        for face in rings:
            canvas.face([camera.project(self._shadow(ring)) for ring in face], normal, SHADOW)
        colours = np.tile(np.array(GRID, dtype=np.uint8), (len(self.lines), 1))
        canvas.lines(camera.project(self.lines), colours, width=0.8, bias=1.5)

    def _shadow(self, ring: Array) -> Array:
        shadow: Array = ring - np.outer((ring - self.point) @ self.normal, self.normal) + self._lift
        return shadow


def _round_up(length: float) -> float:
    """The least of 1, 2, 5 times a power of ten that is not below `length`, m."""
    power = 10.0 ** math.floor(math.log10(length))
    return next(k * power for k in (1.0, 2.0, 5.0, 10.0) if k * power >= length * (1 - 1e-9))
