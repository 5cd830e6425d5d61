"""Soft strips between stiff links: the digits of their turn, on coarse and fine meshes."""

from pathlib import Path

import numpy as np
import pytest
from shapely.geometry import box

from lamc import plate
from tests.support.ctools import needs_cc
from tests.support.plate_meshes import published, sheet, sides, solved

pytestmark = needs_cc

GAP = 0.01  # m, width of the strip between two links of 1 m
COARSE, FINE = (8, 2, 4), (40, 10, 100)  # parts along a link, along the strip, and across


def links(parts: tuple[int, int, int]) -> plate.Mesh:
    """Two links and the strip between them, 2.01 m long and 1 m wide; regions "" and "hinge"."""
    link, strip, across = parts
    first, second = np.linspace(0, 1, link + 1), 1 + np.linspace(0, GAP, strip + 1)
    x = np.concatenate([first, second[1:-1], first + 1 + GAP])
    return plate.grid_of_lines(x, np.linspace(0, 1, across + 1), regions={"hinge": box(1, 0, 1 + GAP, 1)})


def turned(parts: tuple[int, int, int], ratio: float, element: str = "dkt") -> np.ndarray:
    """Rotation along the tip under a unit moment per width, the other end clamped."""
    edge = sides(2 + GAP, 1.0)
    laminates = {"": sheet(1.0, nu=0.0), "hinge": sheet(ratio, nu=0.0)}
    tip = plate.EdgeMoment(edge["right"], 1.0)
    solution = solved(links(parts), laminates, [plate.Clamped(edge["left"])], [tip], element)
    return -np.asarray(solution.slope([2 + GAP] * 5, [0.0, 0.2, 0.5, 0.7, 1.0]))[:, 0]


CASES = [(k, parts) for k in range(3) for parts in (COARSE, FINE)]


@pytest.mark.parametrize(("k", "parts"), CASES)
@pytest.mark.quick("0-parts0", "1-parts2")
def test_a_soft_strip_between_stiff_links_turns_as_in_closed_form(
    shared: Path, k: int, parts: tuple[int, int, int]
) -> None:
    """Curvature is constant in each part, so that DKT is exact, and all that is left is round-off: ten times fewer
    digits lost than the case allows."""
    case = published(shared, "hinge")
    ratio, expected = case["inputs"]["r"][k], case["expected"][k]
    assert expected == pytest.approx(2.0 + GAP / ratio, rel=1e-12)
    found = turned(parts, ratio)
    np.testing.assert_allclose(found, expected, rtol=case["rel_tol"] / 10.0, atol=0)


@pytest.mark.parametrize("element", ["specht", "dkt+cst"])
@pytest.mark.quick("dkt+cst")
def test_other_elements_that_pass_the_patch_test_keep_the_digits_too(element: str) -> None:
    np.testing.assert_allclose(turned(COARSE, 1e-6, element), 2.0 + GAP / 1e-6, rtol=1e-9, atol=0)


def test_bciz_is_a_fifth_too_soft_at_a_strip() -> None:
    """A fact about the element, to the digits that it is known with: the strip's grid differs from the links'."""
    assert turned(COARSE, 1e-3, "bciz").mean() == pytest.approx(1.20 * 12.0, rel=0.03)
