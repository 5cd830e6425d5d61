"""Iterative refinement of a deformation, and what it says about the digits.

In: a system, forces, prescribed values. Out: unknowns in long double, with estimates of their error. Never: loads,
supports.

The residual is f - ∫ Bᵀ S B d dA, strains first: rigid motion, which is most of what a soft hinge passes on, cancels
in B d before the stiffness multiplies anything, and in long double the rest is exact enough to correct what the factor
of a rounded matrix gets wrong. Each step shrinks the error by the condition number times double round-off. Source:
N. J. Higham, Accuracy and Stability of Numerical Algorithms, 2nd ed. 2002, chapter 12.
"""

from dataclasses import dataclass

import numpy as np

from lamc.basics.checks import Array
from lamc.basics.errors import SimulationError
from lamc.plates.elements.kernels import Numbers
from lamc.plates.solving.system import System

_MOST_STEPS = 30
_ENOUGH = 1e-14  # forward error at which it stops: below double round-off of a result of a few operations
_SLOW = 0.9  # a step that shrinks less does not converge
_UNUSABLE = 1e-3  # forward error above which there is no answer


@dataclass(frozen=True)
class Accuracy:
    """How well a system was solved; errors are relative, in units of each unknown's own stiffness.

    condition       estimate for the scaled stiffness matrix
    steps           of refinement
    forward_error   estimate for the unknowns
    backward_error  what is out of balance, over what is in it
    """

    condition: float
    steps: int
    forward_error: float
    backward_error: float


@dataclass(frozen=True, eq=False)
class Deformed:
    """Unknowns (N,), the inner forces that they cause (N,), both in long double, and how exact they are."""

    d: Numbers
    inner: Numbers
    accuracy: Accuracy


def solve(system: System, forces: Array, prescribed: Array, *, refine: bool = True) -> Deformed:
    """The unknowns in equilibrium with `forces` (N,) that are `prescribed` (N,) along what is held.

    Raises SimulationError where the matrix is so badly conditioned that no digits are left.
    """
    outer = forces.astype(np.longdouble)
    d = prescribed.astype(np.longdouble)
    inner = system.inner_forces(d) if prescribed.any() else np.zeros_like(outer)
    if not (forces.any() or prescribed.any()):
        return Deformed(d, inner, Accuracy(system.condition, 0, 0.0, 0.0))
    last, error, step = np.inf, np.inf, 0
    for step in range(_MOST_STEPS + 1 if refine else 1):
        change = _change(system, outer - inner)
        d = d + change
        inner = system.inner_forces(d)
        size = system.size_of(np.asarray(d, dtype=float))
        ratio = system.size_of(np.asarray(change, dtype=float)) / size if size > 0.0 else 0.0
        if step and ratio >= _SLOW * last:
            error = ratio
            break
        # The first solution is as wrong as the condition says; later a step shrinks the error as the last one did.
        rate = (system.condition * np.finfo(float).eps, ratio)[min(step, 1)] if step < 2 else ratio / last
        last, error = ratio, ratio * min(rate, 1.0)
        if step and error < _ENOUGH:
            break
    if not error < _UNUSABLE:
        raise SimulationError(
            f"no digits are left: the stiffness matrix has condition {system.condition:.1e}, and refinement stops at a "
            f"relative error of {error:.1e}; parts may hang together by next to nothing, or be too soft beside the rest"
        )
    backward = _out_of_balance(system, outer, inner)
    return Deformed(d, inner, Accuracy(system.condition, step, float(error), backward))


def _change(system: System, residual: Numbers) -> Numbers:
    """Of the unknowns, by the factor; the residual on them is brought to size 1 first, as it may be tiny."""
    right = system.on_free(residual)
    size = np.max(np.abs(right), initial=0.0)
    if size == 0.0:
        return np.zeros_like(residual)
    change = system.solved_free(np.asarray(right / size, dtype=float)[:, None])[:, 0]
    return np.asarray(change.astype(residual.dtype) * size)


def _out_of_balance(system: System, outer: Numbers, inner: Numbers) -> float:
    """Of the free unknowns, each in units of its own stiffness, over what acts on them."""
    left, acting = system.force_size(outer - inner), max(system.force_size(outer), system.force_size(inner))
    return left / acting if acting > 0.0 else 0.0
