"""The `Scene`: which effects act, how the mechanism starts, how long it runs and what of it matters.

In: effects, and plain values. Out: checked records. Nothing here knows any effect by name, or any mechanism.
"""

import math
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, fields, replace
from numbers import Integral
from typing import Protocol

from lamc.basics.checks import checked_array, checked_kind, checked_name, checked_number, shown
from lamc.basics.errors import DesignError, Place, warn
from lamc.basics.given import GivenByName, GivenMaybe
from lamc.basics.places import Places
from lamc.basics.readonly import ReadOnlyDict
from lamc.basics.units import ANGLE, ANGLE_RATE, DURATION, LENGTH, Quantity
from lamc.records.effect import Effect, check_hooks, overrides
from lamc.records.inputs import (
    Input,
    check_inputs,
    check_read,
    check_smooth,
    checked_inputs,
    inputs_of,
    is_of_effect,
)

TURN = 2.0 * math.pi  # rad
_NEEDED = ("name", "summary", "contribute")  # what `lamc.records.effect.Effect` asks for


def _start(
    values: Mapping[str, float | str], argument: str, what: str, quantity: Quantity
) -> Mapping[str, float]:
    """By joint, in SI. What another scene has checked is a ReadOnlyDict; its numbers had units or none, who knows."""
    if not isinstance(values, Mapping):
        raise DesignError(
            f"{argument} of a scene is {shown(values)}; it must map joint names to numbers, as in {{'h1': 0.1}}"
        )
    found = {}
    for joint, value in values.items():
        name = f"the {what} of joint {joint!r}"
        found[str(joint)] = checked_number(value, name, quantity=quantity)
        if quantity is ANGLE and not isinstance(values, ReadOnlyDict) and is_bare(value):
            warn_of_degrees(found[str(joint)], name)
    return ReadOnlyDict(found)


def is_bare(value: object) -> bool:
    """Whether a number comes without a unit; an expression has the units of its names."""
    if not isinstance(value, str):
        return True
    return value.strip()[-1:] in set("0123456789.") and not set(value) & set("*/^(")


def warn_of_degrees(angle: float, what: str, place: Place | None = None) -> None:
    """Warns of an angle, rad, that came without a unit and is more than a turn."""
    if abs(angle) > TURN:
        warn(
            f"{what} is {angle:g} rad, {abs(angle) / TURN:.3g} turns; angles without a unit are radians: write "
            f"'{angle:g} deg' for degrees, '{angle:g} rad' if radians are meant",
            place,
        )


def _parameters(values: object) -> Mapping[str, float | str]:
    """Numbers, and texts with units, by name; which parameters there are is known when a model is made."""
    if not isinstance(values, Mapping):
        raise DesignError(
            f"parameters of a scene is {shown(values)}; it must map names to numbers, as in {{'h1.stiffness': 2e-3}}"
        )
    found: dict[str, float | str] = {}
    for name, value in values.items():
        checked_name(name, "a parameter of a scene")
        is_text = isinstance(value, str)
        found[name] = value if is_text else checked_number(value, f"the parameter {name!r} of a scene")
    return ReadOnlyDict(found)


def _effects(values: Iterable[Effect], argument: str) -> tuple[Effect, ...]:
    if isinstance(values, type) or hasattr(values, "contribute"):
        name = values.__name__ if isinstance(values, type) else type(values).__name__
        raise DesignError(f"{argument} of a scene is {shown(values)}, no tuple; write {argument}=({name}(),)")
    if isinstance(values, str | bytes | Mapping) or not isinstance(values, Iterable):
        rule = "None or a tuple" if argument == "effects" else "a tuple"
        raise DesignError(f"{argument} of a scene is {shown(values)}; it must be {rule} of effects")
    effects = tuple(values)
    for effect in effects:
        if isinstance(effect, type):
            raise DesignError(
                f"{argument} of a scene holds the class {effect.__name__}; make one: {effect.__name__}()"
            )
        missing = [each for each in _NEEDED if not hasattr(effect, each)]
        if not missing and not overrides(effect, "contribute"):
            missing = ["contribute"]
        if missing:
            raise DesignError(
                f"{argument} of a scene holds {shown(effect)}, which is no effect (it has no {missing[0]!r}); "
                "make an instance of one, such as those in lamc.effects"
            )
        check_hooks(effect)
    kinds = [type(e) for e in effects]
    for kind in kinds:
        if kinds.count(kind) > 1 and not getattr(kind, "repeatable", False):
            raise DesignError(f"the scene calls for {kind.__name__} twice; once is all it can act")
    return effects


