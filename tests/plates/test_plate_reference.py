"""The numeric plate elements against formulas as printed, closed forms and what every element must do."""

import numpy as np
import pytest

from lamc.basics.errors import DesignError, UnsupportedError
from lamc.reference.plate_elements import ReferenceElement
from lamc.reference.plate_layout import CORNERS

NAMES = [
    "bciz",
    "dkt",
    "specht",
    "bfs",
    "cst",
    "lst",
    "q4",
    "q8",
    "q9",
    "q12",
    "dkt+cst",
    "specht+lst",
    "bfs+q12",
]
TRIANGLE = np.array([[[0.3, -0.2], [2.1, 0.4], [0.9, 1.7]]])
RECTANGLE = np.array([[[0.3, -0.2], [2.1, -0.2], [2.1, 0.9], [0.3, 0.9]]])
D6 = np.array([3.0, 1.0, 0.2, 2.0, -0.1, 0.8])
UNIQUE = ([0, 0, 0, 1, 1, 2], [0, 1, 2, 1, 2, 2])
# Sums of some hundred products of like size, cancelling by a digit or two in the elements with high powers.
ROUND_OFF = 1e-13


def matrix(entries: np.ndarray) -> np.ndarray:
    full = np.zeros((3, 3))
    full[UNIQUE] = entries
    return full + np.triu(full, 1).T


def corners_of(element: ReferenceElement) -> np.ndarray:
    return TRIANGLE if element.element.cell == "triangle" else RECTANGLE


def area_of(element: ReferenceElement) -> float:
    x, y = corners_of(element)[0].T
    return float(0.5 * np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y))


def sections_of(element: ReferenceElement) -> np.ndarray:
    both = element.element.stretches and element.element.bends
    return np.concatenate([D6, 0.1 * D6[::-1], D6])[None] if both else D6[None]


def nodal_values(element: ReferenceElement) -> np.ndarray:
    """Unknowns of w = x² + 2 xy - 3 y² + x and u = 2x + y, v = x - 3y."""
    cell = element.element.cell
    corners = corners_of(element)[0]
    values = []
    for node in element.element.nodes:
        xi, eta = float(node.at[0]), float(node.at[1])
        weight = (
            np.array([1 - xi - eta, xi, eta])
            if cell == "triangle"
            else np.array([(1 + xi * float(s)) * (1 + eta * float(t)) / 4 for s, t in CORNERS[cell]])
        )
        x, y = weight @ corners
        known = {
            "u": 2 * x + y,
            "v": x - 3 * y,
            "w": x * x + 2 * x * y - 3 * y * y + x,
            "w_x": 2 * x + 2 * y + 1,
            "w_y": 2 * x - 6 * y,
            "w_xy": 2.0,
        }
        values += [known[dof] for dof in node.dofs]
    return np.array([values])


@pytest.mark.parametrize("name", NAMES)
def test_constant_strain_and_curvature_are_reproduced_everywhere(name: str) -> None:
    element = ReferenceElement(name)
    membrane, bending = [2.0, -3.0, 2.0], [-2.0, 6.0, -4.0]
    expected = membrane * element.element.stretches + bending * element.element.bends
    for xi in ((0.1, 0.2), (0.6, 0.3), (0.0, 1.0)):
        found = element.strain(corners_of(element), [xi], nodal_values(element))[0]
        np.testing.assert_allclose(found, expected, rtol=0, atol=10 * ROUND_OFF)


@pytest.mark.parametrize("name", NAMES)
def test_stiffness_knows_rigid_motions_only(name: str) -> None:
    element = ReferenceElement(name)
    K = element.stiffness(corners_of(element), sections_of(element))[0]
    values = np.linalg.eigvalsh(K)
    rigid = 3 * (element.element.stretches + element.element.bends)
    assert np.all(np.abs(values[:rigid]) < ROUND_OFF * values[-1])
    assert values[rigid] > 1e-4 * values[-1]  # an element of good shape has no other soft mode


@pytest.mark.parametrize("name", NAMES)
def test_energy_force_load_and_mass_agree_with_constant_fields(name: str) -> None:
    element = ReferenceElement(name)
    corners, sections, d = corners_of(element), sections_of(element), nodal_values(element)
    area = area_of(element)
    strain = element.strain(corners, [(0.2, 0.3)], d)[0]
    if sections.shape[1] == 6:
        S = matrix(D6)
    else:
        A, B, D = (matrix(sections[0, 6 * k : 6 * k + 6]) for k in range(3))
        S = np.block([[A, B], [B, D]])
    energy = strain @ S @ strain * area
    scale = np.abs(strain) @ np.abs(S) @ np.abs(strain) * area
    K, f = element.stiffness(corners, sections)[0], element.force(corners, sections, d)[0]
    assert d[0] @ K @ d[0] == pytest.approx(energy, abs=100 * ROUND_OFF * scale)  # d is tens of strains
    assert d[0] @ f == pytest.approx(energy, abs=100 * ROUND_OFF * scale)
    stress = element.prestress(corners, (S @ strain)[None])[0]
    assert d[0] @ stress == pytest.approx(energy, abs=100 * ROUND_OFF * scale)
    dofs = element.element.dofs
    for dof in {"u", "w"} & set(dofs):  # moved as a whole by 1
        moved = np.array([float(name == dof) for name in dofs])
        assert moved @ element.mass(corners, [2.5])[0] @ moved == pytest.approx(2.5 * area, rel=ROUND_OFF)
        fields = [name for name in ("u", "v", "w") if name in dofs]
        push = np.zeros((1, len(fields), len(corners[0])))
        push[0, fields.index(dof)] = 3.0
        assert moved @ element.load(corners, push)[0] == pytest.approx(3.0 * area, rel=ROUND_OFF)


