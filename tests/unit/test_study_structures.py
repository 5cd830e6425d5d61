"""A study tells how many structures were compiled, and at which points the topology changed."""

from pathlib import Path

import pytest

import lamc
from lamc.report.optimum_text import optimum_summary
from lamc.report.study_text import study_summary
from lamc.studies.bench import RunOptions
from lamc.studies.making import study_of
from lamc.studies.storage import ROWS
from tests.support import studied

FAST = RunOptions(t_end=0.02, rtol=1e-6, atol=1e-9, rows=5)
MEASURE = {"end": "last(hip_0)"}


@pytest.mark.slow
def test_points_of_one_topology_share_a_number_and_what_changed_is_told(tmp_path: Path) -> None:
    study = study_of(studied.hanging, {"length": [0.2, 0.3], "count": [1, 2, 3, 1.5]}, MEASURE, run=FAST)
    tables = [study.run(tmp_path / str(workers), workers, alone=0.0) for workers in (1, 2)]
    for table in tables:
        assert table.structure_count == 3
        assert [table.structure(k) for k in range(8)] == [0, 1, 2, 0, 0, 1, 2, 0]
        assert len(table.changes) == 2
        assert table.changes[0].startswith("structure 1 (2 points, first 1: length = 0.2, count = 2)")
        assert "bodies added: rod_1; joints added: hip_1" in table.changes[0]
        text = study_summary(table)
        assert "compiled  3 structures, as the topology changes" in text
        assert "joints added: hip_1, hip_2" in text
    lines = [table.write_csv(tmp_path / "table.csv").read_bytes() for table in tables]
    assert lines[0] == lines[1]
    assert lines[0].splitlines()[2].endswith(b",1,ok,")


def test_one_topology_is_one_structure_and_a_refused_drawing_has_none() -> None:
    table = study_of(studied.rod, {"length": [0.2, 0.3, 0.4]}, {"end": "last(hip)"}, run=FAST).run(None, 1)
    assert [table.structure(k) for k in range(3)] == [0, 0, -1]
    assert table.changes == ()
    assert "compiled  one structure for all points" in study_summary(table)


def test_other_numbers_that_vanish_are_another_structure() -> None:
    study = study_of(studied.rod, {"tilt": [0.0, 0.1, 0.2]}, {"end": "last(hip)"}, run=FAST)
    table = study.run(None, 1)
    assert [table.structure(k) for k in range(3)] == [0, 1, 1]
    assert "other numbers of it vanish" in table.changes[0]


def test_the_dataset_tells_it(tmp_path: Path) -> None:
    pytest.importorskip("xarray")
    study = study_of(studied.hanging, {"count": [2, 1]}, MEASURE, run=FAST)
    dataset = study.run(None, 1).dataset()
    assert dataset["structure"].values.tolist() == [0, 1]
    assert dataset.attrs["structures"] == 2
    assert "bodies gone: rod_1" in dataset.attrs["topology"]


def test_rows_of_a_folder_without_structures_are_read(tmp_path: Path) -> None:
    """As an earlier lamc wrote them."""
    study = study_of(studied.rod, {"length": [0.2, 0.3]}, {"end": "last(hip)"}, run=FAST)
    whole = study.run(tmp_path, 1)
    rows = tmp_path / ROWS
    rows.write_text('[0, "ok", "", [0.25]]\n' + rows.read_text(encoding="ascii").splitlines(True)[1])
    table = study.run(tmp_path, 1, resume=True)
    assert table.values["end"].tolist() == [0.25, whole.values["end"][1]]
    assert [table.structure(k) for k in range(2)] == [-1, 0]


def test_an_optimum_tells_the_structures_that_it_went_through(tmp_path: Path) -> None:
    best = lamc.optimise(
        studied.hanging,
        vary={"count": "1..2", "length": (0.2, 0.3)},
        minimise="rms(hip_0)",
        t_end=0.05,
        rows=11,
        max_runs=60,
    )
    counts = {trial.point[0]: best.structures[trial.index] for trial in best.problem.trials if trial.is_ok}
    assert sorted(counts.values()) == [0, 1]
    assert "2 structures, as the topology changes" in optimum_summary(best)
    head = best.write_csv(tmp_path / "history.csv").read_text(encoding="utf-8").splitlines()[0]
    assert head.endswith(",structure,status,reason,stage")
