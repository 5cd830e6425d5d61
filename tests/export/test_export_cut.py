"""Cut files: what they leave is the design that was simulated, in real size, closed, and the same bytes each time."""

import io
import json
import math
import warnings
from collections.abc import Mapping
from itertools import combinations
from pathlib import Path
from xml.etree import ElementTree

import ezdxf
import numpy as np
import pytest
import shapely
import svgelements
from ezdxf.entities import LWPolyline
from shapely.geometry import LineString, MultiPolygon, Polygon

import lamc
from lamc import examples
from lamc.basics import yaml_text
from lamc.basics.errors import DesignWarning, ExportError, UnsupportedError
from lamc.design.split import split_steps
from lamc.export import files_of
from lamc.export.cut import notes as notes_of
from lamc.export.cuts.perforated import dashes_of
from lamc.export.cuts.plan import difference, plan_of
from lamc.export.options import options_from
from lamc.readers.load import load_text
from lamc.readers.native_writer import design_text
from lamc.records.design import Design
from tests.support import fold_corpus as corpus

DESIGNS = [
    name for name in examples.names() if name not in ("bricard", "stiff_triple", "n_four_bar")
]  # mechanisms
# Coordinates in mm of m are a rounding or two off: of areas some 1e-16 of the box about them, relative.
SAME = 1e-9
Line = tuple[str, bool, np.ndarray]


def example(name: str) -> Design:
    found = examples.find(name)
    design = lamc.load(found.path) if found.path is not None else load_text(found.text, name)
    assert isinstance(design, Design)
    return design


def cut(design: lamc.Design | lamc.Mechanism, **options: object) -> Mapping[str, bytes]:
    return files_of(design, "cut", options=options_from(**options))


def dxf_lines(data: bytes) -> list[Line]:
    """Layer, whether it is closed, points in m."""
    document = ezdxf.read(io.StringIO(data.decode("cp1252")))
    assert document.header["$INSUNITS"] == 4
    assert not document.audit().has_errors
    found = []
    for entity in document.modelspace():
        assert isinstance(entity, LWPolyline)
        found.append((entity.dxf.layer, entity.closed, 1e-3 * np.array(entity.get_points("xy"))))
    return found


def svg_lines(data: bytes) -> list[Line]:
    """The same of SVG; y runs down the page.

    Paths are read one by one: of a page in mm svgelements takes an inch for 25.39999 mm."""
    root = ElementTree.fromstring(data.decode())
    _, _, width, height = root.attrib["viewBox"].split()
    assert (root.attrib["width"], root.attrib["height"]) == (f"{width}mm", f"{height}mm")  # 1 is 1 mm
    found = []
    for group in root.iterfind("{*}g"):
        name = group.attrib["{http://www.inkscape.org/namespaces/inkscape}label"]
        for element in group:
            path = svgelements.Path(element.attrib["d"])
            points = [(s.end.x, s.end.y) for s in path if not isinstance(s, svgelements.Close)]
            found.append((name, isinstance(path[-1], svgelements.Close), 1e-3 * np.array(points)))
    return found


def area(lines: list[Line]) -> float:
    """m² within outlines, less holes; every one closed."""
    rings = [
        (name, is_closed, points) for name, is_closed, points in lines if name in ("1_holes", "3_outline")
    ]
    assert all(is_closed for _, is_closed, _ in rings)
    return math.fsum((-1.0 if name == "1_holes" else 1.0) * Polygon(points).area for name, _, points in rings)


def parts(lines: list[Line]) -> MultiPolygon:
    outlines = shapely.union_all([Polygon(p) for name, _, p in lines if name == "3_outline"])
    holes = shapely.union_all([Polygon(p) for name, _, p in lines if name == "1_holes"])
    found = shapely.difference(outlines, holes)
    return MultiPolygon(list(shapely.get_parts(found)))


@pytest.mark.parametrize("name", ["flaps", "four_bar", "waterbomb", "folding_box", "pendulum"])
def test_files_read_back_with_the_areas_of_the_simulated_bodies(name: str) -> None:
    design = example(name)
    made = cut(design)
    steps = split_steps(design)
    report = json.loads(made["cut.json"])
    total = 0.0
    for k, (layer, row) in enumerate(zip(design.layers, report["layers"], strict=True)):
        drawings = dxf_lines(made[f"{row['file']}.dxf"]), svg_lines(made[f"{row['file']}.svg"])
        assert len(drawings[0]) == len(drawings[1])
        z = design.z[k]
        # Bodies as simulated: film at hinges is none of theirs, since it is taken to weigh on neither side.
        bodies = math.fsum(
            s.polygon.area for b in steps.mechanism.bodies for s in b.outline if s.z_bottom == z
        )
        slits = 0.0
        if layer.material.is_flexible:
            bent = [h for h in steps.hinges if h.properties.layer == k]
            grown = shapely.union_all([shapely.buffer(h.line, 0.1 * h.properties.width) for h in bent])
            slits = float(shapely.intersection(grown, plan_of(design).layers[k].parts).area)
        for lines in drawings:
            assert area(lines) == pytest.approx(bodies + slits, rel=SAME)
            assert area(lines) == pytest.approx(row["area"], rel=SAME)
        total += row["area"] * layer.thickness * layer.material.density
    assert total == pytest.approx(math.fsum(row["mass"] for row in report["layers"]), rel=SAME)


