"""What no plate's answer may depend on: where it lies, its units, the numbers of its nodes, the order of its loads."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from shapely import affinity
from shapely.geometry import LineString, Point

from lamc import plate
from tests.support.ctools import needs_cc
from tests.support.plate_meshes import CFRP, rectangle_mesh, solved, stack

pytestmark = needs_cc

MESH = rectangle_mesh("delaunay", 6, 0.03, 0.02)  # m
LEFT = LineString([(0.0, 0.0), (0.0, 0.02)])
RIGHT = LineString([(0.03, 0.0), (0.03, 0.02)])
AT = np.array([[0.03, 0.0], [0.03, 0.02], [0.02, 0.0105], [0.011, 0.017]])
ANGLES = st.tuples(*[st.floats(-90.0, 90.0)] * 3)
# Round-off of the input, 1e-16, times how far curvature of a strip's parts adds up: far below what matters to anyone.
SAME = 1e-10
few = settings(max_examples=8, deadline=None, derandomize=True)


def moved(solution: plate.Solution, at: np.ndarray = AT) -> np.ndarray:
    """(u, v, w) at some points, m."""
    return np.asarray(solution.displacement(*at.T))


def largest(values: np.ndarray) -> float:
    return float(np.abs(values).max())


@few
@given(angles=ANGLES, turn=st.floats(-180.0, 180.0))
def test_a_plate_turned_as_a_whole_deflects_alike(angles: tuple[float, ...], turn: float) -> None:
    """Mesh, supports, fibres and loads turned by an angle; B is not zero, so that u and v turn with it."""
    inside = 0.0005 + 0.96 * AT  # away from edges, where round-off would put a point outside
    loads = [plate.Pressure(1e3), plate.EdgeLoad(RIGHT, 5.0)]
    first = moved(solved(MESH, stack(CFRP, 50e-6, *angles), [plate.Clamped(LEFT)], loads), inside)
    c, s = np.cos(np.radians(turn)), np.sin(np.radians(turn))
    rotation = np.array([[c, -s], [s, c]])
    left, right = (affinity.rotate(line, turn, origin=(0, 0)) for line in (LEFT, RIGHT))
    mesh = plate.Mesh(MESH.points @ rotation.T, MESH.cells)
    laminate = stack(CFRP, 50e-6, *(angle + turn for angle in angles))
    loads = [plate.Pressure(1e3), plate.EdgeLoad(right, 5.0)]
    second = moved(solved(mesh, laminate, [plate.Clamped(left)], loads), inside @ rotation.T)
    back = np.concatenate([second[:, :2] @ rotation, second[:, 2:]], axis=1)
    assert largest(back - first) < SAME * largest(first)


@few
@given(angles=ANGLES, seed=st.integers(0, 1000))
def test_numbers_of_nodes_and_cells_do_not_matter(angles: tuple[float, ...], seed: int) -> None:
    rng = np.random.default_rng(seed)
    laminate, supports, loads = stack(CFRP, 50e-6, *angles), [plate.Clamped(LEFT)], [plate.Pressure(1e3)]
    first = solved(MESH, laminate, supports, loads)
    order, cells = rng.permutation(len(MESH.points)), rng.permutation(len(MESH.cells))
    number = np.argsort(order)
    starts = rng.integers(0, 3, len(cells))
    renumbered = number[MESH.cells][cells]
    rotated = np.take_along_axis(renumbered, (np.arange(3) + starts[:, None]) % 3, axis=1)
    second = solved(plate.Mesh(MESH.points[order], rotated), laminate, supports, loads)
    assert largest(moved(second) - moved(first)) < SAME * largest(moved(first))


@few
@given(angles=ANGLES)
def test_the_mirrored_laminate_twists_the_other_way(angles: tuple[float, ...]) -> None:
    loads = [plate.Pressure(1e3)]
    first = moved(solved(MESH, stack(CFRP, 50e-6, *angles), [plate.Clamped(LEFT)], loads))
    mesh = plate.Mesh(MESH.points * [1, -1] + [0, 0.02], MESH.cells[:, ::-1])
    laminate = stack(CFRP, 50e-6, *(-angle for angle in angles))
    second = moved(solved(mesh, laminate, [plate.Clamped(LEFT)], loads), AT * [1, -1] + [0, 0.02])
    assert largest(second * [1, -1, 1] - first) < SAME * largest(first)


@few
@given(angles=ANGLES, factor=st.floats(-10.0, 10.0))
def test_loads_add_up(angles: tuple[float, ...], factor: float) -> None:
    laminate = stack(CFRP, 50e-6, *angles)
    pressure, edge = plate.Pressure(1e3), plate.EdgeLoad(RIGHT, (2.0, -1.0, 5.0))
    scaled = plate.EdgeLoad(RIGHT, (2.0 * factor, -factor, 5.0 * factor))
    problem = plate.Problem(
        MESH,
        laminate,
        supports=[plate.Clamped(LEFT)],
        cases={"p": [pressure], "e": [edge], "both": [pressure, scaled]},
    )
    solutions = plate.solve(problem)
    p, e, both = (moved(solutions[name]) for name in ("p", "e", "both"))
    assert largest(p + factor * e - both) < SAME * (largest(p) + abs(factor) * largest(e))


@pytest.mark.parametrize("element", ["dkt", "dkt+cst"])
@pytest.mark.parametrize(("metre", "name"), [(1e3, "mm"), (1e6, "µm")])
def test_units_scale_the_answer_and_nothing_else(element: str, metre: float, name: str) -> None:
    """SI, mm-N and µm-N. Lengths times `metre`, stresses by its square; forces as they are; masses such that seconds
    stay, N s²/length."""
    angles = (45.0, 22.5, 45.0) if element == "dkt" else (45.0, 22.5, 0.0)

    def answers(length: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        force_per_area = length**-2
        material = plate.Material(
            350e9 * force_per_area,
            7e9 * force_per_area,
            0.33,
            5e9 * force_per_area,
            density=1600.0 / length**4,
        )
        mesh = plate.Mesh(MESH.points * length, MESH.cells)
        left, right = (affinity.scale(line, length, length, origin=(0, 0)) for line in (LEFT, RIGHT))
        loads = [plate.Pressure(1e3 * force_per_area), plate.EdgeLoad(right, 5.0 / length)]
        laminate = stack(material, 50e-6 * length, *angles)
        problem = plate.Problem(mesh, laminate, element=element, supports=[plate.Clamped(left)], loads=loads)
        solution = plate.solve(problem)
        middle = (0.0151 * length, 0.0099 * length)
        return (
            moved(solution, AT * length) / length,
            solution.moments(*middle),
            plate.modes(problem, count=4).omega,
        )

    for si, other in zip(answers(1.0), answers(metre), strict=True):
        np.testing.assert_allclose(other, si, rtol=0, atol=1e-8 * largest(si), err_msg=name)


@few
@given(angles=ANGLES, height=st.floats(-3e-4, 3e-4))
def test_the_reference_surface_is_a_matter_of_words(angles: tuple[float, ...], height: float) -> None:
    """Free to slide in its plane, a plate bends alike whichever surface strains refer to: where u and v have quadratics
    (LST), as the slopes of DKT, they can follow the slopes exactly."""
    plies = [plate.Ply(CFRP, 50e-6, angle) for angle in angles]
    hold = [plate.Support(LEFT, ("w",)), plate.Support(RIGHT, ("w",))]
    hold += [plate.Support(Point(0, 0), ("u", "v")), plate.Support(Point(0, 0.02), ("u",))]
    first, second = (
        solved(MESH, plate.Laminate(plies, reference), hold, [plate.Pressure(1e3)], "dkt+lst").deflection(
            *AT.T
        )
        for reference in ("middle", height)
    )
    assert largest(second - first) < 1e-8 * largest(first)  # A z² takes 3 digits more than D
