"""Plate and membrane elements: what is derived of them is what mechanics and the literature say."""

from fractions import Fraction
from functools import cache

import numpy as np
import pytest
import sympy as sp

from lamc import plate
from lamc.errors import DesignError
from lamc.plate.elements import derive, eta, side, x1, xi
from lamc.plate.elements.definition import CORNERS
from lamc.plate.elements.description import operations
from lamc.reference.plate_elements import ReferenceElement
from tests.staged_elements import StagedElement

BENDING = ("bciz", "dkt", "specht", "bfs")
MEMBRANES = ("cst", "lst", "q4", "q8", "q9", "q12")
COUPLED = ("dkt+cst", "dkt+lst", "bciz+cst", "specht+lst", "bfs+q4", "bfs+q12")
ALL = (*BENDING, *MEMBRANES, *COUPLED)
UPPER = np.triu_indices(3)
COUNT = 6  # cells that are tried at once

staged = cache(StagedElement)


def cells(name: str, count: int = COUNT) -> np.ndarray:
    """Corners of irregular cells, away from the origin: triangles, quadrilaterals, or rectangles for bending."""
    rng = np.random.default_rng(7)
    own = plate.element(name)
    base = np.array(CORNERS[own.cell], dtype=float)
    if own.cell == "square" and own.bends:
        return base * np.exp(rng.normal(scale=0.6, size=(count, 1, 2))) + rng.normal(size=(count, 1, 2))
    return base + rng.normal(scale=0.12, size=(count, len(base), 2)) + np.array([2.0, -1.0])


def sections(name: str, count: int = COUNT) -> np.ndarray:
    """Unique entries of positive definite sections, (count, 6 or 18)."""
    rng = np.random.default_rng(8)
    own = plate.element(name)
    size = 6 if own.bends and own.stretches else 3
    root = rng.normal(size=(count, size, size))
    whole = root @ root.transpose(0, 2, 1)
    if size == 3:
        return whole[:, UPPER[0], UPPER[1]]
    coupling = 0.5 * (whole[:, :3, 3:] + whole[:, 3:, :3])
    blocks = (whole[:, :3, :3], 0.3 * coupling, whole[:, 3:, 3:])
    return np.concatenate([block[:, UPPER[0], UPPER[1]] for block in blocks], axis=1)


