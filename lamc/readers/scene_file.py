"""Scenes in lamc's files.

In: validated models of a `scene:` and a `scenes:` section. Out: `Scene` records. A scene that is `like` another has all
of it but what it says itself. No effect is known here by name.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

from lamc.basics.errors import DesignError, DesignErrors, Place
from lamc.basics.places import Places
from lamc.basics.readonly import ReadOnlyDict
from lamc.effects.data import DataError, file_context
from lamc.effects.registry import by_name
from lamc.readers.checking import Path, Problems, did_you_mean, shown
from lamc.readers.effect_calls import Called, effects_called, make_effect
from lamc.readers.numbers import Numbers
from lamc.readers.scene_inputs import read_inputs
from lamc.readers.scene_schema import OutputPointModel, SceneModel
from lamc.records.effect import Effect
from lamc.records.scene import OutputPoint, Scene, is_bare, is_scene_name, warn_of_degrees

MOST_SCENES = 1000  # in one file
MOST_VALUES = 100_000  # that its scenes come to, with all that they are like

SINGLE = ("branch", "closure_tolerance", "duration", "outputs")


class Scenes(NamedTuple):
    """The scenes of a file: the one that is meant where no name is given, and those with names."""

    default: Scene | None
    named: Mapping[str, Scene]


@dataclass(frozen=True)
class _Said:
    """All that a scene says, with what it is like, and where in the file it says so."""

    path: Path
    effects: tuple[Called, ...] | None = None
    added: tuple[Called, ...] = ()
    without: Mapping[str, Path] = field(default_factory=dict)
    angles: Mapping[str, tuple[float, Path]] = field(default_factory=dict)
    rates: Mapping[str, tuple[float, Path]] = field(default_factory=dict)
    inputs: Mapping[str, tuple[object, Path]] = field(default_factory=dict)
    parameters: Mapping[str, tuple[float | str, Path]] = field(default_factory=dict)
    single: Mapping[str, tuple[Any, Path]] = field(default_factory=dict)


def read_scenes(
    scene: SceneModel | None,
    scenes: Mapping[str, SceneModel],
    problems: Problems,
    length_unit: str | None = None,
    at: Path = ("scene",),
    numbers: Numbers | None = None,
    kept: dict[Path, Effect] | None = None,
) -> Scenes:
    """The scenes of a validated file; every problem is added to `problems`, and what has one is left out.

    length_unit  of bare lengths; at  where `scene` stands in the file
    numbers      reads expressions in parameters of the design; None: there are none
    kept         effects that follow from no parameter, by their paths; those that are not there yet are added
    """
    return _Reader(scene, scenes, problems, length_unit, at, numbers, {} if kept is None else kept).scenes()


class _Reader:
    """The scenes of one file on their way to records; every step adds to `problems` and goes on."""

    def __init__(
        self,
        scene: SceneModel | None,
        scenes: Mapping[str, SceneModel],
        problems: Problems,
        length_unit: str | None,
        at: Path,
        numbers: Numbers | None,
        kept: dict[Path, Effect],
    ) -> None:
        self.scene = scene
        self.models = scenes
        self.problems = problems
        self.length_unit = length_unit
        self.at = at
        self.numbers = numbers
        self.kept = kept
        self.said: dict[str, _Said | None] = {}
        self.effects: dict[Path, Effect | None] = {}  # each is made once, however many scenes have it
        self.places: dict[
            Path, Mapping[str, Place]
        ] = {}  # of the values of a map; each map is looked at once
        self.values = 0

    def scenes(self) -> Scenes:
        if len(self.models) > MOST_SCENES:
            self.problems.add(
                ("scenes",),
                f"the file has {len(self.models)} scenes; at most {MOST_SCENES} are read: split it",
            )
            return Scenes(None, {})
        for name in self.models:
            if not is_scene_name(name):
                text = f"{name[:40]!r} is no name of a scene; use letters, digits, _ and -, beginning with a letter"
                self.problems.add(("scenes", name), text)
        named: dict[str, Scene] = {}
        for name in self.models:
            said = self._resolved(name)
            if said is not None and self._is_too_much(said):
                return Scenes(None, {})
            made = self._scene(said) if said is not None else None
            if made is not None:
                named[name] = made
        default = None
        if self.scene is not None:
            base = self._base(self.scene, self.at) if self.scene.like is not None else _Said(self.at)
            said = self._merged(base, self.scene, self.at) if base is not None else None
            default = self._scene(said) if said is not None else None
        return Scenes(default, named)

    def _is_too_much(self, said: _Said) -> bool:
        """True after noting that the scenes hold more than a file should make of them."""
        self.values += (
            len(said.angles) + len(said.rates) + len(said.without) + len(said.added) + len(said.inputs)
        )
        self.values += len(said.parameters)
        self.values += len(said.effects or ()) + len(said.single.get("outputs", ((), ()))[0])
        if self.values > MOST_VALUES:
            text = (
                f"with all that they are like, the scenes hold more than {MOST_VALUES} values; split the file"
            )
            self.problems.add(("scenes",), text)
        return self.values > MOST_VALUES

    def _place(self, path: Path) -> Place:
        """The place of a value of a map."""
        around, key = path[:-1], path[-1]
        if around not in self.places:
            self.places[around] = self.problems.places(around)
        return self.places[around].get(str(key)) or self.problems.place(path)

    def _base(self, model: SceneModel, path: Path) -> _Said | None:
        """What the scene at `path` is like; None after noting that it is not there."""
        assert model.like is not None
        if model.like not in self.models:
            text = f"no scene of this file is named {model.like[:40]!r}; {did_you_mean(model.like, list(self.models))}"
            self.problems.add((*path, "like"), text)
            return None
        return self._resolved(model.like)

    def _resolved(self, name: str) -> _Said | None:
        """The named scene with all that it is like; None after noting a problem. Chains may be long: no recursion."""
        chain: list[str] = []
        step: str | None = name
        while step is not None and step not in self.said and step in self.models and step not in chain:
            chain.append(step)
            step = self.models[step].like
        if step in chain:
            ring = [*chain[chain.index(step) :], step]
            reported = ", which is like ".join(repr(each) for each in ring[:6])
            self.problems.add(("scenes", chain[-1], "like"), f"{reported}: a scene cannot be like itself")
            self.said.update(dict.fromkeys(chain))
        for each in reversed(chain):
            if each in self.said:
                continue
            model, path = self.models[each], ("scenes", each)
            base = self._base(model, path) if model.like is not None else _Said(path)
            self.said[each] = self._merged(base, model, path) if base is not None else None
        return self.said[name]

    def _merged(self, base: _Said, model: SceneModel, path: Path) -> _Said | None:
        """`base` with what `model` says in its place."""
        if not model.model_fields_set - {"kind", "units"}:
            self.problems.add(path, "the scene says nothing; give effects, angles, duration, … or remove it")
            return None
        said = replace(base, path=path)
        if model.effects is not None:
            effects = self._called(model.effects, (*path, "effects"))
            said = replace(said, effects=tuple(effects), added=(), without={})
        added = self._called(model.with_, (*path, "with"))
        without = self._names(model.without, (*path, "without"))
        for entry in added:
            if entry.name in without:
                self.problems.add(
                    entry.path, f"the scene adds {entry.name!r} and is to be without it; say one of them"
                )
        return replace(
            said,
            added=(
                *(
                    e
                    for e in said.added
                    if e.name not in without and not any(e.name == n.name for n in added)
                ),
                *added,
            ),
            without={n: p for n, p in said.without.items() if not any(n == e.name for e in added)} | without,
            angles={**said.angles, **{n: (v, (*path, "angles", n)) for n, v in model.angles.items()}},
            rates={**said.rates, **{n: (v, (*path, "rates", n)) for n, v in model.rates.items()}},
            inputs={**said.inputs, **{n: (v, (*path, "inputs", n)) for n, v in model.inputs.items()}},
            parameters={
                **said.parameters,
                **{n: (v, (*path, "parameters", n)) for n, v in model.parameters.items()},
            },
            single={
                **said.single,
                **{n: (getattr(model, n), (*path, n)) for n in SINGLE if getattr(model, n) is not None},
            },
        )

    def _scene(self, said: _Said) -> Scene | None:
        """The record; None after noting what is wrong with it."""
        problems = self.problems
        effects = None if said.effects is None else [(self._effect(each), each) for each in said.effects]
        added = [(self._effect(each), each) for each in said.added]
        called = [(effect, call.path) for effect, call in [*(effects or ()), *added]]
        inputs = read_inputs(said.inputs, said.path, called, problems, self.numbers)
        if inputs is None:
            return None
        made = [
            (e, problems.place(path), {**problems.words(path), **problems.places(path)})
            for e, path in called
            if e is not None
        ]
        places: list[tuple[Path, Path]] = [((), said.path)]
        places += [(("angles", name), path) for name, (_, path) in said.angles.items()]
        places += [(("rates", name), path) for name, (_, path) in said.rates.items()]
        places += [(("inputs", name), path) for name, (_, path) in said.inputs.items()]
        places += [(("parameters", name), path) for name, (_, path) in said.parameters.items()]
        places += [(("without", name), path) for name, path in said.without.items()]
        places += [((name,), path) for name, (_, path) in said.single.items()]
        outputs, path = said.single.get("outputs", ((), ()))
        names = [each if isinstance(each, str) else each.name for each in outputs]
        places += [(("outputs", name), (*path, index)) for index, name in enumerate(names)]
        known = tuple((key, self._place(path) if path else problems.place(path)) for key, path in places)
        single = {name: value for name, (value, _) in said.single.items() if name != "outputs"}
        self._check_angles(said)
        return problems.attempt(
            said.path,
            lambda: Scene(
                effects=None if effects is None else tuple(e for e, _ in effects if e is not None),
                added=tuple(e for e, _ in added if e is not None),
                without=tuple(said.without),
                angles=ReadOnlyDict({name: value for name, (value, _) in said.angles.items()}),
                rates={name: value for name, (value, _) in said.rates.items()},
                outputs=tuple(map(_output, outputs)) if "outputs" in said.single else None,
                inputs=inputs,
                parameters={name: value for name, (value, _) in said.parameters.items()},
                places=Places(known, tuple(made)),
                **single,
            ),
        )

    def _check_angles(self, said: _Said) -> None:
        """Warns of angles that are more than a turn, and written without a unit."""
        maps = {path[:-1] for _, path in said.angles.values()}
        texts = {each: self.problems.texts(each) for each in maps}
        for name, (value, path) in said.angles.items():
            if is_bare(texts[path[:-1]].get(str(path[-1]), "")):
                warn_of_degrees(value, f"the initial angle of joint {name!r}", self._place(path))

    def _effect(self, called: Called) -> Effect | None:
        """The effect, or None after noting what is wrong with it, at the part of it that is wrong."""
        path, name, value = called
        if path in self.kept:
            return self.kept[path]
        if path not in self.effects:
            self.effects[path] = None
            read = self.numbers.read if self.numbers is not None else 0
            context = file_context(self.length_unit, self.problems.folder, self.numbers)
            try:
                made = self.effects[path] = make_effect(name, value, shown(path), context)
                if self.numbers is not None and self.numbers.read == read:
                    self.kept[path] = made
            except DesignErrors as errors:
                for each in errors.problems:
                    self._note(path, each)
            except DesignError as error:
                self._note(path, error)
        return self.effects[path]

    def _note(self, path: Path, error: DesignError) -> None:
        assert isinstance(error, DataError)
        self.problems.add((*path, *error.path), error.problem, error.place)

    def _called(self, effects: object, path: Path) -> list[Called]:
        return self.problems.attempt(path, lambda: list(effects_called(effects, path))) or []

    def _names(self, without: object, path: Path) -> dict[str, Path]:
        """Names of effects that are left out, each with its place."""
        names = [without] if isinstance(without, str) else without or []
        if not isinstance(names, list) or not all(isinstance(name, str) for name in names):
            self.problems.add(path, "without takes names of effects, such as [gravity, hinge_damping]")
            return {}
        found: dict[str, Path] = {}
        for index, name in enumerate(names):
            at = (*path, index) if without is names else path
            if name not in by_name():
                self.problems.add(
                    at, f"no effect is named {name[:40]!r}; {did_you_mean(name, sorted(by_name()))}"
                )
            else:
                found[name] = at
        return found


def _output(entry: str | OutputPointModel) -> str | OutputPoint:
    return entry if isinstance(entry, str) else OutputPoint(entry.name, entry.body, entry.point)
