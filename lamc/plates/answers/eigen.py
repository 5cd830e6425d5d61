"""Generalised eigenproblems of plates, by Lanczos on what a factorisation of the stiffness gives.

In: sparse symmetric matrices, rigid motions, and who factorises. Out: eigenvalues and vectors. Never: meshes, units.

    vibration  K φ = λ M φ, least λ:      x → P K⁻ M x, symmetric in the product of M
    stability  K φ = -μ G φ, μ next to 0: x → -K⁻¹ G x, symmetric in the product of K

Where K has rigid motions R, K⁻ holds as few unknowns as keep R from moving (which keeps K⁻ exact for loads in
equilibrium), and P = 1 - R Rᵀ M takes the motion of R out again: rigid motions are never computed, and soft modes keep
their digits, which a shift away from zero would cost. Source: B. N. Parlett, The Symmetric Eigenvalue Problem, 1998,
chapters 11 and 15; ARPACK's modes 2 and 3.
"""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any, TypeAlias

import numpy as np
import scipy.linalg
import scipy.sparse as sparse
from scipy.sparse.linalg import ArpackError, ArpackNoConvergence, LinearOperator, eigsh, splu

from lamc.basics.checks import Array
from lamc.basics.errors import SimulationError

Matrix: TypeAlias = Any  # scipy.sparse.csc_array
Solve: TypeAlias = Callable[[Array], Array]
Factor: TypeAlias = Callable[[Matrix], Solve]

# Up to here LAPACK takes no longer than the factorisation, and misses nothing.
DENSE = 150
_MASSLESS = 1e-12  # relative; a motion with less mass than this has none
_EXACT = 1e-11  # of the residual, relative; the values' own error is its square
_ROUGH, _FEW = 1e-3, 8  # of a look for values that were missed: residual, and vectors of the basis
_SAME = 1e-9  # relative; values nearer to each other than this are one
_SEED = 20_040_229  # any, but always the same
# Rounds of Lanczos in which buckling factors are found, where there are as many: some ten are usual.
_ROUNDS = 100
# Of the largest inverse factor of either sign: those that are less are round-off of the solutions, and none.
NEGLIGIBLE = 1e-6


def rigid_basis(motions: Array, mass: Matrix) -> tuple[Array, list[int]]:
    """Of the rigid motions (n, r) those with mass, orthonormal in M, (n, s), and which they are.

    By Gram and Schmidt, so that each is the motion of its place less a part of those before it.
    """
    heavy: list[Array] = []
    which: list[int] = []
    for k, motion in enumerate(motions.T):
        rest = motion / np.linalg.norm(motion)
        before = rest @ (mass @ rest)
        for _ in range(2):  # once more, for what round-off left of the first
            for other in heavy:
                rest = rest - other * (other @ (mass @ rest))
        own = rest @ (mass @ rest)
        if own > _MASSLESS * max(before, 0.0):
            heavy.append(rest / np.sqrt(own))
            which.append(k)
    return np.array(heavy).reshape(-1, len(motions)).T, which


def pinned(stiffness: Matrix, motions: Array) -> tuple[Matrix, Array]:
    """The stiffness with some unknowns held, one per rigid motion, and a vector that is 0 at these and 1 elsewhere.

    They are those that the motions move most and most differently: QR with column pivoting. The matrix keeps its size:
    an unknown that is held stands alone, with its own stiffness.
    """
    free = np.ones(len(motions))
    if motions.shape[1]:
        _, _, order = scipy.linalg.qr(motions.T, mode="economic", pivoting=True)
        free[order[: motions.shape[1]]] = 0.0
    kept = sparse.diags_array(free)
    alone = sparse.diags_array((1.0 - free) * stiffness.diagonal())
    return sparse.csc_array(kept @ stiffness @ kept + alone), free


def held_solve(stiffness: Matrix, motions: Array, factor: Factor) -> Solve:
    """Solves K x = b for b in equilibrium; of x, the unknowns that `pinned` holds are zero."""
    if not motions.shape[1]:
        return factor(stiffness)
    matrix, free = pinned(stiffness, motions)
    solve = factor(matrix)
    return lambda b: solve(free * b)


def vibration(
    stiffness: Matrix, mass: Matrix, motions: Array, count: int, factor: Factor
) -> tuple[Array, Array]:
    """The `count` least eigenvalues other than zero, ascending, and vectors (n, count), orthonormal in M.

    `motions` (n, r) spans the null space of K. Fewer come back where there are fewer modes with mass.
    """
    rigid, _ = rigid_basis(motions, mass)
    size = stiffness.shape[0]
    if size <= max(DENSE, 4 * (count + motions.shape[1])):
        return _dense(stiffness, mass, motions, rigid, count)
    solve = held_solve(stiffness, motions, factor)
    heavy = mass @ rigid

    def without_rigid(x: Array) -> Array:
        return np.asarray(x - rigid @ (heavy.T @ x))

    def inverse(b: Array) -> Array:
        return without_rigid(solve(b - heavy @ (rigid.T @ b)))

    values, vectors = _lanczos(stiffness, mass, inverse, count, _EXACT)
    return _with_missed(stiffness, mass, inverse, values, vectors)


def _lanczos(
    stiffness: Matrix, mass: Matrix, inverse: Solve, count: int, tolerance: float, basis: int | None = None
) -> tuple[Array, Array]:
    size = stiffness.shape[0]
    start = inverse(mass @ np.random.default_rng(_SEED).standard_normal(size))
    operator = LinearOperator((size, size), matvec=inverse, dtype=float)
    with _lanczos_errors("natural frequencies"):
        values, vectors = eigsh(
            stiffness, count, mass, sigma=0.0, OPinv=operator, v0=start, ncv=basis, tol=tolerance
        )
    order = np.argsort(values)
    return values[order], vectors[:, order]


