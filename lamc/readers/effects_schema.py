"""The JSON Schema of effects, as the models of their fields describe themselves.

In: the registry of effects. Out: definitions for `lamc schema`. No effect is known here by name.
"""

from collections.abc import Mapping
from typing import Any

from lamc.effects.data import is_map, model_of
from lamc.effects.registered import RegisteredEffect
from lamc.effects.registry import by_name

_EFFECTS = "Effects"


def with_effects(definitions: Mapping[str, Any]) -> dict[str, Any]:
    """Definitions of a JSON Schema, in which scenes refer to the effects there are, each with its fields."""
    given = dict(definitions)
    scenes = [name for name, each in given.items() if {"effects", "with"} <= set(each.get("properties", {}))]
    if not scenes:
        return given
    for name in scenes:
        properties = dict(given[name]["properties"])
        for key in ("effects", "with"):
            said = properties[key].get("description", "")
            properties[key] = {
                "description": said,
                "anyOf": [{"$ref": f"#/$defs/{_EFFECTS}"}, {"type": "null"}],
                "default": None,
            }
        given[name] = {**given[name], "properties": properties}
    known = by_name()
    one = {
        "type": "object",
        "properties": {name: {"$ref": f"#/$defs/effect_{name}"} for name in sorted(known)},
        "additionalProperties": False,
    }
    given[_EFFECTS] = {
        "anyOf": [
            one,
            {
                "type": "array",
                "items": {"anyOf": [{"type": "string", "enum": sorted(known)}, {**one, "maxProperties": 1}]},
            },
        ]
    }
    return given | {f"effect_{name}": effect_schema(kind) for name, kind in sorted(known.items())}


def effect_schema(kind: type[RegisteredEffect]) -> dict[str, Any]:
    """What a file may say under the effect's name, from its model. The field that `shorthand` names may stand alone."""
    data: type = kind
    whole = model_of(data).model_json_schema()
    properties = {name: _untitled(each) for name, each in whole.get("properties", {}).items()}
    needed = whole.get("required", [])
    nothing = [] if needed else ["null", "boolean"]
    said = {"type": ["object", *nothing], "properties": properties, "additionalProperties": False}
    said |= {"required": needed} if needed else {}
    text = " ".join(kind.said.split())
    short = kind.shorthand
    if short is None:
        return {"description": text, **said}
    if is_map(kind, short):  # its keys are names, which the field's own name would be one of
        return {**properties[short], "description": text}
    return {"description": text, "anyOf": [said, properties[short]]}


def _untitled(schema: dict[str, Any]) -> dict[str, Any]:
    return {key: value for key, value in schema.items() if key != "title"}
