"""A bent plate in space, its deflections enlarged, and the colours of all pictures of plates.

In: a mesh, deflections at its points, matplotlib axes. Out: artists, and how many times deflections were enlarged.
Never: files. The view is a parallel projection onto plain axes: matplotlib's own views leave most of the paper empty.

Colours are viridis for quantities without a sign and PuOr about zero for those with one: both are even to the eye, also
where colours are told apart less well.
"""

import math
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.colors import CenteredNorm, Normalize

from lamc.basics.checks import Array
from lamc.plates.meshing.mesh import Mesh
from lamc.report.plate_marks import INK

_FAR = 0.3  # of the largest value: all that has one sign and is farther from zero has half of the colours
ONE_SIGN, TWO_SIGNS = "viridis", "PuOr"
_SOLID = 12_000  # triangles of a view in space
_TALL = 0.18  # of the plate's size: the largest deflection as it is drawn
REST = "#9A9A9A"  # the edge where nothing has moved
_AXES = 0.09  # of the view's width: arrows along x, y and z


def _directions(rotation: float, tilt: float) -> tuple[Array, Array]:
    """Rows that take (x, y, z) to the picture's right and up, (2, 3); and the direction away from the eye, (3,)."""
    s, c = math.sin(math.radians(rotation)), math.cos(math.radians(rotation))
    up, flat = math.cos(math.radians(tilt)), math.sin(math.radians(tilt))
    return np.array([[c, -s, 0.0], [s * flat, c * flat, up]]), np.array([s * up, c * up, -flat])


_VIEW, _DEPTH = _directions(24.0, 32.0)  # degrees: turned about z, seen from that height
_LIGHT = np.array([-0.4, -0.3, 0.866])


def bent(axis: Axes, mesh: Mesh, w: Array) -> float:
    """The plate as it is seen from above and from the side, its deflections enlarged; grey, its edge at rest.

    w  (points,), m
    Returns how many times deflections were enlarged.
    """
    largest = float(np.abs(w).max(initial=0.0))
    factor = rounded(_TALL * max(box(mesh)) / largest) if largest > 0.0 else 1.0
    points, cells = _coarsened(mesh)
    corners = np.column_stack([mesh.points[points], factor * w[points]])[cells]  # (k, 3, 3)
    middle = corners.mean(axis=1)
    colours, norm = colours_of(-largest, largest, signed=True)
    faces = mpl.colormaps[colours](norm(middle[:, 2] / factor))
    faces[:, :3] *= _shade(corners)[:, None]
    order = np.argsort(middle @ _DEPTH, kind="stable")[::-1]
    axis.add_collection(
        PolyCollection(
            list((corners @ _VIEW.T)[order]), facecolors=faces[order], edgecolors=faces[order], linewidths=0.3
        )
    )
    ends = mesh.edges[np.bincount(mesh.cell_edges.ravel(), minlength=len(mesh.edges)) == 1]
    for height, colour, width, above in ((0.0, REST, 0.7, 0), (factor, INK, 0.8, 3)):
        rim = np.column_stack([mesh.points, height * w])[ends] @ _VIEW.T
        axis.add_collection(LineCollection(list(rim), colors=colour, linewidths=width, zorder=above))
    everything = np.concatenate([(corners @ _VIEW.T).reshape(-1, 2), mesh.points @ _VIEW[:, :2].T])
    low, high = everything.min(axis=0), everything.max(axis=0)
    margin = 0.03 * (high - low).max()
    axis.set_xlim(low[0] - margin, high[0] + margin)
    axis.set_ylim(low[1] - margin, high[1] + margin)
    axis.set_aspect("equal")
    axis.set_axis_off()
    _triad(axis, low, high, middle @ _VIEW.T)
    return factor


