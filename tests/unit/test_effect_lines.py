"""What is wrong in any field of any effect of a scene's file is reported at its line, whatever else the scene has."""

from collections.abc import Iterator
from dataclasses import fields
from pathlib import Path
from typing import Any

import pytest

import lamc
from lamc.basics.errors import DesignErrors, LamcError, Place
from lamc.readers.scene_writer import scene_data
from tests.support.every_effect import SAMPLES, mechanism
from tests.unit.test_unknown_names import UNKNOWN, loop

Data = dict[str, Any]
NAMES = frozenset(each.name for each in (*mechanism().bodies, *mechanism().joints))
COMPANY = {"plain": None, "loop": None, "free base": "free_base", "flexible": "flexible_links"}


def data_of(name: str) -> Data:
    """The sample of an effect as a file has it, by field; torques and the like by joint."""
    ((said,),) = (scene_data(lamc.Scene(effects=[SAMPLES[name]]))["effects"],)
    return {SAMPLES[name].shorthand: said[name]} if isinstance(said[name], list) else said[name] or {}  # type: ignore[attr-defined]


def in_flow(value: Any) -> str:
    """YAML on one line."""
    if isinstance(value, dict):
        return "{" + ", ".join(f"{key}: {in_flow(each)}" for key, each in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(in_flow, value)) + "]"
    if value is None or isinstance(value, bool):
        return {None: "null", True: "true", False: "false"}[value]
    return f'"{value}"' if isinstance(value, str) else repr(value)


def scene_file(
    folder: Path, name: str, data: Data, company: str | None = None
) -> tuple[Path, dict[str, int]]:
    """A scene's file, a field a line, and the lines: of the fields by name, of the effect itself by no name."""
    others = [f"  {company}: {in_flow(data_of(company))}"] if company not in (None, name) else []
    lines, at = ["effects:", *others, f"  {name}:"], {}
    at[""] = len(lines)
    for field, value in data.items():
        lines.append(f"    {in_flow(field)}: {in_flow(value)}")
        at[field] = len(lines)
    file = folder / "scene.yaml"
    file.write_text("\n".join(lines) + "\n")
    return file, at


def refusal(file: Path, kind: str) -> LamcError:
    """What comes of compiling in the file's scene."""
    with pytest.raises(LamcError) as caught:
        lamc.compile(loop() if kind == "loop" else mechanism(), lamc.load_scene(file))
    assert caught.value.place is not None
    assert caught.value.place.file == str(file)
    return caught.value


def misnamed(value: Any) -> Iterator[Any]:
    """`value` with one of the names in it unknown, one after the other."""
    if isinstance(value, str) and value in NAMES:
        yield UNKNOWN
    elif isinstance(value, dict):
        for name, each in value.items():
            if name in NAMES:
                yield {UNKNOWN if key == name else key: v for key, v in value.items()}
            yield from ({**value, name: other} for other in misnamed(each))
    elif isinstance(value, list):
        for k, each in enumerate(value):
            yield from ([*value[:k], other, *value[k + 1 :]] for other in misnamed(each))


NAMED = [
    pytest.param(name, data, id=f"{name}-{k}")
    for name in SAMPLES
    for k, data in enumerate(misnamed(data_of(name)))
]


@pytest.mark.parametrize("kind", COMPANY)
@pytest.mark.parametrize(("name", "data"), NAMED)
def test_a_name_that_is_not_there_is_reported_at_its_field(
    name: str, data: Data, kind: str, tmp_path: Path
) -> None:
    file, at = scene_file(tmp_path, name, data, COMPANY[kind])
    error = refusal(file, kind)
    assert error.place is not None
    assert error.place.line == next(at[key] for key in data if UNKNOWN in in_flow({key: data[key]}))
    assert f"'{UNKNOWN}'" in error.message


@pytest.mark.parametrize("after", ["", "\n\n  # more\n  hinge_damping:\n"])
def test_an_effect_without_a_value_is_reported_at_its_own_line(after: str, tmp_path: Path) -> None:
    """Nothing is written there, and the next word may be lines away, or the file may be over."""
    motion = {"displacement": ["0", "0", "t"]}
    file, _ = scene_file(tmp_path, "base_motion", motion)
    text = file.read_text(encoding="utf-8")
    file.write_text(f"{text}  free_base:{after}\n\n", encoding="utf-8")
    assert refusal(file, "plain").place == Place(str(file), text.count("\n") + 1, 3)


def test_there_is_a_case_of_every_effect_that_names_something() -> None:
    assert len(NAMED) >= 15


# ---- one field spoilt -------------------------------------------------------------------------------------------


def spoilt(value: Any, bad: object) -> Iterator[Any]:
    """`value` with one of the numbers in it replaced; as a whole where it holds none."""
    if isinstance(value, dict | list):
        for key in value if isinstance(value, dict) else range(len(value)):
            for other in spoilt(value[key], bad):
                whole = value.copy()
                whole[key] = other
                yield whole
    elif isinstance(value, float | int) and not isinstance(value, bool):
        yield bad


def of_fields(bad: object) -> list[Any]:
    """Every effect of lamc's with every number of every field spoilt."""
    return [
        pytest.param(name, field, {**data_of(name), field: other}, id=f"{name}.{field}-{k}")
        for name in SAMPLES
        for field, value in data_of(name).items()
        for k, other in enumerate(spoilt(value, bad))
    ]


