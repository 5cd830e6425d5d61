"""Strength of plates against closed forms, where moments are largest: at clamped edges, mostly."""

import dataclasses
from pathlib import Path

import numpy as np
import pytest
from shapely.geometry import LineString, Point, Polygon, box

from lamc import plate
from lamc.basics.times import Times
from lamc.commands.plate_work import answers
from lamc.readers.plates.problem_file import load_plate

SIDE, THICKNESS, PRESSURE = 0.1, 1e-3, 1e4
STRENGTH = 100e6
METAL = dataclasses.replace(
    plate.Material.isotropic(70e9, 0.3, 2700.0), Xt=STRENGTH, Xc=STRENGTH, Yt=STRENGTH, Yc=STRENGTH, S=60e6
)
STRONG_IN_SHEAR = dataclasses.replace(METAL, S=600e6)
LAMINATE = plate.Laminate([plate.Ply(METAL, THICKNESS)])


def ratio(moment: float) -> float:
    """Of strength, where the plate bears `moment`, N."""
    return STRENGTH * THICKNESS**2 / 6.0 / moment


def square(pattern: str, n: int) -> plate.Mesh:
    if pattern == "mesher":
        return plate.mesh(box(0, 0, SIDE, SIDE), SIDE / n)
    shaken = pattern == "jittered"
    mesh = plate.grid(SIDE, SIDE, n, n, "one-diagonal" if shaken else pattern)
    return plate.jittered(mesh, 0.2) if shaken else mesh


def solved(mesh: plate.Mesh, support: object, element: str = "dkt", **given: object) -> plate.Solution:
    given = {"loads": [plate.Pressure(PRESSURE)], **given}
    given = {"laminate": LAMINATE, **given}
    found = plate.solve(plate.Problem(mesh, element=element, supports=[support], **given))  # type: ignore[arg-type, list-item]
    assert isinstance(found, plate.Solution)
    return found


# The largest moment of a clamped square, at the middle of its edges: C. E. Imrak, I. Gerdemeli, Acta Mech. 193, 2007.
CLAMPED_SQUARE = 0.0513337647 * PRESSURE * SIDE**2
# By the number of cells along: first order, as the elements have at their nodes at borders, and some 0.3 in front.
LIMITS = {10: 0.035, 20: 0.03, 40: 0.016}


@pytest.mark.parametrize(
    ("element", "pattern"),
    [(e, p) for e in ("dkt", "dkt+cst", "dkmt")
     for p in ("one-diagonal", "criss-cross", "union-jack", "jittered", "mesher")]
    + [("dkt+lst", "one-diagonal"), ("bciz", "one-diagonal"), ("bfs", "squares")],
)  # fmt: skip
@pytest.mark.parametrize("n", [10, 20])
@pytest.mark.quick("10-*", others="campaign")
def test_strength_of_a_clamped_square(element: str, pattern: str, n: int) -> None:
    first = plate.first_failure(solved(square(pattern, n), plate.Clamped("boundary"), element), "max-stress")
    assert first.ratio == pytest.approx(ratio(CLAMPED_SQUARE), rel=LIMITS[n])
    x, y = first.at
    assert min(x, y, SIDE - x, SIDE - y) < 1e-9


def test_strength_of_a_clamped_square_converges() -> None:
    first = plate.first_failure(solved(square("one-diagonal", 40), plate.Clamped("boundary")), "max-stress")
    assert first.ratio == pytest.approx(ratio(CLAMPED_SQUARE), rel=LIMITS[40])


@pytest.mark.parametrize("n", [10, 20])
def test_strength_of_a_simply_supported_square(n: int) -> None:
    """0.0479 q a² in the middle, and 0.0325 q a² of twist at the corners, where it fails unless it is strong in shear
    (Timoshenko and Woinowsky-Krieger 1959, table 8)."""
    solution = solved(square("one-diagonal", n), plate.SimplySupported("boundary"))
    first = plate.first_failure(solution, "max-stress")
    # First order at borders, second inside; the table has three digits.
    twist = ratio(0.0325 * PRESSURE * SIDE**2) * METAL.S / STRENGTH  # type: ignore[operator]
    assert first.ratio == pytest.approx(twist, rel=LIMITS[n] + 2e-3)
    assert first.mode == "shear"
    strong = dataclasses.replace(
        solution.problem, laminate=plate.Laminate([plate.Ply(STRONG_IN_SHEAR, THICKNESS)])
    )
    bent = plate.first_failure(plate.solve(strong), "max-stress")  # type: ignore[arg-type]
    assert bent.ratio == pytest.approx(ratio(0.0479 * PRESSURE * SIDE**2), rel=2.0 / n**2 + 1e-3)


