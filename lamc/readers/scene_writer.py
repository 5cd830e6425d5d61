"""Scenes as plain data, to be written to a file.

In: `Scene` records. Out: dicts that `scene_file` reads back to equal records. No effect is known here by name.
"""

from collections.abc import Mapping
from dataclasses import MISSING, fields, is_dataclass
from typing import Any

import numpy as np

from lamc.basics.errors import DesignError
from lamc.effects.registered import RegisteredEffect
from lamc.readers.effect_calls import make_effect
from lamc.readers.scene_file import SINGLE
from lamc.readers.series_input import MOST_IN_SCENE
from lamc.records.effect import Effect
from lamc.records.inputs import Input
from lamc.records.scene import TURN, OutputPoint, Scene


def scenes_data(default: Scene | None, named: Mapping[str, Scene]) -> dict[str, Any]:
    """Sections `scene` and `scenes` that `read_scenes` gives back. Raises DesignError as `scene_data` does."""
    data: dict[str, Any] = {}
    if default is not None:
        same = next((name for name, scene in named.items() if scene == default), None)
        data["scene"] = scene_data(default) if same is None else {"like": same}
    if named:
        data["scenes"] = {name: scene_data(scene) for name, scene in named.items()}
    return data


def scene_data(scene: Scene) -> dict[str, Any]:
    """The scene as plain data.

    Raises DesignError for an effect with values that a file cannot hold.
    """
    data: dict[str, Any] = {}
    if scene.effects is not None:
        data["effects"] = [{effect.name: _effect_data(effect)} for effect in scene.effects]
    if scene.added:
        data["with"] = [{effect.name: _effect_data(effect)} for effect in scene.added]
    if scene.without:
        data["without"] = list(scene.without)
    if scene.angles:  # bare ones of more than a turn would be taken for degrees
        said = sorted(scene.angles.items())
        data["angles"] = {joint: f"{angle!r} rad" if abs(angle) > TURN else angle for joint, angle in said}
    if scene.rates:
        data["rates"] = dict(sorted(scene.rates.items()))
    if scene.inputs:
        data["inputs"] = {name: _input_data(name, each) for name, each in scene.inputs.items()}
    if scene.parameters:
        data["parameters"] = dict(scene.parameters)
    for name in SINGLE:
        value = getattr(scene, name)
        if value is not None:
            data[name] = [_output_data(each) for each in value] if isinstance(value, tuple) else value
    return data or {"angles": {}}  # a scene in a file says something


def _input_data(name: str, each: Input) -> object:
    """An input as plain data; a series row by row."""
    series = each.series
    if series is None:
        return {key: value for key, value in _fields(each).items() if key != "series"}
    if len(series.t) > MOST_IN_SCENE:
        raise DesignError(
            f"the series of the input {name!r} has {len(series.t)} rows, and a scene holds {MOST_IN_SCENE} at most; "
            "keep it in a CSV file, and name that in the scene"
        )
    said: dict[str, object] = {"unit": each.unit, "meaning": each.meaning, "hold": series.hold}
    said |= {"beyond": series.beyond, "t": series.t.tolist(), "values": series.values.tolist()}
    return {key: value for key, value in said.items() if value not in ("", "1", "refuse")}


def _output_data(output: str | OutputPoint) -> object:
    if isinstance(output, str):
        return output
    return {"name": output.name, "body": output.body, "point": list(output.point)}


def _effect_data(effect: Effect) -> object:
    """An effect's record as plain data: nothing, its fields by name, or the one that stands for all."""
    assert is_dataclass(effect)
    values = {f.name: _plain(getattr(effect, f.name)) for f in fields(effect)}
    short = effect.shorthand if isinstance(effect, RegisteredEffect) else None
    data = values.get(short, values or None) if len(values) == 1 else values or None
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
    if is_dataclass(value) and not isinstance(value, type):
        return _fields(value)
    return value


def _fields(record: Any) -> dict[str, object]:
    """The fields of a record that differ from their defaults."""
    said = {f.name: (getattr(record, f.name), f.default) for f in fields(record) if f.init}
    return {name: _plain(v) for name, (v, default) in said.items() if default is MISSING or v != default}
