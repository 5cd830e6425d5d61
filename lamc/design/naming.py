"""Names for bodies and joints that nobody named, from their geometry alone.

In: what identifies each body (fixed or not, centre, mass, inertia) and each hinge (its line in space), and
the names that the drawing gives. Out: one name each, in the order of the input. It never looks at ids, nor
at the order of the input except between things that are alike in every respect.

The order is by position: x, then y, then z, then what else tells two things apart. Numbers closer than
`SAME` times the design's size count as equal. They are grouped by gaps, not rounded to a grid: a grid has
boundaries, and round-off on a boundary would flip an order.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from lamc.basics.errors import DesignError
from lamc.records.mechanism import Array

# Relative to the design's size: far above the round-off of polygon overlays (1e-13 or so of the size), far
# below the distance between two bodies or hinges that anyone draws.
SAME = 1e-7
_UPPER = np.triu_indices(3)


@dataclass(frozen=True, eq=False)
class BodyMark:
    """What tells one body from another: for a plated body, what `mass.body_properties` gives."""

    fixed: bool
    com: Array  # (3,), m
    mass: float = 0.0  # kg
    inertia: Array = field(default_factory=lambda: np.zeros((3, 3)))  # (3, 3), kg·m²


@dataclass(frozen=True, eq=False)
class JointMark:
    """What tells one hinge from another: the two ends of its drawn line."""

    start: Array  # (3,), m
    end: Array  # (3,), m


def name_bodies(
    marks: Sequence[BodyMark],
    given: Sequence[str | None] | None = None,
    order: Sequence[int] | None = None,
) -> tuple[str, ...]:
    """A name for each body, in the order of `marks`.

    given  the drawing's own names, None where there is none; they are kept
    order  `body_order` of the marks, if it is known

    The only fixed body is "ground", several are "ground_1", "ground_2", …; moving ones are "link_1",
    "link_2", …. The number is the body's place among all fixed or all moving ones, so that naming one by hand
    renames no other. Raises DesignError for a name given twice.
    """
    names = _given_names(len(marks), given, "bodies")
    order = body_order(marks) if order is None else order
    for fixed, stem in ((True, "ground"), (False, "link")):
        members = [i for i in order if marks[i].fixed is fixed]
        alone = fixed and len(members) == 1 and "ground" not in names
        _number(names, members, f"{stem}_", sole=stem if alone else None)
    return tuple(str(name) for name in names)


def name_joints(
    marks: Sequence[JointMark],
    given: Sequence[str | None] | None = None,
    order: Sequence[int] | None = None,
) -> tuple[str, ...]:
    """A name for each hinge, in the order of `marks`: "h1", "h2", …, or the one in `given` where not None. order:
    `joint_order` of the marks, if it is known.

    The number is the hinge's place among all hinges. Raises DesignError for a name given twice.
    """
    names = _given_names(len(marks), given, "hinges")
    _number(names, joint_order(marks) if order is None else order, "h", sole=None)
    return tuple(str(name) for name in names)


def body_order(marks: Sequence[BodyMark]) -> tuple[int, ...]:
    """Indices of bodies: fixed ones first, then by centre (x, y, z), mass and inertia."""
    if not marks:
        return ()
    com = np.array([m.com for m in marks])
    size = float(np.linalg.norm(np.ptp(com, axis=0)))
    mass = np.array([m.mass for m in marks])
    inertia = np.array([m.inertia for m in marks])[:, *_UPPER]
    scales = np.repeat([size, mass.max(), np.abs(inertia).max()], [3, 1, 6])
    ranked = ranks(np.column_stack([com, mass, inertia]), scales)
    return _lexicographic(np.column_stack([[not m.fixed for m in marks], ranked]))


def joint_order(marks: Sequence[JointMark]) -> tuple[int, ...]:
    """Indices of hinges: by the middle of the line (x, y, z), its slope and length, then its drawn sense."""
    if not marks:
        return ()
    start, end = np.array([m.start for m in marks]), np.array([m.end for m in marks])
    middle, along = (start + end) / 2, end - start
    size = float(np.linalg.norm(np.ptp(np.concatenate([start, end]), axis=0)))
    forward = along * _canonical_sign(along, size)[:, None]
    return _lexicographic(ranks(np.concatenate([middle, forward, along], axis=1), np.full(9, size)))


def ranks(values: Array, scales: Array) -> Array:
    """Rank of each value (n, k) in its column; values in a row closer than SAME x `scales` (k,) share one rank."""
    order = np.argsort(values, axis=0, kind="stable")
    steps = np.diff(np.take_along_axis(values, order, axis=0), axis=0) > SAME * scales
    ranked = np.zeros(values.shape)
    np.put_along_axis(ranked, order[1:], np.cumsum(steps, axis=0), axis=0)
    return ranked


def _canonical_sign(along: Array, size: float) -> Array:
    """+1 or -1 for each direction (n, 3), such that a line and its reverse get opposite signs."""
    clear = np.abs(along) > SAME * size
    first = along[np.arange(len(along)), np.argmax(clear, axis=1)]
    return np.where(clear.any(axis=1) & (first < 0.0), -1.0, 1.0)


def _lexicographic(keys: Array) -> tuple[int, ...]:
    """Indices of rows (n, k), sorted by the first key, ties by the next and so on; full ties keep the input's order."""
    return tuple(np.lexsort(keys.T[::-1]).tolist())


def _given_names(count: int, given: Sequence[str | None] | None, what: str) -> list[str | None]:
    names: list[str | None] = [None] * count if given is None else list(given)
    assert len(names) == count
    seen: set[str] = set()
    for name in names:
        if name in seen:
            raise DesignError(f"two {what} are named {name!r}; names must differ")
        if name is not None:
            seen.add(name)
    return names


def _number(names: list[str | None], members: Sequence[int], stem: str, *, sole: str | None) -> None:
    """Fill the gaps in `names` for `members`, in order: `sole`, or stem and place among the members."""
    taken = {name for name in names if name is not None}
    spare = len(members)
    for place, index in enumerate(members, start=1):
        if names[index] is not None:
            continue
        name = sole or f"{stem}{place}"
        while name in taken:  # somebody named another one so by hand
            spare += 1
            name = f"{stem}{spare}"
        names[index] = name
        taken.add(name)
