"""Torques on hinges that come from outside while a model runs: from a controller, another program, a person's hand."""

from collections.abc import Container
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, ClassVar

from pydantic import Field

from lamc.basics.fields import Names
from lamc.effects.registered import RegisteredEffect
from lamc.mechanics.loads import Loads

if TYPE_CHECKING:
    from lamc.effects.engine_loads import EngineLoads

_EVERY = "torque from outside on every hinge"


def constant_claim(joint: str) -> str:
    """What an effect says that gives a hinge a constant torque as a parameter: that one is then the input."""
    return f"constant torque of hinge {joint!r}"


def is_outside(joint: str, claims: Container[str]) -> bool:
    """Whether an effect of the scene takes the torque on this hinge from outside, by what all effects claim."""
    return _EVERY in claims or _claim(joint) in claims


def _claim(joint: str) -> str:
    return f"torque from outside on hinge {joint!r}"


@dataclass(frozen=True)
class ExternalTorque(RegisteredEffect):
    """A torque on each hinge's child about the hinge's axis, N·m, an input of the model; positive opens the fold.

    The input is `<joint>.torque`, zero unless set otherwise, and constant within a run unless a series of the scene has
    that name. A hinge on which `Torque` acts with a number has that as its input, with that number as its default;
    one with an expression has both. With all inputs zero the motion is that without the effect, to the last bit.
    """

    joints: Annotated[
        Names | None,
        Field(description="names of the hinges; left out: every one, those that close loops too"),
    ] = None

    name: ClassVar[str] = "external_torque"
    summary: ClassVar[str] = "Hinge torques from outside"
    example: ClassVar[str] = "external_torque: [knee]"
    source: ClassVar[str] = "eq. 17"
    shorthand: ClassVar[str] = "joints"
    absent: ClassVar[str] = "no torque comes from outside"

    def claims(self) -> tuple[str, ...]:
        return (_EVERY,) if self.joints is None else tuple(_claim(joint) for joint in self.joints)

    def contribute(self, loads: Loads) -> None:
        for joint in self.joints or ():
            loads.hinge(joint)  # refuses what is not there
        for hinge in loads.hinges():
            joint = hinge.joint.name
            chosen = self.joints is None or joint in self.joints
            if chosen and constant_claim(joint) not in loads.claims:
                torque = loads.parameter(f"{joint}.torque", 0.0, "N·m", "torque from outside", is_input=True)
                loads.hinge_torque(joint, torque)

    def carry_over(self, engine: "EngineLoads") -> None:
        """The same: an engine takes them while it runs."""
        for joint in self.joints or tuple(joint.name for joint in engine.mechanism.joints):
            engine.hinge_outside(joint)
