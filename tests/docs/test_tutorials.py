"""The tutorials run from their first cell to their last, and are kept without results."""

import json
import re
import runpy
from pathlib import Path
from typing import Any

import matplotlib
import pytest
from click.testing import CliRunner

from lamc.cli import main
from lamc.readers.plates.problem_file import plate_of_text
from tests.support.ctools import needs_cc
from tests.support.paths import ROOT

matplotlib.use("Agg")
TUTORIALS = sorted((ROOT / "docs" / "tutorials").glob("*.ipynb"))


def cells(path: Path, kind: str) -> list[str]:
    notebook: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    return ["".join(cell["source"]) for cell in notebook["cells"] if cell["cell_type"] == kind]


def test_all_tutorials_are_there_and_on_the_site() -> None:
    assert {path.stem for path in TUTORIALS} >= {"gripper", "leg", "miura", "sarrus", "plate"}
    listed = re.findall(r": (tutorials/\w+\.ipynb)$", (ROOT / "mkdocs.yml").read_text("utf-8"), re.MULTILINE)
    assert sorted(listed) == [f"tutorials/{path.name}" for path in TUTORIALS]
    index = (ROOT / "docs" / "tutorials" / "index.md").read_text("utf-8")
    assert all(f"({path.name})" in index for path in TUTORIALS)


@needs_cc
@pytest.mark.parametrize("path", TUTORIALS, ids=lambda path: path.stem)
@pytest.mark.quick("gripper", "plate", "leg", others="campaign")
def test_a_tutorial_runs_from_first_to_last(
    path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    names: dict[str, Any] = {"__name__": "__main__"}
    for k, source in enumerate(cells(path, "code")):
        exec(compile(source, f"{path.name}, cell {k}", "exec"), names)
    matplotlib.pyplot.close("all")


@pytest.mark.slow
@pytest.mark.parametrize("path", TUTORIALS, ids=lambda path: path.stem)
def test_a_tutorial_runs_in_a_kernel(path: Path) -> None:
    """As Jupyter and `make docs` run it."""
    pytest.importorskip("ipykernel", reason="extra docs")
    nbclient = pytest.importorskip("nbclient", reason="extra docs")
    nbformat = pytest.importorskip("nbformat", reason="extra docs")
    notebook = nbformat.read(path, as_version=4)
    nbformat.validate(notebook)
    done = nbclient.NotebookClient(notebook, timeout=300).execute()
    shown = [output for cell in done.cells if cell.cell_type == "code" for output in cell.outputs]
    assert any("image/png" in output.get("data", {}) for output in shown)


@pytest.mark.parametrize("path", TUTORIALS, ids=lambda path: path.stem)
def test_a_tutorial_is_kept_without_results(path: Path) -> None:
    notebook = json.loads(path.read_text(encoding="utf-8"))
    for cell in notebook["cells"]:
        assert cell.get("outputs", []) == []
        assert cell.get("execution_count") is None


@pytest.mark.parametrize("path", TUTORIALS, ids=lambda path: path.stem)
def test_links_of_a_tutorial_lead_to_files(path: Path) -> None:
    for target in re.findall(r"\]\(([^)\s]+)\)", "\n".join(cells(path, "markdown"))):
        assert target.startswith("http") or (path.parent / target).is_file(), target


def test_the_plate_file_of_a_tutorial_is_one() -> None:
    (text,) = [
        block
        for source in cells(ROOT / "docs" / "tutorials" / "plate.ipynb", "markdown")
        for block in re.findall(r"```yaml\n(.*?)```", source, re.DOTALL)
    ]
    assert plate_of_text(text, "strip.yaml").name == "strip"


def test_the_reference_has_every_part_effect_and_public_name() -> None:
    made = runpy.run_path(str(ROOT / "docs" / "make_reference.py"))
    pages = made["pages"]()
    assert set(pages) == {*made["NAMES"], made["DRAWN"]}
    assert "| `gap` | number > 0 | m |" in pages["reference/format.md"]
    assert "\n## linear_motor\n" in pages["reference/effects.md"]
    assert "::: lamc.run.simulator.Simulator\n" in pages["reference/api.md"]
    assert pages[made["DRAWN"]].startswith(b"\x89PNG")


def test_tables_in_docstrings_stay_tables() -> None:
    pytest.importorskip("griffe", reason="extra docs")
    fenced = runpy.run_path(str(ROOT / "docs" / "plain_docstrings.py"))["fenced"]
    text = "A thing.\n\nmass   kg; of the thing,\n       all of it\ncom    m\ncentre m, too\n\nRaises."
    assert fenced(text) == (
        "A thing.\n\n\n```text\nmass   kg; of the thing,\n       all of it\ncom    m\ncentre m, too\n```\n\n\nRaises."
    )


@pytest.mark.slow
def test_split_tells_of_loops_where_the_scene_starts_not_as_drawn_nearly_flat(tmp_path: Path) -> None:
    """As drawn the lift's legs lie 1.5 mm above one another, and its weak equations look like a misfit of as much."""
    source = cells(ROOT / "docs" / "tutorials" / "sarrus.ipynb", "code")[1]
    (text,) = re.findall(r'write_text\("""\n(.*?)"""\)', source, re.DOTALL)
    (tmp_path / "lift.yaml").write_text(text, encoding="utf-8")
    done = CliRunner().invoke(main, ["split", str(tmp_path / "lift.yaml"), "--out", str(tmp_path / "out")])
    assert done.exit_code == 0
    assert "\n1 loop: 6 equations of rank 5, 1 redundant\n" in done.stdout