@pytest.mark.parametrize("name", ["flaps", "four_bar", "folding_box"])
def test_a_design_of_its_cut_files_is_the_simulated_device(tmp_path: Path, name: str) -> None:
    """Through lamc's reader of DXF: what a cutter gets is drawn anew, and split."""
    design = example(name)
    folder = lamc.export(design, "cut", out=tmp_path)
    data = yaml_text.scalar  # names and numbers
    text = design_text(design).splitlines()
    start, end = (next(k for k, line in enumerate(text) if line == word) for word in ("shapes:", "hinges:"))
    shapes = [
        f"  - {{shape: {{file: {data(path.name)}, heal: 0}}, layers: {data(layer.name)}}}"
        for layer, path in zip(design.layers, sorted(folder.glob("*.dxf")), strict=True)
    ]
    (tmp_path / "again.yaml").write_text(
        "\n".join([*text[: start + 1], *shapes, *text[end:]]), encoding="utf-8"
    )
    again = lamc.load(tmp_path / "again.yaml")
    made, drawn = lamc.split(again), lamc.split(design)
    assert [body.name for body in made.bodies] == [body.name for body in drawn.bodies]
    for one, other in zip(made.bodies, drawn.bodies, strict=True):
        assert difference(one, other, drawn.size) <= SAME
    assert [(j.name, j.parent, j.child) for j in made.joints] == [
        (j.name, j.parent, j.child) for j in drawn.joints
    ]


def test_drawings_of_layers_lie_over_one_another() -> None:
    made = cut(example("four_bar"))
    apart = [
        np.mean([p.mean(axis=0) * (1.0, -1.0) for *_, p in svg_lines(made[name])], axis=0)
        - np.mean([p.mean(axis=0) for *_, p in dxf_lines(made[name.replace(".svg", ".dxf")])], axis=0)
        for name in sorted(made)
        if name.endswith(".svg")
    ]
    np.testing.assert_allclose(apart, [apart[0]] * len(apart), rtol=0.0, atol=1e-12)


@pytest.mark.parametrize("name", DESIGNS)
@pytest.mark.quick("pendulum", "four_bar", "folding_box", "yoshimura", others="campaign")
def test_what_is_left_is_the_simulated_device(name: str) -> None:
    design = example(name)
    plan = plan_of(design)
    assert plan.largest_difference <= SAME
    for body in plan.drawn.bodies:
        assert plan.left.body(body.name).mass == pytest.approx(body.mass, rel=SAME)
    assert "bodies that the cuts leave are those that are simulated" in "\n".join(notes_of(cut(design)))


def test_the_film_stays_whole_and_boards_are_cut() -> None:
    made = cut(example("waterbomb"))
    assert len(parts(dxf_lines(made["2_film.dxf"])).geoms) == 1
    assert len(parts(dxf_lines(made["1_lower_board.dxf"])).geoms) == 6


CREASED = """
units: mm
materials: {card: {density: 700, E1: 3 GPa, E2: 3 GPa, poisson: 0.3, flexible: true}}
layers: [{name: card, material: card, thickness: 0.3}]
shapes: [{polygon: [[0, 0], [90, 0], [90, 40], [0, 40]]}, {cut: {rect: [55, 10, 65, 20]}}]
hinges:
  - {name: valley, line: [[30, 40], [30, 0]], gap: 0.4, stiffness: 4e-5, rest_angle: 1.2}
  - {name: mountain, line: [[60, 40], [60, 0]], gap: 0.4, stiffness: 4e-5, rest_angle: -1.2}
fixed: [{rect: [0, 0, 10, 40]}]
"""


@pytest.mark.parametrize("kerf", [0.0, 1e-4])
def test_creases_of_a_layer_that_bends_by_itself_are_drawn_to_be_scored(kerf: float) -> None:
    """There had been outlines alone, and what is cut of them cannot fold."""
    design = load_text(CREASED, "creased")
    assert isinstance(design, Design)
    made = cut(design, kerf=kerf)
    lines = dxf_lines(made["1_card.dxf"])
    scored = sorted(sorted(points.tolist()) for layer, _, points in lines if layer == "2_creases")
    # 30 mm less the window of the second.
    expected = [[[0.03, 0.0], [0.03, 0.04]], [[0.06, 0.0], [0.06, 0.01]], [[0.06, 0.02], [0.06, 0.04]]]
    assert np.allclose(
        scored, expected, rtol=0.0, atol=1e-12
    )  # m: round-off of mm, some 1e-17, and of pieces
    assert "drawn to be scored (3 lines)" in "\n".join(notes_of(made))
    assert not any(layer == "2_creases" for layer, _, _ in dxf_lines(cut(example("waterbomb"))["2_film.dxf"]))
    dashed = cut(design, hinge_style="perforated")
    assert {layer for layer, _, _ in dxf_lines(dashed["1_card.dxf"])} == {"1_holes", "2_slits", "3_outline"}


