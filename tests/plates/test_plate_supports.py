"""What supports hold: edges in any direction, corners, curves, mirrors, springs, and the unknowns behind them."""

from fractions import Fraction

import numpy as np
import pytest
from shapely.geometry import LineString, MultiPoint, Point, box

from lamc import plate
from lamc.basics.errors import DesignError
from lamc.plates.dofs import Dofs, mapped
from lamc.plates.elements.definition import SQUARE
from lamc.plates.solving.constraints import constraints
from lamc.plates.solving.equations import support_equations
from tests.support.plates import disk, isotropic, jittered, richardson, turned

BOUNDARY = "boundary"
LEFT, RIGHT = LineString([(0, 0), (0, 1)]), LineString([(1, 0), (1, 1)])
BOTTOM, TOP = LineString([(0, 0), (1, 0)]), LineString([(0, 1), (1, 1)])


def deflections(mesh: plate.Mesh, *supports: object, load: object = None, element: str = "dkt") -> np.ndarray:
    problem = plate.Problem(
        mesh, isotropic(), element, supports=supports, loads=[load or plate.Pressure(1.0)]
    )
    return plate.solve(problem).at_nodes("w")


@pytest.mark.parametrize("degrees", [30.0, 45.0, 101.0])
@pytest.mark.parametrize("support", [plate.SimplySupported(BOUNDARY), plate.Clamped(BOUNDARY)])
def test_a_turned_plate_deflects_alike(support: object, degrees: float) -> None:
    # Edges along no axis: the slopes of a hard support are turned into the edge's own axes.
    mesh = jittered(plate.grid(1.0, 0.7, 8, 6, "union-jack"))
    here, there = deflections(mesh, support), deflections(turned(mesh, degrees, (3.0, 1.0)), support)
    assert there == pytest.approx(here, abs=1e-11 * here.max())  # coordinates are rounded


def test_a_turned_mirror_is_a_mirror() -> None:
    # A quarter of a square, cut by mirrors, turned by 20°; its corner is the middle of the whole.
    whole = deflections(plate.grid(1.0, 1.0, 8, 8, "union-jack"), plate.SimplySupported(BOUNDARY)).max()
    quarter = plate.grid(0.5, 0.5, 4, 4, "union-jack")
    rotation = np.radians(20.0)

    def side(*points: tuple[float, float]) -> LineString:
        c, s = np.cos(rotation), np.sin(rotation)
        return LineString([(c * x - s * y, s * x + c * y) for x, y in points])

    w = deflections(
        turned(quarter, 20.0),
        plate.SimplySupported(side((0.5, 0), (0, 0), (0, 0.5))),
        plate.Symmetry(side((0.5, 0), (0.5, 0.5), (0, 0.5))),
    )
    assert w.max() == pytest.approx(whole, rel=1e-11)


def test_half_a_square_along_its_diagonal_is_the_square() -> None:
    # Its mirror is an oblique edge, which meets the supported edges at corners of 45°.
    n = 8
    whole = plate.grid(1.0, 1.0, n, n, "one-diagonal")
    below = whole.points[whole.cells].mean(axis=1)
    lower = whole.cells[below[:, 0] > below[:, 1]]
    used, cells = np.unique(lower, return_inverse=True)
    half = plate.Mesh(whole.points[used], cells.reshape(lower.shape))
    mirror = plate.Symmetry(LineString([(0, 0), (1, 1)]))
    edges = plate.SimplySupported(LineString([(0, 0), (1, 0), (1, 1)]))
    both = deflections(whole, plate.SimplySupported(BOUNDARY))
    assert deflections(half, edges, mirror) == pytest.approx(both[used], abs=1e-12 * both.max())


def test_a_disk_on_a_polygon_turns_freely_at_its_edge() -> None:
    # Timoshenko and Woinowsky-Krieger, section 16: w0 = (5 + ν) / (64 (1 + ν)) q R⁴ / D. Holding w = 0 along the
    # sides of the polygon, or both slopes at its vertices, would converge to other plates (w0 lower by 30 % and 75 %).
    exact = 5.3 / (64.0 * 1.3)
    values = [deflections(disk(n), plate.SimplySupported(BOUNDARY))[0] for n in (8, 16)]
    assert richardson(*values) == pytest.approx(exact, rel=1e-3)
    assert values[0] == pytest.approx(exact, rel=0.01)  # h² = 1/64 with a factor well below one


