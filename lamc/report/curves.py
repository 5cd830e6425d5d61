"""Curves over time on one pair of axes, with a legend in their order and curves that coincide told.

In: times, curves of one unit, matplotlib axes. Out: artists. It computes nothing but which curves coincide.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.colors import Normalize
from matplotlib.font_manager import FontProperties
from matplotlib.ticker import FuncFormatter, LogLocator, MaxNLocator, NullLocator

from lamc.basics.numbers import shortened
from lamc.records.mechanism import Array
from lamc.report.style import add_legend, curve_style

NAMED_CURVES = (
    24  # with more curves than this, colour goes by position and a colour bar takes the legend's place
)
_SAME = 2e-3  # of what the axes show: less than the width of a line
_WIDTH, _WIDER, _WIDEST = 1.5, 1.6, 7.0  # pt: of a line, each line below it that coincides, and of any
_PER_COLUMN = 14  # entries of a legend


@dataclass(frozen=True, eq=False)
class Curve:
    """values: (m,), in the axes' unit; colour and dash: those of its place where None."""

    name: str
    values: Array
    colour: str | None = None
    dash: str | None = None


def draw_curves(axis: Axes, t: Array, curves: Sequence[Curve]) -> None:
    """Draws the curves, those that coincide as bands of all their colours, and their legend."""
    if len(curves) > NAMED_CURVES:
        _draw_many(axis, t, curves)
        return
    groups = coinciding([curve.values for curve in curves])
    below = {k: len(group) - place - 1 for group in groups for place, k in enumerate(group)}
    lines: list[Any] = []
    for index, curve in enumerate(curves):
        colour, dash = curve_style(index)
        lines += axis.plot(
            t,
            curve.values,
            color=curve.colour or colour,
            linestyle=curve.dash or dash,
            linewidth=min(_WIDTH + _WIDER * below[index], _WIDEST),
            solid_capstyle="butt",
            marker="o" if len(t) == 1 else None,
        )
    alike = {k: number for number, group in enumerate(groups) if len(group) > 1 for k in group}
    numbers = {found: n + 1 for n, found in enumerate(dict.fromkeys(alike.values()))}
    names = [
        shortened(curve.name, 24) + (f"  (= {numbers[alike[k]]})" if k in alike and len(numbers) > 1 else "")
        for k, curve in enumerate(curves)
    ]
    legend = add_legend(axis, lines, names, math.ceil(len(curves) / _PER_COLUMN))
    for handle in legend.get_lines():
        handle.set_linewidth(1.8)
    if alike:
        legend.set_alignment("left")
        legend.set_title(
            "same number: they coincide" if len(numbers) > 1 else _coincide(groups, curves),
            prop=FontProperties(size=7),
        )


def _coincide(groups: Sequence[Sequence[int]], curves: Sequence[Curve]) -> str:
    (group,) = [group for group in groups if len(group) > 1]
    if len(group) == len(curves):
        return "all coincide"
    if len(group) > 3:
        return f"{len(group)} of them coincide"
    return " = ".join(shortened(curves[k].name, 10) for k in group)


def coinciding(values: Sequence[Array]) -> list[list[int]]:
    """Places of curves in groups that no eye tells apart, in their order."""
    known = [v[np.isfinite(v)] for v in values]
    span = max((float(np.ptp(v)) for v in known if v.size), default=0.0)
    if known and all(v.size for v in known):
        span = max(span, float(max(v.max() for v in known) - min(v.min() for v in known)))
    groups: list[list[int]] = []
    for k, each in enumerate(values):
        for group in groups:
            if (
                np.array_equal(each, values[group[0]])
                or np.abs(each - values[group[0]]).max(initial=0.0) < _SAME * span
            ):
                group.append(k)
                break
        else:
            groups.append([k])
    return groups


def dress(axis: Axes) -> None:
    """Grid, ticks and spines as all curves have them."""
    axis.grid(visible=True, color="#DDDDDD", linewidth=0.6)
    axis.spines[["top", "right"]].set_visible(False)
    if axis.get_yscale() == "log":
        _tick_logarithms(axis)
    else:
        axis.yaxis.set_major_locator(MaxNLocator(nbins=7, steps=[1, 2, 2.5, 5, 10]))
    axis.set_axisbelow(True)


def _tick_logarithms(axis: Axes) -> None:
    """Ticks of a logarithmic axis, three of them at least and all labelled: matplotlib labels powers of ten alone, of
    which a short axis has one or none."""
    low, high = axis.get_ylim()
    if high >= 1000.0 * low:
        return
    if high >= 10.0 * low:
        axis.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    else:
        axis.yaxis.set_major_locator(MaxNLocator(nbins=5, steps=[1, 2, 2.5, 5, 10]))
    axis.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axis.yaxis.set_minor_locator(NullLocator())


def _draw_many(axis: Axes, t: Array, curves: Sequence[Curve]) -> None:
    colours = mpl.colormaps["viridis"]
    count = len(curves)
    lines = np.stack([np.broadcast_to(t, (count, len(t))), [curve.values for curve in curves]], axis=2)
    tints = colours(np.arange(count) / (count - 1))
    axis.add_collection(LineCollection(list(lines), colors=tints, linewidths=0.8, joinstyle="round"))
    axis.autoscale_view()
    scale = mpl.cm.ScalarMappable(norm=Normalize(1, count), cmap=colours)
    place = axis.inset_axes((1.02, 0.0, 0.02, 1.0))
    bar = axis.figure.colorbar(scale, cax=place)
    bar.set_label(
        f"{shortened(curves[0].name, 14)} (1) to {shortened(curves[-1].name, 14)} ({count})", fontsize=8
    )
    bar.ax.tick_params(labelsize=7)
