"""Sheets that are not what they seem: what is refused, what is told, of which part."""

import json
import warnings
from pathlib import Path
from typing import Any

import pytest

import lamc
from lamc.basics.errors import DesignWarning, LamcError

CARD = lamc.Card(thickness="0.3 mm", density="700 kg/m^3")


def loaded(file: Path, text: str, **options: Any) -> tuple[lamc.Mechanism, list[str]]:
    """The sheet in a file with that text, and what is told of it."""
    file.write_text(text)
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always", DesignWarning)
        found = lamc.load(file, card=CARD, crease=1e-3, units="mm", **options)
    assert isinstance(found, lamc.Mechanism)
    return found, [str(each.message) for each in told]


@pytest.mark.parametrize(
    ("name", "text", "error"),
    [
        ("a.svg", "not xml", r"a\.svg:1:1: this is not XML"),
        ("a.fold", "{", r"a\.fold:1:2: the file is no JSON"),
        ("a.fold", "[]", "no FOLD file: it holds a list"),
        ("a.json", "[]", "no FOLD file: it holds a list"),
        ("a.fold", '{"a": 1}', "no FOLD file: it has none of vertices_coords"),
        ("a.dxf", "x", "no DXF file"),
        ("a.json", '{"kind": "design"}', "card is for sheets"),
    ],
)
def test_what_is_named_as_a_sheet_and_is_none_is_refused_as_one(
    tmp_path: Path, name: str, text: str, error: str
) -> None:
    file = tmp_path / name
    file.write_text(text)
    with pytest.raises(LamcError, match=error):
        lamc.load(file, card=CARD)


def two_squares(ends: tuple[int, int], *more: tuple[int, int]) -> str:
    """Lines of two squares beside one another with one crease, 1 to 2; the second square's corners there are `ends`."""
    points = [[0, 0], [10, 0], [10, 10], [0, 10], [20, 0], [20, 10], [10, 0], [10, 10]]
    low, high = ends
    edges = [(1, 2), (0, 1), (2, 3), (3, 0), (low, 4), (4, 5), (5, high), *more]
    kinds = ["V", *"BBBBBB", *"V" * len(more)]
    return json.dumps({"vertices_coords": points, "edges_vertices": edges, "edges_assignment": kinds})


def test_a_facet_with_one_corner_of_its_own_at_a_crease_is_joined_and_that_is_told(tmp_path: Path) -> None:
    whole, told = loaded(tmp_path / "sheet.fold", two_squares((1, 2)))
    assert not any("joined" in note for note in told)
    for ends, more, named in (
        ((6, 2), (), "joined: 1 and 6"),
        ((6, 7), (), "joined: 1 and 6; 2 and 7"),
        ((6, 2), ((6, 2),), "edges 7 lie where others do"),
    ):
        sheet, told = loaded(tmp_path / "sheet.fold", two_squares(ends, *more))
        assert [body.mass for body in sheet.bodies] == pytest.approx([body.mass for body in whole.bodies])
        assert [joint.stiffness for joint in sheet.joints] == [joint.stiffness for joint in whole.joints]
        assert sum(named in note for note in told) == 1


def test_a_slit_between_creases_stays_one(tmp_path: Path) -> None:
    """Its sides are two edges, and the crease runs on at both of its ends: a hinge on either side, none along it."""
    points = [[0, 0], [10, 0], [20, 0], [20, 30], [10, 30], [0, 30], [10, 10], [10, 20], [10, 10], [10, 20]]
    edges = [(0, 1), (1, 2), (2, 3), (3, 4), (4, 5), (5, 0), (1, 6), (7, 4), (6, 7), (8, 9)]
    kinds = [*"BBBBBB", *"VV", *"BB"]
    data = {"vertices_coords": points, "edges_vertices": edges, "edges_assignment": kinds}
    sheet, told = loaded(tmp_path / "sheet.fold", json.dumps(data))
    assert len(sheet.bodies) == 2
    assert len(sheet.joints) == 1
    assert sheet.joints[0].stiffness == pytest.approx(
        0.02 * 1e-3
    )  # 1e-3 N/rad by default; none along the slit
    assert any("are one place" in note and "healed" in note for note in told)


def svg(*shapes: str) -> str:
    """A drawing of 40 by 20 mm with a rim."""
    root = '<svg xmlns="http://www.w3.org/2000/svg" width="40mm" height="20mm" viewBox="0 0 40 20">'
    return f'{root}<rect width="40" height="20" fill="none" stroke="black"/>{"".join(shapes)}</svg>'


CREASE = '<line x1="20" x2="20" y2="20" stroke="red" stroke-opacity="0.5"/>'


def test_creases_of_full_opacity_are_counted_that_stay(tmp_path: Path) -> None:
    stray = '<line x1="60" y1="5" x2="64" y2="9" stroke="red"/>'
    whole = '<line x1="10" x2="10" y2="20" stroke="blue"/>'
    _, told = loaded(tmp_path / "a.svg", svg(CREASE, stray))
    assert not any("full opacity" in note for note in told)
    _, told = loaded(tmp_path / "a.svg", svg(CREASE, stray, whole))
    assert sum("1 crease has full opacity and rests at 180 degrees" in note for note in told) == 1


@pytest.mark.parametrize("stroke", ["var(--c, red)", "url(#g) blue", "context-stroke"])
def test_a_stroke_that_is_not_understood_is_told_as_that(tmp_path: Path, stroke: str) -> None:
    line = f'<line x1="10" x2="10" y2="20" stroke="{stroke}"/>'
    sheet, told = loaded(tmp_path / "a.svg", svg(CREASE, line))
    assert len(sheet.joints) == 1
    (note,) = [note for note in told if "left out" in note]
    assert f"its stroke '{stroke}' is not understood" in note
    assert "write a colour" in note
    assert "filled" not in note
    sheet, told = loaded(tmp_path / "a.svg", svg(CREASE, f'<g id="valley_90">{line}</g>'))
    assert len(sheet.joints) == 2
    with pytest.raises(LamcError, match="is not understood"):
        loaded(tmp_path / "a.svg", svg(line).replace('stroke="black"', 'stroke="none"'))


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("rim.svg", svg()),
        ("hole.svg", svg('<circle cx="20" cy="10" r="4" fill="none" stroke="black"/>')),
        (
            "rim.fold",
            json.dumps(
                {
                    "vertices_coords": [[0, 0], [40, 0], [40, 20], [0, 20]],
                    "edges_vertices": [[0, 1], [1, 2], [2, 3], [3, 0]],
                    "edges_assignment": list("BBBB"),
                }
            ),
        ),
    ],
)
def test_a_sheet_without_a_crease_is_told_to_stay_flat(tmp_path: Path, name: str, text: str) -> None:
    sheet, told = loaded(tmp_path / name, text)
    assert len(sheet.bodies) == 1
    (note,) = [note for note in told if "nothing folds" in note]
    assert "no crease lies between two facets" in note
    _, told = loaded(tmp_path / "a.svg", svg(CREASE))
    assert not any("nothing folds" in note for note in told)