@pytest.mark.parametrize(("rotation", "held"), [(20.0, 1), (79.0, 1), (81.0, 2), (90.0, 2), (150.0, 2)])
def test_simple_edges_that_turn_by_less_than_eighty_degrees_are_one_curve(rotation: float, held: int) -> None:
    a = np.radians(rotation)
    between = 1.5 * np.pi - 0.5 * a
    apex, before, after = np.zeros(2), np.array([-1.0, 0.0]), np.array([np.cos(a), -np.sin(a)])
    far = np.array([np.cos(between), np.sin(between)])
    mesh = plate.Mesh(np.array([apex, before, far, after]), np.array([[0, 1, 2], [0, 2, 3]]))
    problem = plate.Problem(
        mesh, isotropic(), supports=[plate.SimplySupported(LineString([before, apex, after]))]
    )
    found = constraints(problem, support_equations(problem))
    slopes = [problem.dofs.of(name)[0] for name in ("w_x", "w_y")]
    rows = found.fixed[found.nodes == 0][:, slopes].toarray()
    rows = rows[np.abs(rows).sum(axis=1) > 0]
    assert np.linalg.matrix_rank(rows) == held
    if held == 1:  # the mean direction of both edges
        assert np.abs(rows[0] @ [np.sin(a / 2), np.cos(a / 2)]) < 1e-12


def test_soft_edges_are_softer_than_hard_ones_and_tend_to_the_same() -> None:
    gaps = []
    for n in (8, 16):
        hard, soft = (
            deflections(plate.grid(1.0, 1.0, n, n), plate.SimplySupported(BOUNDARY, kind)).max()
            for kind in ("hard", "soft")
        )
        gaps.append(soft / hard - 1.0)
    assert gaps[0] > gaps[1] > 0.0
    assert gaps[1] < 0.6 * gaps[0]


def test_elastic_hinges_lie_between_supported_and_clamped() -> None:
    # A strip of length L between mirrors on two hinges of stiffness k: the end moment M = (q L²/12) / (1 + 2 D/(k L)).
    L, D, q = 2.0, 1.0, 3.0
    mesh = plate.grid(L, 0.5, 64, 4)
    sides = [plate.Symmetry(LineString([(0, y), (L, y)])) for y in (0.0, 0.5)]
    ends = [LineString([(x, 0), (x, 0.5)]) for x in (0.0, L)]
    for k in (0.1, 1.0, 100.0):
        solution = plate.solve(
            plate.Problem(
                mesh,
                isotropic(D),
                supports=[*sides, *(plate.Hinged(end, k) for end in ends)],
                loads=[plate.Pressure(q)],
            )
        )
        moment = q * L**2 / 12.0 / (1.0 + 2.0 * D / (k * L))
        exact = 5.0 * q * L**4 / (384.0 * D) - moment * L**2 / (8.0 * D)
        assert float(solution.deflection(L / 2, 0.25)) == pytest.approx(exact, rel=1e-3)  # h² = 1/1024
        # On the left the plate turns about -y, and the spring turns it back.
        assert solution.reactions[2].moment[1] == pytest.approx(moment * 0.5, rel=2e-3)
        assert solution.strain_energy == pytest.approx(0.5 * solution.compliance, rel=1e-11)


def test_a_spring_alone_keeps_a_plate_from_turning() -> None:
    # Hinged on the left, free elsewhere: θ = m / k for a moment m per length at the right end, plus bending.
    mesh = plate.grid(1.0, 1.0, 4, 4)
    k, m = 1e-3, 0.2
    problem = plate.Problem(
        mesh, isotropic(nu=0.0), supports=[plate.Hinged(LEFT, k)], loads=[plate.EdgeMoment(RIGHT, m)]
    )
    solution = plate.solve(problem)
    assert -float(solution.slope(0.0, 0.5)[0]) == pytest.approx(m / k, rel=1e-12)
    assert -float(solution.slope(1.0, 0.5)[0]) == pytest.approx(m / k + m, rel=1e-12)
    assert solution.report.free == ""


