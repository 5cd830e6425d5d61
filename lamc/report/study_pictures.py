"""Pictures of a study: lines of one thing varied, maps of two, parallel coordinates of more, and of samples.

In: a `Table`, the path of a picture. Out: the file. Points without a measure are gaps in lines, hatched in maps and
grey in parallel coordinates. It computes nothing but scales.
"""

from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from lamc.basics.numbers import prefixed, shortened
from lamc.report.curves import dress
from lamc.report.style import PALETTE, WORLD, save
from lamc.run.request import Array
from lamc.studies.axes import Span
from lamc.studies.plans import Grid
from lamc.studies.table import Table

MOST_POINTS = 2_000_000  # that are drawn
_MOST_PANELS, _MOST_PATHS = 8, 3000
_WIDTH, _PANEL = 7.5, 3.0  # inches: of all, and height of a panel
_MAP = "viridis"  # even in lightness, so that it is read without colours too


def draw_study(table: Table, path: Path) -> Path:
    """One panel for each measure, eight at most. Raises LamcError if `path` cannot be written."""
    measures = list(table.values)[:_MOST_PANELS]
    kind = _kind(table)
    wide = _WIDTH + (1.6 * max(len(table.plan.names) - 4, 0) if kind is _parallel else 0.0)
    figure = Figure(figsize=(wide, 0.7 + _PANEL * len(measures)), layout="constrained")
    left = len(table.values) - len(measures)
    more = f" ({left} more measures are in the table)" if left else ""
    figure.suptitle(f"{shortened(table.design, 60)}{more}", fontsize=13, parse_math=False)
    axes: list[Axes] = list(np.ravel(figure.subplots(len(measures), 1)))
    for axis, name in zip(axes, measures, strict=True):
        kind(axis, table, name)
    return save(figure, path)


def _kind(table: Table) -> Any:
    if not isinstance(table.plan, Grid):
        return _parallel if len(table.plan.names) > 1 else _scatter
    varied = sum(length > 1 for length in table.plan.shape)
    return _lines if varied <= 1 else _map if varied == 2 else _parallel


def _scaled(values: Array, unit: str) -> tuple[Array, str]:
    """Values in a unit that suits them, and its text in brackets."""
    if unit in ("rad", "rad/s"):
        return np.degrees(values), f" [{unit.replace('rad', '°')}]"
    known = np.abs(values[np.isfinite(values)])
    scale, text = prefixed(float(known.max(initial=0.0)), "" if unit == "1" else unit)
    return values / scale, f" [{text}]" if text else ""


def _label(name: str, bracket: str) -> str:
    return shortened(name, 34) + bracket


def _is_log(table: Table, name: str) -> bool:
    axis = table.plan.axes[name] if isinstance(table.plan, Grid) else None
    return isinstance(axis, Span) and axis.log


def _axis_values(table: Table, name: str) -> Array:
    assert isinstance(table.plan, Grid)
    axis = table.plan.axes[name]
    return np.array([axis.value(k) for k in range(len(axis))])


def _varied(table: Table) -> list[str]:
    """Names that take more than one value; one at least."""
    assert isinstance(table.plan, Grid)
    found = [name for name, length in zip(table.plan.names, table.plan.shape, strict=True) if length > 1]
    return found or [table.plan.names[0]]


def _lines(axis: Axes, table: Table, measure: str) -> None:
    (name,) = _varied(table)
    x, x_unit = _scaled(_axis_values(table, name), table.units[name])
    y, y_unit = _scaled(table.values[measure], table.units[measure])
    order = np.argsort(x)
    few = len(x) <= 60
    axis.plot(x[order], y[order], color=PALETTE[0], marker="o" if few else None, markersize=4, linewidth=1.5)
    for at in x[~np.isfinite(y)][:200]:
        axis.axvline(at, color=WORLD, linestyle=":", linewidth=1.0)
    if not np.isfinite(y).all():
        axis.plot([], [], color=WORLD, linestyle=":", label="no measure")
        axis.legend(fontsize=8, frameon=False)
    _titled(axis, _label(name, x_unit), _label(measure, y_unit), log=_is_log(table, name))


def _scatter(axis: Axes, table: Table, measure: str) -> None:
    name = table.plan.names[0]
    x, x_unit = _scaled(table.points()[:, 0], table.units[name])
    y, y_unit = _scaled(table.values[measure], table.units[measure])
    axis.plot(x, y, color=PALETTE[0], linestyle="none", marker="o", markersize=3, alpha=0.6)
    _titled(axis, _label(name, x_unit), _label(measure, y_unit), log=False)


def _titled(axis: Axes, x: str, y: str, *, log: bool) -> None:
    dress(axis)
    if log:
        axis.set_xscale("log")
    axis.set_xlabel(x, parse_math=False)
    axis.set_ylabel(y, parse_math=False)


