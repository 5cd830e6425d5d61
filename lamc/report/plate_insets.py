"""Slivers of a plate, such as the film of a hinge, enlarged above its picture with colours of their own.

In: a problem, a field, matplotlib axes that show it. Out: inset axes. Never: computes a field.
"""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.tri import Triangulation

from lamc.basics.checks import Array
from lamc.basics.numbers import prefixed, shortened
from lamc.plates.problem import Problem
from lamc.report.plate_contours import Field
from lamc.report.plate_marks import Scale
from lamc.report.plate_solid import colours_of, split

_THIN = 0.03  # of the plate's longer side: a region that is thinner is a sliver
_MOST = 2  # that are enlarged
_AROUND = 1.6  # times a sliver's width is what its inset shows
_WIDE, _TALL = 0.3, 0.14  # of the plate's longer side
_ABOVE = 0.07  # of it, between the plate and the insets


def slivers(problem: Problem) -> list[int]:
    """Regions that are too thin to be seen and of another laminate than the rest, the thinnest first."""
    mesh = problem.mesh
    size = float(np.ptp(mesh.points, axis=0).max())
    found = []
    for region, laminate in enumerate(problem.laminates):
        points = mesh.corners[mesh.regions == region].reshape(-1, 2)
        alone = all(other != laminate for k, other in enumerate(problem.laminates) if k != region)
        if len(points) and len(problem.laminates) > 1 and alone:
            thin = float(np.ptp(points, axis=0).min())
            if thin < _THIN * size:
                found.append((thin, region))
    return [region for _, region in sorted(found)[:_MOST]]


def draw_insets(axis: Axes, problem: Problem, field: Field, scale: Scale) -> None:
    """An inset for each sliver, above the plate, at its own range, which its title tells with the region's name. The
    limits of `axis` are raised for them."""
    mesh = problem.mesh
    chosen = slivers(problem)
    if not chosen:
        return
    values = field.values if field.values.ndim == 2 else field.values[mesh.cells]
    low, high = mesh.points.min(axis=0) * scale.per_metre, mesh.points.max(axis=0) * scale.per_metre
    size = float((high - low).max())
    wide, tall = min(_WIDE * size, 0.48 * float(high[0] - low[0])), _TALL * size
    bottom = float(high[1]) + _ABOVE * size
    axis.set_ylim(axis.get_ylim()[0], bottom + tall + _ABOVE * size)
    for number, region in enumerate(chosen):
        corners = mesh.corners[mesh.regions == region] * scale.per_metre
        middle = _middle(corners)
        left = float(np.clip(middle[0] - wide / 2, low[0], high[0] - wide))
        if number:  # beside the first, which stands above its own
            left = float(low[0]) if middle[0] < (low[0] + high[0]) / 2 else float(high[0]) - wide
        inset = axis.inset_axes((left, bottom, wide, tall), transform=axis.transData)
        _draw(inset, corners, values[mesh.regions == region], field, mesh.region_names[region] or "the rest")
        across = 0.5 * _AROUND * float(np.ptp(corners.reshape(-1, 2), axis=0).min())
        inset.set_xlim(middle[0] - across, middle[0] + across)
        inset.set_ylim(middle[1] - across * tall / wide, middle[1] + across * tall / wide)
        axis.indicate_inset_zoom(inset, edgecolor="black", alpha=0.8)


def _middle(corners: Array) -> Array:
    """Of the box around corners (k, c, 2)."""
    points = corners.reshape(-1, 2)
    return np.asarray((points.min(axis=0) + points.max(axis=0)) / 2)


def _draw(inset: Axes, corners: Array, values: Array, field: Field, name: str) -> None:
    x, y = corners.reshape(-1, 2).T
    drawn = Triangulation(x, y, split(np.arange(x.size).reshape(values.shape)))
    low, high = float(values.min()), float(values.max())
    unit_scale, unit = prefixed(max(abs(low), abs(high)), field.unit)
    colours, norm = colours_of(low, high, signed=field.signed)
    inset.tripcolor(drawn, values.ravel(), cmap=colours, norm=norm, shading="gouraud")
    inset.set_title(
        f"{shortened(name, 16)}: {low / unit_scale:.4g} to {high / unit_scale:.4g} {unit}".rstrip(),
        fontsize=7,
        parse_math=False,
        pad=2,
    )
    inset.set_xticks([])
    inset.set_yticks([])