def test_boards_over_a_gap_are_told_and_cut_by_it_when_asked() -> None:
    design = example("waterbomb")
    as_drawn, by_gap = cut(design), cut(design, hinge_width="gap")
    assert any("boards reach into the gap of" in line for line in notes_of(as_drawn))
    assert not any("boards reach" in line for line in notes_of(by_gap))
    assert any("not those that are simulated" in line for line in notes_of(by_gap))
    wide = parts(dxf_lines(by_gap["1_lower_board.dxf"]))
    for hinge_set in design.hinges:
        for hinge in hinge_set.lines:
            strip = shapely.buffer(LineString(hinge.line), hinge_set.width, cap_style="flat")
            assert wide.intersection(strip).area <= 1e-9 * strip.area


def test_a_length_is_the_width_of_slits() -> None:
    made = cut(example("waterbomb"), hinge_width="3 mm")
    board = parts(dxf_lines(made["1_lower_board.dxf"]))
    near = [board.distance(LineString(line.line)) for h in example("waterbomb").hinges for line in h.lines]
    assert near == pytest.approx(
        [1.5e-3] * len(near), rel=0.01
    )  # caps of 32 corners stand half a per cent in


def test_kerf_moves_outlines_out_and_holes_in() -> None:
    kerf = 0.1e-3
    design = example("four_bar")
    plain, made = cut(design), cut(design, kerf="0.1 mm")
    for name in plain:
        if name.endswith(".dxf"):
            drawn, moved = parts(dxf_lines(plain[name])), parts(dxf_lines(made[name]))
            assert moved.area > drawn.area
            eaten = shapely.buffer(moved, -kerf / 2, join_style="mitre", mitre_limit=10.0)
            # 1e-6: offsets of the round caps, of some um at gaps' ends, are of their corners.
            assert shapely.symmetric_difference(eaten, drawn).area <= 1e-6 * drawn.area
    assert notes_of(plain)[:5] == notes_of(made)[:5]  # areas and masses are those before the kerf


@pytest.mark.parametrize("name", ["flaps", "waterbomb", "folding_box", "five_bar", "kresling"])
def test_a_beam_as_wide_as_the_kerf_leaves_the_parts(name: str) -> None:
    """All lines are run along by a disc; what it does not touch within the outlines is what was to be cut."""
    kerf = 0.1e-3
    design = example(name)
    made = cut(design, kerf=kerf)
    for layer, row in zip(plan_of(design).layers, json.loads(made["cut.json"])["layers"], strict=True):
        lines = dxf_lines(made[f"{row['file']}.dxf"])
        assert not any(each == "2_slits" for each, *_ in lines)  # none of these is as narrow
        runs = [LineString(np.vstack([p, p[:1]]) if is_closed else p) for _, is_closed, p in lines]
        left = shapely.difference(
            parts(lines), shapely.buffer(shapely.union_all(runs), kerf / 2, quad_segs=32)
        )
        wrong = shapely.symmetric_difference(left, layer.parts).area
        # In each inward corner the disc leaves a fillet of at most (1 - pi/4) r^2, more where the corner is sharp.
        assert wrong <= len(shapely.get_coordinates(layer.parts)) * (kerf / 2) ** 2


def test_slits_narrower_than_the_kerf_are_cut_once_and_part_their_boards() -> None:
    kerf = 0.5e-3  # the drawn gap is 0.4 mm wide
    made = cut(example("flaps"), kerf=kerf)
    lines = dxf_lines(made["1_lower.dxf"])
    slits = [LineString(p) for name, _, p in lines if name == "2_slits"]
    assert len(slits) == 2
    beam = shapely.union_all([shapely.buffer(line, kerf / 2) for line in slits])
    assert len(shapely.get_parts(shapely.difference(parts(lines), beam))) == 3
    assert any("2 slits of hinges are no wider than the kerf of 500 um" in line for line in notes_of(made))


def test_a_gap_as_wide_as_the_kerf_is_cut_once() -> None:
    """Of such a gap the offsets leave slivers of no width, which are no holes."""
    made = cut(example("kresling"), kerf="1 mm")
    lines = dxf_lines(made["1_lower.dxf"])
    assert not [name for name, *_ in lines if name == "1_holes"]
    beam = shapely.union_all(
        [shapely.buffer(LineString(p), 0.5e-3) for name, _, p in lines if name == "2_slits"]
    )
    drawn = plan_of(example("kresling")).layers[0].parts
    assert len(shapely.get_parts(shapely.difference(parts(lines), beam))) == len(drawn.geoms)


def test_parts_that_the_kerf_leaves_in_one_are_refused_with_the_place() -> None:
    design = example("four_bar")  # its boards lie in lanes 2 mm apart
    with pytest.raises(ExportError, match=r"two parts of layer '\w+' are .* less than the kerf of 2500 um"):
        cut(design, kerf="2.5 mm")


