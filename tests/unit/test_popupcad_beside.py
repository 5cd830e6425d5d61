"""popupCAD designs that lie in files beside the one read: from its folder, and from nowhere else."""

import hashlib
import json
from pathlib import Path

import pytest

from lamc.basics.errors import DesignError, UnsupportedError
from lamc.cli import main
from lamc.readers.load import load, load_text
from lamc.records.design import Design
from tests.unit.test_popupcad import areas, cad, read
from tests.unit.test_popupcad_forms import FROM, HOW, TO, line_sketch, transform, with_inner

MORE = "sketch_links: {sketch_to: [202]}, sub_sketch_id: 201"
LINKS = "subopref: !!python/tuple [1, 0], operation_links: {}"
ONLY_A_NAME = (
    "!!python/object:popupcad.filetypes.design.Design {_basename: %s, dirname: 'C:\\Users\\someone', id: 77}"
)


def placing(stored: str | None, key: str = "77", sketches: str = "") -> str:
    """A design that places operation 1 of another, which it has under `key` as `stored`."""
    operation = transform(
        "TransformExternal", f"design_links: {{subdesign: ['{key}']}}, {LINKS}, {MORE}, {HOW}"
    )
    outer = cad(operation, parent=7, sketches=line_sketch(202, TO) + sketches)
    return outer + (f"subdesigns: {{{key}: {stored}}}\n" if stored is not None else "")


def loaded(folder: Path, text: str, name: str = "outer.cad") -> Design:
    (folder / name).write_text(text, encoding="utf-8")
    record = load(folder / name)
    assert isinstance(record, Design)
    return record


@pytest.mark.parametrize(
    ("stored", "key"),
    [
        ("leg.cad", "77"),
        (r"'C:\Users\someone\designs\leg.cad'", "77"),
        ("/home/someone/leg.cad", "77"),
        ("../leg.cad", "77"),
        (ONLY_A_NAME % "leg.cad", "77"),
        (None, "leg.cad"),
    ],
)
def test_a_design_beside_is_placed_as_one_inside(tmp_path: Path, stored: str | None, key: str) -> None:
    """40 by 10 mm, scaled by two and turned by 90 degrees about where the line ends: (x, y) -> (5 - 2 y, 3 + 2 x)."""
    leg = cad(sketches=FROM)
    (tmp_path / "leg.cad").write_text(leg, encoding="utf-8")
    design = loaded(tmp_path, placing(stored, key))
    assert areas(design) == areas(read(with_inner("TransformExternal", MORE)))
    assert areas(design) == pytest.approx([1600.0, 1600.0], rel=1e-12)  # round-off of a turn
    assert design.layers[0].geometry.bounds == pytest.approx((-0.015, 0.003, 0.005, 0.083), abs=1e-15)
    assert design.beside == (("leg.cad", hashlib.sha256(leg.encode()).hexdigest()),)
    assert read(with_inner("TransformExternal", MORE)).beside == ()


@pytest.mark.parametrize("stored", ["leg.cad", ONLY_A_NAME % "leg.cad"])
def test_a_file_that_is_missing_is_reported_with_the_place_and_the_way_out(
    tmp_path: Path, stored: str
) -> None:
    (tmp_path / "legs.cad").write_text(cad(sketches=FROM), encoding="utf-8")
    text = placing(stored)
    with pytest.raises(DesignError, match=r"there is no such file; did you mean .*legs\.cad") as caught:
        loaded(tmp_path, text)
    assert caught.value.place is not None
    assert caught.value.place.file == str(tmp_path / "outer.cad")
    assert caught.value.place.line == text.count("\n")  # the last line names it
    assert "put that file beside this one" in caught.value.message


def test_a_text_without_a_file_has_nothing_beside_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "leg.cad").write_text(cad(sketches=FROM), encoding="utf-8")
    monkeypatch.chdir(tmp_path)  # the working folder is not the text's
    with pytest.raises(DesignError, match=r"this text is in no file .* load the file by its path"):
        load_text(placing("leg.cad"), "given.cad")


def test_nothing_outside_the_folder_is_read(tmp_path: Path) -> None:
    folder = tmp_path / "designs"
    folder.mkdir()
    (tmp_path / "leg.cad").write_text(cad(sketches=FROM), encoding="utf-8")
    with pytest.raises(DesignError, match="there is no such file"):
        loaded(folder, placing("../leg.cad"))
    (folder / "leg.cad").symlink_to(tmp_path / "leg.cad")
    with pytest.raises(DesignError, match="a link that leads out of its folder"):
        loaded(folder, placing("leg.cad"))
    (folder / "leg.cad").unlink()
    (folder / "leg.cad").symlink_to("leg.cad")
    with pytest.raises(DesignError, match=r"leg\.cad"):
        loaded(folder, placing("leg.cad"))
    (folder / "leg.cad").unlink()
    (folder / "own.cad").write_text(cad(sketches=FROM), encoding="utf-8")
    (folder / "leg.cad").symlink_to("own.cad")  # a link within the folder
    assert areas(loaded(folder, placing("leg.cad"))) == pytest.approx([1600.0, 1600.0], rel=1e-12)


