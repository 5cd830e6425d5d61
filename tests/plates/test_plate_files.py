"""Plate files: what is written is what is computed with, and whatever else a file holds is reported at its place."""

import math
import re
import time
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from shapely.geometry import LineString, Point, Polygon

import lamc
from lamc import examples
from lamc.basics.errors import DesignError, DesignErrors, ExpressionError, LamcError
from lamc.examples import plates as plate_examples
from lamc.plates.laminates.laminate import Laminate
from lamc.plates.laminates.library import material
from lamc.plates.laminates.plies import Ply
from lamc.plates.loads import (
    EdgeLoad,
    EdgeMoment,
    ElectricField,
    Moisture,
    PointLoad,
    Pressure,
    SelfWeight,
    Temperature,
)
from lamc.plates.supports import Clamped, Hinged, SimplySupported, Symmetry
from lamc.readers.plates.expression import Field, depends_on_place, number
from lamc.readers.plates.problem_file import load_plate, plate_of_text
from lamc.readers.plates.problem_make import problem_of
from lamc.readers.plates.problem_records import PlateFile
from lamc.readers.plates.problem_schema import PlateFileModel
from lamc.readers.schema import FILES, json_schema
from lamc.report.plate_marks import load_text
from tests.support.quick import tries

PATIENCE = 5.0  # s; a second is the promise, and the machine may be busy with other tests
FEW = settings(
    max_examples=tries(60), deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)

BASE = """\
kind: plate
units: mm
laminate: {material: steel, thickness: 1}
geometry: {rect: [0, 0, 200, 100], grid: [4, 2]}
"""


def read(more: str = "", base: str = BASE) -> PlateFile:
    return plate_of_text(base + more, "plate.yaml")


def problems(more: str = "", base: str = BASE) -> list[str]:
    """The lines of the error that reading the text gives."""
    with pytest.raises(LamcError) as caught:
        read(more, base)
    error = caught.value
    return [str(p) for p in error.problems] if isinstance(error, DesignErrors) else [str(error)]


def single(file: PlateFile) -> tuple[object, ...]:
    return tuple(file.cases[""])


# --- what is written is what is meant -----------------------------------------------------------------------------


def test_bare_lengths_count_in_the_files_units_and_others_say_their_own() -> None:
    file = read("outputs: [{at: [10, 2 cm]}]\n")
    assert file.geometry.outline.bounds == (0.0, 0.0, 0.2, 0.1)
    assert file.outputs[0].at == (0.01, 0.02)
    assert file.laminate is not None
    assert file.laminate.thickness == 0.001


def test_a_layup_is_the_same_laminate_as_its_plies() -> None:
    sheet = "material: steel, thickness: 1"
    layup = read(base=BASE.replace(sheet, "material: T300/5208, layup: '[0/90/45]', ply: 0.125"))
    angled = "{material: T300/5208, thickness: 125 um, angle: %d deg}"
    entries = ", ".join(angled % angle for angle in (0, 90, 45))
    plies = read(base=BASE.replace(sheet, f"plies: [{entries}]"))
    by_hand = Laminate([Ply(material("T300/5208"), 125e-6, angle) for angle in (0.0, 90.0, 45.0)])
    for file in (layup, plies):
        assert file.laminate is not None
        assert np.array_equal(file.laminate.ABD, by_hand.ABD)


def test_degrees_of_a_ply_are_exact() -> None:
    """30° through radians and back is 29.999999999999996°."""
    file = read(base=BASE.replace("thickness: 1}", "thickness: 1, angle: 30 deg}"))
    assert file.laminate is not None
    assert file.laminate.plies[0].angle == 30.0


def test_materials_of_ones_own_go_before_those_of_the_library() -> None:
    file = read(
        "materials: {steel: {E: 100 GPa, nu: 0.25, density: 1 g/cm^3, alpha: 1e-5 K^-1, Xt: 200 MPa}}\n"
    )
    assert file.laminate is not None
    own = file.laminate.plies[0].material
    assert (own.E1, own.nu12, own.density, own.alpha2, own.Xt) == (100e9, 0.25, 1000.0, 1e-5, 200e6)


