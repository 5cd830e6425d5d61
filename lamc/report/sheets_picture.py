"""The splitting of a device of several sheets: a panel for each sheet, and the layers from the side, pulled apart.

In: the steps of a splitting. Out: a figure. A sheet is what hinges run through together; layers that no hinge runs
through, such as tape, join sheets and are shown from the side only. It computes nothing about the mechanism.
"""

import numpy as np
import shapely
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, Rectangle
from shapely.geometry import Polygon

from lamc.basics.groups import root, unite
from lamc.basics.numbers import length_text, shortened
from lamc.design.steps import SplitSteps
from lamc.records.mechanism import Array
from lamc.report.leaders import ROOM, label_beside, raise_limits
from lamc.report.plan_view import View, fill, frame, mend_entry, ring_mends, thinned
from lamc.report.style import body_colours

_ROW = 0.24  # inches of a layer from the side
_APART = 0.9  # rows between sheets
_HINGE = "#B34700"
_NAMED = 12  # bodies of a legend


def sheets_of(steps: SplitSteps) -> list[tuple[int, ...]]:
    """Layers of each sheet, from the bottom up."""
    head = list(range(len(steps.design.layers)))
    for hinge in steps.hinges:
        for layer in hinge.layers[1:]:
            unite(head, hinge.layers[0], layer)
    heads = sorted({root(head, layer) for hinge in steps.hinges for layer in hinge.layers})
    return [tuple(k for k in range(len(head)) if root(head, k) == first) for first in heads]


def sheets_figure(steps: SplitSteps, view: View, sheets: list[tuple[int, ...]], width: float) -> Figure:
    """The figure; `width`, inches, of the drawing in a panel."""
    tall = (view.high[1] - view.low[1]) * view.inches_per_metre
    side = _ROW * (len(steps.design.layers) + _APART * (len(sheets) - 1)) + 0.3
    heights = [tall + 2 * ROOM] * len(sheets) + [side]
    figure = Figure(figsize=(width + 2.6, sum(heights) + 0.75 * len(heights) + 1.2), layout="constrained")
    axes = list(np.ravel(figure.subplots(len(heights), 1, height_ratios=heights)))
    figure.suptitle(f"{shortened(steps.design.name, 60)}: its sheets", parse_math=False, fontsize=13)
    names = [layer.name for layer in steps.design.layers]
    for number, (axis, sheet) in enumerate(zip(reversed(axes[:-1]), sheets, strict=True)):
        told = ", ".join(shortened(names[k], 20) for k in sheet)
        where = " (bottom)" if number == 0 else " (top)" if number == len(sheets) - 1 else ""
        axis.set_title(
            f"sheet {number + 1}{where}: {shortened(told, 70)}", fontsize=10, parse_math=False, loc="left"
        )
        _draw_sheet(axis, steps, view, sheet)
    _draw_side(axes[-1], steps, view, sheets)
    colours = body_colours(steps.mechanism)
    bodies = steps.bodies[:_NAMED] if len(steps.bodies) <= _NAMED else []
    handles: list[Patch | Line2D] = [Line2D([], [], color="black", linewidth=0.9, dashes=(5, 2))]
    labels = ["hinge line, its name in orange"]
    for entry in mend_entry(steps.design.mends):
        handles.append(entry)
        labels.append(str(entry.get_label()))
    for body in bodies:
        handles.append(Patch(facecolor=colours[body.name], hatch="///" if body.fixed else None))
        labels.append(shortened(body.name, 20) + (" (fixed)" if body.fixed else ""))
    legend = figure.legend(
        handles=handles,
        labels=[str(k) for k in range(len(labels))],
        loc="outside lower center",
        ncols=min(6, len(labels)),
        fontsize=8,
        frameon=False,
    )
    for text, label in zip(legend.get_texts(), labels, strict=True):
        text.set_parse_math(False)
        text.set_text(label)
    return figure


