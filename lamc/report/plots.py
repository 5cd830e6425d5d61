"""Plots of a run over time: joint angles and energies, or whatever is named.

In: a `Result`, names. Out: matplotlib axes, or a PNG, SVG or PDF file. It computes nothing but degrees.
"""

import os
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from lamc.basics.checks import shown
from lamc.basics.errors import RequestError
from lamc.basics.numbers import prefixed, shortened
from lamc.report.curves import NAMED_CURVES, Curve, draw_curves, dress
from lamc.report.style import curve_style, save, save_axes
from lamc.run.quantities import AXES, ENERGY, Quantity
from lamc.run.result import Result

_WIDTH, _HEIGHT = 9.0, 6.4  # inches
_LEFT, _HEAD, _FOOT, _BETWEEN = 0.9, 0.72, 0.6, 0.5  # inches of margins
_LETTER, _HANDLE = 0.072, 0.45  # inches of a legend: of a letter, of a line beside it
_HINGES, _ENERGIES = "hinges", "energies"
_ENERGY_DASHES = ("-.", "--", ":", "-")


def draw_angles_energy(result: Result, path: Path) -> Path:
    """Joint angles in degrees above, energies below. Raises LamcError if `path` cannot be written."""
    figure, _ = _drawn(result, _groups(result, (_HINGES, _ENERGIES)), Figure)
    return save(figure, path)


def plot(
    result: Result, *names: str, axes: Any = None, path: str | os.PathLike[str] | None = None
) -> tuple[Axes, ...]:
    """`Result.plot`."""
    groups = _groups(result, names or (_HINGES, _ENERGIES))
    if axes is None:
        if path is None:
            from matplotlib import pyplot  # its figures are shown by notebooks and windows

            return _drawn(result, groups, pyplot.figure)[1]
        figure, drawn = _drawn(result, groups, Figure)
        save(figure, Path(path))
        return drawn
    given = [axes] if isinstance(axes, Axes) else list(np.ravel(np.asarray(axes, dtype=object)))
    if len(given) != len(groups) or not all(isinstance(each, Axes) for each in given):
        units = ", ".join(unit or "1" for unit, _ in groups)
        raise RequestError(
            f"axes is {shown(axes)}; these names have {len(groups)} units ({units}), so it must be "
            f"{len(groups)} Matplotlib axes"
        )
    for axis, group in zip(given, groups, strict=True):
        _panel(axis, result, group)
    if path is not None:
        save_axes(given[0], path)
    return tuple(given)


_Group = tuple[str, list[Quantity]]  # unit as shown, and what has it


def _groups(result: Result, names: Sequence[str]) -> list[_Group]:
    """Quantities by unit, in the order of the names; energies that were asked for as a whole have axes of their own."""
    groups: dict[str, list[Quantity]] = {}
    for name in dict.fromkeys(names):
        for quantity in _named(result, name):
            groups.setdefault(quantity.unit, []).append(quantity)
    if not result.hinges and _HINGES in names:
        return [("rad", []), *groups.items()]
    return list(groups.items())


def _named(result: Result, name: str) -> Iterable[Quantity]:
    if name == _HINGES:
        return [Quantity(hinge, "rad", result.angle(hinge)) for hinge in result.hinges]
    if name == _ENERGIES:
        parts = [Quantity(each, "J", values) for each, values in result.energies.items()]
        return [*parts, Quantity(ENERGY, "J", result.energy)]
    if name in {point.name for point in result.points} or (
        name in result.bodies and name not in result.hinges
    ):
        return [result.quantity(f"{name}.{axis}") for axis in AXES]
    return [result.quantity(name)]


