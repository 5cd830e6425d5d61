"""Contours of a field over a plate, with a colour bar.

In: a mesh, values at its points or at the corners of its cells, matplotlib axes. Out: artists. Contours are drawn on
the mesh's own triangles (quadrilaterals split in two), so that nothing appears where the plate is not. Never: files,
other fields than the one given.
"""

import math
from dataclasses import dataclass

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from matplotlib.tri import Triangulation

from lamc.basics.checks import Array
from lamc.basics.numbers import prefixed
from lamc.plates.meshing.mesh import Mesh
from lamc.report.plate_marks import Scale, draw_outline
from lamc.report.plate_solid import ONE_SIGN, colours_of, split

_LEVELS = 16  # at most, as many as round values allow
_RARE = 0.005  # of the area, at each end of a field
_SHARE = 1 / 3  # of the colours
_BELOW = 1e-9  # of the colour bar: less than can be seen
_SAME = 1e-9  # of the largest value: a field that varies by less is one number
_LINES = 40  # cells along the longer side, up to which contours show the mesh
_TICKS = 9  # of a bar about zero, at most


@dataclass(frozen=True, eq=False)
class Field:
    """A scalar over a plate.

    values  (points,) or, where it may jump between cells, (cells, corners); SI
    signed  whether the quantity has a sign: its colours are then about zero
    """

    name: str
    unit: str
    values: Array
    signed: bool = True


def triangulation(mesh: Mesh, scale: Scale, chosen: Array | None = None) -> Triangulation:
    """The cells as triangles, quadrilaterals split in two; `chosen` (cells,) leaves others out."""
    cells = mesh.cells if chosen is None else mesh.cells[chosen]
    x, y = mesh.points.T * scale.per_metre
    return Triangulation(x, y, split(cells))


def _loose(mesh: Mesh, scale: Scale) -> Triangulation:
    """Triangles that share no corner, for values that jump from cell to cell."""
    x, y = mesh.corners.reshape(-1, 2).T * scale.per_metre
    return Triangulation(x, y, split(np.arange(x.size).reshape(mesh.cells.shape)))


def draw_contours(figure: Figure, axis: Axes, mesh: Mesh, field: Field, scale: Scale) -> None:
    """Filled contours with a colour bar; what is beyond the bar's ends has their colour, and the title says how far."""
    values = np.asarray(field.values, dtype=float)
    low, high = shown_range(mesh, values)
    unit_scale, unit = prefixed(max(abs(low), abs(high)), field.unit)
    shown = values / unit_scale + 0.0  # no -0
    low, high = low / unit_scale, high / unit_scale
    same = high - low <= _SAME * max(abs(low), abs(high))
    if same:  # round-off would take all colours
        low = high = 0.5 * (low + high)
        shown = np.full_like(shown, low)
    colours, norm = colours_of(low, high, signed=field.signed)
    if colours == ONE_SIGN and low * high < 0.0:  # a little of the other sign takes no colour
        low, high = (0.0, high) if high > -low else (low, 0.0)
        shown = np.clip(shown, *((0.0, None) if high > 0.0 else (None, 0.0)))
    drawn = triangulation(mesh, scale) if values.ndim == 1 else _loose(mesh, scale)
    reported = f"{field.name} [{unit}]" if unit else field.name
    if same:
        axis.tripcolor(drawn, shown.ravel(), cmap=colours, norm=norm, shading="gouraud")
        bar = figure.colorbar(
            mpl.cm.ScalarMappable(norm=norm, cmap=colours), ax=axis, pad=0.02, fraction=0.05
        )
        bar.set_ticks([low], labels=[f"{low:.6g}"])
    else:
        levels, ticks = bands(low, high, about_zero=colours != ONE_SIGN)
        if colours == ONE_SIGN:
            norm = Normalize(levels[0], levels[-1])
        # Not `extend`: beyond an end of PuOr it would paint the darkest colour beside a pale one. Below the last level,
        # since triangles that are on it with all their corners belong to no interval and would stay white.
        most = levels[-1] - _BELOW * (levels[-1] - levels[0])
        filled = axis.tricontourf(
            drawn, np.clip(shown, levels[0], most).ravel(), levels=levels, cmap=colours, norm=norm
        )
        bar = figure.colorbar(filled, ax=axis, pad=0.02, fraction=0.05, ticks=ticks)
        least, largest = float(shown.min()), float(shown.max())
        ends = ((least, least < levels[0]), (largest, largest > levels[-1]))
        peaks = [f"{value:.4g}" for value, beyond in ends if beyond]
        reported += f"\npeaks beyond the bar: {' and '.join(peaks)}" if peaks else ""
    axis.set_title(reported, fontsize=9)
    bar.set_label(unit, fontsize=8)
    bar.ax.tick_params(labelsize=7)
    draw_outline(axis, mesh, scale, lines=len(mesh.cells) <= 2 * _LINES**2)


def bands(low: float, high: float, *, about_zero: bool) -> tuple[Array, Array | None]:
    """Borders of the bands of colour, and where the bar has numbers; None: on the borders.

    Where values have two signs, zero is the middle of a band, not a border: values that are zero but for round-off or
    the mesh would be blotches of two colours.
    """
    found: Array = np.asarray(
        MaxNLocator(_LEVELS, steps=[1, 2, 2.5, 5, 10]).tick_values(low, high), dtype=float
    )
    if not about_zero:
        return found, None
    step = float(found[1] - found[0])
    first, last = math.floor(low / step + 0.5), math.ceil(high / step - 0.5)
    every = math.ceil((last - first + 1) / _TICKS)
    ticks = [k * step for k in range(first, last + 1) if k % every == 0]
    borders = np.array([(k - 0.5) * step for k in range(first, last + 2)])
    return borders, np.array(ticks)


def shown_range(mesh: Mesh, values: Array) -> tuple[float, float]:
    """Ends of a colour bar for `values` (points,) or (cells, corners).

    All of them; but where a half per cent of the plate's area, as at a corner where moments are infinite, would take
    more than a third of the colours, the rest has them all.
    """
    low, high = float(values.min()), float(values.max())
    of_cells = values if values.ndim == 2 else values[mesh.cells]
    order = np.argsort(of_cells, axis=None)
    area = np.cumsum(np.repeat(mesh.areas, mesh.corner_count)[order])
    ends = np.searchsorted(area, [_RARE * area[-1], (1.0 - _RARE) * area[-1]])
    common_low, common_high = of_cells.ravel()[order][np.minimum(ends, len(order) - 1)]
    if common_high - common_low < (1.0 - _SHARE) * (high - low):
        return float(common_low), float(common_high)
    return low, high
