"""`FlexibleBody`: a plate that bends in a few given shapes, as numbers.

Goes in: what a reduction of the body's own plate gives, or what a textbook says of a beam. Comes out: the record from
which `derive` takes the body's inertia forces. Nothing here knows finite elements, and nothing is symbolic.

The deformation is u = n Σ φ_k η_k along the drawn normal n, with φ_k and its gradient zero on the body's inboard hinge
line, so that the body's frame is that of its hinge (a floating frame of the tangent kind; Shabana, Dynamics of
Multibody Systems, ch. 5). Rates are exact for that map: what stretching second order in η does is left out, as in any
linear reduction, so that n Σ φ_k η_k has to stay small beside the body.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from lamc.basics.checks import Array, checked_array, checked_name
from lamc.basics.errors import DesignError

Shapes = tuple[Array, Array]  # φ (k,), and the gradients (k, 3) of φ in the plate's plane, 1/m of φ's unit


@dataclass(frozen=True, eq=False)
class FlexibleBody:
    """The modes of one body. With φ in units of 1, η is in m; with φ in 1/√kg (mass-normalised), η is in m·√kg.

    body            name of the body; it must not be fixed
    normal          n, (3,), unit vector, drawn world axes
    moment          s_k = ∫ρ φ_k, (k,), kg
    first_moment    X_k = ∫ρ r φ_k about the drawn centre of mass, (k, 3), kg·m, drawn world axes
    mass            G_kl = ∫ρ φ_k φ_l, (k, k), kg; symmetric, positive definite
    stiffness       K_kl, (k, k), N/m; symmetric, positive semi-definite
    damping_ratios  ζ_k, (k,), of critical: the modes of (K, G) are damped by 2 ζ_k ω_k, in the order of ω
    shape_at        drawn point (3,), m → φ (k,) and gradients (k, 3) there
    unit            of η
    """

    body: str
    normal: Array
    moment: Array
    first_moment: Array
    mass: Array
    stiffness: Array
    damping_ratios: Array
    shape_at: Callable[[Array], Shapes]
    unit: str = "m"
    effect: str = ""  # who asked for it, and stores its energy; `Arranging` fills it in

    def __post_init__(self) -> None:
        checked_name(self.body, "a flexible body")
        what = f"the flexible body {self.body!r}"
        count = len(np.atleast_1d(self.moment))
        shapes: tuple[tuple[str, tuple[int, ...]], ...] = (
            ("normal", (3,)),
            ("moment", (count,)),
            ("first_moment", (count, 3)),
            ("mass", (count, count)),
            ("stiffness", (count, count)),
            ("damping_ratios", (count,)),
        )
        for name, shape in shapes:
            object.__setattr__(self, name, checked_array(getattr(self, name), shape, f"{name} of {what}"))
        if abs(float(np.linalg.norm(self.normal)) - 1.0) > 1e-9:
            raise DesignError(f"the normal of {what} is {self.normal.tolist()}; it must be a unit vector")
        for name, least in (("mass", 1e-12), ("stiffness", -1e-9)):
            matrix = getattr(self, name)
            size = float(np.abs(matrix).max(initial=0.0))
            if not np.allclose(matrix, matrix.T, rtol=0.0, atol=1e-9 * size):
                raise DesignError(
                    f"the modal {name} of {what} is not symmetric; give the integrals as they are"
                )
            lowest = float(np.linalg.eigvalsh(matrix)[0]) if count else 1.0
            if lowest < least * size or (least > 0 and lowest <= 0.0):
                rule = "positive definite" if least > 0 else "positive semi-definite"
                raise DesignError(
                    f"the modal {name} of {what} is not {rule}; leave out modes that depend on others"
                )
        if (self.damping_ratios < 0.0).any():
            raise DesignError(
                f"damping_ratios of {what} are {self.damping_ratios.tolist()}; none may be negative"
            )

    @property
    def count(self) -> int:
        """How many modes."""
        return len(self.moment)

    def shapes(self, point: Array) -> Shapes:
        """φ (k,) and gradients (k, 3) at a drawn point, checked; gradients without what they have along the normal."""
        what = f"shape_at of the flexible body {self.body!r} at {np.asarray(point).tolist()}"
        phi, slopes = self.shape_at(np.asarray(point, dtype=np.float64))
        slopes = checked_array(slopes, (self.count, 3), what)
        return checked_array(phi, (self.count,), what), slopes - np.outer(slopes @ self.normal, self.normal)

    @property
    def damping(self) -> Array:
        """Damping matrix C (k, k), N·s/m, of the ratios: G V diag(2 ζ ω) Vᵀ G with KV = GV diag(ω²), VᵀGV = 1."""
        lower = np.linalg.cholesky(self.mass)
        scaled = np.linalg.solve(lower, np.linalg.solve(lower, self.stiffness).T)
        squares, vectors = np.linalg.eigh(0.5 * (scaled + scaled.T))
        carried = lower @ vectors  # G V
        ratios = 2.0 * self.damping_ratios * np.sqrt(np.maximum(squares, 0.0))
        damping: Array = carried @ np.diag(ratios) @ carried.T
        return damping
