"""Singular values of one matrix, also where LAPACK's quick way to them does not converge.

In: a matrix. Out: its decomposition. Never: gives up on finite numbers.

Divide and conquer (gesdd, which numpy takes) fails now and then on matrices of hundreds of columns with many values of
round-off, by the number of threads and the last digit. The QR iteration (gesvd) takes some times as long, and does not.
"""

import numpy as np

from lamc.records.mechanism import Array


def decomposed(matrix: Array, *, full: bool = False) -> tuple[Array, Array, Array]:
    """U (m, r), singular values (min(m, n),), descending, and V by rows (r, n) of a matrix (m, n); full: all m columns
    of U and n rows of V."""
    try:
        left, values, right = np.linalg.svd(matrix, full_matrices=full)
    except np.linalg.LinAlgError:
        from scipy.linalg import svd  # a quarter of a second, and rarely needed

        left, values, right = svd(matrix, full_matrices=full, lapack_driver="gesvd")
    return left, values, right


def singular_values(matrix: Array) -> Array:
    """(min(m, n),), descending."""
    try:
        return np.asarray(np.linalg.svd(matrix, compute_uv=False))
    except np.linalg.LinAlgError:
        return decomposed(matrix)[1]