@contextmanager
def _lanczos_errors(wanted: str) -> Iterator[None]:
    """What scipy raises as a SimulationError."""
    try:
        yield
    except (ArpackError, np.linalg.LinAlgError) as error:
        raise SimulationError(
            f"the {wanted} were not found: {error}; the stiffness may be too badly conditioned, so check units, cells "
            "and laminates, or ask for fewer"
        ) from error


def _with_missed(
    stiffness: Matrix, mass: Matrix, inverse: Solve, values: Array, vectors: Array
) -> tuple[Array, Array]:
    """Lanczos sees one vector of a repeated eigenvalue until round-off shows the others: look again beside those found.

    Ends when the least of what is left is not below the greatest of what was found.
    """
    count = len(values)
    for _ in range(count):
        heavy = mass @ vectors

        def beside(b: Array, heavy: Array = heavy, vectors: Array = vectors) -> Array:
            x = inverse(b - heavy @ (vectors.T @ b))
            return np.asarray(x - vectors @ (heavy.T @ x))

        # A value found roughly is never too small, so the first look may be a short one.
        value, vector = _lanczos(stiffness, mass, beside, 1, _ROUGH, _FEW)
        if value[0] >= values[-1] * (1.0 - _SAME):
            break
        value, vector = _lanczos(stiffness, mass, beside, 1, _EXACT)
        values, vectors = np.append(values, value), np.hstack([vectors, vector])
        order = np.argsort(values)[:count]
        values, vectors = values[order], vectors[:, order]
    return values, vectors


def _dense(stiffness: Matrix, mass: Matrix, motions: Array, rigid: Array, count: int) -> tuple[Array, Array]:
    """By LAPACK on M φ = (1/λ) K φ, which takes massless motions too, in what rigid motions leave."""
    K, M = stiffness.toarray(), mass.toarray()
    basis = scipy.linalg.null_space(motions.T) if motions.shape[1] else np.eye(len(K))
    heavy = M @ rigid
    # Elastic modes are a motion of `basis` and as much of the rigid motions as leaves nothing of these in M.
    basis = basis - rigid @ (heavy.T @ basis)
    with _lanczos_errors("natural frequencies"):
        inverses, vectors = scipy.linalg.eigh(basis.T @ M @ basis, basis.T @ K @ basis)
    keep = np.flatnonzero(inverses > _MASSLESS * max(inverses.max(initial=0.0), 0.0))[::-1][:count]
    return 1.0 / inverses[keep], basis @ (vectors[:, keep] / np.sqrt(inverses[keep]))


def stability(
    stiffness: Matrix, geometric: Matrix, count: int, factor: Factor, signs: Sequence[int] = (1, -1)
) -> dict[int, tuple[Array, Array]]:
    """By sign the `count` factors λ nearest to zero where K + λ G is singular, and vectors (n, count), φᵀKφ = 1.

    K is positive definite. Fewer come back where there are fewer, and none that is more than a million times the least
    of these signs: such factors cannot be told from round-off of the others.
    """
    size = stiffness.shape[0]
    with _lanczos_errors("buckling factors"):
        if size <= max(DENSE, 4 * count):
            inverses, vectors = scipy.linalg.eigh(-geometric.toarray(), stiffness.toarray())
            found = {sign: (sign * inverses, vectors) for sign in signs}
        else:
            found = _nearest(stiffness, geometric, count, factor, signs)
    largest = max((np.abs(inverses).max(initial=0.0) for inverses, _ in found.values()), default=0.0)
    chosen = {}
    for sign, (inverses, vectors) in found.items():
        order = np.argsort(-inverses)[:count]
        kept = order[inverses[order] > NEGLIGIBLE * largest]
        chosen[sign] = sign / inverses[kept], vectors[:, kept]
    return chosen


def _nearest(
    stiffness: Matrix, geometric: Matrix, count: int, factor: Factor, signs: Sequence[int]
) -> dict[int, tuple[Array, Array]]:
    """By sign the `count` greatest inverses of factors, in any order, and vectors, by Lanczos; where it does not settle
    they are counted first, and may be fewer."""
    size = stiffness.shape[0]
    solve = factor(stiffness)
    start = solve(np.random.default_rng(_SEED).standard_normal(size))
    operator = LinearOperator((size, size), matvec=solve, dtype=float)

    def inverses_of(
        sign: int, count: int, rounds: int | None = None, which: str = "LA"
    ) -> tuple[Array, Array]:
        return eigsh(  # type: ignore[no-any-return]
            -sign * geometric, count, stiffness, Minv=operator, which=which, v0=start, maxiter=rounds
        )

    found = {}
    for sign in signs:
        try:
            found[sign] = inverses_of(sign, count, _ROUNDS)
        except ArpackNoConvergence:
            largest = float(np.abs(inverses_of(sign, 1, which="LM")[0][0]))
            there = min(count, _pressed(stiffness, geometric, sign / (NEGLIGIBLE * largest)))
            found[sign] = inverses_of(sign, there) if there else (np.empty(0), np.empty((size, 0)))
    return found


def _pressed(stiffness: Matrix, geometric: Matrix, factor: float) -> int:
    """How many factors of that sign are less than `factor`: the negative pivots of K + λ G, by J. J. Sylvester's law of
    inertia, in one elimination without pivoting."""
    options = {"SymmetricMode": True}
    try:
        pivots = splu(
            sparse.csc_array(stiffness + factor * geometric),
            permc_spec="MMD_AT_PLUS_A",
            options=options,
            diag_pivot_thresh=0.0,
        ).U.diagonal()
    except RuntimeError:  # a pivot is nil, and nobody knows how many are negative
        return int(stiffness.shape[0])
    return int(np.count_nonzero(pivots < 0.0))
