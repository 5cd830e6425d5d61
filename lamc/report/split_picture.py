"""A picture of the splitting in four panels: device, holes, cut, bodies (as in Figure 1 of the paper); where there are
several sheets, a panel for each (`sheets_picture`).

In: the steps of a splitting and a path ending in .png, .svg or .pdf. Out: that file, written whole or not at
all. It computes nothing about the mechanism, and it shares no state with other figures (no pyplot).

Slits are a few hundredths of a millimetre wide, and invisible at true scale. Their outlines are drawn with a
stroke of visible width, and the picture says so and gives the true width.
"""

import math
import os
from collections.abc import Sequence, Sized
from pathlib import Path

import numpy as np
import shapely
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from shapely.geometry import MultiPolygon, Polygon

from lamc.basics.numbers import length_text, shortened
from lamc.design.cutting import SLIT, material_size
from lamc.design.steps import SplitBody, SplitSteps
from lamc.records.mechanism import Array
from lamc.report.leaders import ROOM, label_beside, raise_limits
from lamc.report.plan_view import (
    View,
    fill,
    fits,
    frame,
    is_hidden,
    label,
    mend_entry,
    ring_mends,
    thinned,
    view_of,
)
from lamc.report.sheets_picture import sheets_figure, sheets_of
from lamc.report.style import WORLD, body_colours, save

# Holes and slits have colours that no body has.
MATERIAL, HOLE, SLIT_COLOUR, LINE = "#C9D6DF", "#B00020", "#3B2C85", "#000000"
_PANEL = 4.6  # inches, width of a panel's drawing
_SHEET = 7.0  # inches, the same of a sheet


def draw_split(steps: SplitSteps, path: str | os.PathLike[str]) -> None:
    """Draw the four steps into `path`. Raises LamcError for a suffix that is not .png, .svg or .pdf."""
    save(_figure(steps), Path(path))


def _figure(steps: SplitSteps) -> Figure:
    bounds = _bounds(steps)
    width, height = bounds[1] - bounds[0]
    rows, columns = (4, 1) if width > 2.4 * height else (2, 2)
    panel_width = 2 * _PANEL if columns == 1 else _PANEL
    size = material_size(steps.design.layers)
    sheets = sheets_of(steps)
    if len(sheets) > 1:
        return sheets_figure(steps, view_of(bounds, size, _SHEET), sheets, _SHEET)
    view = view_of(bounds, size, panel_width)
    named = ((_hinge_points(steps, view), [h.name for h in steps.hinges]), _body_points(steps, view))
    room = 0.0 if all(fits(*each, view) for each in named) else 2 * ROOM
    panel_height = max(panel_width * height / width, 0.9) + room
    paper = (columns * (panel_width + 0.9) + 0.3, rows * (panel_height + 0.9) + 1.2)
    figure = Figure(figsize=paper, layout=ConstrainedLayoutEngine(w_pad=0.08, h_pad=0.14))
    axes = list(figure.subplots(rows, columns).flat)
    figure.suptitle(
        f"{shortened(steps.design.name, 60)}: from laminate to bodies", parse_math=False, fontsize=13
    )
    panels = (_draw_device, _draw_holes, _draw_cut, _draw_bodies)
    for axis, panel in zip(axes, panels, strict=True):
        frame(axis, view)
        if room:
            raise_limits(axis, view)
        note = panel(axis, steps, view)
        axis.set_title(note or " ", fontsize=7.5, color="#444444", parse_math=False)
    figure.legend(handles=_legend(steps), loc="outside lower center", ncols=5, fontsize=8, frameon=False)
    return figure


def _headline(axis: Axes, text: str) -> None:
    """The panel's title; the title proper, below it, is left for a note in smaller print."""
    axis.annotate(
        text,
        (0.5, 1.0),
        (0, 18),
        xycoords="axes fraction",
        textcoords="offset points",
        ha="center",
        fontsize=10.5,
    )


def _count(things: Sized, noun: str) -> str:
    return f"{len(things)} {noun}{'' if len(things) == 1 else 's'}"


def _draw_device(axis: Axes, steps: SplitSteps, view: View) -> str:
    layers = steps.design.layers
    thick = length_text(sum(layer.thickness for layer in layers))
    reported = f"{_count(layers, 'layer')}, {thick} thick in all, {_count(steps.hinges, 'hinge line')}"
    _headline(axis, f"1  device: {reported}")
    for layer in steps.design.layers:
        alpha = 0.25 + 0.6 / len(steps.design.layers)
        fill(axis, layer.geometry.geoms, view, face=MATERIAL, alpha=alpha, edge="#5A6B76", line=0.5)
    for region in steps.design.fixed:
        inside = shapely.intersection(region, shapely.box(*view.low, *view.high))
        polygons = [p for p in shapely.get_parts(inside) if isinstance(p, Polygon)]
        fill(axis, polygons, view, face="none", edge=WORLD, hatch="///", line=0.6)
    ring_mends(axis, steps.design.mends, view)
    return _hinge_lines(axis, steps, view, labels=True)


def _draw_holes(axis: Axes, steps: SplitSteps, view: View) -> str:
    holes = shapely.union_all(steps.holes)
    count = len(shapely.get_parts(holes))
    _headline(axis, f"2  holes: {count} where hinge lines meet" if count else "2  holes: none")
    for layer in steps.design.layers:
        fill(axis, layer.geometry.geoms, view, face=MATERIAL, alpha=0.5, edge="none")
    _hinge_lines(axis, steps, view, labels=False)
    polygons = [p for p in shapely.get_parts(holes) if isinstance(p, Polygon)]
    fill(axis, polygons, view, face=HOLE, edge=HOLE, line=1.6, order=4)
    if not count:
        return ""
    across = max(math.sqrt(p.area) for p in polygons)
    return (
        f"Holes (about {length_text(across)} across) are outlined to be seen."
        if is_hidden(across, view)
        else ""
    )


