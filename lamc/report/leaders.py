"""Names beside a drawing, each with a line to what it names, where they would not fit in it.

In: points and names, a `View`, matplotlib axes. Out: artists above and below the drawing. It moves no point.
"""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes

from lamc.basics.numbers import shortened
from lamc.records.mechanism import Array
from lamc.report.plan_view import View

ROOM = 0.62  # inches that the names take above, and below
_FONTS = (8.0, 7.0, 6.0, 5.0)  # pt, the largest at which a row holds its names
_LETTER, _GAP = 0.60, 0.7  # em: of a letter, between names
_ROWS = 2  # of names, above and below
_LINE = "#777777"
_SHOWN = 16  # letters of a name


def label_beside(axis: Axes, points: Array, names: Sequence[str], view: View, colours: Sequence[str]) -> str:
    """Writes names of points (n, 2), m, in their colours above and below the drawing, with lines. Returns a note where
    not all fit."""
    upper = float(view.high[1]) + 0.04 / view.inches_per_metre
    lower = float(view.low[1]) - 0.04 / view.inches_per_metre
    middle = (upper + lower) / 2
    shown = [shortened(name, _SHOWN) for name in names]
    above = [k for k in range(len(names)) if points[k, 1] >= middle]
    left_out = 0
    for chosen, edge, sign in (
        (above, upper, 1),
        ([k for k in range(len(names)) if k not in above], lower, -1),
    ):
        order = sorted(chosen, key=lambda k: (points[k, 0], -sign * points[k, 1]))
        for row in range(_ROWS):
            left_out += _row(axis, points, shown, view, colours, order[row::_ROWS], edge, sign, row)
    return f"{left_out} names do not fit here and are left out." if left_out else ""


def raise_limits(axis: Axes, view: View) -> None:
    """Makes room for the names above and below what `frame` shows."""
    room = ROOM / view.inches_per_metre * view.per_metre
    low, high = axis.get_ylim()
    axis.set_ylim(low - room, high + room)


def _row(
    axis: Axes,
    points: Array,
    names: Sequence[str],
    view: View,
    colours: Sequence[str],
    order: Sequence[int],
    edge: float,
    sign: int,
    row: int,
) -> int:
    """One row of names in their order from left to right. Returns how many are left out."""
    if not order:
        return 0
    width = (view.high[0] - view.low[0]) * view.inches_per_metre * 72  # pt
    for font in _FONTS:
        needed = np.array([(_LETTER * len(names[k]) + _GAP) * font for k in order])
        if needed.sum() <= width:
            break
    else:
        fits = int(np.searchsorted(np.cumsum(needed), width))
        return len(order) - fits + _row(axis, points, names, view, colours, order[:fits], edge, sign, row)
    wanted = (points[list(order), 0] - view.low[0]) * view.inches_per_metre * 72
    places = _apart(wanted, needed, width) / 72 / view.inches_per_metre + view.low[0]
    height = edge + sign * (0.16 + 0.22 * row) / view.inches_per_metre
    scale = view.per_metre
    for k, x in zip(order, places, strict=True):
        axis.annotate(
            names[k],
            (float(points[k, 0]) * scale, float(points[k, 1]) * scale),
            (float(x) * scale, height * scale),
            fontsize=font,
            color=colours[k],
            ha="center",
            va="bottom" if sign > 0 else "top",
            annotation_clip=False,
            parse_math=False,
            arrowprops={"arrowstyle": "-", "color": _LINE, "linewidth": 0.5, "shrinkA": 1, "shrinkB": 0},
            zorder=7,
        )
        axis.plot(
            [float(points[k, 0]) * scale],
            [float(points[k, 1]) * scale],
            "o",
            color=_LINE,
            markersize=1.8,
            zorder=7,
        )
    return 0


def _apart(wanted: Array, needed: Array, width: float) -> Array:
    """Middles of intervals of lengths `needed`, near to `wanted` and in its order, that do not overlap in 0 … width."""
    places = wanted.copy()
    for _ in range(2):
        least = 0.0
        for k in range(len(places)):
            places[k] = max(places[k], least + needed[k] / 2)
            least = places[k] + needed[k] / 2
        most = width
        for k in reversed(range(len(places))):
            places[k] = min(places[k], most - needed[k] / 2)
            most = places[k] - needed[k] / 2
    return places
