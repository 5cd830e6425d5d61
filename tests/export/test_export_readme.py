"""What the README of an exported folder states is so: bytes, members, start, what acts."""

import io
import re
from pathlib import Path

import pytest
from PIL import Image

import lamc
from lamc.export.picture import picture_of
from tests.support.ctools import needs_cc
from tests.support.exported_folders import KINDS, cc, does, exported, mechanism_of, put, scene_of

pytestmark = needs_cc


def readme(name: str, **options: object) -> str:
    return exported(name, **options)["README.md"].decode()


def rows(text: str, pattern: str) -> list[list[str]]:
    """Cells of the rows whose first cell is like `pattern`."""
    found = [
        re.split(r"(?<!\\)\|", line)[1:-1]
        for line in text.splitlines()
        if re.match(rf"\| `{pattern}` \|", line)
    ]
    return [[cell.strip() for cell in row] for row in found]


@pytest.mark.parametrize("real_time", [False, True])
@pytest.mark.parametrize("name", KINDS)
@pytest.mark.quick("pendulum-*", "limit_stop-*")
def test_the_bytes_of_an_instance_are_those_that_the_compiler_finds(
    name: str, real_time: bool, tmp_path: Path
) -> None:
    folder = put(exported(name, real_time=real_time), tmp_path)
    (folder / "size.c").write_text(
        f'#include "{name}.h"\n#include <stdio.h>\n'
        f'int main(void) {{ printf("%d", (int)sizeof({name}_t)); return 0; }}\n'
    )
    cc(folder, "-std=c99", "size.c", "-o", "size")
    (reported,) = re.findall(r"\| one instance \| (\d+) bytes", readme(name, real_time=real_time))
    assert reported == does([folder / "size"], folder)


@pytest.mark.parametrize("name", KINDS)
def test_every_member_stands_in_a_table_with_its_unit_and_default(name: str) -> None:
    simulator = lamc.compile(mechanism_of(name), scene_of(name))
    header = exported(name)[f"{name}.h"].decode()
    for struct in ("parameters", "inputs"):
        (body,) = re.findall(
            rf"typedef struct {name}_{struct} {{\n(.*?)}} {name}_{struct};", header, re.DOTALL
        )
        members = re.findall(r"^  double (\w+); /\* (\S+):", body, re.MULTILINE)
        reported = {cells[0].strip("`"): cells for cells in rows(readme(name), r"\w+")}
        assert members
        for field, parameter in members:
            _, default, unit, meaning = reported[field]
            assert meaning.startswith(parameter)
            if parameter in simulator.parameters:  # torques from outside are the export's own
                assert float(default) == pytest.approx(simulator.parameters[parameter], rel=1e-5)  # 6 digits
                assert unit == simulator.parameter_units[parameter].replace("*", "\\*")
            else:
                assert (default, unit) == ("0", "N·m")


def test_coordinates_say_which_body_turns_and_where_they_start() -> None:
    simulator = lamc.compile(mechanism_of("crawler"), scene_of("crawler"))
    reported = rows(readme("crawler"), r"q\[\d+\]")
    assert [cells[1] for cells in reported] == [c.name for c in simulator.coordinates]
    assert [float(cells[4]) for cells in reported] == pytest.approx(
        simulator.start[: len(reported)], rel=1e-5
    )
    assert reported[0][3] == "rear_leg relative to body"


@pytest.mark.slow
def test_the_picture_shows_this_mechanism() -> None:
    pictures = []
    for name in KINDS:
        assert "mechanism.png" in exported(name)
        simulator = lamc.compile(mechanism_of(name), scene_of(name))
        program = simulator.program
        painted = picture_of(simulator.mechanism, program.joints, program.bodies)
        pictures.append(Image.open(io.BytesIO(painted)))
    for picture in pictures:
        assert picture.width > 800
        colours = picture.convert("RGB").getcolors(10**6)
        assert colours is not None
        assert len(colours) > 50
    assert len({picture.tobytes() for picture in pictures}) == len(KINDS)


@pytest.mark.parametrize("name", KINDS)
def test_it_is_one_page(name: str) -> None:
    """Tables aside: 80 lines of text are some two screens."""
    text = [line for line in readme(name).splitlines() if line and not line.startswith("|")]
    assert len(text) < 80
    assert max(map(len, text)) < 200
