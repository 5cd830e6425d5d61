"""Ways out of a singular position: the branches on which a mechanism can go on from where its closure loses rank.

In: a `LoopGeometry` and a closed position. Out: `Branch`es, by ratios of the joints' rates. Never: integrates.

Rates u hold the loops closed to first order where J u = 0. To second order there must be accelerations a with
J a + γ(u, u) = 0, where γ sums the Lie brackets of the joint screws: only those u of the null space are directions of
a motion for which γ has no part outside the range of J. That is a set of quadratic forms on the null space; its
solutions up to a factor are the branches. In two dimensions they are solved as binary quadratics, in more by Newton's
method on the sphere from many starts (Müller, "Local kinematic analysis of closed-loop linkages", 2018).
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from lamc.basics.readonly import ReadOnlyDict
from lamc.basics.threads import on_one_thread
from lamc.loops.closing import CLOSED, SMALL, SOLVE, Mask, settle
from lamc.loops.geometry import LoopGeometry
from lamc.loops.linear import EXACT
from lamc.loops.local_forms import LocalForms, local_forms
from lamc.loops.walks import walk
from lamc.records.mechanism import Array

Lead = Callable[[Array], Array]  # of closed angles (n,): rates (n,) that loads ask for
OUT = 1e-3  # rad, of the joint that turns most: how far a start is moved out of a singular position
BENDS = (
    50.0  # 1/rad: a branch bends by some radians per square radian; farther from the tangent is another one
)
STARTS = 24  # of Newton's method, for each dimension of the null space
ROUNDS = 40
BESIDE = 0.2  # of a zero's size, in each direction: slopes there are far above `Fit.family`
FAMILIES = 12  # zeros that are no isolated ones which are looked at
MOST = 32  # branches: a flat sheet of n lines has 2^n
WAY = 16  # steps from one of them to another, some 0.3 each
MOST_FREE = 80  # rates: of more, the second order takes minutes, and no branches are looked for
FEW_FREE, FEW_STARTS, FEW_BRANCHES = 16, 32, 8  # rates: of more, so many starts in all, and so many branches


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


@dataclass(frozen=True)
class Branch:
    """One way out of a singular position, and the opposite one.

    rates    joint name → rate relative to the largest, which is +1; in the order of the mechanism's joints
    freedoms 1 for a branch by itself; more for one of a family of as many freedoms, by an example
    """

    rates: Mapping[str, float]
    freedoms: int = 1

    def row(self, names: tuple[str, ...]) -> Array:
        """The rates as an array in the order of `names`."""
        return np.array([self.rates[name] for name in names])


@dataclass(frozen=True, eq=False)
class Tangents:
    """Directions of motion at a position, to second order.

    basis  (n, d): orthonormal, J basis = 0
    forms  (k, d, d): symmetric and independent; x is a direction of motion if x·forms·x = 0 for each
    local  forms by vertices in their place, of a flat sheet of many free rates
    is_unknown  there are forms, and too many to know
    """

    basis: Array
    forms: Array
    local: LocalForms | None = None
    is_unknown: bool = False

    @property
    def count(self) -> int:
        """How many forms there are; none of a regular position, or where there are too many to know."""
        return len(self.forms) if self.local is None else len(self.local.joints)

    def values(self, x: Array) -> Array:
        """The forms (count,) at a row (d,) of the null space."""
        return np.asarray(self.forms @ x @ x) if self.local is None else self.local.values(self.basis @ x)

    def slopes(self, x: Array) -> Array:
        """Their derivatives (count, d)."""
        if self.local is None:
            return np.asarray(2.0 * self.forms @ x)
        return np.asarray(self.local.slopes(self.basis @ x) @ self.basis)

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
    linear = geometry.linear(angles)
    basis = linear.free(fit.weak).T
    size = basis.shape[1]
    none = np.zeros((0, size, size))
    if size > FEW_FREE and fit is EXACTLY:
        local = local_forms(geometry, angles)
        if local is not None and len(local.joints) < size:
            return Tangents(basis, none, local)
        if local is not None and size > MOST_FREE:
            return Tangents(basis, none, is_unknown=True)
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
        _, strengths, found = np.linalg.svd(rows, full_matrices=False)
    else:
        from scipy.linalg import qr  # a quarter of a second, which reading a design does not need

        columns, triangle, _ = qr(rows.T, mode="economic", pivoting=True)
        strengths, found = np.abs(np.diag(triangle)), columns.T
    return np.asarray(found[strengths > least * max(1.0, float(strengths.max(initial=0.0)))])


def find_branches(
    geometry: LoopGeometry,
    angles: Array,
    fit: Fit = EXACTLY,
    local: Tangents | None = None,
    lead: Lead | None = None,
    rank: int | None = None,
) -> tuple[Branch, ...]:
    """The branches at a singular closed position, in the order of their rates; each was followed for a step.

    Empty where the second order does not tell branches apart. local: `tangents` there, if they are known. lead: of a
    flat sheet of many free rates, which go on in one family, the rates near which its example lies; None: any. rank: of
    the closure on that family; None: any.
    """
    local = local or tangents(geometry, angles, fit)
    if not local.count:
        return ()
    if local.local is not None:
        return _one_of_many(geometry, angles, local, lead, rank)
    two = local.basis.shape[1] == 2
    solutions = _binary(local.forms, fit) if two else _spherical(local.forms, local.basis, fit)
    found: list[Branch] = []
    for x, freedoms in solutions:
        rates = _normalised(local.basis @ x, geometry.order, fit.same)
        if _leads_out(geometry, angles, rates, fit):
            found.append(_branch(geometry, rates, freedoms))
    digits = 7 if fit is EXACTLY else 1  # numbered alike, whatever the rounding of the drawing
    return tuple(
        sorted(found, key=lambda b: (b.freedoms, [round(r, digits) + 0.0 for r in b.rates.values()]))
    )


def _one_of_many(
    geometry: LoopGeometry, angles: Array, tangents: Tangents, lead: Lead | None, rank: int | None
) -> tuple[Branch, ...]:
    """An example of the family on which a flat sheet of many free rates goes on."""
    local, basis = tangents.local, tangents.basis
    assert local is not None
    led = None if lead is None else lead(angles)
    for wanted in [*([] if led is None else [led]), *local.random]:
        rates = local.nearest(basis, wanted)
        if rates is None:
            continue
        freedoms = local.freedoms(basis, rates, EXACTLY.family)
        rates = _normalised(rates, geometry.order, EXACTLY.same)
        place = moved_out(geometry, angles, rates)
        # Sheets have families of lower rank beside, such as folds along straight lines all across.
        if place is not None and (rank is None or geometry.linear(place).rank() == rank):
            return (_branch(geometry, rates, freedoms),)
    return ()


def _branch(geometry: LoopGeometry, rates: Array, freedoms: int) -> Branch:
    names = [joint.name for joint in geometry.tree.mechanism.joints]
    by_name = dict(zip(geometry.names, rates.tolist(), strict=True))
    return Branch(ReadOnlyDict({name: by_name[name] for name in names}), freedoms)


def _leads_out(geometry: LoopGeometry, angles: Array, rates: Array, fit: Fit) -> bool:
    ways = (1.0,) if fit is EXACTLY else (1.0, -1.0)
    return any(moved_out(geometry, angles, way * rates, fit) is not None for way in ways)


def moved_out(geometry: LoopGeometry, angles: Array, rates: Array, fit: Fit = EXACTLY) -> Array | None:
    """The closed position (n,) that is OUT from a singular one along a branch, or farther where loops fit badly; None
    where none is near."""
    held = int(np.argmax(np.abs(rates)))
    guess = angles + OUT / abs(rates[held]) * rates
    # Nearly, fading equations are as weak as a misfit is: the place stays open by the second order.
    cutoff = SOLVE if fit is EXACTLY else OUT * fit.weak
    place, error = settle(geometry, guess, np.arange(len(rates)) != held, cutoff)
    near = np.abs(place - guess).max() < BENDS * OUT**2
    if error <= max(CLOSED, fit.zero * OUT**2 if fit is not EXACTLY else 0.0) and near:
        return place
    if fit is EXACTLY:
        return None
    places = walk(geometry, angles, rates, fit.weak, 1)  # farther out, where less is left of a misfit
    return places[0].angles if places else None


def _binary(forms: Array, fit: Fit) -> list[tuple[Array, int]]:
    """Common zeros of forms in two unknowns, (2,) each: those of the first that are zeros of the others."""
    first = forms[0]
    a, b, c = first[0, 0], first[0, 1], first[1, 1]
    discriminant = b * b - a * c
    if discriminant < -fit.zero:
        return []
    root = float(np.sqrt(max(discriminant, 0.0)))
    half = -(b + root) if b >= 0 else root - b  # of the two sums the one without cancellation
    zeros = [np.array([half, a]), np.array([c, half])] if half != 0.0 else [np.array([1.0, 0.0])]
    unit = [zero / np.linalg.norm(zero) for zero in zeros if np.linalg.norm(zero) > 0.0]
    solutions = [zero for zero in unit if np.abs(forms @ zero @ zero).max() < max(fit.zero, fit.same)]
    return [(zero, 1) for zero in _distinct(solutions, fit.same)]


def _spherical(forms: Array, preferred: Array, fit: Fit) -> list[tuple[Array, int]]:
    """Common zeros of forms in more unknowns, (d,) each, with the dimension of the cone that each lies on; of zeros
    that are joined by zeros there is one, if possible near one of `preferred` (s, d)."""
    size = forms.shape[1]
    random = np.random.default_rng(20260103)
    is_small = size <= FEW_FREE
    count, most = (STARTS * size, MOST) if is_small else (FEW_STARTS, FEW_BRANCHES)
    starts = np.concatenate([preferred[: count // 2], random.normal(size=(count, size))])
    solutions: list[tuple[Array, int]] = []
    families = 0
    for point in _distinct(list(_newton(forms, starts, fit)), fit.same):
        point, freedoms = _usual(forms, point, random, fit)
        if freedoms > 1:
            families += 1
            if families > FAMILIES:
                continue
            joined = any(
                freedoms == known and _joined(forms, point, other, fit) for other, known in solutions
            )
            if joined:
                continue
        solutions.append((point, freedoms))
        if len(solutions) == most:
            break
    return solutions


def _usual(forms: Array, point: Array, random: np.random.Generator, fit: Fit) -> tuple[Array, int]:
    """A zero, or one near it where it is a corner of its family: there slopes vanish that do not beside it. And the
    dimension of the cone that it lies on."""

    def freedoms(at: Array) -> int:
        slopes = np.linalg.svd(2.0 * forms @ at, compute_uv=False)
        return int(forms.shape[1] - (slopes > fit.family).sum())

    here = freedoms(point)
    if here > 1:
        beside = _newton(forms, point + BESIDE * random.normal(size=(1, len(point))), fit)
        if len(beside) and freedoms(beside[0]) < here:
            return beside[0], freedoms(beside[0])
    return point, here


def _newton(forms: Array, points: Array, fit: Fit, rounds: int = ROUNDS) -> Array:
    """The points (s, d) on the sphere that the starts lead to by Gauss-Newton, those that arrive."""
    points = points / np.linalg.norm(points, axis=1, keepdims=True)
    for _ in range(rounds):
        products = np.moveaxis(forms @ points.T, 2, 0)
        values = np.einsum("ska,sa->sk", products, points)
        slopes = 2.0 * (products - values[:, :, None] * points[:, None, :])  # along the sphere
        points = points - _least_squares(slopes, values, fit.same)
        points = points / np.linalg.norm(points, axis=1, keepdims=True)
    values = np.einsum("kab,sa,sb->sk", forms, points, points)
    return np.asarray(points[np.abs(values).max(axis=1, initial=0.0) < fit.zero])


def _least_squares(slopes: Array, values: Array, cutoff: float) -> Array:
    """The shortest steps x (s, d) with the least |slopes x - values|, (s, k, d) and (s, k); singular values below the
    cutoff, of the largest, are none. Where there are many rows, by their products: the next round mends the digits."""
    if slopes.shape[2] <= FEW_FREE:
        return np.asarray(np.einsum("sak,sk->sa", np.linalg.pinv(slopes, rcond=cutoff), values))
    across = np.swapaxes(slopes, 1, 2)
    squares = np.linalg.pinv(across @ slopes, rcond=cutoff**2, hermitian=True)
    return np.asarray((squares @ (across @ values[:, :, None]))[:, :, 0])


def _joined(forms: Array, start: Array, end: Array, fit: Fit) -> bool:
    """Whether zeros lead from one zero to another, or to its opposite, on a short way."""
    for goal in (end, -end):
        point = start
        for _ in range(WAY):
            ahead = point + 0.3 * (goal - point) / max(0.3, float(np.linalg.norm(goal - point)))
            following = _newton(forms, ahead[None], fit, 6)
            if not len(following) or np.linalg.norm(following[0] - point) > 0.6:
                break
            point = following[0]
            if np.linalg.norm(point - goal) < 1e-2:
                return True
    return False


def _distinct(points: list[Array], same: float) -> list[Array]:
    """One of those that are equal up to sign."""
    kept: list[Array] = []
    for point in points:
        if all(min(np.abs(point - k).max(), np.abs(point + k).max()) > same for k in kept):
            kept.append(point)
    return kept


def _normalised(rates: Array, order: list[int], same: float) -> Array:
    """Rates over the largest; of several of that size the first joint's is +1. Round-off becomes zero."""
    largest = float(np.abs(rates).max())
    lead = next(index for index in order if abs(rates[index]) > (1.0 - same) * largest)
    scaled = rates / (largest * np.sign(rates[lead]))
    return np.where(np.abs(scaled) < 1e-13, 0.0, scaled)
