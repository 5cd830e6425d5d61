"""Bodies and joints of a mechanism as plain text and as plain data.

In: a Mechanism, with the splitting's notes where there are any. Out: strings for a terminal, without colour
or markup, and a dictionary of numbers, strings and lists for JSON. It prints nothing.

The tables use the unit that suits the mechanism and name it in the heading; the dictionary is SI throughout.
"""

import math
from collections.abc import Sequence

import numpy as np

from lamc.basics.numbers import shortened
from lamc.records.mechanism import Body, Joint, Mechanism

_MASSES = ((1.0, "kg"), (1e-3, "g"), (1e-6, "mg"), (1e-9, "µg"))
_LENGTHS = ((1.0, "m"), (1e-3, "mm"), (1e-6, "µm"))
_LONGEST_NAME = 32
_MENDS = 20  # told as text
_NAMES = 6  # in a list before it is cut
_RIGHT = frozenset("0123456789.-+")


def split_text(mechanism: Mechanism, notes: Sequence[str] = ()) -> str:
    """Name, tables of bodies and joints, and notes, separated by empty lines."""
    bodies, joints = _count(mechanism.bodies, "body", "bodies"), _count(mechanism.joints, "joint", "joints")
    parts = [
        f"{short_name(mechanism.name)}: {bodies}, {joints}",
        body_table(mechanism),
        joint_table(mechanism),
        mend_table(mechanism),
        f"scenes: {', '.join(mechanism.scenes)}" if mechanism.scenes else "",
        *(f"note: {note}" for note in notes),
    ]
    return "\n\n".join(part for part in parts if part)


def body_table(mechanism: Mechanism) -> str:
    """One line per body: name, fixed or not, mass, centre, principal moments of inertia."""
    scale, unit = _length_unit(mechanism)
    mass_scale, mass_unit = _unit(max((b.mass for b in mechanism.bodies), default=0.0), _MASSES)
    heads = ["body", "", f"mass [{mass_unit}]", *(f"{c} [{unit}]" for c in "xyz")]
    heads += [f"I{k} [kg·m²]" for k in "123"]
    rows = [
        [
            short_name(body.name),
            "fixed" if body.fixed else "",
            f"{body.mass / mass_scale:.7g}",
            *(_number(c / scale) for c in body.com),
            *(f"{moment:.4e}" for moment in principal_moments(body)),
        ]
        for body in mechanism.bodies
    ]
    return table(heads, rows)


def joint_table(mechanism: Mechanism) -> str:
    """One line per joint: name, parent, child, point, axis, stiffness, damping, rest angle, limits."""
    if not mechanism.joints:
        return ""
    scale, unit = _length_unit(mechanism)
    heads = ["joint", "parent", "child", *(f"{c} [{unit}]" for c in "xyz"), "axis"]
    heads += ["k [N·m/rad]", "c [N·m·s/rad]", "rest [°]", "limits [°]"]
    rows = [
        [
            *(short_name(name) for name in (joint.name, joint.parent, joint.child)),
            *(_number(p / scale) for p in joint.point),
            "(" + ", ".join(_number(a, 4) for a in joint.axis) + ")",
            f"{joint.stiffness:.6g}",
            f"{joint.damping:.6g}",
            f"{math.degrees(joint.rest_angle):.6g}",
            _limits(joint),
        ]
        for joint in mechanism.joints
    ]
    return table(heads, rows)


def mend_table(mechanism: Mechanism) -> str:
    """One line per mend of the drawing: what, where, how far, which lines; the rest is in the data."""
    if not mechanism.mends:
        return ""
    scale, unit = _length_unit(mechanism)
    heads = ["healed", f"x [{unit}]", f"y [{unit}]", f"moved [{unit}]", "line"]
    rows = [
        [
            mend.what,
            *(_number(c / scale) for c in mend.at),
            f"{mend.moved / scale:.3g}",
            shortened(mend.source, 60),
        ]
        for mend in mechanism.mends[:_MENDS]
    ]
    more = len(mechanism.mends) - len(rows)
    return table(heads, rows) + (f"\n… and {more} more (--json has all)" if more else "")


def split_data(mechanism: Mechanism, notes: Sequence[str] = ()) -> dict[str, object]:
    """The same as plain data for JSON: SI units, angles in radians, full precision."""
    return {
        "name": mechanism.name,
        "scenes": list(mechanism.scenes),
        "bodies": [
            {
                "name": body.name,
                "fixed": body.fixed,
                "mass": body.mass,
                "com": body.com.tolist(),
                "inertia": body.inertia.tolist(),
                "principal_moments": list(principal_moments(body)),
            }
            for body in mechanism.bodies
        ],
        "joints": [
            {
                "name": joint.name,
                "parent": joint.parent,
                "child": joint.child,
                "point": joint.point.tolist(),
                "axis": joint.axis.tolist(),
                "stiffness": joint.stiffness,
                "damping": joint.damping,
                "rest_angle": joint.rest_angle,
                "limits": list(joint.limits),
            }
            for joint in mechanism.joints
        ],
        "mends": [
            {"what": mend.what, "at": list(mend.at), "moved": mend.moved, "source": mend.source}
            for mend in mechanism.mends
        ],
        "notes": list(notes),
    }


def principal_moments(body: Body) -> tuple[float, float, float]:
    """Principal moments of inertia about the centre of mass, ascending, kg·m²."""
    first, second, third = (float(value) for value in np.linalg.eigvalsh(body.inertia))
    return first, second, third


def _limits(joint: Joint) -> str:
    if not joint.is_limited:
        return "free"
    lower, upper = (math.degrees(limit) for limit in joint.limits)
    return f"{lower:.6g} to {upper:.6g}"


def table(heads: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Columns padded to their widest entry; those that hold numbers only stand to the right."""
    columns = list(zip(heads, *rows, strict=True))
    widths = [max(len(entry) for entry in column) for column in columns]
    numeric = [all(entry[:1] in _RIGHT for entry in column[1:] if entry) for column in columns]
    lines = []
    for row in (heads, *rows):
        cells = [
            entry.rjust(width) if right else entry.ljust(width)
            for entry, width, right in zip(row, widths, numeric, strict=True)
        ]
        lines.append("  ".join(cells).rstrip())
    lines.insert(1, "  ".join("-" * width for width in widths))
    return "\n".join(lines)


def _length_unit(mechanism: Mechanism) -> tuple[float, str]:
    return _unit(mechanism.size, _LENGTHS)


def _unit(largest: float, units: Sequence[tuple[float, str]]) -> tuple[float, str]:
    """The first unit in which `largest` is a tenth or more; the first for zero, the last for what is tiny."""
    if largest == 0.0:
        return units[0]
    return next((u for u in units if largest >= 0.1 * u[0]), units[-1])


def _number(value: float, digits: int = 6) -> str:
    """Rounded to an absolute number of decimals, so that round-off of zero prints as 0."""
    return f"{round(float(value), digits) + 0.0:.7g}"


def _count(things: Sequence[object], one: str, many: str) -> str:
    return f"{len(things)} {one if len(things) == 1 else many}"


def names(items: Sequence[str]) -> str:
    """A few names, then how many there are."""
    shown = ", ".join(short_name(item) for item in items[:_NAMES])
    return shown + (f", … ({len(items)} in all)" if len(items) > _NAMES else "")


def short_name(name: str) -> str:
    """The name, cut where a table would grow too wide."""
    return name if len(name) <= _LONGEST_NAME else name[: _LONGEST_NAME - 1] + "…"
