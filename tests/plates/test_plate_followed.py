"""Supports that a mesh follows: closed forms, files that mesh along them, and refusals where a mesh does not."""

from pathlib import Path

import numpy as np
import pytest
import shapely
from shapely.geometry import LineString, MultiPoint, Point, Polygon, box
from shapely.geometry.base import BaseGeometry

from lamc import plate
from lamc.basics.errors import DesignError
from lamc.plates.problem import Problem
from lamc.readers.plates.bands import Band
from lamc.readers.plates.follow import to_follow
from lamc.readers.plates.problem_file import plate_of_text
from lamc.readers.plates.problem_make import problem_of

SIDE, HALF, THICK, E, NU, RHO, P = 0.1, 0.05, 1e-3, 70e9, 0.3, 2700.0, 1e3
D = E * THICK**3 / (12.0 * (1.0 - NU**2))
SHEET = plate.Laminate([plate.Ply(plate.Material.isotropic(E, NU, RHO), THICK)])
MIDDLE = LineString([(HALF, 0.0), (HALF, SIDE)])
FILE = """\
kind: plate
units: mm
materials: {al: {E: 70 GPa, nu: 0.3, density: 2700}}
laminate: {material: al, thickness: 1}
loads: [{pressure: 1000}]
"""


def of_file(more: str) -> Problem:
    return problem_of(plate_of_text(FILE + more, "plate.yaml"))


def levy(x: float, y: float) -> float:
    """Deflection of the strip 0 < x < HALF, clamped at x = HALF (by symmetry) and simply supported at its other edges:
    M. Lévy's single series, each term a linear ordinary equation of fourth order in x."""
    total = 0.0
    for n in range(1, 40, 2):  # terms fall with n⁻⁵: the rest is 1e-7
        b = n * np.pi / SIDE
        part = 4.0 * P / (n * np.pi) / (D * b**4)

        def terms(at: float, b: float = b) -> np.ndarray:
            """Of both ends, decaying into the strip, and their derivatives up to the second."""
            left, right = np.exp(-b * at), np.exp(-b * (HALF - at))
            r = HALF - at
            return np.array(
                [
                    [left, b * at * left, right, b * r * right],
                    [-b * left, b * (1 - b * at) * left, b * right, b * (b * r - 1) * right],
                    [b * b * left, b * b * (b * at - 2) * left, b * b * right, b * b * (b * r - 2) * right],
                ]
            )

        rows = np.stack([terms(0.0)[0], terms(0.0)[2], terms(HALF)[0], terms(HALF)[1]])
        amounts = np.linalg.solve(rows, [-part, 0.0, -part, 0.0])
        total += (part + terms(x)[0] @ amounts) * np.sin(b * y)
    return float(total)


@pytest.mark.parametrize(
    "kind", ["simply_supported: {%s}", "clamped: {%s}", "hinged: {%s}", "fixed: [w], where: {%s}"]
)
def test_a_file_meshes_along_an_interior_support(kind: str) -> None:
    place = "line: [[50, 0], [50, 100]]"
    held = of_file(
        "geometry: {rect: [0, 0, 100, 100], size: 5}\nsupports:\n  - simply_supported: boundary\n  - {"
        + kind % place
        + "}\n"
    )
    # A mesh of 20 cells along: within 1 % of the series, as without the support. It was 860 % off.
    assert plate.solve(held).deflection(0.025, 0.05) == pytest.approx(levy(0.025, 0.05), rel=0.01)
    if "clamped" not in kind:
        exact = 0.5 * np.pi * (1.0 / HALF**2 + 1.0 / SIDE**2) * np.sqrt(D / (RHO * THICK))
        assert plate.modes(held, 1).frequencies[0] == pytest.approx(exact, rel=0.005)  # 1209 Hz; was 484


@pytest.mark.parametrize(
    "support",
    [plate.SimplySupported, plate.Clamped, plate.Hinged, lambda where: plate.Support(where, ("w",))],
)
def test_a_mesh_that_does_not_follow_a_support_is_refused(support: type) -> None:
    plain, follows = (plate.mesh(box(0, 0, SIDE, SIDE), 0.005, follow=f) for f in ([], [MIDDLE]))
    with pytest.raises(DesignError, match=r"not followed by the mesh at .*follow=\[line\]"):
        Problem(plain, SHEET, supports=[support(MIDDLE)])
    Problem(follows, SHEET, supports=[support(MIDDLE)])


@pytest.mark.parametrize(
    "where",
    [
        LineString([(0, 0.03), (0, 0.07)]),  # ends within edges of the boundary
        box(-0.01, 0.03, 0.0, 0.07),  # so does an area that only touches the plate
        box(0.01, 0.01, 0.04, 0.04),  # an area whose border runs through cells
        MultiPoint([(0, 0), (0.03, 0.03)]),  # a node at the first point only
    ],
)
def test_supports_that_end_beside_nodes_are_refused(where: BaseGeometry) -> None:
    with pytest.raises(DesignError, match=r"not followed by the mesh|touches no node"):
        Problem(plate.grid(SIDE, SIDE, 4, 4), SHEET, supports=[plate.Clamped(where)])


@pytest.mark.parametrize(
    "where",
    [
        LineString([(0, -1), (0, 1)]),  # longer than the plate
        box(-1, -1, 1e-5, 1),  # a box drawn around an edge, thinner than a hundredth of a cell
        box(0, 0, HALF, SIDE),  # whole cells
        MIDDLE,
        Point(0.05, 0.05).buffer(1e-5),  # around a node
        LineString([(-0.1, 0.1), (0.1, -0.1)]),  # touches a corner
    ],
)
def test_supports_that_the_mesh_follows_are_taken(where: BaseGeometry) -> None:
    Problem(plate.grid(SIDE, SIDE, 4, 4), SHEET, supports=[plate.Clamped(where)])


