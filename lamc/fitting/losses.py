"""How residuals count: the loss of each, and its derivatives by the square.

In: residuals (N,) over their noise. Out: costs, weights, curvatures. Large residuals count less with all losses but
"linear" (Huber, Robust Statistics, 1981; Triggs et al. 2000, section 4.3).
"""

import numpy as np

from lamc.run.request import Array

LOSSES = ("linear", "soft_l1", "huber", "cauchy", "arctan")
_LEAST = 1e-3  # of the curvature of a square: beyond an outlier's turning point a step still has a size


def cost_of(residual: Array, loss: str) -> float:
    """Half the sum of the losses."""
    z = residual**2
    if loss == "soft_l1":
        z = 2.0 * (np.sqrt(1.0 + z) - 1.0)
    elif loss == "huber":
        z = np.where(z <= 1.0, z, 2.0 * np.sqrt(z) - 1.0)
    elif loss == "cauchy":
        z = np.log1p(z)
    elif loss == "arctan":
        z = np.arctan(z)
    return 0.5 * float(np.sum(z))


def weights_of(residual: Array, loss: str) -> tuple[Array, Array]:
    """Weights (N,) ρ'(r²) of residuals, and curvatures of the loss, at least a little above zero."""
    z = residual**2
    if loss == "linear":
        return np.ones_like(z), np.ones_like(z)
    if loss == "soft_l1":
        first, second = (1.0 + z) ** -0.5, -0.5 * (1.0 + z) ** -1.5
    elif loss == "huber":
        first = np.where(z <= 1.0, 1.0, np.maximum(z, 1.0) ** -0.5)
        second = np.where(z <= 1.0, 0.0, -0.5 * np.maximum(z, 1.0) ** -1.5)
    elif loss == "cauchy":
        first, second = 1.0 / (1.0 + z), -1.0 / (1.0 + z) ** 2
    else:
        first, second = 1.0 / (1.0 + z**2), -2.0 * z / (1.0 + z**2) ** 2
    return first, np.maximum(first + 2.0 * second * z, _LEAST)


def weighed(residual: Array, jacobian: Array, loss: str) -> tuple[Array, Array]:
    """Residuals and Jacobian of the squares that have the loss's gradient and, nearly, its curvature here."""
    if loss == "linear":
        return residual, jacobian
    weights, curves = weights_of(residual, loss)
    root = np.sqrt(curves)
    return residual * weights / root, jacobian * root[:, None]
