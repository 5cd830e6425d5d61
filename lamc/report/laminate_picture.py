"""A picture of a laminate: its plies from bottom to top, seen from the side.

In: a laminate and a path ending in .png. Out: that file. Never: computes anything about the laminate but heights.

Colours tell materials apart, strokes the direction of fibres as seen from above, and both are written out. Plies too
thin to be labelled at true scale are drawn thicker, all others stay in proportion, and the picture says so.
"""

import math
import os
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import shapely
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine
from matplotlib.patches import Patch, Rectangle

from lamc.basics.checks import Array
from lamc.basics.errors import LamcError
from lamc.basics.numbers import shortened
from lamc.plates.laminates.laminate import Laminate
from lamc.plates.laminates.plies import Ply
from lamc.report.style import PALETTE, save

_WIDTH = 7.0  # inches
_HEIGHTS = (2.2, 11.0)  # inches, least and most
_LINE = 0.36  # inches per ply
_LEAST = 0.7  # of the mean height of a ply: what every ply is drawn with at least
_MOST_LABELS = 48
_TINT = 0.45  # share of white in a ply's colour
_STROKES = 0.11  # inches between strokes
_INK = "#333333"


def draw_stack(laminate: Laminate, path: str | os.PathLike[str], title: str = "") -> Path:
    """Draws the plies into `path`. Raises LamcError for a suffix that is not .png, and where it cannot be written."""
    target = Path(path)
    if target.suffix.lower() != ".png":
        raise LamcError(f"cannot draw into {target.name!r}; the name must end in .png")
    bottoms, heights = _drawn(laminate)
    inches = float(np.clip(_LINE * len(laminate.plies) + 1.3, *_HEIGHTS))
    figure = Figure(figsize=(_WIDTH, inches), layout=ConstrainedLayoutEngine(w_pad=0.08, h_pad=0.08))
    axis = figure.subplots()
    colours = _colours(laminate)
    for ply, low, height in zip(laminate.plies, bottoms, heights, strict=True):
        face = tint(colours[_material_name(ply)])
        axis.add_patch(
            Rectangle((0.0, low), 1.0, height, facecolor=face, edgecolor=_INK, linewidth=0.8, zorder=1)
        )
    _draw_labels(axis, laminate, bottoms, heights)
    _draw_reference(axis, laminate, bottoms, heights)
    _draw_axis(axis, laminate, bottoms, heights)
    count = len(laminate.plies)
    lines = [f"{count} {'ply' if count == 1 else 'plies'}, {_reported(laminate.thickness, laminate)} thick"]
    if title:
        lines[0] = f"{shortened(title, 50)}: {lines[0]}"
    if not _is_true(laminate, heights):
        lines.append("thin plies are drawn thicker than they are")
    if not _holds_reference(laminate):
        lines.append(_where_reference_is(laminate))
    axis.set_title("\n".join(lines), fontsize=10, parse_math=False)
    _draw_legend(axis, laminate, colours)
    figure.draw_without_rendering()  # lays the axes out: angles of strokes are angles on paper
    for ply, low, height in zip(laminate.plies, bottoms, heights, strict=True):
        _draw_fibres(figure, axis, ply, low, height)
    return save(figure, target)


def tint(colour: str) -> tuple[float, float, float]:
    """The colour mixed with white, so that hatching and text on it can be read."""
    parts = [int(colour[k : k + 2], 16) / 255 for k in (1, 3, 5)]
    red, green, blue = (part + _TINT * (1.0 - part) for part in parts)
    return red, green, blue


def _colours(laminate: Laminate) -> dict[str, str]:
    """A colour for each material in the order in which they appear; they repeat after the palette's end."""
    names = list(dict.fromkeys(_material_name(ply) for ply in laminate.plies))
    return {name: PALETTE[k % len(PALETTE)] for k, name in enumerate(names)}


def _material_name(ply: Ply) -> str:
    if ply.material.name:
        return ply.material.name
    return f"E1 = {ply.material.E1 / 1e9:.3g} GPa, E2 = {ply.material.E2 / 1e9:.3g} GPa"


def _draw_legend(axis: Axes, laminate: Laminate, colours: dict[str, str]) -> None:
    handles = [Patch(facecolor=tint(colour), edgecolor=_INK, label="m") for colour in colours.values()]
    names = [shortened(name, 32) for name in colours]
    if any(not ply.material.is_isotropic for ply in laminate.plies):
        handles.append(Patch(facecolor="none", edgecolor="none", label="m"))
        names.append("strokes: fibres as seen from above, x to the right")
    legend = axis.legend(
        handles=handles, loc="upper center", bbox_to_anchor=(0.5, -0.04), ncols=3, fontsize=8, frameon=False
    )
    for text, name in zip(legend.get_texts(), names, strict=True):
        text.set_parse_math(False)
        text.set_text(name)


