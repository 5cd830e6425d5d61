"""The fixed bodies moved as prescribed: by expressions in time, as on a shaker or a turntable."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, ClassVar

import numpy as np

from lamc.basics.errors import DesignError, about
from lamc.basics.fields import Vector
from lamc.basics.quantity_fields import Unit
from lamc.effects.drives import Drive, checked_drive
from lamc.effects.registered import RegisteredEffect
from lamc.mechanics.arrangement import PrescribedBase
from lamc.mechanics.arranging import Arranging
from lamc.mechanics.loads import Loads
from lamc.symbolic.expression import stage
from lamc.symbolic.scalars import Scalar

Prescribed = float | str


@dataclass(frozen=True)
class BaseMotion(RegisteredEffect):
    """A drawn point d of the fixed bodies is at point + Rot(axis, angle) (d - point) + displacement.

    Velocities and accelerations follow by differentiation, so an expression must be smooth: a run is refused where one
    has a kink on the way, such as abs(sin(t)), for no integrator sees the acceleration there. The fixed bodies' own
    mass takes no part; the power of what moves them is that of the wrench on the rest.
    """

    displacement: Annotated[
        tuple[Prescribed, Prescribed, Prescribed],
        Unit(
            "m",
            "along world x, y and z: numbers, or expressions in t (s) and inputs of the scene, such as "
            "0.01*sin(2*pi*50*t)",
        ),
    ] = (0.0, 0.0, 0.0)
    angle: Annotated[Prescribed, Unit("rad", "of a turn about the axis: a number, or such an expression")] = (
        0.0
    )
    axis: Annotated[Vector, Unit("1", "of that turn, world, as drawn; made a unit vector")] = (0.0, 0.0, 1.0)
    point: Annotated[Vector, Unit("m", "of the axis, world, as drawn")] = (0.0, 0.0, 0.0)

    name: ClassVar[str] = "base_motion"
    summary: ClassVar[str] = "Fixed bodies that move as told"
    example: ClassVar[str] = 'base_motion: {displacement: [0, 0, "0.001*sin(2*pi*20*t)"]}'
    source: ClassVar[str] = "x(t) and θ(t), differentiated"
    absent: ClassVar[str] = "the fixed bodies stay where they are"

    def __post_init__(self) -> None:
        super().__post_init__()
        for drive in self.drives():
            checked_drive(drive)
        if not 0.0 < math.hypot(*self.axis) < math.inf:
            with about(("axis",)):
                raise DesignError(
                    f"the axis of base_motion is {self.axis}; it must have a direction and a length"
                )
        if not any(isinstance(v, str) for v in (*self.displacement, self.angle)):
            raise DesignError(
                "base_motion moves nothing: displacement and angle are plain numbers; give expressions in t, or leave "
                "it out"
            )

    def claims(self) -> tuple[str, ...]:
        return ("motion of the base",)

    def arrange(self, arranging: Arranging) -> None:
        """Prescribes the motion of the fixed bodies."""
        axis = np.array(self.axis)
        bodies = tuple(body.name for body in arranging.tree.mechanism.bodies if body.fixed)
        unit = axis / math.hypot(*self.axis)
        arranging.move_base(PrescribedBase(bodies, self._staged, unit, np.array(self.point)))

    def contribute(self, loads: Loads) -> None:
        """Nothing: the motion is in the kinematics."""

    def _staged(self, time: Scalar, inputs: Mapping[str, Scalar]) -> tuple[Scalar, Scalar, Scalar, Scalar]:
        names = {"t": time, **inputs}
        x, y, z, angle = (
            stage(v, names) if isinstance(v, str) else v for v in (*self.displacement, self.angle)
        )
        return x, y, z, angle

    def drives(self) -> tuple[Drive, ...]:
        """The displacements and the angle that are expressions."""
        given: list[tuple[str, float | str, tuple[str | int, ...]]] = [
            (f"the {axis} displacement", value, ("displacement", k))
            for k, (axis, value) in enumerate(zip("xyz", self.displacement, strict=True))
        ]
        given.append(("the angle", self.angle, ("angle",)))
        return tuple(
            Drive(f"{name} of base_motion", value, smooth=True, field=field)
            for name, value, field in given
            if isinstance(value, str)
        )