def test_each_kind_of_support_becomes_its_record() -> None:
    file = read(
        "regions: {spot: {circle: {center: [50, 50], radius: 10}}}\n"
        "supports:\n"
        "  - clamped: left\n"
        "  - {simply_supported: boundary, kind: soft}\n"
        "  - symmetry: {line: [[0, 0], [200, 0]]}\n"
        "  - clamped: {region: spot}\n"
        "  - {fixed: [w], where: {point: [200, 100]}, value: 2}\n"
        "  - {fixed: [w_x, w_y], where: top, value: 0.01}\n"
        "  - {hinged: right, stiffness: 3 N*mm/mm/rad}\n"
        '  - {fixed: [w], where: bottom, value: "2*x/200"}\n'
    )
    left, soft, symmetry, spot, pushed, rotated, hinge, ramp = file.supports
    assert isinstance(left, Clamped)
    assert left.where == LineString([(0, 0), (0, 0.1)])
    assert isinstance(soft, SimplySupported)
    assert (soft.where, soft.kind) == ("boundary", "soft")
    assert isinstance(symmetry, Symmetry)
    assert isinstance(spot.where, Polygon)
    assert spot.where.area == pytest.approx(math.pi * 1e-4, rel=1e-12)  # discs keep their area
    assert (pushed.where, pushed.dofs, pushed.value) == (Point(0.2, 0.1), ("w",), 0.002)
    assert (rotated.dofs, rotated.value) == (("w_x", "w_y"), 0.01)
    assert isinstance(hinge, Hinged)
    assert hinge.stiffness == 3.0
    assert ramp.value(np.array([0.1]), np.zeros(1)) == pytest.approx([0.001], rel=1e-14)  # mm, as x


def test_each_kind_of_load_becomes_its_record() -> None:
    file = read(
        "loads:\n"
        "  - {point: [100, 50], force: 2 mN}\n"
        "  - {point: [100, 50], force: [1, 0, -2 kN]}\n"
        "  - {edge: right, force: 0.5 N/mm}\n"
        "  - {edge: right, moment: 3 N}\n"
        "  - {pressure: 2 kPa}\n"
        "  - gravity: [0, 0, -9.81]\n"
        "  - temperature: -150 K\n"
        "  - moisture: 0.01\n"
        "  - field: 0.5 kV/mm\n"
    )
    down, pulled, edge, moment, pressure, weight, cold, wet, field = single(file)
    assert isinstance(down, PointLoad)
    assert (down.at, tuple(down.force)) == ((0.1, 0.05), (0.0, 0.0, 0.002))
    assert tuple(pulled.force) == (1.0, 0.0, -2000.0)  # type: ignore[attr-defined]
    assert isinstance(edge, EdgeLoad)
    assert tuple(edge.force) == (0.0, 0.0, 500.0)
    assert isinstance(moment, EdgeMoment)
    assert moment.moment == 3.0
    assert isinstance(pressure, Pressure)
    assert pressure.intensity == 2000.0
    assert isinstance(weight, SelfWeight)
    assert tuple(weight.acceleration) == (0.0, 0.0, -9.81)
    assert isinstance(cold, Temperature)
    assert cold.rise == -150.0
    assert isinstance(wet, Moisture)
    assert wet.content == 0.01
    assert isinstance(field, ElectricField)
    assert field.field == 5e5


