"""The JSON Schema of effects, as their classes describe themselves: fields, kinds, units, docstrings.

In: the registry of effects. Out: definitions for `lamc schema`. No effect is known here by name.
"""

import inspect
import re
import typing
from collections.abc import Mapping, Sequence
from dataclasses import MISSING
from dataclasses import fields as fields_of
from types import NoneType
from typing import Any, Literal

from lamc.effects.data import takes_text
from lamc.effects.registered import RegisteredEffect
from lamc.effects.registry import by_name

_EFFECTS = "Effects"
_ENTRY = re.compile(r"(\w+(?:, \w+)*)  +(\S.*)")  # of the fields in a docstring: names, two blanks, text


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
    """What a file may say under the effect's name, from its dataclass: its fields, their kinds and units.

    The field that an effect's `shorthand` names may stand alone. An effect whose data is no record says it itself, as
    `data_schema`.
    """
    own = kind.data_schema
    if own is not None:
        return {"description": " ".join((kind.__doc__ or kind.summary).split()), **own}
    units = kind.units
    hints = typing.get_type_hints(kind)
    entries = fields_of(kind)  # type: ignore[arg-type]
    text, notes = _explained(kind.__doc__ or kind.summary, [f.name for f in entries])
    said = {}
    for f in entries:
        said[f.name] = _field_schema(hints[f.name], units.get(f.name))
        if f.name in notes:
            said[f.name] = {**said[f.name], "description": notes[f.name]}
    needed = [f.name for f in entries if f.default is MISSING and f.default_factory is MISSING]
    nothing = [] if needed else ["null", "boolean"]
    whole = {"type": ["object", *nothing], "properties": said, "additionalProperties": False}
    whole |= {"required": needed} if needed else {}
    short = kind.shorthand
    if short is None:
        return {"description": text, **whole}
    if said[short].get("type") == "object":  # its keys are names, which the field's own name would be one of
        return {"description": text, **{k: v for k, v in said[short].items() if k != "description"}}
    return {"description": text, "anyOf": [whole, said[short]]}


def _explained(doc: str, names: Sequence[str]) -> tuple[str, dict[str, str]]:
    """A docstring without its list of fields, and what that says of each field."""
    rest: list[str] = []
    notes: dict[str, str] = {}
    current: list[str] = []
    for line in inspect.cleandoc(doc).splitlines():
        entry = _ENTRY.match(line)
        listed = entry[1].split(", ") if entry else []
        if listed and set(listed) <= set(names):
            current = listed
            notes |= dict.fromkeys(current, entry[2] if entry else "")
        elif current and line.startswith("  ") and line.strip():
            notes |= {name: f"{notes[name]} {line.strip()}" for name in current}
        else:
            current = []
            rest.append(line)
    return " ".join(" ".join(rest).split()), notes


def _field_schema(hint: Any, unit: str | None) -> dict[str, Any]:
    """The schema of a field of this annotation; with a unit, numbers may be text that has its unit."""
    origin, inner = typing.get_origin(hint), typing.get_args(hint)
    note = _note(unit, expressions=takes_text(hint))
    if hint is float:
        return {"type": "number"} if unit is None else {"type": ["number", "string"], **note}
    if origin is Literal:
        return {"enum": list(inner)}
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
        return (
            {"anyOf": [part for k, part in enumerate(known) if part not in known[:k]]} if all(known) else {}
        )
    return {}


def _note(unit: str | None, *, expressions: bool) -> dict[str, str]:
    if unit is None:
        return {}
    said = f"a number ({unit or 'plain'}), or text with a unit" if unit else "a plain number"
    return {"description": said + (", or an expression" if expressions else "")}
