"""Eigenproblems with rigid motions, repeated values and massless unknowns, on beams whose answers are printed."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
import scipy.sparse as sparse
from scipy.linalg import block_diag
from scipy.sparse.linalg import splu

from lamc.basics.errors import SimulationError
from lamc.plates.answers import eigen
from lamc.plates.answers.eigen import DENSE, rigid_basis, stability, vibration

Matrices = tuple[Any, Any, Any]

# β L of a beam free at both ends, cos(β L) cosh(β L) = 1 (R. D. Blevins, Formulas for Natural Frequency and Mode
# Shape, 1979, table 8-1).
FREE_FREE = np.array([4.73004074, 7.85320462, 10.9956078, 14.1371655])


def beam(count: int) -> Matrices:
    """Stiffness, mass and geometric stiffness (unit compression) of `count` cubic beam elements on [0, 1], EI = ρA = 1;
    unknowns are w and w' at every node. Przemieniecki 1968, sections 5.6, 11.3 and 15.2.
    """
    h = 1.0 / count
    bend = np.array(
        [[12, 6 * h, -12, 6 * h], [0, 4 * h * h, -6 * h, 2 * h * h], [0, 0, 12, -6 * h], [0, 0, 0, 4 * h * h]]
    )
    move = np.array(
        [
            [156, 22 * h, 54, -13 * h],
            [0, 4 * h * h, 13 * h, -3 * h * h],
            [0, 0, 156, -22 * h],
            [0, 0, 0, 4 * h * h],
        ]
    )
    rotation = np.array(
        [[36, 3 * h, -36, 3 * h], [0, 4 * h * h, -3 * h, -h * h], [0, 0, 36, -3 * h], [0, 0, 0, 4 * h * h]]
    )
    result = []
    for upper, factor in ((bend, h**-3), (move, h / 420), (rotation, -1 / (30 * h))):
        full = (upper + np.triu(upper, 1).T) * factor
        total = np.zeros((2 * count + 2, 2 * count + 2))
        for k in range(count):
            total[2 * k : 2 * k + 4, 2 * k : 2 * k + 4] += full
        result.append(sparse.csc_array(total))
    return result[0], result[1], result[2]


def rigid(count: int) -> np.ndarray:
    x = np.linspace(0.0, 1.0, count + 1)
    return np.stack(
        [np.stack([np.ones_like(x), 0 * x], 1).ravel(), np.stack([x, 1 + 0 * x], 1).ravel()], axis=1
    )


def factor(matrix: Any) -> Callable[[np.ndarray], np.ndarray]:
    return splu(sparse.csc_array(matrix)).solve  # type: ignore[no-any-return]


def assert_frequencies(values: np.ndarray, beta: np.ndarray, count: int) -> None:
    """ω² = β⁴ and the cubic beam's own error, (β h)⁴ / 720 of ω², from above; 1e-7 for nine printed digits of β, of
    which ω² is the fourth power, and for round-off of a stiffness that is conditioned like h⁻⁴."""
    own = (beta / count) ** 4 / 720
    excess = values / beta**4 - 1.0
    assert (np.abs(excess - own) <= 0.1 * own + 1e-7).all()


SIZES = {"dense": 20, "lanczos": 100}


@pytest.mark.parametrize("count", SIZES.values(), ids=SIZES)
def test_free_beam_vibrates_as_tabulated(count: int) -> None:
    K, M, _ = beam(count)
    assert (K.shape[0] > DENSE) == (count == SIZES["lanczos"])
    R = rigid(count)
    values, vectors = vibration(K, M, R, 4, factor)
    assert_frequencies(values, FREE_FREE, count)
    # Modes are orthonormal in the mass, and to the rigid motions: round-off of sums over the unknowns.
    np.testing.assert_allclose(vectors.T @ (M @ vectors), np.eye(4), rtol=0.0, atol=1e-10)
    np.testing.assert_allclose(R.T @ (M @ vectors), 0.0, rtol=0.0, atol=1e-10)


def test_a_value_repeated_three_times_is_found_three_times() -> None:
    """Three equal beams that do not touch: Lanczos from one vector would see one of each."""
    K, M, _ = beam(60)
    three = [sparse.csc_array(block_diag(*[A.toarray()] * 3)) for A in (K, M)]
    values, _ = vibration(three[0], three[1], np.kron(np.eye(3), rigid(60)), 7, factor)
    assert_frequencies(values, np.repeat(FREE_FREE[:3], [3, 3, 1]), 60)


def test_massless_rigid_motions_are_no_modes() -> None:
    """A free beam beside an equal one without mass: its rigid motions have no frequency, not even zero."""
    K, M, _ = beam(60)
    stiffness = sparse.csc_array(block_diag(K.toarray(), K.toarray()))
    mass = sparse.csc_array(block_diag(M.toarray(), 0 * M.toarray()))
    motions = np.kron(np.eye(2), rigid(60))
    heavy, which = rigid_basis(motions, mass)
    assert (heavy.shape[1], which) == (2, [0, 1])
    values, vectors = vibration(stiffness, mass, motions, 2, factor)
    assert_frequencies(values, FREE_FREE[:2], 60)
    assert np.isfinite(vectors).all()


def test_a_stiffness_that_is_not_positive_is_refused() -> None:
    K, M, G = beam(20)
    with pytest.raises(SimulationError, match=r"buckling factors were not found: .* check units"):
        stability(sparse.csc_array(-K), G, 2, factor)
    with pytest.raises(SimulationError, match="natural frequencies were not found"):
        vibration(sparse.csc_array(-K), M, rigid(20), 2, factor)


@pytest.mark.parametrize("count", SIZES.values(), ids=SIZES)
@pytest.mark.parametrize("sign", [1, -1])
def test_pinned_beam_buckles_at_eulers_loads(count: int, sign: int) -> None:
    """π² n². Pulled instead, the factors are the same with the other sign, and of the first sign there are none."""
    K, _, G = beam(count)
    keep = np.setdiff1d(np.arange(K.shape[0]), [0, K.shape[0] - 2])
    stiffness, geometric = (sparse.csc_array(A[keep][:, keep]) for A in (K, sign * G))
    factors, _ = stability(stiffness, geometric, 3, factor, [sign])[sign]
    # Order four again; π² of the first is exact, 3π h = 0.47 of the third gives 6e-5 with 20 elements.
    assert factors == pytest.approx(sign * np.pi**2 * np.array([1, 4, 9]), rel=1e-4 if count == 20 else 2e-7)
    solved = 0

    def counted(matrix: Any) -> Callable[[np.ndarray], np.ndarray]:
        solve = factor(matrix)

        def counting(b: np.ndarray) -> np.ndarray:
            nonlocal solved
            solved += 1
            return solve(b)

        return counting

    none, vectors = stability(stiffness, geometric, 3, counted)[-sign]
    assert len(none) == 0
    assert vectors.shape[1] == 0
    # Lanczos waited for round-off to converge, 100 000 solutions long.
    assert solved < 5000


@pytest.mark.parametrize("rounds", [100, 1])
def test_factors_of_the_other_sign_are_found_though_they_are_many_times_larger(
    rounds: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Two beams by themselves, one pressed and the other pulled by a thousandth of it; by Lanczos alone, and where it
    does not settle at once and they are counted first."""
    monkeypatch.setattr(eigen, "_ROUNDS", rounds)
    K, _, G = beam(60)
    keep = np.setdiff1d(np.arange(K.shape[0]), [0, K.shape[0] - 2])
    K, G = (A.toarray()[np.ix_(keep, keep)] for A in (K, G))
    stiffness = sparse.csc_array(block_diag(K, K))
    geometric = sparse.csc_array(block_diag(G, -1e-3 * G))
    found = stability(stiffness, geometric, 2, factor)
    for sign, least in ((1, np.pi**2), (-1, 1e3 * np.pi**2)):
        factors, _ = found[sign]
        # Order four of 60 elements leaves 2e-7, as above; round-off of K⁻¹, by the square of its part, less.
        assert factors == pytest.approx(sign * least * np.array([1, 4]), rel=1e-6)


