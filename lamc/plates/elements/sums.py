"""Sums and products of staged matrices that are mostly zeros, with few operations.

In: scalars of a store. Out: scalars of the same store. Never: knows what they are about.
"""

from collections.abc import Iterable, Mapping, Sequence
from typing import TypeAlias

from lamc.symbolic.scalars import Scalar, Value

Sparse: TypeAlias = Sequence[Mapping[int, Scalar]]  # row by row: column → entry


def weighted_sum(terms: Iterable[tuple[Scalar, Scalar]]) -> Scalar:
    """Σ factor · value. Values with the same factor are added (or subtracted) first, and multiplied once.

    Besides being cheaper, this is what keeps rigid motions small: differences of displacements come first.
    """
    groups: dict[Scalar, Scalar] = {}
    inner: Scalar
    for factor, value in terms:
        magnitude: Scalar
        if isinstance(factor, Value):
            magnitude, sign = Value(factor.store, factor.index, 1), factor.sign
        elif factor == 0:
            continue
        else:
            magnitude, sign = (factor, 1) if factor > 0 else (-factor, -1)
        inner = groups.get(magnitude, 0)
        groups[magnitude] = inner + sign * value
    total: Scalar = 0
    for magnitude, inner in groups.items():
        total = total + magnitude * inner
    return total


def applied(weights: Sparse, values: Sequence[Scalar]) -> list[Scalar]:
    """weights · values."""
    return [weighted_sum((w, values[j]) for j, w in row.items()) for row in weights]


def applied_transposed(weights: Sparse, values: Sequence[Scalar], count: int) -> list[Scalar]:
    """weightsᵀ · values, `count` of them."""
    return [
        weighted_sum((row[j], values[m]) for m, row in enumerate(weights) if j in row) for j in range(count)
    ]


def congruence(matrix: Sequence[Sequence[Scalar]], weights: Sparse, count: int) -> list[list[Scalar]]:
    """weightsᵀ · matrix · weights for a symmetric matrix: all of it, (count, count), the lower triangle computed."""
    columns = [[row.get(j, 0) for row in weights] for j in range(count)]
    half = [
        [weighted_sum((c, row[m]) for m, c in enumerate(column)) for row in matrix] for column in columns
    ]  # half[j] = matrix · column j
    result: list[list[Scalar]] = [[0] * count for _ in range(count)]
    for i in range(count):
        for j in range(i + 1):
            result[i][j] = result[j][i] = weighted_sum((columns[i][m], v) for m, v in enumerate(half[j]))
    return result


def lower_triangle(matrix: Sequence[Sequence[Scalar]]) -> list[Scalar]:
    """By rows."""
    return [matrix[i][j] for i in range(len(matrix)) for j in range(i + 1)]
