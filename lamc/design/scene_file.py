"""The `scene:` section of lamc's files, both ways; the one place of the front end that asks for effects.

In: plain data. Out: a `Scene`, or a `Scene` as plain data. No effect is known here by name.
"""

from collections.abc import Iterator, Mapping
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np
from pydantic import ValidationError

from lamc.design.checking import Path, Problems, did_you_mean, shown
from lamc.design.schema import SceneModel
from lamc.effects.base import Effect
from lamc.effects.data import DataError, refusal
from lamc.effects.registry import by_name
from lamc.errors import DesignError
from lamc.scene import Scene


def read_scene(data: object) -> Scene:
    """The scene that plain data describes: {effects: …, angles: {joint: rad}, rates: {joint: rad/s}, branch: …,
    closure_tolerance: m}.

    Raises DesignError with the first problem.
    """
    try:
        model = SceneModel.model_validate(data)
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        raise DesignError(f"{shown(('scene', *first['loc']))}: {first['msg']}") from error
    effects = None
    if model.effects is not None:
        effects = tuple(make_effect(name, value, shown(path)) for path, name, value in _called(model.effects))
    return _scene(model, effects)


def scene_from_model(model: SceneModel | None, problems: Problems) -> Scene | None:
    """The scene of a validated file; every problem is added to `problems`."""
    if model is None:
        return None
    effects: list[Effect] = []
    called = problems.attempt(("scene", "effects"), lambda: list(_called(model.effects))) or []
    for path, name, value in called:
        effect = _attempt_effect(problems, path, name, value)
        if effect is not None:
            effects.append(effect)
    return problems.attempt(
        ("scene",),
        lambda: _scene(model, tuple(effects) if model.effects is not None else None),
    )


def _scene(model: SceneModel, effects: tuple[Effect, ...] | None) -> Scene:
    return Scene(effects, model.angles, model.rates, model.branch, model.closure_tolerance)


def make_effect(name: str, value: object, where: str) -> Effect:
    """The effect of that name in files; messages begin with `where`.

    Raises DesignError for a name the registry does not have, and for data that does not fit.
    """
    known = by_name()
    if name not in known:
        raise refusal(where, f"no effect is named {name[:40]!r}; {did_you_mean(name, sorted(known))}")
    try:
        return known[name].from_data(value, where)
    except DataError:
        raise
    except DesignError as error:
        raise type(error)(f"{where}: {_unplaced(error, where)}", error.place) from error


def _attempt_effect(problems: Problems, path: Path, name: str, value: object) -> Effect | None:
    """The effect, or None after noting what is wrong with it, at the part of it that is wrong."""
    where = shown(path)
    try:
        return make_effect(name, value, where)
    except DataError as error:
        problems.add((*path, *error.path), error.problem)
    except DesignError as error:
        problems.add(path, _unplaced(error, where), error.place)
    return None


def _unplaced(error: DesignError, where: str) -> str:
    """The message without the place that the effect's own reader may have put before it."""
    return error.message.removeprefix(f"{where}: ")


def scene_data(scene: Scene) -> dict[str, Any]:
    """The scene as plain data that `read_scene` gives back.

    Raises DesignError for an effect with values that a file cannot hold.
    """
    data: dict[str, Any] = {}
    if scene.effects is not None:
        data["effects"] = [{effect.name: _effect_data(effect)} for effect in scene.effects]
    for name, values in (("angles", scene.angles), ("rates", scene.rates)):
        if values:
            data[name] = dict(sorted(values.items()))
    if scene.branch is not None:
        data["branch"] = scene.branch
    if scene.closure_tolerance is not None:
        data["closure_tolerance"] = scene.closure_tolerance
    return data


def _called(effects: object) -> Iterator[tuple[Path, str, object]]:
    """(path, name, value) of each effect in a map, or in a list of names and one-entry maps."""
    if effects is None:
        return
    if isinstance(effects, Mapping):
        for name, value in effects.items():
            yield ("scene", "effects", str(name)), str(name), value
        return
    if not isinstance(effects, list):
        raise DesignError("effects are a map from name to value, or a list of names and one-entry maps")
    for index, item in enumerate(effects):
        path: Path = ("scene", "effects", index)
        if isinstance(item, str):
            yield path, item, None
        elif isinstance(item, Mapping) and len(item) == 1:
            ((name, value),) = item.items()
            yield (*path, str(name)), str(name), value
        else:
            raise DesignError(f"entry {index} of the effects is neither a name nor a map with one entry")


def _effect_data(effect: Effect) -> object:
    """An effect's record as plain data: nothing, its only field, or its fields by name."""
    assert is_dataclass(effect)
    values = {f.name: _plain(getattr(effect, f.name)) for f in fields(effect)}
    data = None if not values else next(iter(values.values())) if len(values) == 1 else values
    try:
        same = make_effect(effect.name, data, effect.name) == effect
    except DesignError:
        same = False
    if not same:
        raise DesignError(
            f"the effect {effect.name!r} has values that a file cannot hold, so it cannot be written"
        )
    return data


def _plain(value: object) -> object:
    if isinstance(value, Mapping):
        return {str(k): _plain(v) for k, v in value.items()}
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, tuple | list):
        return [_plain(v) for v in value]
    return value
