"""Matrices of plate and membrane elements against those in textbooks and papers."""

import numpy as np

from tests.support.staged_elements import (
    isotropic,
    staged,
)


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