def _names(values: Iterable[str], argument: str, example: str) -> tuple[str, ...]:
    if isinstance(values, str | bytes | Mapping) or not isinstance(values, Iterable):
        raise DesignError(
            f"{argument} of a scene is {shown(values)}; it must be a tuple of names, such as ({example!r},)"
        )
    names = tuple(checked_name(name, f"an entry of {argument}") for name in values)
    for name in names:
        if names.count(name) > 1:
            raise DesignError(f"{argument} of a scene has {name!r} twice; once is enough")
    return names


@dataclass(frozen=True)
class OutputPoint:
    """A point of a body that matters, such as a tip.

    name   of the point; as outputs it is NAME.x, NAME.y and NAME.z, m, world
    body   that it belongs to and moves with; a rigid one
    point  (3,), m: where it is in the drawn configuration, world axes

    Raises DesignError for what are no names and for a point that is not three finite numbers.
    """

    name: str
    body: str
    point: tuple[float, float, float]  # m

    def __post_init__(self) -> None:
        checked_name(self.name, "an output point")
        checked_name(self.body, f"the body of the output point {self.name!r}")
        what = f"the output point {self.name!r}"
        x, y, z = (float(v) for v in checked_array(self.point, (3,), what, LENGTH))
        object.__setattr__(self, "point", (x, y, z))


def _outputs(values: "Iterable[str | OutputPoint]") -> "tuple[str | OutputPoint, ...]":
    if isinstance(values, OutputPoint):
        raise DesignError("outputs of a scene is an OutputPoint, no tuple; write outputs=(…,)")
    if isinstance(values, str | bytes | Mapping) or not isinstance(values, Iterable):
        return _names(values, "outputs", "h1")
    entries = tuple(values)
    _names([each.name if isinstance(each, OutputPoint) else each for each in entries], "outputs", "h1")
    if not entries:
        raise DesignError("outputs of a scene is empty; name one at least, or leave it out")
    return entries


