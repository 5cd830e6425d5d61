"""A file that would take minutes to read, split or mesh is refused first, by work that is counted and not timed."""

import ast
import math
import random
import re
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import shapely
from shapely.geometry import LineString, Polygon

from lamc import examples
from lamc.basics.errors import DesignError, LamcError
from lamc.design import cutting, split, work
from lamc.design.split import split as split_design
from lamc.plates import followed
from lamc.plates.designs import overlay
from lamc.readers.load import load
from lamc.readers.plates import follow, problem_make
from lamc.readers.plates.problem_file import plate_of_text
from lamc.readers.plates.problem_make import problem_of
from lamc.records.design import Design
from lamc.records.mechanism import Joint
from lamc.records.network import faults
from tests.unit import test_popupcad as cads
from tests.unit.test_popupcad_forms import FROM, internal, line_sketch

HEAD = """\
kind: design
units: mm
materials:
  card: {density: 0.7 g/cm^3, rigid: true}
  film: {density: 1.4 g/cm^3, flexible: true}
"""
LAYERS = [
    "{name: lower, material: card, thickness: 0.3}",
    "{name: film, material: film, thickness: 0.05}",
    "{name: upper, material: card, thickness: 0.3}",
]
SHEET = "rect: [0, 0, 100, 100]"
HINGE = "{line: [[50, 0], [50, 100]], gap: 0.4}"


def listed(name: str, entries: Sequence[str]) -> str:
    return f"{name}:\n" + "".join(f"  - {entry}\n" for entry in entries)


def drawn(
    folder: Path,
    shapes: Sequence[str] = (SHEET,),
    hinges: Sequence[str] = (HINGE,),
    layers: Sequence[str] = LAYERS,
) -> Path:
    parts = (listed("layers", layers), listed("shapes", shapes), listed("hinges", hinges))
    file = folder / "drawn.yaml"
    file.write_text(HEAD + "".join(parts) + "fixed:\n  - rect: [1, 1, 9, 9]\n", encoding="utf-8")
    return file


def comb(teeth: int, *, lying: bool) -> str:
    points = [(0.0, 0.0)]
    for k in range(teeth):
        a, b, c = (100.0 * (k + part) / teeth for part in (0.0, 0.5, 1.0))
        points += [(a, 100.0), (b, 100.0), (b, 1.0), (c, 1.0)]
    points += [(100.0, 0.0)]
    return f"polygon: {[[y, x] if lying else [x, y] for x, y in points]}"


def line(a: tuple[float, float], b: tuple[float, float], width: float) -> str:
    return f"{{line: [[{a[0]}, {a[1]}], [{b[0]}, {b[1]}]], gap: {2 * width}}}"


def bundle(count: int, width: float) -> list[str]:
    """Hinge lines through one point."""
    rotations = [math.pi * k / count for k in range(count)]
    ends = [(40.0 * math.cos(t), 40.0 * math.sin(t)) for t in rotations]
    return [line((50 + x, 50 + y), (50 - x, 50 - y), width) for x, y in ends]


def test_outlines_that_cross_too_often_are_refused_before_they_are_joined(tmp_path: Path) -> None:
    """Two combs of 200 teeth have 160 000 crossings; overlaying them took over a minute."""
    file = drawn(tmp_path, [comb(200, lying=False), f"{{cut: {{{comb(200, lying=True)}}}}}"])
    with pytest.raises(
        DesignError, match=rf"drawn.yaml:11:.*'lower'.* {work.MOST_CROSSINGS} crossings.*fewer"
    ):
        load(file)


def test_hinge_strips_that_meet_too_often_are_refused_before_they_are_cut(tmp_path: Path) -> None:
    """400 lines through a point: 79 800 pairs meet; cutting them took over 40 s."""
    design = load(drawn(tmp_path, hinges=bundle(400, 0.2)))
    with pytest.raises(DesignError, match=rf"drawn.yaml:13:.*400 hinge lines.* {work.MOST_MEETINGS} .*gap"):
        split_design(design)  # type: ignore[arg-type]


