"""Common zeros of quadratic forms: directions in which a singular position can be left.

In: `Tangents`. Out: rows of its null space at which all forms vanish, one of each isolated zero and one of each family.
Never: follows a motion.

In two dimensions they are solved as binary quadratics, in more by Newton's method on the sphere from many starts.
"""

import numpy as np

from lamc.loops.tangents import FEW_FREE, ROUNDS, Fit, Tangents
from lamc.records.mechanism import Array

STARTS = 24  # of Newton's method, for each dimension of the null space
BESIDE = 0.2  # of a zero's size, in each direction: slopes there are far above `Fit.family`
FAMILIES = 12  # zeros that are no isolated ones which are looked at
MOST = 32  # branches: a flat sheet of n lines has 2^n
WAY = 16  # steps from one of them to another, some 0.3 each
STILL = 1e-14  # of a point of length one: a step of round-off
# Starts of forms by vertices that lead nowhere: after so many, there are degenerate zeros only, or none. Of a sheet
# with 156 free rates some three in a hundred arrive, and which of them, round-off decides.
# Of more than USUAL_FREE rates they are fewer, as a start costs their cube.
IN_VAIN, FEWEST_IN_VAIN, USUAL_FREE = 100, 8, 160
LONG = 60  # rounds of Newton's method from such starts
FEW_STARTS, FEW_BRANCHES = 32, 8  # of more than FEW_FREE rates: so many starts in all, and so many branches
# Joints: of more, so many starts and branches; what loads ask for comes besides.
MANY, FEWEST_STARTS, FEWEST_BRANCHES = 600, 8, 3


def binary(forms: Array, fit: Fit) -> list[tuple[Array, int]]:
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


def spherical(tangents: Tangents, preferred: Array, fit: Fit) -> list[tuple[Array, int]]:
    """Common zeros of quadratic forms in more unknowns, (d,) each, with the dimension of the cone that each lies on; of
    zeros that are joined by zeros there is one, if possible near one of `preferred` (s, d).

    Rates that no form holds, as those of a flap outside all loops, go with all zeros. They are no way of their own, and
    others are looked for without them: Newton's method would lead to them, as forms of next to nothing are nil."""
    if tangents.local is not None:
        within = tangents.basis[tangents.local.held]
        zeros = [(within.T @ (within @ x), freedoms) for x, freedoms in _of_all(tangents, preferred, fit)]
        return [(x / np.linalg.norm(x), freedoms) for x, freedoms in zeros]
    loose, held = tangents.loose, tangents.held
    if not loose:
        return _of_all(tangents, preferred, fit)
    near = preferred @ held
    near = near[np.linalg.norm(near, axis=1) > fit.same]
    zeros = [(held @ x, freedoms + loose) for x, freedoms in _of_all(tangents.inner, near, fit)]
    if zeros:
        return zeros
    free = np.linalg.svd(held.T)[2][held.shape[1] :] if held.shape[1] else np.eye(loose)
    return [(free[0], loose)]