def _triad(axis: Axes, low: Array, high: Array, taken: Array) -> None:
    """Arrows along x, y and z in the upper left or lower right corner, where fewer of the points `taken` (k, 2) are."""
    length = _AXES * float(high[0] - low[0])
    arrows = length * _VIEW.T
    room = 1.3 * (np.maximum(arrows.max(axis=0), 0.0) - np.minimum(arrows.min(axis=0), 0.0))
    corners = [np.array([low[0], high[1] - room[1]]), np.array([high[0] - room[0], low[1]])]
    corner = min(corners, key=lambda c: int(((taken > c) & (taken < c + room)).all(axis=1).sum()))
    origin = corner + 0.15 * room - np.minimum(arrows.min(axis=0), 0.0)
    for arrow, name in zip(arrows, "xyz", strict=True):
        tip = origin + arrow
        style = {
            "arrowstyle": "-|>",
            "color": INK,
            "linewidth": 0.8,
            "shrinkA": 0,
            "shrinkB": 0,
            "mutation_scale": 7,
        }
        axis.annotate("", tuple(tip), tuple(origin), annotation_clip=False, arrowprops=style)
        x, y = (float(v) for v in tip + 0.25 * arrow)
        axis.text(x, y, name, fontsize=7, ha="center", va="center", color=INK)


def view_aspect(mesh: Mesh) -> float:
    """Height over width of the view of `bent`, about."""
    width, height = box(mesh)
    right, up = np.abs(_VIEW) @ np.array([width, height, _TALL * max(width, height)])
    return float(up / right)


def _shade(corners: Array) -> Array:
    """Brightness of each triangle, 0.8 to 1: a face that turns away from the light is darker, so that bends show."""
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length = np.linalg.norm(normal, axis=1)
    towards = np.abs(normal @ _LIGHT) / np.where(length > 0.0, length, 1.0)
    return np.asarray(0.8 + 0.2 * towards)


def rounded(factor: float) -> float:
    """1, 2 or 5 times a power of ten, not above `factor`."""
    power = 10.0 ** math.floor(math.log10(factor))
    return power * next(step for step in (5.0, 2.0, 1.0) if factor >= step * power * (1.0 - 1e-12))


def _coarsened(mesh: Mesh) -> tuple[Any, Any]:
    """Points and triangles for a view in space: all, or of a large mesh, one point for each of a grid of squares.

    Triangles whose corners fall into one square, or into two, vanish.
    """
    triangles = split(mesh.cells)
    if len(triangles) <= _SOLID:
        return np.arange(len(mesh.points)), triangles
    low, span = mesh.points.min(axis=0), np.ptp(mesh.points, axis=0)
    step = math.sqrt(span[0] * span[1] * 2.0 / _SOLID)
    squares = np.floor((mesh.points - low) / step).astype(np.int64)
    _, first, index = np.unique(
        squares[:, 0] * (1 << 32) + squares[:, 1], return_index=True, return_inverse=True
    )
    merged = index[triangles]
    distinct = (
        (merged[:, 0] != merged[:, 1]) & (merged[:, 1] != merged[:, 2]) & (merged[:, 0] != merged[:, 2])
    )
    return first, np.unique(np.sort(merged[distinct], axis=1), axis=0)


def split(cells: Any) -> Any:
    return cells if cells.shape[1] == 3 else np.concatenate([cells[:, [0, 1, 2]], cells[:, [0, 2, 3]]])


def colours_of(low: float, high: float, *, signed: bool) -> tuple[str, Normalize]:
    """Colour map and its range: PuOr for a quantity that has a sign, purple above zero and orange below, whether or not
    both are there, so that it looks alike in all pictures; else viridis."""
    size = max(abs(low), abs(high))
    if (
        signed and min(-low, high) < -_FAR * size
    ):  # far from zero: half of the map, pale where nearest to zero
        span = (high - low) or size
        return TWO_SIGNS, Normalize(low - 1.15 * span, high) if low > 0.0 else Normalize(
            low, high + 1.15 * span
        )
    if signed:
        return TWO_SIGNS, CenteredNorm(0.0, size or 1.0)
    room = 0.0 if high > low else max(abs(low), 1.0)
    return ONE_SIGN, Normalize(low - room, high + room)


def box(mesh: Mesh) -> tuple[float, float]:
    """Width and height of the box around the mesh, m."""
    wide, tall = np.ptp(mesh.points, axis=0)
    return float(wide), float(tall)
