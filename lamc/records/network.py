"""What can be wrong with bodies and joints taken together, fault by fault.

In: bodies and joints, each well formed by itself. Out: faults, each with the entry it lies in, so that a reader can
tell the line of its file. Never: raises; looks at angles, loops or files.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from lamc.basics.errors import DesignError, TopologyError

if TYPE_CHECKING:
    from lamc.records.mechanism import Body, Joint

# Of the distance between hinges: points and directions that agree so well were meant to be the same.
SAME = 1e-9


@dataclass(frozen=True, eq=False)
class Fault:
    """What is wrong, and where: keys and indices from the top of the record, as in ("joints", 2, "child")."""

    path: tuple[str | int, ...]
    error: DesignError


def faults(bodies: "Sequence[Body]", joints: "Sequence[Joint]") -> Iterator[Fault]:
    """What keeps bodies and joints from being a `Mechanism`."""
    yield from _same_names([body.name for body in bodies], "bodies")
    yield from _same_names([joint.name for joint in joints], "joints")
    names = {body.name for body in bodies}
    for index, joint in enumerate(joints):
        for key, end in (("parent", joint.parent), ("child", joint.child)):
            if end not in names:
                text = (
                    f"joint {joint.name!r} joins body {end!r}, which the mechanism does not have; "
                    f"its bodies are {listed_names(sorted(names))}"
                )
                yield Fault(("joints", index, key), TopologyError(text))
    yield from _same_hinges(joints)
    if not any(body.fixed for body in bodies):
        text = (
            "no body is fixed, so nothing holds the mechanism; fix one (fixed=True, or draw a fixed region)"
        )
        yield Fault(("bodies",), TopologyError(text))


def loose_ends(bodies: "Sequence[Body]", joints: "Sequence[Joint]") -> Iterator[Fault]:
    """What keeps a `Mechanism` from being planned: hinges that cannot turn, bodies that nothing holds."""
    fixed = {body.name for body in bodies if body.fixed}
    for index, joint in enumerate(joints):
        if joint.parent in fixed and joint.child in fixed:
            text = (
                f"joint {joint.name!r} joins two fixed bodies, {joint.parent!r} and {joint.child!r}, and cannot "
                "move; remove it or free one of them"
            )
            yield Fault(("joints", index), TopologyError(text))
    held = _held(fixed, joints)
    lost = sorted((body.name, index) for index, body in enumerate(bodies) if body.name not in held)
    if lost:
        name, index = lost[0]
        more = f" and {len(lost) - 1} more" if len(lost) > 1 else ""
        text = (
            f"body {name!r}{more} has no path of hinges to a fixed body ({listed_names(sorted(fixed))}); "
            "add a hinge, fix the body or remove it"
        )
        yield Fault(("bodies", index), TopologyError(text))


def listed_names(names: Sequence[str], count: int = 8) -> str:
    """A few names, then how many there are."""
    shown = ", ".join(names[:count])
    return shown + (f", … ({len(names)} in all)" if len(names) > count else "")


def _same_names(names: Sequence[str], what: str) -> Iterator[Fault]:
    seen: set[str] = set()
    for index, name in enumerate(names):
        if name in seen:
            error = DesignError(f"two {what} are named {name!r}; names must differ")
            yield Fault((what, index, "name"), error)
        seen.add(name)


def _same_hinges(joints: "Sequence[Joint]") -> Iterator[Fault]:
    """Two hinges of one pair of bodies may share a line, as a door's do, but not the place on it as well."""
    points = np.array([joint.point for joint in joints]).reshape(-1, 3)
    axes = np.array([joint.axis for joint in joints]).reshape(-1, 3)
    size = float(np.linalg.norm(np.ptp(points, axis=0))) if len(joints) else 0.0
    of_pair: dict[tuple[str, ...], list[int]] = {}
    for index, joint in enumerate(joints):
        others = of_pair.setdefault(tuple(sorted((joint.parent, joint.child))), [])
        apart = np.linalg.norm(points[others] - joint.point, axis=1)
        same = np.flatnonzero(apart <= SAME * size)
        if len(same):  # first, as crosses cost more: thousands may share two bodies
            askew = np.linalg.norm(np.cross(axes[others][same], joint.axis), axis=1)
            same = same[askew <= SAME]
        if len(same):
            other = joints[others[same[0]]]
            text = (
                f"joints {other.name!r} and {joint.name!r} are the same hinge: both join {joint.parent!r} and "
                f"{joint.child!r} at one point along one axis; remove one of them"
            )
            yield Fault(("joints", index), TopologyError(text))
        else:
            others.append(index)


def _held(fixed: set[str], joints: "Sequence[Joint]") -> set[str]:
    """Names of the bodies that hinges connect to a fixed one, and of those."""
    neighbours: dict[str, list[str]] = {}
    for joint in joints:
        neighbours.setdefault(joint.parent, []).append(joint.child)
        neighbours.setdefault(joint.child, []).append(joint.parent)
    held, waiting = set(fixed), sorted(fixed)
    while waiting:
        for other in neighbours.get(waiting.pop(), []):
            if other not in held:
                held.add(other)
                waiting.append(other)
    return held
