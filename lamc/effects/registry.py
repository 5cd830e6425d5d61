"""The effects that lamc brings. To add one, write its module and put its class here."""

from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import NamedTuple

from lamc.basics.checks import did_you_mean
from lamc.basics.errors import DesignError, about
from lamc.effects.base_motion import BaseMotion
from lamc.effects.bender import PiezoBender
from lamc.effects.blade_element import BladeElementDrag
from lamc.effects.cable import Cable
from lamc.effects.external_torque import ExternalTorque
from lamc.effects.flexible import FlexibleLinks
from lamc.effects.free_base import FreeBase
from lamc.effects.gravity import Gravity
from lamc.effects.ground_contact import GroundContact
from lamc.effects.hinges import HingeDamping, HingeStiffness, RestAngle
from lamc.effects.limits import JointLimits
from lamc.effects.motor import LinearMotor
from lamc.effects.nonlinear import NonlinearStiffness
from lamc.effects.pouch import Pouch
from lamc.effects.registered import RegisteredEffect
from lamc.effects.servo import Servo
from lamc.effects.spring import Spring
from lamc.effects.torque import Torque
from lamc.effects.twist import TwistCompliance
from lamc.records.effect import Effect, claims_of, hooked
from lamc.records.mechanism import Mechanism
from lamc.records.scene import Scene

EFFECTS: tuple[type[RegisteredEffect], ...] = (
    Gravity,
    HingeStiffness,
    PiezoBender,
    RestAngle,
    HingeDamping,
    JointLimits,
    LinearMotor,
    Cable,
    NonlinearStiffness,
    Pouch,
    Servo,
    Spring,
    Torque,
    GroundContact,
    FreeBase,
    BaseMotion,
    TwistCompliance,
    BladeElementDrag,
    FlexibleLinks,
    ExternalTorque,
)


MOST_CLAIMS_REPORTED = 3
ADDED = "added by the scene"


class Choice(NamedTuple):
    """One line of the account of effects: the effect that acts, or None, and why; whether somebody asked to leave it
    out."""

    name: str
    effect: Effect | None
    reason: str
    left_out: bool = False


def by_name() -> Mapping[str, type[RegisteredEffect]]:
    """The effects by the name that scene files use."""
    return MappingProxyType({kind.name: kind for kind in EFFECTS})


def choose(mechanism: Mechanism, scene: Scene) -> tuple[Choice, ...]:
    """Which effects act in the scene and which do not, sorted by name, so that no order of listing matters.

    Raises DesignError for two effects of one name, for two that claim the same thing, and for a name of no effect among
    those left out.
    """
    if scene.effects is not None:
        choices = _called(scene.effects)
    else:
        choices = [Choice(kind.name, *kind.default_for(mechanism)) for kind in EFFECTS]
    choices = _changed(choices, scene)
    choices.sort(key=lambda c: c.name)
    _check_claims([choice.effect for choice in choices if choice.effect is not None])
    return tuple(_with_claims(choice) for choice in choices)


def _called(effects: Sequence[Effect]) -> list[Choice]:
    """The account where a scene lists its effects."""
    names = [effect.name for effect in effects]
    for effect in effects:
        if names.count(effect.name) > 1 and not hooked(effect).repeatable:
            raise DesignError(
                f"two effects of the scene are named {effect.name!r}; names keep their energies apart"
            )
    choices = [Choice(effect.name, effect, "the scene calls for it") for effect in effects]
    return choices + [
        Choice(kind.name, None, "the scene does not call for it")
        for kind in EFFECTS
        if kind.name not in names
    ]


def _changed(choices: list[Choice], scene: Scene) -> list[Choice]:
    """The account after what the scene adds and leaves out."""
    for effect in scene.added:
        kept = hooked(effect).repeatable
        choices = [c for c in choices if c.name != effect.name or (kept and c.effect is not None)]
        choices.append(Choice(effect.name, effect, ADDED))
    for name in scene.without:
        if not any(choice.name == name for choice in choices):
            known = sorted({choice.name for choice in choices})
            with about(("without", name)):
                raise DesignError(
                    f"the scene is to be without {name[:40]!r}, which is no effect; {did_you_mean(name, known)}"
                )
        choices = [c for c in choices if c.name != name] + [Choice(name, None, "left out by the scene", True)]
    return choices


def _check_claims(effects: Sequence[Effect]) -> None:
    """Raises DesignError where two effects claim the same thing."""
    holders: dict[str, str] = {}
    for effect in effects:
        for claim in claims_of(effect):
            if claim in holders:
                with about(effect):
                    raise DesignError(
                        f"{holders[claim]} and {effect.name} both claim the {claim}, which only one effect can have: "
                        "leave one of them out of the scene"
                    )
            holders[claim] = effect.name


def _with_claims(choice: Choice) -> Choice:
    """The line of the account says what the effect has for itself."""
    claims = claims_of(choice.effect) if choice.effect is not None else ()
    if not claims:
        return choice
    more = f" and {len(claims) - MOST_CLAIMS_REPORTED} more" if len(claims) > MOST_CLAIMS_REPORTED else ""
    return choice._replace(
        reason=f"{choice.reason}; it alone gives the {', the '.join(claims[:MOST_CLAIMS_REPORTED])}{more}"
    )