@pytest.mark.parametrize(("element", "thickness"), [("dkt", 1e-3), ("dkmt", 1e-3), ("dkmt", 1e-2)])
def test_strength_of_a_clamped_circle(element: str, thickness: float) -> None:
    """q R² / 8 at the edge, by the closed form, with shear or without: moments are those of equilibrium and symmetry
    (Timoshenko and Woinowsky-Krieger 1959, section 17)."""
    radius = 0.5 * SIDE
    mesh = plate.mesh(Point(0, 0).buffer(radius, quad_segs=32), 0.05 * SIDE)
    laminate = plate.Laminate([plate.Ply(METAL, thickness)])
    solution = solved(mesh, plate.Clamped("boundary"), element, laminate=laminate)
    first = plate.first_failure(solution, "max-stress")
    # As on the square of 20 cells, with straight edges for the arc: a part of 1e-3.
    expected = ratio(PRESSURE * radius**2 / 8.0) * (thickness / THICKNESS) ** 2
    assert first.ratio == pytest.approx(expected, rel=LIMITS[20])


def test_strength_of_a_long_clamped_rectangle() -> None:
    """0.0829 q a² at the middle of the long sides, twice as long (the same, table 35)."""
    mesh = plate.grid(SIDE, 2.0 * SIDE, 20, 40)
    first = plate.first_failure(solved(mesh, plate.Clamped("boundary")), "max-stress")
    assert first.ratio == pytest.approx(ratio(0.0829 * PRESSURE * SIDE**2), rel=LIMITS[20])


def test_outputs_of_files_speak_as_the_extremes_do(tmp_path: Path) -> None:
    file = tmp_path / "clamped.yaml"
    file.write_text(
        "kind: plate\nunits: mm\nlaminate: {material: aluminium, thickness: 1}\n"
        "geometry: {rect: [0, 0, 100, 100], grid: [10, 10]}\nsupports: [{clamped: boundary}]\n"
        "cases: {blown: [{pressure: 10000 Pa}]}\n"
        "outputs: [{name: edge, at: [0, 50], value: M_x}]\n",
        encoding="utf-8",
    )
    case = answers(load_plate(file), "", None, "auto", Times(), two_meshes=True).cases[0]
    # One polynomial, at the same corner: round-off.
    assert case.printed[0].value == pytest.approx(case.extremes["M_x"][1].value, rel=1e-9)
    assert abs(case.printed[0].value) == pytest.approx(CLAMPED_SQUARE, rel=LIMITS[10])


def test_where_stress_has_no_bound_is_reported() -> None:
    bent = Polygon([(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)])
    notched = plate.first_failure(solved(plate.mesh(bent, 0.1), plate.Clamped("boundary")))
    assert notched.sharp == "in a corner that cuts into the plate"
    assert "is no strength" in notched.notes[0]
    mesh = square("one-diagonal", 20)
    force = plate.PointLoad((SIDE / 2, SIDE / 2), 1.0)
    pushed = plate.first_failure(solved(mesh, plate.SimplySupported("boundary"), loads=[force]))
    assert pushed.sharp == "under a force at a point"
    part = LineString([(0, 0.3 * SIDE), (0, 0.7 * SIDE)])
    ended = plate.first_failure(solved(mesh, plate.Clamped(part)))
    assert ended.sharp == "at an end of a support"


def test_smooth_places_are_not_told_of() -> None:
    """A clamped square of 20 cells, and a cantilever, whose corners at the root are right angles."""
    first = plate.first_failure(solved(square("one-diagonal", 20), plate.Clamped("boundary")))
    assert (first.sharp, first.notes) == ("", ())
    root = plate.Clamped(LineString([(0, 0), (0, SIDE)]))
    assert plate.first_failure(solved(square("one-diagonal", 20), root)).sharp == ""


