"""A drawing of the folded device at a few instants of a run.

In: a `Result`. Out: a PNG file. All panels share one view and one scale, so that lengths compare; nothing is stretched.
"""

import math
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from lamc.records.mechanism import Array
from lamc.report.plan_view import length_text, shortened
from lamc.report.raster import Pixels
from lamc.report.stage import HINGE, Stage, stage_of
from lamc.report.style import WORLD, body_colours, save
from lamc.run.result import Result

PANELS = 4
_LONGEST = 900  # pixels of a panel
_PANEL_WIDTH = 4.6  # inches
_ALIKE = math.radians(
    2.0
)  # instants whose angles all differ by less, and lengths by as much of the size, look alike
_EDGE = "#444444"
_NAMED = 8  # bodies and joints beyond this are not named


def draw_folded(result: Result, path: Path) -> Path:
    """The device at up to four instants, the start and the end among them. Raises LamcError if it cannot write."""
    rows = instants(result)
    stage = stage_of(result, result.t[rows], _LONGEST)
    columns = min(2, len(rows))
    lines = math.ceil(len(rows) / columns)
    width = _PANEL_WIDTH if columns == 2 else 1.6 * _PANEL_WIDTH
    tall = width * stage.height / stage.width
    figure = Figure(figsize=(columns * width + 0.3, lines * (tall + 0.55) + 1.1), layout="constrained")
    axes = np.atleast_1d(figure.subplots(lines, columns)).ravel()
    for axis in axes:
        axis.set_axis_off()
    for panel, (axis, row) in enumerate(zip(axes, rows, strict=False)):
        picture = stage.draw(panel)
        axis.imshow(picture, interpolation="antialiased")
        axis.set_title(_title(result, row), fontsize=9.5, parse_math=False)
        if panel == 0:
            corners = free_corners(picture)
            scale_bar(axis, stage, corners[0])
            triad(axis, stage, corners[1])
    figure.suptitle(shortened(result.provenance.design, 60), parse_math=False, fontsize=13)
    _legend(figure, result)
    return save(figure, path)


def instants(result: Result, count: int = PANELS) -> list[int]:
    """Rows to show, ascending: the start, the end, and those between that differ most from the ones already taken."""
    last = len(result.t) - 1
    taken = [0] if last == 0 else [0, last]
    if not result.coordinates:
        return taken[:1]
    thinned = np.unique(np.linspace(0, last, 400).astype(int))
    q = result.q / [result.mechanism.size if c.unit == "m" else 1.0 for c in result.coordinates]
    while len(taken) < count:
        apart = np.min([np.abs(q[thinned] - q[k]).max(axis=1) for k in taken], axis=0)
        farthest = int(np.argmax(apart))
        if not apart[farthest] > _ALIKE:
            break
        taken.append(int(thinned[farthest]))
    return sorted(taken)


def _title(result: Result, row: int) -> str:
    word = " (start)" if row == 0 else " (end)" if row == len(result.t) - 1 else ""
    title = f"t = {result.t[row]:.4g} s{word}"
    if 0 < len(result.joints) <= 4:
        angles = (
            f"{shortened(j, 10)} {math.degrees(result.q[row, k]):.1f}°" for k, j in enumerate(result.joints)
        )
        title += "\n" + ",  ".join(angles)
    return title


def scale_bar(axis: Axes, stage: Stage, corner: Array) -> None:
    """A bar of a round length around `corner`, pixels."""
    length = round_length(0.2 * stage.width / stage.camera.scale)
    half, y = length * stage.camera.scale / 2, corner[1] + 0.02 * stage.height
    axis.plot(
        corner[0] + np.array([-half, half]), [y, y], color="black", linewidth=2.5, solid_capstyle="butt"
    )
    axis.text(corner[0], y - 0.02 * stage.height, length_text(length), fontsize=8, ha="center", va="bottom")


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


def triad(axis: Axes, stage: Stage, corner: Array) -> None:
    """The world's axes around `corner`, pixels."""
    camera = stage.camera
    length = 0.09 * min(stage.width, 2 * stage.height)
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
        beyond = origin + arrow + 0.25 * length * arrow / max(float(np.linalg.norm(arrow)), 1e-9)
        axis.text(*_xy(beyond), name, fontsize=8, ha="center", va="center", color="#333333")


def _xy(point: Array) -> tuple[float, float]:
    return float(point[0]), float(point[1])


def _legend(figure: Figure, result: Result) -> None:
    colours = body_colours(result.mechanism)
    bodies = result.mechanism.bodies
    handles: list[Any] = [Line2D([], [], color=f"#{HINGE[0]:02x}{HINGE[1]:02x}{HINGE[2]:02x}", linewidth=2)]
    names = ["hinge line"]
    moving = result.motion.model.bodies
    if len(bodies) <= _NAMED:
        handles += [Patch(facecolor=colours[b.name], edgecolor=_EDGE, linewidth=0.5) for b in bodies]
        names += [shortened(b.name, 24) + ("" if b.name in moving else " (fixed)") for b in bodies]
    elif any(b.name not in moving for b in bodies):
        handles.append(Patch(facecolor=WORLD, edgecolor=_EDGE, linewidth=0.5))
        names.append("fixed")
    legend = figure.legend(
        handles=handles,
        labels=[str(k) for k in range(len(names))],
        loc="outside lower center",
        ncols=min(len(names), 5),
        fontsize=8,
        frameon=False,
    )
    for text, name in zip(legend.get_texts(), names, strict=True):
        text.set_parse_math(False)
        text.set_text(name)
