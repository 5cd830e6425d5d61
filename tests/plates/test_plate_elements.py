"""Plate and membrane elements: what is derived of them is what mechanics says, and what another formulation gives."""

import numpy as np
import pytest

from lamc import plate
from lamc.plates.elements import derive
from lamc.plates.elements.description import operations
from lamc.reference.plate_elements import ReferenceElement
from tests.support.staged_elements import (
    ALL,
    BENDING,
    COUNT,
    MEMBRANES,
    cells,
    constant_strain,
    isotropic,
    matrix,
    nodal,
    relative,
    sections,
    staged,
    strain_rows,
)

# Deriving these takes a second each, of what others have in parts.
LARGE = ("dkt+lst", "bciz+cst", "specht+lst", "bfs+q12")
NAMES = [pytest.param(name, marks=pytest.mark.slow if name in LARGE else ()) for name in ALL]

# --- against a formulation that shares no code -----------------------------------------------------------------------


@pytest.mark.parametrize("name", ALL)
@pytest.mark.quick("bciz", "dkt", "cst", "lst", "q4", "q8", "dkt+cst", "bfs", others="campaign")
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


# --- mechanics -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.quick("bciz", "dkt", "specht", "bfs", "cst", "lst", "q4", "q8", "q9", "dkt+cst")
def test_stiffness_resists_everything_but_rigid_motion(name: str) -> None:
    own = staged(name)
    K = own.stiffness(cells(name), sections(name))
    values = np.linalg.eigvalsh(K)
    rigid = 3 * (own.element.bends + own.element.stretches)
    # Zero eigenvalues come out as round-off of the largest; the softest real mode here is 1e-5 of it.
    assert np.abs(values[:, :rigid] / values[:, -1:]).max() < 1e-14
    assert (values[:, rigid] / values[:, -1]).min() > 1e-6


@pytest.mark.parametrize("name", NAMES)
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


@pytest.mark.parametrize("name", NAMES)
def test_constant_strain_is_represented_everywhere(name: str) -> None:
    own, corners = staged(name), cells(name)
    at = np.random.default_rng(3).uniform(0.05, 0.45, size=(COUNT, 2))
    for column, k in enumerate(strain_rows(name)):
        d = nodal(name, corners, constant_strain(k))
        expected = np.eye(len(strain_rows(name)))[column]
        # 1e-13: unknowns of size 3 over cells of size 1, differenced twice.
        np.testing.assert_allclose(
            own.strain(corners, at, d), np.tile(expected, (COUNT, 1)), rtol=0.0, atol=1e-13
        )


@pytest.mark.parametrize("name", NAMES)
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


@pytest.mark.parametrize("name", NAMES)
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
    rotated = own.stiffness(corners @ rotation.T, section)
    # 1e-13: rounding of turned corners, amplified by third powers of their differences.
    assert relative(T.T @ rotated @ T, own.stiffness(corners, section)) < 1e-13


@pytest.mark.quick("dkt+cst", "bciz+lst")
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


@pytest.mark.parametrize("name", NAMES)
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