def _of_all(tangents: Tangents, preferred: Array, fit: Fit) -> list[tuple[Array, int]]:
    """The same of forms that hold all rates."""
    size = tangents.basis.shape[1]
    random = np.random.default_rng(20260103)
    is_small = size <= FEW_FREE
    few = (FEW_STARTS, FEW_BRANCHES) if len(tangents.basis) <= MANY else (FEWEST_STARTS, FEWEST_BRANCHES)
    count, most = (STARTS * size, MOST) if is_small else few
    by_vertices = tangents.local is not None
    tried, rounds = (max(count, _in_vain(size)), LONG) if by_vertices else (count, ROUNDS)
    starts = np.concatenate([preferred[: count // 2], _drawn(tangents, random, tried)])
    solutions: list[tuple[Array, int]] = []
    families = 0
    for point in _distinct(list(arrivals(tangents, starts, fit, rounds, count)), fit.same):
        point, freedoms = usual(tangents, point, random, fit)
        if freedoms > 1:
            families += 1
            if families > FAMILIES:
                continue
            joined = any(
                freedoms == known and _joined(tangents, point, other, fit) for other, known in solutions
            )
            if joined:
                continue
        solutions.append((point, freedoms))
        if len(solutions) == most:
            break
    return solutions


def _drawn(tangents: Tangents, random: np.random.Generator, count: int) -> Array:
    """Random points (count, d): the same rates, whichever basis there is of them."""
    return np.asarray(random.normal(size=(count, len(tangents.basis))) @ tangents.basis)


def _in_vain(size: int) -> int:
    """Starts that lead nowhere, of so many free rates, before the search ends."""
    return max(FEWEST_IN_VAIN, int(IN_VAIN * min(1.0, (USUAL_FREE / size) ** 3)))


def usual(tangents: Tangents, point: Array, random: np.random.Generator, fit: Fit) -> tuple[Array, int]:
    """A zero, or one near it where it is a corner of its family: there slopes vanish that do not beside it. And the
    dimension of the cone that it lies on."""
    here = tangents.freedoms(point, fit.family)
    if here > 1:
        beside = arrivals(tangents, point + BESIDE * _drawn(tangents, random, 1), fit)
        if len(beside):
            there = tangents.freedoms(beside[0], fit.family)
            if there < here:
                return beside[0], there
    return point, here


def arrivals(
    tangents: Tangents, points: Array, fit: Fit, rounds: int = ROUNDS, enough: int | None = None
) -> Array:
    """The points (s, d) on the sphere that the starts lead to by Gauss-Newton, those that arrive. enough: of forms by
    vertices, so many starts if one of them does; None: all."""
    if tangents.local is not None:
        basis, local = tangents.basis, tangents.local
        found: list[Array] = []
        for number, point in enumerate(points):
            if number >= ((enough or len(points)) if found else _in_vain(basis.shape[1])):
                break
            rates = local.nearest(basis, basis @ point, rounds)
            if rates is not None:
                found.append(rates @ basis)
        return np.array(found).reshape(-1, basis.shape[1])
    forms = tangents.forms
    points = points / np.linalg.norm(points, axis=1, keepdims=True)
    settled = _of_many if points.shape[1] > FEW_FREE else _of_few
    points = settled(forms, points, fit.same, rounds)
    values = np.einsum("kab,sa,sb->sk", forms, points, points)
    return np.asarray(points[np.abs(values).max(axis=1, initial=0.0) < fit.zero])


def _of_few(forms: Array, points: Array, cutoff: float, rounds: int) -> Array:
    """All rounds; those that repeat themselves, bit for bit, are not computed."""
    passed, known = [points], {points.tobytes(): 0}
    for number in range(1, rounds + 1):
        points = _moved(points, _steps(forms, points, cutoff))
        before = known.setdefault(points.tobytes(), number)
        if before < number:
            return passed[before + (rounds - before) % (number - before)]
        passed.append(points)
    return points


def _of_many(forms: Array, points: Array, cutoff: float, rounds: int) -> Array:
    """Rounds until a point stands still: one costs milliseconds there, and seven are usual."""
    moving = np.ones(len(points), dtype=bool)
    for _ in range(rounds):
        at = points[moving]
        steps = _steps(forms, at, cutoff)
        points[moving] = _moved(at, steps)
        moving[moving] = np.abs(steps).max(axis=1) > STILL
        if not moving.any():
            break
    return points


def _steps(forms: Array, points: Array, cutoff: float) -> Array:
    products = np.moveaxis(forms @ points.T, 2, 0)
    values = np.einsum("ska,sa->sk", products, points)
    slopes = 2.0 * (products - values[:, :, None] * points[:, None, :])  # along the sphere
    return _least_squares(slopes, values, cutoff)


def _moved(points: Array, steps: Array) -> Array:
    moved = points - steps
    return np.asarray(moved / np.linalg.norm(moved, axis=1, keepdims=True))


def _least_squares(slopes: Array, values: Array, cutoff: float) -> Array:
    """The shortest steps x (s, d) with the least |slopes x - values|, (s, k, d) and (s, k); singular values below the
    cutoff, of the largest, are none. Where there are many rows, by their products: the next round mends the digits."""
    if slopes.shape[2] <= FEW_FREE:
        return np.asarray(np.einsum("sak,sk->sa", _inverses(slopes, cutoff), values))
    across = np.swapaxes(slopes, 1, 2)
    squares = np.linalg.pinv(across @ slopes, rcond=cutoff**2, hermitian=True)
    return np.asarray((squares @ (across @ values[:, :, None]))[:, :, 0])


def _inverses(matrices: Array, cutoff: float) -> Array:
    """As `numpy.linalg.pinv`, which looks at what it is given for half of the time that matrices so small take."""
    if not matrices.size:
        return np.swapaxes(matrices, 1, 2)
    left, sizes, right = np.linalg.svd(matrices, full_matrices=False)
    kept = sizes > cutoff * sizes[:, :1]
    inverse = np.divide(1.0, sizes, where=kept, out=np.zeros_like(sizes))
    return np.asarray(np.matmul(np.swapaxes(right, 1, 2), inverse[:, :, None] * np.swapaxes(left, 1, 2)))


def _joined(tangents: Tangents, start: Array, end: Array, fit: Fit) -> bool:
    """Whether zeros lead from one zero to another, or to its opposite, on a short way."""
    for goal in (end, -end):
        point = start
        for _ in range(WAY):
            ahead = point + 0.3 * (goal - point) / max(0.3, float(np.linalg.norm(goal - point)))
            following = arrivals(tangents, ahead[None], fit, 6)
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