def _draw_cut(axis: Axes, steps: SplitSteps, view: View) -> str:
    _headline(axis, "3  cut: slits along hinge lines")
    for cut in steps.cut:
        fill(axis, cut.geoms, view, face=MATERIAL, alpha=0.5, edge="none")
    device = shapely.union_all([thinned(layer.geometry, view) for layer in steps.design.layers])
    slits = shapely.intersection(shapely.union_all(steps.slits), device)
    polygons = [p for p in shapely.get_parts(slits) if isinstance(p, Polygon)]
    fill(axis, polygons, view, face=SLIT_COLOUR, edge=SLIT_COLOUR, line=1.2, order=4)
    holes = [p for p in shapely.get_parts(shapely.union_all(steps.holes)) if isinstance(p, Polygon)]
    fill(axis, holes, view, face="white", edge=HOLE, line=1.0, order=5)
    widths = sorted({2 * SLIT * hinge.properties.width for hinge in steps.hinges})
    if not is_hidden(widths[0], view):
        return ""
    span = (
        length_text(widths[0])
        if widths[0] == widths[-1]
        else f"{length_text(widths[0])} to {length_text(widths[-1])}"
    )
    return f"Slits ({span} wide) are drawn wider than they are."


def _draw_bodies(axis: Axes, steps: SplitSteps, view: View) -> str:
    fixed = sum(body.fixed for body in steps.bodies)
    _headline(axis, f"4  bodies: {len(steps.bodies) - fixed} moving, {fixed} fixed")
    colours = body_colours(steps.mechanism)
    for body in steps.bodies:
        for polygons in body.polygons:
            fill(axis, polygons, view, face=colours[body.name], edge="none")
        outline = shapely.union_all([thinned(MultiPolygon(p), view) for p in body.polygons])
        parts = [p for p in shapely.get_parts(outline) if isinstance(p, Polygon)]
        fill(axis, parts, view, face="none", edge="white", line=1.0)
        if body.fixed:
            fill(axis, parts, view, face="none", edge="#5A5A5A", line=0.4, hatch="///")
    _hinge_lines(axis, steps, view, labels=False)
    return _named(axis, *_body_points(steps, view), view, "body", bold=True)


def _hinge_lines(axis: Axes, steps: SplitSteps, view: View, *, labels: bool) -> str:
    for hinge in steps.hinges:
        xy = np.array(hinge.line.coords) * view.per_metre
        axis.plot(xy[:, 0], xy[:, 1], color=LINE, linewidth=0.9, dashes=(5, 2), zorder=3)
    if not labels:
        return ""
    names = [hinge.name for hinge in steps.hinges]
    return _named(axis, _hinge_points(steps, view), names, view, "hinge", bold=False)


def _named(axis: Axes, points: Array, names: Sequence[str], view: View, what: str, *, bold: bool) -> str:
    """Names where they fit, else beside the drawing. Returns a note where some are left out."""
    if fits(points, names, view):
        return label(axis, points, names, view, what, bold=bold)
    return label_beside(axis, points, names, view, ["black"] * len(names))


def _hinge_points(steps: SplitSteps, view: View) -> Array:
    """Middles of the hinge lines, (n, 2), m."""
    box = shapely.box(*view.low, *view.high)
    middles = [shapely.intersection(hinge.line, box).centroid for hinge in steps.hinges]
    return np.array([(p.x, p.y) for p in middles]).reshape(-1, 2)


def _body_points(steps: SplitSteps, view: View) -> tuple[Array, list[str]]:
    """A point inside each body, (n, 2), m, and its name."""
    return np.array([_middle(body, view) for body in steps.bodies]), [body.name for body in steps.bodies]


def _middle(body: SplitBody, view: View) -> tuple[float, float]:
    """A point well inside the body's largest polygon, m."""
    polygons = [p for layer in body.polygons for p in layer]
    largest = thinned(max(polygons, key=lambda p: p.area), view)
    if largest.contains(largest.centroid):
        return float(largest.centroid.x), float(largest.centroid.y)
    point = largest.representative_point()
    return float(point.x), float(point.y)


def _bounds(steps: SplitSteps) -> Array:
    """Lower and upper corner of the box around all layers, (2, 2), m."""
    boxes = np.array([layer.geometry.bounds for layer in steps.design.layers if not layer.geometry.is_empty])
    return np.array([boxes[:, :2].min(axis=0), boxes[:, 2:].max(axis=0)])


def _legend(steps: SplitSteps) -> list[Patch | Line2D]:
    entries: list[Patch | Line2D] = [
        Patch(facecolor=MATERIAL, edgecolor="#5A6B76", label="material (darker: more layers)"),
        Line2D([], [], color=LINE, linewidth=0.9, dashes=(5, 2), label="hinge line"),
        Patch(facecolor="none", edgecolor=WORLD, hatch="///", label="fixed region, fixed body"),
        Patch(facecolor=SLIT_COLOUR, label="slit"),
    ]
    if any(not hole.is_empty for hole in steps.holes):
        entries.append(Patch(facecolor=HOLE, label="hole"))
    return entries + mend_entry(steps.design.mends)