def test_corners_that_meet_where_parts_are_a_kerf_apart_become_round() -> None:
    """Boards of the four-bar have corners 1.005 mm from each other, and sharp offsets of them cross."""
    lines = dxf_lines(cut(example("four_bar"), kerf="1 mm")["2_lower_board.dxf"])
    slits = [LineString(p) for name, _, p in lines if name == "2_slits"]
    beam = shapely.union_all([shapely.buffer(line, 0.5e-3) for line in slits])
    assert len(shapely.get_parts(shapely.difference(parts(lines), beam))) == 3


def test_a_slit_that_ends_in_a_part_is_not_lengthened_by_the_kerf() -> None:
    """The stroke's line ends where the wing's holder goes on: it is cut no farther than simulated."""
    design = example("flapping_wing")
    made = cut(design, kerf="25 um")  # slits are 20 and 14 um wide
    slits = [LineString(p) for name, _, p in dxf_lines(made["1_frame.dxf"]) if name == "2_slits"]
    assert len(slits) >= 1
    inside = shapely.buffer(split_steps(design).cut[0], -1e-9)
    assert not any(shapely.intersects(slit, inside) for slit in slits)


def square_with_hole(width: float) -> Design:
    board = lamc.Material("board", 1000.0, is_rigid=True)
    film = lamc.Material("film", 1000.0, is_flexible=True)
    from lamc.records.design import HingeLine, HingeSet, Layer

    window = shapely.box(2e-3, 2e-3, 2e-3 + width, 5e-3)
    sheet = shapely.difference(shapely.box(0, 0, 20e-3, 10e-3), window)
    layers = tuple(
        Layer(n, m, 1e-4, MultiPolygon([sheet])) for n, m in (("board", board), ("film <&>", film))
    )
    hinge = HingeSet((HingeLine(((10e-3, 0.0), (10e-3, 10e-3)), "h"),), 2e-4, 1, (0, 1))
    fixed = MultiPolygon([shapely.box(0, 0, 1e-3, 1e-3)])
    return Design("a/b <&>", layers, (hinge,), (fixed, MultiPolygon()))


def test_holes_that_the_kerf_closes_are_told_with_their_place() -> None:
    notes = notes_of(cut(square_with_hole(0.05e-3), kerf="0.1 mm"))
    assert any("'board': narrower than the kerf, and not cut: (2.025, 3.5) mm" in line for line in notes)
    assert not any("not cut" in line for line in notes_of(cut(square_with_hole(0.5e-3), kerf="0.1 mm")))


def test_names_are_text_in_every_file() -> None:
    made = cut(square_with_hole(0.5e-3))
    assert sorted(made) == sorted(
        ["1_board.dxf", "1_board.svg", "2_film.dxf", "2_film.svg", "README.md", "cut.json"]
    )
    for name, data in made.items():
        if name.endswith(".svg"):
            slit = 0.4e-6 if "board" in name else 0.0
            assert area(svg_lines(data)) == pytest.approx(200e-6 - 1.5e-6 - slit, rel=SAME)


def test_castellated_boards_have_tabs_to_the_line_by_turns() -> None:
    design = example("flaps")
    board = parts(dxf_lines(cut(design, hinge_style="castellated, 2 mm")["1_lower.dxf"]))
    assert len(board.geoms) == 3
    along = np.arange(6) * 2e-3 + 1e-3  # the middle of each of six tabs on 12 mm
    sides = [shapely.contains_xy(board, -20e-3 + s * 0.1e-3, y) for y in along for s in (-1.0, 1.0)]
    assert sum(sides) == 6
    assert all(left != right for left, right in zip(sides[::2], sides[1::2], strict=True))
    assert [sides[2 * k] for k in range(6)] in ([True, False] * 3, [False, True] * 3)
    gaps = [a.distance(b) for a, b in combinations(board.geoms, 2)]
    assert min(gaps) >= 0.04e-3 * (1.0 - 1e-6)  # a tenth of half the gap to either side of the line


def test_tabs_leave_room_for_the_kerf_or_are_refused() -> None:
    made = cut(example("flaps"), hinge_style="castellated", kerf="0.1 mm")
    assert len(parts(dxf_lines(made["1_lower.dxf"])).geoms) == 3
    with pytest.raises(ExportError, match=r"between tabs of hinge 'left' there is no room for the kerf"):
        cut(example("flaps"), hinge_style="castellated", kerf="0.3 mm")


def test_perforations_are_half_of_the_line_with_film_at_both_ends() -> None:
    made = cut(example("flaps"), hinge_style="perforated, 1 mm")
    dashes = [p for name, _, p in dxf_lines(made["2_film.dxf"]) if name == "2_slits"]
    assert len(dashes) == 24  # two hinges of 12 mm
    assert sum(math.dist(*dash) for dash in dashes) == pytest.approx(12e-3, rel=SAME)
    assert min(dash[:, 1].min() for dash in dashes) == pytest.approx(0.25e-3, rel=SAME)
    assert area(dxf_lines(made["2_film.dxf"])) == pytest.approx(1320e-6, rel=SAME)


