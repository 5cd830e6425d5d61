"""Plan views: polygons, lines and labels seen from above, at a known scale on paper.

In: geometry in metres, matplotlib axes, and a `View` that fixes box, unit and scale. Out: artists added to
the axes. It opens no figures and writes no files.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import shapely
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import PathPatch
from matplotlib.path import Path
from matplotlib.patheffects import withStroke
from shapely.geometry import Polygon
from shapely.geometry.base import BaseGeometry
from shapely.geometry.polygon import orient

from lamc.basics.numbers import shortened
from lamc.records.drawing import Mend
from lamc.records.mechanism import Array

_RING: dict[str, Any] = {
    "marker": "o",
    "linestyle": "none",
    "markersize": 9,
    "markerfacecolor": "none",
    "markeredgecolor": "#D6006C",  # no body and no other mark has it
    "markeredgewidth": 1.4,
    "zorder": 6,
}
_LARGEST_FONT, _SMALLEST_FONT = 9.0, 4.5  # pt; labels that would be smaller are left out
_FINEST = 1 / 3000  # of the drawing's size: detail below it is not drawn


@dataclass(frozen=True)
class View:
    """The box that is seen, the unit of the axes, the scale on paper."""

    low: tuple[float, float]  # m
    high: tuple[float, float]  # m
    unit: str
    per_metre: float
    inches_per_metre: float
    tolerance: float  # m, detail below it is not drawn


def view_of(bounds: Array, size: float, panel_width: float) -> View:
    """A view of the box `bounds`, (2, 2) m, `panel_width` inches wide; `size`, m, sets the unit."""
    low, high = bounds
    margin = 0.04 * float((high - low).max())
    unit, per_metre = ("m", 1.0) if size >= 1.0 else ("mm", 1e3) if size >= 1e-3 else ("µm", 1e6)
    width = float(high[0] - low[0]) + 2 * margin
    return View(
        (float(low[0]) - margin, float(low[1]) - margin),
        (float(high[0]) + margin, float(high[1]) + margin),
        unit,
        per_metre,
        panel_width / width,
        _FINEST * size,
    )


def frame(axis: Axes, view: View) -> None:
    """Limits, equal scale, labels with unit, quiet spines."""
    axis.set_xlim(view.low[0] * view.per_metre, view.high[0] * view.per_metre)
    axis.set_ylim(view.low[1] * view.per_metre, view.high[1] * view.per_metre)
    axis.set_aspect("equal")
    axis.set_xlabel(f"x [{view.unit}]", fontsize=8)
    axis.set_ylabel(f"y [{view.unit}]", fontsize=8)
    axis.tick_params(labelsize=7)
    axis.spines[["top", "right"]].set_visible(False)


def fill(
    axis: Axes,
    polygons: Iterable[BaseGeometry],
    view: View,
    *,
    face: str = "none",
    edge: str = "none",
    line: float = 0.0,
    alpha: float = 1.0,
    hatch: str | None = None,
    order: float = 1.0,
) -> None:
    """Add polygons to the axes; `line` is the outline's width in points. Lines and points are left out."""
    for polygon in polygons:
        for part in shapely.get_parts(thinned(polygon, view)):
            if isinstance(part, Polygon) and not part.is_empty:
                axis.add_patch(
                    PathPatch(
                        _path(part, view.per_metre),
                        facecolor=face,
                        edgecolor=edge,
                        linewidth=line,
                        alpha=alpha,
                        hatch=hatch,
                        zorder=order,
                    )
                )


def ring_mends(axis: Axes, mends: Sequence[Mend], view: View) -> None:
    """Rings where a drawing was healed."""
    for mend in mends:
        x, y = mend.at
        axis.plot(x * view.per_metre, y * view.per_metre, **_RING)


def mend_entry(mends: Sequence[Mend]) -> list[Line2D]:
    """Their entry in a legend; none where nothing was healed."""
    return [Line2D([], [], label=f"drawing healed here ({len(mends)})", **_RING)] if mends else []


def _path(polygon: Polygon, scale: float) -> Path:
    """A compound path; exterior and holes run opposite ways, so that holes stay open."""
    rotated = orient(polygon)
    rings = (rotated.exterior, *rotated.interiors)
    return Path.make_compound_path(*(Path(np.array(r.coords)[:, :2] * scale, closed=True) for r in rings))


def thinned(geometry: BaseGeometry, view: View) -> BaseGeometry:
    """The geometry without detail that the eye cannot see; small outlines stay as they are."""
    if shapely.get_num_coordinates(geometry) < 2000:
        return geometry
    return shapely.simplify(geometry, view.tolerance)


def fits(points: Array, names: Sequence[str], view: View) -> bool:
    """Whether names at points (n, 2) m can be read, without one over another."""
    return _font_size(points, [shortened(name, 16) for name in names], view) >= _SMALLEST_FONT


def label(axis: Axes, points: Array, names: Sequence[str], view: View, what: str, *, bold: bool) -> str:
    """Write names at points (n, 2) m as large as their spacing allows; or return a note instead."""
    shown = [shortened(name, 16) for name in names]
    font = _font_size(points, shown, view)
    if font < _SMALLEST_FONT:
        return f"The {what} names would not be legible here, and are left out."
    halo = [withStroke(linewidth=2.2, foreground="white")]
    for (x, y), name in zip(points * view.per_metre, shown, strict=True):
        axis.text(
            x,
            y,
            name,
            fontsize=font,
            ha="center",
            va="center",
            weight="bold" if bold else "normal",
            path_effects=halo,
            parse_math=False,
            zorder=6,
            clip_on=True,
        )
    return ""


def _font_size(points: Array, names: Sequence[str], view: View) -> float:
    """Largest font, pt, at which no two labels overlap: a letter is about 0.7 em wide, a line 1.3 em high."""
    font = _LARGEST_FONT
    on_paper = points * view.inches_per_metre * 72
    tree = shapely.STRtree(shapely.points(on_paper))
    reach = _LARGEST_FONT * 0.72 * max(len(name) for name in names)
    for i, point in enumerate(on_paper):
        for j in tree.query(shapely.Point(point).buffer(reach)):
            if int(j) <= i:
                continue
            dx, dy = np.abs(on_paper[int(j)] - point)
            wide = 0.72 * (len(names[i]) + len(names[int(j)])) / 2
            font = min(font, max(dx / wide, dy / 1.3))
    return font


def is_hidden(length: float, view: View) -> bool:
    """True if a length is under two points on paper."""
    return length * view.inches_per_metre * 72 < 2.0
