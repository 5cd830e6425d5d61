"""Ways out of a singular position: the branches on which a mechanism can go on from where its closure loses rank.

In: a `LoopGeometry` and a closed position. Out: `Branch`es, by ratios of the joints' rates. Never: integrates.

Rates u hold the loops closed to first order where J u = 0. To second order there must be accelerations a with
J a + γ(u, u) = 0, where γ sums the Lie brackets of the joint screws: only those u of the null space are directions of
a motion for which γ has no part outside the range of J. That is a set of quadratic forms on the null space; its
solutions up to a factor are the branches. In two dimensions they are solved as binary quadratics, in more by Newton's
method on the sphere from many starts (Müller, "Local kinematic analysis of closed-loop linkages", 2018).
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from lamc.basics.readonly import ReadOnlyDict
from lamc.loops.closing import CLOSED, Mask, directions, settle
from lamc.loops.geometry import LoopGeometry
from lamc.mechanism.tree import WORLD
from lamc.records.mechanism import Array

SINGULAR = (
    1e-6  # relative to the largest singular value, as in the runtime: below it an equation is not taken
)
OUT = 1e-3  # rad, of the joint that turns most: how far a start is moved out of a singular position
SAME = 1e-6  # rates, of the largest: nearer than this two branches are one
STARTS = 24  # of Newton's method, for each dimension of the null space
ROUNDS = 40
FAMILIES = 8  # zeros that are no isolated ones which are looked at
WAY = 16  # steps from one of them to another, some 0.3 each
SOLVED = 1e-11  # of the forms, which are scaled to 1


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
    """

    basis: Array
    forms: Array

    def residual(self, rates: Array) -> float:
        """How far rates (n,) of the null space miss the second order, relative to their size."""
        x = self.basis.T @ rates
        square = float(x @ x)
        return float(np.abs(self.forms @ x @ x).max(initial=0.0)) / square if square else 0.0

    def nearest(self, rates: Array, held: Mask) -> Array | None:
        """A direction of motion near `rates` (n,) with the same rates where `held` (n,) bool; None if none is near."""
        x = self.basis.T @ rates
        size = float(np.linalg.norm(x))
        for _ in range(ROUNDS):
            slopes = np.concatenate([2.0 * self.forms @ x / size, self.basis[held]])
            missed = np.concatenate([self.forms @ x @ x / size, (self.basis @ x - rates)[held]])
            if np.abs(missed).max() <= SOLVED * size:
                return np.asarray(self.basis @ x)
            x = x - np.linalg.lstsq(slopes, missed, rcond=SAME)[0]
        return None


def rank_at(geometry: LoopGeometry, angles: Array) -> int:
    """Rank of the closure at a position, as the runtime judges it."""
    values, _ = directions(geometry, angles)
    return int((values > SINGULAR * values[0]).sum())


def tangents(geometry: LoopGeometry, angles: Array) -> Tangents:
    """The null space and its quadratic forms at a closed position `angles` (n,)."""
    jacobian = geometry.jacobian(angles)
    left, values, right = np.linalg.svd(jacobian, full_matrices=True)
    rank = int((values > SINGULAR * values[0]).sum())
    basis, outside = right[rank:].T, left[:, rank:]
    bilinear = np.einsum("kab,kr->rab", _brackets(geometry, angles, basis), outside)
    forms = 0.5 * (bilinear + bilinear.transpose(0, 2, 1))
    size = basis.shape[1]
    rows = forms.reshape(len(forms), size * size)
    _, strengths, independent = np.linalg.svd(rows, full_matrices=False)
    kept = strengths > SINGULAR * max(1.0, float(strengths.max(initial=0.0)))
    return Tangents(basis, independent[kept].reshape(-1, size, size))


def find_branches(geometry: LoopGeometry, angles: Array) -> tuple[Branch, ...]:
    """The branches at a singular closed position, in the order of their rates; each was followed for a step.

    Empty where the second order does not tell branches apart.
    """
    local = tangents(geometry, angles)
    if not len(local.forms):
        return ()
    solutions = _binary(local.forms) if local.basis.shape[1] == 2 else _spherical(local.forms, local.basis)
    found: list[Branch] = []
    names = [joint.name for joint in geometry.tree.mechanism.joints]
    for x, freedoms in solutions:
        rates = _normalised(local.basis @ x, [geometry.names.index(name) for name in names])
        if moved_out(geometry, angles, rates) is not None:
            by_name = dict(zip(geometry.names, rates.tolist(), strict=True))
            found.append(Branch(ReadOnlyDict({name: by_name[name] for name in names}), freedoms))
    return tuple(sorted(found, key=lambda b: (b.freedoms, [round(r, 7) for r in b.rates.values()])))


def moved_out(geometry: LoopGeometry, angles: Array, rates: Array) -> Array | None:
    """The closed position (n,) that is OUT from a singular one along a branch; None where none is near."""
    held = int(np.argmax(np.abs(rates)))
    guess = angles + OUT / abs(rates[held]) * rates
    place, error = settle(geometry, guess, np.arange(len(rates)) != held)
    # A branch bends by some radians per square radian: farther from the tangent is another one.
    near = np.abs(place - guess).max() < 50.0 * OUT**2
    return place if error <= CLOSED and near else None