def _map(axis: Axes, table: Table, measure: str) -> None:
    assert isinstance(table.plan, Grid)
    first, second = _varied(table)
    x, x_unit = _scaled(_axis_values(table, second), table.units[second])
    y, y_unit = _scaled(_axis_values(table, first), table.units[first])
    values, unit = _scaled(table.values[measure], table.units[measure])
    grid = values.reshape([length for length in table.plan.shape if length > 1])
    columns, rows = np.argsort(x), np.argsort(y)
    grid = grid[np.ix_(rows, columns)]
    logs = _is_log(table, second), _is_log(table, first)
    edges = [_edges(np.sort(each), log=log) for each, log in zip((x, y), logs, strict=True)]
    known = np.ma.masked_invalid(grid)
    image = axis.pcolormesh(*edges, known, cmap=_MAP, shading="flat", rasterized=True)
    if np.ma.is_masked(known):
        axis.patch.set(facecolor="white", edgecolor=WORLD, hatch="///", linewidth=0.0)
        patch = Patch(facecolor="white", edgecolor=WORLD, hatch="///", label="no measure")
        axis.legend(handles=[patch], fontsize=8, loc="lower left", bbox_to_anchor=(0.0, 1.0), frameon=False)
    bar = axis.figure.colorbar(image, ax=axis)
    bar.set_label(_label(measure, unit), parse_math=False)
    for log, set_scale in zip(logs, (axis.set_xscale, axis.set_yscale), strict=True):
        if log:
            set_scale("log")
    axis.set_xlabel(_label(second, x_unit), parse_math=False)
    axis.set_ylabel(_label(first, y_unit), parse_math=False)


def _edges(centres: Array, *, log: bool) -> Array:
    """Edges (n + 1,) of cells about centres (n,), ascending."""
    at = np.log(centres) if log else centres
    if len(at) == 1:
        at = np.array([at[0] - 0.5, at[0] + 0.5])
        return np.exp(at) if log else at
    middle = 0.5 * (at[1:] + at[:-1])
    edges = np.concatenate([[2.0 * at[0] - middle[0]], middle, [2.0 * at[-1] - middle[-1]]])
    return np.exp(edges) if log else edges


def _parallel(axis: Axes, table: Table, measure: str) -> None:
    """A line for each point over an upright axis for each name and the measure, coloured by the measure."""
    points, values = table.points(), table.values[measure]
    chosen = _spread_out(len(values))
    columns = [*(points[chosen, k] for k in range(points.shape[1])), values[chosen]]
    names = [*table.plan.names, measure]
    logs = [_is_log(table, name) for name in table.plan.names] + [False]
    colours, known = mpl.colormaps[_MAP], values[np.isfinite(values)]
    low, high = (float(known.min()), float(known.max())) if known.size else (0.0, 1.0)
    paths = np.column_stack([_unit(column, log=log) for column, log in zip(columns, logs, strict=True)])
    norm = Normalize(low, high if high > low else low + 1.0)
    for path, value in zip(paths, columns[-1], strict=True):
        if np.isfinite(value):
            axis.plot(path, color=colours(norm(value)), linewidth=0.8, alpha=0.7)
        else:
            axis.plot(path[:-1], color=WORLD, linewidth=0.8, linestyle=":")
    for k, (name, column) in enumerate(zip(names, columns, strict=True)):
        axis.plot([k, k], [0.0, 1.0], color="black", linewidth=0.8)
        scaled, bracket = _scaled(column[np.isfinite(column)], table.units[name])
        for end, at, where in ((np.min, 0.0, "top"), (np.max, 1.0, "bottom")):
            if scaled.size:
                axis.annotate(
                    f"{end(scaled):.4g}",
                    (k, at),
                    (0, -3 if at == 0.0 else 3),
                    textcoords="offset points",
                    ha="center",
                    va=where,
                    fontsize=8,
                )
        axis.annotate(
            f"{shortened(name, 22)}{bracket}",
            (k, 0.0),
            (0, -18 - 12 * (k % 2)),  # two lines, so that long names do not meet
            textcoords="offset points",
            ha="center",
            va="top",
            fontsize=9,
            parse_math=False,
            annotation_clip=False,
        )
    axis.set(xlim=(-0.4, len(names) - 0.6), ylim=(-0.3, 1.12))
    axis.axis("off")
    if not np.isfinite(values).all():
        axis.plot([], [], color=WORLD, linestyle=":", label="no measure")
        axis.legend(fontsize=8, frameon=False, loc="upper left", bbox_to_anchor=(0.0, 1.16))
    if len(chosen) < len(values):
        axis.set_title(f"{len(chosen)} of {len(values)} points", fontsize=9, loc="right")


def _spread_out(count: int) -> "np.ndarray[Any, np.dtype[np.int64]]":
    """Numbers of the points that are drawn: all, or evenly chosen ones."""
    return np.unique(np.linspace(0, count - 1, min(count, _MOST_PATHS)).astype(np.int64))


def _unit(column: Array, *, log: bool) -> Array:
    """Values from 0, the least, to 1, the most; half where all are equal."""
    at = np.log(column) if log else column
    known = at[np.isfinite(at)]
    if not known.size or known.max() == known.min():
        return np.where(np.isfinite(at), 0.5, np.nan)
    shares: Array = (at - known.min()) / (known.max() - known.min())
    return shares
