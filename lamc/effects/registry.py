"""The effects that lamc brings. To add one, write its module and put its class here."""

from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import NamedTuple

from lamc.effects.base import Effect, RegisteredEffect, claims_of
from lamc.effects.gravity import Gravity
from lamc.effects.ground_contact import GroundContact
from lamc.effects.hinges import HingeDamping, HingeStiffness, RestAngle
from lamc.effects.limits import JointLimits
from lamc.effects.spring import Spring
from lamc.effects.torque import Torque
from lamc.errors import DesignError
from lamc.mechanism.records import Mechanism
from lamc.scene import Scene

EFFECTS: tuple[type[RegisteredEffect], ...] = (
    Gravity,
    HingeStiffness,
    RestAngle,
    HingeDamping,
    JointLimits,
    Spring,
    Torque,
    GroundContact,
)


MOST_CLAIMS_TOLD = 3


class Choice(NamedTuple):
    """One line of the account of effects: the effect that acts, or None, and why."""

    name: str
    effect: Effect | None
    reason: str


def by_name() -> Mapping[str, type[RegisteredEffect]]:
    """The effects by the name that scene files use."""
    return MappingProxyType({kind.name: kind for kind in EFFECTS})


def choose(mechanism: Mechanism, scene: Scene) -> tuple[Choice, ...]:
    """Which effects act in the scene and which do not, sorted by name, so that no order of listing matters.

    Raises DesignError for two effects of one name, and for two that claim the same thing.
    """
    choices: list[Choice] = []
    if scene.effects is not None:
        names = [e.name for e in scene.effects]
        called = set(names)
        for called_for in scene.effects:
            if names.count(called_for.name) > 1 and not getattr(called_for, "repeatable", False):
                raise DesignError(
                    f"two effects of the scene are named {called_for.name!r}; names keep their energies apart"
                )
        choices += [Choice(e.name, e, "the scene calls for it") for e in scene.effects]
        choices += [
            Choice(k.name, None, "the scene does not call for it") for k in EFFECTS if k.name not in called
        ]
    else:
        for kind in EFFECTS:
            effect, reason = kind.default_for(mechanism)
            choices.append(Choice(kind.name, effect, reason))
    choices.sort(key=lambda c: c.name)
    _check_claims([choice.effect for choice in choices if choice.effect is not None])
    return tuple(_with_claims(choice) for choice in choices)


def _check_claims(effects: Sequence[Effect]) -> None:
    """Raises DesignError where two effects claim the same thing."""
    holders: dict[str, str] = {}
    for effect in effects:
        for claim in claims_of(effect):
            if claim in holders:
                raise DesignError(
                    f"{holders[claim]} and {effect.name} both claim the {claim}, which only one effect can have: leave "
                    "one of them out of the scene"
                )
            holders[claim] = effect.name


def _with_claims(choice: Choice) -> Choice:
    """The line of the account says what the effect has for itself."""
    claims = claims_of(choice.effect) if choice.effect is not None else ()
    if not claims:
        return choice
    more = f" and {len(claims) - MOST_CLAIMS_TOLD} more" if len(claims) > MOST_CLAIMS_TOLD else ""
    return choice._replace(
        reason=f"{choice.reason}; it alone gives the {', the '.join(claims[:MOST_CLAIMS_TOLD])}{more}"
    )
