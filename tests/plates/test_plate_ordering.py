"""Orders for sparse factors: every unknown once, few entries, and the same answer whatever the order."""

import numpy as np
import pytest
import scipy.sparse.linalg as sla
from shapely.geometry import Point, box

from lamc import plate
from lamc.plates.solving.dissection import nested_dissection
from lamc.plates.solving.solvers import SuperLU
from lamc.plates.solving.system import System, places_of
from tests.support.plates import isotropic

MESHES = {
    "slivers": lambda: plate.grid(1.0, 1.0, 4, 1000),  # the longer side of a part has the fewer cells
    "grid": lambda: plate.grid(1.0, 1.0, 40, 40),
    "strip": lambda: plate.grid(20.0, 1.0, 200, 10, "criss-cross"),
    "holed": lambda: plate.mesh(box(0, 0, 1, 1).difference(Point(0.4, 0.4).buffer(0.2)), size=0.03),
}


def system(name: str) -> System:
    problem = plate.Problem(MESHES[name](), isotropic(), supports=[plate.Clamped("boundary")])
    return plate.FactoredPlate(problem, "superlu").system


@pytest.mark.parametrize("name", MESHES)
def test_dissection_orders_every_unknown_once_and_the_same_every_time(name: str) -> None:
    made = system(name)
    matrix, _ = made._reduced
    points = places_of(made.constraints.free, made.problem.dofs)
    order = nested_dissection(matrix, points)
    assert np.array_equal(np.sort(order), np.arange(matrix.shape[0]))
    assert np.array_equal(order, nested_dissection(matrix, points))


@pytest.mark.quick("holed-1.8", "grid-1.4")
@pytest.mark.parametrize(("name", "worst"), [("grid", 1.4), ("strip", 3.5), ("holed", 1.8), ("slivers", 3.5)])
def test_dissection_fills_about_as_little_as_minimum_degree(name: str, worst: float) -> None:
    # Within a constant; long strips suit minimum degree, and are cheap in any order.
    made = system(name)
    matrix, _ = made._reduced
    ours = made.factor
    assert isinstance(ours, SuperLU)
    options = {"SymmetricMode": True}
    theirs = sla.splu(matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options=options)
    assert ours._lu.nnz / theirs.nnz < worst
    right = np.linspace(0.0, 1.0, matrix.shape[0])
    one, other = ours.solve(right), theirs.solve(right)
    close = made.condition * np.finfo(float).eps * np.abs(other).max()
    assert one == pytest.approx(other, abs=close)
    several = ours.solve(np.stack([right, 2.0 * right], axis=1))
    assert several[:, 1] == pytest.approx(2.0 * one, abs=close)
    again = ours.refactored(2.0 * matrix)
    assert again.solve(right) == pytest.approx(
        0.5 * one, rel=1e-12
    )  # halves are exact; the order is the same