@pytest.mark.parametrize("place", ["line: [[0, 30], [0, 70]]", "rect: [-10, 30, 0, 70]"])
def test_a_file_has_nodes_where_a_support_of_the_boundary_ends(place: str) -> None:
    more = "geometry: {rect: [0, 0, 100, 100], size: %s}\nsupports: [{clamped: {" + place + "}}]\n"
    coarse, fine = (of_file(more % size) for size in ("20", "5"))
    for problem in (coarse, fine):
        ends = np.linalg.norm(problem.mesh.points - np.array([[[0, 0.03]], [[0, 0.07]]]), axis=2).min(axis=1)
        assert ends.max() < 1e-9
    tips = [float(plate.solve(problem).deflection(SIDE, HALF)) for problem in (coarse, fine)]
    # The corner stresses where the support ends converge with first order; it was 64 % on such a grid.
    assert tips[0] == pytest.approx(tips[1], rel=0.05)


def test_a_grid_that_does_not_follow_is_reported_at_its_line() -> None:
    with pytest.raises(DesignError, match=r"plate\.yaml:7.*asks for a grid"):
        of_file(
            "geometry: {rect: [0, 0, 100, 100], grid: [5, 5]}\nsupports: [{clamped: {line: [[40, 0], [60, 100]]}}]\n"
        )


def test_a_load_along_a_line_inside_is_followed() -> None:
    force = of_file(
        "geometry: {rect: [0, 0, 100, 100], size: 20}\nsupports: [{clamped: left}]\n"
        "cases: {push: [{edge: {line: [[33, 0], [33, 100]]}, force: 1 N/m}]}\n"
    )
    assert float(plate.FactoredPlate(force).solve_case("push").deflection(SIDE, HALF)) > 0.0


def test_lines_that_nearly_coincide_with_others_bring_no_slivers() -> None:
    square, region = box(0, 0, 1, 1), box(0, 0, 0.5, 1)
    off = 3e-8  # m: what a file that rounds coordinates leaves
    wheres = [
        LineString([(off, 0.2), (off, 0.8)]),  # along the edge
        LineString([(0.5 + off, 0), (0.5 - off, 1)]),  # along the border of a region
        LineString([(0.0, 0.5), (1.0, 0.5 + off)]),  # across both
        LineString([(0.25, 0.5), (0.75, 0.5)]),  # upon the one before
        Polygon([(0.6, 0.5), (0.9, 0.5), (0.9, 1), (0.6, 1)]),
    ]
    found = to_follow(wheres, square, [region])
    mesh = plate.mesh(square, 0.2, regions={"r": region}, follow=found)
    ends = mesh.points[mesh.edges]
    assert np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1).min() > 0.02
    Problem(mesh, SHEET, supports=[plate.Clamped(where) for where in wheres])


DESIGN = """\
kind: design
units: mm
materials: {film: {density: 1420 kg/m^3, E1: 2.5 GPa, poisson: 0.34, flexible: true}}
layers: [{name: film, material: film, thickness: 0.1}]
shapes: [{rect: [-20, 0, 20, 10]}]
hinges: [{name: h, line: [[0, 0], [0, 10]], gap: 1, layer: film}]
fixed: [{rect: [-20, 0, -16.3, 10]}]
bodies: {left: [-5, 5], right: [5, 5]}
"""


def test_what_a_design_fixes_is_followed(tmp_path: Path) -> None:
    (tmp_path / "two.yaml").write_text(DESIGN, encoding="utf-8")
    text = (
        "kind: plate\nunits: mm\ngeometry: {design: two.yaml, body: left, size: 2.5}\n"
        "supports: [{clamped: fixed}]\nloads: [{pressure: 1}]\n"
    )
    made = problem_of(plate_of_text(text, str(tmp_path / "plate.yaml")))
    (held,) = made.supports
    assert isinstance(held.where, BaseGeometry)
    inside = held.where.buffer(1e-8).contains([Polygon(corners) for corners in made.mesh.corners])
    assert made.mesh.areas[inside].sum() == pytest.approx(
        3.7e-3 * 10e-3, rel=1e-5
    )  # coordinates are rounded to 1e-8 m


@pytest.mark.parametrize("seed", range(20))
@pytest.mark.quick("[0-5]", others="campaign")
def test_a_band_cuts_lines_where_shapes_of_it_would(seed: int) -> None:
    rng = np.random.default_rng(seed)
    segments, line, near = rng.uniform(0.0, 1.0, (6, 2, 2)), LineString(rng.uniform(0.0, 1.0, (4, 2))), 0.05
    segments[0, 1] = segments[0, 0]  # a point
    beyond, within = Band(segments, near).cut([line])
    there = shapely.union_all([*shapely.linestrings(segments[1:]), Point(segments[0, 0])])
    area = shapely.buffer(there, near, quad_segs=2000)  # chords of its arcs are within 1e-7 of `near`
    for parts, expected in ((beyond, line.difference(area)), (within, line.intersection(area))):
        assert sum(part.length for part in parts) == pytest.approx(expected.length, abs=1e-6)
        assert (
            shapely.hausdorff_distance(shapely.union_all(parts), expected) < 1e-5
        )  # grazing: the root of 1e-7 near
    assert sum(part.length for part in (*beyond, *within)) == pytest.approx(line.length, rel=1e-12)
