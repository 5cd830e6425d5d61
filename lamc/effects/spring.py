"""A spring, with damper if wished, between a point of one body and a point of another."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, ClassVar

import numpy as np
from pydantic import Field

from lamc.basics.checks import Array
from lamc.basics.errors import DesignError
from lamc.basics.fields import Name, Vector
from lamc.basics.quantity_fields import Unit
from lamc.effects.registered import RegisteredEffect
from lamc.mechanics.loads import Loads
from lamc.records.mechanism import Mechanism
from lamc.symbolic.algebra import Vector3, dot
from lamc.symbolic.scalars import Scalar, Value, call

if TYPE_CHECKING:
    from lamc.effects.engine_loads import EngineLoads

_ROUND_OFF = 1e-12  # of the points' coordinates


@dataclass(frozen=True)
class Spring(RegisteredEffect):
    """Pulls its two points together when it is longer than its rest length; several may act in one scene."""

    body_a: Annotated[Name, Field(description="the body of the first end")]
    point_a: Annotated[Vector, Unit("m", "where the point is in the drawn configuration, world axes")]
    body_b: Annotated[Name, Field(description="the body of the other end")]
    point_b: Annotated[Vector, Unit("m", "where the point is in the drawn configuration, world axes")]
    stiffness: Annotated[float, Unit("N/m", "force per stretch", ge=0.0)]
    rest_length: Annotated[
        float,
        Unit(
            "m",
            "a spring of no length has no direction: with a rest length the points must stay apart",
            ge=0.0,
        ),
    ] = 0.0
    damping: Annotated[float, Unit("N*s/m", "of the rate of change of the length", ge=0.0)] = 0.0

    name: ClassVar[str] = "spring"
    summary: ClassVar[str] = "Springs between points"
    example: ClassVar[str] = (
        "spring: {body_a: frame, point_a: [0, 0, 0], body_b: arm, point_b: [10 mm, 0, 2 mm], stiffness: "
        "0.2 N/mm, rest_length: 8 mm}"
    )
    source: ClassVar[str] = "F = -(k (l - l0) + c dl/dt) along the line, eq. 18"
    repeatable: ClassVar[bool] = True
    absent: ClassVar[str] = "no spring is called for"

    @property
    def conservative(self) -> bool:
        """Without a damper it is."""
        return not self.damping

    def contribute(self, loads: Loads) -> None:
        loads.check_apart("the spring", self.body_a, self.body_b)
        between = _difference(
            loads.position(self.body_b, self.point_b), loads.position(self.body_a, self.point_a)
        )
        label = f"spring.{self.body_a}.{self.body_b}"
        taken = sum(
            1 for name in loads.parameter_names if name.startswith(label) and name.endswith(".stiffness")
        )
        label = f"{label}.{taken + 1}" if taken else label
        k = loads.parameter(f"{label}.stiffness", self.stiffness, "N/m", "stiffness of the spring")
        square = dot(between, between)
        self._check_apart(square)
        length = call("sqrt", square) if self.rest_length or self.damping else 0
        pull: Scalar = k  # force over length
        if self.rest_length:
            rest = loads.parameter(
                f"{label}.rest_length", self.rest_length, "m", "length at which it does not pull"
            )
            pull = k - k * rest / length
            stretch = length - rest
            loads.stored_energy(0.5 * (k * (stretch * stretch)))
        else:
            loads.stored_energy(0.5 * (k * square))
        if self.damping:
            c = loads.parameter(f"{label}.damping", self.damping, "N·s/m", "damping of the spring's length")
            closing = _difference(
                loads.velocity(self.body_b, self.point_b), loads.velocity(self.body_a, self.point_a)
            )
            pull = pull + c * dot(between, closing) / square
        force = [pull * x for x in between]
        loads.force(self.body_a, self.point_a, force)
        loads.force(self.body_b, self.point_b, [-f for f in force])

    def _check_apart(self, square: Scalar) -> None:
        """Raises DesignError where points that stay in one place are known as such; others meet `check_poses`."""
        if not isinstance(square, Value):
            self._check_length(math.sqrt(square))

    def check_poses(
        self, mechanism: Mechanism, poses: Mapping[str, tuple[Array, Array]], parameters: Mapping[str, float]
    ) -> None:
        """Raises DesignError where the ends are in one place at the start, and the spring needs a direction."""
        coms = {body.name: body.com for body in mechanism.bodies}
        ends = []
        for name, point in ((self.body_a, self.point_a), (self.body_b, self.point_b)):
            com, rotation = poses.get(name, (coms[name], np.eye(3)))  # fixed bodies are as drawn
            ends.append(com + rotation @ (np.array(point) - coms[name]))
        self._check_length(float(np.linalg.norm(ends[1] - ends[0])))

    def _check_length(self, length: float) -> None:
        size = max(map(abs, (*self.point_a, *self.point_b)))
        if (self.rest_length or self.damping) and length <= _ROUND_OFF * size:
            raise DesignError(
                f"the spring between {self.body_a!r} and {self.body_b!r} has both ends in one place at the start, and "
                "no direction to act along; move an end (on a hinge they never part), or leave out rest_length and "
                "damping"
            )

    def carry_over(self, engine: "EngineLoads") -> None:
        """The same spring."""
        ends = (self.body_a, self.point_a), (self.body_b, self.point_b)
        engine.add_spring(*ends, self.stiffness, self.rest_length, self.damping)


def _difference(a: Sequence[Scalar], b: Sequence[Scalar]) -> Vector3:
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])
