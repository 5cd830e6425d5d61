"""A closure matrix taken apart: which rates it leaves free, and the least change that it asks for.

In: a sparse matrix. Out: small singular values with their vectors, null space, least-squares steps. Never: knows what
the matrix is of.

Small matrices are decomposed as they are. Large ones have a dozen entries in a row, and their elimination in an order
of little fill costs what the elimination of a plane graph costs. Of

    [ e I   J^T ] [x]   [a]
    [ J    -e I ] [y] = [b]

a = 0 gives the least change x = (J^T J + e^2)^-1 J^T b, and b = 0 is a step of inverse iteration towards the null space
of J. No singular value is squared: those below e are told apart by what J does to the vectors that come out.
"""

from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from lamc.basics.threads import hold_scipy_too
from lamc.loops.decompositions import decomposed
from lamc.records.mechanism import Array

if TYPE_CHECKING:
    from scipy import sparse

DENSE = 60  # columns: up to here a decomposition takes a few milliseconds, as sparse elimination does
DAMPING = 1e-5  # e, of the largest singular value: what is smaller is damped, and comes with the next steps
SEED = 20260105  # of the vectors that inverse iteration begins from
BLOCK = 8  # vectors of inverse iteration more than values are counted
ROUNDS = 3  # of it: a null vector gains (e / sigma)^2 on others in each
# Of rounds from the vectors of a matrix nearby, and where no value is near the largest that is looked for, as it is not
# if it is so many times smaller: beside such values, what is beyond fades to a thousandth by a round.
FEW_ROUNDS, FAR_BELOW = 2, 16.0
BEYOND = 2.0  # times the largest that is looked for: blocks reach so far; a round leaves a quarter of what is beyond
CLOSE = 3.0  # times its neighbour: beyond what is looked for, such a value is not known well enough to be told from it
WEAK = 2e-2  # of the largest singular value: in large matrices, smaller ones are looked for; no misfit's are larger
EXACT = 1e-11  # likewise: below it a closure matrix has round-off only
FARTHER = 10.0  # times as large are values that are looked for next
# Rows that hold something: of more, to tell hundreds of weak directions near flat takes half a second.
FEW_ROWS = 700
NOTHING = (
    1e-12  # entries that are round-off of zero, beside those of one, on a sheet of hundreds of facets across
)


def least_changes(matrices: Array, goals: Array, cutoff: float) -> Array:
    """As `Linear.least_change`, of small matrices (s, m, n) and goals (s, m) at once: (s, n)."""
    left, values, right = np.linalg.svd(matrices, full_matrices=False)
    kept = values > cutoff * values[:, :1]
    parts = (goals[:, None] @ left)[:, 0] * kept / np.where(kept, values, 1.0)
    return np.asarray((parts[:, None] @ right)[:, 0])


def _tells(values: Array, nullity: int, most: float) -> bool:
    """Whether what is known of singular values (k,), exactly up to `most`, tells the first `nullity` from the next."""
    if len(values) <= nullity:
        return False
    return bool(values[nullity] <= most or nullity == 0 or values[nullity] > CLOSE * values[nullity - 1])


def _eliminated(system: Any) -> Any:
    """L and U of a symmetric sparse matrix, without pivoting. Raises RuntimeError where it is singular."""
    from scipy.sparse.linalg import splu

    hold_scipy_too()
    options = {"SymmetricMode": True}
    return splu(system, permc_spec="MMD_AT_PLUS_A", options=options, diag_pivot_thresh=0.0)


