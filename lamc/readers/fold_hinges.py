"""Creases of a sheet as joints: where they lie, which side turns, how stiff they are and where they rest.

In: hinges as pieces of edges, bodies. Out: joints, and notes of what was assumed. Never: moves a facet.
"""

import math
from collections import deque
from collections.abc import Mapping, Sequence

import numpy as np

from lamc.readers.fold_bending import FACET, STIFFER
from lamc.readers.fold_file import FoldFrame
from lamc.readers.fold_flat import Beside, Corners, pair_of
from lamc.readers.fold_groups import Crease, ends_of
from lamc.readers.fold_level import SIDED
from lamc.readers.fold_own import Own
from lamc.records.mechanism import Array, Body, Joint
from lamc.records.network import listed_names

CREASE = 1e-3  # N·m/rad for each m of crease: thin card, creased
REST = math.radians(60.0)  # of creases M and V whose angle no one says
_DAMPED = 0.5  # of the critical damping of a facet on its crease; a sheet moves many facets by one crease, with less
_SMALL = 1e-9  # rad


class Hinges:
    """The hinges of one sheet; `notes` grows as joints are made.

    start   rad, the angle of each joined edge of a folded sheet; empty: it is flat
    groups  the lowest face of each face's body
    crease  N·m/rad for each m; None: the file's own, else `CREASE`
    """

    def __init__(
        self,
        frame: FoldFrame,
        beside: Beside,
        corners: Corners,
        start: Mapping[int, float],
        groups: Sequence[int],
        crease: float | None,
        own: Own,
    ) -> None:
        self.frame, self.beside, self.corners, self.start, self.groups = frame, beside, corners, start, groups
        self.crease, self.own = crease, own
        self.notes: list[str] = []
        self._told: dict[str, list[str]] = {}
        self._mixed: dict[
            str, int
        ] = {}  # hinges whose pieces are marked differently, and the edge that counts

    def joints(
        self,
        creases: Sequence[Crease],
        fixed: Sequence[int],
        names: Mapping[int, str],
        bodies: Mapping[str, Body],
    ) -> list[Joint]:
        """In the order of the creases. The child is the body that is farther from a fixed one, and lies to the left of
        the axis: a valley is positive."""
        depth = _depths(fixed, [crease.groups for crease in creases])
        height = 0.5 * next(iter(bodies.values())).outline[0].z_top
        joints = []
        for crease in creases:
            parent, child = sorted(crease.groups, key=lambda group: (depth[group], group))
            start, end, length = ends_of(crease, self.frame.edges, self.beside, self.corners)
            if not self._is_left(crease, child, end - start):
                start, end = end, start
            point, axis = np.array([*start, height]), np.array([*(end - start), 0.0])
            lever = min(_about(bodies[names[g]], point, axis) for g in (parent, child))
            joints.append(self._joint(crease, (names[parent], names[child]), (point, axis), length, lever))
        if creases and self.crease is None and self.own.hinges is None:
            driven = any(joint.stiffness > 0.0 for joint in joints)
            what = (
                "creases are taken to have"
                if driven
                else "hinges have no spring, and are damped as if they had"
            )
            self.notes.append(
                f"{what} {CREASE:g} N*mm/rad for each mm (--crease '{CREASE:g} N*mm/mm/rad' says another)"
            )
        if self._mixed:
            counting = self.frame.edges_named(list(self._mixed.values()))
            self.notes.append(
                f"{listed_names(list(self._mixed))}: pieces of one hinge are marked differently; {counting} "
                f"{'counts' if len(self._mixed) == 1 else 'count'}, as most of it is marked"
            )
        self.notes += [f"{listed_names(found)}: {what}" for what, found in self._told.items()]
        return joints

    def _is_left(self, crease: Crease, child: int, along: Array) -> bool:
        """Whether the child lies to the left of a direction along the crease."""
        left, _ = pair_of(self.beside, crease.edges[0])
        a, b = (self.corners[left][v] for v in self.frame.edges[crease.edges[0]])
        return bool(((b - a) @ along > 0.0) == (self.groups[left] == child))

    def _joint(
        self,
        crease: Crease,
        ends: tuple[str, str],
        line: tuple[Array, Array],
        length: float,
        lever: float,
    ) -> Joint:
        """lever: kg·m² of the lighter side about the crease."""
        own = self.own.hinges[crease.edges[0]] if self.own.hinges else None
        name = own.name if own else f"E{self.frame.number(crease.edges[0])}"
        per_length = self.crease if self.crease is not None else CREASE
        if self.frame.kinds[crease.edges[0]] == FACET:
            per_length *= STIFFER
        drives, rest = self._rest(crease, name)
        stiffness = per_length * length if drives else 0.0
        damping = 2.0 * _DAMPED * math.sqrt(per_length * length * lever)
        if own:
            rest = own.rest_angle
            if self.crease is None:
                stiffness, damping = own.stiffness, own.damping
        return Joint(name, *ends, *line, stiffness, damping, rest)

    def _rest(self, crease: Crease, name: str) -> tuple[bool, float]:
        """Whether a spring acts, and where it rests, rad."""
        leading = crease.edges[0]
        kinds = {self.frame.kinds[k] for k in crease.edges}
        given = [angle for k in crease.edges if (angle := self.frame.angles[k]) is not None]
        if len(kinds) > 1 or (given and max(given) - min(given) > _SMALL):
            leading = self._longest(crease)
            self._mixed[name] = leading
            own = self.frame.angles[leading]
            given = [] if own is None else [own]
        kind = self.frame.kinds[leading]
        sign = {"M": -1.0, "V": 1.0}.get(kind, 0.0)
        if given and (given[0] or self.start or not sign):
            if given[0] * sign < 0.0:
                self._tell("the fold angle has the other sign than M or V has; the angle counts", name)
            return bool(given[0]) or kind != "U", given[0]
        if self.start:
            rest = self.start[crease.edges[0]]
            if sign and (abs(rest) < SIDED or rest * sign < 0.0):
                self._tell("no fold angle: it rests as it is folded, which is not as M or V says", name)
            return kind != "U", rest
        if sign:
            degrees = f"{math.degrees(REST):g}"
            said = "a fold angle of 0, which is where the flat sheet is" if given else "no fold angle"
            self._tell(f"{said}; M rests at -{degrees} degrees, V at {degrees}", name)
        return sign != 0.0 or kind != "U", sign * REST

    def _longest(self, crease: Crease) -> int:
        """An edge that is marked as most of a hinge is."""
        lengths: dict[tuple[str, float | None], float] = {}
        for k in crease.edges:
            mark = self.frame.kinds[k], self.frame.angles[k]
            a, b = self.frame.edges[k]
            lengths[mark] = lengths.get(mark, 0.0) + math.dist(self.frame.vertices[a], self.frame.vertices[b])
        most = max(lengths, key=lambda mark: lengths[mark])
        return next(k for k in crease.edges if (self.frame.kinds[k], self.frame.angles[k]) == most)

    def _tell(self, what: str, name: str) -> None:
        self._told.setdefault(what, []).append(name)


def _depths(fixed: Sequence[int], pairs: Sequence[tuple[int, int]]) -> dict[int, int]:
    """Creases between each body and the nearest fixed one."""
    beside: dict[int, list[int]] = {}
    for a, b in pairs:
        beside.setdefault(a, []).append(b)
        beside.setdefault(b, []).append(a)
    depth = dict.fromkeys(fixed, 0)
    queue = deque(fixed)
    while queue:
        group = queue.popleft()
        for other in beside.get(group, []):
            if other not in depth:
                depth[other] = depth[group] + 1
                queue.append(other)
    return depth


def _about(body: Body, point: Array, axis: Array) -> float:
    """Moment of inertia about a line, kg·m²."""
    unit = axis / np.linalg.norm(axis)
    arm = np.cross(body.com - point, unit)
    return float(unit @ body.inertia @ unit + body.mass * (arm @ arm))
