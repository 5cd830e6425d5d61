"""A drawing of the folded device at a few instants of a run.

In: a `Result`. Out: a PNG, SVG or PDF file. All panels share one view and one scale, so that lengths compare; nothing
is stretched, and white margins are cut off by rows and columns of panels.
"""

import math
import textwrap
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from lamc.basics.numbers import length_text, shortened
from lamc.records.mechanism import Array, Mechanism
from lamc.report.angle_table import AngleTable, angle_table, number_hinges
from lamc.report.look import Look
from lamc.report.raster import Pixels
from lamc.report.stage import HINGE, Stage, stage_of
from lamc.report.style import DPI, WORLD, body_colours, save
from lamc.run.result import Result

PANELS = 4
_LONGEST = 700  # pixels of a panel
_NARROWEST = 960  # pixels of the sheet: what legend, axes and scale take
_ALIKE = math.radians(
    2.0
)  # instants whose angles all differ by less, and lengths by as much of the size, look alike
_EDGE = "#444444"
_NAMED = 8  # bodies beyond this are not named
_HEAD, _LINE, _FOOT, _GAP = 44, 22, 92, 24  # pixels: name, a line of a title, axes and scale, between panels
_ENTRY = 150  # pixels of a legend's entry


def draw_folded(result: Result, path: Path, look: Look | None = None) -> Path:
    """The device at up to four instants, the start and the end among them. Raises LamcError if it cannot write."""
    look = look or Look()
    rows = instants(result)
    stage = stage_of(result, result.t[rows], look.size or _LONGEST, look.camera)
    pictures = [stage.draw(panel) for panel in range(len(rows))]
    table = angle_table(result, rows)
    titles = [_title(result, row, with_angles=table is None) for row in rows]
    figure = _Sheet(pictures, titles, stage, shortened(result.provenance.design, 60), table)
    _legend(figure.figure, result.mechanism, result.motion.model.bodies, figure.legend_room)
    return save(figure.figure, path)


class _Sheet:
    """Panels at one pixel of the file for each of theirs, and below them the table of angles, axes and scale.

    legend_room: middle of the foot and its width, pixels
    """

    def __init__(
        self,
        pictures: Sequence[Pixels],
        titles: Sequence[str],
        stage: Stage,
        name: str,
        table: AngleTable | None,
    ) -> None:
        ratio = stage.height / stage.width
        count = len(pictures)
        columns = count if ratio > 1.2 else 1 if ratio < 0.24 else min(2, count)
        lines = math.ceil(count / columns)
        inks = [_ink_box(picture) for picture in pictures]
        across = [_union(inks[k::columns], 1) for k in range(columns)]
        down = [_union(inks[k * columns : (k + 1) * columns], 0) for k in range(lines)]
        above = _LINE * max(title.count("\n") + 1 for title in titles) + 8
        widths = [high - low for low, high in across]
        heights = [high - low for low, high in down]
        inner = sum(widths) + _GAP * (columns + 1)
        self.width = max(inner, _NARROWEST)
        below = _FOOT + (table.height if table is not None else 0)
        self.height = _HEAD + sum(heights) + (above + 8) * lines + below
        self.figure = Figure(figsize=(self.width / DPI, self.height / DPI), dpi=DPI)
        self.figure.text(0.5, 1 - 8 / self.height, name, ha="center", va="top", fontsize=12, parse_math=False)
        y = _HEAD
        for line, tall in enumerate(heights):
            y += above
            x = (self.width - inner) / 2 + _GAP
            for column, wide in enumerate(widths):
                index = line * columns + column
                if index < count:
                    axis = self._axes(x, y, wide, tall)
                    window = np.s_[slice(*down[line]), slice(*across[column])]
                    axis.imshow(
                        pictures[index][window],
                        interpolation="nearest",
                        aspect="auto",
                        extent=(across[column][0], across[column][1], down[line][1], down[line][0]),
                    )
                    axis.set_title(titles[index], fontsize=8.5, parse_math=False, pad=4)
                    if index == 0 and table is not None:
                        number_hinges(axis, stage, table)
                x += wide + _GAP
            y += tall + 8
        if table is not None:
            table.write(self._axes(0, y, self.width, table.height), self.width)
            y += table.height
        foot = self._axes(0, y, self.width, _FOOT)
        foot.set_xlim(0, self.width)
        foot.set_ylim(_FOOT, 0)
        triad(foot, stage, np.array([70.0, _FOOT / 2]), 30.0)
        bar = scale_length(stage) * stage.camera.scale
        scale_bar(foot, stage, np.array([self.width - bar / 2 - 30.0, _FOOT / 2]))
        self.legend_room = (_FOOT / 2 / self.height, self.width - 2 * max(150.0, bar + 50.0))

    def _axes(self, x: float, y: float, wide: float, tall: float) -> Axes:
        """Axes at a place in pixels from the upper left."""
        place = (x / self.width, 1 - (y + tall) / self.height, wide / self.width, tall / self.height)
        axis = self.figure.add_axes(place)
        axis.set_axis_off()
        return axis