def test_an_inner_line_of_supports_makes_two_fields_of_one() -> None:
    # A strip over three supports, between mirrors: the middle reaction is 5/4 of q L per field (three moments).
    L = 1.0
    mesh = plate.grid(2 * L, 0.25, 64, 8)
    lines = [LineString([(x, 0), (x, 0.25)]) for x in (0.0, L, 2 * L)]
    sides = [plate.Symmetry(LineString([(0, y), (2 * L, y)])) for y in (0.0, 0.25)]
    solution = plate.solve(
        plate.Problem(
            mesh,
            isotropic(),
            supports=[*(plate.SimplySupported(line) for line in lines), *sides],
            loads=[plate.Pressure(1.0)],
        )
    )
    forces = [reaction.force[2] for reaction in solution.reactions[:3]]
    assert forces == pytest.approx([-0.375 * 0.25, -1.25 * 0.25, -0.375 * 0.25], rel=2e-3)  # h² = 1/1024


def test_a_region_can_be_held() -> None:
    mesh = plate.grid(1.0, 1.0, 8, 8)
    patch = box(0.0, 0.0, 0.25, 1.0)
    held = plate.solve(
        plate.Problem(mesh, isotropic(), supports=[plate.Clamped(patch)], loads=[plate.Pressure(1.0)])
    )
    shorter = plate.grid(0.75, 1.0, 6, 8, origin=(0.25, 0.0))
    edge = plate.Clamped(LineString([(0.25, 0), (0.25, 1)]))
    free = plate.solve(plate.Problem(shorter, isotropic(), supports=[edge], loads=[plate.Pressure(1.0)]))
    assert float(held.deflection(1.0, 0.5)) == pytest.approx(float(free.deflection(1.0, 0.5)), rel=1e-11)
    assert float(held.deflection(0.2, 0.5)) == 0.0


def test_four_corner_posts_share_the_weight() -> None:
    posts = [plate.Support(Point(x, y), ("w",)) for x in (0, 1) for y in (0, 1)]
    solution = plate.solve(
        plate.Problem(
            plate.grid(1.0, 1.0, 8, 8, "union-jack"), isotropic(), supports=posts, loads=[plate.Pressure(2.0)]
        )
    )
    assert [r.force[2] for r in solution.reactions] == pytest.approx([-0.5] * 4, rel=1e-12)
    together = plate.Support(MultiPoint([(0, 0), (1, 0), (0, 1), (1, 1)]), ("w",))
    one = plate.solve(
        plate.Problem(
            plate.grid(1.0, 1.0, 8, 8), isotropic(), supports=[together], loads=[plate.Pressure(2.0)]
        )
    )
    assert one.reactions[0].force[2] == pytest.approx(-2.0, rel=1e-12)
    assert one.reactions[0].moment == pytest.approx([-1.0, 1.0, 0.0], rel=1e-9)


def test_corner_forces_hold_a_supported_square_down() -> None:
    # Timoshenko and Woinowsky-Krieger, table 8: each corner of a square under q is held down by 0.065 q a².
    solution = plate.solve(
        plate.Problem(
            plate.grid(1.0, 1.0, 48, 48, "union-jack"),
            isotropic(),
            supports=[plate.SimplySupported(BOUNDARY, "soft")],
            loads=[plate.Pressure(1.0)],
        )
    )
    reaction = solution.reactions[0]
    at = solution.problem.dofs.points[reaction.nodes]
    corner = np.isin(at, (0.0, 1.0)).all(axis=1)
    assert reaction.values[corner, 2] == pytest.approx(
        [0.065] * 4, abs=0.01
    )  # the node has its share of the edge too
    assert reaction.force[2] == pytest.approx(-1.0, rel=1e-12)