def test_cells_too_coarse_for_a_strength_are_reported() -> None:
    first = plate.first_failure(solved(plate.grid(SIDE, SIDE, 2, 2), plate.Clamped("boundary")))
    assert first.off > 0.1
    assert "too coarse" in " ".join(first.notes)


def test_coupled_plies_on_constant_strains_are_told_to_be_too_strong() -> None:
    laminate = plate.Laminate.parse("[0/45/90]", plate.material("T300/5208"), THICKNESS / 3)
    found = {}
    for element in ("dkt+cst", "dkt+lst"):
        problem = plate.Problem(
            plate.grid(SIDE, SIDE, 10, 10),
            laminate,
            element,
            [plate.Clamped("boundary")],
            [plate.Pressure(PRESSURE)],
        )
        found[element] = plate.first_failure(plate.solve(problem))  # type: ignore[arg-type]
    assert found["dkt+cst"].ratio > 1.1 * found["dkt+lst"].ratio
    assert "take 'dkt+lst'" in " ".join(found["dkt+cst"].notes)
    assert found["dkt+lst"].notes == ()


SPAN, WIDTH = 0.1, 0.02
BEAM = plate.Laminate([plate.Ply(dataclasses.replace(STRONG_IN_SHEAR, nu12=0.0, G12=35e9), THICKNESS)])


def across(x: float) -> LineString:
    return LineString([(x, 0), (x, WIDTH)])


def two_spans(element: str, pattern: str, n: int, middle: list[object], load: object) -> plate.Solution:
    """Of ν = 0, a beam: simply supported at both ends, and in the middle as `middle` says; n cells along each span."""
    soft = [plate.SimplySupported(across(x), kind="soft") for x in (0.0, 2.0 * SPAN)]
    mesh = plate.grid(2.0 * SPAN, WIDTH, 2 * n, n // 5, pattern)
    found = plate.solve(plate.Problem(mesh, BEAM, element, [*soft, *middle], [load]))  # type: ignore[list-item]
    assert isinstance(found, plate.Solution)
    return found


def left_span(x: object, y: object) -> object:
    return PRESSURE * (np.asarray(x) < SPAN)


# Kind of the middle, load, and the moment there: reactions and line loads make a kink of it, clamped lines a jump.
PEAKS = {
    "reaction": ([plate.SimplySupported(across(SPAN))], plate.Pressure(PRESSURE), PRESSURE * SPAN**2 / 8.0),
    "clamped": ([plate.Clamped(across(SPAN))], plate.Pressure(left_span), PRESSURE * SPAN**2 / 8.0),
    "line load": ([], plate.EdgeLoad(across(SPAN), PRESSURE * SPAN), PRESSURE * SPAN**2 / 2.0),
}


@pytest.mark.parametrize("element", ["dkt", "dkmt", "bciz"])
@pytest.mark.parametrize("kind", sorted(PEAKS))
@pytest.mark.parametrize(("n", "limit"), [(10, 0.06), (20, 0.03)])
def test_strength_over_an_inner_line(element: str, kind: str, n: int, limit: float) -> None:
    """First order, as at borders: the spans' moments fall by a third of the peak along the first cell of ten."""
    middle, load, moment = PEAKS[kind]
    solution = two_spans(element, "one-diagonal", n, middle, load)  # type: ignore[arg-type]
    first = plate.first_failure(solution, "max-stress")
    assert first.at[0] == pytest.approx(SPAN, rel=1e-12)
    assert first.ratio == pytest.approx(ratio(moment), rel=limit)
    assert first.sharp == ""  # the line ends at free edges, and beyond it are right angles


def test_moments_jump_where_a_line_is_clamped() -> None:
    """Nothing acts on the right span: its moments are those of round-off, up to the line."""
    middle, load, moment = PEAKS["clamped"]
    better = two_spans("dkt", "one-diagonal", 10, middle, load).recovered  # type: ignore[arg-type]
    assert abs(float(better.moments(1.001 * SPAN, 0.5 * WIDTH)[0])) < 1e-9 * moment
    assert abs(float(better.moments(0.999 * SPAN, 0.5 * WIDTH)[0])) == pytest.approx(moment, rel=0.06)
