"""Pictures of plates: mesh, deflection, moments, modes.

In: a `Problem`, values at its mesh's points or at the corners of its cells. Out: PNG files. Every colour bar has its
unit, and every line its entry in the legend. Never: computes a field.
"""

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator

from lamc.basics.checks import Array
from lamc.basics.numbers import shortened
from lamc.plates.meshing.mesh import Mesh
from lamc.plates.problem import Problem
from lamc.report.plate_contours import Field, draw_contours, triangulation
from lamc.report.plate_insets import draw_insets, slivers
from lamc.report.plate_marks import Scale, draw_loads, draw_outline, draw_supports, region_borders, scale_of
from lamc.report.plate_solid import REST, bent, box, view_aspect
from lamc.report.style import PALETTE, save

_VISIBLE = 50_000  # cells of a mesh that is drawn; more are smaller than four pixels
_COLUMNS = 4  # of a legend


def draw_mesh(problem: Problem, path: Path, title: str, loads: Sequence[Any] = ()) -> Path:
    """Writes `mesh_figure`. Raises LamcError if it cannot write."""
    return save(mesh_figure(problem, title, loads), path)


def mesh_figure(problem: Problem, title: str, loads: Sequence[Any] = ()) -> Figure:
    """Cells, regions in colours, supports and loads."""
    mesh, scale = problem.mesh, scale_of(problem.size)
    figure, axis = _plan(mesh, 6.4)
    handles: list[Line2D] = []
    names = [name or "the rest" for name in mesh.region_names]
    if len(names) > 1:
        for index, name in enumerate(names):
            colour = PALETTE[index % len(PALETTE)]
            axis.tripcolor(
                triangulation(mesh, scale, mesh.regions == index),
                np.zeros(len(mesh.points)),
                cmap=ListedColormap([colour]),
                alpha=0.35,
            )
            label = f"{shortened(name, 24)}"
            handles.append(Line2D([], [], marker="s", linestyle="", color=colour, alpha=0.5, label=label))
    visible = len(mesh.cells) <= _VISIBLE
    draw_outline(axis, mesh, scale, lines=visible)
    handles += draw_supports(axis, problem, scale) + draw_loads(axis, problem, loads, scale)
    reported = f"{title}: {len(mesh.cells)} {_cells(mesh)}{'' if visible else ', too small to be drawn'}"
    _finish(figure, axis, mesh, scale, reported, handles)
    return figure


def draw_deflection(problem: Problem, w: Array, path: Path, title: str, loads: Sequence[Any] = ()) -> Path:
    """Contours of the deflection (points,) m, and the plate bent in space. Raises LamcError if it cannot write."""
    mesh, scale = problem.mesh, scale_of(problem.size)
    width, height = box(mesh)
    wide = width >= 1.6 * height  # then the two views stand above each other
    if wide:
        heights = (6.0 * height / width + 0.8, 5.6 * view_aspect(mesh) + 0.3)
        figure = Figure(figsize=(7.6, sum(heights) + 0.7), layout="constrained")
        plan, view = figure.subplots(2, 1, height_ratios=heights)
    else:
        figure = Figure(figsize=(10.6, min(4.9, 1.6 + 4.2 * height / width)), layout="compressed")
        plan, view = figure.subplots(1, 2)
    draw_contours(figure, plan, mesh, Field("deflection w", "m", w), scale)
    handles = draw_supports(plan, problem, scale) + draw_loads(plan, problem, loads, scale)
    handles += [*region_borders(mesh), Line2D([], [], color=REST, linewidth=0.9, label="at rest")]
    frame_plate(plan, mesh, scale)
    factor = bent(view, mesh, w)
    view.set_title(f"bent, deflections × {factor:g}", fontsize=9)
    figure.suptitle(shortened(title, 80), fontsize=11, parse_math=False)
    _legend(figure, handles)
    return save(figure, path)


