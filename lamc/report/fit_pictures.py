"""Pictures of a fit: recordings over the model, and what is left of them.

In: what was compared. Out: files. It computes nothing but scales.
"""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from lamc.basics.numbers import prefixed, shortened
from lamc.fitting.compared import Compared
from lamc.report.curves import dress
from lamc.report.style import PALETTE, WORLD, save

_WIDTH, _PANEL = 9.0, 2.2  # inches
_MOST = 12  # panels


def draw_overlay(compared: Sequence[Compared], path: Path) -> Path:
    """Each column over time: dots as measured, a line as the model has it."""
    figure, axes, panels = _panels(compared, "measured, and the fitted model")
    for axis, (each, k) in zip(axes, panels, strict=True):
        scale, unit = _scale(each, k, each.measured[:, k])
        axis.plot(each.t, each.measured[:, k] / scale, ".", color=WORLD, markersize=3, label="measured")
        axis.plot(each.t, each.predicted[:, k] / scale, color=PALETTE[0], linewidth=1.4, label="model")
        _label(axis, each, k, unit)
    handles, names = axes[0].get_legend_handles_labels()
    figure.legend(handles, names, loc="upper left", fontsize=8, frameon=False, ncols=2)
    return save(figure, path)


def draw_residuals(compared: Sequence[Compared], path: Path) -> Path:
    """What the model misses of each column over time; dashed: its root mean square on either side."""
    figure, axes, panels = _panels(compared, "model less measured (dashed: root mean square)")
    for axis, (each, k) in zip(axes, panels, strict=True):
        residual = each.residuals[:, k]
        scale, unit = _scale(each, k, residual)
        axis.plot(each.t, residual / scale, ".", color=PALETTE[0], markersize=3)
        rms = float(np.sqrt(np.nanmean(residual**2))) / scale
        axis.axhline(0.0, color=WORLD, linewidth=0.8)
        for sign in (-1.0, 1.0):
            axis.axhline(sign * rms, color=WORLD, linewidth=0.8, linestyle="--")
        _label(axis, each, k, unit)
    return save(figure, path)


def _panels(
    compared: Sequence[Compared], title: str
) -> tuple[Figure, list[Axes], list[tuple[Compared, int]]]:
    every = [
        (each, k)
        for each in compared
        for k in range(len(each.columns))
        if np.isfinite(each.measured[:, k]).any()
    ]
    panels = every[:_MOST]
    columns = 1 if len(panels) < 4 else 2
    rows = -(-len(panels) // columns)
    figure = Figure(figsize=(_WIDTH, 0.6 + _PANEL * rows), layout="constrained")
    more = f"; {len(every) - len(panels)} more columns are not drawn" if len(every) > len(panels) else ""
    figure.suptitle(title + more, fontsize=12, parse_math=False)
    axes: list[Axes] = list(np.ravel(figure.subplots(rows, columns, squeeze=False)))
    for axis in axes[len(panels) :]:
        axis.set_visible(False)
    for place, axis in enumerate(axes[: len(panels)]):
        if place + columns >= len(panels):
            axis.set_xlabel("t [s]")
    return figure, axes[: len(panels)], panels


def _scale(each: Compared, k: int, values: np.ndarray) -> tuple[float, str]:
    unit = each.units[k]
    if unit in ("rad", "rad/s"):
        return np.pi / 180.0, unit.replace("rad", "°")
    return prefixed(float(np.nanmax(np.abs(values), initial=0.0)), unit)


def _label(axis: Axes, each: Compared, k: int, unit: str) -> None:
    dress(axis)
    name = f"{shortened(each.name, 20)}: {shortened(each.columns[k], 22)}"
    axis.set_ylabel(name + (f"\n[{unit}]" if unit else ""), parse_math=False, fontsize=9)