@pytest.mark.parametrize("name", ["''", "..", "'designs/'", '"a\\0b.cad"', '"a\\nb.cad"', "[1]", "null"])
def test_names_that_name_no_file_are_refused(tmp_path: Path, name: str) -> None:
    with pytest.raises(DesignError):
        loaded(tmp_path, placing(name))


def test_files_that_place_each_other_are_refused(tmp_path: Path) -> None:
    own = placing("outer.cad", sketches=FROM).replace("[1, 0]", "[7, 0]", 1)
    with pytest.raises(DesignError, match=r"outer\.cad → outer\.cad; take one of them out"):
        loaded(tmp_path, own.replace("subopref: !!python/tuple [1, 0]", "subopref: !!python/tuple [7, 0]"))
    a, b = (
        placing(name, sketches=FROM).replace(
            "subopref: !!python/tuple [1, 0]", "subopref: !!python/tuple [7, 0]"
        )
        for name in ("b.cad", "a.cad")
    )
    (tmp_path / "b.cad").write_text(b, encoding="utf-8")
    with pytest.raises(DesignError, match=r"a\.cad → b\.cad → a\.cad"):
        loaded(tmp_path, a, "a.cad")


def test_chains_of_files_are_read_and_bounded(tmp_path: Path) -> None:
    def chain(count: int) -> Design:
        for k in range(count):
            text = placing(f"f{k + 1}.cad", sketches=FROM)
            (tmp_path / f"f{k}.cad").write_text(
                text.replace("subopref: !!python/tuple [1, 0]", "subopref: !!python/tuple [7, 0]").replace(
                    TO, "[1, 1, 0], [2, 11, 0]"
                ),
                encoding="utf-8",
            )
        last = cad(transform("ShiftFlip3", "operation_links: {parent: [[1, 0]]}, shift: 0"), sketches=FROM)
        (tmp_path / f"f{count}.cad").write_text(last, encoding="utf-8")
        record = load(tmp_path / "f0.cad")
        assert isinstance(record, Design)
        return record

    three = chain(3)  # each moves by 1 mm
    assert three.layers[0].geometry.bounds == pytest.approx((0.003, 0.0, 0.043, 0.01), abs=1e-15)
    assert [name for name, _ in three.beside] == ["f1.cad", "f2.cad", "f3.cad"]
    with pytest.raises(DesignError, match="more than 20 files rest on one another"):
        chain(22)


def test_what_lies_beside_is_judged_as_every_file(tmp_path: Path) -> None:
    beside = tmp_path / "leg.cad"
    beside.write_text("kind: design\n", encoding="utf-8")
    with pytest.raises(DesignError, match="is no popupCAD design"):
        loaded(tmp_path, placing("leg.cad"))
    code = "- !!python/object:popupcad.manufacturing.code_exec_op.CodeExecOperation {id: 6, customname: x}\n"
    beside.write_text(cad(code, sketches=FROM), encoding="utf-8")
    with pytest.raises(UnsupportedError, match="never runs stored code") as caught:
        loaded(tmp_path, placing("leg.cad"))
    assert caught.value.place is not None
    assert caught.value.place.file == str(beside)
    beside.write_bytes(b"\xff\x00\xff")
    with pytest.raises(DesignError, match="not UTF-8"):
        loaded(tmp_path, placing("leg.cad"))


def test_a_run_names_the_files_beside(tmp_path: Path) -> None:
    leg = cad(sketches=FROM)
    (tmp_path / "leg.cad").write_text(leg, encoding="utf-8")
    # The plate stays where it was drawn, so that the hinge crosses it.
    text = placing("leg.cad").replace(TO, "[1, 0, 0], [2, 10, 0]")
    (tmp_path / "outer.cad").write_text(text, encoding="utf-8")
    out = tmp_path / "out"
    words = ["run", str(tmp_path / "outer.cad"), "--t-end", "0.01", "--out", str(out)]
    assert main(words, standalone_mode=False) == 0
    manifest = json.loads((out / "manifest.json").read_text(encoding="utf-8"))
    assert manifest["beside_sha256"] == {"leg.cad": hashlib.sha256(leg.encode()).hexdigest()}
