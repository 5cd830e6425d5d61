"""A cable that pulls through points of bodies: slack or taut, wound up by a drive, with friction where it turns."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Annotated, ClassVar

import numpy as np
from pydantic import Field

from lamc.basics.checks import Array
from lamc.basics.errors import DesignError, about
from lamc.basics.fields import NamesInARow, Vector
from lamc.basics.quantity_fields import Unit
from lamc.effects.drives import Drive, checked_drive
from lamc.effects.registered import RegisteredEffect
from lamc.mechanics.loads import Loads
from lamc.records.mechanism import Mechanism
from lamc.symbolic.algebra import Vector3, add, cross, dot, scale, total
from lamc.symbolic.derivative import derivative
from lamc.symbolic.expression import stage
from lamc.symbolic.scalars import Scalar, Value, call

_ROUND_OFF = 1e-12  # of the points' coordinates
_STRAIGHT = 1e-12  # rad, added in square to angles of wrap, which have no derivative at nought


@dataclass(frozen=True)
class Part:
    """What runs from one point to the next: length m, its rate m/s, unit vector to the next point."""

    length: Scalar
    rate: Scalar
    along: Vector3


@dataclass(frozen=True)
class Cable(RegisteredEffect):
    """A cable from the first point through those between to the last: tension = stiffness stretch + damping its rate,
    where it is taut, and never below zero.

    The stretch is the way through all points beyond the cable's length: a number, a parameter of the simulator; or, of
    a drive that winds it up, an expression in t (s) and inputs of the scene. Left out, the cable is just taut as drawn.
    The cable has no mass and slides through the points between.

    With friction it loses tension at each of them (Euler, Eytelwein): the stretch tells the tension T at the first
    point, where a drive pulls, and beyond a point at which the cable turns by θ it is T exp(-friction θ s). s is 1
    where the cable slides towards the first point, -1 where it slides back, and in between tanh(speed / slip_speed):
    a cable at rest has no friction to hold it, and creeps.

    Where it becomes taut or slack, and where its damping would make it push, are events. Several may act in one scene.
    """

    bodies: Annotated[
        NamesInARow, Field(description="the body of each point, in the order in which the cable runs")
    ]
    points: Annotated[
        tuple[Vector, ...],
        Unit("m", "where the points are in the drawn configuration, world axes; at least 2"),
    ]
    stiffness: Annotated[float, Unit("N/m", "of the whole cable: tension per stretch", gt=0.0)]
    length: Annotated[
        float | str | None,
        Unit("m", "unstretched, through all points; left out: as drawn, through the points"),
    ] = None
    damping: Annotated[float, Unit("N*s/m", "of the rate of the stretch, while taut", ge=0.0)] = 0.0
    friction: Annotated[float, Unit("1", "coefficient at the points between the ends", ge=0.0)] = 0.0
    slip_speed: Annotated[
        float, Unit("m/s", "of sliding, from which on friction has nearly its full value", gt=0.0)
    ] = 1e-3

    name: ClassVar[str] = "cable"
    summary: ClassVar[str] = "Cables through points"
    example: ClassVar[str] = (
        "cable: {bodies: [frame, frame, arm], points: [[0, 0, 0], [10 mm, 0, 5 mm], [30 mm, 0, 1 mm]], "
        "stiffness: 2 N/mm, length: 0.03 - 0.001*t}"
    )
    source: ClassVar[str] = "T = k (l - l0) + c dl/dt >= 0; beyond a turn T exp(-mu theta), Euler 1762"
    repeatable: ClassVar[bool] = True
    absent: ClassVar[str] = "no cable is called for"

    def __post_init__(self) -> None:
        super().__post_init__()
        if len(self.bodies) != len(self.points) or len(self.points) < 2:
            with about(("bodies" if len(self.bodies) < max(len(self.points), 2) else "points",)):
                raise DesignError(
                    f"the cable has {len(self.bodies)} bodies and {len(self.points)} points; it needs at least 2 "
                    "points, and the body of each"
                )
        if isinstance(self.length, float) and self.length <= 0.0:
            with about(("length",)):
                raise DesignError(f"the length of the cable is {self.length:g} m; it must be above 0")
        if self.friction and len(self.points) < 3:
            with about(("friction",)):
                raise DesignError(
                    "the cable has friction, but no point between its ends to rub on: leave one out"
                )
        for drive in self.drives():
            checked_drive(drive)

    @property
    def conservative(self) -> bool:
        """Without a damper, friction, and a drive."""
        return not (self.damping or self.friction or isinstance(self.length, str))

    def drives(self) -> tuple[Drive, ...]:
        """The length, if it is an expression."""
        what = f"the length of the cable from {self.bodies[0]!r} to {self.bodies[-1]!r}"
        return (Drive(what, self.length, field=("length",)),) if isinstance(self.length, str) else ()

    def contribute(self, loads: Loads) -> None:
        self._check_acts(loads)
        label = self._label(loads.parameter_names)
        parts = self._parts(loads)
        stiffness = loads.parameter(f"{label}.stiffness", self.stiffness, "N/m", "stiffness of the cable")
        length = self._length(loads, label)
        stretch = total([part.length for part in parts]) - length
        taut = loads.switch(f"{label} is taut", stretch)
        loads.stored_energy(0.5 * (taut * (stiffness * (stretch * stretch))))
        tension: Scalar = stiffness * stretch
        if self.damping:
            damping = loads.parameter(
                f"{label}.damping", self.damping, "N·s/m", "damping of the cable's stretch"
            )
            wound = derivative(length, {loads.time: 1}) if isinstance(loads.time, Value) else 0
            tension = tension + damping * (total([part.rate for part in parts]) - wound)
            pulls = loads.switch(f"{label} pulls", tension)
            tension = pulls * tension
        tensions = self._along(loads, label, parts, taut * tension)
        pulled = [scale(tension, part.along) for tension, part in zip(tensions, parts, strict=True)]
        for place, (body, point) in enumerate(zip(self.bodies, self.points, strict=True)):
            force: Vector3 = pulled[place] if place < len(pulled) else (0, 0, 0)
            if place:
                force = add(force, scale(-1, pulled[place - 1]))
            loads.force(body, point, force)

    def _check_acts(self, loads: Loads) -> None:
        """Raises DesignError for a body that is not there, and where no two points move against each other."""
        refused: list[DesignError] = []
        for a, b in pairwise(self.bodies):
            loads.link_of(a), loads.link_of(b)
            try:
                loads.check_apart("the cable", a, b)
            except DesignError as error:
                refused.append(error)
        if len(refused) == len(self.bodies) - 1:
            raise refused[0]

    def _parts(self, loads: Loads) -> list[Part]:
        parts = []
        ends = list(zip(self.bodies, self.points, strict=True))
        for a, b in pairwise(ends):
            between = _difference(loads.position(*b), loads.position(*a))
            square = dot(between, between)
            if not isinstance(square, Value):
                self._check_length(math.sqrt(square), a[0], b[0])
            length = call("sqrt", square)
            along = scale(1 / length, between)
            parting = _difference(loads.velocity(*b), loads.velocity(*a))
            parts.append(Part(length, dot(along, parting), along))
        return parts

    def _length(self, loads: Loads, label: str) -> Scalar:
        if isinstance(self.length, str):
            return stage(self.length, {"t": loads.time, **loads.inputs})
        length = self.length if self.length is not None else self.drawn_length
        return loads.parameter(f"{label}.length", length, "m", "length of the cable, unstretched")

    @property
    def drawn_length(self) -> float:
        """Through the points as drawn, m."""
        return math.fsum(math.dist(a, b) for a, b in pairwise(self.points))

    def _along(self, loads: Loads, label: str, parts: Sequence[Part], first: Scalar) -> list[Scalar]:
        """Tension of each part, N, from that of the first one."""
        if not self.friction:
            return [first] * len(parts)
        friction = loads.parameter(
            f"{label}.friction", self.friction, "1", "friction of the cable at its points"
        )
        slip = loads.parameter(
            f"{label}.slip_speed", self.slip_speed, "m/s", "of sliding with nearly full friction"
        )
        tensions, lost = [first], None
        for place, (before, after) in enumerate(pairwise(parts), start=1):
            across = cross(before.along, after.along)
            sine = call("sqrt", dot(across, across) + _STRAIGHT * _STRAIGHT)
            turned = call("atan2", sine, dot(before.along, after.along))
            inwards = -total(
                [part.rate for part in parts[place:]]
            )  # what passes the point towards the first one
            here = turned * call("tanh", inwards / slip)
            lost = here if lost is None else lost + here
            tensions.append(first * call("exp", -(friction * lost)))
        return tensions

    def _label(self, taken: Sequence[str]) -> str:
        """What the cable's parameters begin with; a second one between the same bodies is number 2."""
        label = f"cable.{self.bodies[0]}.{self.bodies[-1]}"
        count = sum(name.startswith(f"{label}.") and name.endswith(".stiffness") for name in taken)
        return f"{label}.{count + 1}" if count else label

    def check_poses(
        self, mechanism: Mechanism, poses: Mapping[str, tuple[Array, Array]], parameters: Mapping[str, float]
    ) -> None:
        """Raises DesignError where two neighbouring points are in one place at the start."""
        coms = {body.name: body.com for body in mechanism.bodies}
        places = []
        for name, point in zip(self.bodies, self.points, strict=True):
            com, rotation = poses.get(name, (coms[name], np.eye(3)))  # fixed bodies are as drawn
            places.append(com + rotation @ (np.array(point) - coms[name]))
        for k, (a, b) in enumerate(pairwise(places)):
            self._check_length(float(np.linalg.norm(b - a)), *self.bodies[k : k + 2])

    def _check_length(self, length: float, body_a: str, body_b: str) -> None:
        size = max(abs(x) for point in self.points for x in point)
        if length <= _ROUND_OFF * size:
            raise DesignError(
                f"the cable has two points in one place at the start, of {body_a!r} and {body_b!r}, and no direction "
                "between them; leave one out, or move it (on a hinge they never part)"
            )


def _difference(a: Sequence[Scalar], b: Sequence[Scalar]) -> Vector3:
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])
