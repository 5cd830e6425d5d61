"""The panel of a ledger that has the effects: what leaving each out changes, and what that saves.

In: an `Account`. Out: two axes in a figure. It measures nothing.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import NullLocator

from lamc.basics.numbers import duration, shortened
from lamc.ledger.records import Account, EffectRow, Ledger
from lamc.ledger.verdict import percent, power

GRID = "#E3E3E3"
_DOUBT = "#777777"
_MOST_SHOWN = 200.0  # %, where bars end


def effect_rows(account: Account) -> list[EffectRow]:
    """Rows that are drawn, the largest change first."""
    rows = [row for row in account.rows if row.succeeded]
    if account.together is not None and account.together.succeeded and len(account.together.effects) > 1:
        rows.append(account.together)
    return sorted(rows, key=lambda row: -(row.change or 0.0))


def draw_effects(figure: Any, account: Account, rows: Sequence[EffectRow], ledger: Ledger) -> None:
    """To the left what leaving each effect out changes, to the right what that saves."""
    left, right = figure.subplots(1, 2, sharey=True, width_ratios=[2.2, 1.0])
    places = np.arange(len(rows))
    names = [_row_name(row) for row in rows]
    least = max(min([*(row.change or 1.0 for row in rows), ledger.sweep.accuracy]) / 10.0, 1e-12)
    left.set_xscale("log")
    for place, row in zip(places, rows, strict=True):
        change = max(row.change or least, least)
        left.plot([least, change], [place, place], color="#0072B2", linewidth=1.4)
        left.plot(change, place, "o", color="#0072B2", markersize=5.5)
        unsure = row.discretisation is not None and row.discretisation > least
        if unsure:
            left.plot(row.discretisation, place, "|", color=_DOUBT, markersize=9)
        end = max(change, row.discretisation or 0.0) if unsure else change
        left.annotate(
            _change_text(row),
            (end, place),
            xytext=(7, 0),
            textcoords="offset points",
            fontsize=8,
            va="center",
        )
    top = max(row.change or least for row in rows)
    left.xaxis.set_minor_locator(NullLocator())
    left.set_xlim(least, max(top, ledger.sweep.accuracy) * 30.0)
    left.axvline(ledger.sweep.accuracy, color="#D55E00", linewidth=0.9, linestyle="--")
    left.annotate(
        f"asked for: {percent(ledger.sweep.accuracy)}",
        (ledger.sweep.accuracy, 1.0),
        xycoords=("data", "axes fraction"),
        xytext=(3, 1),
        textcoords="offset points",
        fontsize=7,
        color="#D55E00",
        va="bottom",
    )
    left.set_yticks(places, names, fontsize=8, parse_math=False)
    left.invert_yaxis()
    left.set_ylim(len(rows) - 0.4, -0.6)
    left.set_title("Leaving an effect out changes the outputs by", fontsize=9.5, loc="left", pad=14)
    doubt = "\n| up to there it may be the integrator's doing"
    left.set_xlabel(f"largest change, over the largest range of an output{doubt}", fontsize=8)
    _draw_savings(right, account, rows, places)
    for axis in (left, right):
        axis.grid(visible=True, axis="x", color=GRID, linewidth=0.6)
        axis.set_axisbelow(True)
        axis.spines[["top", "right"]].set_visible(False)
        axis.tick_params(labelsize=8)


def _draw_savings(axis: Axes, account: Account, rows: Sequence[EffectRow], places: Any) -> None:
    base = account.scene.seconds or 1.0
    values = [100.0 * ((row.seconds or base) / base - 1.0) for row in rows]
    shown = [min(v, _MOST_SHOWN) for v in values]
    axis.barh(places, shown, height=0.5, color=["#009E73" if v < 0 else "#CC79A7" for v in values])
    axis.axvline(0.0, color="black", linewidth=0.8)
    reach = max(max(abs(v) for v in shown), 10.0) * 1.6
    axis.set_xlim(-reach if min(values) < 0 else -0.15 * reach, reach if max(values) > 0 else 0.15 * reach)
    for place, value, end in zip(places, values, shown, strict=True):
        text = f"{value:+.0f} %" if value <= _MOST_SHOWN else f"× {1.0 + value / 100.0:.2g}"
        axis.annotate(
            text, (end, place), xytext=(3 if value >= 0 else -3, 0), textcoords="offset points",
            fontsize=7.5, va="center", ha="left" if value >= 0 else "right",
        )  # fmt: skip
    axis.set_title("and its time by", fontsize=9.5, loc="left", pad=14)
    axis.set_xlabel(f"% of {duration(base)} ({account.integrator}, rtol {power(account.rtol)})", fontsize=8)


def _row_name(row: EffectRow) -> str:
    names = " and ".join(name.replace("_", " ") for name in row.effects)
    names += f": {row.form}" if row.form else ""
    return shortened(("with " if row.is_added else "") + names, 32)


def _change_text(row: EffectRow) -> str:
    value = row.change or 0.0
    if value >= 0.1:
        return f"{100 * value:.0f} %"
    return f"{100 * value:.2g} %" if value >= 1e-3 else power(value)