def test_supports_that_agree_are_no_contradiction() -> None:
    mesh = plate.grid(1.0, 1.0, 6, 6)
    one = deflections(mesh, plate.Clamped(BOUNDARY))
    more = deflections(
        mesh, plate.SimplySupported(LEFT), plate.Clamped(BOUNDARY), plate.Support(Point(0, 0), ("w_x",))
    )
    assert more == pytest.approx(one, abs=1e-14 * one.max())


def test_supports_that_contradict_each_other_are_named() -> None:
    words = r"contradict each other at \(0, 0\): Support \(number 2\) asks for 0.1, Clamped \(number 1\) asks for 0;"
    with pytest.raises(DesignError, match=words):
        deflections(plate.grid(1.0, 1.0, 3, 3), plate.Clamped(LEFT), plate.Support(LEFT, ("w",), 0.1))


def test_oblique_supports_that_contradict_each_other_are_found() -> None:
    mesh = turned(plate.grid(1.0, 1.0, 3, 3), 30.0)
    c, s = np.cos(np.pi / 6), np.sin(np.pi / 6)
    edge = LineString([(0, 0), (c, s)])
    with pytest.raises(DesignError, match="contradict"):  # the slope along the edge is held at zero already
        deflections(mesh, plate.SimplySupported(edge), plate.Support(edge, ("w_x", "w_y"), 0.1))


@pytest.mark.parametrize("degrees", [0.0, 30.0])
def test_what_is_free_is_gathered_as_a_product_of_matrices_would(degrees: float) -> None:
    mesh = turned(jittered(plate.grid(1.0, 1.0, 5, 4)), degrees)
    made = plate.FactoredPlate(
        plate.Problem(mesh, isotropic(), "dkt+lst", [plate.SimplySupported(BOUNDARY)])
    ).system
    free = made.constraints.free
    product = (free.T @ made.stiffness @ free).toarray()
    gathered = made.pattern.reduction(made.stiffness).matrix(made.stiffness.data)
    assert gathered.has_sorted_indices
    assert gathered.toarray() == pytest.approx(product, abs=1e-15 * np.abs(product).max())
    held = made.constraints.fixed
    assert abs(held @ free).max() < 1e-15  # what is held and what is free span everything, at right angles
    assert held.shape[0] + free.shape[1] == free.shape[0]
    assert np.abs((held @ held.T).toarray() - np.eye(held.shape[0])).max() < 1e-15


# --- numbers of unknowns ---


@pytest.mark.parametrize("name", ["dkt", "lst", "dkt+lst", "dkt+cst"])
def test_cells_agree_on_where_their_common_nodes_are(name: str) -> None:
    mesh = jittered(plate.grid(2.0, 1.0, 5, 4, "union-jack"))
    check_common_nodes(Dofs(mesh, plate.element(name)))


@pytest.mark.parametrize("name", ["bfs", "q4", "q8", "q9", "q12", "bfs+q12"])
def test_squares_agree_on_where_their_common_nodes_are(name: str) -> None:
    mesh = plate.grid(2.0, 1.0, 5, 4, "squares")
    # Cells that begin at any corner, so that neighbours see an edge from either end; those that bend must not.
    shifts = np.random.default_rng(3).integers(0, 1 if plate.element(name).bends else 4, len(mesh.cells))
    cells = np.array([np.roll(cell, k) for cell, k in zip(mesh.cells, shifts, strict=True)])
    check_common_nodes(Dofs(plate.Mesh(mesh.points, cells), plate.element(name)))