def test_all_layers_have_the_same_frame_and_pins() -> None:
    options = {"stock": "300mm x 200mm", "pins": "3 mm", "kerf": "0.1 mm"}
    made = cut(example("four_bar"), **options)
    shared = []
    for name in sorted(made):
        if name.endswith(".dxf"):
            lines = dxf_lines(made[name])
            frame = [p for layer, _, p in lines if layer == "4_reference"]
            pins = [Polygon(p) for layer, _, p in lines if layer == "1_holes" and len(p) == 128]
            assert np.ptp(frame[0], axis=0) == pytest.approx([0.3, 0.2])
            # 2.9 mm wide: the cutter takes 0.05 mm around
            assert [pin.area for pin in pins] == pytest.approx([math.pi * 1.45e-3**2] * 4, rel=SAME)
            middles = np.array([pin.centroid.coords[0] for pin in pins])
            turned = 2.0 * middles.mean(axis=0) - middles
            assert not all(min(math.dist(a, b) for b in middles) < 1e-3 for a in turned)
            shared.append(middles)
            whole = parts(lines).bounds
            assert min(whole[0], whole[1]) > 0.0
            assert whole[2] < 0.3
    assert all(np.array_equal(each, shared[0]) for each in shared)
    svg = made["1_lower_film.svg"].decode()
    assert 'width="300mm" height="200mm" viewBox="0 0 300 200"' in svg
    plain = json.loads(cut(example("four_bar"))["cut.json"])
    assert plain["layers"] == json.loads(made["cut.json"])["layers"]


def test_a_sheet_that_is_too_small_is_refused_with_what_it_needs() -> None:
    with pytest.raises(ExportError, match=r"--sheet \(stock\) is 100 mm x 20 mm; .* need 110 mm x 12 mm"):
        cut(example("flaps"), stock=(0.1, 0.02))
    with pytest.raises(ExportError, match=r"turned by 90 degrees"):
        cut(example("flaps"), stock=(0.02, 0.12))
    with pytest.raises(ExportError, match=r"--pins \(pins\) is 0.05 mm, no wider than the kerf"):
        cut(example("flaps"), pins="50 um", kerf="0.1 mm")


@pytest.mark.parametrize(
    ("options", "reported"),
    [
        ({"hinge_style": "wavy"}, "must be gap, castellated or perforated"),
        ({"hinge_style": "gap, 2 mm"}, "must be gap"),
        ({"hinge_width": "0 mm"}, "must be above 0"),
        ({"kerf": -1e-4}, "at least 0"),
        ({"kerf": math.nan}, "finite"),
        ({"kerf": 0.1}, r"is 100 mm, and more than 5 mm is not cut.* write '0\.1 mm'"),
        ({"stock": "300 x 200"}, "write '300 mm'"),
        ({"pins": 3}, "write '3 mm'"),
        ({"hinge_width": "1"}, "write '1 mm'"),
        ({"pins": 0}, "must be above 0"),
        ({"stock": "300 mm"}, "must be width and height"),
        ({"stock": "300 kg x 2 mm"}, "width of --sheet"),
        ({"lossy": True}, "cut has no use for it"),
    ],
)
def test_options_that_make_no_sense_are_refused(options: dict[str, object], reported: str) -> None:
    with pytest.raises(ExportError, match=reported):
        cut(example("flaps"), **options)


def test_a_scene_makes_no_cut() -> None:
    with pytest.raises(ExportError, match="nothing moves"):
        files_of(example("flaps"), "cut", lamc.Scene())


def test_the_same_design_gives_the_same_bytes(tmp_path: Path) -> None:
    before = ezdxf.options.write_fixed_meta_data_for_testing
    options = {"kerf": "0.1 mm", "stock": "300mm x 200mm", "pins": 3e-3}
    first, second = cut(example("flaps"), **options), cut(example("flaps"), **options)
    assert first == second
    assert ezdxf.options.write_fixed_meta_data_for_testing is before
    text = first["1_lower.dxf"].decode("cp1252")
    assert "{00000000-0000-0000-0000-000000000000}" in text  # no random identifier
    lamc.export(example("flaps"), "cut", out=tmp_path / "out", **options)
    assert (tmp_path / "out" / "1_lower.dxf").read_bytes() == first["1_lower.dxf"]


def sheet(data: corpus.Data, folder: Path) -> lamc.Mechanism:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DesignWarning)
        made = lamc.load(corpus.write(folder / "sheet.fold", data))
    assert isinstance(made, lamc.Mechanism)
    return made


def test_a_sheet_of_creases_is_outline_and_creases(tmp_path: Path) -> None:
    made = cut(sheet(corpus.miura(3, 3), tmp_path))
    for lines in (dxf_lines(made["sheet.dxf"]), svg_lines(made["sheet.svg"])):
        (border,) = [(closed, p) for name, closed, p in lines if name == "border"]
        assert border[0]
        assert Polygon(border[1]).area == pytest.approx(
            9 * corpus.ALONG * corpus.ACROSS * math.sin(corpus.ACUTE) * 1e-6, rel=SAME
        )
        kinds = [name.split("_")[0] for name, *_ in lines]
        assert (kinds.count("mountain"), kinds.count("valley")) == (6, 6)
    assert any(name == "mountain_-60" for name, *_ in dxf_lines(made["sheet.dxf"]))
    assert 'stroke-opacity="0.3333333333333333"' in made["sheet.svg"].decode()


