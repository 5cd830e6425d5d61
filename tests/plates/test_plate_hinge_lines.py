"""Hinge lines inside plates, against beams and plates with hinges in them as textbooks solve them.

A strip of ν = 0 bends as a beam of bending stiffness D b; a hinge line across it of stiffness k per length is a
rotational spring k b. The rectangle (bfs) has the cubic of a beam and is exact in statics.
"""

import numpy as np
import pytest
import shapely.affinity
from scipy.optimize import brentq
from shapely.geometry import LineString, Point, box

from lamc import plate
from tests.support.plate_meshes import FAMILIES
from tests.support.plates import disk, isotropic, richardson

D, L, B = 2.0, 1.0, 0.25  # N·m, m, m
LEFT, RIGHT = LineString([(0, 0), (0, B)]), LineString([(L, 0), (L, B)])
ROUND_OFF = 1e-9  # of a result of a factored system of condition 1e12, refined


def across(x: float) -> LineString:
    return LineString([(x, -0.0), (x, B)])


def strip(*hinges: plate.HingeLine, element: str = "bfs", n: int = 8, **more: object) -> plate.Problem:
    pattern = "squares" if element == "bfs" else "union-jack"
    mesh = plate.grid(L, B, n, 2, pattern)
    return plate.Problem(mesh, isotropic(D, nu=0.0, density=1.0), element, hinges=hinges, **more)  # type: ignore[arg-type]


@pytest.mark.parametrize("stiffness", [1e-6, 1e-2, 1.0, 1e3, 1e12])
def test_a_cantilever_of_two_links_bends_and_folds(stiffness: float) -> None:
    # Beam: P L³ / 3 D; the hinge at a carries the moment P (L - a) and turns the rest by P (L - a) / k.
    P, a, k = 0.3, 0.375, stiffness * D / L
    line = plate.HingeLine(across(a), k)
    solution = plate.solve(strip(line, supports=[plate.Clamped(LEFT)], loads=[plate.EdgeLoad(RIGHT, P)]))
    expected = P * L**3 / (3 * D) + P * (L - a) ** 2 / k
    assert solution.deflection(L, 0.5 * B) == pytest.approx(expected, rel=ROUND_OFF)
    # Both sides rise from a hinge that opens upwards under a force upwards at the tip: a valley.
    assert solution.hinge_rotation(a, [0.0, 0.1, B]) == pytest.approx(P * (L - a) / k, rel=1e-6)
    (turn,) = solution.hinges
    # At 1e12 the rotation is 1e-12 of the slopes, which are known to 19 digits.
    assert turn.largest == pytest.approx(P * (L - a) / k, rel=1e-6)
    assert turn.moment == pytest.approx(np.full((2, 2), P * (L - a)), rel=1e-6)
    assert turn.energy == pytest.approx(0.5 * k * B * (P * (L - a) / k) ** 2, rel=1e-6)
    # The moment across the line on the plate's side: M = -D w'' = -P (L - x), and the spring's is against it.
    assert solution.moments(a - 1e-9, 0.1)[0] == pytest.approx(-P * (L - a), rel=1e-6)
    assert solution.strain_energy == pytest.approx(0.5 * solution.compliance, rel=ROUND_OFF)