def check_common_nodes(dofs: Dofs) -> None:
    for k, node in enumerate(dofs.element.nodes):
        at = np.array([float(Fraction(value)) for value in node.at])
        own = mapped(dofs.element.cell, dofs.mesh.corners, at)
        assert own == pytest.approx(dofs.points[dofs.of_nodes[:, k]], abs=1e-12)
    # Every unknown is used, and the count follows from points, edges and cells.
    assert np.array_equal(np.unique(dofs.of_cells), np.arange(dofs.count))
    corners = dofs.mesh.corner_count
    kinds = {"corner": 0, "edge": 0, "cell": 0}
    for node in dofs.element.nodes:
        a, b = node.at
        square = dofs.element.cell == SQUARE
        edges = (abs(a) == 1, abs(b) == 1) if square else (a == 0, b == 0, a + b == 1)
        kinds[("cell", "edge", "corner")[min(sum(edges), 2)]] += len(node.dofs)
    expected = (
        len(dofs.mesh.points) * kinds["corner"] // corners
        + len(dofs.mesh.edges) * kinds["edge"] // corners
        + len(dofs.mesh.cells) * kinds["cell"]
    )
    assert dofs.count == expected


def test_an_element_for_other_cells_is_refused() -> None:
    with pytest.raises(DesignError, match="element 'q4' is for quadrilaterals, and the mesh has triangles"):
        Dofs(plate.grid(1.0, 1.0, 2, 2), plate.element("q4"))


FIBRES = plate.Material(E1=140e9, E2=9e9, nu12=0.3, G12=5e9, density=1600.0)


def mirrored(angles: list[float], line: LineString, mesh: plate.Mesh | None = None) -> plate.Problem:
    laminate = plate.Laminate([plate.Ply(FIBRES, 1e-4, angle) for angle in angles])
    held = [plate.SimplySupported(BOUNDARY), plate.Symmetry(line)]
    return plate.Problem(mesh or plate.grid(1, 1, 4, 4), laminate, supports=held, loads=[plate.Pressure(1.0)])


@pytest.mark.parametrize(
    ("angles", "term"),
    [([45.0], "D[12]6 of 0.83"), ([30.0, -30.0], "B[12]6"), ([45.0, -45.0, -45.0, 45.0], "D[12]6")],
)
def test_a_mirror_along_a_laminate_that_couples_across_it_is_refused(angles: list[float], term: str) -> None:
    with pytest.raises(DesignError, match=rf"Symmetry support at .* along 90°, .* region '' has a {term}"):
        mirrored(angles, RIGHT)


@pytest.mark.parametrize("angles", [[0.0], [0.0, 90.0], [90.0, 0.0, 0.0, 90.0]])
def test_a_mirror_along_a_cross_ply_is_a_mirror(angles: list[float]) -> None:
    assert plate.solve(mirrored(angles, RIGHT)).at_nodes("w").max() > 0.0


def test_what_a_mirror_needs_is_judged_in_the_edges_own_axes() -> None:
    # A ply along or across an oblique mirror is symmetric to it, and one along x is not.
    n = 4
    whole = plate.grid(1.0, 1.0, n, n, "one-diagonal")
    below = whole.points[whole.cells].mean(axis=1)
    lower = whole.cells[below[:, 0] > below[:, 1]]
    used, cells = np.unique(lower, return_inverse=True)
    half = plate.Mesh(whole.points[used], cells.reshape(lower.shape))
    diagonal = LineString([(0, 0), (1, 1)])
    for angle in (45.0, -45.0, 135.0):
        mirrored([angle], diagonal, half)
    with pytest.raises(DesignError, match=r"along 45°, .* D[12]6"):
        mirrored([0.0], diagonal, half)


def test_a_mirror_is_judged_again_with_other_laminates_and_by_what_bears() -> None:
    problem = mirrored([0.0], RIGHT)
    with pytest.raises(DesignError, match=r"Symmetry support .* D[12]6"):
        problem.with_laminate(plate.Laminate([plate.Ply(FIBRES, 1e-4, 10.0)]))
    # A and B of this stack have no such terms, so a membrane may have the mirror; D has, so a plate may not.
    twisted = plate.Laminate([plate.Ply(FIBRES, 1e-4, angle) for angle in (45.0, -45.0, -45.0, 45.0)])
    mirror = [plate.Symmetry(RIGHT)]
    assert plate.Problem(plate.grid(1, 1, 2, 2), twisted, "cst", supports=mirror).supports
    with pytest.raises(DesignError, match=r"D[12]6"):
        plate.Problem(plate.grid(1, 1, 2, 2), twisted, "dkt+cst", supports=mirror)
