"""Three cross-checks on every element: generated C, the same program interpreted, and conditions with quadrature in
numpy.

All on random cells of size 1, so that no entry of a matrix hides behind another for its unit, and random laminates.
Errors are relative to the largest entry of each cell's matrix, or of what maps unknowns to strains.
"""

from collections.abc import Callable
from functools import cache

import numpy as np
import pytest

from lamc.plate import Laminate, Material, Ply
from lamc.plates.elements.kernels import ElementKernels, kernels
from lamc.reference.plate_elements import ReferenceElement
from tests.support.ctools import needs_cc

pytestmark = needs_cc

TRIANGLES = ["bciz", "dkt", "specht", "cst", "lst", "dkt+cst", "bciz+cst", "specht+lst"]
RECTANGLES = ["bfs", "bfs+q4", "bfs+q9"]
QUADRILATERALS = ["q4", "q8", "q9", "q12"]
NAMES = TRIANGLES + RECTANGLES + QUADRILATERALS
COUNT = 40  # cells
EXACT = 1e-13  # sums of some hundred products, each rounded at 1e-16
UNIQUE = ([0, 0, 0, 1, 1, 2], [0, 1, 2, 1, 2, 2])
CrossCheck = ElementKernels | ReferenceElement


@cache
def cross_checks(name: str) -> tuple[ElementKernels, ElementKernels, ReferenceElement]:
    return kernels(name), kernels(name, "interpreted"), ReferenceElement(name)


def triangles(aspect: float) -> np.ndarray:
    """Turned anyhow; the longest edge is 1 to 2, and 1 to 2 times `aspect` over the height on it."""
    rng = np.random.default_rng(5)
    base, foot = rng.uniform(1.0, 2.0, COUNT), rng.uniform(0.1, 0.9, COUNT)
    height = base / (aspect * rng.uniform(1.0, 2.0, COUNT))
    flat = np.zeros((COUNT, 3, 2))
    flat[:, 1, 0], flat[:, 2, 0], flat[:, 2, 1] = base, foot * base, height
    turn = rng.uniform(0.0, 2.0 * np.pi, COUNT)
    rotation = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
    return np.einsum("ijm,mkj->mki", rotation, flat) + rng.uniform(-1.0, 1.0, (COUNT, 1, 2))


def cells(name: str) -> np.ndarray:
    rng = np.random.default_rng(6)
    square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    if name in RECTANGLES:
        return square * rng.uniform(0.2, 2.0, (COUNT, 1, 2)) + rng.uniform(-1.0, 1.0, (COUNT, 1, 2))
    if name in QUADRILATERALS:
        return square * 1.3 + rng.uniform(-0.25, 0.25, (COUNT, 4, 2))
    return triangles(1.0)


def sections(name: str) -> np.ndarray:
    """Of three plies each, not symmetric; 1 m thick and of some Pa, so that A, B and D are of one size."""
    rng = np.random.default_rng(7)
    rows = []
    for _ in range(COUNT):
        stiff, ratio = 1.0 + rng.uniform(0.0, 20.0), rng.uniform(0.0, 0.45)
        material = Material(E1=stiff, E2=1.0, nu12=ratio, G12=rng.uniform(0.3, 1.0), density=1.0)
        plies = [
            Ply(material, t, angle) for t, angle in zip((0.2, 0.3, 0.5), rng.uniform(-90, 90, 3), strict=True)
        ]
        laminate = Laminate(plies)
        A, B, D = (matrix[UNIQUE] for matrix in (laminate.A, laminate.B, laminate.D))
        bends = "+" in name or name in ("bciz", "dkt", "specht", "bfs")
        rows.append(np.concatenate([A, B, D]) if "+" in name else D if bends else A)
    return np.array(rows)


