"""Singular values where LAPACK's quick way to them fails."""

from typing import Any, NoReturn

import numpy as np
import pytest

from lamc.loops.decompositions import decomposed, singular_values


@pytest.mark.parametrize("shape", [(9, 5), (5, 9)])
@pytest.mark.parametrize("full", [False, True])
def test_what_does_not_converge_is_decomposed_another_way(
    shape: tuple[int, int], full: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A waterbomb sheet of 8 x 8 ended in "SVD did not converge", by the number of threads."""
    matrix = np.random.default_rng(4).normal(size=shape)
    usual = np.linalg.svd(matrix, full_matrices=full)

    def fails(*_: Any, **__: Any) -> NoReturn:
        raise np.linalg.LinAlgError("SVD did not converge")

    monkeypatch.setattr(np.linalg, "svd", fails)
    left, values, right = decomposed(matrix, full=full)
    assert values == pytest.approx(usual[1], rel=1e-13)
    assert singular_values(matrix) == pytest.approx(usual[1], rel=1e-13)
    assert (left.shape, right.shape) == (usual[0].shape, usual[2].shape)
    count = len(values)
    assert (left[:, :count] * values) @ right[:count] == pytest.approx(matrix, abs=1e-13)
    assert right @ right.T == pytest.approx(np.eye(len(right)), abs=1e-13)


def test_numbers_that_are_none_are_refused() -> None:
    with pytest.raises((ValueError, np.linalg.LinAlgError)):
        decomposed(np.array([[np.nan, 1.0], [0.0, 1.0]]))