@pytest.mark.parametrize("element", ["dkt", "bciz", "specht", "dkt+cst", "specht+lst"])
@pytest.mark.quick("dkt", "bciz", "dkt+cst")
def test_triangles_tend_to_the_beam_with_a_hinge(element: str) -> None:
    P, a, k = 0.3, 0.375, 0.7 * D / L
    expected = P * L**3 / (3 * D) + P * (L - a) ** 2 / k
    supports, loads = [plate.Clamped(LEFT)], [plate.EdgeLoad(RIGHT, P)]
    line = plate.HingeLine(across(a), k)

    def off(n: int) -> float:
        mesh = plate.grid(L, B, n, n // 4, "one-diagonal")
        problem = plate.Problem(mesh, isotropic(D, nu=0.0), element, supports, loads, hinges=[line])
        return abs(float(plate.solve(problem).deflection(L, 0.5 * B)) / expected - 1.0)

    assert off(16) < 1e-3  # of second order: 3e-3 on 8 cells
    assert off(32) < 0.3 * off(16)


@pytest.mark.parametrize("element", ["bfs+q4", "bfs+q8", "bfs+q9", "bfs+q12"])
@pytest.mark.slow
@pytest.mark.ci("bfs+q4")
def test_rectangles_with_membranes_fold_as_exactly(element: str) -> None:
    P, a, k = 0.3, 0.375, 0.7
    mesh = plate.grid(L, B, 8, 2, "squares")
    made = {"supports": [plate.Clamped(LEFT)], "loads": [plate.EdgeLoad(RIGHT, (2.0, 0.0, P))]}
    line = plate.HingeLine(across(a), k)
    solution = plate.solve(plate.Problem(mesh, isotropic(D, nu=0.0), element, hinges=[line], **made))  # type: ignore[arg-type]
    expected = P * L**3 / (3 * D) + P * (L - a) ** 2 / k
    assert solution.deflection(L, 0.5 * B) == pytest.approx(expected, rel=ROUND_OFF)
    # In the plane nothing is hinged: N L / (E h), with D = E h³ / 12 and h = 1 mm.
    assert solution.displacement(L, 0.1)[0] == pytest.approx(2.0 * L / (12 * D / 1e-6), rel=ROUND_OFF)


def test_a_supported_strip_sags_in_its_middle_hinge() -> None:
    # P at the middle: P L³ / 48 D of the beam, and the rotation M / k = P L / 4 k times L / 4.
    P, k = -1.0, 3.0
    solution = plate.solve(
        strip(
            plate.HingeLine(across(L / 2), k),
            supports=[plate.SimplySupported(LEFT), plate.SimplySupported(RIGHT)],
            loads=[plate.EdgeLoad(across(L / 2), P)],
        )
    )
    expected = P * L**3 / (48 * D) + P * L**2 / (16 * k)
    assert solution.deflection(L / 2, 0.1) == pytest.approx(expected, rel=ROUND_OFF)
    assert solution.hinges[0].largest == pytest.approx(-P * L / (4 * k), rel=ROUND_OFF)


def test_a_free_hinge_between_clamps_leaves_two_cantilevers() -> None:
    # Under a uniform load symmetry leaves no force in the hinge: q (L/2)⁴ / 8 D each.
    q = 1.5
    solution = plate.solve(
        strip(
            plate.HingeLine(across(L / 2)),
            supports=[plate.Clamped(LEFT), plate.Clamped(RIGHT)],
            loads=[plate.Pressure(q)],
        )
    )
    # A cubic's nodes are exact under the consistent load of a uniform pressure.
    assert solution.deflection(L / 2, 0.1) == pytest.approx(q * (L / 2) ** 4 / (8 * D), rel=ROUND_OFF)
    force = sum(reaction.force for reaction in solution.reactions)
    assert force == pytest.approx([0.0, 0.0, -q * L * B], abs=1e-12)
    # M = 0 in the hinge up to what a linear moment makes of a parabola in an element: q h² / 12, h = L / 8.
    assert abs(solution.moments(L / 2 - 1e-9, 0.1)[0]) < 1.001 * q * (L / 8) ** 2 / 12


def test_four_links_in_a_row_add_up() -> None:
    # Each hinge at a turns by P (L - a) / k and moves the tip by (L - a) times that.
    P, places, k = 1.0, (0.25, 0.5, 0.75), (0.5, 2.0, 1e-3)
    lines = [plate.HingeLine(across(a), each) for a, each in zip(places, k, strict=True)]
    solution = plate.solve(strip(*lines, supports=[plate.Clamped(LEFT)], loads=[plate.EdgeLoad(RIGHT, P)]))
    folds = sum(P * (L - a) ** 2 / each for a, each in zip(places, k, strict=True))
    assert solution.deflection(L, 0.1) == pytest.approx(P * L**3 / (3 * D) + folds, rel=ROUND_OFF)


def test_a_soft_strip_tends_to_the_line() -> None:
    """A strip of width s and stiffness D_s = k s about the line turns as the line does, but for O(s)."""
    P, a, k = 1.0, 0.5, 0.2
    loads, supports = [plate.EdgeLoad(RIGHT, P)], [plate.Clamped(LEFT)]
    line = plate.HingeLine(across(a), k)
    hinged = plate.solve(strip(line, supports=supports, loads=loads)).deflection(L, 0.1)

    def off(s: float) -> float:
        xs = np.concatenate([np.linspace(0, a - s / 2, 5), np.linspace(a + s / 2, L, 5)])
        mesh = plate.grid_of_lines(xs, np.linspace(0, B, 3), "squares")
        soft = np.abs(mesh.corners.mean(axis=1)[:, 0] - a) < s / 2
        mesh = plate.Mesh(mesh.points, mesh.cells, soft.astype(np.int32), ("link", "strip"))
        laminates = {"link": isotropic(D, nu=0.0), "strip": isotropic(k * s, nu=0.0)}
        solved = plate.solve(plate.Problem(mesh, laminates, "bfs", supports, loads))
        return float(solved.deflection(L, 0.1) - hinged)

    # The moment P (L - x) over the strip has the same mean and adds P s² / 12 k; the links are shorter by s/2 each:
    # -P (L - a)² s / D.
    for s in (0.02, 0.01):
        expected = P * s**2 / (12 * k) - (P / (3 * D)) * ((L - a + s / 2) ** 3 - (L - a - s / 2) ** 3)
        assert off(s) == pytest.approx(expected, rel=1e-6)


# --- vibration and buckling ------------------------------------------------------------------------------------------


def beam_frequencies(a: float, k: float, count: int) -> list[float]:
    """β of a cantilever with a rotational spring k (over D) at a, from the 8 conditions of its two parts."""

    def determinant(beta: float) -> float:
        def row(
            x: float, order: int
        ) -> np.ndarray:  # a derivative of cos, sin, cosh, sinh of βx, over β^order
            c, s, ch, sh = np.cos(beta * x), np.sin(beta * x), np.cosh(beta * x), np.sinh(beta * x)
            turn = [(c, s), (-s, c), (-c, -s), (s, -c)][order]
            return np.array([*turn, *((ch, sh) if order % 2 == 0 else (sh, ch))])

        none = np.zeros(4)
        return float(
            np.linalg.det(
                np.array(
                    [
                        [*row(0, 0), *none],
                        [*row(0, 1), *none],
                        [*row(a, 0), *-row(a, 0)],
                        [*row(a, 2), *-row(a, 2)],
                        [*row(a, 3), *-row(a, 3)],
                        [*(beta * row(a, 2) + k * row(a, 1)), *(-k * row(a, 1))],
                        [*none, *row(L, 2)],
                        [*none, *row(L, 3)],
                    ]
                )
            )
        )

    # The determinant grows as e^β: its sign is what counts.
    found, step = [], np.linspace(0.05, 20.0, 4000)
    values = [determinant(b) for b in step]
    for b0, b1, v0, v1 in zip(step, step[1:], values, values[1:], strict=False):
        if v0 * v1 < 0.0 and len(found) < count:
            found.append(float(brentq(determinant, b0, b1, xtol=1e-13)))
    return found


@pytest.mark.parametrize("k", [1e-3, 1.0, 50.0])
def test_two_links_on_a_spring_vibrate_as_a_beam_does(k: float) -> None:
    a, rho = 0.375, 1e-3  # areal mass: density 1 times 1 mm
    problem = strip(plate.HingeLine(across(a), k * D), n=32, supports=[plate.Clamped(LEFT)])
    # Only what bends along x: a strip of ν = 0 also twists and bends across.
    found = plate.modes(problem, 14)
    middle = problem.mesh.points[:, 1] == 0.5 * B
    shapes = found.shapes[: len(problem.mesh.points)]
    edge = problem.mesh.points[:, 1] == 0.0
    flat = [j for j in range(14) if np.allclose(shapes[middle, j], shapes[edge, j], rtol=0.0, atol=1e-6)]
    expected = [np.sqrt(D / rho) * b**2 for b in beam_frequencies(a, k, 3)]
    # Cubics: an error of (βh)⁴ / 720, 1e-6 for the third mode with 32 cells.
    assert found.omega[flat[:3]] == pytest.approx(expected, rel=3e-6)


@pytest.mark.parametrize("k", [0.1, 2.0, 1e3])
def test_a_supported_strip_with_a_middle_hinge_buckles(k: float) -> None:
    # w = sin βx on either side of the hinge; its moment P w is that of the spring, 2 k β cos βL/2: P = D β².
    problem = strip(
        plate.HingeLine(across(L / 2), k),
        n=32,
        supports=[plate.SimplySupported(LEFT), plate.SimplySupported(RIGHT)],
    )
    beta = brentq(lambda b: D * b * np.sin(b * L / 2) - 2 * k * np.cos(b * L / 2), 1e-9, np.pi / L)
    found = plate.buckling(problem, 1, forces=(-1.0, 0.0, 0.0))
    assert found.critical == pytest.approx(D * beta**2, rel=1e-6)  # cubics, as above


# --- limits ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("element", ["dkt", "bciz", "specht", "dkt+cst", "dkt+lst"])
@pytest.mark.parametrize("family", FAMILIES[:4])
@pytest.mark.quick("*-dkt", "*-bciz", "*-specht", "*-dkt+cst")
def test_a_hinge_of_great_stiffness_is_none(family: str, element: str) -> None:
    # A line through the middle of a square, and a load that bends and twists: the same unknowns at every node.
    mesh = plate.grid(1.0, 1.0, 6, 6, family) if family != "jittered" else plate.grid(1.0, 1.0, 6, 6)
    line = LineString([(0.5, 0), (0.5, 1)])
    if family == "jittered":
        on = np.abs(mesh.points[:, 0] - 0.5) < 1e-9
        shaken = plate.jittered(mesh, 0.2)
        mesh = plate.Mesh(np.where(on[:, None], mesh.points, shaken.points), mesh.cells)
    made = {
        "supports": [plate.Clamped(LineString([(0, 0), (0, 1)]))],
        "loads": [plate.Pressure(1.0), plate.PointLoad((1, 0.2), 0.3)],
    }
    whole = plate.solve(plate.Problem(mesh, isotropic(D), element, **made))  # type: ignore[arg-type]
    hinged = plate.solve(
        plate.Problem(mesh, isotropic(D), element, hinges=[plate.HingeLine(line, 1e12 * D)], **made)  # type: ignore[arg-type]
    )
    count = len(whole.at_nodes("w"))
    for name in ("w", "w_x", "w_y"):
        # The rotation that is left is 1e-12 of the moment over D.
        wanted, found = whole.at_nodes(name), hinged.at_nodes(name)[:count]
        assert found == pytest.approx(wanted, abs=1e-10 * np.nanmax(np.abs(wanted)), nan_ok=True)


def test_refined_digits_hold_for_soft_hinges() -> None:
    # Rotation 1e6 times the bending: exact but for round-off, whatever the condition.
    P, a, k = 1.0, 0.5, 1e-6 * D / L
    solution = plate.solve(
        strip(
            plate.HingeLine(across(a), k),
            element="dkt",
            supports=[plate.Clamped(LEFT)],
            loads=[plate.EdgeLoad(RIGHT, P)],
        )
    )
    assert solution.report.accuracy.forward_error < 1e-12
    assert solution.hinges[0].largest == pytest.approx(P * (L - a) / k, rel=1e-9)


def test_units_do_not_matter() -> None:
    """The same plate in mm and N·mm: lengths 1000 times, bending stiffness in N·mm 1000 times."""

    line = LineString([(0.25, 0), (0.5, B)])
    mesh = plate.mesh(box(0, 0, L, B), 0.08, follow=[line])

    def tip(unit: float) -> tuple[float, float]:
        def sized(where: LineString) -> LineString:
            return shapely.affinity.scale(where, unit, unit, origin=(0, 0))

        problem = plate.Problem(
            plate.Mesh(mesh.points * unit, mesh.cells),
            isotropic(D * unit, h=1e-3 * unit),
            supports=[plate.Clamped(sized(LEFT))],
            loads=[plate.PointLoad((L * unit, 0.0), 0.2)],
            hinges=[plate.HingeLine(sized(line), 0.7)],
        )
        found = plate.solve(problem)
        return float(found.deflection(L * unit, 0.0)) / unit, found.hinges[0].largest

    assert tip(1e3) == pytest.approx(tip(1.0), rel=1e-9)
    assert tip(1e-6) == pytest.approx(tip(1.0), rel=1e-9)


# --- curves and vertices ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize("k", [0.0, 1.5])
def test_a_ring_of_hinge_in_a_round_plate(k: float) -> None:
    """Uniform load, simply supported: the shear is q r / 2, so on both sides w = q r⁴ / 64 D + A + B r² (+ C ln r)."""
    q, nu, a = 1.0, 0.3, 0.5

    def particular(r: float) -> tuple[float, float, float]:  # w, slope and M_r
        return q * r**4 / (64 * D), q * r**3 / (16 * D), -q * r**2 * (3 + nu) / 16

    def terms(r: float) -> np.ndarray:  # of 1, r², ln r
        return np.array(
            [[1, r * r, np.log(r)], [0, 2 * r, 1 / r], [0, -2 * D * (1 + nu), D * (1 - nu) / r**2]]
        )

    inner, outer, rim = terms(a)[:, :2], terms(a), terms(1.0)
    none2 = np.zeros(2)
    rows = [
        [*inner[0], *-outer[0]],  # w
        [*inner[2], *-outer[2]],  # M_r
        [*none2, *rim[0]],  # w = 0
        [*none2, *rim[2]],  # M_r = 0
        [*(inner[2] - k * inner[1]), *(k * outer[1])],  # M_r = -k (slope outside - slope inside)
    ]
    _, _, moment = particular(a)
    right = [0.0, 0.0, -particular(1.0)[0], -particular(1.0)[2], -moment]
    centre = float(np.linalg.solve(np.array(rows), right)[0])
    jump = 0.0

    def found(rings: int) -> float:
        mesh = disk(rings)
        angles = np.arange(3 * rings) * (2.0 * np.pi / (3 * rings))
        ring = a * np.stack([np.cos(angles), np.sin(angles)], axis=1)
        problem = plate.Problem(
            mesh,
            isotropic(D, nu),
            supports=[plate.SimplySupported("boundary")],
            loads=[plate.Pressure(q)],
            hinges=[plate.HingeLine(LineString([*ring, ring[0]]), k)],
        )
        solution = plate.solve(problem)
        nonlocal jump
        jump = solution.hinges[0].largest
        return float(solution.deflection(0.0, 0.0))

    coarse, fine = found(8), found(16)
    assert fine == pytest.approx(centre, rel=5e-3)
    assert richardson(coarse, fine) == pytest.approx(centre, rel=5e-4)
    slope = np.linalg.solve(np.array(rows), right)
    expected = float(terms(a)[1] @ slope[2:] - terms(a)[1, :2] @ slope[:2])
    assert jump == pytest.approx(expected, rel=2e-2)  # the slope is of first order


def test_a_flat_vertex_has_the_folds_that_close_around_it() -> None:
    # n lines that meet: Σ φ_j n_j = 0 takes two of n rotations. Beside them a free plate has three rigid motions.
    mesh = plate.grid(1.0, 1.0, 8, 8, "union-jack")
    ends = [(1, 0.5), (1, 1), (0.5, 1), (0, 0.5), (0, 0), (0.5, 0), (1, 0)]
    for count in (3, 4, 5, 6):
        lines = [plate.HingeLine(LineString([(0.5, 0.5), end])) for end in ends[:count]]
        problem = plate.Problem(mesh, isotropic(D, density=1.0), hinges=lines)
        found = plate.modes(problem, 8)
        rigid = len(found.rigid)
        closing = np.linalg.matrix_rank(np.array(ends[:count]) - 0.5)
        assert rigid == 3 + count - closing
        assert sum(name.startswith("fold") for name in found.rigid) == count - closing
        assert found.omega[rigid] > 1.0  # what comes next bends


def test_a_fold_that_closes_is_exact_at_a_vertex() -> None:
    """A valley of unit rotation along one line and what it asks of the others, by geometry of four triangles."""
    mesh = plate.grid(1.0, 1.0, 4, 4, "union-jack")
    ends = [(1, 0.5), (0.5, 1), (0, 0.5), (0.5, 0)]
    k = 1e-3
    lines = [
        plate.HingeLine(LineString([(0.5, 0.5), end]), k, name)
        for end, name in zip(ends, "abcd", strict=True)
    ]
    # Held at three corners; the fourth is pushed. Panels are rigid beside the hinges: opposite lines fold alike.
    problem = plate.Problem(
        mesh,
        isotropic(1e6),
        supports=[plate.Support(Point(x, y), ("w",)) for x, y in ((0, 0), (1, 0), (0, 1))],
        loads=[plate.PointLoad((1, 1), 1e-3)],
        hinges=lines,
    )
    rotations = {turn.hinge.name: turn for turn in plate.solve(problem).hinges}
    for name in "abcd":
        assert np.ptp(rotations[name].rotation) < 1e-6 * abs(rotations[name].largest)  # rigid panels
    assert rotations["a"].largest == pytest.approx(rotations["c"].largest, rel=1e-6)
    assert rotations["b"].largest == pytest.approx(rotations["d"].largest, rel=1e-6)


def test_a_line_that_ends_inside_does_not_turn_at_its_tip() -> None:
    mesh = plate.grid(1.0, 1.0, 10, 10, "union-jack")
    line = LineString([(0.5, 0), (0.5, 0.6)])
    problem = plate.Problem(
        mesh,
        isotropic(D),
        supports=[plate.Clamped(LineString([(0, 0), (0, 1)]))],
        loads=[plate.EdgeLoad(LineString([(1, 0), (1, 1)]), 1.0)],
        hinges=[plate.HingeLine(line)],
    )
    solution = plate.solve(problem)
    assert solution.hinge_rotation(0.5, 0.6) == 0.0
    at = np.linspace(0.0, 0.6, 7)
    assert (np.diff(solution.hinge_rotation(0.5, at)) < 0.0).all()  # it opens towards the edge
    # Softer than without, stiffer than with a line all through, which is a mechanism.
    whole = plate.solve(plate.Problem(mesh, isotropic(D), supports=problem.supports, loads=problem.loads))
    assert solution.compliance > whole.compliance
    assert solution.strain_energy == pytest.approx(0.5 * solution.compliance, rel=1e-10)


def test_slopes_differ_across_the_line_and_deflections_do_not() -> None:
    a, eps = 0.5, 1e-7
    k = 0.3
    solution = plate.solve(
        strip(
            plate.HingeLine(across(a), k),
            element="dkt",
            supports=[plate.Clamped(LEFT)],
            loads=[plate.PointLoad((L, 0.0), 1.0)],
        )
    )
    y = np.linspace(0.01, 0.24, 5)
    left, right = (solution.slope(np.full(5, a + s), y) for s in (-eps, eps))
    # The tangential slope is one, that across jumps by the rotation; linear between nodes for DKT.
    assert right[:, 0] - left[:, 0] == pytest.approx(solution.hinge_rotation(a, y), rel=1e-5)
    assert right[:, 1] == pytest.approx(left[:, 1], abs=1e-5 * np.abs(right).max())
    w = [solution.deflection(np.full(5, a + s), y) for s in (-eps, eps)]
    assert w[1] == pytest.approx(w[0], abs=1e-5 * np.abs(w).max())


def test_coupled_laminates_fold_about_their_reference_surface() -> None:
    """One ply, seen from a reference surface beside its middle: B is not zero, and nothing else than the same beam if
    the plane is free. The hinge's axis lies in the reference surface; in-plane motion makes up for its height."""
    P, a, k, e = 1.0, 0.5, 0.4, 3e-3
    middle = isotropic(D, nu=0.0)
    off = plate.Laminate(middle.plies, e)
    mesh = plate.grid(L, B, 16, 4, "union-jack")
    supports, loads = [plate.Clamped(LEFT)], [plate.EdgeLoad(RIGHT, P)]
    lines = [plate.HingeLine(across(a), k)]
    found = [
        float(
            plate.solve(plate.Problem(mesh, lam, "dkt+lst", supports, loads, hinges=lines)).deflection(L, 0.1)
        )
        for lam in (middle, off)
    ]
    assert found[1] == pytest.approx(found[0], rel=2e-3)  # meshes of 16 cells differ by that in the two forms


# --- books -----------------------------------------------------------------------------------------------------------


def test_supports_across_a_hinge_balance_the_loads() -> None:
    line = plate.HingeLine(LineString([(0.25, 0), (0.75, B)]), 0.1)
    mesh = plate.mesh(box(0, 0, L, B), 0.06, follow=[line.where])
    problem = plate.Problem(
        mesh,
        isotropic(D),
        supports=[plate.SimplySupported("boundary")],
        loads=[plate.Pressure(3.0), plate.PointLoad((0.5, 0.1), 0.4)],
        hinges=[line],
    )
    solution = plate.solve(problem)
    assert sum(r.force for r in solution.reactions) == pytest.approx([0, 0, -3.0 * L * B - 0.4], abs=1e-11)
    moment = sum(r.moment for r in solution.reactions)
    assert moment[:2] == pytest.approx([-3.0 * L * B * B / 2 - 0.04, 3.0 * L * L / 2 * B + 0.2], rel=1e-10)
    energy = sum(turn.energy for turn in solution.hinges)
    assert 0.0 < energy < solution.strain_energy
    assert solution.strain_energy == pytest.approx(0.5 * solution.compliance, rel=1e-11)


def test_the_error_estimate_does_not_smooth_a_hinge() -> None:
    """Moments of a plate of two links: recovered within each side, their error stays what it is without the hinge."""
    made = {"supports": [plate.Clamped(LEFT)], "loads": [plate.PointLoad((L, 0.0), 1.0)]}

    def estimate(*hinges: plate.HingeLine) -> float:
        mesh = plate.grid(L, B, 32, 8, "union-jack")
        problem = plate.Problem(mesh, isotropic(D), hinges=hinges, **made)  # type: ignore[arg-type]
        return plate.solve(problem).error_estimate.relative

    # Twist and bending along the line jump where it folds unevenly; smoothed, they would be an error of some 10 %.
    assert estimate(plate.HingeLine(across(0.5), 0.05)) < 1.5 * estimate()


def test_a_halved_mesh_keeps_its_hinges() -> None:
    P, a, k = 0.3, 0.375, 0.7
    problem = strip(
        plate.HingeLine(across(a), k),
        element="dkt",
        n=16,
        supports=[plate.Clamped(LEFT)],
        loads=[plate.EdgeLoad(RIGHT, P)],
    )
    found = plate.error_of(problem, lambda solution: float(solution.deflection(L, 0.5 * B)))
    expected = P * L**3 / (3 * D) + P * (L - a) ** 2 / k
    assert found.extrapolated == pytest.approx(expected, rel=1e-5)  # what is left is of fourth order


@pytest.mark.slow
def test_other_laminates_on_the_same_hinged_mesh() -> None:
    P, a, k = 0.3, 0.375, 0.7
    made = {"supports": [plate.Clamped(LEFT)], "loads": [plate.EdgeLoad(RIGHT, P)]}
    model = plate.FactoredPlate(strip(plate.HingeLine(across(a), k), **made))
    model.solve()
    again = model.with_laminates(isotropic(5.0, nu=0.0)).solve()
    expected = P * L**3 / (3 * 5.0) + P * (L - a) ** 2 / k
    assert again.deflection(L, 0.1) == pytest.approx(expected, rel=ROUND_OFF)


def test_gradients_go_through_hinges() -> None:
    P, a, k = 0.3, 0.375, 0.7
    made = {"supports": [plate.Clamped(LEFT)], "loads": [plate.EdgeLoad(RIGHT, P)]}
    problem = strip(plate.HingeLine(across(a), k), **made)
    found = plate.gradient(plate.solve(problem), "compliance")
    # Compliance = P b w, of which only the beam's part depends on D, which goes with the cube of the thickness, 1 mm.
    beam = P * B * P * L**3 / (3 * D)
    assert found["ply[0].thickness"] == pytest.approx(-3.0 * beam / 1e-3, rel=1e-9)
