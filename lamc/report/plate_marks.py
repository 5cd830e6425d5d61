"""Outline, regions, hinge lines, supports and loads of a plate, drawn on axes.

In: a `Problem`, matplotlib axes in a unit of length. Out: artists with labels for a legend. Never: fields, files.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import shapely
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.lines import Line2D
from matplotlib.patheffects import withStroke
from shapely.geometry.base import BaseGeometry

from lamc.basics.checks import Array
from lamc.basics.numbers import shortened, shown_number
from lamc.plates.loads import (
    EdgeLoad,
    EdgeMoment,
    ElectricField,
    Intensity,
    LoadRecord,
    Moisture,
    PointLoad,
    Pressure,
    SelfWeight,
    Temperature,
)
from lamc.plates.meshing.mesh import Mesh
from lamc.plates.problem import Problem
from lamc.plates.supports import Clamped, Hinged, SimplySupported, Symmetry

INK = "#202020"
LOAD = "#D55E00"  # vermilion of Okabe and Ito
_HELD = "#0072B2"  # their blue
_FOLD = "#009E73"  # their green
_STYLES: tuple[tuple[type, str, Any, float], ...] = (
    (Clamped, "clamped", "solid", 4.0),
    (SimplySupported, "simply supported", (0, (2.0, 1.0)), 3.0),
    (Hinged, "hinged", (0, (0.6, 0.6)), 4.0),
    (Symmetry, "symmetry", "dashdot", 2.0),
)
_OTHERS: tuple[tuple[Any, str], ...] = (  # lines and marks of other sets of unknowns that are held
    ("solid", "s"),
    ((0, (5.0, 1.0)), "D"),
    ((0, (1.0, 1.0)), "o"),
    ("dashdot", "P"),
)
_LINE, _BORDER = 0.5, 0.8  # pt, of mesh lines and of borders between regions
_FAINTEST = 75  # edges along the picture beyond which mesh lines are thinner, as they would be a grey wash
_THIN = 0.1  # of a mesh line's width: what is left of it at least


@dataclass(frozen=True)
class Scale:
    """Unit of the axes."""

    unit: str
    per_metre: float


def scale_of(size: float) -> Scale:
    """The unit that suits a plate of `size` m."""
    for unit, per_metre in (("m", 1.0), ("mm", 1e3), ("µm", 1e6)):
        if size * per_metre >= 1.0 or unit == "µm":
            return Scale(unit, per_metre)
    raise AssertionError("a unit is always found")


def draw_outline(axis: Axes, mesh: Mesh, scale: Scale, *, lines: bool = False) -> None:
    """The mesh's boundary, borders between regions, and with `lines` all edges."""
    ends = mesh.points[mesh.edges] * scale.per_metre  # (e, 2, 2)
    counts = np.bincount(mesh.cell_edges.ravel(), minlength=len(ends))
    boundary = counts == 1
    if lines:
        inner = ends[~boundary]
        lengths = np.linalg.norm(inner[:, 1] - inner[:, 0], axis=1) / np.ptp(ends, axis=(0, 1)).max()
        widths = np.clip(lengths * _FAINTEST, _THIN, 1.0) * _LINE
        axis.add_collection(LineCollection(list(inner), colors=INK, linewidths=widths, alpha=0.25, zorder=3))
    axis.add_collection(
        LineCollection(
            _merged(ends[_borders(mesh)]),
            colors=INK,
            linewidths=_BORDER,
            linestyles=":",
            zorder=4,
            path_effects=[_halo(_BORDER)],
        )
    )
    axis.add_collection(LineCollection(list(ends[boundary]), colors=INK, linewidths=1.0, zorder=4))


def region_borders(mesh: Mesh) -> list[Line2D]:
    """The entry of a legend for the dotted lines of `draw_outline`, if there are any."""
    names = ", ".join(name for name in mesh.region_names if name)
    if len(mesh.region_names) < 2:
        return []
    return [_line(f"border of {shortened(names, 32)}", INK, ":", _BORDER)]


