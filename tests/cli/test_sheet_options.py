"""Drawings on the command line: what each verb takes of a sheet, roles from a file, what is refused."""

import json
from pathlib import Path

import pytest

import lamc
from lamc.basics.errors import LamcError
from lamc.cli import main
from lamc.commands.options import Cli
from lamc.readers.drawings.roles_file import read_roles
from tests.support.ctools import needs_cc
from tests.support.svg_corpus import HEAD

DRAWING = f"""<svg {HEAD} width="40mm" height="20mm" viewBox="0 0 40 20" fill="none">
<rect width="40" height="20" stroke="navy"/><line x1="20" x2="20" y2="20" stroke="teal" id="fold"/>
<g id="notes"><line x1="5" x2="6" stroke="black"/></g></svg>
"""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "pair.svg").write_text(DRAWING)
    (tmp_path / "shop.yaml").write_text("'#000080': border\nteal: cut  # --role says hinge\nNotes: ignore\n")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def call(*words: str) -> int:
    assert isinstance(main, Cli)
    return int(main.main(list(words), standalone_mode=False))


SHEET = (
    "--roles",
    "shop.yaml",
    "--role",
    "teal=hinge",
    "--card",
    "0.3 mm, 700 kg/m^3",
    "--crease",
    "1e-3",
    "--heal",
)


@needs_cc
@pytest.mark.parametrize(
    "words",
    [
        ("split",),
        ("build",),
        ("run", "--t-end", "0.1", "--no-pictures"),
        ("check", "--t-end", "0.1", "--states", "2"),
        ("bench",),
        ("ledger", "--t-end", "0.1", "--budget", "1s", "--no-effects", "--integrator", "rk45"),
        ("export", "--to", "fold"),
        ("view", "--fold"),
    ],
    ids=lambda words: words[0],
)
@pytest.mark.quick("split", "run", "export", "check", others="campaign")
def test_each_verb_takes_a_drawing_and_what_is_said_of_it(
    folder: Path, words: tuple[str, ...], capsys: pytest.CaptureFixture[str]
) -> None:
    assert call(words[0], "pair.svg", *words[1:], *SHEET, "0.1 mm", "--json") == 0
    told = json.loads(capsys.readouterr().out)
    assert told["ok"]
    assert not told.get("warnings")


def test_a_role_of_the_command_line_comes_before_the_file(folder: Path) -> None:
    assert read_roles("shop.yaml") == {"#000080": "border", "teal": "cut", "Notes": "ignore"}
    assert call("split", "pair.svg", *SHEET, "0", "--out", "out") == 0
    made = lamc.load("out/pair.mechanism.yaml")
    assert isinstance(made, lamc.Mechanism)
    assert [joint.rest_angle for joint in made.joints] == [0.0]
    assert call("split", "pair.svg", "--roles", "shop.yaml", "--out", "cut") == 0
    assert not lamc.load("cut/pair.mechanism.yaml").joints  # type: ignore[union-attr]


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("#ff0000: cut\n", "colours stand in quotes"),
        ("", "says no role"),
        ("- red\n", "is a map of colours"),
        ("red: mountian\n", r"roles.yaml:1:6: the role of 'red' is 'mountian'; roles are border"),
        ("red: [cut]\n", "the role of 'red' is no word"),
        ("? [a]\n: cut\n", "by its name"),
        ("a: cut\na: cut\n", "stands twice"),
        ("\ufffe", "not|no"),
    ],
)
def test_a_file_of_roles_is_refused_with_its_line(tmp_path: Path, text: str, told: str) -> None:
    file = tmp_path / "roles.yaml"
    file.write_text(text, encoding="utf-8")
    with pytest.raises(LamcError, match=told):
        read_roles(file)


def test_options_of_drawings_are_refused_elsewhere(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for words, told in (
        (("split", "--example", "pendulum", "--role", "red=cut"), "--role is of FOLD, SVG and DXF files"),
        (("split", "pair.svg", "--role", "red"), "write a colour or a layer and a role: red=cut"),
        (("split", "pair.svg", "--role", "red=scut"), "roles are border"),
        (("split", "pair.svg", "--roles", "none.yaml"), "none.yaml"),
        (("plate", "pair.svg"), "read as a sheet of creases"),
    ):
        assert call(*words) == 2
        assert told in " ".join(capsys.readouterr().err.split())
    fold = folder / "a.fold"
    fold.write_text('{"vertices_coords": [[0,0],[1,0],[0,1]], "edges_vertices": [[0,1],[1,2],[2,0]]}')
    with pytest.raises(LamcError, match="roles is for drawings"):
        lamc.load(fold, roles={"red": "cut"})
