"""The `Scene`: which effects act, and how the mechanism starts. Nothing here knows any effect by name."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import TYPE_CHECKING

from lamc.errors import DesignError
from lamc.mechanism.records import checked_number

if TYPE_CHECKING:
    from lamc.effects.base import Effect


def _angles(values: Mapping[str, float], what: str) -> Mapping[str, float]:
    return MappingProxyType(
        {str(k): checked_number(v, f"the {what} of joint {k!r}") for k, v in values.items()}
    )


@dataclass(frozen=True)
class Scene:
    """What a run calls for.

    effects  None: what the design itself asks for; a tuple: exactly these, and an empty one means none
    angles   initial joint angles by joint name, rad; joints left out start at zero (the drawn angle)
    rates    initial joint rates by joint name, rad/s; joints left out start at zero
    """

    effects: "tuple[Effect, ...] | None" = None
    angles: Mapping[str, float] = field(default_factory=dict)  # rad
    rates: Mapping[str, float] = field(default_factory=dict)  # rad/s

    def __post_init__(self) -> None:
        if self.effects is not None:
            effects = tuple(self.effects)
            kinds = [type(e) for e in effects]
            for kind in kinds:
                if kinds.count(kind) > 1 and not getattr(kind, "repeatable", False):
                    raise DesignError(f"the scene calls for {kind.__name__} twice; once is all it can act")
            object.__setattr__(self, "effects", effects)
        object.__setattr__(self, "angles", _angles(self.angles, "initial angle"))
        object.__setattr__(self, "rates", _angles(self.rates, "initial rate"))
