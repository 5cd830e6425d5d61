"""Arguments of a `Simulator` as arrays: states, starts, rates.

In: what a user passes. Out: arrays of the shapes that a `Motion` takes, or a RequestError of one line. Never: evaluates
anything.
"""

import math

import numpy as np
import numpy.typing as npt

from lamc.basics.checks import shown
from lamc.basics.errors import RequestError, about
from lamc.records.scene import Scene
from lamc.run.model import Model
from lamc.run.request import Array, did_you_mean, finite


def states(
    q: npt.ArrayLike, u: npt.ArrayLike, t: npt.ArrayLike, model: Model
) -> tuple[Array, Array, tuple[int, ...]]:
    """Times (m,), rows (m, nq + nu) and the leading shape, of coordinates (…, nq), rates (…, nu) and times (…)."""
    angles, rates, times = (numbers(a, name) for a, name in ((q, "q"), (u, "u"), (t, "t")))
    plain = len(model.coordinates) == len(model.joints)
    for array, name, entries in ((angles, "q", model.coordinates), (rates, "u", model.rates)):
        if array.ndim == 0 or array.shape[-1] != len(entries):
            what = "the joints" if plain else f"as many as `{'coordinates' if name == 'q' else 'rates'}`"
            raise RequestError(
                f"{name} has shape {array.shape}; its last length must be {len(entries)}, {what}"
            )
    try:
        shape = np.broadcast_shapes(angles.shape[:-1], rates.shape[:-1], times.shape)
    except ValueError as error:
        raise RequestError(
            f"q {angles.shape}, u {rates.shape} and t {times.shape} do not broadcast to one shape"
        ) from error
    halves = [np.broadcast_to(half, (*shape, half.shape[-1])) for half in (angles, rates)]
    rows = np.concatenate(halves, axis=-1).reshape(math.prod(shape), model.state_size)
    return np.ascontiguousarray(np.broadcast_to(times, shape)).reshape(-1), rows, shape


def numbers(values: npt.ArrayLike, name: str) -> Array:
    """`values` as an array of floats, or RequestError."""
    try:
        return np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError, OverflowError) as error:
        raise RequestError(f"{name} is {shown(values)}; it must be an array of numbers") from error


def check_names(scene: Scene, joints: tuple[str, ...]) -> None:
    """Raises RequestError if the scene starts a joint that is not there."""
    for values, what in ((scene.angles, "angle"), (scene.rates, "rate")):
        for name in values:
            if name not in joints:
                with about((f"{what}s", name)):
                    raise RequestError(
                        f"the scene gives an initial {what} to joint {name!r}, which is not there; "
                        f"{did_you_mean(name, joints)}"
                    )


def drawn_start(scene: Scene, joints: tuple[str, ...]) -> Array:
    """Angles and rates (2n,) of the joints of a tree at the start: the scene's, zero where it gives none."""
    angles = [scene.angles.get(name, 0.0) for name in joints]
    rates = [scene.rates.get(name, 0.0) for name in joints]
    return np.array([*angles, *rates], dtype=np.float64)


def checked_rate(baumgarte: float | None, *, has_loops: bool) -> float:
    """Rate of Baumgarte's stabilisation, 1/s; 0 for None."""
    if baumgarte is None:
        return 0.0
    if isinstance(baumgarte, bool):
        raise RequestError(f"baumgarte is {baumgarte}; it must be a rate in 1/s above zero, or None")
    if not has_loops:
        raise RequestError(
            f"baumgarte is {shown(baumgarte)}, but there are no loops to stabilise; leave it out"
        )
    rate = finite(baumgarte, "baumgarte", "a rate in 1/s above zero, or None")
    if rate <= 0.0:
        raise RequestError(
            f"baumgarte is {rate!r}; it must be a rate in 1/s above zero, or None for projection"
        )
    return rate