@dataclass(frozen=True)
class Scene:
    """What a run calls for.

    effects  None: what the design itself asks for; a tuple: exactly these, and an empty one means none
    added    effects besides; one takes the place of an effect of the same name, unless several may act (springs)
    without  names of effects that are left out, as in ("gravity",)
    angles   initial joint angles by joint name, rad; joints left out start at zero (the drawn angle)
    rates    initial joint rates by joint name, rad/s; joints left out start at zero
             with loops, what is left out follows from closure, as near to zero as that allows
    branch   which way out of a singular start, such as a flat one: 1 is the first of `Simulator.branches`; -1 the same
             the other way; None: rates say it, or at rest the loads, by the work that they do on each
    closure_tolerance  m, the gap up to which loops that do not fit count as closed; None: 1e-4 of the size,
                       or 15 µm, as drawings have three decimals of a millimetre
    duration  s, how long `lamc run` simulates the scene, if not told; None: 10 s
    parameters  of the model, values by name in place of the design's, as `Simulator.parameters` names them and
             "h1.stiffness" or "link_1.mass": what a fit found; SI, or text with a unit
    inputs   numbers from outside by name, which expressions of the effects may hold: constant within a run, and
             parameters of the simulator, or following a series; a series may also have the name of an input that an
             effect brings, such as "knee.torque" of external_torque
    outputs  what of the motion matters: names of joints (angles), of coordinates that effects add, such as "base.qw",
             and "BODY.x", ".y" and ".z" (centre of mass); or an `OutputPoint`, any point of a body; None: all joints
    places   where its parts stand in its file; empty for a scene made by hand

    Numbers are SI; text has its unit, as in angles={"fold": "30 deg"}. A bare angle of more than a turn warns.

    Raises DesignError for what are no effects, no numbers, or an effect twice; for an input that no effect reads, and
    ExpressionError for a name in an expression that is no input.
    """

    effects: tuple[Effect, ...] | None = None
    angles: GivenByName = field(default_factory=dict)  # type: ignore[assignment]  # rad
    rates: GivenByName = field(default_factory=dict)  # type: ignore[assignment]  # rad/s
    branch: int | None = None
    closure_tolerance: GivenMaybe = None  # type: ignore[assignment]  # m
    added: tuple[Effect, ...] = ()
    without: tuple[str, ...] = ()
    duration: GivenMaybe = None  # type: ignore[assignment]  # s
    outputs: tuple[str | OutputPoint, ...] | None = None
    inputs: Mapping[str, Input] = field(default_factory=dict)
    parameters: Mapping[str, float | str] = field(default_factory=dict)
    places: Places = field(default=Places(), compare=False, repr=False)

    def __post_init__(self) -> None:
        if self.effects is not None:
            object.__setattr__(self, "effects", _effects(self.effects, "effects"))
        object.__setattr__(self, "added", _effects(self.added, "added"))
        object.__setattr__(self, "without", _names(self.without, "without", "gravity"))
        for effect in self.added:
            if effect.name in self.without:
                raise DesignError(f"the scene adds {effect.name!r} and leaves it out; say one of them")
        object.__setattr__(self, "inputs", checked_inputs(self.inputs))
        object.__setattr__(self, "parameters", _parameters(self.parameters))
        effects = (*(self.effects or ()), *self.added)
        for effect in effects:
            check_inputs(effect, self.inputs)
            check_smooth(effect, self.inputs)
        check_read(self.inputs, effects)
        object.__setattr__(self, "angles", _start(self.angles, "angles", "initial angle", ANGLE))
        object.__setattr__(self, "rates", _start(self.rates, "rates", "initial rate", ANGLE_RATE))
        if self.duration is not None:
            duration = checked_number(self.duration, "duration of a scene", minimum=0.0, quantity=DURATION)
            if duration == 0.0:
                raise DesignError("duration of a scene is 0; give seconds above zero, or None")
            object.__setattr__(self, "duration", duration)
        if self.outputs is not None:
            object.__setattr__(self, "outputs", _outputs(self.outputs))
        if self.branch is not None:
            whole = isinstance(self.branch, Integral) and not isinstance(self.branch, bool)
            if not whole or self.branch == 0:
                raise DesignError(
                    f"branch of a scene is {shown(self.branch)}; it must be 1, 2, … as the branches are listed, "
                    "or -1, -2, … for the other way"
                )
            object.__setattr__(self, "branch", int(self.branch))
        if self.closure_tolerance is not None:
            tolerance = checked_number(
                self.closure_tolerance, "closure_tolerance of a scene", minimum=0.0, quantity=LENGTH
            )
            object.__setattr__(self, "closure_tolerance", tolerance)

    def __repr__(self) -> str:
        """What it says beyond the defaults, effects by name."""
        told = []
        for each in fields(self):
            value = getattr(self, each.name)
            if each.repr and value not in (None, (), {}):
                shown_value = [e.name for e in value] if each.name in ("effects", "added") else value
                told.append(f"{each.name}={shown_value!r}")
        return f"Scene({', '.join(told)})"

    def acting(self, effects: Iterable[Effect]) -> "Scene":
        """The same in which exactly these effects act, with the inputs that they read."""
        acting = tuple(effects)
        read = {name for effect in acting for name in inputs_of(effect)}
        inputs = {name: each for name, each in self.inputs.items() if name in read or is_of_effect(name)}
        return replace(self, effects=acting, added=(), without=(), inputs=inputs)


_SCENE_NAME = re.compile(r"[^\W\d][\w-]*\Z")


def is_scene_name(text: str) -> bool:
    """True for a letter or _, and then letters, digits, _ and -: no such name is taken for a file's."""
    return _SCENE_NAME.match(text) is not None


def checked_scenes(scenes: Mapping[str, Scene], what: str) -> Mapping[str, Scene]:
    """Scenes by name as a mapping that cannot change. Raises DesignError for what are none."""
    if not isinstance(scenes, Mapping):
        raise DesignError(f"scenes of {what} is {shown(scenes)}; it must map names to Scenes")
    for name, scene in scenes.items():
        checked_name(name, f"a scene of {what}")
        if not is_scene_name(name):
            raise DesignError(
                f"a scene of {what} is named {name!r}; a name is of letters, digits, _ and -, and begins with a letter"
            )
        checked_kind(scene, Scene, f"the scene {name!r} of {what}", "make one with lamc.Scene(…)")
    return ReadOnlyDict(scenes)


class HasScenes(Protocol):
    """A Design or a Mechanism, as far as its scenes go."""

    @property
    def scene(self) -> Scene | None: ...

    @property
    def scenes(self) -> Mapping[str, Scene]: ...


def own_scene(made: HasScenes, scene: Scene) -> str | None:
    """Which of its own scenes a scene is, by name; "": the one without a name, None: none of them. One that says the
    same at the same place of the same file is the same; one that was made by hand is only itself."""

    def is_same(own: Scene | None) -> bool:
        if own is scene or own is None or not scene.places.known:
            return own is scene
        return own.places.known == scene.places.known and own == scene

    if is_same(made.scene):
        return ""
    return next((name for name, own in made.scenes.items() if is_same(own)), None)