def _draw_sheet(axis: Axes, steps: SplitSteps, view: View, sheet: tuple[int, ...]) -> None:
    """The bodies' parts in the sheet, its hinge lines, and the names of both beside it."""
    colours = body_colours(steps.mechanism)
    points: list[tuple[float, float]] = []
    names: list[str] = []
    inks: list[str] = []
    for body in steps.bodies:
        parts = [polygon for k in sheet for polygon in body.polygons[k]]
        if not parts:
            continue
        fill(axis, parts, view, face=colours[body.name])
        outline = shapely.union_all([thinned(part, view) for part in parts])
        polygons = [p for p in shapely.get_parts(outline) if isinstance(p, Polygon)]
        fill(axis, polygons, view, edge="white", line=1.0)
        if body.fixed:
            fill(axis, polygons, view, edge="#5A5A5A", line=0.4, hatch="///")
        at = max(polygons, key=lambda p: p.area).representative_point()
        points.append((at.x, at.y))
        names.append(body.name)
        inks.append("black")
    for hinge in steps.hinges:
        if not set(hinge.layers) <= set(sheet):
            continue
        x, y = np.array(hinge.line.coords).T * view.per_metre
        axis.plot(x, y, color="black", linewidth=0.9, dashes=(5, 2), zorder=3)
        end = max(hinge.line.coords, key=lambda p: p[1])
        points.append((end[0], end[1]))
        names.append(hinge.name)
        inks.append(_HINGE)
    ring_mends(axis, steps.design.mends, view)
    note = label_beside(axis, np.array(points), names, view, inks)
    if note:
        axis.set_xlabel(note, fontsize=7)
    frame(axis, view)
    raise_limits(axis, view)


def _draw_side(axis: Axes, steps: SplitSteps, view: View, sheets: list[tuple[int, ...]]) -> None:
    """Layers as bars by body, seen along y (x for tall devices), heights not to scale, sheets pulled apart."""
    along = 0 if view.high[0] - view.low[0] >= view.high[1] - view.low[1] else 1
    colours = body_colours(steps.mechanism)
    heights = _rows(steps, sheets)
    for k, layer in enumerate(steps.design.layers):
        for body in steps.bodies:
            for polygon in body.polygons[k]:
                low, high = polygon.bounds[along], polygon.bounds[along + 2]
                place = (low * view.per_metre, heights[k])
                axis.add_patch(
                    Rectangle(
                        place,
                        (high - low) * view.per_metre,
                        0.8,
                        facecolor=colours[body.name],
                        edgecolor="white",
                        linewidth=0.5,
                        alpha=0.85,
                    )
                )
        text = f" {shortened(layer.name, 20)}, {length_text(layer.thickness)}"
        axis.annotate(
            text,
            (1.0, heights[k] + 0.4),
            xycoords=axis.get_yaxis_transform(),
            fontsize=7,
            va="center",
            parse_math=False,
        )
    for hinge in steps.hinges:
        at = shapely.centroid(hinge.line).coords[0][along] * view.per_metre
        axis.plot([at], [heights[hinge.properties.layer] + 0.4], "o", color=_HINGE, markersize=4, zorder=4)
    axis.set_xlim(view.low[along] * view.per_metre, view.high[along] * view.per_metre)
    axis.set_ylim(-0.3, heights[-1] + 1.1)
    axis.set_yticks([])
    axis.spines[["top", "right", "left"]].set_visible(False)
    axis.set_xlabel(f"{'xy'[along]} [{view.unit}]", fontsize=8)
    axis.tick_params(labelsize=7)
    axis.set_title(
        "from the side, pulled apart: heights are not to scale, dots are hinges", fontsize=10, loc="left"
    )


def _rows(steps: SplitSteps, sheets: list[tuple[int, ...]]) -> Array:
    """Heights of the layers' bars, with a gap where another sheet begins or ends."""
    sheet_of = {k: number for number, sheet in enumerate(sheets) for k in sheet}
    heights, height = [], 0.0
    for k in range(len(steps.design.layers)):
        if k and sheet_of.get(k) != sheet_of.get(k - 1):
            height += _APART / 2
        heights.append(height)
        height += 1.0
    return np.array(heights)
