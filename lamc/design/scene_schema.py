"""The schema of scenes: what a `scene:` or `scenes:` section and a file of scenes may say.

In: plain data. Out: validated models in SI, and the JSON Schema of effects as their classes describe themselves. What
effects hold is read by the effects (`scene_file`); none is known here by name.
"""

import typing
from collections.abc import Mapping, Sequence
from dataclasses import fields as fields_of
from types import NoneType
from typing import Annotated, Any, Literal

from pydantic import Field

from lamc.design.fields import AngleRate, AnyAngle, Duration, Gap, LengthUnit, Model
from lamc.effects.base import RegisteredEffect
from lamc.effects.data import takes_text
from lamc.effects.registry import by_name

_CALLED: dict[str, Any] = {"type": ["object", "array", "null"]}
_EFFECTS = "Effects"
_SAYS = "effects by name with their values, as a map, or as a list of names and one-entry maps"


class SceneModel(Model):
    """What acts, how the mechanism starts, how long it runs. Without `effects`: what the design itself asks for."""

    like: str | None = Field(
        None, description="another scene of the file, of which this one has all but what it says"
    )
    effects: Any = Field(None, description=f"exactly these act: {_SAYS}", json_schema_extra=_CALLED)
    with_: Any = Field(
        None,
        alias="with",
        description=f"these act besides, or in place of those of the same name: {_SAYS}",
        json_schema_extra=_CALLED,
    )
    without: Any = Field(
        None,
        description="names of effects that are left out",
        json_schema_extra={"type": ["array", "string", "null"], "items": {"type": "string"}},
    )
    angles: dict[str, AnyAngle] = Field({}, description="initial angles by joint")
    rates: dict[str, AngleRate] = Field({}, description="initial rates by joint")
    branch: int | None = Field(
        None, description="way out of a singular start: 1, 2, … as listed; negative for the other way"
    )
    closure_tolerance: Gap | None = Field(
        None, description="gap up to which loops that do not fit count as closed"
    )
    duration: Duration | None = Field(None, description="how long `lamc run` simulates it; 10 s if not said")
    outputs: list[str] | None = Field(
        None, description="what matters of the motion: joints, BODY.x, BODY.y, BODY.z; all joints if not said"
    )


ScenesModel = Annotated[
    dict[str, SceneModel], Field(description="scenes by name; `lamc run DESIGN --scene NAME` simulates one")
]


class SceneFileModel(Model):
    """Scenes in a file of their own, for `lamc run DESIGN --scene FILE:NAME`."""

    kind: Literal["scene"] = "scene"
    units: LengthUnit = Field("m", description="the unit of every length written without one, such as mm")
    scene: SceneModel | None = Field(None, description="the one that is meant where no name is given")
    scenes: ScenesModel = Field(default={})


class LoneSceneModel(SceneModel):
    """One scene that is a file."""

    kind: Literal["scene"] = "scene"
    units: LengthUnit = "m"


def with_effects(definitions: Mapping[str, Any]) -> dict[str, Any]:
    """Definitions of a JSON Schema, in which scenes refer to the effects there are, each with its fields."""
    given = dict(definitions)
    if "SceneModel" not in given:
        return given
    scene = dict(given["SceneModel"])
    properties = dict(scene["properties"])
    for key in ("effects", "with"):
        said = properties[key].get("description", "")
        properties[key] = {"description": said, "anyOf": [{"$ref": f"#/$defs/{_EFFECTS}"}, {"type": "null"}]}
    given["SceneModel"] = {**scene, "properties": properties}
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
    """What a file may say under the effect's name, from its dataclass: its fields, their kinds and units.

    The field that an effect's `shorthand` names may stand alone. An effect whose data is no record says it itself, as
    `data_schema`.
    """
    own: Mapping[str, Any] | None = getattr(kind, "data_schema", None)
    if own is not None:
        return {"description": " ".join((kind.__doc__ or kind.summary).split()), **own}
    units: Mapping[str, str] = getattr(kind, "units", {})
    hints = typing.get_type_hints(kind)
    entries = fields_of(kind)  # type: ignore[arg-type]
    said = {f.name: _field_schema(hints[f.name], units.get(f.name)) for f in entries}
    text = " ".join((kind.__doc__ or kind.summary).split())
    whole = {"type": ["object", "null", "boolean"], "properties": said, "additionalProperties": False}
    short: str | None = getattr(kind, "shorthand", None)
    if short is None:
        return {"description": text, **whole}
    if said[short]["type"] == "object":  # its keys are names, which the field's own name would be one of
        return {"description": text, **said[short], "type": ["object", "null"]}
    return {"description": text, "anyOf": [whole, said[short]]}


def _field_schema(hint: Any, unit: str | None) -> dict[str, Any]:
    """The schema of a field of this annotation; with a unit, numbers may be text that has its unit."""
    origin, inner = typing.get_origin(hint), typing.get_args(hint)
    note = _note(unit, expressions=takes_text(hint))
    if hint is float:
        return {"type": "number"} if unit is None else {"type": ["number", "string"], **note}
    plain = {bool: "boolean", int: "integer", str: "string", NoneType: "null"}
    if hint in plain:
        return {"type": plain[hint], **(note if hint is str else {})}
    if isinstance(origin, type) and issubclass(origin, Mapping):
        return {"type": "object", "additionalProperties": _field_schema(inner[1], unit)}
    if isinstance(origin, type) and issubclass(origin, Sequence):
        parts = [part for part in inner if part is not Ellipsis]
        length = (
            {}
            if Ellipsis in inner or origin is not tuple
            else {"minItems": len(parts), "maxItems": len(parts)}
        )
        return {"type": "array", "items": _field_schema(parts[0], unit) if parts else {}, **length}
    if inner:  # a union
        known = [_field_schema(part, unit) for part in inner]
        return {"anyOf": [part for k, part in enumerate(known) if part not in known[:k]]}
    return {}


def _note(unit: str | None, *, expressions: bool) -> dict[str, str]:
    if unit is None:
        return {}
    said = f"a number ({unit or 'plain'}), or text with a unit" if unit else "a plain number"
    return {"description": said + (", or an expression" if expressions else "")}
