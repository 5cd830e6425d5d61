"""A file that would take minutes to read, split or mesh is refused first, by work that is counted and not timed."""

import math
import random
import re
from collections.abc import Sequence
from pathlib import Path

import pytest
import shapely

from lamc import examples
from lamc.basics.errors import DesignError, LamcError
from lamc.design import split, work
from lamc.design.split import split as split_design
from lamc.plates import followed
from lamc.readers import native
from lamc.readers.load import load
from lamc.readers.plates import problem_make
from lamc.readers.plates.problem_file import plate_of_text
from lamc.readers.plates.problem_make import problem_of
from lamc.records.design import Design
from lamc.records.mechanism import Joint
from lamc.records.network import faults

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
HINGE = "{line: [[50, 0], [50, 100]], width: 0.2}"


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
    return f"{{line: [[{a[0]}, {a[1]}], [{b[0]}, {b[1]}]], width: {width}}}"


def bundle(count: int, width: float) -> list[str]:
    """Hinge lines through one point."""
    turns = [math.pi * k / count for k in range(count)]
    ends = [(40.0 * math.cos(t), 40.0 * math.sin(t)) for t in turns]
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
    with pytest.raises(DesignError, match=rf"drawn.yaml:13:.*400 hinge lines.* {work.MOST_MEETINGS} .*width"):
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


def test_thousands_of_cuts_are_joined_and_cut_in_one_go(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """One difference per run of cuts and set of layers that are alike; cut by cut, 500 circles took 29 s."""
    calls = []
    joined = native.shapely.union_all
    monkeypatch.setattr(native.shapely, "union_all", lambda parts: calls.append(len(parts)) or joined(parts))
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
    told = [str(fault.error) for fault in faults([], joints) if "same hinge" in str(fault.error)]
    assert len(told) == 1
    assert "'h0' and 'h2999'" in told[0]


def test_the_examples_and_a_miura_fold_of_256_plates_are_well_within_the_limits(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """16 × 16 plates have 225 vertices with 6 pairs of strips each, and 480 hinges."""
    counted: list[int] = []
    count = work._meetings
    monkeypatch.setattr(work, "_meetings", lambda *given: counted.append(count(*given)) or counted[-1])
    at = {(i, j): (6 * i + 1.5 * (j % 2), 6.0 * j) for i in range(17) for j in range(17)}
    pairs = [((i, j), (i + 1, j)) for i in range(16) for j in range(1, 16)]
    pairs += [((i, j), (i, j + 1)) for i in range(1, 16) for j in range(16)]
    rim = [at[i, 0] for i in range(17)] + [at[16, j] for j in range(1, 17)]
    rim += [at[i, 16] for i in range(15, -1, -1)] + [at[0, j] for j in range(15, 0, -1)]
    hinges = [line(at[a], at[b], 0.2) for a, b in pairs]
    design = load(drawn(tmp_path, [f"polygon: {[list(point) for point in rim]}"], hinges))
    work.check_strips(split.strips_of(split.named_hinges(design)), None)  # type: ignore[arg-type]
    assert 6 * 225 <= counted[-1] <= work.MOST_MEETINGS / 3
    for name in examples.files():
        record = load(examples.path(name))
        if isinstance(record, Design):
            split_design(record)
    assert max(counted) <= work.MOST_MEETINGS / 3


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


def test_mutated_examples_overlay_no_more_than_the_limits(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Whatever passes the count has no more meetings than it allows; whatever does not is refused with a message."""
    passed: list[int] = []
    count = work._meetings

    def counting(shapes: object, owner: object, most: int) -> int:
        found = count(shapes, owner, most)  # type: ignore[arg-type]
        if found <= most:
            passed.append(found)
        return found

    monkeypatch.setattr(work, "_meetings", counting)
    told: list[str] = []
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
            told.append(str(error))
    assert all(told)
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
