"""The angles of many hinges at a few instants, as a table below pictures, and the numbers that name its hinges there.

In: a `Result`, rows, matplotlib axes in pixels. Out: text. It computes nothing but degrees.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patheffects import withStroke

from lamc.basics.numbers import shortened
from lamc.records.mechanism import Array
from lamc.report.stage import Stage
from lamc.run.result import Result

_TITLED = 4  # hinges, up to which the panels' titles have the angles
_MOST = 36  # hinges of a table
_BLOCKS = 3  # of the table, side by side
_LINE, _HEAD = 15.2, 26.0  # pixels
_NAME, _CELL = 0.34, 0.15  # of a block's width
_FONT = 6.5  # pt
_CLOSE = 13.0  # pixels between numbers at hinges
_UNITS = (
    (1e-2, 1.0, "s"),
    (1e-5, 1e-3, "ms"),
    (0.0, 1e-6, "µs"),
)  # from which time on, s; its size, s; its name
_HALO = [withStroke(linewidth=1.8, foreground="white")]


@dataclass(frozen=True)
class AngleTable:
    """hinges: their names, in the design's order; times: s; degrees: by hinge, one for each instant; left_out: how many
    hinges that move less are not in it."""

    hinges: tuple[str, ...]
    times: tuple[float, ...]
    degrees: tuple[tuple[float, ...], ...]
    left_out: int

    @property
    def lines(self) -> int:
        """Of a block."""
        return math.ceil(len(self.hinges) / _BLOCKS)

    @property
    def height(self) -> int:
        """Pixels."""
        return int(_HEAD + _LINE * (self.lines + (1.6 if self.left_out else 0.6)))

    def write(self, axis: Axes, width: float) -> None:
        """Writes the table over all of `axis`, `width` pixels wide: a text for each column of a block."""
        axis.set_xlim(0, width)
        axis.set_ylim(self.height, 0)
        block = min(width / _BLOCKS, 560.0)
        left = (width - _BLOCKS * block) / 2 + 20
        second, unit = next((size, name) for least, size, name in _UNITS if (max(self.times) or 1.0) >= least)
        for k in range(math.ceil(len(self.hinges) / self.lines)):
            chosen = range(k * self.lines, min((k + 1) * self.lines, len(self.hinges)))
            x = left + k * block
            names = [f"{n + 1}  {shortened(self.hinges[n], 16)}" for n in chosen]
            self._column(axis, x, [f"hinge  (at t, {unit})", *names], "left")
            for column, time in enumerate(self.times):
                cells = [f"{round(self.degrees[n][column], 1) + 0.0:.1f}°" for n in chosen]
                right = x + block * (_NAME + _CELL * (column + 1)) - 10
                self._column(axis, right, [f"{time / second:.3g}", *cells], "right")
        if self.left_out:
            text = f"and {self.left_out} more, which move less: see the table of results"
            axis.text(
                left, _HEAD + _LINE * (self.lines + 0.4), text, fontsize=_FONT, va="top", color="#555555"
            )

    @staticmethod
    def _column(axis: Axes, x: float, cells: Sequence[str], side: str) -> None:
        head, *rest = cells
        axis.text(x, 4, head, fontsize=_FONT, ha=side, va="top", color="#555555")
        axis.text(
            x,
            _HEAD - 2,
            "\n".join(rest),
            fontsize=_FONT,
            ha=side,
            va="top",
            parse_math=False,
            linespacing=1.0,
        )


def angle_table(result: Result, rows: Sequence[int]) -> AngleTable | None:
    """The table of a run at some rows; None where the panels' titles can hold the angles."""
    named = result.hinges
    if len(named) <= _TITLED:
        return None
    angles = {name: np.degrees(result.angle(name)) for name in named}
    kept = set(sorted(named, key=lambda name: -float(np.ptp(angles[name])))[:_MOST])
    shown = tuple(name for name in named if name in kept)
    values = tuple(tuple(float(angles[name][row]) for row in rows) for name in shown)
    return AngleTable(shown, tuple(float(result.t[row]) for row in rows), values, len(named) - len(shown))


def number_hinges(axis: Axes, stage: Stage, table: AngleTable) -> None:
    """The numbers of the table's hinges at their lines at the first instant. Axes have the picture's pixels."""
    places = {joint.name: k for k, joint in enumerate(stage.solid.mechanism.joints)}
    middles = stage.project(0, stage.solid.hinges).mean(axis=1)
    taken: list[Array] = []
    for number, name in enumerate(table.hinges):
        x, y, _ = middles[places[name]]
        here = np.array([x, y])
        if any(float(np.abs(here - other).max()) < _CLOSE for other in taken):
            continue  # a number over another names neither; those beside it tell where it is
        taken.append(here)
        axis.text(
            stage.width / 2 + x,
            stage.height / 2 - y,
            str(number + 1),
            fontsize=5.5,
            ha="center",
            va="center",
            path_effects=_HALO,
        )
