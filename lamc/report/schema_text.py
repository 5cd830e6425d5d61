"""What a part of lamc's files may say, as a table: field, type, unit, default, meaning; and an example.

In: definitions of the JSON Schema. Out: plain text and plain data. It prints nothing.
"""

import json
import textwrap
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass
from typing import Any

from lamc.basics.fields import MEANING, UNIT, unit_in

Schema = Mapping[str, Any]
Naming = Callable[[str], str]  # from a $ref to what people call it

_NARROW, _WIDE = 40, 112  # characters: the least of a column of meanings, and a whole line
_ANY_LENGTH = 3  # entries from which a list of alternatives is cut


@dataclass(frozen=True)
class FieldRow:
    """One field: unit "" for none; default "" for one that must be given."""

    name: str
    type: str
    unit: str
    default: str
    meaning: str


def field_rows(definition: Schema, naming: Naming) -> list[FieldRow]:
    """The fields of a definition; one row without a name for a part that is no map of fields."""
    whole = next((each for each in definition.get("anyOf", ()) if "properties" in each), definition)
    if "properties" not in whole:
        return [
            FieldRow("", type_of(whole, naming), unit_in(whole), "", str(whole.get(MEANING, "see above")))
        ]
    needed = whole.get("required", ())
    return [
        FieldRow(
            name,
            type_of(each, naming),
            unit_in(each),
            "required" if name in needed else default_of(each),
            meaning_of(each),
        )
        for name, each in whole["properties"].items()
        if not each.get("deprecated")
    ]


def meaning_of(field: Schema) -> str:
    """What the field is, without words about its form."""
    return str(field.get(MEANING) or field.get("description", ""))


def default_of(field: Schema) -> str:
    """As one would write it; "-" for nothing."""
    value = field.get("default")
    if value is None or value in ([], {}, ""):
        return "-"
    return json.dumps(value) if not isinstance(value, str) else value


def type_of(field: Any, naming: Naming) -> str:
    """In a few words: number, text, list of layer, map of material, a | b."""
    if not isinstance(field, Mapping) or not field:
        return "any"
    if "$ref" in field:
        return naming(field["$ref"])
    if "allOf" in field:
        return type_of(field["allOf"][0], naming)
    if "const" in field:
        return str(field["const"])
    if "enum" in field:
        return " | ".join(map(str, field["enum"]))
    if "anyOf" in field or "oneOf" in field:
        parts = field.get("anyOf", []) + field.get("oneOf", [])
        kinds = [type_of(each, naming) for each in parts if each.get("type") != "null"]
        return " or ".join(dict.fromkeys(kinds))
    return _plain_type(field, naming)


def _plain_type(field: Schema, naming: Naming) -> str:
    kind = field.get("type", "any")
    kinds = [kind] if isinstance(kind, str) else [each for each in kind if each != "null"]
    if UNIT in field and "string" in kinds:  # text of a number with a unit is a number to people
        said = "number or expression" if "expression" in str(field.get("description")) else "number"
        return f"{said}{_bounds(field)}" + (" or list" if "array" in kinds else "")
    if kinds == ["array"]:
        return _list_type(field, naming)
    if kinds == ["object"]:
        return (
            f"map of {type_of(field.get('additionalProperties'), naming)}" if "items" not in field else "map"
        )
    names = {
        "string": "text",
        "boolean": "true | false",
        "integer": "whole number",
        "array": "list",
        "object": "map",
    }
    return " or ".join(names.get(each, each) for each in kinds) + _bounds(field)


def _list_type(field: Schema, naming: Naming) -> str:
    """2 numbers, list of layer, 2 x 2 numbers, list of (2 numbers)."""
    entry = type_of(field.get("items") or (field.get("prefixItems") or [{}])[0], naming)
    count = field.get("maxItems") if field.get("maxItems") == field.get("minItems") else None
    if count is None:
        return f"list of ({entry})" if entry[0].isdigit() else f"list of {entry}"
    if entry[0].isdigit():
        return f"{count} x {entry}"
    return f"{count} {entry}s" if entry.endswith("number") else f"{count} {entry}"


def _bounds(field: Schema) -> str:
    """ " > 0", " 0 to 1", as far as there are any."""
    signs = {"exclusiveMinimum": ">", "minimum": "≥", "exclusiveMaximum": "<", "maximum": "≤"}
    return "".join(f" {sign} {field[key]:g}" for key, sign in signs.items() if key in field)


def schema_table(definition: Schema, naming: Naming) -> str:
    """A row per field, meanings wrapped."""
    rows = field_rows(definition, naming)
    heads = ("field", "type", "unit", "default")
    cells = [(row.name, _cut(row.type), row.unit, row.default) for row in rows]
    widths = [max(len(each[k]) for each in (heads, *cells)) for k in range(4)]
    left = sum(widths) + 2 * len(widths)
    room = max(_NARROW, _WIDE - left)
    lines = ["  ".join(head.ljust(width) for head, width in zip(heads, widths, strict=True)) + "  meaning"]
    for row, cell in zip(rows, cells, strict=True):
        said = textwrap.wrap(row.meaning, room) or [""]
        start = "  ".join(text.ljust(width) for text, width in zip(cell, widths, strict=True))
        lines.append(f"{start}  {said[0]}".rstrip())
        lines += [" " * left + more for more in said[1:]]
    return "\n".join(lines)


def _cut(kind: str) -> str:
    parts = kind.split(" | ")
    return kind if len(parts) <= _ANY_LENGTH + 2 else " | ".join(parts[:_ANY_LENGTH]) + " | …"


def schema_data(definition: Schema, naming: Naming) -> list[dict[str, str]]:
    """The rows as plain data."""
    return [asdict(row) for row in field_rows(definition, naming)]