def test_a_slit_in_a_sheet_is_a_cut(tmp_path: Path) -> None:
    data = corpus.box_net()
    hinge = data["edges_assignment"].index("V")
    data["edges_assignment"][hinge], data["edges_foldAngle"][hinge] = "C", None
    made = sheet(data, tmp_path)
    lines = dxf_lines(cut(made)["sheet.dxf"])
    names = [name for name, *_ in lines]
    assert names.count("cut") == 1
    assert sum(name.startswith("valley") for name in names) == 4
    # A kerf moves outlines, and a cut, which has two sides, stays.
    beside = dxf_lines(cut(made, kerf="0.2 mm")["sheet.dxf"])
    (slit,), (same,) = ([p for name, _, p in each if name == "cut"] for each in (lines, beside))
    assert np.array_equal(slit, same)
    text = (
        "1 cut is cut once, along the line, and no kerf is allowed for there: what lies beside loses 100 um"
    )
    assert any(text in note for note in notes_of(cut(made, kerf="0.2 mm")))
    assert not any("cut once" in note for note in notes_of(cut(made)))


def test_kerf_and_dashes_of_a_sheet(tmp_path: Path) -> None:
    made = sheet(corpus.waterbomb(), tmp_path)
    lines = dxf_lines(cut(made, kerf="0.2 mm", hinge_style="perforated, 2 mm")["sheet.dxf"])
    (border,) = [Polygon(p) for name, _, p in lines if name == "border"]
    assert border.area == pytest.approx((80.2e-3) ** 2, rel=SAME)
    dashes = [p for name, _, p in lines if name.startswith(("mountain", "valley"))]
    length = 4 * math.hypot(40e-3, 40e-3) + 80e-3
    drawn = 0.5 * length - 0.2e-3 * len(dashes)  # the cutter takes a kerf at each, half of it at either end
    assert sum(math.dist(*dash) for dash in dashes) == pytest.approx(drawn, rel=SAME)


@pytest.mark.parametrize("kerf", [0.1e-3, 0.45e-3])
def test_perforations_leave_half_of_a_line_whatever_the_kerf(kerf: float, tmp_path: Path) -> None:
    """Of what the cutter takes away, by shapely: the card stays in one piece, and half of each crease stays."""
    made = sheet(corpus.waterbomb(), tmp_path)
    lines = dxf_lines(cut(made, kerf=kerf, hinge_style="perforated, 1 mm")["sheet.dxf"])
    gone = shapely.union_all(
        [LineString(p).buffer(0.5 * kerf) for name, _, p in lines if name.startswith(("mountain", "valley"))]
    )
    card = shapely.box(-40e-3, -40e-3, 40e-3, 40e-3)
    assert isinstance(card.difference(gone), Polygon)
    for end in ((40e-3, 40e-3), (-40e-3, 0.0)):
        crease = LineString([(0.0, 0.0), end])
        assert crease.difference(gone).length == pytest.approx(
            0.5 * crease.length, rel=0.02
        )  # at the middle, all meet


def test_a_kerf_that_would_take_all_bridges_is_refused(tmp_path: Path) -> None:
    with pytest.raises(
        ExportError, match=r"around \(20, 20\) mm perforations cut 0.496 mm .* takes 0.6 mm: take a longer"
    ):
        cut(sheet(corpus.waterbomb(), tmp_path), kerf="0.6 mm", hinge_style="perforated, 1 mm")
    with pytest.raises(ExportError, match=r"one perforation would cut .* the line is too short for it"):
        dashes_of(LineString([(0.0, 0.0), (0.35e-3, 0.0)]), 9e-3, 0.2e-3, "along hinge 'x'")
    with pytest.raises(ExportError, match=r"along hinge '.*' perforations cut .* take a longer pitch"):
        cut(example("flaps"), kerf="0.6 mm", hinge_style="perforated, 1 mm")


def test_lines_along_which_facets_bend_are_not_cut(tmp_path: Path) -> None:
    path = corpus.write(tmp_path / "sheet.fold", corpus.miura(2, 2))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DesignWarning)
        made = lamc.load(path, facets="bend")
    assert isinstance(made, lamc.Mechanism)
    assert (len(made.joints), len(made.facet_creases)) == (8, 4)
    files = cut(made)
    names = [name.split("_")[0] for name, *_ in dxf_lines(files["sheet.dxf"])]
    assert len(names) == 5
    assert set(names) == {"border", "mountain", "valley"}
    assert any(
        "the 4 lines along which they do are not drawn" in note
        for note in json.loads(files["cut.json"])["notes"]
    )


def test_a_width_is_as_wide_as_what_is_simulated_at_least() -> None:
    with pytest.raises(ExportError, match=r"0.001 mm is narrower than the slit of .* simulated at hinge '"):
        cut(example("waterbomb"), hinge_width="0.001 mm")
    # Boards that are drawn farther apart have no slit.
    notes = json.loads(cut(example("flaps"), hinge_width="0.01 mm")["cut.json"])["notes"]
    assert any("it cuts nothing there" in each for each in notes)