class Linear:
    """A matrix J (m, n)."""

    def __init__(self, matrix: "Array | sparse.csr_array") -> None:
        self.count = int(matrix.shape[1])
        self.is_small = self.count <= DENSE
        self.matrix = matrix if isinstance(matrix, np.ndarray) or not self.is_small else matrix.toarray()
        # Weak directions, by the value up to which they were looked for: of this matrix, and of one nearby
        self._found: dict[float, tuple[Array, Array]] = {}
        self._begun: dict[float, tuple[Array, Array]] = {}
        self._alone: dict[float, tuple[Array, Array]] = {}  # what `_left_alone` gave, by cutoff

    def columns(self, taken: npt.NDArray[np.bool_]) -> "Linear":
        """Those of a mask (n,)."""
        return self if taken.all() else self.part(np.flatnonzero(taken))

    def part(self, taken: npt.NDArray[np.int64]) -> "Linear":
        """Columns of some indices (k,), ascending."""
        if len(taken) == self.count:
            return self
        return Linear(self.matrix.take(taken, axis=1) if self.is_small else self.matrix[:, taken])

    @cached_property
    def dense(self) -> tuple[Array, Array, Array]:
        """U (m, r), singular values (min(m, n),), descending, V (n, n) by rows in their order."""
        return decomposed(self.matrix, full=self.matrix.shape[0] < self.count)

    @cached_property
    def scale(self) -> float:
        """The largest singular value, to some hundredths; 1 where there is nothing."""
        if self.is_small:
            values = self.dense[1]
            return (float(values[0]) if len(values) else 0.0) or 1.0
        if not len(self.used):
            return 1.0
        vector, turned = np.random.default_rng(20260104).normal(size=self.count), self.matrix.T
        for _ in range(20):
            vector = turned @ (self.matrix @ (vector / np.linalg.norm(vector)))
        return float(np.sqrt(np.linalg.norm(vector))) or 1.0

    @property
    def weak(self) -> tuple[Array, Array]:
        """The smallest singular values (k,), relative to the largest, ascending, and their vectors (k, n) by rows: all
        of a small matrix; of a large one those below WEAK, and some more, less exactly."""
        return self._weak_to(WEAK)

    def _weak_to(self, cutoff: float) -> tuple[Array, Array]:
        """As `weak`, all up to `cutoff` at least; the same for all of a decade, whichever is asked for first."""
        if self.is_small:
            return self._all_by_weakness
        most = WEAK
        while most < cutoff:
            most *= FARTHER
        return self._weakest(most)

    @cached_property
    def _all_by_weakness(self) -> tuple[Array, Array]:
        _, known, right = self.dense
        values = np.zeros(self.count)
        values[self.count - len(known) :] = known[::-1] / self.scale
        return values, right[::-1]

    def after(self, nearby: "Linear | None") -> "Linear":
        """This, whose weak directions are looked for from those that were found of a matrix nearby."""
        if nearby is not None and nearby.count == self.count:
            self._begun = nearby._found or nearby._begun
        return self

    def _weakest(self, most: float) -> tuple[Array, Array]:
        """As `weak` of a large matrix, those up to `most`, and some more."""
        known = self._found.get(most)
        if known is None:
            known = self._found[most] = self._iterated(most)
        return known

    def _iterated(self, most: float) -> tuple[Array, Array]:
        """By inverse iteration of a block that reaches beyond `most`."""
        block, random = np.zeros((self.count, 0)), np.random.default_rng(SEED)
        within = self.about(BEYOND * most)
        size, rounds = BLOCK + within, ROUNDS
        if most in self._begun:
            near, vectors = self._begun[most]
            block, rounds = vectors[: 1 + int(np.count_nonzero(near <= BEYOND * most))].T, FEW_ROUNDS
            size = max(size, block.shape[1] + BLOCK)  # and some that hold what has become weak since
        elif self.about(most / FAR_BELOW) in (within, self.about(most)):
            rounds = FEW_ROUNDS
        while True:
            size = min(size, self.count)
            block = np.hstack([block, random.normal(size=(self.count, size - block.shape[1]))])
            for left in range(rounds, 0, -1):
                block = np.linalg.qr(self._pushed(block, exact=left == 1))[0]
            # Of the same singular values as what the block gives, and no higher than wide
            triangle = np.asarray(np.linalg.qr(self._held @ block, mode="r"))
            _, found, mixed = decomposed(triangle, full=triangle.shape[0] < size)
            values = np.concatenate([np.zeros(size - len(found)), found[::-1] / self.scale])
            block = block @ mixed[::-1].T
            if values[-1] > BEYOND * most or size == self.count:
                return values, block.T
            size, rounds = 2 * size, ROUNDS

    def about(self, most: float) -> int:
        """How many singular values are at most `most` times the largest, by J. J. Sylvester's law of inertia: of

            [ s I   J^T ]
            [ J     s I ]

        as many pivots are positive as there are rows and singular values below s. It takes one elimination, without
        pivoting, by which signs may be wrong: it decides on the size of a block, which grows if it was too small, and
        on two rounds or three."""
        shift = most * self.scale
        try:
            pivots = _eliminated(self._bordered(shift, shift)).U.diagonal()
        except RuntimeError:  # a pivot is nil
            return 0
        return max(0, int(np.count_nonzero(pivots > 0.0)) - len(self.used))

    def _pushed(self, block: Array, *, exact: bool) -> Array:
        """A step of inverse iteration. Elimination without pivoting leaves 1e-10 of strong directions in weak ones;
        exact: not so, by once more what is left of the equations."""
        given = np.zeros((self.count + len(self.used), block.shape[1]), order="F")  # as SuperLU takes it
        given[: self.count] = block
        system, factors = self._system, self._factors
        found: Array = factors.solve(given)
        if exact:
            found = found + factors.solve(given - system @ found)
        return found[: self.count]

    @cached_property
    def used(self) -> Any:
        """The rows that hold something."""
        largest = abs(self.matrix).max(axis=1)
        largest = largest.toarray() if hasattr(largest, "toarray") else largest
        return np.flatnonzero(np.asarray(largest).ravel() > NOTHING)

    @cached_property
    def _held(self) -> Any:
        """The rows that hold something."""
        return self.matrix[self.used].tocsr()

    @cached_property
    def _rows(self) -> Any:
        """The same without round-off, which eliminations would take for entries."""
        rows = self._held.copy()
        rows.data[np.abs(rows.data) < NOTHING] = 0.0
        rows.eliminate_zeros()
        return rows

    @cached_property
    def _factors(self) -> Any:
        return self._factored(DAMPING)

    @cached_property
    def _system(self) -> Any:
        return self._damped_system(DAMPING)

    def _damped_system(self, damping: float) -> Any:
        e = damping * self.scale
        return self._bordered(e, -e)

    def _bordered(self, left: float, right: float) -> Any:
        """[[left I, J^T], [J, right I]] of the rows that hold something."""
        from scipy import sparse

        rows, eye = self._rows, sparse.eye_array
        return sparse.block_array(
            [[left * eye(self.count), rows.T], [rows, right * eye(len(self.used))]], format="csc"
        )

    def _factored(self, damping: float) -> Any:
        # It is quasi-definite: any order of elimination does, without pivoting (R. Vanderbei, 1995).
        return _eliminated(self._system if damping == DAMPING else self._damped_system(damping))

    def nullity(self, cutoff: float = EXACT) -> int:
        """How many singular values are at most `cutoff` times the largest."""
        return int(np.count_nonzero(self._weak_to(cutoff)[0] <= cutoff))

    def rank(self, cutoff: float = EXACT) -> int:
        """How many are larger."""
        return int(self.count - self.nullity(cutoff))

    def amid(self, nullity: int) -> float:
        """A cutoff between the first `nullity` singular values and the next: their geometric mean."""
        most, values = WEAK, self.weak[0]
        while len(values) < self.count and nullity < self.count and not _tells(values, nullity, most):
            most *= FARTHER
            values = self._weakest(most)[0]
        values = np.concatenate([[EXACT], np.maximum(values, EXACT), [1.0]])
        return float(np.sqrt(values[nullity] * values[nullity + 1])) if nullity < len(values) - 1 else 1.0

    def free(self, cutoff: float = EXACT) -> Array:
        """(d, n): rates that the matrix leaves free, orthonormal rows."""
        return self._weak_to(cutoff)[1][: self.nullity(cutoff)]

    def outside(self, goals: Array, cutoff: float = EXACT) -> Array:
        """The parts of `goals` (m, k) that no x gives.

        Of a large matrix whose rows are independent but for those that hold nothing, such as a flat sheet's, these."""
        if self.is_small:
            inside = self.dense[0][:, : self.rank(cutoff)]
            return np.asarray(goals - inside @ (inside.T @ goals))
        if len(self.used) == self.rank(cutoff):
            left = goals.copy()
            left[self.used] = 0.0
            return np.asarray(left[np.abs(left).max(axis=1) > 0.0])
        return np.column_stack([g - self.matrix @ self.least_change(g, cutoff) for g in goals.T])

    def least_change(self, goal: Array, cutoff: float) -> Array:
        """The smallest x (n,) for which J x is nearest to `goal` (m,), singular values below `cutoff` times the largest
        counted as zero."""
        if self.is_small:
            left, values, right = self.dense
            kept = np.count_nonzero(values > cutoff * self.scale)
            return np.asarray((goal @ left[:, :kept] / values[:kept]) @ right[:kept])
        if cutoff <= DAMPING:
            return self._damped_twice(goal)
        weak, held = self._left_alone(cutoff)
        # What weak directions hold goes first: divided by next to nothing, it would cost all others their digits.
        found = self._damped_twice(goal - held @ (held.T @ goal))
        return np.asarray(found - weak.T @ (weak @ found))

    def _left_alone(self, cutoff: float) -> tuple[Array, Array]:
        """Weak directions (k, n) by rows, and what they hold (m, l), orthonormal columns."""
        known = self._alone.get(cutoff)
        if known is None:
            values, vectors = self._weak_to(cutoff)
            weak = vectors[: int(np.count_nonzero(values <= cutoff))]
            held = np.linalg.qr(self.matrix @ weak[values[: len(weak)] > EXACT].T)[0]
            known = self._alone[cutoff] = weak, held
        return known

    def _damped_twice(self, goal: Array) -> Array:
        """The least change but for parts (e / sigma)^4 of it."""
        found = self._damped(goal, self._factors)
        return found + self._damped(goal - self.matrix @ found, self._factors)

    @cached_property
    def is_very_large(self) -> bool:
        """Whether to tell which directions are weak may take a second."""
        return not self.is_small and min(len(self.used), self.count) > FEW_ROWS

    def damped_change(self, goal: Array, cutoff: float) -> Array:
        """Some of `least_change`: (J^T J + e^2)^-1 J^T goal with e = cutoff times the largest singular value, most of
        it along strong directions and little along weak ones."""
        return self._damped(goal, self._factored(cutoff))

    def _damped(self, goal: Array, factors: Any) -> Array:
        known = np.concatenate([np.zeros(self.count), goal[self.used]])
        return np.asarray(factors.solve(known)[: self.count])
