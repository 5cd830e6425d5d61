"""Nonlinear least squares within bounds, of problems whose every evaluation is a run.

In: a problem, a start, bounds. Out: a `Found`. Steps are those of Gauss and Newton in a region of trust (Moré 1978,
"The Levenberg-Marquardt algorithm", section 3), whose size counts each number by its own size; what would leave its
bounds stays at them for the step. Residuals (N,) and Jacobian (N, p) come in as a `Local`, p numbers and a triangle, so
that the algebra of a step takes no time beside a run. It ends by what the next step promises: no run is made to see
that nothing is left to gain.
"""

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from lamc.run.request import Array

_FIRST = 1.0  # of the numbers' sizes: as far as a run is nearly linear in logarithms of its numbers
_BLOCK = 4096  # numbers: LAPACK factors so few on one processor, and waking others takes longer than the work
_DOUBLED, _QUARTERED = 0.75, 0.25  # of what a step promised: the region of trust grows, and shrinks
_GOOD = 1e-4  # of what a step promised: it is taken
_HITS = 0.9  # of the region's size: a step that ends at its edge
_EDGE = 0.01  # of the region's size, to which a step at its edge is found
_NEWTON = 30  # steps to that edge; usually three


@dataclass(frozen=True, eq=False)
class Local:
    """A problem near a point: cost + rates' s + |triangle s|²/2 by a step s. cost: half the sum of squares, or of the
    loss; triangle (p, p), R of the Jacobian's QR; target (p,), Q'r. Infinite cost: nothing there."""

    cost: float
    triangle: Array
    target: Array

    def gain(self, step: Array) -> float:
        """By how much a step (p,) lowers the cost, if the problem were linear."""
        moved = self.triangle @ step
        return -float(moved @ self.target + 0.5 * moved @ moved)


class Problem(Protocol):
    """What is made least."""

    @property
    def known_to(self) -> float:
        """Errors of Jacobians, of the largest: directions felt less than that are not gone along."""

    @property
    def at_once(self) -> bool:
        """Whether a Jacobian takes little beside the cost alone."""

    def cost(self, x: Array) -> float:
        """Infinite where there is none."""

    def local(self, x: Array) -> Local:
        """Near x."""


@dataclass(frozen=True, eq=False)
class Found:
    """x: (p,), the best that was looked at; ahead: (p,), where the linear problem there has its least, as far as it is
    trusted; steps: that were tried."""

    x: Array
    ahead: Array
    local: Local
    converged: bool
    steps: int


@dataclass(frozen=True, eq=False)
class Box:
    """low, high: bounds (p,). sizes: (p,), changes that count as one."""

    low: Array
    high: Array
    sizes: Array


def minimise(problem: Problem, begin: Array, box: Box, gain: float, change: float, most: int) -> Found:
    """From a start (p,) within the box.

    gain    of the cost: where the linear problem promises no more, it ends
    change  of the sizes: likewise for all numbers
    most    steps
    """
    x, here = begin, problem.local(begin)
    radius = _FIRST
    for steps in range(most + 1):
        if not np.isfinite(here.cost):
            return Found(x, x, here, False, steps)
        whole = _step(here, x, box, np.inf, problem.known_to)
        if (
            abs(here.gain(whole)) <= gain * here.cost
            or np.max(np.abs(whole / box.sizes), initial=0.0) <= change
        ):
            return Found(x, x + _step(here, x, box, radius, problem.known_to), here, True, steps)
        while True:
            step = _step(here, x, box, radius, problem.known_to)
            length, promised = float(np.linalg.norm(step / box.sizes)), here.gain(step)
            if length <= change:
                return Found(x, x, here, True, steps)
            there = problem.local(x + step) if problem.at_once else None
            cost = problem.cost(x + step) if there is None else there.cost
            share = (here.cost - cost) / promised if promised > 0.0 else -np.inf
            if share < _QUARTERED:
                radius = 0.25 * min(length, radius)
            elif share > _DOUBLED and length > _HITS * radius:
                radius *= 2.0
            if share > _GOOD:
                break
            steps += 1
            if steps > most:
                return Found(x, x, here, False, steps)
        x = x + step
        here = problem.local(x) if there is None else there
    return Found(x, x, here, False, most)


def _step(here: Local, x: Array, box: Box, radius: float, known_to: float) -> Array:
    """The step (p,) that lowers the linear problem most within the region and, nearly, the bounds."""
    step = np.zeros(len(x))
    slope = here.triangle.T @ here.target
    free = ~(((x <= box.low) & (slope > 0.0)) | ((x >= box.high) & (slope < 0.0)))
    while free.any():
        target = here.target + here.triangle[:, ~free] @ step[~free]
        spent = float(np.sum((step[~free] / box.sizes[~free]) ** 2))
        left = np.sqrt(max(radius**2 - spent, (_EDGE * radius) ** 2)) if np.isfinite(radius) else np.inf
        sizes = box.sizes[free]
        step[free] = _shortest(here.triangle[:, free] * sizes, target, left, known_to) * sizes
        kept = np.clip(x + step, box.low, box.high) - x
        out = free & (kept != step)
        step = np.where(out, kept, step)
        if not out.any():
            break
        free &= ~out
    return step


def _shortest(matrix: Array, target: Array, radius: float, known_to: float) -> Array:
    """s (p,) with least |matrix s + target| among |s| ≤ radius; of several the shortest."""
    felt = np.linalg.norm(matrix, axis=0)
    felt[felt == 0.0] = 1.0
    u, values, v = np.linalg.svd(matrix / felt, full_matrices=False)
    kept = values > known_to * values[0]
    whole = -(v[kept].T @ (u[:, kept].T @ target / values[kept])) / felt
    if np.linalg.norm(whole) <= radius:
        return np.asarray(whole)
    u, values, v = np.linalg.svd(matrix, full_matrices=False)
    parts = u.T @ target
    damping = 0.0
    for _ in range(_NEWTON):
        below = values**2 + damping
        some = np.divide(values * parts, below, out=np.zeros_like(parts), where=below > 0.0)
        length = float(np.linalg.norm(some))
        if abs(length - radius) <= _EDGE * radius:
            break
        falls = float(np.sum(np.divide(some**2, below, out=np.zeros_like(parts), where=below > 0.0)))
        damping = max(damping + length**2 / falls * (length - radius) / radius, 0.0)
    return np.asarray(-v.T @ some)


def local_of(cost: float, residual: Array, jacobian: Array) -> Local:
    """The problem of residuals (N,) with a Jacobian (N, p)."""
    p = jacobian.shape[1]
    whole = triangle_of(np.column_stack([jacobian, residual]))
    return Local(cost, whole[:p, :p], whole[:p, p])


def triangle_of(rows: Array) -> Array:
    """R (p, p) of the QR of rows (N, p): R'R = rows'rows. In blocks of rows, whose triangles are factored again
    (Demmel, Grigori, Hoemmen & Langou 2012, SIAM J. Sci. Comput. 34, A206-A239)."""
    width = rows.shape[1]
    block = max(_BLOCK // max(width, 1), 2 * width)
    while len(rows) > block:
        count = -(-len(rows) // block)
        filled = np.zeros((count * block, width))
        filled[: len(rows)] = rows
        rows = np.vstack([np.linalg.qr(part, mode="r") for part in np.split(filled, count)])
    found = np.zeros((width, width))
    triangle = np.linalg.qr(rows, mode="r")
    found[: len(triangle)] = triangle
    return found