def matrix(entries: np.ndarray) -> np.ndarray:
    """The section, (m, 3, 3) or (m, 6, 6), of its unique entries."""
    blocks = []
    for k in range(entries.shape[1] // 6):
        block = np.zeros((len(entries), 3, 3))
        block[:, UPPER[0], UPPER[1]] = block[:, UPPER[1], UPPER[0]] = entries[:, 6 * k : 6 * k + 6]
        blocks.append(block)
    if len(blocks) == 1:
        return blocks[0]
    A, B, D = blocks
    return np.concatenate([np.concatenate([A, B], 2), np.concatenate([B, D], 2)], 1)


def node_places(name: str, corners: np.ndarray) -> np.ndarray:
    """Coordinates of the nodes, (m, nodes, 2): linear or bilinear between the corners."""
    own = plate.element(name)
    at = np.array([[float(c) for c in node.at] for node in own.nodes])
    if own.cell == "triangle":
        shares = np.stack([1.0 - at.sum(axis=1), at[:, 0], at[:, 1]], axis=1)
    else:
        signs = np.array(CORNERS["square"], dtype=float)
        shares = np.prod(1.0 + at[:, None] * signs, axis=2) / 4.0
    return np.einsum("nc,mcd->mnd", shares, corners)


def nodal(name: str, corners: np.ndarray, motion: dict[str, object]) -> np.ndarray:
    """Unknowns (m, nd) where the plate moves as `motion`: functions of x and y by name of the unknown."""
    own = plate.element(name)
    places = node_places(name, corners)
    columns = [
        np.broadcast_to(motion.get(dof, lambda x, y: 0.0 * x)(*places[:, k].T), len(corners))
        for k, node in enumerate(own.nodes)
        for dof in node.dofs
    ]
    return np.stack(columns, axis=1)


def constant_strain(k: int) -> dict[str, object]:
    """A motion of unit strain k: ε_x, ε_y, γ_xy, κ_x, κ_y, κ_xy, with a rigid motion on top."""
    e = np.eye(6)[k]
    return {
        "u": lambda x, y: e[0] * x + e[2] * y + 0.3 - 0.2 * y,
        "v": lambda x, y: e[1] * y - 0.1 + 0.2 * x,
        "w": lambda x, y: -0.5 * (e[3] * x * x + e[4] * y * y + e[5] * x * y) + 0.2 - 0.4 * x + 0.7 * y,
        "w_x": lambda x, y: -e[3] * x - 0.5 * e[5] * y - 0.4,
        "w_y": lambda x, y: -e[4] * y - 0.5 * e[5] * x + 0.7,
        "w_xy": lambda x, y: -0.5 * e[5] + 0.0 * x,
    }


def strain_rows(name: str) -> list[int]:
    own = plate.element(name)
    return [*range(3)] * own.stretches + [*range(3, 6)] * own.bends


def relative(found: np.ndarray, expected: np.ndarray) -> float:
    """Largest difference over the largest entry, cell by cell."""
    m = len(expected)
    scale = np.abs(expected).reshape(m, -1).max(axis=1)
    return float((np.abs(found - expected).reshape(m, -1).max(axis=1) / scale).max())


# --- against a formulation that shares no code -----------------------------------------------------------------------


@pytest.mark.parametrize("name", ALL)
def test_matrices_and_vectors_agree_with_numeric_quadrature(name: str) -> None:
    """ReferenceElement states elements by nodal conditions and integrates numerically, without sympy."""
    own, reference = staged(name), ReferenceElement(name)
    assert own.element.dofs == reference.element.dofs
    rng = np.random.default_rng(9)
    corners, section = cells(name), sections(name)
    d = rng.normal(size=(COUNT, len(own.element.dofs)))
    at = rng.uniform(0.1, 0.4, size=(COUNT, 2))
    tries: dict[str, tuple[object, ...]] = {
        "stiffness": (section,),
        "mass": (rng.uniform(1.0, 2.0, size=COUNT),),
        "load": (rng.normal(size=(COUNT, len(own.element.fields), own.element.corner_count)),),
        "prestress": (rng.normal(size=(COUNT, len(strain_rows(name)))),),
        "strain": (at, d),
        "displacement": (at, d),
        "force": (section, d),
    }
    if own.element.bends:
        tries["geometric"] = (rng.normal(size=(COUNT, 3)),)
    for function, inputs in tries.items():
        found = getattr(own, function)(corners, *inputs)
        # 1e-13: some hundred roundings of 1e-16 on either side.
        assert relative(found, getattr(reference, function)(corners, *inputs)) < 1e-13, function


def triangle_rule(count: int) -> tuple[np.ndarray, np.ndarray]:
    """Gauss points of a square folded to the triangle; exact up to degree 2 count - 2."""
    x, weight = np.polynomial.legendre.leggauss(count)
    a, b = (part.ravel() for part in np.meshgrid(0.5 * (x + 1.0), 0.5 * (x + 1.0), indexing="ij"))
    return np.stack([a * (1.0 - b), b], axis=1), 0.25 * np.outer(weight, weight).ravel() * (1.0 - b)


MIDDLES = (np.array([[0.5, 0.0], [0.5, 0.5], [0.0, 0.5]]), np.full(3, 1.0 / 6.0))


def six_points() -> tuple[np.ndarray, np.ndarray]:
    """Degree 4: G. R. Cowper, Int. J. Numer. Meth. Engng 7, 1973, in closed form."""
    points, weights = [], []
    for sign in (1.0, -1.0):
        a = (8.0 - np.sqrt(10.0) + sign * np.sqrt(38.0 - 44.0 * np.sqrt(0.4))) / 18.0
        points += [[a, a], [1.0 - 2.0 * a, a], [a, 1.0 - 2.0 * a]]
        weights += 3 * [(620.0 + sign * np.sqrt(213125.0 - 53320.0 * np.sqrt(10.0))) / 7440.0]
    return np.array(points), np.array(weights)


def by_quadrature(name: str, rule: tuple[np.ndarray, np.ndarray]) -> np.ndarray:
    """Stiffness of triangles from the element's own strains at points."""
    own, corners = staged(name), cells(name)
    size, S = len(own.element.dofs), matrix(sections(name))
    (ax, ay), (bx, by) = (corners[:, 1] - corners[:, 0]).T, (corners[:, 2] - corners[:, 0]).T
    total = np.zeros((COUNT, size, size))
    for point, weight in zip(*rule, strict=True):
        columns = [
            own.strain(corners, np.tile(point, (COUNT, 1)), np.tile(unit, (COUNT, 1)))
            for unit in np.eye(size)
        ]
        B = np.stack(columns, axis=2)
        total += (weight * (ax * by - ay * bx))[:, None, None] * (B.transpose(0, 2, 1) @ S @ B)
    return total


@pytest.mark.parametrize(
    ("name", "rule"),
    [
        ("bciz", MIDDLES),
        ("dkt", MIDDLES),
        ("lst", MIDDLES),
        ("specht", six_points()),
        *((name, triangle_rule(6)) for name in ("bciz", "dkt", "specht", "cst", "lst", "dkt+cst")),
    ],
)
def test_exact_integrals_are_what_quadrature_of_sufficient_degree_gives(
    name: str, rule: tuple[np.ndarray, np.ndarray]
) -> None:
    """The three mid-edge points suffice for quadratics, the six of Cowper for Specht's."""
    found = staged(name).stiffness(cells(name), sections(name))
    # 1e-14: round-off of sums of 3 to 36 points, relative to the largest entry.
    assert relative(by_quadrature(name, rule), found) < 1e-14


def test_three_points_are_too_few_for_specht() -> None:
    found = staged("specht").stiffness(cells("specht"), sections("specht"))
    assert relative(by_quadrature("specht", MIDDLES), found) > 1e-3


# --- against matrices in print ---------------------------------------------------------------------------------------


def isotropic(nu: float) -> np.ndarray:
    """Plane stress, unit modulus and thickness: unique entries, (1, 6)."""
    return np.array([[1.0, nu, 0.0, 1.0, 0.0, 0.5 * (1.0 - nu)]]) / (1.0 - nu * nu)


def test_constant_strain_triangle_has_the_textbook_matrix() -> None:
    """Right isosceles triangle without Poisson's effect: R. D. Cook, Concepts and Applications of FEA, section 3.4."""
    corners = np.array([[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]])
    expected = 0.25 * np.array(
        [
            [3, 1, -2, -1, -1, 0],
            [1, 3, 0, -1, -1, -2],
            [-2, 0, 2, 0, 0, 0],
            [-1, -1, 0, 1, 1, 0],
            [-1, -1, 0, 1, 1, 0],
            [0, -2, 0, 0, 0, 2],
        ]
    )
    np.testing.assert_array_equal(staged("cst").stiffness(corners, isotropic(0.0))[0], expected)


def test_bilinear_square_has_the_matrix_of_sigmund() -> None:
    """O. Sigmund, Struct. Multidisc. Optim. 21, 2001, appendix: the element of the 99-line code."""
    nu = 0.3
    k = np.array(
        [
            1 / 2 - nu / 6,
            1 / 8 + nu / 8,
            -1 / 4 - nu / 12,
            -1 / 8 + 3 * nu / 8,
            -1 / 4 + nu / 12,
            -1 / 8 - nu / 8,
            nu / 6,
            1 / 8 - 3 * nu / 8,
        ]
    )
    order = ("12345678", "21876543", "38167452", "47618325", "56781234", "65432187", "74523816", "83254761")
    expected = np.array([[k[int(digit) - 1] for digit in row] for row in order]) / (1.0 - nu * nu)
    corners = np.array([[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]])
    # 4 points and their irrational coordinates: a few roundings.
    np.testing.assert_allclose(
        staged("q4").stiffness(corners, isotropic(nu))[0], expected, rtol=0, atol=4e-16
    )


def hermite_beam(length: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """∫ f″f″, ∫ f′f′ and ∫ f f of the beam's cubics: J. S. Przemieniecki, Theory of Matrix Structural Analysis, 1968,
    chapters 5, 11 and 15."""
    a = length
    bending = np.array(
        [[12, 6 * a, -12, 6 * a], [0, 4 * a * a, -6 * a, 2 * a * a], [0, 0, 12, -6 * a], [0, 0, 0, 4 * a * a]]
    )
    string = np.array(
        [[36, 3 * a, -36, 3 * a], [0, 4 * a * a, -3 * a, -a * a], [0, 0, 36, -3 * a], [0, 0, 0, 4 * a * a]]
    )
    mass = np.array(
        [
            [156, 22 * a, 54, -13 * a],
            [0, 4 * a * a, 13 * a, -3 * a * a],
            [0, 0, 156, -22 * a],
            [0, 0, 0, 4 * a * a],
        ]
    )
    scaled = (bending / a**3, string / (30 * a), mass * a / 420)
    return tuple(np.triu(m) + np.triu(m, 1).T for m in scaled)  # type: ignore[return-value]


def test_conforming_rectangle_is_the_product_of_two_beams() -> None:
    """Without Poisson's effect each term of the energy is a product of beam matrices."""
    a, b, d11, d22, d66, rho, nx, nxy = 1.7, 0.6, 2.0, 3.0, 0.7, 1.3, 0.9, 0.0
    (kx, cx, mx), (ky, cy, my) = hermite_beam(a), hermite_beam(b)
    # Corner by corner (0,0), (a,0), (a,b), (0,b); w, w_x, w_y, w_xy: which end and which function along x and along y.
    ends = ((0, 0), (1, 0), (1, 1), (0, 1))
    along_x = [2 * end[0] + f for end in ends for f in (0, 1, 0, 1)]
    along_y = [2 * end[1] + f for end in ends for f in (0, 0, 1, 1)]

    def product(first: np.ndarray, second: np.ndarray) -> np.ndarray:
        return first[np.ix_(along_x, along_x)] * second[np.ix_(along_y, along_y)]

    corners = np.array([[[0.0, 0.0], [a, 0.0], [a, b], [0.0, b]]]) + np.array([0.25, -0.5])
    own = staged("bfs")
    stiffness = own.stiffness(corners, np.array([[d11, 0.0, 0.0, d22, 0.0, d66]]))[0]
    expected = d11 * product(kx, my) + d22 * product(mx, ky) + 4.0 * d66 * product(cx, cy)
    # 1e-14: round-off, relative to the largest entry.
    np.testing.assert_allclose(stiffness, expected, rtol=0, atol=1e-14 * np.abs(expected).max())
    mass = rho * product(mx, my)
    np.testing.assert_allclose(own.mass(corners, np.array([rho]))[0], mass, rtol=0, atol=1e-14 * mass.max())
    pulled = nx * product(cx, my)
    found = own.geometric(corners, np.array([[nx, 0.0, nxy]]))[0]
    np.testing.assert_allclose(found, pulled, rtol=0, atol=1e-14 * pulled.max())


def test_masses_of_linear_triangle_and_square_are_those_of_archer() -> None:
    """ρA/12 and ρA/36 times whole numbers: J. S. Archer, AIAA J. 3, 1965."""
    triangle = np.array([[[0.0, 0.0], [2.0, 0.5], [0.5, 3.0]]])
    area = 0.5 * (2.0 * 3.0 - 0.5 * 0.5)
    found = staged("cst").mass(triangle, np.array([4.0]))[0, ::2, ::2]
    np.testing.assert_allclose(found, 4.0 * area / 12.0 * (np.ones((3, 3)) + np.eye(3)), rtol=1e-15)
    square = np.array([[[0.0, 0.0], [3.0, 0.0], [3.0, 2.0], [0.0, 2.0]]])
    expected = np.array([[4, 2, 1, 2], [2, 4, 2, 1], [1, 2, 4, 2], [2, 1, 2, 4]]) * 4.0 * 6.0 / 36.0
    np.testing.assert_allclose(
        staged("q4").mass(square, np.array([4.0]))[0, 1::2, 1::2], expected, rtol=4e-16
    )


# --- mechanics -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ALL)
def test_stiffness_resists_everything_but_rigid_motion(name: str) -> None:
    own = staged(name)
    K = own.stiffness(cells(name), sections(name))
    values = np.linalg.eigvalsh(K)
    rigid = 3 * (own.element.bends + own.element.stretches)
    # Zero eigenvalues come out as round-off of the largest; the softest real mode here is 1e-5 of it.
    assert np.abs(values[:, :rigid] / values[:, -1:]).max() < 1e-14
    assert (values[:, rigid] / values[:, -1]).min() > 1e-6


@pytest.mark.parametrize("name", ALL)
def test_rigid_motion_calls_for_no_force(name: str) -> None:
    own, corners, section = staged(name), cells(name), sections(name)
    largest = np.abs(own.stiffness(corners, section)).reshape(COUNT, -1).max(axis=1)
    motions = [
        {"u": lambda x, y: 1.0 + 0.0 * x},
        {"v": lambda x, y: 1.0 + 0.0 * x},
        {"w": lambda x, y: 1.0 + 0.0 * x},
        {"u": lambda x, y: -y, "v": lambda x, y: x},
        {"w": lambda x, y: x, "w_x": lambda x, y: 1.0 + 0.0 * x},
        {"w": lambda x, y: y, "w_y": lambda x, y: 1.0 + 0.0 * x},
    ]
    for k, motion in enumerate(motions):
        force = np.abs(own.force(corners, section, nodal(name, corners, motion))).max(axis=1)
        if k < 3:
            assert not force.any(), "differences of equal displacements are zero, not round-off"
        # Coordinates are of size 3, so unknowns are, and their rounding of 1e-16 is what is left.
        assert (force / largest).max() < 1e-14


@pytest.mark.parametrize("name", ALL)
def test_constant_strain_is_represented_everywhere(name: str) -> None:
    own, corners = staged(name), cells(name)
    at = np.random.default_rng(3).uniform(0.05, 0.45, size=(COUNT, 2))
    for column, k in enumerate(strain_rows(name)):
        d = nodal(name, corners, constant_strain(k))
        expected = np.eye(len(strain_rows(name)))[column]
        # 1e-13: unknowns of size 3 over cells of size 1, differenced twice.
        np.testing.assert_allclose(own.strain(corners, at, d), np.tile(expected, (COUNT, 1)), atol=1e-13)


@pytest.mark.parametrize("name", ALL)
def test_energy_of_constant_strain_is_that_of_the_section(name: str) -> None:
    own, corners, section = staged(name), cells(name), sections(name)
    x, y = corners[..., 0], corners[..., 1]
    area = 0.5 * np.sum(x * np.roll(y, -1, 1) - np.roll(x, -1, 1) * y, axis=1)
    rows = strain_rows(name)
    d = nodal(name, corners, constant_strain(rows[0])) + 2.0 * nodal(name, corners, constant_strain(rows[-1]))
    strain = np.eye(len(rows))[0] + 2.0 * np.eye(len(rows))[-1]
    expected = area * np.einsum("i,mij,j->m", strain, matrix(section), strain)
    by_stiffness = np.einsum("mi,mij,mj->m", d, own.stiffness(corners, section), d)
    by_force = np.einsum("mi,mi->m", d, own.force(corners, section, d))
    # The stiffness is up to 1e3 times the energy's, as w grows with the square of coordinates.
    np.testing.assert_allclose(by_stiffness, expected, rtol=1e-11)
    np.testing.assert_allclose(by_force, expected, rtol=1e-12)
    resultants = np.einsum("mij,j->mi", matrix(section), strain)
    np.testing.assert_allclose(
        np.einsum("mi,mi->m", d, own.prestress(corners, resultants)), expected, rtol=1e-12
    )


@pytest.mark.parametrize("name", ["bciz", "dkt", "specht"])
@pytest.mark.parametrize("tip", [(0.4, 1e-3), (0.0, 1e-3)])
def test_forces_keep_their_digits_in_slivers(name: str, tip: tuple[float, float]) -> None:
    """1:1000, turned by 40°. The stiffness matrix itself cannot: its entries are 1e9 times what bending along takes."""
    turn = np.array([[np.cos(0.7), np.sin(0.7)], [-np.sin(0.7), np.cos(0.7)]])
    corners = np.array([[[0.0, 0.0], [1.0, 0.0], tip]]) @ turn
    section = np.array([[1.0, 0.3, 0.1, 2.0, 0.05, 0.4]])
    S, area = matrix(section)[0], 0.5e-3
    for k in range(3):
        d = nodal(name, corners, constant_strain(3 + k))
        energy = float(d[0] @ own_force(name, corners, section, d))
        # 1e-8: curvatures are quotients of 1e-16 by (1e-3)², and by another 1e-3 where slopes turn along the long side.
        assert energy == pytest.approx(area * S[k, k], rel=1e-8)


def own_force(name: str, corners: np.ndarray, section: np.ndarray, d: np.ndarray) -> np.ndarray:
    return staged(name).force(corners, section, d)[0]


@pytest.mark.parametrize("name", ALL)
def test_scaling_lengths_scales_results_exactly(name: str) -> None:
    """A unit that is a power of two larger: no digit may change, as there is nothing in the element with a unit."""
    own, corners, section = staged(name), cells(name), sections(name)
    scale = 2.0**-10
    lengths = {"u": 1, "v": 1, "w": 1, "w_x": 0, "w_y": 0, "w_xy": -1}
    change = np.array([scale ** lengths[dof] for dof in own.element.dofs])
    factors = [scale**-2] * 6 * own.element.stretches
    if own.element.stretches and own.element.bends:
        factors += [scale**-1] * 6
    factors += [1.0] * 6 * own.element.bends
    small = own.stiffness(scale * corners, section * np.array(factors))
    np.testing.assert_array_equal(change[:, None] * small * change, own.stiffness(corners, section))


@pytest.mark.parametrize("name", [n for n in ALL if "bfs" not in n])
def test_turning_the_plate_turns_its_unknowns(name: str) -> None:
    own, corners = staged(name), cells(name)
    c, s = np.cos(0.6), np.sin(0.6)
    rotation = np.array([[c, -s], [s, c]])
    # Isotropic sections are the same in all axes.
    section = np.tile(
        np.concatenate([isotropic(0.3), *(0.4 * isotropic(0.3), isotropic(0.2))], axis=1), (COUNT, 1)
    )
    section = section if own.element.bends and own.element.stretches else section[:, :6]
    blocks = [
        rotation if dof in ("u", "w_x") else np.eye(1) for dof in own.element.dofs if dof not in ("v", "w_y")
    ]
    size = len(own.element.dofs)
    T, at = np.zeros((size, size)), 0
    for block in blocks:
        T[at : at + len(block), at : at + len(block)] = block
        at += len(block)
    turned = own.stiffness(corners @ rotation.T, section)
    # 1e-13: rounding of turned corners, amplified by third powers of their differences.
    assert relative(T.T @ turned @ T, own.stiffness(corners, section)) < 1e-13


@pytest.mark.parametrize("name", ["dkt+cst", "bciz+lst", "bfs+q9"])
def test_uncoupled_section_gives_bending_and_membrane_side_by_side(name: str) -> None:
    bending, membrane = name.split("+")
    own, corners = staged(name), cells(name)
    section = sections(name).copy()
    section[:, 6:12] = 0.0
    K = own.stiffness(corners, section)
    in_plane = np.array([dof in ("u", "v") for dof in own.element.dofs])
    assert not K[:, in_plane][:, :, ~in_plane].any()
    assert (
        relative(K[:, ~in_plane][:, :, ~in_plane], staged(bending).stiffness(corners, section[:, 12:]))
        < 1e-14
    )
    # The membrane alone may use Gauss points in place of exact integrals: round-off again, as rectangles are affine.
    assert (
        relative(K[:, in_plane][:, :, in_plane], staged(membrane).stiffness(corners, section[:, :6])) < 1e-14
    )


@pytest.mark.parametrize("name", ALL)
def test_loads_and_mass_know_the_total(name: str) -> None:
    """Uniform unit load does the work of the area on a unit shift; so does mass."""
    own, corners = staged(name), cells(name)
    x, y = corners[..., 0], corners[..., 1]
    area = 0.5 * np.sum(x * np.roll(y, -1, 1) - np.roll(x, -1, 1) * y, axis=1)
    mass = own.mass(corners, np.ones(COUNT))
    for k, field in enumerate(own.element.fields):
        shift = nodal(name, corners, {field: lambda x, y: 1.0 + 0.0 * x})
        intensity = np.zeros((COUNT, len(own.element.fields), own.element.corner_count))
        intensity[:, k] = 1.0
        np.testing.assert_allclose(
            np.einsum("mi,mi->m", shift, own.load(corners, intensity)), area, rtol=1e-13
        )
        np.testing.assert_allclose(np.einsum("mi,mij,mj->m", shift, mass, shift), area, rtol=1e-13)


# --- operations ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "limit"), [("bciz", 1450), ("dkt", 1900), ("specht", 1900), ("dkt+cst", 1900)]
)
def test_stiffness_takes_few_operations(name: str, limit: int) -> None:
    """The limits are what the project promises; a third above today's count shows what creeps in."""
    today = {"bciz": 505, "dkt": 531, "specht": 1121, "dkt+cst": 904}
    count = operations(staged(name).equations)["stiffness"].flops
    assert count <= limit
    assert count <= today[name] * 4 / 3


@pytest.mark.parametrize("name", [*BENDING, *MEMBRANES, "dkt+cst"])
def test_straight_code_stays_short_enough_to_compile(name: str) -> None:
    """gcc's time grows faster than the length of one block; above some 3000 operations there must be a loop."""
    for function, counted in operations(staged(name).equations).items():
        assert counted.flops < 3000, function


def test_equal_elements_give_equal_equations() -> None:
    first, second = (derive(plate.element("dkt+cst")) for _ in range(2))
    assert first.store.operations == second.store.operations
    assert first.store.arguments == second.store.arguments


# --- a user's own ----------------------------------------------------------------------------------------------------


def square_functions() -> list[sp.Expr]:
    return [(1 + a * xi) * (1 + b * eta) / 4 for a, b in CORNERS["square"]]


def test_element_of_a_user_is_the_one_of_the_library() -> None:
    N = square_functions()
    mine = plate.Element("mine", "square", plate.corners("square", ("u", "v")), u=N, v=N)
    found = StagedElement(mine).stiffness(cells("q4"), sections("q4"))
    np.testing.assert_array_equal(found, staged("q4").stiffness(cells("q4"), sections("q4")))


def adini_clough_melosh() -> plate.Element:
    """The rectangle of 12 unknowns, w complete to cubics, from its nodal conditions.

    A. Adini, R. W. Clough, NSF report G7337, 1961; R. J. Melosh, J. Aerospace Sci. 28, 1961.
    """
    powers = [(0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2), (3, 0), (2, 1), (1, 2), (0, 3), (3, 1), (1, 3)]
    monomials = sp.Matrix([xi**i * eta**j for i, j in powers])
    rows = [
        [f.subs({xi: a, eta: b}) for f in g]
        for a, b in CORNERS["square"]
        for g in (monomials, monomials.diff(xi), monomials.diff(eta))
    ]
    N = sp.Matrix(rows).T.inv() * monomials
    scale = [1, side("x", 2, 1) / 2, side("y", 4, 1) / 2]
    w = [scale[k % 3] * N[k] for k in range(12)]
    return plate.Element("acm", "square", plate.corners("square", ("w", "w_x", "w_y")), w=w)


def test_element_of_a_user_that_bends_has_the_stiffness_in_print() -> None:
    """O. C. Zienkiewicz, Y. K. Cheung, Proc. Inst. Civ. Eng. 28, 1964: the first entry, with p = a / b, is
    (4 (p² + 1/p²) + (14 - 4 ν) / 5) D / (a b)."""
    a, b, nu = 1.4, 0.9, 0.3
    corners = np.array([[[0.0, 0.0], [a, 0.0], [a, b], [0.0, b]]])
    section = np.array([[1.0, nu, 0.0, 1.0, 0.0, 0.5 * (1.0 - nu)]])
    own = StagedElement(adini_clough_melosh())
    expected = (4.0 * (a * a / b / b + b * b / a / a) + (14.0 - 4.0 * nu) / 5.0) / (a * b)
    assert own.stiffness(corners, section)[0, 0, 0] == pytest.approx(expected, rel=1e-14)
    # It stretches when told so.
    both = plate.combine(own.element, plate.element("q4"))
    assert both.name == "acm+q4"
    assert len(both.dofs) == 20


def test_library_is_told_apart_by_raw_coordinates_as_by_sides() -> None:
    """x2 - x1 and x21 are the same; so is what comes of them, up to round-off."""
    bciz = plate.element("bciz")
    raw = {
        side(axis, i, j): sp.Symbol(f"{axis}{i}", real=True) - sp.Symbol(f"{axis}{j}", real=True)
        for axis in "xy"
        for i in (1, 2, 3)
        for j in (1, 2, 3)
        if i != j
    }
    mine = plate.Element("mine", "triangle", bciz.nodes, w=[f.xreplace(raw) for f in bciz.w])
    found = StagedElement(mine).stiffness(cells("bciz"), sections("bciz"))
    assert relative(found, staged("bciz").stiffness(cells("bciz"), sections("bciz"))) < 1e-14


def bad_elements() -> dict[str, tuple[dict[str, object], str]]:
    N = square_functions()
    bubble = (1 - xi**2) * (1 - eta**2)
    inner = [N[0] + xi * bubble, *N[1:]]
    linear = [1 - xi - eta, xi, eta]
    bending = {"cell": "triangle", "nodes": plate.corners("triangle", ("w", "w_x", "w_y"))}
    return {
        "text": ({"u": ["xi", "eta", "1", "1"]}, "'xi' in u"),
        "too few": ({"u": N[:3]}, "3 shape functions for u"),
        "v missing": ({"v": ()}, "shape functions for u"),
        "nothing": ({"u": (), "v": ()}, "shape functions for nothing"),
        "wrong order": ({"u": N[::-1]}, "the shape function of u1 in u gives u1 = 0"),
        "not rigid": ({"u": inner}, "is strained when it shifts along x"),
        "unknown symbol": ({"u": [sp.Symbol("k") * N[0], *N[1:]]}, "unknown symbol k"),
        "no polynomial": ({"u": [sp.sin(xi) * N[0], *N[1:]]}, "no polynomial in xi and eta"),
        "place": ({"u": [x1 * N[0], *N[1:]]}, "changes as the cell is moved"),
        "quotient": ({"u": [N[0] / side("x", 2, 1), *N[1:]]}, "give it a symbol in `geometry`"),
        "degree": ({"degree": -1}, "degree -1"),
        "cell": ({"cell": "hexagon"}, "cell 'hexagon'"),
        "no nodes": ({"nodes": ["here"]}, "holds 'here'"),
        "no bending": ({"u": (), "v": (), **bending}, "shape functions for nothing"),
        "tilt": (
            {"u": (), "v": (), "w": [f for L in linear for f in (L, 0, 0)], **bending},
            "the shape function of w1 in w gives w_x1",
        ),
        "slopes": (
            {"u": (), "v": (), "w": plate.element("bciz").w, "slopes": ([xi], [eta]), **bending},
            "slopes of [1, 1] shape functions",
        ),
        "amounts": (
            {
                "u": (),
                "v": (),
                "w": plate.element("bciz").w,
                **bending,
                "slopes": ([xi], [eta]),
                "amounts": [sp.Symbol("w1", real=True) ** 2],
            },
            "must be linear in the unknowns",
        ),
        "membrane with w": ({"nodes": plate.corners("square", ("u", "v", "w"))}, "has unknowns for w"),
    }


@pytest.mark.parametrize("case", bad_elements())
def test_element_that_cannot_work_is_refused_by_name(case: str) -> None:
    N = square_functions()
    changes, message = bad_elements()[case]
    good = {"name": "mine", "cell": "square", "nodes": plate.corners("square", ("u", "v")), "u": N, "v": N}
    with pytest.raises(DesignError) as caught:
        derive(plate.Element(**(good | changes)))
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


def test_names_that_are_no_elements_are_refused() -> None:
    for name, message in {
        "dtk": "did you mean 'dkt'",
        "hexagon": "there are bciz",
        "dkt+q4": "triangles and 'q4' for squares",
        "dkt+bciz": "stretches only",
        "cst+lst": "bends only",
        "dkt+cst+cst": "3 parts",
        "": "there is no element ''",
    }.items():
        with pytest.raises(DesignError, match=message.replace("+", r"\+")):
            plate.element(name)
    assert plate.element("CST+DKT").name == "dkt+cst"


def test_nodes_are_where_they_are_said_to_be() -> None:
    assert [node.at for node in plate.edges("square", ("u", "v"), (Fraction(1, 3), Fraction(2, 3)))][:3] == [
        (Fraction(-1, 3), -1),
        (Fraction(1, 3), -1),
        (1, Fraction(-1, 3)),
    ]
    with pytest.raises(DesignError, match="in this order"):
        plate.Node((0, 0), ("w_x", "w"))


def test_description_names_what_matters() -> None:
    text = plate.describe(plate.element("dkt"))
    for part in ("Batoz", "9 unknowns", "Shape functions of w_x", "κ =", "stiffness", "531", "exact"):
        assert part in text
    assert "3 × 3 Gauss points" in plate.describe(plate.element("q8"))
    assert "{" not in text
