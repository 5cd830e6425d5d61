"""`lamc schema`, `lamc materials`, `lamc effects`, `lamc functions`: what there is to say, as tables and as data."""

import json
import re
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from lamc.cli import main
from lamc.effects.registry import by_name
from lamc.plates.laminates.library import LIBRARY
from lamc.symbolic.functions import FUNCTIONS


def call(*words: str) -> Result:
    return CliRunner().invoke(main, list(words))


def test_a_part_is_a_table_with_units_defaults_and_an_example() -> None:
    done = call("schema", "hinge")
    assert done.exit_code == 0
    lines = done.stdout.splitlines()
    (damping,) = [line.split() for line in lines if line.startswith("damping ")]
    assert damping[:5] == ["damping", "number", "≥", "0", "N*m*s/rad"]
    assert "example" in lines
    assert call("schema", "hinges").stdout == call("schema", "design.hinge").stdout == done.stdout


def test_a_part_is_json_schema_on_request() -> None:
    data = json.loads(call("schema", "layer", "--json").stdout)
    assert data["properties"]["thickness"]["x-unit"] == "m"
    assert data["properties"]["thickness"]["description"].endswith("or text with a unit")


def test_a_part_that_is_not_there_names_the_nearest() -> None:
    done = call("schema", "hinje")
    assert (done.exit_code, done.stdout) == (2, "")
    assert "did you mean 'hinge'?" in done.stderr
    assert "`lamc effects` lists" in call("schema", "effects").stderr


def test_schemas_are_written_for_editors(tmp_path: Path) -> None:
    done = call("schema", "--out", str(tmp_path / "s"))
    assert f"# yaml-language-server: $schema={(tmp_path / 's').as_posix()}/lamc.schema.json" in done.stdout
    written = {path.name for path in (tmp_path / "s").iterdir()}
    assert {"design.schema.json", "plate.schema.json", "lamc.schema.json"} <= written
    assert json.loads((tmp_path / "s" / "lamc.schema.json").read_text()) == json.loads(call("schema").stdout)


def test_a_copy_of_an_example_beside_the_schema_names_it(tmp_path: Path) -> None:
    call("examples", "flaps", "--copy", str(tmp_path / "bare"))
    call("schema", "--out", str(tmp_path))
    call("examples", "flaps", "--copy", str(tmp_path))
    line, rest = (tmp_path / "flaps.yaml").read_text(encoding="utf-8").split("\n", 1)
    assert line == "# yaml-language-server: $schema=lamc.schema.json"
    assert rest == (tmp_path / "bare" / "flaps.yaml").read_text(encoding="utf-8")


@pytest.mark.slow
def test_the_list_has_every_effect_and_each_can_be_asked_for() -> None:
    listed = call("schema", "--list").stdout
    for name in by_name():
        assert f"\n  {name} " in listed
        assert call("effects", name).exit_code == call("schema", name).exit_code == 0


@pytest.mark.parametrize("name", [*LIBRARY, "kapton hn"])
def test_a_material_tells_its_numbers_and_their_source(name: str) -> None:
    done = call("materials", name)
    assert done.exit_code == 0
    assert "source: " in done.stdout
    data = json.loads(call("materials", name, "--json").stdout)
    assert data["E1"] == next(each.E1 for key, each in LIBRARY.items() if key.lower() == name.lower())


def test_lists_are_complete() -> None:
    assert all(name in call("materials").stdout for name in LIBRARY)
    assert all(f"{name}(" in call("functions").stdout for name in FUNCTIONS)
    assert set(json.loads(call("functions", "--json").stdout)["functions"]) == set(FUNCTIONS)
    assert {each["name"] for each in json.loads(call("effects", "--json").stdout)["effects"]} == set(
        by_name()
    )


@pytest.mark.slow
def test_a_warning_is_one_line_on_stderr_and_none_with_quiet(tmp_path: Path) -> None:
    text = Path(__file__).parents[2].joinpath("lamc/examples/flaps.yaml").read_text(encoding="utf-8")
    (tmp_path / "old.yaml").write_text(text.replace("gap: 0.4", "width: 0.2"), encoding="utf-8")
    words = ("split", str(tmp_path / "old.yaml"), "--out", str(tmp_path / "out"))
    told = [line for line in call(*words).stderr.splitlines() if line.startswith("warning: ")]
    assert len(told) == 1
    assert "write gap: 0.4 mm" in told[0]
    assert call(*words, "--quiet").stderr == ""


@pytest.mark.slow
def test_split_tells_slit_and_strip(tmp_path: Path) -> None:
    done = call("split", "--example", "flaps", "--out", str(tmp_path), "--json")
    assert json.loads(done.stdout)["cuts"][0] == {"joint": "left", "gap": 4e-4, "slit": 4e-5}
    text = call("split", "--example", "flaps", "--out", str(tmp_path)).stdout
    assert "gap 0.4 mm of all hinges: so much film bends, from board to board; a slit of 40 µm is cut" in text


def test_arguments_stand_in_their_order() -> None:
    told = call("functions").stdout
    assert re.search(r"^atan2\(y, x\) +angle of the point \(x, y\)", told, re.MULTILINE)
    assert re.search(r"^pow\(x, y\) +x to the power of y", told, re.MULTILINE)


def test_an_effect_asked_for_as_a_part_leads_to_the_effects() -> None:
    refused = call("schema", "motor")
    assert refused.exit_code == 2
    assert "lamc effects" in refused.stderr