def test_more_layers_than_any_laminate_has_are_refused_at_their_line(tmp_path: Path) -> None:
    layers = [f"{{name: s{k}, material: card, thickness: 0.1}}" for k in range(3000)]
    file = drawn(
        tmp_path, ["{rect: [0, 0, 1, 1], layers: [" + ", ".join(f"x{k}" for k in range(3000)) + "]}"]
    )
    text = file.read_text(encoding="utf-8").replace(listed("layers", LAYERS), listed("layers", layers))
    file.write_text(text, encoding="utf-8")
    with pytest.raises(
        DesignError, match=r"drawn.yaml:\d+:.*layers: the design has 3000 layers; at most 200"
    ) as found:
        load(file)
    assert len(str(found.value).splitlines()) == 1  # and no layer's name was looked for among 3000 others


@pytest.mark.slow
def test_thousands_of_cuts_are_joined_and_cut_in_one_go(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """One difference per run of cuts and set of layers that are alike; cut by cut, 500 circles took 29 s."""
    calls = []
    joined = shapely.union_all
    monkeypatch.setattr(shapely, "union_all", lambda parts: calls.append(len(parts)) or joined(parts))
    spots = [(5 + 3 * (k % 30), 5 + 3 * (k // 30)) for k in range(600)]
    cuts = [f"{{cut: {{circle: {{center: [{x}, {y}], radius: 0.7}}}}}}" for x, y in spots]
    design = load(drawn(tmp_path, [SHEET, *cuts]))
    assert isinstance(design, Design)
    assert len(design.layers[0].geometry.geoms[0].interiors) == 600
    assert design.layers[0].geometry.area == pytest.approx(
        1e-2 - 600 * math.pi * 0.7e-3**2, rel=1e-9
    )  # circles are drawn with their true areas; nine digits of 10^4 corners' round-off
    assert calls.count(600) == 1  # not once per layer


def test_layers_that_are_alike_are_cut_along_the_same_slits(tmp_path: Path) -> None:
    design = load(drawn(tmp_path))
    assert isinstance(design, Design)
    steps = split.split_steps(design)
    assert steps.slits[0] is steps.slits[1] is steps.slits[2]


def test_hinges_between_the_same_bodies_are_compared_by_arrays() -> None:
    """Of 3000 hinges between two bodies, on one line, the last is the first again."""
    joints = [Joint(f"h{k}", "a", "b", point=[float(k % 2999), 0, 0], axis=[1, 0, 0]) for k in range(3000)]
    reported = [str(fault.error) for fault in faults([], joints) if "same hinge" in str(fault.error)]
    assert len(reported) == 1
    assert "'h0' and 'h2999'" in reported[0]


def test_the_examples_and_a_miura_fold_of_256_plates_are_well_within_the_limits(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """16 × 16 plates have 225 vertices with 6 pairs of strips each, and 480 hinges."""
    counted: list[int] = []
    meetings, crossings = work._meetings, work._crossings

    def counted_meetings(*given: Any, **near: Any) -> Any:
        pairs = meetings(*given, **near)
        counted.append(len(pairs))
        return pairs

    def counted_crossings(*given: Any) -> int:
        counted.append(crossings(*given))
        return counted[-1]

    monkeypatch.setattr(work, "_meetings", counted_meetings)
    monkeypatch.setattr(work, "_crossings", counted_crossings)
    at = {(i, j): (6 * i + 1.5 * (j % 2), 6.0 * j) for i in range(17) for j in range(17)}
    pairs = [((i, j), (i + 1, j)) for i in range(16) for j in range(1, 16)]
    pairs += [((i, j), (i, j + 1)) for i in range(1, 16) for j in range(16)]
    rim = [at[i, 0] for i in range(17)] + [at[16, j] for j in range(1, 17)]
    rim += [at[i, 16] for i in range(15, -1, -1)] + [at[0, j] for j in range(15, 0, -1)]
    hinges = [line(at[a], at[b], 0.2) for a, b in pairs]
    design = load(drawn(tmp_path, [f"polygon: {[list(point) for point in rim]}"], hinges))
    cutting.holes_per_layer(split.named_hinges(design), len(design.layers))  # type: ignore[arg-type]
    assert counted[-2:] == [6 * 225, 15 * 225]
    for name in examples.files():
        record = load(examples.path(name))
        if isinstance(record, Design):
            split_design(record)
    assert max(counted) <= work.MOST_CROSSINGS / 3


def test_lines_through_one_place_are_refused_before_their_holes_are_joined(tmp_path: Path) -> None:
    """100 lines through a point: 4950 pairs meet, within that limit, and all these areas lie on one another; joining
    them took a minute."""
    design = load(drawn(tmp_path, hinges=bundle(100, 0.2)))
    with pytest.raises(DesignError, match=rf"drawn.yaml:13:.*4950 areas.* {work.MOST_OVERLAPS} .*gap"):
        split_design(design)  # type: ignore[arg-type]


def test_meetings_are_each_pair_once_in_order() -> None:
    """Squares in a row, of which neighbours meet, and a cluster of 30: against all pairs looked at one by one."""
    squares = [shapely.box(2.0 * k, 0.0, 2.0 * k + 2.0, 1.0) for k in range(300)]
    squares += [shapely.box(0.1 * k, 50.0, 0.1 * k + 5.0, 55.0) for k in range(30)]
    found = work._meetings(np.array(squares), 10_000)
    expected = [(a, b) for a in range(330) for b in range(a + 1, 330) if squares[a].intersects(squares[b])]
    assert found.tolist() == [list(pair) for pair in expected]
    assert len(work._meetings(np.array(squares), 100)) > 100


NUMBER = re.compile(r"(?<![\w.])-?\d+(?:\.\d+)?(?![\w.])")


def mutant(text: str, dice: random.Random) -> str:
    """One number changed by decades, or one entry of a list drawn 200 times, each a little elsewhere."""
    lines = text.splitlines()
    entries = [k for k, each in enumerate(lines) if each.lstrip().startswith("- ") and NUMBER.search(each)]
    at = dice.choice(entries)

    def moved(found: re.Match[str]) -> str:
        return repr(float(found.group()) * dice.uniform(0.2, 1.8))

    if dice.random() < 0.4:
        lines[at : at + 1] = [NUMBER.sub(moved, lines[at]) for _ in range(200)]
    else:
        spot = dice.choice(list(NUMBER.finditer(lines[at])))
        changed = repr(float(spot.group()) * 10.0 ** dice.randint(-6, 6))
        lines[at] = lines[at][: spot.start()] + changed + lines[at][spot.end() :]
    return "\n".join(lines)


@pytest.mark.campaign
def test_mutated_examples_overlay_no_more_than_the_limits(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Whatever passes the count has no more meetings than it allows; whatever does not is refused with a message."""
    passed: list[int] = []
    count = work.Account.overlay

    def counting(account: work.Account, *given: object) -> None:
        count(account, *given)  # type: ignore[arg-type]
        passed.append(account.crossings)

    monkeypatch.setattr(work.Account, "overlay", counting)
    reported: list[str] = []
    dice = random.Random(12)
    files = [name for name in examples.files() if examples.path(name).suffix == ".yaml"]
    file = tmp_path / "mutant.yaml"
    for _ in range(40):
        name = dice.choice(files)
        file.write_text(mutant(examples.path(name).read_text(encoding="utf-8"), dice), encoding="utf-8")
        try:
            record = load(file)
            if isinstance(record, Design):
                split_design(record)
        except LamcError as error:
            reported.append(str(error))
    assert all(reported)
    assert passed
    assert max(passed) <= work.MOST_CROSSINGS


def plate_text(geometry: str) -> str:
    return (
        "kind: plate\nunits: mm\nlaminate: {material: steel, thickness: 1}\n"
        f"geometry: {{{geometry}}}\nsupports: [{{clamped: left}}]\nloads: [{{pressure: 1 Pa}}]\n"
    )


@pytest.mark.parametrize(
    "geometry",
    [
        "rect: [0, 0, 100, 100], grid: [1000, 200]",
        "polygon: [[0, 0], [100, 0], [100, 100], [0, 100]], size: 0.3",
    ],
)
def test_plate_files_of_more_cells_than_the_limit_are_refused_before_they_are_meshed(
    geometry: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(problem_make, "check_memory", lambda *_given, **_named: None)  # of any machine
    file = plate_of_text(plate_text(geometry), "x.yaml")
    with pytest.raises(DesignError, match=rf"x.yaml:4:.*the limit is {problem_make.MOST}: take"):
        problem_of(file)


def test_a_plate_file_of_50_000_cells_is_meshed() -> None:
    file = plate_of_text(plate_text("rect: [0, 0, 100, 100], grid: [250, 100]"), "x.yaml")
    assert len(problem_of(file).mesh.cells) == 50_000


def test_what_a_support_holds_is_grown_edge_by_edge(monkeypatch: pytest.MonkeyPatch) -> None:
    """A chain of hundreds of edges in one go took ten seconds of a mesh of 11 000 cells."""
    corners: list[int] = []
    grow = followed.shapely.buffer

    def counting(shape: object, *given: object, **named: object) -> object:
        corners.append(int(shapely.get_num_coordinates(shape).max()))
        return grow(shape, *given, **named)

    monkeypatch.setattr(followed.shapely, "buffer", counting)
    rim = "clamped: {line: [[0, 0], [120, 80], [0, 80], [0, 0]]}"
    text = plate_text("polygon: [[0, 0], [120, 0], [120, 80], [0, 80]], size: 4").replace(
        "clamped: left", rim
    )
    problem_of(plate_of_text(text, "x.yaml"))
    assert corners.count(2) > 0
    assert max(corners) < 20  # the outline and the lines themselves, but no chain of the mesh's edges


# --- popupCAD, plates, and the start of a process -----------------------------------------------------------------


def cad_sketch(number: int, kind: str, points: Sequence[tuple[float, float]]) -> str:
    exterior = [[k, x, y] for k, (x, y) in enumerate(points, 1)]
    return cads.sketch(number, f"{kind} {{construction: false, exterior: {exterior}, id: {number}}}")


def comb_points(teeth: int, *, lying: bool) -> list[tuple[float, float]]:
    return [tuple(point) for point in ast.literal_eval(comb(teeth, lying=lying).removeprefix("polygon: "))]


def cad_of_combs(teeth: int, operation: str) -> str:
    sketches = "".join(
        cad_sketch(201 + lying, cads.POLY, comb_points(teeth, lying=lying)) for lying in (0, 1)
    )
    drawn = cads.sketch_operation(5, 201) + cads.sketch_operation(6, 202)
    return cads.cad(drawn + operation, parent=7, sketches=sketches)


@pytest.mark.quick("intersection")
@pytest.mark.parametrize("function", ["union", "intersection", "difference", "symmetric_difference"])
def test_popupcad_laminates_that_cross_too_often_are_refused_at_their_operation(function: str) -> None:
    """Two combs of 200 teeth: over a minute, and gigabytes."""
    second = "[[6, 0]]" if "difference" in function else "[]"
    first = "[[5, 0]]" if "difference" in function else "[[5, 0], [6, 0]]"
    for teeth in (10, 200):
        text = cad_of_combs(teeth, cads.laminate_operation(7, function, first, second))
        if teeth == 10:
            assert cads.areas(cads.read(text))[0] > 0.0
            continue
        reported = rf"given.cad:\d+:\d+: operation 'op 7': .*{function} cross .*{work.MOST_CROSSINGS} crossings .*fewer"
        with pytest.raises(DesignError, match=reported):
            cads.read(text)


@pytest.mark.slow
def test_popupcad_buffers_wider_than_what_they_grow_are_counted() -> None:
    """A comb of 800 teeth grown by 80 of their widths: 10 s. Smooth outlines are simplified first, and cost nothing."""
    text = cad_of_combs(800, cads.buffer_operation(7, 5, "[10.0, 5]"))
    with pytest.raises(
        DesignError, match=r"operation 'op 7': sides .* come within 20 mm of each other \d+ times"
    ):
        cads.read(text)
    rotations = [2.0 * math.pi * k / 4000 for k in range(4000)]
    round_one = cad_sketch(201, cads.POLY, [(50 * math.cos(t), 50 * math.sin(t)) for t in rotations])
    drawn = cads.sketch_operation(5, 201) + cads.buffer_operation(7, 5, "[100.0, 5]")
    grown = cads.areas(cads.read(cads.cad(drawn, parent=7, sketches=round_one)))
    assert grown[0] == pytest.approx(math.pi * 150.0**2, rel=0.01)  # 20 segments around


def test_popupcad_hinge_lines_that_cross_too_often_are_refused_before_they_are_parted() -> None:
    """300 lines through a point, of which each parts all others."""
    rotations = [math.pi * k / 300 for k in range(300)]
    ends = [((40 * math.cos(t), 40 * math.sin(t)), (-40 * math.cos(t), -40 * math.sin(t))) for t in rotations]
    lines = [
        f"{cads.LINE} {{construction: false, exterior: [[1, {a}, {b}], [2, {c}, {d}]], id: {k}}}"
        for k, ((a, b), (c, d)) in enumerate(ends)
    ]
    text = cads.cad(sketches=cads.sketch(104, *lines)).replace("sketch: 102", "sketch: 104")
    with pytest.raises(DesignError, match=r"given.cad:\d+:\d+: the hinge lines cross each other"):
        cads.read(text)


@pytest.mark.slow
def test_popupcad_layers_are_bounded_before_they_are_read() -> None:
    head, layers, rest = re.split(
        r"(?<=layers:\n)(.*?)(?=operations:)", cads.cad(), maxsplit=1, flags=re.DOTALL
    )
    with pytest.raises(
        DesignError, match=r"given.cad:\d+:\d+: the design has 2000 layers; at most 200 .*join"
    ):
        cads.read(head + 1000 * layers + rest)


def test_a_laminate_placed_a_thousand_times_is_joined_in_one_go(monkeypatch: pytest.MonkeyPatch) -> None:
    """One after another they cost the square of their number."""
    joined: list[int] = []
    join = shapely.union_all
    monkeypatch.setattr(
        shapely, "union_all", lambda parts, **how: joined.append(len(parts)) or join(parts, **how)
    )
    lines = [f"[1, {50 * k}, 0], [2, {50 * k + 10}, 0]" for k in range(1000)]
    text = cads.cad(internal(), parent=7, sketches=FROM + line_sketch(202, *lines))
    once = cads.cad(internal(), parent=7, sketches=FROM + line_sketch(202, lines[0]))
    assert cads.areas(cads.read(text)) == pytest.approx(
        [1000 * area for area in cads.areas(cads.read(once))], rel=1e-9
    )
    assert joined.count(1000) == 1  # for both layers, which are alike


def test_a_folded_hinge_line_of_a_plate_is_refused_before_it_is_cut_at_the_outline() -> None:
    """2000 corners on one line, to and fro: minutes."""
    along = [[10.0 + 80.0 * ((k * 7919) % 2000) / 2000, 50] for k in range(2000)]
    text = (
        plate_text("rect: [0, 0, 100, 100], size: 5")
        + f"hinges: [{{along: {{line: {along}}}, stiffness: 1}}]\n"
    )
    with pytest.raises(
        DesignError, match=r"x.yaml:7:\d+: hinges\[0\].along: .*cross each other .*20000 crossings"
    ):
        plate_of_text(text, "x.yaml")


def test_layers_of_a_plate_that_cross_each_other_too_often_are_refused_before_they_are_overlaid() -> None:
    """No layer crosses itself, so that splitting is little work."""
    combs = [shapely.MultiPolygon([Polygon(comb_points(200, lying=lying))]) for lying in (False, True)]
    with pytest.raises(DesignError, match=r"outlines of the plate's layers cross each other"):
        overlay.overlay(combs, 1e-3)
    assert len(overlay.overlay([combs[0]] * 40, 1e-3).regions) == 1


def test_the_number_of_places_of_a_plate_is_bounded() -> None:
    """2000 supports, all at the left, took 7 s on a mesh of 1600 cells, and would on 100 times as many cells 500."""
    text = plate_text("rect: [0, 0, 100, 100], size: 5").replace("clamped: left}", "clamped: left}, " * 600)
    text = text.replace("clamped: left}, ", "clamped: left}, {", 599).replace("}, ]", "}]")
    with pytest.raises(
        DesignError, match=r"x.yaml:5:\d+: supports: .* 601 holes, regions, supports, .*at most 500 .*join"
    ):
        plate_of_text(text, "x.yaml")


def test_supports_beside_outlines_of_many_corners_are_bounded() -> None:
    """Each support is cut at everything that is drawn, and so costs all its corners."""
    rotations = [2.0 * math.pi * k / 4000 for k in range(4000)]
    rim = [[round(50 * math.cos(t), 9), round(50 * math.sin(t), 9)] for t in rotations]
    for count, fits in ((2, True), (60, False)):
        supports = ", ".join(f"{{clamped: {{point: [{k - 30}, 0]}}}}" for k in range(count))
        text = plate_text(f"polygon: {rim}, size: 5").replace("[{clamped: left}]", f"[{supports}]")
        file = plate_of_text(text, "x.yaml")
        if fits:
            follow.to_follow([s.where for s in file.supports], file.geometry.outline, [])
            continue
        with pytest.raises(
            DesignError, match=r"x.yaml:4:.*60 places .*4061 corners .*more than 200000 steps.*grid"
        ):
            problem_of(file)


def test_crossings_are_counted_as_they_cost() -> None:
    """A grid of lines crosses; lines that meet in their ends, and the same line twice, do not; nor do neighbours."""

    def counted(*lines: Sequence[tuple[float, float]]) -> int:
        account = work.Account()
        account.overlay([LineString(points) for points in lines], "lines")
        return account.crossings

    grid = [[(k, -1), (k, 9)] for k in range(9)] + [[(-1, k), (9, k)] for k in range(9)]
    assert counted(*grid) == 81 + (18 + 2 * 81) // work._LOOKS
    assert counted([(0, 0), (1, 0)], [(1, 0), (1, 1)], [(1, 0), (2, 5)], [(0, 0), (1, 0)]) == 0
    assert counted([(0, 0), (2, 0)], [(1, 0), (3, 0)]) == 1
    assert counted([(0, 0), (3, 0), (1, 0), (2, 0)]) == 3  # one line, folded on itself
    account = work.Account()
    squares = [shapely.box(k, k, k + 1.5, k + 1.5) for k in range(3)]
    account.overlay(squares, "squares")
    assert account.crossings == 4


def test_reading_and_splitting_imports_nothing_of_numpy_that_waits() -> None:
    """numpy.ma takes as long to import as a small design to be read; `np.unique` imports it."""
    words = (
        "import lamc, sys; from lamc.examples import path\n"
        "for name in ('folding_box', 'pendulum.cad'): lamc.split(lamc.load(path(name)))\n"
        "print('numpy.ma' in sys.modules)"
    )
    reported = subprocess.run([sys.executable, "-c", words], capture_output=True, text=True, check=True)
    assert reported.stdout.strip() == "False"


def through_the_middle(count: int) -> list[LineString]:
    at = [math.pi * k / count for k in range(count)]
    ends = [(40 * math.cos(t), 40 * math.sin(t)) for t in at]
    return [LineString([(50 + x, 50 + y), (50 - x, 50 - y)]) for x, y in ends]


def test_places_beside_each_other_are_held_against_each_other_without_shapes_of_them(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Bands around 80 lines through a point took 51 s to join, and those around a comb of 280 took ten."""
    sizes: list[int] = []
    grow = shapely.buffer
    monkeypatch.setattr(
        shapely,
        "buffer",
        lambda shape, *given, **named: (
            sizes.append(int(shapely.get_num_coordinates(shape))) or grow(shape, *given, **named)
        ),
    )
    plate = shapely.box(0, 0, 100, 100)
    found = follow.to_follow(through_the_middle(80), plate, [])
    assert sizes == [5]  # the plate, once
    # Each line beyond the first two is parted by what is there, and by nothing but round-off at the middle.
    assert 159 <= len(found) < 300
    comb = [LineString([(k, 5), (k, 95)]) for k in range(1, 100)]
    assert [line.wkt for line in follow.to_follow(comb, plate, [])] == [line.wkt for line in comb]


@pytest.mark.slow
def test_places_that_cut_each_other_into_too_many_parts_are_refused() -> None:
    steps = [1 + 98 * k / 79 for k in range(80)]
    lines = [f"{{line: [[1, {s}], [99, {s}]]}}" for s in steps] + [
        f"{{line: [[{s}, 1], [{s}, 99]]}}" for s in steps
    ]
    supports = ", ".join(f"{{simply_supported: {each}}}" for each in lines)
    text = plate_text("rect: [0, 0, 100, 100], size: 5").replace("[{clamped: left}]", f"[{supports}]")
    with pytest.raises(DesignError, match=r"x.yaml:4:.*cut into more than 5000 parts.*fewer of them cross"):
        problem_of(plate_of_text(text, "x.yaml"))
