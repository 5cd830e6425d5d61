"""What an effect is. The rest of the compiler knows effects through this page only.

An effect is a small immutable record. `contribute` adds its symbolic loads, stored energy and parameters to a
`Loads` collector; what it does not add leaves no trace in the equations or in the C. The other methods of `Effect` are
hooks: they do nothing unless an effect overrides them.
"""

import difflib
import inspect
import math
from collections.abc import Container, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, Any, ClassVar

from lamc.basics.checks import Array
from lamc.basics.errors import DesignError, about

if TYPE_CHECKING:
    from lamc.effects.drives import Drive
    from lamc.effects.engine_loads import EngineLoads
    from lamc.mechanics.arranging import Arranging
    from lamc.mechanics.loads import Loads
    from lamc.mechanism.tree import Tree
    from lamc.records.mechanism import Mechanism


@dataclass(frozen=True)
class PlaneMark:
    """A plane to draw, such as the ground: a point of it, m, and its unit normal, world axes, towards what it faces."""

    point: tuple[float, float, float]  # m
    normal: tuple[float, float, float]


class Effect:
    """One physical effect. Effects of one's own are frozen dataclasses of this class.

    name        lower-case identifier, the effect's name in scene files, tables and energies
    summary     one line for people; with `source`, where the law is from, it heads the effect's C
    repeatable  whether a scene may hold several

    A force of one's own, in sympy, on the tip of one body:

        @dataclass(frozen=True)
        class TipDrag(lamc.Effect):
            name: ClassVar[str] = "tip_drag"
            summary: ClassVar[str] = "Drag on the tip"

            def contribute(self, loads):
                u = sympy.Symbol("u_h1")
                loads.hinge_torque("h1", -0.01 * u * sympy.Abs(u))

    An object of another class that has name, summary and contribute will do; of the hooks it may have any. A method
    that is named nearly as a hook is refused: it would never be asked.

    What scene files can name besides is a `RegisteredEffect`, see `lamc/effects/registered.py`. Expressions may hold
    inputs of the scene: `loads.inputs` has them by name, and sympy expressions may hold symbols of their names.
    """

    name: ClassVar[str]
    summary: ClassVar[str]
    source: ClassVar[str] = ""
    repeatable: ClassVar[bool] = False

    def contribute(self, loads: "Loads") -> None:
        """Adds the effect's loads. Raises DesignError if it names bodies or joints that are not there."""
        raise NotImplementedError(f"effect {self.name!r} has no contribute(loads)")

    def arrange(self, arranging: "Arranging") -> None:
        """Adds coordinates, or moves the fixed bodies; asked before `contribute`. See `Arranging`; its method
        inverse_dynamics() is for effects that add fluid's mass."""

    def drives(self) -> "Sequence[Drive]":
        """Expressions in time that the effect acts by: evaluated where the run begins and along it, and refused where
        they have no value. See `lamc/effects/drives.py`."""
        return ()

    def inputs(self) -> Iterable[str]:
        """Names of the scene's inputs that the effect reads otherwise than in its drives."""
        return ()

    def claims(self) -> Iterable[str]:
        """What must be this effect's alone, as short texts such as "motion of the base" or "stiffness of hinge 'h1'":
        two effects of a scene with a claim in common are refused. One that gives way instead asks `loads.claims` who
        holds a claim, and leaves that out: HingeStiffness does, hinge by hinge."""
        return ()

    @property
    def conservative(self) -> bool | None:
        """Whether the energy of a run stays as it is under the effect; None: if the effect stores some. A spring with a
        damper, or a bender under a voltage that changes, stores energy and is not conservative."""
        return None

    def check_start(self, mechanism: "Mechanism", angles: Mapping[str, float]) -> None:
        """Raises DesignError for a start that the effect refuses: angles of all joints by name, rad."""

    def check_poses(
        self,
        mechanism: "Mechanism",
        poses: Mapping[str, tuple[Array, Array]],
        parameters: Mapping[str, float],
    ) -> None:
        """As `check_start`, of where the bodies are, by the name of each that moves: centre of mass (3,), m, and
        rotation from drawn axes (3, 3), world; parameters of the run by name. Asked before each run."""

    def alternatives(self) -> "Mapping[str, Effect]":
        """Cheaper or finer forms, such as with fewer modes of a plate, by a few words each: `lamc ledger` puts each in
        the effect's place, to see what it changes and costs."""
        return {}

    def marks(self, parameters: Mapping[str, float]) -> Iterable[PlaneMark]:
        """What pictures of a run show besides the bodies, at the run's parameters."""
        return ()

    def notes(self, tree: "Tree") -> Iterable[str]:
        """Where the effect may be wrong in the mechanism of that tree, in sentences, for `Simulator.notes`."""
        return ()

    def bandwidth(self, tree: "Tree") -> float:
        """Up to which angular frequency, rad/s, the coordinates that the effect adds have all motions of what bends;
        inf: there is no limit. Of vibrations above, `Modes.notes` tells."""
        return math.inf

    def carry_over(self, engine: "EngineLoads") -> None:
        """Says what the effect is in other engines, see `EngineLoads`. Exports to them refuse a scene with an effect
        that does not override this, or leave it out by request."""


