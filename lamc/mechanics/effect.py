"""What an effect is. The rest of the compiler knows effects through this page only.

An effect is a small immutable record. `contribute` adds its symbolic loads, stored energy and parameters to a
`Loads` collector; what it does not add leaves no trace in the equations or in the C.
"""

from collections.abc import Container, Iterable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar, Protocol, runtime_checkable

if TYPE_CHECKING:
    from lamc.mechanics.loads import Loads
    from lamc.mechanism.tree import Tree
    from lamc.records.mechanism import Mechanism


@runtime_checkable
class Effect(Protocol):
    """One physical effect. Implementations are frozen dataclasses; a user's own need no more than this.

    name     lower-case identifier, the effect's name in scene files, tables and energies
    summary  one line for people; with `source`, an attribute that may be left out, it heads the effect's C

    A force of one's own, in sympy, on the tip of one body:

        @dataclass(frozen=True)
        class TipDrag:
            name: ClassVar[str] = "tip_drag"
            summary: ClassVar[str] = "Drag on the tip"

            def contribute(self, loads):
                u = sympy.Symbol("u_h1")
                loads.hinge_torque("h1", -0.01 * u * sympy.Abs(u))

    What scene files can name besides is a `RegisteredEffect`. Its `units` give the SI unit of each field that has one,
    and `lamc.effects.data.record` reads the fields from a file then: numbers are SI, text has its unit ("3 N*mm/deg");
    `shorthand` names the field that may stand alone, as in `gravity: [0, 0, -9.81]`; `data_schema` is the JSON Schema
    of data that is no such record; `lamc.effects.data.quantity(value, "N*m/rad", where, "stiffness")` reads one number.

    An effect that cannot act from every start has check_start(mechanism, angles) as well: angles are those of all
    joints by name, rad, at the start; it raises DesignError for one that it refuses. One that minds where the bodies
    are has check_poses(mechanism, poses, parameters), asked before each run: poses are centre of mass, m, and rotation
    from drawn axes, world, by the name of each body that moves; parameters are the run's, by name.

    An effect that acts by expressions in time has drives() as well: see `lamc/effects/drives.py`. They are evaluated
    where the run begins and along it, and refused where they have no value.

    Expressions may hold inputs of the scene: `loads.inputs` has them by name, and sympy expressions may hold symbols of
    their names. An effect that reads some otherwise than in its drives tells their names by inputs().

    An effect that must be the only one of its sort says so by claims(): short texts such as "motion of the base" or
    "stiffness of hinge 'h1'". Two effects of a scene with a claim in common are refused. One that gives way instead
    asks `loads.claims` who holds a claim, and leaves that out: HingeStiffness does, hinge by hinge.

    An effect is taken to keep the energy of a run if it stores some. One for which this is not so says it by
    `conservative`, true or false: a spring with a damper, a bender under a voltage that changes.

    An effect that comes in cheaper or finer forms, such as with fewer modes of a plate, tells them by alternatives():
    effects of its kind by a few words each. `lamc ledger` puts each in its place, to see what it changes and costs.

    An effect with something to show has marks(parameters): what pictures of a run show besides the bodies, given the
    run's parameters by name; so far planes, as `PlaneMark`s.

    An effect that knows where it may be wrong in a mechanism says so by notes(tree): sentences, for `Simulator.notes`.

    An effect that other engines can have says what it is there by carry_over(engine): see `EngineLoads` in
    `lamc/effects/engine_loads.py`. Exports to them refuse a scene with one that does not, or leave it out by request.

    An effect that adds coordinates or moves the fixed bodies has arrange(arranging), asked before `contribute`: see
    `Arranging` in `lamc/mechanics/arrangement.py`. Its method inverse_dynamics() is for those that add fluid's mass.
    """

    name: ClassVar[str]
    summary: ClassVar[str]

    def contribute(self, loads: "Loads") -> None:
        """Adds the effect's loads. Raises DesignError if it names bodies or joints that are not there."""


@dataclass(frozen=True)
class PlaneMark:
    """A plane to draw, such as the ground: a point of it, m, and its unit normal, world axes, towards what it faces."""

    point: tuple[float, float, float]  # m
    normal: tuple[float, float, float]


class RegisteredEffect(Effect, Protocol):
    """An effect of lamc's own, which scene files can name and designs can ask for."""

    @classmethod
    def default_for(cls, mechanism: "Mechanism") -> tuple[Effect | None, str]:
        """The effect as the mechanism itself asks for it (None: not at all), and why, in a few words."""

    @classmethod
    def from_data(cls, value: object, where: str) -> Effect:
        """The effect from a scene file's plain data; `where` names the place for errors.

        Most return `data.record(cls, value, where)`. Raises DesignError, at best a `data.DataError` with the part at
        fault, if the data does not fit.
        """


def marks_of(effects: Iterable[Effect], parameters: Mapping[str, float]) -> tuple[PlaneMark, ...]:
    """What the effects of a run have to show, at the run's parameters."""
    shown = (getattr(effect, "marks", None) for effect in effects)
    return tuple(mark for marks in shown if marks is not None for mark in marks(parameters))


def notes_of(effects: Iterable[Effect], tree: "Tree") -> tuple[str, ...]:
    """What effects tell of themselves in the mechanism of that tree."""
    told = (getattr(effect, "notes", None) for effect in effects)
    return tuple(note for notes in told if notes is not None for note in notes(tree))


def alternatives_of(effect: Effect) -> Mapping[str, Effect]:
    """Other forms of the effect by a few words each; none for one that does not say."""
    alternatives = getattr(effect, "alternatives", None)
    return dict(alternatives()) if alternatives is not None else {}


def conserves(effect: Effect, energies: Container[str]) -> bool:
    """Whether the energy of a run stays as it is under the effect; `energies`: names of those that are stored."""
    return bool(getattr(effect, "conservative", effect.name in energies))


def claims_of(effect: Effect) -> tuple[str, ...]:
    """What the effect claims, each thing once; nothing for one that does not say."""
    claims = getattr(effect, "claims", None)
    return tuple(dict.fromkeys(claims())) if claims is not None else ()