def _merged(ends: Array) -> list[Array]:
    """Edges (k, 2, 2) as few long lines, so that dashes run on from edge to edge."""
    if not len(ends):
        return []
    lines = shapely.line_merge(shapely.multilinestrings(list(ends)))
    return [np.asarray(part.coords) for part in shapely.get_parts(lines)]


def _halo(width: float) -> withStroke:
    """White beside a line of `width` pt, which may cross a field of its own colour."""
    return withStroke(linewidth=width + 1.2, foreground="white", alpha=0.7)


def _borders(mesh: Mesh) -> Array:
    """Which edges have cells of two regions, shape (e,)."""
    regions = np.repeat(mesh.regions[:, None], mesh.corner_count, axis=1).ravel()
    low = np.full(len(mesh.edges), np.iinfo(np.int32).max)
    high = np.full(len(mesh.edges), -1)
    np.minimum.at(low, mesh.cell_edges.ravel(), regions)
    np.maximum.at(high, mesh.cell_edges.ravel(), regions)
    return np.asarray(low < high)


def draw_supports(axis: Axes, problem: Problem, scale: Scale) -> list[Line2D]:
    """Lines and points where the plate is held, and lines where it folds; handles for a legend, one per kind."""
    handles: dict[str, Line2D] = {}
    for hinge in problem.hinges:
        fold = "hinge line, free" if hinge.stiffness == 0.0 else "hinge line"
        dashes = (0, (1.5, 1.5)) if hinge.stiffness == 0.0 else (0, (4.0, 2.0))
        _place(axis, problem, hinge.where, scale, _FOLD, dashes, 1.8, "", order=4.5)
        handles.setdefault(fold, _line(fold, _FOLD, dashes, 1.8))
    others: dict[str, tuple[Any, str]] = {}
    for support in problem.supports:
        kinds = [(name, style, width) for kind, name, style, width in _STYLES if isinstance(support, kind)]
        held = f"held: {', '.join(getattr(support, 'dofs', ()))}"
        if kinds:
            (name, style, width), marker = kinds[0], "s"
        else:
            name, width = held, 2.0
            style, marker = others.setdefault(held, _OTHERS[len(others) % len(_OTHERS)])
        if isinstance(support, SimplySupported) and support.kind == "soft":
            name += " (soft)"
        as_points = _place(axis, problem, support.where, scale, _HELD, style, width, marker)
        spot = Line2D([], [], color=_HELD, linestyle="", marker=marker, markersize=6, label=name)
        handles.setdefault(name, spot if as_points else _line(name, _HELD, style, width))
    return list(handles.values())


def draw_loads(axis: Axes, problem: Problem, loads: Sequence[Any], scale: Scale) -> list[Line2D]:
    """Forces at points and along edges; handles for a legend, one per load, without a mark for what acts on areas."""
    handles: list[Line2D] = []
    for load in loads:
        if isinstance(load, PointLoad):
            x, y = (c * scale.per_metre for c in load.at)
            mark = _mark(load.force)
            axis.add_line(Line2D([x], [y], zorder=7, **mark))
            handles.append(Line2D([], [], label=load_text(load), **mark))
        elif isinstance(load, EdgeLoad | EdgeMoment):
            _place(axis, problem, load.where, scale, LOAD, "solid", 1.6, "^", order=6)
            handles.append(_line(load_text(load), LOAD, "solid", 1.6))
        else:  # acts everywhere, or on a region that its text names
            handles.append(_line(shortened(load_text(load), 48), LOAD, "none", 0.0))
    return handles


def _line(label: str, colour: str, style: Any, width: float) -> Line2D:
    return Line2D([], [], color=colour, linestyle=style, linewidth=width, label=label)