def check_field(name: str, field: str, data: Data, folder: Path) -> str:
    """The field is refused at its line when the scene is read, whatever moves in it; and what is said of it."""
    file, at = scene_file(folder, name, data)
    with pytest.raises(LamcError) as caught:
        lamc.load_scene(file)
    place = caught.value.place
    assert place is not None
    assert (place.file, place.line) == (str(file), at[field]), str(caught.value)
    assert place.column > 0
    assert f"effects.{name}" in caught.value.message
    return caught.value.message


@pytest.mark.parametrize(("name", "field", "data"), of_fields("3 K"))
def test_a_wrong_unit_is_reported_at_its_field(name: str, field: str, data: Data, tmp_path: Path) -> None:
    if field not in ("strips", "modes", "corners"):  # whole numbers, which have no unit
        assert "'K' is not a unit of" in check_field(name, field, data, tmp_path)


@pytest.mark.parametrize(("name", "field", "data"), of_fields(1e300))
def test_a_number_that_is_none_of_this_world_is_reported_at_its_field(
    name: str, field: str, data: Data, tmp_path: Path
) -> None:
    check_field(name, field, data, tmp_path)


FIELDS = [
    pytest.param(name, each.name, id=f"{name}.{each.name}")
    for name, effect in SAMPLES.items()
    for each in fields(effect)  # type: ignore[arg-type]
    if each.name not in ("torques", "laws")  # stand alone, by joint
]


@pytest.mark.parametrize("bad", [{"no such": {"no": 1}}, [[[["no"]]]], []])
@pytest.mark.parametrize(("name", "field"), FIELDS)
def test_a_wrong_type_is_reported_at_its_field(name: str, field: str, bad: object, tmp_path: Path) -> None:
    if (field, bad) in (("polarity", []), ("outline", [])):  # of the right type: told by what they are for
        return
    said = check_field(name, field, {**data_of(name), field: bad}, tmp_path)
    assert "; " in said  # and the way out


@pytest.mark.parametrize("name", [n for n in SAMPLES if n not in ("torque", "nonlinear_stiffness")])
def test_a_field_that_is_not_there_is_reported_at_its_line(name: str, tmp_path: Path) -> None:
    said = check_field(name, "nosuch", {**data_of(name), "nosuch": 1}, tmp_path)
    assert "has no field 'nosuch'" in said or "takes no value" in said


BELOW = {
    "blade_element_drag": ("air_density", "strips", "lift", "drag_edge_on", "drag_broadside", "rest_speed"),
    "ground_contact": ("friction", "stiffness", "corners"),
    "joint_limits": ("stiffness", "damping"),
    "linear_motor": ("torque_constant", "resistance"),
    "piezo_bender": ("width", "extension"),
    "spring": ("stiffness", "rest_length", "damping"),
    "twist_compliance": ("width", "thickness", "E", "nu", "retardation"),
    "flexible_links": ("modes", "damping_ratio", "size", "refinement"),
}


@pytest.mark.parametrize(("name", "field"), [(name, field) for name in BELOW for field in BELOW[name]])
def test_a_number_out_of_bounds_is_reported_at_its_field(name: str, field: str, tmp_path: Path) -> None:
    said = check_field(name, field, {**data_of(name), field: -1}, tmp_path)
    assert "it must be above" in said or "it must be at least" in said


def in_blocks(value: Any, indent: int, path: tuple[Any, ...], lines: list[str], at: dict[Any, int]) -> None:
    """YAML with a line for each node, and the lines by path."""
    for key, each in value.items() if isinstance(value, dict) else enumerate(value):
        head = f"{' ' * indent}{f'{in_flow(key)}:' if isinstance(value, dict) else '-'}"
        below = bool(each) and isinstance(each, dict | list)
        lines.append(head if below else f"{head} {in_flow(each)}")
        at[*path, key] = len(lines)
        if below:
            in_blocks(each, indent + 2, (*path, key), lines, at)


def numbers(value: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """Paths of the numbers in it."""
    if isinstance(value, dict | list):
        for key, each in value.items() if isinstance(value, dict) else enumerate(value):
            yield from numbers(each, (*path, key))
    elif isinstance(value, int | float) and not isinstance(value, bool):
        yield path


def put(value: Any, path: tuple[Any, ...], other: object) -> Any:
    if not path:
        return other
    whole = value.copy()
    whole[path[0]] = put(value[path[0]], path[1:], other)
    return whole


@pytest.mark.parametrize("name", SAMPLES)
def test_a_number_deep_in_a_field_is_reported_at_its_own_line(name: str, tmp_path: Path) -> None:
    """Of a laminate's plies all had been reported at the first."""
    data, file = data_of(name), tmp_path / "scene.yaml"
    for path in numbers(data):
        if path[-1] in ("strips", "modes", "corners") or path[0] == "outline":
            continue  # whole numbers have no unit
        lines, at = ["effects:", f"  {name}:"], {}
        in_blocks(put(data, path, "3 K"), 4, (), lines, at)
        file.write_text("\n".join(lines) + "\n")
        with pytest.raises(LamcError) as caught:
            lamc.load_scene(file)
        assert caught.value.place is not None
        assert caught.value.place.line == at[path], str(caught.value)


def test_all_that_is_wrong_with_an_effect_is_reported_at_once(tmp_path: Path) -> None:
    data = {**data_of("spring"), "stiffness": "3 kg", "damping": -1, "point_a": [0, 0]}
    file, at = scene_file(tmp_path, "spring", data)
    with pytest.raises(DesignErrors) as caught:
        lamc.load_scene(file)
    lines = [each.place.line for each in caught.value.problems if each.place is not None]
    assert lines == sorted(at[field] for field in ("stiffness", "damping", "point_a"))
