"""Sheets whose rigid facets do not fold, or close only nearly: they bend along diagonals, and it is told."""

import json
import math
import random
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner

import lamc
from lamc.basics.errors import DesignError, DesignWarning
from lamc.cli import main
from lamc.loops.at_start import loops_of
from lamc.loops.rank import LoopCount
from lamc.loops.work import Limits
from lamc.mechanism.tree import Tree
from lamc.readers.fold_bending import NOWHERE, obstacle
from lamc.records.mechanism import Mechanism
from lamc.records.scene import Scene
from tests.support import fold_corpus
from tests.support.ctools import needs_cc

pytestmark = needs_cc


def quads(folder: Path, off: float, count: int = 3) -> Path:
    """A sheet of parallelograms, mm, whose corners are off by random shares: no vertex of it fits the next."""
    chance = random.Random(20260301)
    places = [
        [
            10.0 * j + (5.0 if i % 2 else 0.0) + chance.uniform(-off, off),
            9.0 * i + chance.uniform(-off, off),
        ]
        for i in range(count + 1)
        for j in range(count + 1)
    ]
    edges: list[tuple[int, int, str]] = []
    for i in range(count + 1):
        for j in range(count):
            a = i * (count + 1) + j
            edges.append((a, a + 1, "B" if i in (0, count) else "MV"[(i + j) % 2]))
            b = j * (count + 1) + i
            edges.append((b, b + count + 1, "B" if i in (0, count) else "MV"[i % 2]))
    path = folder / "quads.fold"
    data = {
        "file_spec": 1.1,
        "frame_unit": "mm",
        "vertices_coords": places,
        "edges_vertices": [edge[:2] for edge in edges],
        "edges_assignment": [edge[2] for edge in edges],
        "edges_foldAngle": [
            None if edge[2] == "B" else math.copysign(30.0, ord(edge[2]) - 80) for edge in edges
        ],
    }
    path.write_text(json.dumps(data))
    return path


def read(path: Path, **options: Any) -> tuple[Mechanism, list[str]]:
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        sheet = lamc.load(path, card=lamc.Card(), crease=1e-3, **options)
    assert isinstance(sheet, Mechanism)
    return sheet, [str(each.message) for each in caught if issubclass(each.category, DesignWarning)]


@pytest.mark.slow
def test_facets_bend_where_rigid_ones_do_not_move(tmp_path: Path) -> None:
    path = quads(tmp_path, 1.5)
    rigid, _ = read(path, facets="rigid")
    with pytest.raises(DesignError, match=r"no degree of freedom|nothing moves"):
        lamc.compile(rigid)
    bent, notes = read(path)
    assert any("they bend along diagonals" in note for note in notes)
    assert len(bent.bodies) == 2 * len(rigid.bodies)
    masses = [sum(body.mass for body in sheet.bodies) for sheet in (rigid, bent)]
    assert masses[1] == pytest.approx(masses[0], rel=1e-12)  # the same area in parts
    flat = {joint.name: joint for joint in bent.joints}
    for joint in rigid.joints:
        assert flat[joint.name].stiffness == pytest.approx(joint.stiffness, rel=1e-12)
    result = lamc.compile(bent, lamc.Scene(without=("gravity", "hinge_damping"))).run(0.02, rtol=1e-9)
    assert result.success, result.message
    total, kinetic = result.energy, result.energies["kinetic"]
    assert kinetic.max() > 0.0
    assert np.abs(total - total[0]).max() <= 1e-6 * kinetic.max()  # the tolerance, over some hundred steps


def test_facets_that_move_stay_rigid(tmp_path: Path) -> None:
    sheet, notes = read(quads(tmp_path, 0.0))
    assert not any("bend" in note for note in notes)
    assert len(sheet.bodies) == 9
    asked, _ = read(quads(tmp_path, 0.0), facets="bend")
    assert len(asked.bodies) == 18


def drawn_by_eye(folder: Path, off: float) -> Path:
    """A Miura sheet of 4 x 3 facets whose vertices are off by shares of its size."""
    data = fold_corpus.miura(4, 3)
    exact = np.array(data["vertices_coords"], dtype=float)
    aside = np.random.default_rng(3).uniform(-1.0, 1.0, exact.shape)
    data["vertices_coords"] = (exact + off * np.ptp(exact, axis=0).max() * aside).tolist()
    return fold_corpus.write(folder / f"miura_{off:g}.fold", data)


