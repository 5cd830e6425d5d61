"""Modes in words and in JSON's own types.

In: `Modes`. Out: text, rows, a dict. Never: computes physics.
"""

import math
from typing import Any

from lamc.report.split_text import table
from lamc.run.equilibrium import Equilibrium
from lamc.run.vibration import Mode, Modes

_MOVING = 0.02  # of the largest: what moves less is not named
_NAMED = 4  # coordinates of a mode
_ANGLES = 12  # of an equilibrium


def modes_text(found: Modes, count: int) -> str:
    """The equilibrium, and the first `count` modes, slowest first."""
    rows = [
        [str(k + 1), *_numbers(mode), mode.kind, motion(mode)] for k, mode in enumerate(found.modes[:count])
    ]
    text = table(["mode", "Hz", "rad/s", "damping", "kind", "moves"], rows)
    more = len(found.modes) - count
    tail = [f"… and {more} more, in modes.csv"] if more > 0 else []
    notes = [f"note         {note}" for note in found.notes]
    return "\n".join([equilibrium_text(found.point), *notes, "", text, *tail])


def equilibrium_text(point: Equilibrium) -> str:
    """What it is and where."""
    angles = list(point.angles.items())
    said = ", ".join(f"{name} {math.degrees(angle):.5g} deg" for name, angle in angles[:_ANGLES])
    more = f", … ({len(angles)} hinges)" if len(angles) > _ANGLES else ""
    lines = [
        f"equilibrium  {point.kind}: {point.reason} ({point.criterion})",
        f"angles       {said or 'none'}{more}",
        f"energy       {point.energy:.6g} J; {point.residual:.1e} left of accelerations, rad/s²; {point.way}, "
        f"{point.steps} steps",
    ]
    if point.contacts:
        lines.append(f"contacts     {', '.join(point.contacts)}")
    return "\n".join([*lines, *(f"note         {note}" for note in point.notes)])


def moving(mode: Mode) -> list[str]:
    """Coordinates that move, those that move most first; of equal ones in their order."""
    sizes = dict(zip(mode.names, abs(mode.shape).tolist(), strict=True))
    largest = max(sizes.values())
    ordered = sorted(sizes, key=lambda name: -round(sizes[name] / largest, 6))
    return [name for name in ordered if sizes[name] > _MOVING * largest]


def motion(mode: Mode, count: int = _NAMED) -> str:
    """What moves most in a mode, against the largest."""
    found, largest = moving(mode), float(abs(mode.shape).max())
    told = [f"{name} {_share(mode, name, largest)}" for name in found[:count]]
    return ", ".join(told) + (f", … ({len(found)} move)" if len(found) > count else "")


def modes_table(found: Modes) -> list[list[Any]]:
    """Rows of modes.csv, the head first."""
    names = found.modes[0].names
    units = [c.unit for c in found.point.motion.model.coordinates]
    parts = [
        f"{name} {part} ({unit})" for name, unit in zip(names, units, strict=True) for part in ("re", "im")
    ]
    head = [
        "mode",
        "kind",
        "frequency (Hz)",
        "rate (rad/s)",
        "damping ratio",
        "re λ (1/s)",
        "im λ (1/s)",
        *parts,
    ]
    rows: list[list[Any]] = [head]
    for k, mode in enumerate(found.modes):
        shape = [float(x) for value in mode.shape for x in (value.real, value.imag)]
        numbers = [mode.frequency, mode.angular_frequency, mode.damping]
        rows.append([k + 1, mode.kind, *numbers, mode.eigenvalue.real, mode.eigenvalue.imag, *shape])
    return rows


def modes_data(found: Modes, design: str, source: str) -> dict[str, Any]:
    """Of modes.json, SI units."""
    point, model = found.point, found.point.motion.model
    return {
        "design": design,
        "source": source,
        "program_digest": model.digest,
        "parameters": dict(zip(model.parameters, point.motion.parameters.tolist(), strict=False)),
        "equilibrium": {
            "kind": point.kind,
            "stable": point.stable,
            "criterion": point.criterion,
            "reason": point.reason,
            "coordinates": dict(point.coordinates),
            "stiffnesses": point.stiffnesses.tolist(),
            "residual": point.residual,
            "uncertainty": point.uncertainty,
            "energy": point.energy,
            "contacts": list(point.contacts),
            "way": point.way,
            "t": point.t,
            "notes": list(point.notes),
        },
        "damped": found.has_damping,
        "notes": list(found.notes),
        "modes": [_mode_data(mode) for mode in found.modes],
    }


def _mode_data(mode: Mode) -> dict[str, Any]:
    return {
        "kind": mode.kind,
        "frequency": mode.frequency,
        "angular_frequency": mode.angular_frequency,
        "damping": None if math.isnan(mode.damping) else mode.damping,
        "eigenvalue": [mode.eigenvalue.real, mode.eigenvalue.imag],
        "amplitudes": dict(mode.amplitudes),
        "phases": dict(mode.phases),
    }


def _numbers(mode: Mode) -> tuple[str, str, str]:
    if mode.kind == "vibration":
        return f"{mode.frequency:.5g}", f"{mode.angular_frequency:.5g}", f"{mode.damping:.4f}"
    rate = "" if mode.kind == "free" else f"{abs(mode.eigenvalue):.5g}"
    return "", rate, ""


def _share(mode: Mode, name: str, largest: float) -> str:
    """The part of a coordinate in the largest, with its phase where it has one of its own."""
    value = complex(mode.shape[mode.names.index(name)]) / largest
    if mode.is_standing or abs(value.imag) < _MOVING:
        return f"{value.real:+.2f}"
    return f"{abs(value):.2f} at {math.degrees(math.atan2(value.imag, value.real)):.0f}°"