@pytest.mark.parametrize("name", ["bciz", "dkt", "specht", "bfs"])
def test_geometric_stiffness_of_a_tilted_element_is_that_of_a_membrane(name: str) -> None:
    """w = 2x - y: the work of N is N_x w_x² + 2 N_xy w_x w_y + N_y w_y² per area, twice."""
    element = ReferenceElement(name)
    corners = corners_of(element)
    place = {"w": corners[0] @ [2.0, -1.0], "w_x": [2.0] * 4, "w_y": [-1.0] * 4, "w_xy": [0.0] * 4}
    size = len(element.element.dofs) // len(corners[0])
    d = np.array([place[dof][k // size] for k, dof in enumerate(element.element.dofs)])
    work = d @ element.geometric(corners, [[5.0, 7.0, 1.0]])[0] @ d
    assert work == pytest.approx((4 * 5.0 + 7.0 - 2 * 2 * 1.0) * area_of(element), rel=ROUND_OFF)


def specht_as_printed(corners: np.ndarray, L: np.ndarray) -> np.ndarray:
    """w of the nine unknowns at area coordinates L, from Specht 1988, as in Zienkiewicz and Taylor, vol. 2, 1991,
    eqs. 1.60 and 1.61."""
    x, y = corners.T
    b = np.array([y[1] - y[2], y[2] - y[0], y[0] - y[1]])
    c = np.array([x[2] - x[1], x[0] - x[2], x[1] - x[0]])
    l2 = b**2 + c**2
    mu = [(l2[2] - l2[1]) / l2[0], (l2[0] - l2[2]) / l2[1], (l2[1] - l2[0]) / l2[2]]
    bubble = 0.5 * L[0] * L[1] * L[2]

    def cubic(i: int, j: int, m: float, k: int) -> float:
        return L[i] ** 2 * L[j] + bubble * (3 * (1 - m) * L[i] - (1 + 3 * m) * L[j] + (1 + 3 * m) * L[k])

    P = [
        L[0], L[1], L[2], L[0] * L[1], L[1] * L[2], L[2] * L[0],
        cubic(0, 1, mu[2], 2), cubic(1, 2, mu[0], 0), cubic(2, 0, mu[1], 1),
    ]  # fmt: skip
    rows = []
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        rows += [
            P[i] - P[i + 3] + P[k + 3] + 2 * (P[i + 6] - P[k + 6]),
            -b[j] * (P[k + 6] - P[k + 3]) - b[k] * P[i + 6],
            -c[j] * (P[k + 6] - P[k + 3]) - c[k] * P[i + 6],
        ]
    return np.array(rows)


def test_specht_from_its_edge_condition_is_specht_as_printed() -> None:
    element = ReferenceElement("specht")
    for xi, eta in ((0.2, 0.3), (0.5, 0.1), (1 / 3, 1 / 3), (0.05, 0.9)):
        found = element.displacement(np.repeat(TRIANGLE, 9, axis=0), [(xi, eta)] * 9, np.eye(9))[:, 0]
        w, theta_x, theta_y = (
            specht_as_printed(TRIANGLE[0], np.array([1 - xi - eta, xi, eta])).reshape(3, 3).T
        )
        expected = np.transpose([w, -theta_y, theta_x]).ravel()  # θx = w_y, θy = -w_x
        np.testing.assert_allclose(found, expected, rtol=0, atol=ROUND_OFF)


def dkt_slopes_as_printed(corners: np.ndarray, xi: float, eta: float) -> np.ndarray:
    """Hx and Hy of Batoz 1982 (Int. J. Numer. Meth. Engng 18), as Batoz, Bathe and Ho 1980, table IV: rotations
    βx = -w_x, βy = -w_y for the unknowns w, θx = w_y, θy = -w_x."""
    x, y = corners.T
    p, q, t, r = {}, {}, {}, {}
    for k, (i, j) in zip((4, 5, 6), ((1, 2), (2, 0), (0, 1)), strict=True):
        xij, yij = x[i] - x[j], y[i] - y[j]
        length = xij**2 + yij**2
        p[k], t[k] = -6 * xij / length, -6 * yij / length
        q[k], r[k] = 3 * xij * yij / length, 3 * yij**2 / length
    a, d, b, c, e = {}, {}, {}, {}, {}
    for k, (i, j) in zip((4, 5, 6), ((1, 2), (2, 0), (0, 1)), strict=True):
        xij, yij = x[i] - x[j], y[i] - y[j]
        length = xij**2 + yij**2
        a[k], b[k] = -xij / length, 0.75 * xij * yij / length
        c[k] = (0.25 * xij**2 - 0.5 * yij**2) / length
        d[k], e[k] = -yij / length, (0.25 * yij**2 - 0.5 * xij**2) / length
    L = 1 - xi - eta
    N = [L * (2 * L - 1), xi * (2 * xi - 1), eta * (2 * eta - 1), 4 * xi * eta, 4 * eta * L, 4 * xi * L]
    n = {k + 1: value for k, value in enumerate(N)}
    hx, hy = [], []
    for i, (before, after) in zip((1, 2, 3), ((5, 6), (6, 4), (4, 5)), strict=True):
        # the edges that meet at corner i: `after` is where it comes first (i - j), `before` where it comes last
        hx += [
            1.5 * (a[after] * n[after] - a[before] * n[before]),
            b[before] * n[before] + b[after] * n[after],
            n[i] - c[before] * n[before] - c[after] * n[after],
        ]
        hy += [
            1.5 * (d[after] * n[after] - d[before] * n[before]),
            -n[i] + e[before] * n[before] + e[after] * n[after],
            -b[before] * n[before] - b[after] * n[after],
        ]
    return np.array([hx, hy])


def test_dkt_from_its_constraints_is_dkt_as_printed() -> None:
    element = ReferenceElement("dkt")
    for xi, eta in ((0.2, 0.3), (0.5, 0.1), (0.05, 0.9)):
        found = element.displacement(np.repeat(TRIANGLE, 9, axis=0), [(xi, eta)] * 9, np.eye(9))[:, 1:]
        hx, hy = dkt_slopes_as_printed(TRIANGLE[0], xi, eta)
        w_x = [[-hx[3 * k], hx[3 * k + 2], -hx[3 * k + 1]] for k in range(3)]  # by w, w_x = -θy, w_y = θx
        w_y = [[-hy[3 * k], hy[3 * k + 2], -hy[3 * k + 1]] for k in range(3)]
        np.testing.assert_allclose(found[:, 0], np.ravel(w_x), rtol=0, atol=ROUND_OFF)
        np.testing.assert_allclose(found[:, 1], np.ravel(w_y), rtol=0, atol=ROUND_OFF)


def test_bciz_is_as_printed() -> None:
    """Zienkiewicz 1977, eq. 10.26: N1 = L1 + L1²L2 + L1²L3 - L1L2² - L1L3², and its slopes."""
    element = ReferenceElement("bciz")
    x, y = TRIANGLE[0].T
    for xi, eta in ((0.2, 0.3), (0.5, 0.1), (0.05, 0.9)):
        found = element.displacement(np.repeat(TRIANGLE, 9, axis=0), [(xi, eta)] * 9, np.eye(9))[:, 0]
        L = np.array([1 - xi - eta, xi, eta])
        half = 0.5 * L[0] * L[1] * L[2]
        expected = []
        for i in range(3):
            j, k = (i + 1) % 3, (i + 2) % 3
            to_j, to_k = L[i] ** 2 * L[j] + half, L[i] ** 2 * L[k] + half
            expected += [
                L[i] + L[i] ** 2 * (L[j] + L[k]) - L[i] * (L[j] ** 2 + L[k] ** 2),
                (x[j] - x[i]) * to_j + (x[k] - x[i]) * to_k,
                (y[j] - y[i]) * to_j + (y[k] - y[i]) * to_k,
            ]
        np.testing.assert_allclose(found, expected, rtol=0, atol=ROUND_OFF)


def test_a_bilinear_square_is_as_published() -> None:
    """Unit square, plane stress, E = 1, ν = 0: the 2 × 2 rule gives k11 = 1/2, k12 = 1/8 (closed form)."""
    element = ReferenceElement("q4")
    square = np.array([[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]])
    K = element.stiffness(square, [[1.0, 0.0, 0.0, 1.0, 0.0, 0.5]])[0]
    np.testing.assert_allclose(
        K[0], [1 / 2, 1 / 8, -1 / 4, -1 / 8, -1 / 4, -1 / 8, 0, 1 / 8], rtol=0, atol=1e-15
    )


@pytest.mark.parametrize("name", ["", "dkt+dkt", "cst+cst", "dkt+q4", "melosh", "dkt+cst+lst"])
def test_an_unknown_element_is_refused_with_the_list(name: str) -> None:
    with pytest.raises(UnsupportedError, match=r"take one of bciz, dkt"):
        ReferenceElement(name)


def test_corners_of_another_cell_are_refused() -> None:
    with pytest.raises(DesignError, match=r"\(1, 4, 2\); it must be \(m, 3, 2\)"):
        ReferenceElement("dkt").stiffness(RECTANGLE, D6[None])
