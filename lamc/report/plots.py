"""Plots of a run: joint angles and energies over time.

In: a `Result`. Out: a PNG file. It computes nothing but degrees.
"""

import math
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from lamc.report.plan_view import shortened
from lamc.report.style import add_legend, curve_style, save
from lamc.run.result import Result

NAMED_CURVES = (
    24  # with more joints than this, colour goes by position and a colour bar takes the legend's place
)
_WIDTH, _HEIGHT = 9.0, 6.4  # inches
_ENERGY_UNITS = ((1e3, "kJ"), (1.0, "J"), (1e-3, "mJ"), (1e-6, "µJ"), (1e-9, "nJ"), (1e-12, "pJ"))


def draw_angles_energy(result: Result, path: Path) -> Path:
    """Joint angles in degrees above, energies in joules below. Raises LamcError if `path` cannot be written."""
    figure = Figure(figsize=(_WIDTH, _HEIGHT), layout="constrained")
    angles, energies = figure.subplots(2, 1, sharex=True)
    title = shortened(result.provenance.design, 60)
    ended = "" if result.success else f" (ended early at t = {_last(result):.4g} s)"
    figure.suptitle(f"{title}{ended}", parse_math=False, fontsize=13)
    _draw_angles(figure, angles, result)
    _draw_energies(energies, result)
    energies.set_xlabel("time t [s]")
    for axis in (angles, energies):
        axis.grid(visible=True, color="#DDDDDD", linewidth=0.6)
        axis.spines[["top", "right"]].set_visible(False)
        axis.yaxis.set_major_locator(MaxNLocator(nbins=7, steps=[1, 2, 2.5, 5, 10]))
        axis.set_axisbelow(True)
    if len(result.t) > 1:
        energies.set_xlim(float(result.t[0]), float(result.t[-1]))
    figure.align_ylabels([angles, energies])
    return save(figure, path)


def _last(result: Result) -> float:
    return float(result.t[-1]) if len(result.t) else 0.0


def _draw_angles(figure: Figure, axis: Axes, result: Result) -> None:
    axis.set_ylabel("joint angle [°]")
    axis.set_title("Joint angles, zero as drawn", fontsize=10, loc="left")
    degrees = np.degrees(result.q)
    if not result.joints:
        axis.text(0.5, 0.5, "nothing moves: there is no joint", ha="center", transform=axis.transAxes)
        return
    if len(result.joints) > NAMED_CURVES:
        _draw_many(figure, axis, result.t, degrees)
        return
    lines: list[Any] = []
    for index in range(len(result.joints)):
        colour, dash = curve_style(index)
        marks = _marks(len(result.t), index, len(result.joints))
        lines += axis.plot(
            result.t,
            degrees[:, index],
            color=colour,
            linestyle=dash,
            linewidth=1.5,
            marker=marks[0],
            markevery=marks[1],
        )
    add_legend(axis, lines, result.joints, math.ceil(len(result.joints) / 14))


def _marks(rows: int, index: int, count: int) -> tuple[str, list[int]]:
    """A marker, and a few rows where it stands, shifted from curve to curve so that equal curves both show."""
    places = np.linspace(0, rows - 1, 8) + (rows / 8) * (index + 0.5) / count
    marker = "osD^v<>P"[index % 8]
    return marker, sorted({int(p) for p in places if 0 <= p < rows})


def _draw_many(figure: Figure, axis: Axes, t: Any, degrees: Any) -> None:
    count = degrees.shape[1]
    colours = mpl.colormaps["viridis"]
    for index in range(count):
        axis.plot(t, degrees[:, index], color=colours(index / (count - 1)), linewidth=0.8)
    scale = mpl.cm.ScalarMappable(norm=Normalize(1, count), cmap=colours)
    figure.colorbar(scale, ax=axis, label="joint number, in the order of the results", pad=0.01)


def _draw_energies(axis: Axes, result: Result) -> None:
    largest = max(
        (float(np.abs(v).max(initial=0.0)) for v in (*result.energies.values(), result.energy)), default=0.0
    )
    scale, unit = next(((s, u) for s, u in _ENERGY_UNITS if largest >= s), (1.0, "J"))
    axis.set_ylabel(f"energy [{unit}]")
    axis.set_title("Energies by effect, and in all", fontsize=10, loc="left")
    lines: list[Any] = []
    names = []
    for index, (name, values) in enumerate(result.energies.items()):
        colour, _ = curve_style(index)
        lines += axis.plot(
            result.t, values / scale, color=colour, linestyle=("-.", "--", ":", "-")[index % 4], linewidth=1.5
        )
        names.append(name.replace("_", " "))
    lines += axis.plot(result.t, result.energy / scale, color="black", linewidth=1.8)
    add_legend(axis, lines, [*names, "total"])
