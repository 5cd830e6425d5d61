"""Modes as pictures: the device at both ends of each mode's swing, over its equilibrium.

In: `Modes`. Out: a PNG, SVG or PDF file. Swings are as large as asked for, or as loops close. All panels share one view
and one scale, so that shapes compare; nothing is stretched.
"""

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from lamc.basics.errors import SimulationError
from lamc.basics.numbers import length_text, shortened
from lamc.report.look import Look
from lamc.report.modes_text import motion, moving
from lamc.report.raster import Pixels
from lamc.report.stage import stage_of
from lamc.report.style import DPI, save
from lamc.run.as_result import as_result
from lamc.run.request import Array
from lamc.run.vibration import Mode, Modes, cycle

_LONGEST = 440  # pixels of a panel
_FAINT = 0.28  # of the equilibrium's colours
_HEAD, _TITLE, _FOOT, _GAP = 44, 62, 26, 22  # pixels: of the sheet, above and below a mode, between panels
_WIDE = 0.6  # of a letter's size, of an average one: DejaVu Sans
_HALVED = 5  # times, until loops close


@dataclass(frozen=True, eq=False)
class _Swing:
    """A mode's ends (nq,), and the amplitude, rad, of what moves most there."""

    mode: Mode
    amplitude: float
    back: Array
    forth: Array


def draw_modes(found: Modes, path: Path, count: int, amplitude: float, look: Look | None = None) -> Path:
    """The first `count` modes, two panels each. amplitude: rad, of what moves most. Raises LamcError if it cannot
    write."""
    look = look or Look()
    swings = [_swing(found, mode, amplitude) for mode in found.modes[:count]]
    rest = found.point.stand.rest
    places = [found.point.stand.q, *(q for swing in swings for q in (swing.back, swing.forth))]
    rows = np.vstack([rest.row(q) for q in places])
    result = as_result(found.simulator, found.point.motion, np.arange(float(len(rows))), rows, "")
    stage = stage_of(result, result.t, look.size or _LONGEST, look.camera)
    faint = stage.draw(0)
    panels = [_over(stage.draw(k), faint) for k in range(1, len(rows))]
    sheet = _Sheet(len(swings), stage.width, stage.height)
    name = shortened(found.point.motion.model.name, 60)
    sheet.write(0.5, 12, f"{name}: modes about its equilibrium, which is {found.point.kind}", 12)
    for k, swing in enumerate(swings):
        lines = (
            f"mode {k + 1}: {_title(swing.mode, found)}",
            f"of what moves most: {motion(swing.mode, 3)}",
        )
        size = _size(swing, found)
        sheet.show(k, panels[2 * k : 2 * k + 2], lines, (f"-{size}", f"+{size}"))
    return save(sheet.figure, path)


class _Sheet:
    """Modes in lines, two panels of width by height pixels each."""

    def __init__(self, count: int, width: int, height: int) -> None:
        self.columns = 1 if count <= 2 else 2
        self.panel = (width, height)
        self.cell = (max(2 * width + 3 * _GAP, 680), height + _TITLE + _FOOT)
        self.width = self.columns * self.cell[0]
        self.height = _HEAD + math.ceil(count / self.columns) * self.cell[1]
        self.figure = Figure(figsize=(self.width / DPI, self.height / DPI), dpi=DPI)

    def show(self, index: int, panels: list[Pixels], lines: tuple[str, str], labels: tuple[str, str]) -> None:
        """A mode: what it is, and its two ends, with what they are below them."""
        line, column = divmod(index, self.columns)
        left, top = column * self.cell[0], _HEAD + line * self.cell[1]
        wide, tall = self.panel
        middle = (left + self.cell[0] / 2) / self.width
        self.write(middle, top + 6, lines[0], 10.5, self.cell[0])
        self.write(middle, top + 32, lines[1], 8.5, self.cell[0])
        first = left + (self.cell[0] - 2 * wide - _GAP) / 2
        for k, (picture, label) in enumerate(zip(panels, labels, strict=True)):
            x, bottom = first + k * (wide + _GAP), top + _TITLE + tall
            place = (x / self.width, 1 - bottom / self.height, wide / self.width, tall / self.height)
            axis = self.figure.add_axes(place)
            axis.imshow(picture, interpolation="nearest", aspect="auto")
            axis.set_axis_off()
            self.write((x + wide / 2) / self.width, bottom + 2, label, 9)

    def write(self, across: float, down: float, text: str, size: float, room: float | None = None) -> None:
        """A line. across: share of the width, of its middle; down: pixels from the top; room: pixels that it must fit
        in, None: those of the sheet."""
        long = _WIDE * size * DPI / 72.0 * max(len(text), 1)
        size *= min(1.0, ((self.width if room is None else room) - _GAP) / long)
        self.figure.text(
            across, 1 - down / self.height, text, ha="center", va="top", fontsize=size, parse_math=False
        )


def _swing(found: Modes, mode: Mode, amplitude: float) -> _Swing:
    """As far as asked for, or as loops close."""
    stand = found.point.stand
    for _ in range(_HALVED):
        try:
            (forth,) = cycle(stand, mode, amplitude, np.zeros(1))
            (back,) = cycle(stand, mode, amplitude, np.array([math.pi]))
        except SimulationError:
            amplitude *= 0.5
            continue
        return _Swing(mode, amplitude, back, forth)
    return _Swing(mode, 0.0, stand.q, stand.q)


def _size(swing: _Swing, found: Modes) -> str:
    """Of what moves most: an angle, or a length."""
    coordinates = found.point.motion.model.coordinates
    units = {c.name: c.unit for c in coordinates}
    away = dict(zip(units, (abs(swing.forth - found.point.stand.q)).tolist(), strict=True))
    most = moving(swing.mode)[0]
    return length_text(away[most]) if units[most] == "m" else f"{math.degrees(swing.amplitude):.3g}°"


def _over(picture: Pixels, faint: Pixels) -> Pixels:
    """A picture over a faint one of the same size."""
    ground = 255.0 - _FAINT * (255.0 - faint.astype(float))
    blank = (picture == 255).all(axis=2, keepdims=True)
    return np.where(blank, ground, picture).astype(np.uint8)


def _title(mode: Mode, found: Modes) -> str:
    if mode.kind == "vibration":
        damped = f"damping ratio {mode.damping:.3g}" if found.has_damping else "undamped"
        return f"{mode.frequency:.4g} Hz, {damped}"
    if mode.kind == "free":
        return "free, nothing pulls back"
    word = "dies away" if mode.kind == "decay" else "grows"
    return f"{word} e-fold in {1.0 / abs(mode.eigenvalue.real):.3g} s"
