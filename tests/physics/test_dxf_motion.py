"""A Miura and a laminate drawn as DXF, of every version, are the devices that YAML describes, and move as they do."""

import itertools
import json
import re
import string
import warnings
from pathlib import Path
from typing import Any

import pytest

import lamc
from lamc.basics.errors import DesignWarning
from lamc.examples import find
from lamc.readers.load import load_text
from tests.physics.test_fold_motion import CREASE, DENSITY, THICKNESS, by_hand
from tests.support import dxf_corpus, fold_corpus
from tests.support.ctools import needs_cc
from tests.support.four_bar import written_out
from tests.support.same_motion import assert_same_motion

pytestmark = needs_cc

FORMS = [f"{version}-{fmt}" for version, fmt in dxf_corpus.FORMS]


def load(path: Path, data: bytes | str, **options: Any) -> Any:
    path.write_bytes(data if isinstance(data, bytes) else data.encode())
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DesignWarning)
        return lamc.load(path, **options)


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.quick("R12-asc", "R2018-bin")
@pytest.mark.ci("R12-asc", "R12-bin", "R2000-asc", "R2007-bin", "R2018-asc", "R2018-bin")
def test_a_miura_from_dxf_moves_as_one_from_yaml(tmp_path: Path, form: str) -> None:
    hand = load(tmp_path / "miura.yaml", json.dumps(by_hand()))
    drawn = load(
        tmp_path / "miura.dxf",
        dxf_corpus.pattern(fold_corpus.miura(3, 3), *form.split("-")),
        card=lamc.Card(THICKNESS, DENSITY),
        crease=CREASE,
        fixed=(0.012, 0.005),
        units="mm",
    )
    assert_same_motion(hand, drawn)


def drawn_four_bar(version: str, fmt: str) -> tuple[str, bytes]:
    """The example with every shape and hinge line from a drawing; the drawing, of lines alone."""
    made, space = dxf_corpus.drawing(version)
    count = 0

    def drawn(found: re.Match[str]) -> str:
        nonlocal count
        count += 1
        numbers = [float(each) for each in re.findall(r"-?[\d.]+", found[1])]
        (x0, y0, x1, y1), layer = numbers, f"layer {string.ascii_letters[count]}"
        corners = [(x0, y0), (x1, y0), (x1, y1), (x0, y1), (x0, y0)] if found[0].startswith("rect") else []
        ends = corners or [(x0, y0), (x1, y1)]
        for a, b in itertools.pairwise(ends):
            space.add_line(a, b, dxfattribs={"layer": layer})
        word = "shape" if corners else "lines"
        return f"{word}: {{file: bar.dxf, layer: {layer}, units: mm}}"

    text = re.sub(r"rect: \[(.*?)\]", drawn, written_out())
    text = re.sub(r"line: \[(\[.*?\], \[.*?\])\]", drawn, text)
    assert not re.search(r"\b(?:rect|line): ", text)
    return text, dxf_corpus.data_of(made, fmt)


@pytest.mark.quick("R12-asc", "R2018-bin", others="campaign")
@pytest.mark.parametrize("form", FORMS)
def test_a_laminate_from_dxf_is_the_one_drawn_in_yaml(tmp_path: Path, form: str) -> None:
    version, fmt = form.split("-")
    text, bars = drawn_four_bar(version, fmt)
    (tmp_path / "bar.dxf").write_bytes(bars)
    found = lamc.split(load(tmp_path / "bar.yaml", text))
    expected = lamc.split(load_text(find("four_bar").text, "four_bar.yaml"))
    assert [b.name for b in found.bodies] == [b.name for b in expected.bodies]
    # Sums over the same corners in another order round differently in the last digits.
    for a, b in zip(found.bodies, expected.bodies, strict=True):
        assert a.mass == pytest.approx(b.mass, rel=1e-9)
        assert a.com == pytest.approx(b.com, abs=1e-12)
    for c, d in zip(found.joints, expected.joints, strict=True):
        assert (c.name, c.parent, c.child) == (d.name, d.parent, d.child)
        assert c.point == pytest.approx(d.point, abs=1e-12)
        assert c.axis == pytest.approx(d.axis, abs=1e-12)