def test_a_width_that_cuts_nothing_is_told() -> None:
    notes = json.loads(cut(example("folding_box"), hinge_width="0.1 mm")["cut.json"])["notes"]
    assert any(
        "are drawn farther apart than --hinge-width says: it cuts nothing there" in each for each in notes
    )
    assert not any("a tenth of the gap" in each for each in notes)


def test_the_outline_of_a_sheet_is_cut_last(tmp_path: Path) -> None:
    text = cut(sheet(corpus.waterbomb(), tmp_path))["README.md"].decode()
    assert text.index("| `hole` |") < text.index("| `cut` |") < text.index("| `border` |")
    assert "3_outline" not in text
    assert "3_outline" in cut(example("flaps"))["README.md"].decode()


def test_a_piece_in_a_window_is_cut_out_and_refused_where_the_kerf_is_wider_than_its_gap(
    tmp_path: Path,
) -> None:
    path = tmp_path / "sheet.svg"
    path.write_text(
        '<svg xmlns="http://www.w3.org/2000/svg" width="100mm" height="100mm" viewBox="0 0 100 100" fill="none">'
        '<rect x="10" y="10" width="80" height="80" stroke="black"/><path d="M10 30H90" stroke="red"/>'
        '<rect x="30" y="40" width="40" height="40" stroke="black"/>'
        '<rect x="31" y="41" width="38" height="38" stroke="black"/></svg>'
    )
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DesignWarning)
        made = lamc.load(path, card=lamc.Card(), crease=1e-3)
    assert isinstance(made, lamc.Mechanism)
    lines = dxf_lines(cut(made, kerf="0.2 mm")["sheet.dxf"])
    found = sorted((name, 1e6 * Polygon(p).area) for name, _, p in lines if name in ("border", "hole"))
    assert [name for name, _ in found] == ["border", "border", "hole"]
    assert [area for _, area in found] == pytest.approx([38.2**2, 80.2**2, 39.8**2], rel=SAME)
    with pytest.raises(
        ExportError, match=r"two pieces of the sheet are 1000 um from each other at \(69.5, -41\) mm"
    ):
        cut(made, kerf="1.5 mm")


def test_what_is_no_sheet_is_told(tmp_path: Path) -> None:
    flaps = lamc.split(example("flaps"))
    bare = lamc.Mechanism(flaps.bodies, flaps.joints, "bare")  # without its drawing
    with pytest.raises(UnsupportedError, match=r"no sheet of creases.*layers of several heights"):
        cut(bare)
    with pytest.raises(ExportError, match="boards beside hinges"):
        cut(sheet(corpus.waterbomb(), tmp_path), hinge_style="castellated")


def test_a_child_to_the_right_of_its_axis_folds_the_other_way(tmp_path: Path) -> None:
    made = sheet(corpus.folded_pair(0.7), tmp_path)
    joint = made.joints[0]
    turned = lamc.Joint(
        joint.name,
        joint.child,
        joint.parent,
        joint.point,
        joint.axis,
        joint.stiffness,
        joint.damping,
        joint.rest_angle,
    )
    same = lamc.Joint(
        joint.name,
        joint.parent,
        joint.child,
        joint.point,
        -joint.axis,
        joint.stiffness,
        joint.damping,
        -joint.rest_angle,
    )
    for other, is_mountain in ((joint, False), (same, False), (turned, True)):
        lines = dxf_lines(cut(lamc.Mechanism(made.bodies, (other,), "pair"))["pair.dxf"])
        assert any(name.startswith("mountain") for name, *_ in lines) == is_mountain
        assert any(name.startswith("valley") for name, *_ in lines) != is_mountain


def drawn_sheet(folder: Path, body: str) -> lamc.Mechanism:
    """60 mm x 20 mm, with a mountain across at x = 20 mm; more lines as SVG, y down."""
    path = folder / "drawn.svg"
    path.write_text(
        '<svg xmlns="http://www.w3.org/2000/svg" width="60mm" height="20mm" viewBox="0 0 60 20" fill="none">'
        f'<rect width="60" height="20" stroke="black"/><path d="M20 0V20" stroke="red"/>{body}</svg>'
    )
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DesignWarning)
        made = lamc.load(path, card=lamc.Card(), crease=1e-3)
    assert isinstance(made, lamc.Mechanism)
    return made


def test_windows_of_a_sheet_that_the_kerf_closes_are_told_with_their_place(tmp_path: Path) -> None:
    """As those of a laminate are."""
    made = drawn_sheet(tmp_path, '<rect x="40" y="9.96" width="8" height="0.08" stroke="black"/>')
    notes = notes_of(cut(made, kerf="0.2 mm"))
    assert any("sheet: narrower than the kerf, and not cut: (44, -10) mm" in line for line in notes)
    assert not any("not cut" in line for line in notes_of(cut(made, kerf="0.05 mm")))


