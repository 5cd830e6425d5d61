"""The picture of a ledger: work against precision, and the account of effects.

In: a `Ledger`. Out: a PNG file. It measures nothing.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import cycle
from pathlib import Path
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, FuncFormatter, LogLocator, NullFormatter, NullLocator

from lamc.basics.numbers import duration, shortened
from lamc.ledger.records import Ledger, Point
from lamc.ledger.verdict import power
from lamc.report.ledger_effects import GRID, draw_effects, effect_rows
from lamc.report.ledger_text import shown_name
from lamc.report.style import save
from lamc.run.methods import AUTO, METHODS

# Okabe and Ito's palette: lamc's own in colour and filled, peers in greys and open, each with a mark of its own.
_COLOURS = cycle(("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#F0E442"))
_OWN = {
    **dict(zip(METHODS, zip(_COLOURS, cycle("os^DvP"), strict=False), strict=False)),
    AUTO: ("#000000", "*"),
}
_OTHER = ("#E69F00", "#56B4E9")
_PEER_MARKS = ("o", "s", "^", "D", "v", "P")
_PEER_GREYS = ("#707070", "#8C8C8C", "#5A5A5A", "#A0A0A0")
_LABEL_SIZE = 8.0
_FAR = 1e-3  # of the least error: a floor below this is named, not drawn, as the picture would be empty up to there


@dataclass(frozen=True)
class _Curve:
    """An integrator as it is drawn."""

    name: str
    label: str
    points: list[Point]
    colour: str
    mark: str
    is_peer: bool


def draw_ledger(ledger: Ledger, path: Path) -> Path:
    """One panel of curves; a second one of effects where there are any. Raises LamcError as `save` does."""
    account = ledger.account
    rows = effect_rows(account) if account is not None else []
    height = 5.2 + (0.9 + 0.34 * len(rows) if rows else 0.0)
    figure = Figure(figsize=(8.4, height), layout="constrained")
    end = ", incomplete: interrupted" if ledger.interrupted else ""
    figure.suptitle(
        f"{shortened(ledger.design, 50)}: {ledger.sweep.t_end:g} s of motion{end}",
        fontsize=12,
        parse_math=False,
    )
    if rows and account is not None:
        parts: Any = figure.subfigures(2, 1, height_ratios=[5.0, 0.9 + 0.34 * len(rows)])
        upper, lower = parts
        _draw_precision(upper.subplots(), ledger)
        draw_effects(lower, account, rows, ledger)
    else:
        _draw_precision(figure.subplots(), ledger)
    return save(figure, path)


def _curves(ledger: Ledger) -> list[_Curve]:
    orders = {each.integrator: each.path for each in ledger.orders}
    found = []
    others = peers = 0
    for name in dict.fromkeys(p.integrator for p in ledger.points):
        points = [
            p
            for p in ledger.points
            if p.integrator == name and p.path is not None and p.path > 0.0 and p.seconds
        ]
        if not points:
            continue
        points.sort(key=lambda p: -p.setting)
        is_peer = points[0].is_peer
        if is_peer:
            colour, mark = _PEER_GREYS[peers % len(_PEER_GREYS)], _PEER_MARKS[peers % len(_PEER_MARKS)]
            peers += 1
        elif name in _OWN:
            colour, mark = _OWN[name]
        else:
            colour, mark = _OTHER[others % len(_OTHER)], "X"
            others += 1
        order = orders.get(name)
        label = shown_name(name) + (f", order {order:.1f}" if order is not None else "")
        found.append(_Curve(name, label, points, colour, mark, is_peer))
    return found


def _draw_precision(axis: Axes, ledger: Ledger) -> None:
    curves = _curves(ledger)
    floor = ledger.reference.uncertainty
    errors = [p.path for c in curves for p in c.points if p.path is not None]
    times = [p.seconds for c in curves for p in c.points if p.seconds is not None]
    if not errors:
        axis.text(0.5, 0.5, "no setting reaches the end", ha="center", transform=axis.transAxes)
        return
    axis.set_xscale("log")
    axis.set_yscale("log")
    most = min(max(errors) * 4.0, 10.0)
    least = max(min(min(errors) / 3.0, floor / 10.0 if floor > _FAR * min(errors) else 1.0), 1e-16)
    axis.set_xlim(most, least)  # more exact to the right
    axis.set_ylim(min(times) / 2.0, max(times) * 2.0)
    _draw_floor(axis, floor, least)
    for curve in sorted(curves, key=lambda c: not c.is_peer):
        _draw_curve(axis, curve)
    _slope_guides(axis, most, least, curves)
    _end_labels(axis, curves)
    axis.set_xlabel("largest error of the outputs, over the largest range of one")
    axis.set_ylabel("processor time of a run [s]")
    loosest, tightest = max(ledger.sweep.tolerances), min(ledger.sweep.tolerances)
    axis.set_title(
        f"Work against precision: rtol {power(loosest)} to {power(tightest)} along each curve",
        fontsize=9.5,
        loc="left",
    )
    if any(curve.is_peer for curve in curves):
        axis.text(
            0.012, 0.985, "dashed: peers; scipy and CVODE call\nlamc's equations from Python", fontsize=7,
            color="#777777", va="top", transform=axis.transAxes,
        )  # fmt: skip
    _finish(axis)


def _draw_floor(axis: Axes, floor: float, least: float) -> None:
    """What the two runs of the reference differ by: below it errors are not told apart. A floor beyond the axis is
    named at its end."""
    style: dict[str, Any] = {"fontsize": 7, "color": "#777777", "va": "bottom"}
    if floor > least:
        axis.axvspan(floor, least, color="#EDEDED", zorder=0)
        axis.axvline(floor, color="#9A9A9A", linewidth=0.9, linestyle=":", zorder=1)
        axis.annotate(
            f"floor {floor:.0e}:\nnot told apart below", (floor, 0.02), xycoords=("data", "axes fraction"),
            xytext=(3, 0), textcoords="offset points", **style,
        )  # fmt: skip
    else:
        axis.text(0.988, 0.02, f"floor {floor:.0e} →", transform=axis.transAxes, ha="right", **style)


def _draw_curve(axis: Axes, curve: _Curve) -> None:
    x = [p.path or math.nan for p in curve.points]
    y = [p.seconds or math.nan for p in curve.points]
    style: dict[str, Any] = {"color": curve.colour, "marker": curve.mark}
    if curve.is_peer:
        axis.plot(
            x, y, linestyle=(0, (4, 2)), linewidth=0.9, markersize=4.5, markerfacecolor="white", **style
        )
    else:
        is_choice = curve.name == "auto"  # lies on others' curves: thin, so that they show
        axis.plot(x, y, linewidth=1.0 if is_choice else 1.6, markersize=7.0 if is_choice else 4.8, **style)


def _slope_guides(axis: Axes, most: float, least: float, curves: Sequence[_Curve]) -> None:
    """Short lines of the slopes of theory, time ~ error^(-1/order), below the curves."""
    bottom = axis.get_ylim()[0]
    own = [p.seconds for c in curves if not c.is_peer for p in c.points if p.seconds]
    start_y = bottom * 1.25
    if own and min(own) / bottom < 1.6:
        axis.set_ylim(bottom / 3.0, axis.get_ylim()[1])
        start_y = axis.get_ylim()[0] * 1.3
    decades = math.log10(most / least)
    begin = most * 10 ** (-0.45 * decades)
    end = begin * 10 ** (-0.22 * decades)
    for order in (4, 5, 8):
        top = start_y * (begin / end) ** (1.0 / order)
        axis.plot([begin, end], [start_y, top], color="#9A9A9A", linewidth=0.9, zorder=1)
        axis.annotate(
            str(order),
            (end, top),
            xytext=(3, 0),
            textcoords="offset points",
            fontsize=7,
            color="#777777",
            va="center",
        )
    axis.annotate(
        "slopes of order", (begin, start_y), xytext=(-4, 0), textcoords="offset points", fontsize=7, color="#777777",
        ha="right", va="center",
    )  # fmt: skip


def _end_labels(axis: Axes, curves: Sequence[_Curve]) -> None:
    """Names beside the axes, each at the height of its curve's end as far as they do not overlap."""
    low, high = (math.log10(v) for v in axis.get_ylim())
    ends = [(math.log10(c.points[-1].seconds or 1.0), c) for c in curves]
    ends.sort(key=lambda e: e[0])
    heights = spread([(y - low) / (high - low) for y, _ in ends], 0.047)
    for height, (y, curve) in zip(heights, ends, strict=True):
        last = curve.points[-1].path or 1.0
        axis.annotate(
            curve.label,
            (last, 10.0**y),
            xytext=(1.035, height),
            textcoords="axes fraction",
            fontsize=_LABEL_SIZE,
            color=curve.colour,
            va="center",
            ha="left",
            annotation_clip=False,
            parse_math=False,
            arrowprops={
                "arrowstyle": "-",
                "color": curve.colour,
                "linewidth": 0.5,
                "alpha": 0.6,
                "shrinkA": 2,
                "shrinkB": 4,
            },
        )


