"""--set of a design's parameters: every verb that reads a design takes it, mistakes name the nearest."""

import json
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

import lamc
from lamc.cli import main
from tests.support.ctools import needs_cc
from tests.unit.test_design_parameters import BODY, HEAD


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    Path("d.yaml").write_text(HEAD + BODY, encoding="utf-8")
    return tmp_path


FEW = ("--t-end", "0.05", "--no-pictures")


def call(*words: str) -> Result:
    return CliRunner().invoke(main, list(words))


@needs_cc
@pytest.mark.parametrize(
    "words",
    [
        ("split",),
        ("build", "--force"),
        ("run", "--t-end", "0.05", "--no-pictures"),
        ("check", "--t-end", "0.05", "--states", "2"),
        ("bench",),
        ("ledger", "--t-end", "0.05", "--budget", "1s", "--no-effects", "--integrator", "rk45"),
        ("export", "--to", "mjcf", "--lossy"),
        ("view", "--fold"),
        ("convert", "d2.yaml"),
    ],
    ids=lambda words: words[0],
)
@pytest.mark.quick("split", "run", "export", "check", "convert", others="campaign")
def test_every_verb_that_reads_a_design_sets_its_parameters(words: tuple[str, ...]) -> None:
    verb, *more = words
    done = call(verb, "d.yaml", *more, "--set", "length=56 mm", "--set", "tilt=0.4")
    assert done.exit_code == 0, done.output
    refused = call(
        verb, "d.yaml", *more, "--force" if verb == "convert" else "--json", "--set", "lenght=56 mm"
    )
    assert refused.exit_code == 2
    assert "--set 'lenght=56 mm': no parameter is named 'lenght'; did you mean 'length'?" in refused.output


@pytest.mark.slow
def test_splitting_tells_the_parameters_and_uses_them() -> None:
    done = call("split", "d.yaml", "--set", "length=56 mm", "--out", "o")
    assert "parameters: length 56 mm, tilt 30°, t 0.3 mm, w 14 mm, k 0.002 N·m/rad, count 2" in done.output
    mechanism = lamc.load("o/d.mechanism.yaml")
    assert mechanism == lamc.split(lamc.load("d.yaml", set={"length": 0.056}))  # type: ignore[arg-type]
    data = json.loads(call("split", "d.yaml", "--json", "--out", "o").stdout)
    assert data["parameters"]["length"]["value"] == 0.04


def test_values_out_of_bounds_and_of_another_unit_are_refused_with_the_option() -> None:
    for text, said in (
        ("length=1", "parameter 'length' is 1 m; it must be at most 0.09 m"),
        ("length=3 deg", "'deg' is not a unit of parameter 'length'"),
        ("w=0", "d.yaml:15:5: shapes[0]: the rectangle encloses no area"),
    ):
        done = call("split", "d.yaml", "--set", text)
        assert done.exit_code == 2
        assert said in done.output


@needs_cc
def test_a_finished_run_is_viewed_with_the_parameters_that_it_had() -> None:
    done = call(
        "run",
        "d.yaml",
        "--t-end",
        "0.05",
        "--no-pictures",
        "--set",
        "length=56 mm",
        "--set",
        "h1.stiffness=1e-3",
    )
    assert "params  length 56 mm, tilt 30°" in done.output
    manifest = json.loads(Path("out/d/scene/manifest.json").read_text(encoding="utf-8"))
    assert manifest["design_parameters"]["length"]["value"] == 0.056
    assert manifest["design_parameters_set"] == {"length": 0.056}
    assert manifest["parameters"]["h1.stiffness"] == 1e-3
    assert call("view", "out/d", "--no-live").exit_code == 0


@needs_cc
def test_a_name_of_neither_names_the_nearest_of_both() -> None:
    for name, nearest in (("h1.stifness", "h1.stiffness"), ("lenght", "length")):
        done = call("run", "d.yaml", "--t-end", "0.05", "--no-pictures", "--set", f"{name}=1e-3")
        assert done.exit_code == 2
        assert f"did you mean '{nearest}'?" in done.output


def test_facets_is_handed_on_to_the_reader() -> None:
    """Two triangles with their diagonal flat: facets bend along it, unless they are to be rigid."""
    corners = [[0, 0], [1, 0], [1, 1], [0, 1]]
    edges = [[0, 1], [1, 2], [2, 3], [3, 0], [0, 2]]
    fold = {
        "vertices_coords": corners,
        "edges_vertices": edges,
        "edges_assignment": [*"BBBB", "F"],
        "frame_unit": "mm",
    }
    Path("flat.fold").write_text(json.dumps(fold), encoding="utf-8")
    counts = []
    for facets in ("rigid", "bend"):
        done = call("split", "flat.fold", "--facets", facets, "--json", "--out", facets)
        counts.append(len(json.loads(done.stdout)["joints"]))
    assert counts == [0, 1]


def test_a_converted_file_holds_values_and_says_so() -> None:
    done = call("convert", "d.yaml", "e.yaml", "--set", "length=56 mm")
    assert "lost      parameters, whose values are written in: length 56 mm" in done.output
    made, written = lamc.load("d.yaml", set={"length": "56 mm"}), lamc.load("e.yaml")
    assert isinstance(made, lamc.Design)
    assert isinstance(written, lamc.Design)
    assert [each.thickness for each in written.layers] == [each.thickness for each in made.layers]
    assert written.body_names == made.body_names
