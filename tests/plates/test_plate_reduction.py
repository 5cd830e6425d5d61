"""Plates reduced to a few shapes: modes and integrals of textbook beams, statics of the finite elements."""

import numpy as np
import pytest
from shapely.geometry import LineString, box

from lamc import plate
from lamc.basics.errors import DesignError
from lamc.plates.answers.reduction import Attachment, Reduction, reduce_plate
from lamc.plates.elements.kernels import kernels
from tests.support.ctools import needs_cc

E, RHO, T, A, B = 70e9, 2700.0, 1e-3, 0.1, 0.01
# ν = 0: the plate is a row of beams.
SHEET = plate.Laminate([plate.Ply(plate.Material.isotropic(E, 0.0, RHO), T)])
CURLED = plate.Laminate([plate.Ply(plate.Material.isotropic(E, 0.3, RHO), T)])
END, TIP = LineString([(0, 0), (0, B)]), LineString([(A, 0), (A, B)])
MASS = RHO * T * A * B

pytestmark = needs_cc


def problem(laminate: plate.Laminate = SHEET, loads: tuple[object, ...] = (), nx: int = 40) -> plate.Problem:
    return plate.Problem(plate.grid(A, B, nx, 4), laminate, supports=[plate.Clamped(END)], loads=loads)


def test_a_strip_has_the_modes_and_integrals_of_a_cantilever() -> None:
    """φ = ∓1 at the tip: ω = λ² √(EI/ρA)/L², ∫φ/L = 2 σ/λ/2 and ∫φ²/L = 1/4 (Blevins 1979, table 8-1)."""
    found = reduce_plate(problem(), 3, static=False)
    lam, sigma = np.array([1.875104069, 4.694091133]), np.array([0.734095514, 1.018467319])
    omega = lam**2 * np.sqrt(E * T**2 / 12 / RHO) / A**2
    assert found.omega[:2] == pytest.approx(omega, rel=1e-3)  # 40 cells: (λ/40)² and less
    assert np.diag(found.mass)[:2] == pytest.approx([MASS / 4] * 2, rel=2e-3)
    signs = np.sign(found.shape_at(A, B / 2)[0][:2])
    assert signs * found.moment[:2] == pytest.approx(MASS * sigma / lam * [1.0, -1.0], rel=2e-3)
    assert abs(found.first_moment[0, 0]) == pytest.approx(MASS * A / lam[0] ** 2, rel=2e-3)  # ∫xφ = L²/λ²
    assert np.abs(found.first_moment[:2, 2]).max() == 0.0  # the reference surface is the middle


def test_natural_modes_stay_what_they_are() -> None:
    """Those of statics come after them and change none: the same frequencies as `plate.modes` gives."""
    expected = plate.modes(problem(CURLED), 4).omega
    found = reduce_plate(problem(CURLED), 4, [Attachment((A, B / 2), TIP)])
    assert found.natural == 4
    assert len(found.omega) == 4 + 1 + 3
    assert found.omega[:4] == pytest.approx(expected, rel=1e-9)
    size = np.sqrt(np.diag(found.stiffness))
    coupled = found.stiffness / np.outer(size, size) - np.eye(8)
    assert np.abs(coupled).max() <= 1e-9
    assert (found.omega[4:] > found.omega[3]).all()


def deflected(found: Reduction, generalised: np.ndarray) -> np.ndarray:
    return np.linalg.solve(found.stiffness, generalised)


def test_statics_under_a_field_is_that_of_the_elements() -> None:
    found = reduce_plate(problem(CURLED), 1)
    eta = deflected(found, -9.81 * found.moment)
    solution = plate.solve(problem(CURLED, (plate.SelfWeight((0.0, 0.0, -9.81)),)))
    for x, y in ((A, 0.0), (0.6 * A, B), (0.33 * A, 0.4 * B)):
        phi, slopes = found.shape_at(x, y)
        assert phi @ eta == pytest.approx(solution.deflection(x, y), rel=1e-8)
        assert slopes.T @ eta == pytest.approx(solution.slope(x, y), rel=1e-8, abs=1e-12)


@pytest.mark.parametrize("direction", range(3))
def test_statics_under_a_joined_body_is_that_of_the_elements(direction: int) -> None:
    """A force, and a moment each way, at a point a little off the edge: carried by the edge as by a rigid one. The
    same work is done by loads that the solver has: along the edge, even or in proportion to y, and a moment."""
    at = (A + 1e-3, B / 2)
    found = reduce_plate(problem(CURLED), 1, [Attachment(at, TIP)])
    load = np.zeros(3)
    load[direction] = 1e-2
    phi, slopes = found.shape_at(*at)
    eta = deflected(found, np.column_stack([phi, slopes]) @ load)
    force, by_x, by_y = load
    y = (np.arange(64) + 0.5) / 64 * B
    pushes = force / 64 + by_y * (y - B / 2) / ((y - B / 2) ** 2).sum()
    along = [plate.PointLoad((A, float(b)), float(f)) for b, f in zip(y, pushes, strict=True)]
    twist = plate.EdgeMoment(TIP, -(by_x + force * 1e-3) / B)
    solution = plate.solve(problem(CURLED, (*along, twist)))
    for b in (0.0, 0.3 * B, B):
        expected = solution.deflection(A, b)
        # The same forces; the moment along the edge by sums of as many samples, and by the solver's exact integrals.
        assert found.shape_at(A, b)[0] @ eta == pytest.approx(expected, rel=1e-3)


def test_points_off_the_plate_move_as_if_rigidly_joined() -> None:
    found = reduce_plate(problem(), 2)
    phi, slopes = found.shape_at(A, B / 2)
    beyond, same = found.shape_at(A + 5e-3, B / 2)
    assert beyond == pytest.approx(phi + 5e-3 * slopes[:, 0])
    assert same == pytest.approx(slopes)
    for values in found.shape_at(-1e-3, B / 2):
        assert np.abs(values).max() <= 1e-12


def test_a_plate_that_is_not_held_is_refused() -> None:
    loose = plate.Problem(plate.mesh(box(0, 0, A, B), 5e-3), SHEET)
    with pytest.raises(DesignError, match="a plate that is reduced needs a plate that is held"):
        reduce_plate(loose, 2)


def test_shapes_at_a_point_are_made_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Effects push at few points, and the independent cross-checks ask for the shapes there at every instant."""
    found = reduce_plate(problem(nx=4), 2)
    phi, slopes = found.shape_at(A, B / 2)
    monkeypatch.setattr("lamc.plates.answers.reduction.kernels", None)
    again = found.shape_at(A, B / 2)
    assert again[0] is phi
    assert again[1] is slopes
    assert not phi.flags.writeable
    assert not slopes.flags.writeable


def test_an_element_is_written_out_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Its text, by which the cache knows it, takes sympy longer than a small plate takes to solve."""
    element = problem(nx=4).dofs.element
    kernels(element)
    monkeypatch.setattr(type(element), "__repr__", None)
    assert kernels(element).unknown_count == kernels(element).unknown_count