def _brackets(geometry: LoopGeometry, angles: Array, basis: Array) -> Array:
    """(6 loops, d, d): the acceleration bias of each loop as a bilinear form of two rates of `basis` (n, d)."""
    screws = geometry.screws(geometry.poses(angles))
    size = basis.shape[1]
    twists = np.zeros((geometry.tree_count + 1, size, 6))  # of the bodies, the last for the world
    for index, link in enumerate(geometry.tree.links):
        inner = twists[link.parent] if link.parent != WORLD else 0.0
        twists[index] = inner + basis[index][:, None] * screws[index][None, :]
    carrier = twists[geometry.near]  # (n, d, 6), of the body that carries each joint
    turning = np.cross(carrier[:, :, :3], screws[:, None, :3])
    moving = np.cross(carrier[:, :, :3], screws[:, None, 3:]) + np.cross(
        carrier[:, :, 3:], screws[:, None, :3]
    )
    rates_of_screws = np.concatenate([turning, moving], axis=2)
    bias = np.einsum("cj,jas,jb->csab", geometry.signs, rates_of_screws, basis)
    return np.asarray(bias.reshape(6 * geometry.loops, size, size))


def _binary(forms: Array) -> list[tuple[Array, int]]:
    """Common zeros of forms in two unknowns, (2,) each: those of the first that are zeros of the others."""
    first = forms[0]
    a, b, c = first[0, 0], first[0, 1], first[1, 1]
    discriminant = b * b - a * c
    if discriminant < -SOLVED:
        return []
    root = float(np.sqrt(max(discriminant, 0.0)))
    half = -(b + root) if b >= 0 else root - b  # of the two sums the one without cancellation
    zeros = [np.array([half, a]), np.array([c, half])] if half != 0.0 else [np.array([1.0, 0.0])]
    unit = [zero / np.linalg.norm(zero) for zero in zeros if np.linalg.norm(zero) > 0.0]
    solutions = [zero for zero in unit if np.abs(forms @ zero @ zero).max() < SAME]
    return [(zero, 1) for zero in _distinct(solutions)]


def _spherical(forms: Array, preferred: Array) -> list[tuple[Array, int]]:
    """Common zeros of forms in more unknowns, (d,) each, with the dimension of the cone that each lies on; of zeros
    that are joined by zeros there is one, if possible near one of `preferred` (s, d)."""
    size = forms.shape[1]
    random = np.random.default_rng(20260103)
    starts = np.concatenate([preferred, random.normal(size=(STARTS * size, size))])
    solutions: list[tuple[Array, int]] = []
    families = 0
    for point in _distinct(list(_newton(forms, starts))):
        slopes = np.linalg.svd(2.0 * forms @ point, compute_uv=False)
        freedoms = size - int((slopes > 1e-4).sum())
        if freedoms > 1:
            families += 1
            joined = any(freedoms == known and _joined(forms, point, other) for other, known in solutions)
            if joined or families > FAMILIES:
                continue
        solutions.append((point, freedoms))
    return solutions


def _newton(forms: Array, points: Array, rounds: int = ROUNDS) -> Array:
    """The points (s, d) on the sphere that the starts lead to by Gauss-Newton, those that arrive."""
    points = points / np.linalg.norm(points, axis=1, keepdims=True)
    for _ in range(rounds):
        products = np.einsum("kab,sb->ska", forms, points)
        values = np.einsum("ska,sa->sk", products, points)
        slopes = 2.0 * (products - values[:, :, None] * points[:, None, :])  # along the sphere
        steps = np.einsum("sak,sk->sa", np.linalg.pinv(slopes, rcond=1e-6), values)
        points = points - steps
        points = points / np.linalg.norm(points, axis=1, keepdims=True)
    values = np.einsum("kab,sa,sb->sk", forms, points, points)
    return np.asarray(points[np.abs(values).max(axis=1) < SOLVED])


def _joined(forms: Array, start: Array, end: Array) -> bool:
    """Whether zeros lead from one zero to another, or to its opposite, on a short way."""
    for goal in (end, -end):
        point = start
        for _ in range(WAY):
            ahead = point + 0.3 * (goal - point) / max(0.3, float(np.linalg.norm(goal - point)))
            following = _newton(forms, ahead[None], 6)
            if not len(following) or np.linalg.norm(following[0] - point) > 0.6:
                break
            point = following[0]
            if np.linalg.norm(point - goal) < 1e-2:
                return True
    return False


def _distinct(points: list[Array]) -> list[Array]:
    """One of those that are equal up to sign."""
    kept: list[Array] = []
    for point in points:
        if all(min(np.abs(point - k).max(), np.abs(point + k).max()) > SAME for k in kept):
            kept.append(point)
    return kept


def _normalised(rates: Array, order: list[int]) -> Array:
    """Rates over the largest; of several of that size the first joint's is +1. Round-off becomes zero."""
    largest = float(np.abs(rates).max())
    lead = next(index for index in order if abs(rates[index]) > (1.0 - SAME) * largest)
    scaled = rates / (largest * np.sign(rates[lead]))
    return np.where(np.abs(scaled) < 1e-13, 0.0, scaled)
