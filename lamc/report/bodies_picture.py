"""A picture of the bodies of a mechanism as drawn, seen from above.

In: a mechanism whose bodies have outlines, the drawn hinge lines, and a path. Out: a PNG file. It computes nothing
about the mechanism.
"""

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import shapely
from matplotlib.figure import Figure
from shapely.geometry import Polygon

from lamc.basics.numbers import shortened
from lamc.records.design import Line
from lamc.records.mechanism import Body, Mechanism
from lamc.report.plan_view import fill, frame, label, mend_entry, ring_mends, thinned, view_of
from lamc.report.style import body_colours, save

_WIDTH = 7.0  # inches


def draw_bodies(mechanism: Mechanism, lines: Mapping[str, Line], path: Path) -> Path:
    """The plates of each body in the body's colour. Raises LamcError if it cannot be written."""
    bodies = [body for body in mechanism.bodies if body.outline]
    boxes = np.array([plate.polygon.bounds for body in bodies for plate in body.outline])
    bounds = np.array([boxes[:, :2].min(axis=0), boxes[:, 2:].max(axis=0)])
    width, height = bounds[1] - bounds[0]
    view = view_of(bounds, float(max(width, height)), _WIDTH)
    tall = max(_WIDTH * float(height / width), 0.9)
    figure = Figure(figsize=(_WIDTH + 0.9, tall + 1.2), layout="constrained")
    axis = figure.subplots()
    colours = body_colours(mechanism)
    for body in bodies:
        fill(axis, [plate.polygon for plate in body.outline], view, face=colours[body.name])
        outline = shapely.union_all([thinned(plate.polygon, view) for plate in body.outline])
        fill(axis, shapely.get_parts(outline), view, edge="white", line=1.0)
        if body.fixed:
            fill(axis, shapely.get_parts(outline), view, edge="#5A5A5A", line=0.4, hatch="///")
    for line in lines.values():
        x, y = np.array(line).T * view.per_metre
        axis.plot(x, y, color="#000000", linewidth=0.9, dashes=(5, 2), zorder=3)
    ring_mends(axis, mechanism.mends, view)
    if mechanism.mends:
        figure.legend(
            handles=mend_entry(mechanism.mends), loc="outside lower center", fontsize=8, frameon=False
        )
    points = np.array([_middle(body) for body in bodies])
    note = label(axis, points, [body.name for body in bodies], view, "body", bold=True)
    axis.set_title(note or " ", fontsize=7.5, color="#444444", parse_math=False)
    figure.suptitle(f"{shortened(mechanism.name, 60)}: bodies as drawn", parse_math=False, fontsize=13)
    frame(axis, view)
    return save(figure, path)


def _middle(body: Body) -> tuple[float, float]:
    """A point inside the body's largest polygon, m."""
    largest: Polygon = max((plate.polygon for plate in body.outline), key=lambda p: p.area)
    point = largest.centroid if largest.contains(largest.centroid) else largest.representative_point()
    return float(point.x), float(point.y)