def _mark(force: Any) -> dict[str, Any]:
    """A triangle that points the way of the larger component: along z up or down as seen from the side."""
    fx, fy, fz = force
    if abs(fz) >= max(abs(fx), abs(fy)):
        marker = "^" if fz > 0.0 else "v"
    else:
        marker = (">" if fx > 0.0 else "<") if abs(fx) >= abs(fy) else ("$↑$" if fy > 0.0 else "$↓$")
    return {
        "linestyle": "",
        "marker": marker,
        "color": LOAD,
        "markersize": 8,
        "markeredgecolor": "white",
        "markeredgewidth": 0.8,
    }


def vector_text(vector: Any, unit: str) -> str:
    """The parts of (x, y, z) that are not zero."""
    parts = [
        f"{shown_number(abs(value), unit)} along {'-' if value < 0.0 else ''}{axis}"
        for axis, value in zip("xyz", vector, strict=True)
        if value != 0.0
    ]
    return " and ".join(parts) or f"0 {unit}"


def load_text(load: LoadRecord) -> str:
    """What acts, in a few words."""
    match load:
        case PointLoad(force=force):
            reported = vector_text(force, "N")
        case EdgeLoad(force=force):
            reported = vector_text(force, "N/m")
        case EdgeMoment(moment=moment):
            reported = f"moment {shown_number(moment, 'N·m/m')}"
        case Pressure(intensity=intensity):
            reported = f"pressure {_amount(intensity, lambda value: shown_number(value, 'Pa'))}"
        case SelfWeight(acceleration=acceleration):
            reported = f"gravity {vector_text(acceleration, 'm/s²')}"
        case Temperature(rise=rise):
            reported = (
                f"temperature change {_amount(rise, lambda value: f'{value:+g}')} K{_slope_text(load, 'K/m')}"
            )
        case Moisture(content=content):
            reported = f"moisture {_amount(content, lambda value: f'{value:g}')}{_slope_text(load, '1/m')}"
        case ElectricField(field=field):
            each = field if isinstance(field, Sequence) else [field]
            values = [_amount(one, lambda value: shown_number(value, "V/m")) for one in each]
            reported = f"electric field {', '.join(values)}"
        case _:
            reported = type(load).__name__
    region = getattr(load, "region", None)
    return f"{reported} on {region!r}" if region else reported


def _slope_text(load: Temperature | Moisture, unit: str) -> str:
    """How it changes through the thickness, if it does."""
    if not load.has_gradient:
        return ""
    return f" and {_amount(load.gradient, lambda value: f'{value:+g}')} {unit} upwards"


def _amount(amount: Intensity, reported: Callable[[float], str]) -> str:
    """A number in words; of a function its text, where it has one."""
    return str(getattr(amount, "text", "varies")) if callable(amount) else reported(amount)


def _place(
    axis: Axes,
    problem: Problem,
    where: str | BaseGeometry,
    scale: Scale,
    colour: str,
    style: Any,
    width: float,
    marker: str,
    order: float = 5,
) -> bool:
    """Edges on the place as lines; a region as hatching; single points as marks. Returns whether it is points."""
    if not isinstance(where, str) and where.area > 0.0:
        for part in shapely.get_parts(where):
            x, y = np.asarray(part.exterior.coords).T[:2] * scale.per_metre
            axis.fill(x, y, facecolor="none", edgecolor=colour, hatch="////", linewidth=0.8, zorder=order)
        return False
    edges = problem.places.edges_on(where)
    if len(edges):
        mesh = problem.mesh
        cells, local = edges.T
        ends = np.stack(
            [mesh.cells[cells, local], mesh.cells[cells, (local + 1) % mesh.corner_count]], axis=1
        )
        axis.add_collection(
            LineCollection(
                _merged(mesh.points[ends] * scale.per_metre),
                colors=colour,
                linewidths=width,
                linestyles=style,
                zorder=order,
                capstyle="projecting" if style == "solid" else None,  # a ring has no notch where it closes
                path_effects=[_halo(width)] if colour == _FOLD else None,
            )
        )
        return False
    nodes = problem.places.nodes(where, "a place that is drawn")
    x, y = problem.dofs.points[nodes].T * scale.per_metre
    axis.plot(x, y, linestyle="", marker=marker, color=colour, markersize=6, zorder=order)
    return True
