"""Kernels of finite elements: C against the interpreted program and the third cross-check, hostile input, the cache."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

from lamc.basics.errors import DesignError, UnsupportedError
from lamc.plates.elements.kernels import ElementKernels, kernels
from lamc.plates.elements.library import ELEMENTS, element
from lamc.reference.plate_elements import ReferenceElement
from tests.support.ctools import needs_cc

pytestmark = needs_cc

Array = npt.NDArray[np.float64]
# Those with shear read sections for strains as well: test_plate_dkmt.py. The last two: coupled where the laminate
# has B.
NAMES = (*sorted(name for name in ELEMENTS if not ELEMENTS[name].shear), "dkt+cst", "bfs+q4")
CELLS = 7  # more than the lanes of the C, and not a multiple of them


def cells(name: str, count: int, seed: int = 1) -> Array:
    """Corners (count, c, 2) of cells of ordinary shape, some 1e-3 m long; rectangles where the element needs them."""
    rng = np.random.default_rng(seed)
    size = rng.uniform(0.8e-3, 1.2e-3, (count, 1, 2))
    if element(name).corner_count == 3:
        return size * (np.array([[0, 0], [1, 0.1], [0.2, 1]]) + rng.uniform(-0.15, 0.15, (count, 3, 2)))
    square = np.array([[0, 0], [1, 0], [1, 1], [0, 1.0]])
    wobble = 0.0 if element(name).bends else rng.uniform(-0.15, 0.15, (count, 4, 2))
    return size * (square + wobble)


def inputs(made: ElementKernels, count: int, seed: int = 2) -> Mapping[str, tuple[Any, ...]]:
    """Arguments besides the corners for every function of the element."""
    rng = np.random.default_rng(seed)
    xi, d = rng.uniform(0.1, 0.4, (count, 2)), rng.standard_normal((count, made.unknown_count))
    section = rng.standard_normal((count, made.section_count))
    found: dict[str, tuple[Any, ...]] = {
        "stiffness": (section,),
        "mass": (rng.uniform(0.1, 1.0, count),),
        "load": (rng.standard_normal((count, len(made.element.fields), made.corner_count)),),
        "prestress": (rng.standard_normal((count, made.strain_count)),),
        "strain": (xi, d),
        "displacement": (xi, d),
        "force": (section, d),
    }
    if made.element.bends:
        found["geometric"] = (rng.standard_normal((count, 3)),)
    return found


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.quick("bciz", "bfs", "dkt", "q4", "specht", "dkt+cst", others="campaign")
def test_c_gives_the_bits_of_the_interpreted_program(name: str) -> None:
    """Both take the same operations in the same order; -ffp-contract=off. In long double too."""
    compiled, interpreted = kernels(name), kernels(name, "interpreted")
    corners = cells(name, CELLS)
    for function, arguments in inputs(compiled, CELLS).items():
        in_c = getattr(compiled, function)(corners, *arguments)
        assert np.array_equal(in_c, getattr(interpreted, function)(corners, *arguments)), function
    section, d = inputs(compiled, CELLS)["force"]
    in_c = compiled.force(corners, section, d, np.longdouble)
    assert in_c.dtype == np.longdouble
    assert np.array_equal(in_c, interpreted.force(corners, section, d, np.longdouble))


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.quick("[!b]*", "bciz", "bfs")
def test_c_agrees_with_the_third_cross_check(name: str) -> None:
    """1e-13 of the largest entry: sums of some hundred terms, each rounded at 1e-16, that cancel to a hundredth."""
    compiled, reference = kernels(name), ReferenceElement(name)
    corners = cells(name, CELLS)
    for function, arguments in inputs(compiled, CELLS).items():
        found = getattr(compiled, function)(corners, *arguments)
        expected = getattr(reference, function)(corners, *arguments)
        assert found.shape == expected.shape, function
        assert np.abs(found - expected).max() <= 1e-13 * np.abs(expected).max(), function


@pytest.mark.parametrize("name", NAMES)
def test_matrices_are_symmetric_to_the_last_bit(name: str) -> None:
    made = kernels(name)
    corners, given = cells(name, CELLS), inputs(made, CELLS)
    for function in ("stiffness", "mass", "geometric"):
        if function in given:
            matrices = getattr(made, function)(corners, *given[function])
            assert np.array_equal(matrices, matrices.swapaxes(1, 2)), function


def test_cells_do_not_see_their_neighbours() -> None:
    """One cell alone gives the bits that it gives among others, wherever it lies in a group of lanes."""
    made = kernels("dkt")
    corners, (sections,) = cells("dkt", 5), inputs(made, 5)["stiffness"]
    together = made.stiffness(corners, sections)
    for k in range(5):
        assert np.array_equal(made.stiffness(corners[k : k + 1], sections[k : k + 1])[0], together[k])


def test_no_cells_give_no_rows() -> None:
    made = kernels("dkt")
    assert made.stiffness(np.zeros((0, 3, 2)), np.zeros((0, 6))).shape == (0, 9, 9)
    assert made.force(np.zeros((0, 3, 2)), np.zeros((0, 6)), np.zeros((0, 9)), np.longdouble).shape == (0, 9)


def test_force_in_long_double_has_its_digits() -> None:
    """Cells three times as large: what moments do to slopes stays, and forces fall as lengths grow. Exact in the
    formulas, so what differs is round-off: below 1e-17, out of reach of doubles."""
    if np.finfo(np.longdouble).eps == np.finfo(float).eps:
        pytest.skip("long double is double here")
    made = kernels("specht")
    corners, (section, d) = cells("specht", 1), inputs(made, 1)["force"]
    coarse = made.force(corners, section, d)
    fine = made.force(corners, section, d, np.longdouble)
    scale = np.abs(coarse).max()
    assert 0 < np.abs(fine - coarse).max() < 1e-13 * scale
    deflection = np.array([dof == "w" for dof in made.element.dofs])
    scaled = made.force(corners * np.longdouble(3), section, np.where(deflection, 3 * d, d), np.longdouble)
    expected = np.where(deflection, fine / 3, fine)
    assert np.abs(scaled - expected).max() < 1e-17 * scale


HOSTILE = {
    "nan": np.nan,
    "inf": np.inf,
    "huge": 1e300,
    "tiny": 1e-320,
    "zero": 0.0,
}


@pytest.mark.parametrize("value", HOSTILE.values(), ids=HOSTILE)
def test_numbers_that_make_no_cell_give_numbers_and_no_crash(value: float) -> None:
    for name in NAMES:
        made = kernels(name)
        corners = np.full((3, made.corner_count, 2), value)
        for function, arguments in inputs(made, 3).items():
            found = getattr(made, function)(corners, *arguments)
            assert len(found) == 3
            if np.isnan(value) and function not in ("displacement",):
                assert np.isnan(found).any(), (name, function)


def test_a_nan_stays_in_its_cell() -> None:
    made = kernels("bciz")
    corners, (sections,) = cells("bciz", 4), inputs(made, 4)["stiffness"]
    corners[2, 0, 0] = np.nan
    found = made.stiffness(corners, sections)
    assert np.isfinite(found[[0, 1, 3]]).all()
    assert np.isnan(found[2]).any()


def test_other_layouts_and_types_are_taken_as_they_are_meant() -> None:
    made = kernels("cst")
    corners, (sections,) = cells("cst", 4), inputs(made, 4)["stiffness"]
    expected = made.stiffness(corners, sections)
    assert np.array_equal(made.stiffness(np.asfortranarray(corners), sections[::-1][::-1]), expected)
    assert np.array_equal(made.stiffness(corners.tolist(), sections.astype(">f8")), expected)
    single = corners.astype(np.float32)
    assert np.array_equal(made.stiffness(single, sections), made.stiffness(single.astype(float), sections))


REFUSED: Mapping[str, tuple[Any, Any, str]] = {
    "corners of another cell": (np.zeros((3, 4, 2)), np.zeros((3, 6)), r"corners have shape \(3, 4, 2\)"),
    "one cell without its axis": (
        np.zeros((3, 2)),
        np.zeros((3, 6)),
        r"must be \(m, 3, 2\), one row per cell",
    ),
    "fewer sections than cells": (np.zeros((3, 3, 2)), np.zeros((2, 6)), r"sections have shape \(2, 6\)"),
    "coupled sections": (np.zeros((3, 3, 2)), np.zeros((3, 18)), r"must be \(3, 6\)"),
    "complex": (np.zeros((3, 3, 2)), np.zeros((3, 6), dtype=complex), "real numbers"),
    "text": (np.zeros((3, 3, 2)), "soft", "real numbers"),
    "nothing": (np.zeros((3, 3, 2)), None, "real numbers"),
    "ragged": (np.zeros((3, 3, 2)), [[1.0], [2.0, 3.0]], "real numbers"),
}


@pytest.mark.parametrize("case", sorted(REFUSED))
def test_arrays_that_do_not_fit_are_refused_by_name(case: str) -> None:
    corners, sections, reported = REFUSED[case]
    with pytest.raises(DesignError, match=reported):
        kernels("dkt").stiffness(corners, sections)


def test_other_refusals() -> None:
    made = kernels("cst")
    with pytest.raises(UnsupportedError, match="'cst' has no deflection"):
        made.geometric(np.zeros((1, 3, 2)), np.zeros((1, 3)))
    with pytest.raises(DesignError, match=r"dtype is .*float or numpy\.longdouble"):
        made.force(np.zeros((1, 3, 2)), np.zeros((1, 6)), np.zeros((1, 6)), np.float32)
    with pytest.raises(DesignError, match="backend is 'fortran'"):
        kernels("cst", "fortran")  # type: ignore[arg-type]
    with pytest.raises(DesignError, match="the element is 3"):
        kernels(3)  # type: ignore[arg-type]