def _ink_box(picture: Pixels) -> Array:
    """First and last row, first and last column that are not white, with a margin, (2, 2)."""
    ink = (picture < 255).any(axis=2)
    spans = []
    for axis in (1, 0):
        found = np.flatnonzero(ink.sum(axis=axis))
        size = ink.shape[1 - axis]
        spans.append((max(found[0] - 8, 0), min(found[-1] + 9, size)) if found.size else (0, size))
    return np.array(spans)


def _union(boxes: Sequence[Array], side: int) -> tuple[int, int]:
    return int(min(box[side, 0] for box in boxes)), int(max(box[side, 1] for box in boxes))


def instants(result: Result, count: int = PANELS) -> list[int]:
    """Rows to show, ascending: the start, the end, and those between that look least like the ones already taken."""
    last = len(result.t) - 1
    taken = [0] if last == 0 else [0, last]
    if not result.coordinates:
        return taken[:1]
    thinned = np.unique(np.linspace(0, last, 400).astype(int))
    lengths = np.array([c.unit == "m" for c in result.coordinates])
    while len(taken) < count:
        apart = np.min([_unlike(result, result.q[thinned] - result.q[k], lengths) for k in taken], axis=0)
        farthest = int(np.argmax(apart))
        if not apart[farthest] > _ALIKE:
            break
        taken.append(int(thinned[farthest]))
    return sorted(taken)


def _unlike(result: Result, change: Array, lengths: Array) -> Array:
    """How unlike rows look, (m,), rad, of changes (m, nq): a full turn looks like none."""
    turned = np.abs((change + np.pi) % (2.0 * np.pi) - np.pi)
    found: Array = np.where(lengths, np.abs(change) / result.mechanism.size, turned).max(axis=1)
    return found


def _title(result: Result, row: int, *, with_angles: bool) -> str:
    word = " (start)" if row == 0 else " (end)" if row == len(result.t) - 1 else ""
    title = f"t = {result.t[row]:.4g} s{word}"
    if with_angles:
        angles = [
            f"{shortened(j, 10)} {round(math.degrees(result.angle(j)[row]), 1) + 0.0:.1f}°"
            for j in result.hinges
        ]
        title += "\n" + "\n".join(textwrap.wrap(",  ".join(a.replace(" ", "\u00a0") for a in angles), 44))
    return title


def scale_length(stage: Stage) -> float:
    """The round length, m, that a scale bar shows."""
    return round_length(0.2 * stage.width / stage.camera.scale)


def scale_bar(axis: Axes, stage: Stage, corner: Array) -> None:
    """A bar of a round length around `corner`, pixels."""
    length = scale_length(stage)
    half, y = length * stage.camera.scale / 2, corner[1] + 9.0
    axis.plot(
        corner[0] + np.array([-half, half]), [y, y], color="black", linewidth=2.5, solid_capstyle="butt"
    )
    axis.text(corner[0], y - 9.0, length_text(length), fontsize=8, ha="center", va="bottom")