@pytest.mark.quick("0.0001-True")
@pytest.mark.parametrize(("off", "bend"), [(1e-6, False), (1e-5, False), (1e-4, True), (1e-3, True)])
def test_facets_bend_where_rigid_ones_close_only_by_far(tmp_path: Path, off: float, bend: bool) -> None:
    """Loops of such sheets are off by some seven times as much as their corners."""
    sheet, notes = read(drawn_by_eye(tmp_path, off))
    told = [note for note in notes if "they bend along diagonals" in note]
    assert len(sheet.bodies) == (24 if bend else 12)
    assert len(told) == bend
    # At 1e-3 of the size loops are off by more than is taken as closed: nothing moves.
    assert all(("nothing moves" if off == 1e-3 else "fits worst around") in note for note in told)
    assert all("--facets rigid" in note for note in told)


@pytest.mark.slow
@pytest.mark.ci("3-*", "4-*")
@pytest.mark.parametrize(("columns", "turned"), [(3, 5.0), (3, 33.0), (4, 5.0), (5, 5.0), (5, 33.0)])
def test_rigid_facets_of_six_digits_move_as_those_of_the_exact_drawing(
    columns: int, turned: float, tmp_path: Path
) -> None:
    """A sheet turned on its page, in mm to a micrometre: facets that bend folded another way, by a radian."""
    data = fold_corpus.miura(columns, columns)
    places = np.array(data["vertices_coords"], dtype=float)[:, :2]
    angle = math.radians(turned)
    turn = np.array([[math.cos(angle), math.sin(angle)], [-math.sin(angle), math.cos(angle)]])
    places = places @ turn
    places -= places.min(axis=0)
    digits = 6 - len(str(int(places.max())))
    results = []
    for name, drawn in (("exact", places), ("rounded", np.round(places, digits))):
        path = fold_corpus.write(tmp_path / f"{name}.fold", data | {"vertices_coords": drawn.tolist()})
        sheet, notes = read(path)
        assert not any("bend along" in note for note in notes)
        results.append(lamc.compile(sheet).run(1.0))
    exact, rounded = results
    assert rounded.success, rounded.message
    # Facets are off by 1 µm in 30 mm; a fold angle is off by some times that.
    worst = max(abs(exact.angle(name)[-1] - rounded.angle(name)[-1]) for name in exact.hinges)
    assert worst < 1e-3