@pytest.mark.parametrize(
    ("edge", "length"),
    [
        ("right", 0.1),
        ("boundary", 0.6),
        ("{line: [[0, 0], [50, 0]]}", 0.05),
        ("{rect: [190, -1, 210, 101]}", 0.12),
    ],
)
def test_a_total_force_is_spread_over_the_edge_that_is_there(edge: str, length: float) -> None:
    (load,) = single(read(f"loads: [{{edge: {edge}, total: 3 N}}]\n"))
    assert isinstance(load, EdgeLoad)
    # The tolerance of a place, a millionth of the plate's size, is all that the length may be wrong by.
    assert tuple(load.force)[2] == pytest.approx(3.0 / length, rel=1e-5)


def test_a_pressure_in_x_and_y_counts_in_the_files_units() -> None:
    (load,) = single(read('loads: [{pressure: "1000*sin(pi*x/200)*y^2"}]\n'))
    assert isinstance(load, Pressure)
    x, y = np.array([0.05, 0.1]), np.array([0.01, 0.02])
    expected = [1000 * math.sin(math.pi / 4) * 100, 1000 * math.sin(math.pi / 2) * 400]
    assert load.intensity(x, y) == pytest.approx(expected, rel=1e-14)  # type: ignore[operator]


def test_what_expands_may_be_an_expression_in_the_files_units() -> None:
    warm, wet, field, fields = single(
        read(
            'loads: [{temperature: "20 + x/10"}, {moisture: "0.01*y/100"}, {field: "1000*x"}, '
            '{field: ["-x", "0.5 kV/mm"]}]\n'
        )
    )
    x, y = np.array([0.05, 0.1]), np.array([0.01, 0.02])
    assert warm.rise(x, y) == pytest.approx([25.0, 30.0], rel=1e-14)  # type: ignore[attr-defined]
    assert wet.content(x, y) == pytest.approx([0.001, 0.002], rel=1e-14)  # type: ignore[attr-defined]
    assert field.field(x, y) == pytest.approx([5e4, 1e5], rel=1e-14)  # type: ignore[attr-defined]
    first, second = fields.field  # type: ignore[attr-defined]
    assert first(x, y) == pytest.approx([-50.0, -100.0], rel=1e-14)
    assert second == 5e5
    assert [load_text(load) for load in (warm, wet, field, fields)] == [
        "temperature change 20 + x/10 K",
        "moisture 0.01*y/100",
        "electric field 1000*x",
        "electric field -x, 500 kV/m",
    ]


def test_common_loads_act_in_every_case() -> None:
    file = read("loads: [gravity: [0, 0, -9.81]]\ncases: {up: [{pressure: 1}], down: [{pressure: -1}]}\n")
    assert [list(map(type, loads)) for loads in file.cases.values()] == [[SelfWeight, Pressure]] * 2


def test_what_is_expected_may_be_said_in_the_laminates_numbers() -> None:
    file = read("outputs: [{at: [1, 1], expected: 2*0.1^3/D11}, {at: [1, 1], value: M_x, expected: 3 mN}]\n")
    stiffness = 210e9 * 1e-9 / (12 * (1 - 0.3**2))
    assert file.outputs[0].expected == pytest.approx(2e-3 / stiffness, rel=1e-14)
    assert file.outputs[1].expected == 0.003


def test_polygons_have_holes_and_regions_with_laminates_of_their_own() -> None:
    file = read(
        "regions: {hinge: {rect: [90, -10, 110, 210], laminate: film, size: 0.5}}\n"
        "laminates: {film: {material: Kapton HN, thickness: 25 um}}\n",
        base=BASE.replace(
            "rect: [0, 0, 200, 100], grid: [4, 2]",
            "polygon: [[0, 0], [200, 0], [200, 100], [0, 100]], size: 5, holes: [{rect: [10, 10, 20, 20]}, "
            "[[30, 10], [40, 10], [35, 20]]]",
        ),
    )
    assert file.geometry.outline.area == pytest.approx(0.2 * 0.1 - 1e-4 - 5e-5, rel=1e-12)
    region = file.geometry.regions["hinge"]
    assert region.polygon.bounds == (0.09, 0.0, 0.11, 0.1)  # no further than the plate
    assert region.size == 5e-4
    assert region.laminate is not None
    assert region.laminate.plies[0].material.name == "Kapton HN"


