"""Pictures of plates: mesh, deflection, moments, modes.

In: a `Problem`, values at its mesh's points or at the corners of its cells. Out: PNG files. Contours are drawn on the
mesh's own triangles (quadrilaterals split in two), so that nothing appears where the plate is not; every colour bar has
its unit. Never: computes a field.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap, Normalize
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator
from matplotlib.tri import Triangulation

from lamc.mechanism.checks import Array
from lamc.plate.meshing.mesh import Mesh
from lamc.plate.problem import Problem
from lamc.report.numbers import prefixed
from lamc.report.plan_view import shortened
from lamc.report.plate_marks import Scale, draw_loads, draw_outline, draw_supports, scale_of
from lamc.report.plate_solid import ONE_SIGN, bent, box, colours_of, split, view_aspect
from lamc.report.style import PALETTE, save

_LEVELS = 16  # at most, as many as round values allow
_RARE = 0.005  # of the area, at each end of a field
_SHARE = 1 / 3  # of the colours
_BELOW = 1e-9  # of the colour bar: less than can be seen
_SAME = 1e-9  # of the largest value: a field that varies by less is one number
_VISIBLE = 50_000  # cells of a mesh that is drawn; more are smaller than four pixels
_LINES = 40  # cells along the longer side, up to which contours show the mesh
_COLUMNS = 4  # of a legend


@dataclass(frozen=True, eq=False)
class Field:
    """A scalar over a plate.

    values  (points,) or, where it may jump between cells, (cells, corners); SI
    """

    name: str
    unit: str
    values: Array


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
    told = f"{title}: {len(mesh.cells)} {_cells(mesh)}{'' if visible else ', too small to be drawn'}"
    _finish(figure, axis, mesh, scale, told, handles)
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
    _contours(figure, plan, mesh, Field("deflection w", "m", w), scale)
    handles = draw_supports(plan, problem, scale) + draw_loads(plan, problem, loads, scale)
    _frame(plan, mesh, scale)
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
    tall = min(max(panel * 0.72 * height / width, 1.1), 5.0) + 0.75
    figure = Figure(figsize=(panel * columns, tall * lines + 0.5), layout="compressed")
    axes = np.atleast_1d(figure.subplots(lines, columns)).ravel()
    handles: list[Line2D] = []
    for axis in axes[len(fields) :]:
        axis.set_axis_off()
    for axis, field in zip(axes, fields, strict=False):
        _contours(figure, axis, mesh, field, scale)
        if marks:
            handles = draw_supports(axis, problem, scale)
        _frame(axis, mesh, scale)
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
    for axis, shape, told in zip(axes, shapes.T, titles, strict=False):
        bent(axis, mesh, shape, signed=True)
        axis.set_title(told, fontsize=9, parse_math=False)
    figure.suptitle(shortened(title, 80), fontsize=11, parse_math=False)
    return save(figure, path)


def triangulation(mesh: Mesh, scale: Scale, chosen: Array | None = None) -> Triangulation:
    """The cells as triangles, quadrilaterals split in two; `chosen` (cells,) leaves others out."""
    cells = mesh.cells if chosen is None else mesh.cells[chosen]
    x, y = mesh.points.T * scale.per_metre
    return Triangulation(x, y, split(cells))


def _loose(mesh: Mesh, scale: Scale) -> Triangulation:
    """Triangles that share no corner, for values that jump from cell to cell."""
    x, y = mesh.corners.reshape(-1, 2).T * scale.per_metre
    return Triangulation(x, y, split(np.arange(x.size).reshape(mesh.cells.shape)))


def _contours(figure: Figure, axis: Axes, mesh: Mesh, field: Field, scale: Scale) -> None:
    """Filled contours with a colour bar; what is beyond the bar's ends has their colour, and the title says so."""
    values = np.asarray(field.values, dtype=float)
    low, high = shown_range(mesh, values)
    unit_scale, unit = prefixed(max(abs(low), abs(high)), field.unit)
    shown = values / unit_scale + 0.0  # no -0
    low, high = low / unit_scale, high / unit_scale
    same = high - low <= _SAME * max(abs(low), abs(high))
    if same:  # round-off would take all colours
        low = high = 0.5 * (low + high)
        shown = np.full_like(shown, low)
    colours, norm = colours_of(low, high)
    if colours == ONE_SIGN and low * high < 0.0:  # a little of the other sign takes no colour
        low, high = (0.0, high) if high > -low else (low, 0.0)
        shown = np.clip(shown, *((0.0, None) if high > 0.0 else (None, 0.0)))
    drawn = triangulation(mesh, scale) if values.ndim == 1 else _loose(mesh, scale)
    cut = False
    if same:
        axis.tripcolor(drawn, shown.ravel(), cmap=colours, norm=norm, shading="gouraud")
        bar = figure.colorbar(
            mpl.cm.ScalarMappable(norm=norm, cmap=colours), ax=axis, pad=0.02, fraction=0.05
        )
        bar.set_ticks([low], labels=[f"{low:.6g}"])
    else:
        levels = MaxNLocator(_LEVELS, steps=[1, 2, 2.5, 5, 10]).tick_values(low, high)
        if colours == ONE_SIGN:
            norm = Normalize(levels[0], levels[-1])
        cut = shown.min() < levels[0] or shown.max() > levels[-1]
        # Not `extend`: beyond an end of PuOr it would paint the darkest colour beside a pale one. Below the last level,
        # since triangles that are on it with all their corners belong to no interval and would stay white.
        most = levels[-1] - _BELOW * (levels[-1] - levels[0])
        filled = axis.tricontourf(
            drawn, np.clip(shown, levels[0], most).ravel(), levels=levels, cmap=colours, norm=norm
        )
        bar = figure.colorbar(filled, ax=axis, pad=0.02, fraction=0.05)
    told = f"{field.name} [{unit}]" if unit else field.name
    axis.set_title(f"{told}, peaks beyond the bar" if cut else told, fontsize=9)
    bar.set_label(unit, fontsize=8)
    bar.ax.tick_params(labelsize=7)
    draw_outline(axis, mesh, scale, lines=len(mesh.cells) <= 2 * _LINES**2)


def shown_range(mesh: Mesh, values: Array) -> tuple[float, float]:
    """Ends of a colour bar for `values` (points,) or (cells, corners).

    All of them; but where a half per cent of the plate's area, as at a corner where moments are infinite, would take
    more than a third of the colours, the rest has them all.
    """
    low, high = float(values.min()), float(values.max())
    of_cells = values if values.ndim == 2 else values[mesh.cells]
    order = np.argsort(of_cells, axis=None)
    area = np.cumsum(np.repeat(mesh.areas, mesh.corner_count)[order])
    ends = np.searchsorted(area, [_RARE * area[-1], (1.0 - _RARE) * area[-1]])
    common_low, common_high = of_cells.ravel()[order][np.minimum(ends, len(order) - 1)]
    if common_high - common_low < (1.0 - _SHARE) * (high - low):
        return float(common_low), float(common_high)
    return low, high


def _plan(mesh: Mesh, width: float) -> tuple[Figure, Axes]:
    wide, tall = box(mesh)
    height = min(max(width * tall / wide, 1.2), 7.0)
    figure = Figure(figsize=(width + 0.8, height + 1.4), layout="constrained")
    return figure, figure.subplots()


def _frame(axis: Axes, mesh: Mesh, scale: Scale) -> None:
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
    _frame(axis, mesh, scale)
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
