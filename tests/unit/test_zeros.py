"""Common zeros of quadratic forms, against forms that are made with known zeros; and the work that it takes."""

import numpy as np
import pytest

from lamc.loops import zeros
from lamc.loops.tangents import EXACTLY, FEW_FREE, ROUNDS, Tangents

SIZE = FEW_FREE + 4


def forms_with_zero(count: int) -> tuple[Tangents, np.ndarray]:
    """Symmetric forms of which a point of the sphere is a common zero, by construction."""
    random = np.random.default_rng(1)
    zero = random.normal(size=SIZE)
    zero /= np.linalg.norm(zero)
    forms = random.normal(size=(count, SIZE, SIZE))
    forms = forms + forms.transpose(0, 2, 1)
    forms -= np.einsum("kab,a,b->k", forms, zero, zero)[:, None, None] * np.outer(zero, zero)
    forms /= np.linalg.norm(forms, axis=(1, 2))[:, None, None]
    return Tangents(np.eye(SIZE), forms), zero


def test_newton_ends_where_it_stands_still(monkeypatch: pytest.MonkeyPatch) -> None:
    local, zero = forms_with_zero(3 * SIZE)
    solve, rows = zeros._least_squares, []

    def counted(slopes: np.ndarray, values: np.ndarray, cutoff: float) -> np.ndarray:
        rows.append(len(values))
        return solve(slopes, values, cutoff)

    monkeypatch.setattr(zeros, "_least_squares", counted)
    near = zero + 1e-2 * np.random.default_rng(2).normal(size=(3, SIZE))
    found = zeros.arrivals(local, near, EXACTLY)
    # Some ten rounds: Newton's method doubles the digits in each, and the last one finds a step of round-off.
    assert len(rows) < ROUNDS // 4
    # The form of least slope at the zero takes some digits of round-off 1e-16.
    assert np.abs(found - zero).max() < 1e-12
    assert len(found) == len(near)
