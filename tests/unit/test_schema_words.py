"""Every field that a file may have is described, with unit and default; every part has an example that reads."""

import re
from collections.abc import Iterator
from typing import Any

import pytest

from lamc.basics.fields import MEANING, UNIT, StrictModel
from lamc.effects.registry import by_name
from lamc.readers import native, schema, study_file
from lamc.readers.checking import validate
from lamc.readers.fields import LENGTH_UNIT
from lamc.readers.inert import compose, plain
from lamc.readers.plates import problem_schema
from lamc.readers.schema_names import _PARTS, called, definitions, parts
from lamc.report.schema_text import field_rows, schema_table

KNOWN = definitions()
FIELDS = [
    (f"{part}.{name}", field, name in definition.get("required", ()))
    for part, definition in KNOWN.items()
    for whole in (definition, *definition.get("anyOf", ()))
    for name, field in whole.get("properties", {}).items()
    if part != "Effects"
]
_FORM = re.compile(r"^([\w ]+, )?a number \(|^ply angle with its unit")  # what the unit alone says


def numbers_without_unit(field: Any) -> bool:
    """Whether a number that is no whole one stands in the field with no unit on it or around it."""
    if isinstance(field, list):
        return any(map(numbers_without_unit, field))
    if not isinstance(field, dict) or UNIT in field:
        return False
    kinds = field.get("type", [])
    if "number" in ([kinds] if isinstance(kinds, str) else kinds):
        return True
    return any(
        numbers_without_unit(each) for key, each in field.items() if key not in ("default", "properties")
    )


def test_no_field_of_any_schema_lacks_a_description_a_unit_or_a_default() -> None:
    assert len(FIELDS) > 300
    meanings = {name: field.get(MEANING) or field.get("description", "") for name, field, _ in FIELDS}
    assert [name for name, said in meanings.items() if not said or _FORM.match(said)] == []
    assert [name for name, field, _ in FIELDS if numbers_without_unit(field)] == []
    assert [name for name, field, needed in FIELDS if not needed and "default" not in field] == []


def test_every_part_has_a_name_and_every_name_a_part() -> None:
    named = {of for of, _ in _PARTS.values()} | {f"effect_{name}" for name in by_name()}
    assert set(KNOWN) - named == {"Effects", "SceneModel"}  # their own verb, and `scene`
    assert all(part.said and part.summary and part.example for part in parts().values())


def _model(of: str) -> type[StrictModel]:
    if of in schema_files():
        return schema_files()[of]
    (found,) = [model for model in every_model(StrictModel) if model.__name__ == of]
    return found


def every_model(of: type[StrictModel]) -> Iterator[type[StrictModel]]:
    for model in of.__subclasses__():
        yield model
        yield from every_model(model)


def schema_files() -> dict[str, type[StrictModel]]:
    return {**schema.FILES, "PlateProblem": problem_schema.PlateFileModel, "Study": study_file.StudyModel}


@pytest.mark.parametrize("name", sorted(_PARTS))
def test_the_example_of_a_part_reads_as_one(name: str) -> None:
    of, example = _PARTS[name]
    node = compose(example, f"{name}.yaml")
    if of == "Design":  # its numbers are expressions, which need its parameters
        native.read_design(node)
    else:
        validate(_model(of), node, {LENGTH_UNIT: native.length_unit_of(node)})


@pytest.mark.parametrize("name", sorted(by_name()))
def test_the_example_of_an_effect_makes_it(name: str) -> None:
    ((called_so, value),) = plain(compose(by_name()[name].example, name)).items()
    assert called_so == name
    assert by_name()[name].from_data(value, name).name == name


def test_a_table_tells_field_type_unit_default_and_meaning() -> None:
    rows = {row.name: row for row in field_rows(KNOWN["HingeModel"], called)}
    assert rows["damping"].unit == "N*m*s/rad"
    assert (rows["damping"].type, rows["damping"].default) == ("number ≥ 0", "0.0")
    assert rows["stiffness"].type == "number ≥ 0 or from-material"
    assert rows["line"].type == "2 x 2 numbers"
    assert "width" not in rows  # the old name
    assert max(map(len, schema_table(KNOWN["HingeModel"], called).splitlines())) <= 112
    materials = next(row for row in field_rows(KNOWN["Design"], called) if row.name == "materials")
    assert (materials.type, materials.default) == ("map of material", "required")