def spread(wanted: Sequence[float], gap: float) -> list[float]:
    """Ascending places as near to those wanted as `gap` between neighbours allows, within 0 … 1 where they fit."""
    placed = list(wanted)
    for _ in range(200):
        moved = False
        for k in range(len(placed) - 1):
            lack = gap - (placed[k + 1] - placed[k])
            if lack > 1e-9:
                placed[k] -= lack / 2
                placed[k + 1] += lack / 2
                moved = True
        if not moved:
            break
    if placed:
        over = max(placed[-1] - 1.0, 0.0)
        placed = [p - over for p in placed]
    return placed


def _finish(axis: Axes) -> None:
    axis.grid(visible=True, which="major", color=GRID, linewidth=0.6)
    axis.set_axisbelow(True)
    axis.spines[["top", "right"]].set_visible(False)
    axis.tick_params(labelsize=8)
    axis.xaxis.set_minor_locator(NullLocator())
    axis.xaxis.set_major_locator(LogLocator(numticks=20))
    low, high = axis.get_ylim()
    ticks = [m * 10.0**e for e in range(-7, 5) for m in (1, 3) if low <= m * 10.0**e <= high]
    if len(ticks) > 10:
        ticks = [t for t in ticks if math.isclose(math.log10(t), round(math.log10(t)), abs_tol=1e-9)]
    axis.yaxis.set_major_locator(FixedLocator(ticks))
    axis.yaxis.set_major_formatter(FuncFormatter(lambda value, _: duration(value)))
    axis.yaxis.set_minor_formatter(NullFormatter())
    axis.set_ylabel("processor time of a run")
