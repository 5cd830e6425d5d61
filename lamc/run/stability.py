"""Whether an equilibrium holds: stiffness, damping and inertia along the closed positions, and what they say.

In: a `Stand` where forces balance. Out: `Resistance`: symmetric or not, in orthonormal coordinates of the inertia, and
a verdict. Never: searches.

Of conservative loads the stiffness is the projected Hessian, N^T (V_qq + λ·φ_qq) N, and tells all (Lagrange and
Dirichlet). Of others, such as forces that follow a body, and where damping feeds energy in, the eigenvalues of the
linear model do (Lyapunov's first method); where one has no real part, nothing is said.
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from lamc.run.at_rest import Stand
from lamc.run.request import Array

Kind = Literal["stable", "unstable", "neutral"]
Criterion = Literal["projected Hessian", "eigenvalues"]
NEUTRAL = 1e-9  # of the largest: below, round-off says of a stiffness which sign it has
_SYMMETRIC = 1e-7  # of the stiffness: exact derivatives of conservative loads leave 1e-12, differences 1e-10
_ON_AXIS = 1e-7  # of the largest eigenvalue: a double one is known to the root of round-off, 1.5e-8, only


@dataclass(frozen=True, eq=False)
class Resistance:
    """stiffness (k, k), 1/s², and damping (k, k), 1/s, by L⁻¹ K L⁻ᵀ, and what they say.

    kind         stable: any small push is answered by a motion that stays small; unstable; neutral: in one direction
                 at least nothing pulls back or pushes on to first order
    criterion    what says so
    reason       the same for people
    """

    stiffness: Array
    damping: Array
    kind: Kind
    criterion: Criterion
    reason: str

    @property
    def is_symmetric(self) -> bool:
        return is_symmetric(self.stiffness)


def is_symmetric(matrix: Array) -> bool:
    """But for round-off."""
    return bool(np.linalg.norm(matrix - matrix.T) <= _SYMMETRIC * np.linalg.norm(matrix))


def resistance(stand: Stand) -> Resistance:
    """Of a stand where forces balance."""
    factor = stand.factor
    by_positions, by_rates, _ = stand.slopes
    stiffness, damping = (
        np.asarray(-np.linalg.solve(factor, (factor.T @ slope).T).T, dtype=float)
        for slope in (by_positions, by_rates)
    )
    return Resistance(stiffness, damping, *_verdict(stiffness, damping))


def system(stiffness: Array, damping: Array) -> Array:
    """(2k, 2k): of x' = A x, with positions, then rates."""
    k = len(stiffness)
    return np.block([[np.zeros((k, k)), np.eye(k)], [-stiffness, -damping]])


def _verdict(stiffness: Array, damping: Array) -> tuple[Kind, Criterion, str]:
    if not len(stiffness):
        return "stable", "projected Hessian", "nothing can move"
    dissipation = np.linalg.eigvalsh(0.5 * (damping + damping.T))
    feeds = dissipation[0] < -NEUTRAL * max(abs(dissipation[-1]), abs(dissipation[0]))
    if is_symmetric(stiffness) and not feeds:
        found = np.linalg.eigvalsh(0.5 * (stiffness + stiffness.T))
        least = NEUTRAL * float(np.abs(found).max())
        falling, idle = int((found < -least).sum()), int((np.abs(found) <= least).sum())
        if falling and is_symmetric(damping):
            return "unstable", "projected Hessian", _count(falling, len(found), "falls away")
        if not falling:
            kind: Kind = "neutral" if idle else "stable"
            says = _count(idle, len(found), "is held by nothing") if idle else "all directions are held"
            return kind, "projected Hessian", says
    pace = (
        float(np.sqrt(np.linalg.norm(stiffness))) or 1.0
    )  # 1/s: time is measured by it, so that entries are alike
    values = pace * np.linalg.eigvals(system(stiffness / pace**2, damping / pace))
    largest = float(values.real.max())
    why = "damping feeds energy in" if feeds else "loads are not conservative"
    told = f"{why}; the eigenvalue with the largest real part has {largest:.3g} 1/s"
    if largest > _ON_AXIS * float(np.abs(values).max()):
        return "unstable", "eigenvalues", told
    return ("stable" if largest < -_ON_AXIS * float(np.abs(values).max()) else "neutral"), "eigenvalues", told


def _count(some: int, of: int, what: str) -> str:
    return f"{some} of {of} direction{'s' * (of > 1)} {what}"