@pytest.mark.parametrize("count", SIZES.values(), ids=SIZES)
def test_round_off_is_no_factor(count: int) -> None:
    """Forces that press one place only, and one that is pulled a millionth of a millionth as hard: of what is not
    pressed, solutions leave 1e-17 of the largest inverse factor, of either sign."""
    K, _, _ = beam(count)
    keep = np.setdiff1d(np.arange(K.shape[0]), [0, K.shape[0] - 2])
    stiffness = sparse.csc_array(K[keep][:, keep])
    for pulled in (0.0, 1e-12):
        geometric = np.zeros(stiffness.shape)
        geometric[5, 5], geometric[9, 9] = -1.0, pulled
        found = stability(stiffness, sparse.csc_array(geometric), 3, factor)
        inverse = np.linalg.inv(stiffness.toarray())[5, 5]  # of K - λ e eᵀ: 1 = λ eᵀ K⁻¹ e
        # Round-off of K⁻¹, whose condition grows like the fourth power of the elements: 1e8 of a hundred.
        assert found[1][0] == pytest.approx([1.0 / inverse], rel=1e-7)
        assert len(found[-1][0]) == 0


@pytest.mark.parametrize(("factor_of_all", "expected"), [(5.0, 0), (20.0, 1), (50.0, 2), (100.0, 3)])
@pytest.mark.parametrize("sign", [1, -1])
def test_factors_are_counted(factor_of_all: float, expected: int, sign: int) -> None:
    """π² n² of a pinned beam: 9.87, 39.5, 88.8, 158."""
    K, _, G = beam(60)
    keep = np.setdiff1d(np.arange(K.shape[0]), [0, K.shape[0] - 2])
    stiffness, geometric = (sparse.csc_array(A[keep][:, keep]) for A in (K, sign * G))
    assert eigen._pressed(stiffness, geometric, sign * factor_of_all) == expected


def test_where_factors_cannot_be_counted_all_are_looked_for() -> None:
    nothing = sparse.csc_array((4, 4))
    assert eigen._pressed(nothing, nothing, 1.0) == 4
