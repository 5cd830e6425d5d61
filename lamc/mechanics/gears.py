"""Inertia of rotors behind gears: on a joint's own rate, or on a coordinate of its own where the gear has play.

Goes in: joints by name, inertias as staged by an effect. Comes out: entries of `Loads.reflected`, and the gear's angle
as effects see it. That a rotor turns with its joint's parent too is of the order of the gear ratio beside its square,
and left out (R. Featherstone, Rigid Body Dynamics Algorithms, 2008, section 9.6).
"""

from dataclasses import dataclass
from typing import TYPE_CHECKING

from lamc.basics.errors import DesignError
from lamc.symbolic.scalars import Scalar

if TYPE_CHECKING:
    from lamc.mechanics.loads import Loads


@dataclass(frozen=True)
class GearAngle:
    """The gear of a joint as effects see it: relative to the joint's parent, as the joint's own angle."""

    place: int  # among coordinates and rates
    angle: Scalar  # rad
    rate: Scalar  # rad/s


def gear_name(joint: str) -> str:
    """Of the coordinate that `Arranging.gear` adds."""
    return f"{joint}.gear"


def gear_of(loads: "Loads", joint: str) -> GearAngle:
    """The gear that the effect's `arrange` asked for. Raises DesignError for a hinge that yields and closes a loop."""
    arrangement = loads.kinematics.arrangement
    names = [each.name for each in arrangement.plain_coordinates] if arrangement is not None else []
    if gear_name(joint) not in names:
        raise DesignError(
            f"joint {joint!r} yields and closes a loop, so that its angle is no coordinate, and no gear can turn "
            "beside it: leave the play out, or let the joint not yield"
        )
    place = names.index(gear_name(joint))
    return GearAngle(place, *loads.coordinate(place))


def reflected_inertia(loads: "Loads", joint: str, inertia: Scalar) -> None:
    """Adds kinetic energy ½ inertia u², kg·m², of the joint's own rate u. The effect's `arrange` has to ask for
    `inverse_dynamics`. The energy is booked under the effect. Raises DesignError for a joint that closes a loop: its
    rate is taken to move no mass, everywhere."""
    name = loads.hinge(joint).joint.name
    names = [each.joint.name for each in loads.tree.links]
    if name not in names:
        raise DesignError(
            f"joint {joint!r} closes a loop, and its rate follows from the others', so that no gear's inertia can "
            "act on it: set that to 0, or give the inertia to another joint of the loop"
        )
    gear_inertia(loads, names.index(name), inertia)


def gear_inertia(loads: "Loads", place: int, inertia: Scalar) -> None:
    """Adds kinetic energy ½ inertia u², kg·m², of the rate u at that place."""
    if loads.kinematics.arrangement is None:
        raise DesignError(
            f"effect {loads.effect_name!r} adds inertia to a rate, but its arrange(arranging) does not call "
            "arranging.inverse_dynamics(); let it do so"
        )
    loads.reflected.setdefault(place, []).append((loads.effect_name, inertia))
