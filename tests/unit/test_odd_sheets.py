"""Sheets that are not what they seem: what is refused, what is told, of which part."""

from pathlib import Path

import pytest

import lamc
from lamc.basics.errors import LamcError

CARD = lamc.Card(thickness="0.3 mm", density="700 kg/m^3")


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
