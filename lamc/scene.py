"""The `Scene`: which effects act, and how the mechanism starts. Nothing here knows any effect by name."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from numbers import Integral
from typing import TYPE_CHECKING

from lamc.errors import DesignError
from lamc.mechanism.checks import checked_number, shown
from lamc.readonly import ReadOnlyDict

if TYPE_CHECKING:
    from lamc.effects.base import Effect


_NEEDED = ("name", "summary", "contribute")  # what `lamc.effects.base.Effect` asks for


def _angles(values: Mapping[str, float], argument: str, what: str) -> Mapping[str, float]:
    if not isinstance(values, Mapping):
        raise DesignError(
            f"{argument} of a scene is {shown(values)}; it must map joint names to numbers, as in {{'h1': 0.1}}"
        )
    return ReadOnlyDict({str(k): checked_number(v, f"the {what} of joint {k!r}") for k, v in values.items()})


def _effects(values: "Iterable[Effect]") -> "tuple[Effect, ...]":
    if isinstance(values, type) or hasattr(values, "contribute"):
        name = values.__name__ if isinstance(values, type) else type(values).__name__
        raise DesignError(f"effects of a scene is {shown(values)}, no tuple; write effects=({name}(),)")
    if isinstance(values, str | bytes | Mapping) or not isinstance(values, Iterable):
        raise DesignError(f"effects of a scene is {shown(values)}; it must be None or a tuple of effects")
    effects = tuple(values)
    for effect in effects:
        if isinstance(effect, type):
            raise DesignError(
                f"effects of a scene holds the class {effect.__name__}; make one: {effect.__name__}()"
            )
        missing = [each for each in _NEEDED if not hasattr(effect, each)]
        if missing:
            raise DesignError(
                f"effects of a scene holds {shown(effect)}, which is no effect (it has no {missing[0]!r}); "
                "make an instance of one, such as those in lamc.effects"
            )
    return effects


@dataclass(frozen=True)
class Scene:
    """What a run calls for.

    effects  None: what the design itself asks for; a tuple: exactly these, and an empty one means none
    angles   initial joint angles by joint name, rad; joints left out start at zero (the drawn angle)
    rates    initial joint rates by joint name, rad/s; joints left out start at zero
             with loops, what is left out follows from closure, as near to zero as that allows
    branch   which way out of a singular start, such as a flat one: 1 is the first of `Simulator.branches`; -1 the same
             the other way
    closure_tolerance  m, the gap up to which loops that do not fit count as closed; None: 1e-6 of the size

    Raises DesignError for what are no effects, no numbers, or an effect twice.
    """

    effects: "tuple[Effect, ...] | None" = None
    angles: Mapping[str, float] = field(default_factory=dict)  # rad
    rates: Mapping[str, float] = field(default_factory=dict)  # rad/s
    branch: int | None = None
    closure_tolerance: float | None = None  # m

    def __post_init__(self) -> None:
        if self.effects is not None:
            effects = _effects(self.effects)
            kinds = [type(e) for e in effects]
            for kind in kinds:
                if kinds.count(kind) > 1 and not getattr(kind, "repeatable", False):
                    raise DesignError(f"the scene calls for {kind.__name__} twice; once is all it can act")
            object.__setattr__(self, "effects", effects)
        object.__setattr__(self, "angles", _angles(self.angles, "angles", "initial angle"))
        object.__setattr__(self, "rates", _angles(self.rates, "rates", "initial rate"))
        if self.branch is not None:
            whole = isinstance(self.branch, Integral) and not isinstance(self.branch, bool)
            if not whole or self.branch == 0:
                raise DesignError(
                    f"branch of a scene is {shown(self.branch)}; it must be 1, 2, … as the branches are listed, "
                    "or -1, -2, … for the other way"
                )
            object.__setattr__(self, "branch", int(self.branch))
        if self.closure_tolerance is not None:
            tolerance = checked_number(self.closure_tolerance, "closure_tolerance of a scene", minimum=0.0)
            object.__setattr__(self, "closure_tolerance", tolerance)
