"""The fixed bodies let go: all of them together float as one rigid body."""

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, ClassVar

import numpy as np

from lamc.basics.errors import DesignError
from lamc.basics.fields import Vector
from lamc.basics.quantity_fields import Unit
from lamc.effects.registered import RegisteredEffect
from lamc.mechanics.arrangement import FloatingBase
from lamc.mechanics.arranging import Arranging
from lamc.mechanics.loads import Loads
from lamc.mechanism.rotations import snap
from lamc.records.mechanism import Array, Body

if TYPE_CHECKING:
    from lamc.effects.engine_loads import EngineLoads


@dataclass(frozen=True)
class FreeBase(RegisteredEffect):
    """Six more freedoms: world position of the centre of mass of what was fixed, and its rotation, a quaternion.

    The fixed bodies need mass and inertia; several are one rigid body. A pose has no singular attitude.
    """

    position: Annotated[
        Vector | None, Unit("m", "of that centre of mass at the start, world; left out: as drawn")
    ] = None
    rotation: Annotated[
        Vector, Unit("rad", "at the start, from the drawn position, as axis times angle, world axes")
    ] = (0.0, 0.0, 0.0)
    velocity: Annotated[Vector, Unit("m/s", "of that centre of mass at the start, world axes")] = (
        0.0,
        0.0,
        0.0,
    )
    spin: Annotated[Vector, Unit("rad/s", "angular velocity at the start, axes of the body")] = (
        0.0,
        0.0,
        0.0,
    )

    name: ClassVar[str] = "free_base"
    summary: ClassVar[str] = "Fixed bodies that float"
    example: ClassVar[str] = "free_base: {position: [0, 0, 40 mm], spin: [1, 0, 0]}"
    conservative: ClassVar[bool] = True
    source: ClassVar[str] = "Newton and Euler for the base; quaternion rates ½ q ω"
    absent: ClassVar[str] = "the fixed bodies stay where they are"

    def claims(self) -> tuple[str, ...]:
        return ("motion of the base",)

    def arrange(self, arranging: Arranging) -> None:
        """Lets the fixed bodies float. Raises DesignError where they have no mass or no inertia."""
        bodies = [body for body in arranging.tree.mechanism.bodies if body.fixed]
        mass, com, inertia = _together(bodies)
        _check_mass(bodies, mass, inertia)
        arranging.move_base(
            FloatingBase(
                bodies=tuple(body.name for body in bodies),
                mass=mass,
                com=com,
                inertia=snap(inertia, float(np.abs(inertia).max())),
                position=np.array(com if self.position is None else self.position),
                rotation=_quaternion(np.array(self.rotation)),
                velocity=np.array(self.velocity),
                spin=np.array(self.spin),
            )
        )

    def contribute(self, loads: Loads) -> None:
        """Nothing: its coordinates are all there is."""

    def carry_over(self, engine: "EngineLoads") -> None:
        """Nothing: `arrange` says it all."""


def _together(bodies: list[Body]) -> tuple[float, Array, Array]:
    """Mass, kg, centre of mass, m, and inertia about it, kg·m², of bodies as one; world axes."""
    mass = math.fsum(body.mass for body in bodies)
    if not mass:
        return 0.0, np.zeros(3), np.zeros((3, 3))
    if len(bodies) == 1:
        return mass, bodies[0].com, bodies[0].inertia
    com = np.array(sum(body.mass * body.com for body in bodies)) / mass
    inertia = np.zeros((3, 3))
    for body in bodies:
        r = body.com - com
        inertia += body.inertia + body.mass * (float(r @ r) * np.eye(3) - np.outer(r, r))
    return mass, com, inertia


def _check_mass(bodies: list[Body], mass: float, inertia: Array) -> None:
    names = ", ".join(repr(body.name) for body in bodies)
    which = f"fixed body {names} has" if len(bodies) == 1 else f"fixed bodies {names} have"
    if mass <= 0.0:
        raise DesignError(
            f"the {which} no mass, so that nothing can float: give mass, centre of mass and inertia (a drawn body has "
            "them by its layers), or leave free_base out"
        )
    # Without inertia about an axis no torque would be too small to spin the base about it.
    moments = np.linalg.eigvalsh(0.5 * (inertia + inertia.T))
    if moments[0] <= 1e-12 * moments[-1] or moments[-1] <= 0.0:
        raise DesignError(
            f"the {which} a principal moment of inertia of {moments[0]:g} kg·m², and a body that floats needs three "
            "above zero: give the inertia, or leave free_base out"
        )


def _quaternion(turn: Array) -> Array:
    """(w, x, y, z) of a turn given as axis times angle."""
    angle = math.hypot(*turn)
    if angle == 0.0:
        return np.array([1.0, 0.0, 0.0, 0.0])
    return np.array([math.cos(0.5 * angle), *(math.sin(0.5 * angle) / angle * turn)])
