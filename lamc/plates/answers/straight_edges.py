"""What it changes that the edge of a reduced plate stays straight at its hinge: with and without, by its modes.

In: a reduced plate, the edge that is clamped to its frame, the stiffness of the hinge. Out: frequencies of the plate on
its hinge alone, as it is reduced and where its edge may bend. Never: other bodies.

On a soft hinge each piece of a wide edge turns by its own angle, and shapes that twist the plate turn both ends against
each other. A reduced plate turns by one angle. Frequencies are compared by the likeness of their shapes, as in
`shape_pairs.py`.
"""

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
import scipy.linalg
from scipy.optimize import linear_sum_assignment
from shapely.geometry.base import BaseGeometry

from lamc.basics.checks import Array
from lamc.plates.answers.eigen import Matrix
from lamc.plates.answers.modes import modes
from lamc.plates.answers.pencil import pencil
from lamc.plates.answers.reduction import Reduction, edge_axes, rigid_fields
from lamc.plates.supports import Hinged

_ALIKE = 0.5  # MAC below which two are not the same shape
_MORE = 4  # modes more than asked for of the plate whose edge may bend: some of them come earlier


@dataclass(frozen=True)
class StraightMode:
    """omega: rad/s, of the reduced plate on its hinge; free: of the one whose edge may bend, nan if none is like it."""

    omega: float
    free: float

    @property
    def excess(self) -> float:
        """By how much it is too high, relative; 0 where that is not known."""
        return self.omega / self.free - 1.0 if self.free > 0.0 else 0.0


@lru_cache(maxsize=64)
def straight_modes(reduction: Reduction, edge: BaseGeometry, stiffness: float) -> tuple[StraightMode, ...]:
    """Of the plate on its hinge alone, other hinges free, as many as the reduction has natural modes, the lowest: those
    above owe more to what was left out or stands for it; stiffness in N·m/rad. Remembered by reduction."""
    problem = reduction.problem
    whole = pencil(problem).mass(in_plane=False)
    middle, along = edge_axes(edge)
    across = np.array([-along[1], along[0]])
    fields = rigid_fields(problem)
    swing = fields[:, 1:] @ across - (across @ middle) * fields[:, 0]
    basis = np.column_stack([swing, reduction.vectors])
    k = scipy.linalg.block_diag([[stiffness]], reduction.stiffness)
    squares, inner = scipy.linalg.eigh(k, basis.T @ (whole @ basis))
    count = reduction.natural
    omega, shapes = np.sqrt(np.maximum(squares[:count], 0.0)), basis @ inner[:, :count]
    hinged = replace(problem, supports=[Hinged(edge, stiffness / edge.length)])
    free = modes(hinged, count + _MORE, in_plane_inertia=False)
    alike = _mac(shapes, free.vectors, whole)
    rows, columns = linear_sum_assignment(-alike)
    found = np.full(count, np.nan)
    close = alike[rows, columns] >= _ALIKE
    found[rows[close]] = free.omega[columns[close]]
    return tuple(StraightMode(float(a), float(b)) for a, b in zip(omega, found, strict=True))


def _mac(one: Array, other: Array, mass: Matrix) -> Array:
    """How alike each of `one` (N, k) is to each of `other` (N, l), 0 to 1, (k, l)."""
    weighted = mass @ other
    sizes = np.outer(np.einsum("nk,nk->k", one, mass @ one), np.einsum("nl,nl->l", other, weighted))
    return np.asarray(np.square(one.T @ weighted) / np.maximum(sizes, np.finfo(float).tiny))
