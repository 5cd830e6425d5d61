"""`lamc schema` says what effects may hold, as each effect's own class does."""

import inspect
import json
from dataclasses import dataclass, fields
from typing import Annotated, Any, ClassVar

import pytest

from lamc.basics.quantity_fields import Unit
from lamc.effects import Gravity, JointLimits, Spring, Torque
from lamc.effects.registered import RegisteredEffect
from lamc.effects.registry import EFFECTS
from lamc.readers.effects_schema import effect_schema
from lamc.readers.schema import json_schema

SCHEMA = json_schema()["$defs"]


def test_scenes_refer_to_every_effect_of_the_registry() -> None:
    names = sorted(kind.name for kind in EFFECTS)
    by_map, by_list = SCHEMA["Effects"]["anyOf"]
    assert sorted(by_map["properties"]) == names
    assert by_map["additionalProperties"] is False
    assert by_list["items"]["anyOf"][0]["enum"] == names
    for scene in ("SceneModel", "Scene"):
        for key in ("effects", "with"):
            assert {"$ref": "#/$defs/Effects"} in SCHEMA[scene]["properties"][key]["anyOf"]


@pytest.mark.parametrize("kind", EFFECTS, ids=lambda kind: kind.name)
def test_an_effect_is_described_by_its_class(kind: Any) -> None:
    said = SCHEMA[f"effect_{kind.name}"]
    json.dumps(said)
    assert said["description"]
    if "properties" in said:
        assert set(said["properties"]) == {f.name for f in fields(kind)}


def test_fields_have_units_bounds_and_words_of_their_own() -> None:
    limits = effect_schema(JointLimits)
    stiffness = limits["properties"]["stiffness"]
    assert stiffness["description"].startswith("with neither stiffness nor rest")
    number: dict[str, Any] = {
        "type": ["number", "string"],
        "description": "a number (N*m/rad), or text with a unit",
    }
    number["x-unit"] = "N*m/rad"
    assert {**number, "exclusiveMinimum": 0.0} in stiffness["anyOf"]
    assert limits["properties"]["flat_fold"]["type"] == "boolean"
    assert limits["type"] == ["object", "null", "boolean"]
    assert "a joint that comes to rest" not in limits["description"].lower()


def test_what_must_be_given_is_required() -> None:
    spring = effect_schema(Spring)
    assert spring["required"] == ["body_a", "point_a", "body_b", "point_b", "stiffness"]
    assert spring["type"] == ["object"]
    assert spring["properties"]["point_a"]["minItems"] == 3
    assert spring["properties"]["point_b"]["description"].startswith("where the point is")


def test_a_field_may_stand_alone() -> None:
    whole, short = effect_schema(Gravity)["anyOf"]
    assert whole["properties"]["acceleration"] == short
    torque = effect_schema(Torque)
    assert torque["type"] == "object"
    assert torque["additionalProperties"]["type"] == ["number", "string"]
    assert "or an expression" in torque["additionalProperties"]["description"]


def test_an_effect_of_any_fields_is_described() -> None:
    @dataclass(frozen=True)
    class Odd(RegisteredEffect):
        """Odd."""

        table: Annotated[tuple[tuple[float, float], ...], Unit("rad", "rows, ascending")] = ()
        choice: int | str | None = None

        name: ClassVar[str] = "odd"
        summary: ClassVar[str] = "Odd"

    said = effect_schema(Odd)
    assert said["description"] == "Odd."
    assert said["properties"]["table"]["description"] == "rows, ascending"
    assert said["properties"]["table"]["items"]["maxItems"] == 2
    assert [part["type"] for part in said["properties"]["choice"]["anyOf"]] == ["integer", "string", "null"]
    assert inspect.getdoc(Odd) == f"Odd.\n\n{'table':<16} rad, rows, ascending"