HOOKS = tuple(name for name in vars(Effect) if not name.startswith("_") and name not in ("name", "summary"))
_LIKE = 0.85  # of difflib's ratio: check_starts, claim and drive are near their hooks, and wing is near none


class _Foreign(Effect):
    """An object of another class, with the hooks that it has."""

    def __init__(self, effect: Any) -> None:
        self.__dict__["effect"] = effect

    def __getattribute__(self, name: str) -> Any:
        own = object.__getattribute__(self, "__dict__")
        if name in (*HOOKS, "name", "summary") and hasattr(own["effect"], name):
            return getattr(own["effect"], name)
        return super().__getattribute__(name)


def hooked(effect: Any) -> Effect:
    """The effect with all hooks, whatever its class."""
    return effect if isinstance(effect, Effect) else _Foreign(effect)


def overrides(effect: Any, hook: str) -> bool:
    """Whether the effect has a `hook` of its own."""
    kind = effect if isinstance(effect, type) else type(effect)
    if issubclass(kind, Effect):
        return getattr(kind, hook) is not getattr(Effect, hook)
    return hasattr(effect, hook)


def check_hooks(effect: Any) -> None:
    """Raises DesignError for what is named nearly as a hook and is no field, and for a hook that cannot be asked: a
    method in the place of a property, another value in the place of a method, or one that takes other arguments."""
    kind: Any = type(effect)
    problem = _problem_of_hooks(kind)
    if problem:
        raise DesignError(f"effect {effect.name!r}{problem}")


@lru_cache(maxsize=256)  # classes: scenes of thousands of effects have few
def _problem_of_hooks(kind: Any) -> str:
    """What is the matter with a class of effects, to follow the name of one; empty of one that is in order."""
    for name in dir(kind):
        if name.startswith("_"):
            continue
        own = inspect.getattr_static(kind, name)
        if name in HOOKS:
            problem = _hook_problem(name, own)
            if problem:
                return f": {name} {problem}"
        elif name not in getattr(kind, "__dataclass_fields__", {}):
            near = difflib.get_close_matches(name, HOOKS, n=1, cutoff=_LIKE)
            if near:
                return (
                    f" has {'a method' if callable(own) else 'an attribute'} {name!r}, which nothing asks for; did you "
                    f"mean {near[0]!r}? What is its own may begin with _"
                )
    return ""


def _hook_problem(name: str, own: object) -> str:
    """Why a hook cannot be asked as it is; empty where it can."""
    asked = vars(Effect)[name]
    if not callable(asked):  # a property or a value; fields may say it too
        return "must be a property: write @property above it" if inspect.isfunction(own) else ""
    if not inspect.isroutine(own) and not callable(own):
        return f"must be a method: define {_call(name)}"
    if inspect.isfunction(own):
        try:
            inspect.signature(own).bind(*inspect.signature(asked).parameters)
        except TypeError:
            return f"takes other arguments than it is asked with: define {_call(name)}"
    return ""


def _call(hook: str) -> str:
    return f"{hook}({', '.join(inspect.signature(vars(Effect)[hook]).parameters)})"


@contextmanager
def asked(effect: Any) -> Iterator[None]:
    """What the effect raises is about it, so that whoever read it from a file can tell its place; numbers that
    overflow, or a division by zero, are a DesignError."""
    with about(effect):
        try:
            yield
        except ArithmeticError as error:
            raise DesignError(
                f"effect {effect.name!r} cannot compute with its numbers ({type(error).__name__}: {error}); one of "
                "them is far too small or too large"
            ) from error


def marks_of(effects: Iterable[Effect], parameters: Mapping[str, float]) -> tuple[PlaneMark, ...]:
    """What the effects of a run have to show, at the run's parameters."""
    return tuple(mark for effect in effects for mark in hooked(effect).marks(parameters))


def notes_of(effects: Iterable[Effect], tree: "Tree") -> tuple[str, ...]:
    """What effects tell of themselves in the mechanism of that tree."""
    return tuple(note for effect in effects for note in hooked(effect).notes(tree))


def bandwidth_of(effects: Iterable[Effect], tree: "Tree") -> float:
    """The least bandwidth of effects, rad/s; inf where none has a limit."""
    return min((float(hooked(effect).bandwidth(tree)) for effect in effects), default=math.inf)


def conserves(effect: Effect, energies: Container[str]) -> bool:
    """Whether the energy of a run stays as it is under the effect; `energies`: names of those that are stored."""
    said = hooked(effect).conservative
    return effect.name in energies if said is None else bool(said)


def claims_of(effect: Effect) -> tuple[str, ...]:
    """What the effect claims, each thing once; nothing for one that does not say."""
    return tuple(dict.fromkeys(hooked(effect).claims()))
