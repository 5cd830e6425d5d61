"""Least squares within bounds, against scipy's, and ends that closed forms know."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pytest
from scipy.optimize import least_squares, lsq_linear

from lamc.fitting.trust import Box, Local, local_of, minimise, triangle_of

Function = Callable[[np.ndarray], np.ndarray]


@dataclass
class Curve:
    """Residuals and Jacobian by formula."""

    residual: Function
    jacobian: Function
    at_once: bool = True
    known_to: float = 1e-12
    evaluated: int = 0

    def cost(self, x: np.ndarray) -> float:
        r = self.residual(x)
        return 0.5 * float(r @ r)

    def local(self, x: np.ndarray) -> Local:
        self.evaluated += 1
        return local_of(self.cost(x), self.residual(x), self.jacobian(x))


def box(p: int, low: float = -np.inf, high: float = np.inf) -> Box:
    return Box(np.full(p, low), np.full(p, high), np.ones(p))


@pytest.mark.parametrize("shape", [(3, 5), (40, 4), (5000, 7), (3000, 60)])
def test_triangles_have_the_squares_of_their_rows(shape: tuple[int, int]) -> None:
    rows = np.random.default_rng(0).normal(size=shape)
    triangle = triangle_of(rows)
    assert triangle.shape == (shape[1], shape[1])
    np.testing.assert_allclose(
        triangle.T @ triangle, rows.T @ rows, atol=1e-11 * shape[0]
    )  # round-off of sums


@pytest.mark.parametrize("at_once", [True, False])
def test_rosenbrock_ends_at_its_floor(at_once: bool) -> None:
    curve = Curve(
        lambda x: np.array([10.0 * (x[1] - x[0] ** 2), 1.0 - x[0]]),
        lambda x: np.array([[-20.0 * x[0], 10.0], [-1.0, 0.0]]),
        at_once,
    )
    found = minimise(curve, np.array([-1.2, 1.0]), box(2), 1e-12, 1e-12, 100)
    assert found.converged
    np.testing.assert_allclose(found.x, 1.0, atol=1e-9)  # steps below 1e-12 end it, quadratically


def test_linear_problems_within_bounds_end_where_scipy_does() -> None:
    rng = np.random.default_rng(3)
    for _ in range(20):
        a, b = rng.normal(size=(12, 5)), rng.normal(size=12)
        curve = Curve(lambda x, a=a, b=b: a @ x - b, lambda x, a=a: a)  # type: ignore[misc]
        found = minimise(curve, np.zeros(5), box(5, -0.2, 0.2), 1e-14, 1e-12, 200)
        expected = lsq_linear(a, b, (-0.2, 0.2), tol=1e-14).cost
        assert found.local.cost == pytest.approx(expected, rel=1e-9)  # it ends by gains of 1e-14 of the cost
        assert np.all(np.abs(found.x) <= 0.2)


def test_a_noisy_curve_ends_where_scipy_does_and_no_run_looks_whether_it_has() -> None:
    t = np.linspace(0.0, 2.0, 200)
    data = 3.0 * np.exp(-1.7 * t) + 0.05 * np.random.default_rng(1).normal(size=200)
    curve = Curve(
        lambda x: x[0] * np.exp(-x[1] * t) - data,
        lambda x: np.stack([np.exp(-x[1] * t), -x[0] * t * np.exp(-x[1] * t)], axis=1),
    )
    found = minimise(curve, np.array([1.0, 1.0]), box(2), 1e-10, 1e-12, 50)
    known = least_squares(curve.residual, [1.0, 1.0], curve.jacobian, xtol=1e-15, ftol=1e-15, gtol=1e-15)
    np.testing.assert_allclose(
        found.x, known.x, rtol=1e-5
    )  # a gain of 1e-10 of 200 data: 1e-4 of 0.02, the errors
    assert curve.evaluated == found.steps + 1


def test_directions_that_nothing_tells_are_not_gone_along() -> None:
    curve = Curve(lambda x: np.array([x[0] + x[1] - 2.0, 0.0]), lambda x: np.array([[1.0, 1.0], [0.0, 0.0]]))
    found = minimise(curve, np.array([0.0, 0.5]), box(2), 1e-12, 1e-12, 50)
    np.testing.assert_allclose(found.x, [0.75, 1.25], atol=1e-12)  # the nearest of the line x + y = 2


def test_points_without_a_run_are_stepped_back_from() -> None:
    def residual(x: np.ndarray) -> np.ndarray:
        return np.array([np.log(x[0])]) if x[0] > 0.0 else np.array([np.inf])

    curve = Curve(residual, lambda x: np.array([[1.0 / x[0]]]))
    found = minimise(curve, np.array([8.0]), box(1), 1e-14, 1e-12, 60)
    np.testing.assert_allclose(found.x, 1.0, atol=1e-9)  # quadratic
