"""The second order of closed loops at a position: which of the rates that hold them to first order go on.

In: a `LoopGeometry` and a closed position. Out: `Tangents`, the null space of the closure and its quadratic forms.
Never: follows a motion.

Rates u hold the loops closed to first order where J u = 0. To second order there must be accelerations a with
J a + γ(u, u) = 0, where γ sums the Lie brackets of the joint screws: only those u of the null space are directions of
a motion for which γ has no part outside the range of J. That is a set of quadratic forms on the null space (Müller,
"Local kinematic analysis of closed-loop linkages", 2018).
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from lamc.basics.threads import on_one_thread
from lamc.loops.closing import SMALL, Mask
from lamc.loops.decompositions import decomposed, singular_values
from lamc.loops.geometry import LoopGeometry
from lamc.loops.linear import EXACT
from lamc.loops.local_forms import LocalForms, local_forms
from lamc.records.mechanism import Array

ROUNDS = 40  # of Newton's method
MOST_FREE = 80  # rates: of more, forms that are not by vertices take minutes, and are not looked for
FEW_FREE = (
    16  # rates: of more, forms are taken by vertices where they can be, and not all branches are looked for
)


@dataclass(frozen=True)
class Fit:
    """How exactly a drawing is taken where branches part. All numbers are relative.

    weak     singular values below it are none
    forms    second-order forms weaker than this, of those of one, are none
    zero     of the forms, which are scaled to one: as small is zero
    same     rates, of the largest: nearer than this two branches are one
    family   slopes of the forms at a zero below it leave directions in which it goes on
    """

    weak: float
    forms: float
    zero: float
    same: float
    family: float


EXACTLY = Fit(EXACT, 1e-6, 1e-11, 1e-6, 1e-4)  # round-off, and its root where zeros are double
# Vertices off by a thousandth of the distance between them, and the root of that where zeros are double.
NEARLY = Fit(SMALL, 5e-3, 5e-3, 3e-2, 5e-2)


@dataclass(frozen=True, eq=False)
class Tangents:
    """Directions of motion at a position, to second order.

    basis  (n, d): orthonormal, J basis = 0
    forms  (k, d, d): symmetric and independent; x is a direction of motion if x·forms·x = 0 for each
    local  forms by vertices in their place, of a flat sheet of many free rates
    """

    basis: Array
    forms: Array
    local: LocalForms | None = None

    @property
    def count(self) -> int:
        """How many forms there are; none of a regular position, or where there are too many to know."""
        return len(self.forms) if self.local is None else self.local.forms

    @property
    def is_one_family(self) -> bool:
        """Whether so many fewer forms than free rates of a sheet leave no branch by itself."""
        return self.local is not None and self.count + 1 < self.basis.shape[1] - self.loose

    @cached_property
    def held(self) -> Array:
        """(d, c): orthonormal, rates in coordinates of the basis that some form holds; all others are free of each
        other, as those of flaps outside all loops. All are, where there are no forms."""
        size = self.basis.shape[1]
        if self.local is not None:
            flaps = self.basis[~self.local.held]
            return np.asarray(np.linalg.svd(flaps)[2][len(flaps) :].T) if len(flaps) else np.eye(size)
        if not len(self.forms):
            return np.eye(size)
        squares, axes = np.linalg.eigh(np.tensordot(self.forms, self.forms, axes=([0, 2], [0, 2])))
        some = squares > EXACTLY.forms**2 * squares[-1]
        return np.eye(len(axes)) if some.all() else np.asarray(axes[:, some])

    @property
    def loose(self) -> int:
        """How many rates no form holds."""
        if self.local is not None:
            return int(np.count_nonzero(~self.local.held))
        return int(self.basis.shape[1] - self.held.shape[1])

    @cached_property
    def inner(self) -> "Tangents":
        """The same of those rates alone that some form holds, by the columns of `held`."""
        if not self.loose:
            return self
        held = self.held
        return Tangents(self.basis @ held, held.T @ self.forms @ held, self.local)

    def values(self, x: Array) -> Array:
        """The forms (count,) at a row (d,) of the null space."""
        return np.asarray(self.forms @ x @ x) if self.local is None else self.local.values(self.basis @ x)

    def slopes(self, x: Array) -> Array:
        """Their derivatives (count, d)."""
        if self.local is None:
            return np.asarray(2.0 * self.forms @ x)
        return np.asarray(self.local.slopes(self.basis @ x) @ self.basis)

    def freedoms(self, x: Array, least: float) -> int:
        """The dimension of the cone of zeros around one: slopes of less than `least` hold nothing."""
        strengths = singular_values(self.slopes(x))
        return int(self.basis.shape[1] - (strengths > least).sum())

    def residual(self, rates: Array) -> float:
        """How far rates (n,) of the null space miss the second order, relative to their size."""
        x = self.basis.T @ rates
        square = float(x @ x)
        return float(np.abs(self.values(x)).max(initial=0.0)) / square if square else 0.0

    def nearest(self, rates: Array, held: Mask) -> Array | None:
        """A direction of motion near `rates` (n,) with the same rates where `held` (n,) bool; None if none is near."""
        x = self.basis.T @ rates
        size = float(np.linalg.norm(x))
        for _ in range(ROUNDS):
            slopes = np.concatenate([self.slopes(x) / size, self.basis[held]])
            missed = np.concatenate([self.values(x) / size, (self.basis @ x - rates)[held]])
            if np.abs(missed).max() <= EXACTLY.zero * size:
                return np.asarray(self.basis @ x)
            x = x - np.linalg.lstsq(slopes, missed, rcond=EXACTLY.same)[0]
        return None


def tangents(geometry: LoopGeometry, angles: Array, fit: Fit = EXACTLY) -> Tangents:
    """The null space and its quadratic forms at a closed position `angles` (n,)."""
    question = ("tangents", angles.tobytes(), fit)
    return geometry.lately(question, lambda: _tangents(geometry, angles, fit))


def _tangents(geometry: LoopGeometry, angles: Array, fit: Fit) -> Tangents:
    linear = geometry.linear(angles)
    basis = linear.free(fit.weak).T
    size = basis.shape[1]
    none = np.zeros((0, size, size))
    if size > FEW_FREE and fit is EXACTLY:
        local = local_forms(geometry, angles)
        if local is not None:
            return Tangents(basis, none, local)
    if not 0 < size <= MOST_FREE:
        return Tangents(basis, none)
    bias = geometry.rings.bias(angles, basis)
    upper = np.triu_indices(size)
    obstacles = linear.outside(bias[:, upper[0], upper[1]], fit.weak)
    weights = np.where(upper[0] == upper[1], 1.0, np.sqrt(2.0))  # entries off the diagonal count twice
    rows = _independent(obstacles * weights, fit.forms, exactly=size <= FEW_FREE) / weights
    forms = np.zeros((len(rows), size, size))
    forms[:, upper[0], upper[1]] = forms[:, upper[1], upper[0]] = rows
    return Tangents(basis, forms)


@on_one_thread
def _independent(rows: Array, least: float, *, exactly: bool) -> Array:
    """Orthonormal rows that span `rows` but for what is weaker than `least`, of one or of the largest. exactly: by
    singular values; else by pivots, which takes a thousand rows of 2000 in a second instead of minutes."""
    if exactly:
        _, strengths, found = decomposed(rows)
    else:
        from scipy.linalg import qr  # a quarter of a second, which reading a design does not need

        columns, triangle, _ = qr(rows.T, mode="economic", pivoting=True)
        strengths, found = np.abs(np.diag(triangle)), columns.T
    return np.asarray(found[strengths > least * max(1.0, float(strengths.max(initial=0.0)))])