def _drawn(result: Result, groups: Sequence[_Group], make: Any) -> tuple[Figure, tuple[Axes, ...]]:
    """A figure with a panel for each group, one above the other; margins by what legends take."""
    height = _HEIGHT if len(groups) == 2 else 0.9 + 2.75 * len(groups)
    figure = make(figsize=(_WIDTH, height))
    letters = max((len(shortened(q.name, 24)) + 4 for _, group in groups for q in group), default=0)
    columns = max((len(group) - 1) // 14 + 1 if len(group) <= NAMED_CURVES else 1 for _, group in groups)
    right = min(0.2 + columns * (_HANDLE + _LETTER * letters), 0.5 * _WIDTH)
    inner = (height - _HEAD - _FOOT - _BETWEEN * (len(groups) - 1)) / len(groups)
    figure.subplots_adjust(
        left=_LEFT / _WIDTH,
        right=1 - right / _WIDTH,
        top=1 - _HEAD / height,
        bottom=_FOOT / height,
        hspace=_BETWEEN / inner,
    )
    axes: tuple[Axes, ...] = tuple(np.ravel(figure.subplots(len(groups), 1, sharex=True)))
    ended = "" if result.success else f" (ended early at t = {_last(result):.4g} s)"
    title = shortened(result.provenance.design, 60)
    figure.text(
        0.5, 1 - 0.1 / height, f"{title}{ended}", parse_math=False, fontsize=13, ha="center", va="top"
    )
    for axis, group in zip(axes, groups, strict=True):
        _panel(axis, result, group)
        axis.yaxis.set_label_coords(-0.68 / (_WIDTH - _LEFT - right), 0.5)
        if axis is not axes[-1]:
            axis.set_xlabel("")
    return figure, axes


def _panel(axis: Axes, result: Result, group: _Group) -> None:
    unit, quantities = group
    scale, reported = _scale(unit, quantities)
    energies = unit == "J"
    curves = [
        Curve(
            "total" if energies and q.name == ENERGY else q.name.replace("_", " ") if energies else q.name,
            q.values / scale,
            *(_energy_style(q.name, k) if energies and len(quantities) > 1 else (None, None)),
        )
        for k, q in enumerate(quantities)
    ]
    axis.set_title(_heading(unit, quantities), fontsize=10, loc="left", parse_math=False)
    axis.set_ylabel(f"{_noun(unit, quantities)} [{reported}]" if reported else _noun(unit, quantities))
    axis.set_xlabel("time t [s]")
    dress(axis)
    if not quantities:
        axis.text(0.5, 0.5, "nothing moves: there is no joint", ha="center", transform=axis.transAxes)
        return
    draw_curves(axis, result.t, curves)
    if len(result.t) > 1:
        axis.set_xlim(float(result.t[0]), float(result.t[-1]))


def _scale(unit: str, quantities: Sequence[Quantity]) -> tuple[float, str]:
    """What values are divided by, and the unit that they then have."""
    if unit in ("rad", "rad/s"):
        return np.pi / 180.0, unit.replace("rad", "°")
    finite = [float(np.abs(q.values[np.isfinite(q.values)]).max(initial=0.0)) for q in quantities]
    return prefixed(max(finite, default=0.0), "" if unit == "1" else unit)


def _heading(unit: str, quantities: Sequence[Quantity]) -> str:
    if unit == "rad":
        return "Joint angles, zero as drawn"
    if unit == "J" and len(quantities) > 1:
        return "Energies by effect, and in all" if quantities[-1].name == ENERGY else "Energies by effect"
    return ""


def _noun(unit: str, quantities: Sequence[Quantity]) -> str:
    if len(quantities) == 1:
        return shortened(quantities[0].name, 24)
    return {"rad": "joint angle", "rad/s": "rate", "m": "position", "J": "energy", "m/s": "velocity"}.get(
        unit, ""
    )


def _energy_style(name: str, index: int) -> tuple[str, str]:
    if name == ENERGY:
        return "black", "-"
    return curve_style(index)[0], _ENERGY_DASHES[index % 4]


def _last(result: Result) -> float:
    return float(result.t[-1]) if len(result.t) else 0.0
