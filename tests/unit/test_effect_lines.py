"""What is wrong in any field of any effect of a scene's file is told at its line, whatever else the scene has."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import lamc
from lamc.basics.errors import LamcError
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
def test_a_name_that_is_not_there_is_told_at_its_effect(
    name: str, data: Data, kind: str, tmp_path: Path
) -> None:
    file, at = scene_file(tmp_path, name, data, COMPANY[kind])
    error = refusal(file, kind)
    assert error.place is not None
    assert error.place.line in at.values()
    assert f"'{UNKNOWN}'" in error.message


def test_there_is_a_case_of_every_effect_that_names_something() -> None:
    assert len(NAMED) >= 15
