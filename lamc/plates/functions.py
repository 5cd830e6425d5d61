"""Functions of x and y that a user gives: called with arrays, and not trusted.

In: a number or a function, and places. Out: one finite number per place. Never: knows what they are for.
"""

from collections.abc import Callable

import numpy as np

from lamc.basics.checks import Array, shown
from lamc.basics.errors import DesignError, ExpressionError


def values_at(given: float | Callable[[Array, Array], Array], points: Array, what: str) -> Array:
    """`given` at `points` (..., 2), shape (...). Raises DesignError, naming `what`, where it fails or is not finite."""
    shape = points.shape[:-1]
    if not callable(given):
        return np.full(shape, float(given))
    x, y = points[..., 0].ravel(), points[..., 1].ravel()
    try:
        found = np.asarray(given(x.copy(), y.copy()))
        if np.iscomplexobj(found):
            raise TypeError("its values are complex")  # numpy would drop the imaginary parts
        values = found.astype(float)
    except ExpressionError as error:  # of a file, whose words suit its reader
        raise DesignError(f"{what}: {error.message}") from error
    except Exception as error:  # whatever a user's own function raises
        raise DesignError(
            f"{what} is a function that fails: {type(error).__name__}: {error}; it is called with arrays of x and y "
            "and must give an array: use numpy's functions, or numpy.vectorize"
        ) from error
    if values.shape not in ((), x.shape):
        raise DesignError(
            f"{what} is a function that gives an array of shape {values.shape} for x and y of shape {x.shape}; it must "
            "give one number for every place"
        )
    values = np.broadcast_to(values, x.shape)
    if not np.isfinite(values).all():
        k = int(np.flatnonzero(~np.isfinite(values))[0])
        raise DesignError(
            f"{what} is a function that gives {shown(float(values[k]))} at ({x[k]:.6g}, {y[k]:.6g}); every value "
            "must be finite"
        )
    return values.reshape(shape).copy()