@pytest.mark.parametrize(
    ("shape", "reported"),
    [
        # Triangles of √3/4 (0.3 mm)² on 2e4 mm²: half a million.
        ("rect: [0, 0, 200, 100], size: 0.3", r"plate.yaml:4:.* at least \d{6} cells of element 'dkt'"),
        ("rect: [0, 0, 200, 100], grid: [600, 300]", r"plate.yaml:4:.* 360000 cells of element 'dkt'"),
    ],
)
def test_memory_to_solve_is_asked_for_before_meshing(
    shape: str, reported: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """On a machine with 256 MiB free, where some hundred thousand triangles would be meshed and then not solved."""

    def never(*_: object, **__: object) -> None:
        raise AssertionError("meshed")

    monkeypatch.setattr("lamc.plates.memory.available_memory", lambda: 2**28)
    monkeypatch.setattr("lamc.readers.plates.problem_make.mesh", never)
    monkeypatch.setattr("lamc.readers.plates.problem_make.grid", never)
    head = "kind: plate\nunits: mm\nlaminate: {material: steel, thickness: 1}\n"
    file = plate_of_text(f"{head}geometry: {{{shape}}}\nsupports: [{{clamped: left}}]\n", "plate.yaml")
    with pytest.raises(DesignError, match=reported + ".*GiB to solve with .* mesh coarser"):
        problem_of(file, solver="superlu")


def test_a_mesh_follows_the_lines_and_points_of_the_file() -> None:
    """So that a load along an inner line, which must be on edges, finds them."""
    shape = "geometry: {rect: [0, 0, 200, 100], size: 20, follow: [{line: [[30, 20], [150, 70]]}, {point: [20, 60]}]}\n"
    head = "kind: plate\nunits: mm\nlaminate: {material: steel, thickness: 1}\n"
    more = "supports: [{clamped: left}]\nloads: [{edge: {line: [[30, 20], [150, 70]]}, force: 1}]\n"
    problem = problem_of(plate_of_text(head + shape + more, "plate.yaml"))
    points = problem.mesh.points
    line = LineString([(0.03, 0.02), (0.15, 0.07)])
    # The line's ends and its parts of a wanted edge each; round-off of coordinates.
    assert sum(line.distance(Point(p)) < 1e-12 for p in points) >= 1 + round(line.length / 0.02)
    assert min(np.hypot(*(points - (0.02, 0.06)).T)) < 1e-12
    # What acts along a line is followed without being reported; a grid is where it is.
    problem_of(plate_of_text(head + "geometry: {rect: [0, 0, 200, 100], size: 20}\n" + more, "plate.yaml"))
    with pytest.raises(DesignError, match="lies along no edge of the mesh"):
        problem_of(
            plate_of_text(head + "geometry: {rect: [0, 0, 200, 100], grid: [9, 7]}\n" + more, "plate.yaml")
        )


@pytest.mark.parametrize(
    ("entry", "reported"),
    [
        (
            "{rect: [0, 0, 2, 1], grid: [2, 2], follow: [{point: [1, 1]}]}",
            "the lines of a grid are where they are",
        ),
        (
            "{rect: [0, 0, 2, 1], follow: [{point: [1, 1], line: [[0, 0], [1, 1]]}]}",
            "exactly one of point, line",
        ),
        ("{rect: [0, 0, 2, 1], follow: [{line: [[0, 0]]}]}", "a line has two points at least"),
        ("{rect: [0, 0, 2, 1], follow: [{line: [[1, 1], [1, 1]]}]}", "the points of the line are one point"),
    ],
)
def test_what_a_mesh_of_a_file_cannot_follow_is_refused(entry: str, reported: str) -> None:
    (line,) = problems(base=f"kind: plate\nlaminate: {{material: steel, thickness: 1}}\ngeometry: {entry}\n")
    assert line.startswith("plate.yaml:3:")
    assert reported in line


def test_well_known_text_counts_in_the_files_units() -> None:
    text = "wkt: 'POLYGON ((0 0, 4 0, 4 3, 0 3, 0 0), (1 1, 2 1, 2 2, 1 1))'"
    file = read(base=BASE.replace("rect: [0, 0, 200, 100], grid: [4, 2]", text))
    assert file.geometry.outline.area == pytest.approx(11.5e-6, rel=1e-12)


# --- a body of a design --------------------------------------------------------------------------------------------


@pytest.fixture
def beside_flaps(tmp_path: Path) -> Path:
    """A place for plate files beside lamc's example design of two flaps: 12 mm wide, hinges at x = ±20 mm."""
    (tmp_path / "flaps.yaml").write_text(examples.find("flaps").text, encoding="utf-8")
    return tmp_path / "plate.yaml"


def of_design(path: Path, geometry: str, more: str = "") -> PlateFile:
    path.write_text(
        f"kind: plate\nunits: mm\ngeometry: {{design: flaps.yaml, {geometry}}}\n{more}", encoding="utf-8"
    )
    return load_plate(path)


def test_a_body_of_a_design_brings_its_outline_and_laminates(beside_flaps: Path) -> None:
    file = of_design(beside_flaps, "body: link_1, hinges: strips")
    x0, y0, x1, y1 = file.geometry.outline.bounds
    assert (x0, y0, y1) == pytest.approx((-0.05, 0.0, 0.012), abs=1e-9)
    assert x1 == pytest.approx(
        -0.0198, abs=1e-9
    )  # the far edge of the strip: half the gap of 0.4 mm beyond the line
    stack, strip = file.geometry.regions.values()
    assert stack.laminate is not None
    assert strip.laminate is not None
    assert [ply.thickness for ply in stack.laminate.plies] == [0.5e-3, 50e-6, 0.5e-3]
    assert [ply.material.name for ply in strip.laminate.plies] == ["film"]


def test_a_hinge_of_the_design_is_a_place(beside_flaps: Path) -> None:
    file = of_design(beside_flaps, "body: link_1, hinges: lines", "supports: [{hinged: {hinge: left}}]")
    (support,) = file.supports
    assert support.where.length == pytest.approx(0.012, rel=1e-6)  # type: ignore[union-attr]
    # The line stands for the strip between the sheets, which end 0.2 mm before it.
    assert support.where.distance(Point(-0.0202, 0.006)) < 1e-9  # type: ignore[union-attr]


def test_what_a_design_fixes_is_a_place(beside_flaps: Path) -> None:
    file = of_design(beside_flaps, "body: ground", "supports: [{clamped: fixed}]")
    (support,) = file.supports
    assert support.where.area == pytest.approx(20e-3 * 8e-3, rel=1e-9)  # type: ignore[union-attr]


def test_materials_of_a_plate_file_replace_those_of_the_design(beside_flaps: Path) -> None:
    file = of_design(beside_flaps, "body: link_1", "materials: {plate: steel, film: {E: 3 GPa, nu: 0.3}}")
    region = max(file.geometry.regions.values(), key=lambda r: r.polygon.area)  # all but a strip of bare film
    assert region.laminate is not None
    assert [ply.material.name for ply in region.laminate.plies] == ["steel", "film", "steel"]
    assert region.laminate.plies[1].material.E1 == 3e9


@pytest.mark.parametrize(
    ("geometry", "more", "reported"),
    [
        ("body: link_9", "", "did you mean 'link_2'?"),
        ("body: []", "", "names a body"),
        ("body: link_1", "supports: [{clamped: {hinge: right}}]", "no hinge 'right' joins the body"),
        ("body: link_1", "supports: [{clamped: fixed}]", "nothing of the plate is fixed"),
        ("body: link_1", "laminate: {material: steel, thickness: 1}", "come from the design"),
        ("body: link_1, holes: [[[0, 0], [1, 0], [0, 1]]]", "", "holes are drawn there"),
    ],
)
def test_what_a_design_does_not_have_is_refused(
    beside_flaps: Path, geometry: str, more: str, reported: str
) -> None:
    with pytest.raises(DesignErrors) as caught:
        of_design(beside_flaps, geometry, more)
    (problem,) = caught.value.problems
    assert reported in problem.message
    assert problem.place is not None
    assert problem.place.line in (3, 4)


def test_a_hinge_of_no_design_is_no_place() -> None:
    (line,) = problems("supports: [{clamped: {hinge: left}}]")
    assert "only a plate of a design has hinges" in line


# --- expressions --------------------------------------------------------------------------------------------------


@given(x=st.floats(-2, 2), y=st.floats(0.1, 2))
def test_fields_are_what_python_computes(x: float, y: float) -> None:
    field = Field("-3*x^3 + atan2(y, x)/exp(x) - min(x, y)*sqrt(y) + max(abs(x), 0.5)")
    expected = -3 * x**3 + math.atan2(y, x) / math.exp(x) - min(x, y) * math.sqrt(y) + max(abs(x), 0.5)
    assert field([x], [y])[0] == pytest.approx(
        expected, rel=1e-13, abs=1e-13
    )  # a dozen roundings of numbers near 10


def test_a_field_without_place_is_the_same_everywhere() -> None:
    assert Field("2*pi")(np.zeros((2, 3)), np.zeros((2, 3))).shape == (2, 3)


def test_a_field_that_has_no_value_somewhere_says_where() -> None:
    with pytest.raises(ExpressionError, match=re.escape("no finite value at (0, 3) m")):
        Field("1/x")(np.array([1.0, 0.0]), np.array([2.0, 3.0]))


@pytest.mark.parametrize("text", ["__import__('os')", "x.real", "lambda: 1", "z", "x if y else 1", "[x]", ""])
def test_nothing_but_the_language_is_a_field(text: str) -> None:
    with pytest.raises(ExpressionError):
        Field(text)


def test_words_with_x_in_them_do_not_depend_on_the_place() -> None:
    assert depends_on_place("3*x")
    assert depends_on_place("sin(y)")
    assert not depends_on_place("exp(3) * max(1, 2)")
    assert number("0.5*D11/h", {"D11": 4.0, "h": 2.0}) == 1.0


# --- refusals -----------------------------------------------------------------------------------------------------


def test_all_problems_of_a_file_are_reported_at_once_each_at_its_place() -> None:
    lines = problems(
        "materials:\n"
        "  a: {E: -3, nu: 0.3}\n"
        "supports:\n"
        "  - clampd: left\n"
        "  - clamped: north\n"
        "loads:\n"
        "  - {point: [1, 1]}\n"
        '  - {pressure: "3*x + __import__(1)"}\n'
        "  - {pressure: 3 bananas}\n"
    )
    places = [line.split(": ")[0] for line in lines]
    assert places == [f"plate.yaml:{at}" for at in ("6:10", "8:5", "9:14", "11:5", "12:16", "13:16")]
    assert "did you mean 'clamped'?" in lines[1]
    assert "one of boundary, left, right, bottom, top" in lines[2]


@pytest.mark.parametrize(
    ("more", "reported"),
    [
        ("supports: [{clamped: {region: r}}]", "no region is named 'r'"),
        ("supports: [{fixed: [w, w_x], where: left, value: 1}]", "different units"),
        ("supports: [{fixed: [w], value: 1}]", "where tells the place"),
        ("supports: [{clamped: left, kind: soft}]", "kind belongs to simply_supported"),
        ("supports: [{clamped: {line: [[0, 0], [0, 0]]}}]", "two that differ"),
        ("supports: [{clamped: {line: [[0, 0], [0, 1]], point: [0, 0]}}]", "exactly one of"),
        ("loads: [{point: [1, 1], force: [1, 2]}]", "one number, along z, or three"),
        ("loads: [{edge: left, force: 3 N}]", "'N' is not a unit of force per length"),
        ("loads: [{edge: {line: [[30, 30], [40, 40]]}, total: 3 N}]", "no edge there"),
        ("loads: [{edge: left, force: 1, moment: 2}]", "this one has force and moment"),
        ("loads: [{pressure: 1, region: r}]", "no region is named 'r'"),
        ("loads: [{temperature: 20 m}]", "or an expression in x and y"),
        ("loads: [{field: [1, '2*x +']}]", "'2*x +'"),
        ("loads: [{gravity: [0, 0, -9.81], region: r}]", "region belongs to"),
        ("outputs: [{at: [300, 0]}]", "(0.3, 0) m is 0.1 m off the plate"),
        ("outputs: [{at: [0, 0], expected: 1/D17}]", "D17"),
        ("outputs: [{at: [0, 0], value: M_x, expected: 3 mm}]", "not a unit of moment per length"),
        ("laminates: {a: {use: b}}", "cannot name another entry"),
        ("regions: {r: {rect: [300, 0, 400, 1]}}", "does not overlap the plate"),
        ("regions: {r: {rect: [0, 0, 10, 10]}, s: {rect: [5, 5, 20, 20]}}", "overlaps region 'r'"),
        ("regions: {r: {rect: [0, 0, 10, 10], laminate: q}}", "no laminate is named 'q'"),
        ("modes: 1000000", "must be 0 to 1000"),
        ("modes: -1", "must be 0 to 1000"),
        ("materials: {a: {E: 1, nu: 0.3, E1: 3}}", "do not go together"),
        ("materials: {a: {E1: 1 GPa, E2: 2 GPa, nu12: 2, G12: 1 GPa}}", "sqrt(E1/E2)"),
        ("materials: {a: {E: 1}}", "nu missing"),
    ],
)
def test_what_makes_no_sense_is_refused_with_the_reason(more: str, reported: str) -> None:
    (line,) = problems(more)
    assert line.startswith("plate.yaml:5:")
    assert reported in line


@pytest.mark.parametrize(
    ("old", "new", "reported"),
    [
        ("thickness: 1", "thickness: 0", "it must be above 0"),
        ("material: steel", "material: steal", "did you mean 'steel'?"),
        ("thickness: 1}", "thickness: 1, angle: 45}", "45 has no unit"),
        ("thickness: 1}", "layup: '[0/45'}", "thickness of a ply"),
        ("thickness: 1}", "layup: '[0/45', ply: 1}", "there must be"),
        ("thickness: 1}", "plies: []}", "exactly one of"),
        ("grid: [4, 2]", "grid: [4, 0]", "one cell at least"),
        ("grid: [4, 2]", "grid: [4, 2], size: 3", "neither size nor holes"),
        ("grid: [4, 2]", "pattern: union-jack", "pattern belongs to a grid"),
        ("grid: [4, 2]", "grid: [4, 2], pattern: chevron", "'one-diagonal'"),
        (
            "rect: [0, 0, 200, 100], grid: [4, 2]",
            "polygon: [[0, 0], [1, 1], [0, 1], [1, 0]]",
            "self-intersection",
        ),
        ("rect: [0, 0, 200, 100], grid: [4, 2]", "wkt: 'POINT (1 2)'", "it must be a POLYGON"),
        ("rect: [0, 0, 200, 100], grid: [4, 2]", "wkt: bananas", "no geometry"),
        ("grid: [4, 2]", "holes: [{circle: {center: [-9, 0], radius: 1}}]", "outside the plate"),
        ("grid: [4, 2]", "holes: [{rect: [-1, -1, 201, 101]}]", "take the whole plate away"),
        ("laminate: {material: steel, thickness: 1}\n", "", "the plate has no laminate"),
    ],
)
def test_a_plate_that_cannot_be_is_refused_with_the_reason(old: str, new: str, reported: str) -> None:
    assert old in BASE
    (line,) = problems(base=BASE.replace(old, new))
    assert line.startswith("plate.yaml:")
    assert reported in line


def test_a_plate_file_is_no_design(tmp_path: Path) -> None:
    file = tmp_path / "p.yaml"
    file.write_text(BASE, encoding="utf-8")
    with pytest.raises(DesignError, match="`lamc plate` solves it"):
        lamc.load(file)


def test_the_json_schema_describes_plate_files() -> None:
    schema = json_schema({**FILES, "PlateProblem": PlateFileModel})
    assert {"$ref": "#/$defs/PlateProblem"} in schema["anyOf"]
    plate = schema["$defs"]["PlateProblem"]
    assert set(plate["required"]) == {"kind", "geometry"}
    names = set(json_schema()["$defs"]) - {"CircleModel"}
    assert not names & set(json_schema({"PlateProblem": PlateFileModel})["$defs"])  # one name, one meaning


# --- fuzzing ------------------------------------------------------------------------------------------------------

FRAGMENTS = (
    *(
        "&a [*a, *a]",
        ".nan",
        "-.inf",
        "1e999",
        "'9'",
        "~",
        "[]",
        "{}",
        "[[[[",
        "9" * 500,
        "\t",
        "\x00",
        "!!python/x 1",
    ),
    *(
        "POLYGON ((0 0, 1 1))",
        "GEOMETRYCOLLECTION (" * 20,
        "x^x^x^x",
        "1/x",
        "D11",
        "steel",
        "boundary",
        "1e300",
        "-1",
    ),
    *(
        "[0, 0]",
        "[[0, 0], [1, 1]]",
        "{point: [0, 0]}",
        "{line: 3}",
        "'[0/90]9999999s'",
        "45 deg",
        "3 N/m",
        "true",
    ),
)


def attempt(text: str) -> None:
    """Reads the text; anything but a record or a LamcError escapes and fails the test."""
    began = time.monotonic()
    message = "a plate"
    try:
        plate_of_text(text, "fuzzed")
    except LamcError as error:
        message = str(error)
    assert message
    assert all(len(line) < 2000 for line in message.splitlines())
    assert time.monotonic() - began < PATIENCE


@FEW
@given(text=st.text(max_size=200))
def test_any_text_is_a_plate_or_an_error(text: str) -> None:
    attempt("kind: plate\n" + text)


@FEW
@given(data=st.data())
def test_damaged_plate_files_are_a_plate_or_an_error(data: st.DataObject) -> None:
    text = data.draw(st.sampled_from([plate_examples.find(name).text for name in plate_examples.names()]))
    start = data.draw(st.integers(0, len(text)))
    length = data.draw(st.sampled_from([0, 1, 2, 5, 20, 100]))
    patch = data.draw(st.one_of(st.sampled_from(FRAGMENTS), st.text(max_size=5)))
    attempt(text[:start] + patch + text[start + length :])


@settings(FEW, max_examples=tries(150))
@given(data=st.data())
def test_plate_files_with_one_value_replaced_are_a_plate_or_an_error(data: st.DataObject) -> None:
    """Replaces whole values, so that the file stays YAML and the damage reaches the readers behind it."""
    text = data.draw(st.sampled_from([plate_examples.find(name).text for name in plate_examples.names()]))
    values = list(re.finditer(r"(?<=[:\[,] )[^\s,\[\]{}][^,\[\]{}\n]*|\[[^\[\]\n]*\]", text))
    chosen = data.draw(st.sampled_from(values))
    attempt(text[: chosen.start()] + data.draw(st.sampled_from(FRAGMENTS)) + text[chosen.end() :])


def test_a_file_that_is_not_there_is_reported(tmp_path: Path) -> None:
    with pytest.raises(DesignError, match="there is no such file"):
        load_plate(tmp_path / "none.yaml")
