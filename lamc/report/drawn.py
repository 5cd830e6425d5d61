"""Designs from above and mechanisms in space, on Matplotlib axes: `design.draw()`, `mechanism.draw(angles=…)`.

In: a `Design` or a `Mechanism`, axes. Out: the axes, or a PNG, SVG or PDF file. It computes nothing but a view.
"""

import os
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import shapely
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from shapely.geometry import LineString, Polygon

from lamc.basics.checks import shown
from lamc.basics.errors import RequestError
from lamc.basics.numbers import length_text, shortened
from lamc.loops.posed import posed
from lamc.records.design import Design
from lamc.records.mechanism import Mechanism
from lamc.report.folded import free_corners, scale_bar, triad
from lamc.report.look import Look, camera_of
from lamc.report.plan_view import fill, frame, label, view_of
from lamc.report.stage import Poses, Stage
from lamc.report.style import WORLD, save_axes

MATERIAL, EDGE, LINE = "#C9D6DF", "#5A6B76", "#000000"
_WIDTH = 7.0  # inches
_LONGEST = 900  # pixels


def on_axes(size: tuple[float, float], axes: Any, path: str | os.PathLike[str] | None, draw: Any) -> Axes:
    """Draws on axes of the caller's, or of a new figure of a size, inches: pyplot's, or one for a file."""
    if axes is not None:
        if not isinstance(axes, Axes):
            raise RequestError(f"axes is {shown(axes)}; it must be Matplotlib axes, or None")
        axis = axes
    elif path is None:
        from matplotlib import pyplot  # its figures are shown by notebooks and windows

        axis = pyplot.figure(figsize=size, layout="constrained").subplots()
    else:
        axis = Figure(figsize=size, layout="constrained").subplots()
    draw(axis)
    if path is not None:
        save_axes(axis, path)
    return axis


def draw_design(
    design: Design, *, axes: Axes | None = None, path: str | os.PathLike[str] | None = None
) -> Axes:
    """`Design.draw`."""
    boxes = np.array([layer.geometry.bounds for layer in design.layers if not layer.geometry.is_empty])
    bounds = np.array([boxes[:, :2].min(axis=0), boxes[:, 2:].max(axis=0)])
    width, height = bounds[1] - bounds[0]
    view = view_of(bounds, float(max(width, height)), _WIDTH)

    def draw(axis: Axes) -> None:
        for layer in design.layers:
            alpha = 0.25 + 0.6 / len(design.layers)
            fill(axis, layer.geometry.geoms, view, face=MATERIAL, alpha=alpha, edge=EDGE, line=0.5)
        box = shapely.box(*view.low, *view.high)
        for region in design.fixed:
            parts = [
                p for p in shapely.get_parts(shapely.intersection(region, box)) if isinstance(p, Polygon)
            ]
            fill(axis, parts, view, edge=WORLD, hatch="///", line=0.6)
        hinges = [hinge for each in design.hinges for hinge in each.lines]
        for hinge in hinges:
            x, y = np.array(hinge.line).T * view.per_metre
            axis.plot(x, y, color=LINE, linewidth=0.9, dashes=(5, 2), zorder=3)
        named = [hinge for hinge in hinges if hinge.name]
        if named:
            middles = [shapely.intersection(LineString(hinge.line), box).centroid for hinge in named]
            points = np.array([(p.x, p.y) for p in middles])
            label(axis, points, [hinge.name or "" for hinge in named], view, "hinge", bold=False)
        thick = length_text(sum(layer.thickness for layer in design.layers))
        count = len(design.layers)
        title = f"{shortened(design.name, 40)}: {count} layer{'' if count == 1 else 's'}, {thick} thick"
        axis.set_title(title, fontsize=10, parse_math=False)
        frame(axis, view)

    return on_axes((_WIDTH + 0.9, max(_WIDTH * float(height / width), 0.9) + 0.9), axes, path, draw)


def draw_mechanism(
    mechanism: Mechanism,
    angles: Mapping[str, float] | None = None,
    *,
    axes: Axes | None = None,
    path: str | os.PathLike[str] | None = None,
    camera: str | Sequence[float] | None = None,
    size: int | None = None,
) -> Axes:
    """`Mechanism.draw`."""
    look = Look(camera_of(camera), size)
    centres, rotations = posed(mechanism, angles or {})
    poses = Poses(np.zeros(1), centres[None], rotations[None])
    stage = Stage(mechanism, poses, look.size or _LONGEST, camera=look.camera)
    picture = stage.draw(0)

    def draw(axis: Axes) -> None:
        axis.set_axis_off()
        axis.imshow(picture, interpolation="antialiased")
        corners = free_corners(picture)
        scale_bar(axis, stage, corners[0])
        triad(axis, stage, corners[1])
        told = "as drawn" if not angles else "folded"
        axis.set_title(f"{shortened(mechanism.name, 60)}, {told}", fontsize=10, parse_math=False)

    return on_axes((_WIDTH, _WIDTH * stage.height / stage.width + 0.4), axes, path, draw)