def test_a_crease_is_one_line_past_windows_beside_it(tmp_path: Path) -> None:
    """Facets around a window are parted by level lines, which end on creases that nobody parted."""
    made = drawn_sheet(tmp_path, '<circle cx="40" cy="10" r="3" stroke="black"/>')
    lines = dxf_lines(cut(made)["drawn.dxf"])
    (crease,) = [p for name, _, p in lines if name.startswith("mountain")]
    assert sorted(crease[:, 1]) == pytest.approx([-20e-3, 0.0], abs=1e-15)
    # One that another crease meets is of two pieces, which fold by themselves.
    met = drawn_sheet(tmp_path, '<path d="M0 10H20" stroke="blue"/>')
    assert sum(name.startswith("mountain") for name, *_ in dxf_lines(cut(met)["drawn.dxf"])) == 2


@pytest.mark.parametrize(
    ("body", "parts"),
    [
        ("", 1),
        ('<path d="M40 0V20" stroke="lime"/>', 2),
        ('<path d="M40 0V12" stroke="lime"/>', 1),
        ('<path d="M40 0V20M50 0V20" stroke="lime"/>', 3),
        ('<circle cx="40" cy="10" r="3" stroke="black"/><path d="M40 0V7" stroke="lime"/>', 1),
        ('<circle cx="40" cy="10" r="3" stroke="black"/><path d="M40 0V7M40 13V20" stroke="lime"/>', 2),
    ],
)
def test_parts_are_counted_by_what_cuts_part(tmp_path: Path, body: str, parts: int) -> None:
    report = json.loads(cut(drawn_sheet(tmp_path, body))["cut.json"])
    assert [layer["parts"] for layer in report["layers"]] == [parts]


def test_perforations_keep_a_bridge_beside_a_window() -> None:
    """Each piece of film along the line has its own dashes, as pieces of a crease of a sheet have."""
    board = lamc.Material("board", 1000.0, is_rigid=True)
    film = lamc.Material("film", 1000.0, is_flexible=True)
    from lamc.records.design import HingeLine, HingeSet, Layer

    window = shapely.box(8e-3, 10e-3, 12e-3, 20e-3)
    shape = MultiPolygon([shapely.difference(shapely.box(0, 0, 20e-3, 30e-3), window)])
    layers = tuple(Layer(n, m, 1e-4, shape) for n, m in (("board", board), ("film", film)))
    hinge = HingeSet((HingeLine(((10e-3, 0.0), (10e-3, 30e-3)), "h"),), 2e-4, 1, (0, 1))
    design = Design("w", layers, (hinge,), (MultiPolygon([shapely.box(0, 0, 1e-3, 1e-3)]), MultiPolygon()))
    made = cut(design, hinge_style="perforated, 3 mm", kerf="0.1 mm")
    dashes = [p for name, _, p in dxf_lines(made["2_film.dxf"]) if name == "2_slits"]
    reach = sorted((1e3 * float(p[:, 1].min()) - 0.05, 1e3 * float(p[:, 1].max()) + 0.05) for p in dashes)
    assert len(reach) == 6  # three along each piece of 10 mm
    for low, high in ((0.0, 10.0), (20.0, 30.0)):
        ends = [each for each in reach if low <= each[0] < high]
        assert ends[0][0] - low == pytest.approx(high - ends[-1][1], rel=1e-6)
        assert ends[0][0] - low == pytest.approx(10.0 / 12.0, rel=1e-6)  # a quarter of a pitch


def test_a_line_that_bounds_nothing_is_told_to_be_missing(tmp_path: Path) -> None:
    (tmp_path / "slit.svg").write_text(
        '<svg xmlns="http://www.w3.org/2000/svg" width="100mm" height="50mm" viewBox="0 0 100 50">'
        '<path stroke="black" fill="none" d="M0 0H100V50H0Z"/><path stroke="red" stroke-opacity=".5" d="M50 0V50"/>'
        '<path id="slit" stroke="#00ff00" d="M10 10H30"/></svg>'
    )
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DesignWarning)
        made = cut(lamc.load(tmp_path / "slit.svg"))
    (note,) = [line for line in notes_of(made) if "bounds nothing" in line]
    assert "a line that bounds nothing is not in these files, at (20, -10) mm, path #slit" in note


@pytest.mark.parametrize("x", [10, 11, 12, 13])
def test_a_slit_as_wide_as_the_kerf_is_one_line(x: int) -> None:
    """What was left of the offsets by round-off was a cut of no length."""
    text = f"""
name: k
units: mm
materials: {{card: {{density: 700, rigid: true}}, film: {{density: 1390, flexible: true}}}}
layers: [{{name: low, material: card, thickness: 0.5}}, {{name: hinge, material: film, thickness: 0.05}}]
shapes: [{{rect: [0, 0, 60, 12]}}]
hinges: [{{name: j1, line: [[{x}, 0], [{x}, 12]], layer: hinge, gap: 1, stiffness: 1e-3}}]
fixed: [{{rect: [0, 0, 5, 12]}}]
"""
    design = load_text(text, "k.yaml")
    assert isinstance(design, Design)
    made = cut(design, kerf=1e-4)
    slits = [line for line in dxf_lines(made["1_low.dxf"]) if line[0] == "2_slits"]
    (note,) = [line for line in notes_of(made) if "no wider than the kerf" in line]
    assert "1 slit of a hinge is no wider than the kerf of 100 um" in note
    assert len(slits) == 1