def answers(name: str, corners: np.ndarray) -> dict[str, Callable[[CrossCheck], np.ndarray]]:
    """What is asked of every cross-check, by name; the first axis is over cells."""
    rng = np.random.default_rng(8)
    layout = ReferenceElement(name).element
    count, strains = len(layout.dofs), 3 * (layout.stretches + layout.bends)
    section, xi = sections(name), rng.uniform(0.05, 0.45, (COUNT, 2))
    fields = 2 * layout.stretches + layout.bends
    intensity = rng.standard_normal((COUNT, fields, layout.corner_count))
    resultants, forces = rng.standard_normal((COUNT, strains)), rng.standard_normal((COUNT, 3))

    def maps(method: str) -> Callable[[CrossCheck], np.ndarray]:
        """The matrix from unknowns to what the method gives, one unknown at a time."""

        def ask(cross_check: CrossCheck) -> np.ndarray:
            unit = np.broadcast_to(np.eye(count)[:, None], (count, COUNT, count))
            first = [section] if method == "force" else [xi]
            return np.stack([getattr(cross_check, method)(corners, *first, d) for d in unit], axis=1)

        return ask

    asked: dict[str, Callable[[CrossCheck], np.ndarray]] = {
        "stiffness": lambda cross_check: cross_check.stiffness(corners, section),
        "mass": lambda cross_check: cross_check.mass(corners, np.linspace(0.5, 2.0, COUNT)),
        "load": lambda cross_check: cross_check.load(corners, intensity),
        "prestress": lambda cross_check: cross_check.prestress(corners, resultants),
        "strain": maps("strain"),
        "displacement": maps("displacement"),
        "force": maps("force"),
    }
    if layout.bends:
        asked["geometric"] = lambda cross_check: cross_check.geometric(corners, forces)
    return asked


def difference(found: np.ndarray, expected: np.ndarray, scale: np.ndarray | None = None) -> float:
    """The largest over cells of the largest error over `scale` (cells,), or over the largest entry."""
    axes = tuple(range(1, expected.ndim))
    size = np.abs(expected).max(axis=axes) if scale is None else scale
    return float((np.abs(found - expected).max(axis=axes) / size).max())


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.quick("bciz", "dkt", "cst", "lst", "dkt+cst", "q4", "q8", "q9", others="campaign")
def test_three_cross_checks_agree_on_every_matrix(name: str) -> None:
    compiled, interpreted, reference = cross_checks(name)
    for function, ask in answers(name, cells(name)).items():
        expected = ask(reference)
        assert difference(ask(compiled), expected) <= EXACT, function
        assert difference(ask(interpreted), expected) <= EXACT, function


@pytest.mark.parametrize("name", TRIANGLES + RECTANGLES)
@pytest.mark.quick("bciz", "dkt", "specht", "cst", "lst", "dkt+cst", "bfs", others="campaign")
def test_exact_integration_agrees_with_quadrature(name: str) -> None:
    """On affine cells the C has integrals in closed form, the third cross-check Gauss's rule of a degree that is
    exact."""
    compiled, _, reference = cross_checks(name)
    asked = answers(name, cells(name))
    for function in ("stiffness", "mass"):
        assert difference(asked[function](compiled), asked[function](reference)) <= EXACT / 10.0, function


@pytest.mark.parametrize("name", TRIANGLES)
@pytest.mark.parametrize("aspect", [30.0, 1000.0])
@pytest.mark.quick("*-bciz", "*-dkt", "*-cst", "*-dkt+cst", others="campaign")
def test_three_cross_checks_agree_on_slivers(name: str, aspect: float) -> None:
    """Both start from differences of coordinates, which are exact for near numbers: no digits go to the aspect.

    Forces of constant resultants are those of the cell's edge; the curvatures within are 1000 times as large and
    cancel. So they are held against the sum of what cancels.
    """
    compiled, interpreted, reference = cross_checks(name)
    corners = triangles(aspect)
    asked = answers(name, corners)
    x, y = np.moveaxis(np.diff(corners, axis=1), 2, 0)
    area = 0.5 * (x[:, 0] * y[:, 1] - x[:, 1] * y[:, 0])
    terms = area * np.abs(asked["strain"](reference)).max(axis=(1, 2))  # resultants are of size 1
    for function, ask in asked.items():
        expected, scale = ask(reference), terms if function == "prestress" else None
        assert difference(ask(compiled), expected, scale) <= EXACT, function
        assert difference(ask(interpreted), expected, scale) <= EXACT, function


@pytest.mark.parametrize("name", ["dkt", "dkt+cst", "specht", "q4"])
def test_forces_in_long_double_agree_to_its_digits(name: str) -> None:
    """What refinement of a solution lives on. As `EXACT`, with the round-off of long double for that of double."""
    compiled, interpreted, reference = cross_checks(name)
    corners, section = cells(name), sections(name)
    d = np.random.default_rng(9).standard_normal((COUNT, compiled.unknown_count))
    found = compiled.force(corners, section, d, np.longdouble)
    assert np.array_equal(found, interpreted.force(corners, section, d, np.longdouble))
    expected = reference.force(corners, section, d, np.longdouble)
    digits = np.finfo(np.longdouble).eps / np.finfo(float).eps
    assert difference(found, expected) <= 10 * EXACT * digits  # d is anyhow: forces of it cancel by a digit