def _draw_fibres(figure: Figure, axis: Axes, ply: Ply, low: float, height: float) -> None:
    """Strokes at the ply's angle, which matplotlib's hatches do not have; none where there is no direction."""
    if ply.material.is_isotropic:
        return
    to_paper = (axis.transData - figure.dpi_scale_trans).transform  # inches
    (left, bottom), (right, top) = to_paper([(0.0, low), (1.0, low + height)])
    angle = math.radians(ply.angle)
    along, across = (
        np.array([math.cos(angle), math.sin(angle)]),
        np.array([-math.sin(angle), math.cos(angle)]),
    )
    middle, reach = np.array([left + right, bottom + top]) / 2, math.hypot(right - left, top - bottom) / 2
    count = math.floor(reach / _STROKES)
    starts = middle + np.outer(_STROKES * (np.arange(-count, count) + 0.5), across)
    strokes = shapely.multilinestrings(
        list(np.stack([starts - reach * along, starts + reach * along], axis=1))
    )
    inside = shapely.intersection(strokes, shapely.box(left, bottom, right, top))
    from_paper = (figure.dpi_scale_trans - axis.transData).transform
    lines = [from_paper(np.asarray(part.coords)) for part in shapely.get_parts(inside) if part.length > 0.0]
    axis.add_collection(LineCollection(lines, colors=_INK, linewidths=0.4, zorder=1.5))


def _drawn(laminate: Laminate) -> tuple[Array, Array]:
    """Where each ply is drawn, and how high, both (plies,), in parts of the drawing's height."""
    t = np.array([ply.thickness for ply in laminate.plies])
    gaps = np.array([ply.gap for ply in laminate.plies])
    count = len(t) + int((gaps > 0.0).sum())
    least = _LEAST / count
    shares, spaces = (np.where(x > 0.0, np.maximum(x / laminate.thickness, least), 0.0) for x in (t, gaps))
    total = float(shares.sum() + spaces.sum())
    edges = np.cumsum(np.column_stack([spaces, shares]).ravel()) / total
    return edges[::2], shares / total


def _is_true(laminate: Laminate, heights: Array) -> bool:
    t = np.array([ply.thickness for ply in laminate.plies])
    return bool(np.allclose(heights / heights.max(), t / t.max(), rtol=1e-6))


def _holds_reference(laminate: Laminate) -> bool:
    z = laminate.heights
    return bool(z[0, 0] <= 0.0 <= z[-1, 1])


def _where_reference_is(laminate: Laminate) -> str:
    low, high = float(laminate.heights[0, 0]), float(laminate.heights[-1, 1])
    if low > 0.0:
        return f"the reference surface, z = 0, lies {_reported(low, laminate)} below"
    return f"the reference surface, z = 0, lies {_reported(-high, laminate)} above"


def _draw_labels(axis: Axes, laminate: Laminate, bottoms: Array, heights: Array) -> None:
    """Thickness and angle of each ply, within it; of every so many where there are more than can be read."""
    every = math.ceil(len(laminate.plies) / _MOST_LABELS)
    for k, (ply, low, height) in enumerate(zip(laminate.plies, bottoms, heights, strict=True)):
        if k % every:
            continue
        direction = "isotropic" if ply.material.is_isotropic else f"{ply.angle:g}°"
        axis.text(
            0.5,
            low + 0.5 * height,
            f"{k + 1}   {_reported(ply.thickness, laminate)}   {direction}",
            ha="center",
            va="center",
            fontsize=8 if len(laminate.plies) < 30 else 6,
            bbox={"facecolor": "white", "edgecolor": "none", "pad": 0.8},
        )


def _draw_reference(axis: Axes, laminate: Laminate, bottoms: Array, heights: Array) -> None:
    """The surface that z counts from, where it lies within the plies: a dashed line, behind the labels."""
    if not _holds_reference(laminate):
        return
    at = _place_of(0.0, laminate.heights, bottoms, heights)
    axis.plot([-0.03, 1.03], [at, at], color="#B00020", linewidth=1.3, dashes=(5, 2), zorder=2, clip_on=False)
    axis.text(1.04, at, "z = 0", color="#B00020", va="center", fontsize=8)


def _place_of(height: float, z: Array, bottoms: Array, heights: Array) -> float:
    """Where a height (m, within the plies) is in the drawing."""
    real = z.ravel()
    drawn = np.column_stack([bottoms, bottoms + heights]).ravel()
    return float(np.interp(height, real, drawn))


def _unit(laminate: Laminate) -> tuple[float, str]:
    """Units per metre, and their name, for all lengths of the picture."""
    return (1e3, "mm") if laminate.thickness >= 1e-3 else (1e6, "µm")


def _reported(metres: float, laminate: Laminate) -> str:
    scale, unit = _unit(laminate)
    return f"{metres * scale:.4g} {unit}"


def _draw_axis(axis: Axes, laminate: Laminate, bottoms: Array, heights: Array) -> None:
    """Heights of the faces at the left, as many as can be read, and the direction of z."""
    z = laminate.heights
    drawn = np.column_stack([bottoms, bottoms + heights])
    faces = {round(float(d), 9): float(height) for d, height in zip(drawn.ravel(), z.ravel(), strict=True)}
    every = math.ceil(len(faces) / (_MOST_LABELS + 1))
    ticks: Sequence[float] = sorted(faces)
    shown = [tick for k, tick in enumerate(ticks) if k % every == 0 or k == len(ticks) - 1]
    scale, unit = _unit(laminate)
    axis.set_yticks(shown, [f"{faces[tick] * scale + 0.0:.5g}" for tick in shown], fontsize=7)
    axis.set_ylabel(f"z [{unit}]  ↑", fontsize=9)
    axis.set_xticks([])
    axis.set_xlim(-0.03, 1.12)
    axis.set_ylim(-0.005, 1.005)
    for side in ("top", "right", "bottom"):
        axis.spines[side].set_visible(False)