@pytest.mark.slow
def test_a_sheet_whose_rigid_facets_come_apart_is_run_with_facets_that_bend(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    path = drawn_by_eye(tmp_path, 1e-5)
    rigid, _ = read(path)
    failed = lamc.compile(rigid).run(1.0)
    assert not failed.success
    assert failed.t[-1] < 0.1
    words = ["run", str(path), "--t-end", "1", "--no-pictures", "--out", "o"]
    done = CliRunner().invoke(main, words)
    assert done.exit_code == 0, done.output
    manifest = json.loads(Path("o/manifest.json").read_text(encoding="utf-8"))
    (note,) = [note for note in manifest["notes"] if "came apart" in note]
    assert "--facets rigid" in note
    assert "freedoms" in note
    assert manifest["facets"] == "bend"
    seen = CliRunner().invoke(main, ["view", "o", "--out", "o.html"])
    assert seen.exit_code == 0, seen.output
    asked = CliRunner().invoke(main, [*words, "--facets", "rigid"])
    assert asked.exit_code == 3


def test_a_curved_crease_folds_where_its_facets_bend(tmp_path: Path) -> None:
    path = tmp_path / "curve.svg"
    path.write_text(
        '<svg xmlns="http://www.w3.org/2000/svg" width="100mm" height="60mm" viewBox="0 0 100 60">'
        '<rect width="100" height="60" fill="none" stroke="#000"/>'
        '<polyline points="0,40 25,25 50,20 75,25 100,40" fill="none" stroke="#f00" opacity="0.3"/></svg>'
    )
    sheet, notes = read(path)
    assert any("they bend along diagonals" in note for note in notes)
    resting = [joint.rest_angle for joint in sheet.joints if joint.rest_angle]
    assert resting == pytest.approx([-0.3 * math.pi] * 4, rel=1e-12)
    assert lamc.compile(sheet).run(0.01).success


def test_loops_of_a_sheet_may_be_off_by_a_thousandth_of_its_size(tmp_path: Path) -> None:
    sheet, _ = read(quads(tmp_path, 1e-3), facets="rigid")
    sim = lamc.compile(sheet)
    assert sim.loops.misfit is not None
    allowed = sim.scene.closure_tolerance
    assert allowed is not None
    assert 0.0 < sim.loops.misfit.gap <= allowed
    assert allowed == pytest.approx(1e-3 * sheet.size, rel=0.2)


def test_other_words_for_facets_are_refused(tmp_path: Path) -> None:
    with pytest.raises(DesignError, match="'rigid' or 'bend'"):
        lamc.load(quads(tmp_path, 0.0), facets="soft")  # type: ignore[arg-type]


def test_facets_bend_where_rigid_ones_would_stay_flat_along_most_creases(tmp_path: Path) -> None:
    """Three creases that leave a vertex to one side, which rigid facets lock, and a flap at a corner, which turns."""
    rim = [(0, 0), (40, 0), (60, 0), (60, 20), (60, 60), (30, 60), (0, 60), (0, 40)]
    data = {
        "file_spec": 1.1,
        "frame_unit": "mm",
        "vertices_coords": [*rim, (30, 30)],
        "edges_vertices": [*[(k, (k + 1) % 8) for k in range(8)], (1, 3), (8, 4), (8, 5), (8, 7)],
        "edges_assignment": [*"BBBBBBBB", "V", "M", "V", "M"],
        "edges_foldAngle": [*8 * [None], 40, -30, 30, -30],
    }
    path = tmp_path / "locked.fold"
    path.write_text(json.dumps(data))
    rigid, _ = read(path, facets="rigid")
    assert [joint.name for joint in rigid.joints] == ["E8"]
    bent, told = read(path)
    assert {"E8", "E9", "E10", "E11"} < {joint.name for joint in bent.joints}
    assert any("rigid facets would stay flat along 3 of 4 creases" in each for each in told)
    result = lamc.compile(bent).run(t_end=0.05)
    assert result.success
    assert max(abs(result.angle(name)).max() for name in ("E9", "E10", "E11")) > 0.1


def test_facets_stay_rigid_where_bending_ones_would_be_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Nothing moves either way, and the reason is told; with facets that bend it would be how many they are."""
    path = drawn_by_eye(tmp_path, 1e-3)
    bent, _ = read(path)
    for limits in ("SOON", "MOST"):
        fewer = Limits(hinges=len(bent.joints) - 1, closing=10**6, numbers=10**6)
        monkeypatch.setattr(f"lamc.readers.fold_sheet.{limits}", fewer)
    rigid, notes = read(path)
    assert len(rigid.bodies) == 12
    assert any("left rigid" in note and "--facets bend" in note for note in notes)
    meant, _ = read(path, large=True)
    assert len(meant.bodies) == len(bent.bodies)


@pytest.mark.parametrize(
    ("too_long", "bends"), [((), True), (("rigid",), True), (("bent",), False), (("all",), False)]
)
def test_facets_that_crawl_bend_where_that_is_no_more_work_than_is_done(
    too_long: tuple[str, ...], bends: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """too_long: to be taken without a word, of rigid facets and so of all; of bending ones; to be taken at all, of
    bending ones. What takes a while anyway may as well bend."""
    path = fold_corpus.write(tmp_path / "vertex.fold", fold_corpus.miura(2, 2))
    monkeypatch.setattr(
        "lamc.readers.fold_sheet.obstacle", lambda sheet: "crawls" if len(sheet.bodies) == 4 else ""
    )
    rigid = Limits(hinges=4, closing=10**6, numbers=10**6)
    few = {"rigid": 3, "bent": 4, "all": 3}
    soon = rigid._replace(hinges=min((few[each] for each in too_long), default=100))
    monkeypatch.setattr("lamc.readers.fold_sheet.SOON", soon)
    monkeypatch.setattr(
        "lamc.readers.fold_sheet.MOST", rigid._replace(hinges=4 if "all" in too_long else 100)
    )
    sheet, notes = read(path)
    assert len(sheet.bodies) == (8 if bends else 4)
    assert any(("left rigid" in note) is not bends for note in notes if "crawls" in note)


def test_facets_bend_around_a_hole_whose_creases_do_not_meet(tmp_path: Path) -> None:
    """Four creases, as a pinwheel, are a loop of six equations: more than four, so that nothing moves."""
    outer = [(0, 0), (20, 0), (40, 0), (40, 20), (40, 40), (20, 40), (0, 40), (0, 20)]
    inner = [(12, 12), (28, 12), (28, 28), (12, 28)]
    rim = [(k, (k + 1) % 8, "B") for k in range(8)] + [(8 + k, 8 + (k + 1) % 4, "B") for k in range(4)]
    creases = [(2 * k + 1, 8 + k, "MV"[k % 2]) for k in range(4)]
    lines = rim + creases
    faces = [[2 * k + 1, (2 * k + 2) % 8, (2 * k + 3) % 8, 8 + (k + 1) % 4, 8 + k] for k in range(4)]
    data = {
        "file_spec": 1.1,
        "frame_unit": "mm",
        "vertices_coords": [*outer, *inner],
        "edges_vertices": [line[:2] for line in lines],
        "edges_assignment": [line[2] for line in lines],
        "faces_vertices": faces,
    }
    path = fold_corpus.write(tmp_path / "pinwheel.fold", data)
    sheet, notes = read(path)
    assert any("nothing moves while facets are rigid: they bend" in note for note in notes)
    assert len(sheet.bodies) == 12
    assert lamc.compile(sheet).run(0.01).success


@pytest.mark.parametrize(("least", "bends"), [(2e-8, True), (2e-4, False)])
def test_facets_bend_where_rounding_alone_holds_rigid_ones(
    least: float, bends: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As of a pleated square with one corner off by a pixel: its loops move exactly, and crawl. Here by what is counted
    of a sheet that folds: at a tenth of a radian."""
    counted = LoopCount(4, 24, 11, 1, (2.0, 1.0, least), branch_ranks=(11,), position=(0.1,) * 12)
    monkeypatch.setattr("lamc.readers.fold_bending.loops_of", lambda tree, scene: counted)
    sheet, _ = read(fold_corpus.write(tmp_path / "miura.fold", fold_corpus.miura(4, 3)), facets="rigid")
    assert ("would crawl" in obstacle(sheet)) == bends


def test_creases_that_move_anyway_do_not_hide_those_that_crawl(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A vertex of four creases has more hinges than equations: whether something moves is not all that is asked."""
    sheet, _ = read(fold_corpus.write(tmp_path / "vertex.fold", fold_corpus.miura(2, 2)), facets="rigid")
    assert len(sheet.joints) == 4
    counted = LoopCount(1, 6, 3, 1, (2.0, 1.0, 2e-8), branch_ranks=(3,), position=(0.1,) * 4)
    monkeypatch.setattr("lamc.readers.fold_bending.loops_of", lambda tree, scene: counted)
    assert "would crawl" in obstacle(sheet)

    def refused(tree: object, scene: object) -> LoopCount:
        raise DesignError("more free rates than branches are looked for")

    monkeypatch.setattr("lamc.readers.fold_bending.loops_of", refused)
    assert obstacle(sheet) == NOWHERE


def test_facets_bend_where_nobody_knows_how_rigid_ones_begin(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As of a rounded sheet of hundreds of creases, of whose ways out of the plane none goes on: it is no way out to be
    refused by the compiler. Here by what is counted of a vertex whose four sectors are no triangles."""

    def rigid_refused(tree: Tree, scene: Scene) -> LoopCount:
        if len(tree.hinges) == 4:
            raise DesignError("none of the ways that were tried goes on")
        return loops_of(tree, scene)

    path = fold_corpus.write(tmp_path / "vertex.fold", fold_corpus.miura(2, 2))
    monkeypatch.setattr("lamc.readers.fold_bending.loops_of", rigid_refused)
    sheet, notes = read(path)
    assert len(sheet.bodies) == 8
    assert any(f"{NOWHERE}: they bend" in note for note in notes)