def draw_fields(
    problem: Problem, fields: Sequence[Field], path: Path, title: str, *, marks: bool = True
) -> Path:
    """A panel of contours for each field, each with its own colour bar. Raises LamcError if it cannot write."""
    mesh, scale = problem.mesh, scale_of(problem.size)
    width, height = box(mesh)
    columns = (
        1
        if width >= 2.2 * height
        else 2
        if width >= 1.6 * height and len(fields) > 2
        else min(3, len(fields))
    )
    lines = math.ceil(len(fields) / columns)
    panel = 10.5 / columns if columns > 1 else 7.4
    tall = min(max(panel * 0.72 * height / width, 1.1), 5.0) + (2.3 if slivers(problem) else 1.1)
    layout: Any = "compressed" if columns > 1 else "constrained"
    figure = Figure(figsize=(panel * columns, tall * lines + 0.9), layout=layout)
    axes = np.atleast_1d(figure.subplots(lines, columns)).ravel()
    handles: list[Line2D] = []
    for axis in axes[len(fields) :]:
        axis.set_axis_off()
    for axis, field in zip(axes, fields, strict=False):
        draw_contours(figure, axis, mesh, field, scale)
        if marks:
            handles = draw_supports(axis, problem, scale) + region_borders(mesh)
        frame_plate(axis, mesh, scale)
        draw_insets(axis, problem, field, scale)
    figure.suptitle(shortened(title, 80), fontsize=11, parse_math=False)
    _legend(figure, handles)
    return save(figure, path)


def draw_modes(problem: Problem, shapes: Array, titles: Sequence[str], path: Path, title: str) -> Path:
    """Each shape (points, modes) in space with its title; amplitudes mean nothing. Raises LamcError if it cannot."""
    mesh = problem.mesh
    count = shapes.shape[1]
    columns = min(3, count)
    lines = math.ceil(count / columns)
    figure = Figure(figsize=(3.4 * columns, 2.5 * lines + 0.4), layout="constrained")
    axes = np.atleast_1d(figure.subplots(lines, columns)).ravel()
    for axis in axes[count:]:
        axis.set_axis_off()
    for axis, shape, reported in zip(axes, shapes.T, titles, strict=False):
        bent(axis, mesh, shape)
        axis.set_title(reported, fontsize=9, parse_math=False)
    figure.suptitle(shortened(title, 80), fontsize=11, parse_math=False)
    figure.supxlabel("purple: up, orange: down, grey: at rest; amplitudes are arbitrary", fontsize=8)
    return save(figure, path)


def _plan(mesh: Mesh, width: float) -> tuple[Figure, Axes]:
    wide, tall = box(mesh)
    height = min(max(width * tall / wide, 1.2), 7.0)
    figure = Figure(figsize=(width + 0.8, height + 1.4), layout="constrained")
    return figure, figure.subplots()


def frame_plate(axis: Axes, mesh: Mesh, scale: Scale) -> None:
    """Limits, equal scale, labels with unit, quiet spines."""
    low, high = mesh.points.min(axis=0) * scale.per_metre, mesh.points.max(axis=0) * scale.per_metre
    margin = 0.04 * float((high - low).max())
    axis.set_xlim(low[0] - margin, high[0] + margin)
    axis.set_ylim(low[1] - margin, high[1] + margin)
    axis.set_aspect("equal")
    axis.set_xlabel(f"x [{scale.unit}]", fontsize=8)
    axis.set_ylabel(f"y [{scale.unit}]", fontsize=8)
    axis.tick_params(labelsize=7)
    for line, share in ((axis.xaxis, high[0] - low[0]), (axis.yaxis, high[1] - low[1])):
        line.set_major_locator(
            MaxNLocator(max(2, round(8 * share / (high - low).max())), steps=[1, 2, 2.5, 5, 10])
        )
    axis.spines[["top", "right"]].set_visible(False)


def _finish(
    figure: Figure, axis: Axes, mesh: Mesh, scale: Scale, title: str, handles: Sequence[Line2D]
) -> None:
    frame_plate(axis, mesh, scale)
    figure.suptitle(shortened(title, 80), fontsize=10, parse_math=False)
    figure.set_figheight(figure.get_figheight() + 0.25 * math.ceil(len(handles) / _COLUMNS))
    _legend(figure, handles)


def _legend(figure: Figure, handles: Sequence[Line2D]) -> None:
    if handles:
        legend = figure.legend(
            handles=list(handles),
            loc="outside lower center",
            ncols=min(_COLUMNS, len(handles)),
            fontsize=8,
            frameon=False,
        )
        for text in legend.get_texts():
            text.set_parse_math(False)


def _cells(mesh: Mesh) -> str:
    return "triangles" if mesh.corner_count == 3 else "quadrilaterals"
