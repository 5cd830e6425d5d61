"""What is shown of a splitting: picture, tables, data."""

import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from lamc.basics.errors import LamcError
from lamc.design.split import split, split_steps
from lamc.records.design import HingeLine
from lamc.report.split_picture import draw_split
from lamc.report.split_text import body_table, joint_table, split_data, split_text
from tests.support.laminates import flaps, miura, pendulum, vertex


def test_picture_has_four_panels_of_all_that_there_is(tmp_path: Path) -> None:
    draw_split(split_steps(vertex((0, 60, 140, 250))), tmp_path / "steps.svg")
    text = (tmp_path / "steps.svg").read_text()
    assert text.count('<g id="axes_') == 4
    # Matplotlib leaves the text of titles and labels in comments of the SVG.
    for label in (
        "1  device",
        "2  holes: 1",
        "3  cut",
        "4  bodies: 3 moving, 1 fixed",
        "hinge line",
        "x [mm]",
    ):
        assert re.search(rf"<!-- .*{re.escape(label)}.* -->", text), label
    assert "<dc:date>" not in text


@pytest.mark.slow
def test_picture_is_the_same_every_time(tmp_path: Path) -> None:
    for name in ("a.svg", "b.svg"):
        draw_split(split_steps(flaps()), tmp_path / name)
    assert (tmp_path / "a.svg").read_bytes() == (tmp_path / "b.svg").read_bytes()
    assert sorted(p.name for p in tmp_path.iterdir()) == ["a.svg", "b.svg"]


@pytest.mark.slow
def test_picture_shows_each_body_in_a_colour_of_its_own(tmp_path: Path) -> None:
    draw_split(split_steps(pendulum()), tmp_path / "steps.png")
    with Image.open(tmp_path / "steps.png") as image:
        pixels = np.asarray(image.convert("RGB")).reshape(-1, 3).astype(np.uint32) @ [1 << 16, 1 << 8, 1]
    colours, counts = np.unique(pixels, return_counts=True)
    # Each square body covers about 1.8 % of the picture.
    large = {f"{c:06x}" for c, n in zip(colours, counts, strict=True) if n > 0.01 * len(pixels)}
    assert {"0072b2", "e69f00", "009e73"} <= large


def test_names_that_look_like_markup_are_drawn_as_they_are(tmp_path: Path) -> None:
    design = flaps()
    line = HingeLine(design.hinges[0].lines[0].line, r"$\frac{1}{$")
    odd = replace(design, name="$x^{$", hinges=(replace(design.hinges[0], lines=(line,)), design.hinges[1]))
    draw_split(split_steps(odd), tmp_path / "steps.png")
    assert (tmp_path / "steps.png").stat().st_size > 10_000


def test_unknown_kind_of_picture_is_refused(tmp_path: Path) -> None:
    with pytest.raises(
        LamcError, match=r"cannot draw into 'steps.bmp'; the name must end in .png, .svg, .pdf"
    ):
        draw_split(split_steps(flaps()), tmp_path / "steps.bmp")
    assert list(tmp_path.iterdir()) == []


def test_tables_name_units_and_hold_every_body_and_joint() -> None:
    mechanism = split(flaps())
    bodies, joints = body_table(mechanism).splitlines(), joint_table(mechanism).splitlines()
    assert [line.split()[0] for line in bodies[2:]] == ["ground", "link_1", "link_2"]
    assert "x [mm]" in bodies[0]
    assert "fixed" in bodies[2]
    assert joints[2].split()[:3] == ["h1", "ground", "link_1"]
    assert joints[2].endswith("-120 to 120")
    assert joints[3].endswith("free")
    assert "(0, 1, 0)" in joints[2]
    # 15 degrees as drawn.
    assert " 15 " in joints[2]


def test_numbers_stand_in_columns() -> None:
    lines = body_table(split(pendulum())).splitlines()
    assert lines[3].split()[:2] == ["link_1", "0.9999836"]
    ends = {m.end() for line in lines[2:] for m in re.finditer(r"0\.99998\d\d", line)}
    assert len(ends) == 1


def test_report_ends_with_notes() -> None:
    assert split_text(split(flaps()), ["left out a scrap"]).endswith("\n\nnote: left out a scrap")
    assert split_text(split(flaps())).startswith("flaps: 3 bodies, 2 joints\n\n")


def test_data_reads_back_exactly_from_json() -> None:
    mechanism = split(miura())
    data = json.loads(json.dumps(split_data(mechanism)))
    assert [b["mass"] for b in data["bodies"]] == [b.mass for b in mechanism.bodies]
    assert [j["point"] for j in data["joints"]] == [j.point.tolist() for j in mechanism.joints]
    assert {j["stiffness"] for j in data["joints"]} == {1e-3}
