"""The benchmark of one design as a table and as a picture.

In: a `Bench`. Out: plain text, and a PNG file. It measures nothing.
"""

from pathlib import Path
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine

from lamc.basics.numbers import duration, shortened
from lamc.ledger.bench import Bench, Row
from lamc.report.style import save

_COLOURS = ("#9A9A9A", "#E69F00", "#56B4E9", "#0072B2")
_HEADS = ("way", "derive", "print", "compile", "per evaluation", "per simulated second", "flops", "× C")


def bench_table(bench: Bench) -> str:
    """A line per way, then what the marks mean."""
    fastest = bench.rows[-1]
    rows = [_cells(row, fastest) for row in bench.rows]
    widths = [max(len(row[k]) for row in (_HEADS, *rows)) for k in range(len(_HEADS))]
    lines = [
        f"{shortened(bench.design, 40)}: {_hinges(bench)}, effects: {', '.join(bench.effects) or 'none'}",
        "",
    ]
    for row in (_HEADS, tuple("-" * w for w in widths), *rows):
        cells = [
            cell.ljust(w) if k == 0 else cell.rjust(w)
            for k, (cell, w) in enumerate(zip(row, widths, strict=True))
        ]
        lines.append("  ".join(cells).rstrip())
    lines.append("")
    lines.append(
        f"RK45 at rtol 1e-6; {bench.evaluations} evaluations by the generated C in one simulated second."
    )
    lines.append(
        "Flops: sympy's include sin, cos and what depends on parameters only, which the others do once."
    )
    if any(row.extrapolated for row in bench.rows):
        lines.append("* extrapolated: that number of evaluations, times the time of one.")
    lines.extend(bench.notes)
    return "\n".join(lines)


def _cells(row: Row, fastest: Row) -> tuple[str, ...]:
    return (
        row.name,
        duration(row.derive),
        duration(row.prints),
        duration(row.compiles) if row.compiles is not None else "none",
        duration(row.evaluation * 1e-9),
        duration(row.second) + ("*" if row.extrapolated else " "),
        str(row.flops),
        f"{row.evaluation / fastest.evaluation:.3g}",
    )


def _hinges(bench: Bench) -> str:
    return f"{bench.hinges} hinge{'' if bench.hinges == 1 else 's'}"


def draw_bench(bench: Bench, path: Path) -> Path:
    """Bars on logarithmic scales: time per evaluation, time per simulated second. Raises LamcError as `save` does."""
    figure = Figure(figsize=(10.5, 3.6), layout=ConstrainedLayoutEngine(w_pad=0.1, h_pad=0.08))
    left, right = figure.subplots(1, 2, sharey=True)
    figure.suptitle(
        f"{shortened(bench.design, 50)}: symbolic against generated ({_hinges(bench)})",
        fontsize=12,
        parse_math=False,
    )
    names = [row.name for row in bench.rows]
    _bars(left, names, [row.evaluation * 1e-9 for row in bench.rows], [""] * len(names))
    marks = ["*" if row.extrapolated else "" for row in bench.rows]
    _bars(right, names, [row.second for row in bench.rows], marks)
    left.invert_yaxis()  # both: the panels share it
    left.set_xlabel("time per evaluation of the right-hand side [s]")
    extrapolated = "\n* extrapolated from the time of one evaluation" if any(marks) else ""
    right.set_xlabel(f"time per simulated second [s], RK45 at rtol 1e-6{extrapolated}")
    return save(figure, path)


def _bars(axis: Axes, names: list[str], seconds: list[float], marks: list[str]) -> None:
    places: Any = range(len(names))
    axis.barh(places, seconds, color=_COLOURS, height=0.62)
    axis.set_yticks(places, names)
    axis.set_xscale("log")
    low, high = min(seconds) / 4, max(seconds) * 40  # room for the labels
    axis.set_xlim(low, high)
    for place, value, mark in zip(places, seconds, marks, strict=True):
        axis.text(value * 1.25, place, duration(value) + mark, va="center", fontsize=9)
    axis.grid(visible=True, axis="x", color="#DDDDDD", linewidth=0.6)
    axis.set_axisbelow(True)
    axis.spines[["top", "right"]].set_visible(False)