def free_corners(picture: Pixels) -> list[Array]:
    """Middles of the picture's corners, columns and rows; empty corners first."""
    height, width, _ = picture.shape
    reach = np.array([0.24 * width, 0.24 * height])
    corners = [np.array([x, y]) for y in (1.0, 0.0) for x in (0.0, 1.0)]
    middles = [reach / 2 + corner * (np.array([width, height]) - reach) for corner in corners]
    return sorted(middles, key=lambda middle: _ink(picture, middle, reach / 2))


def _ink(picture: Pixels, middle: Array, half: Array) -> int:
    """How many pixels of a window are not white."""
    (x0, y0), (x1, y1) = (middle - half).astype(int), (middle + half).astype(int)
    return int((picture[y0:y1, x0:x1] < 255).any(axis=2).sum())


def round_length(longest: float) -> float:
    """The largest of 1, 2, 5 times a power of ten that is not above `longest`, m."""
    power = 10.0 ** math.floor(math.log10(longest))
    return power * max(k for k in (1.0, 2.0, 5.0) if k * power <= longest * (1 + 1e-9))


def triad(axis: Axes, stage: Stage, corner: Array, length: float | None = None) -> None:
    """The world's axes around `corner`, arrows of `length`, pixels."""
    camera = stage.camera
    length = length or 0.09 * min(stage.width, 2 * stage.height)
    arrows = length * np.column_stack([np.eye(3) @ camera.right, -(np.eye(3) @ camera.up)])
    corners = np.vstack([arrows, np.zeros(2)])
    origin = corner - (corners.min(axis=0) + corners.max(axis=0)) / 2
    for arrow, name in zip(arrows, "xyz", strict=True):
        axis.annotate(
            "",
            _xy(origin + arrow),
            _xy(origin),
            annotation_clip=False,
            arrowprops={
                "arrowstyle": "-|>",
                "color": "#333333",
                "linewidth": 1.0,
                "shrinkA": 0,
                "shrinkB": 0,
            },
        )
        beyond = origin + arrow + 0.35 * length * arrow / max(float(np.linalg.norm(arrow)), 1e-9)
        axis.text(*_xy(beyond), name, fontsize=8, ha="center", va="center", color="#333333")


def _xy(point: Array) -> tuple[float, float]:
    return float(point[0]), float(point[1])


def _legend(figure: Figure, mechanism: Mechanism, moving: Sequence[str], room: tuple[float, float]) -> None:
    """What colours mean, in the design's order. room: middle, share of the figure's height, and width, pixels."""
    colours = body_colours(mechanism)
    bodies = mechanism.bodies
    handles: list[Any] = [Line2D([], [], color=f"#{HINGE[0]:02x}{HINGE[1]:02x}{HINGE[2]:02x}", linewidth=2)]
    names = ["hinge line"]
    if len(bodies) <= _NAMED:
        handles += [Patch(facecolor=colours[b.name], edgecolor=_EDGE, linewidth=0.5) for b in bodies]
        names += [shortened(b.name, 16) + ("" if b.name in moving else " (fixed)") for b in bodies]
    elif any(b.name not in moving for b in bodies):
        handles.append(Patch(facecolor=WORLD, edgecolor=_EDGE, linewidth=0.5))
        names.append("fixed")
    legend = figure.legend(
        handles=handles,
        labels=[str(k) for k in range(len(names))],
        loc="center",
        bbox_to_anchor=(0.5, room[0]),
        ncols=max(1, min(len(names), 5, int(room[1] / _ENTRY))),
        fontsize=8,
        frameon=False,
    )
    for text, name in zip(legend.get_texts(), names, strict=True):
        text.set_parse_math(False)
        text.set_text(name)
