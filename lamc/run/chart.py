"""Independent coordinates of the closed positions next to a stand, by name.

In: a `Stand`, perhaps names. Out: a `Chart`: which rates are independent, and how all others follow them. Never:
evaluates forces.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from lamc.basics.checks import did_you_mean, shown
from lamc.basics.errors import RequestError
from lamc.run.at_rest import Rest, Stand
from lamc.run.request import Array

ENOUGH = (
    0.5  # of the largest share that is left: the first rate in order with so much is taken, so that round-off
)
# never chooses among equals
_DEPENDENT = 1e-9  # of the share of the first: what follows from those that were chosen
_TURNS = {"base.wx": "base.rx", "base.wy": "base.ry", "base.wz": "base.rz"}


@dataclass(frozen=True, eq=False)
class Chart:
    """positions, rates  names of the independent ones, with their units, in the order of the model's rates
    chosen   (k,): their places among the rates
    follow   S (nu, k): all rates of the independent ones
    flow     B S (nq, k): how all coordinates follow the independent positions

    The position of a rate that is no coordinate's own, a turn of a free base, is its integral: "base.rx", rad, about
    the x axis of the base as it stands there."""

    positions: tuple[str, ...]
    position_units: tuple[str, ...]
    rates: tuple[str, ...]
    rate_units: tuple[str, ...]
    chosen: tuple[int, ...]
    follow: Array
    flow: Array


def chart_of(stand: Stand, names: Sequence[str] | None = None) -> Chart:
    """The chart of the rates named, by their coordinates ("h1", "base.x"), or of a choice that depends on no round-off.

    Raises RequestError for names that are not there, too few or too many, or of which one follows from others."""
    rest, tangent = stand.rest, stand.tangent
    known = position_names(rest)
    shares = tangent / rest.per_radian[:, None]
    chosen = _chosen(shares) if names is None else _given(names, known, shares)
    follow = tangent @ np.linalg.inv(tangent[list(chosen)]) if chosen else np.zeros((rest.nu, 0))
    follow[list(chosen)] = np.eye(len(chosen))
    model, rates = rest.motion.model, rate_names(rest)
    return Chart(
        tuple(known[k] for k in chosen),
        tuple(model.rates[k].unit.removesuffix("/s") for k in chosen),
        tuple(rates[k] for k in chosen),
        tuple(model.rates[k].unit for k in chosen),
        chosen,
        follow,
        np.asarray(rest.flow(stand.q) @ follow),
    )


def position_names(rest: Rest) -> tuple[str, ...]:
    """What each rate is the rate of."""
    return tuple(
        _TURNS.get(rate.name, rate.name.replace("base.v", "base.", 1)) for rate in rest.motion.model.rates
    )


def rate_names(rest: Rest) -> tuple[str, ...]:
    """As results have them: "h1.rate", and of a free base "base.vx"."""
    return tuple(
        rate.name if rate.name.startswith("base.") else f"{rate.name}.rate"
        for rate in rest.motion.model.rates
    )


def _chosen(shares: Array) -> tuple[int, ...]:
    """By Gram and Schmidt with a choice of rows."""
    left, found = shares.copy(), []
    for _ in range(shares.shape[1]):
        sizes = np.linalg.norm(left, axis=1)
        best = int(np.flatnonzero(sizes >= ENOUGH * sizes.max())[0])
        axis = left[best] / sizes[best]
        left = left - np.outer(left @ axis, axis)
        left[best] = 0.0
        found.append(best)
    return tuple(sorted(found))


def _given(names: Sequence[str], known: Sequence[str], shares: Array) -> tuple[int, ...]:
    if isinstance(names, str) or not isinstance(names, Sequence):
        raise RequestError(f"independent is {shown(names)}; it must be a list of names, such as ['h1']")
    for name in names:
        if name not in known:
            raise RequestError(f"independent has {shown(name)}; {did_you_mean(str(name), list(known))}")
    chosen = tuple(known.index(name) for name in names)
    k = shares.shape[1]
    if len(set(chosen)) != k or len(chosen) != k:
        raise RequestError(
            f"independent names {len(chosen)} coordinates; it must name {k} different ones, as many as there are "
            "degrees of freedom"
        )
    values = np.linalg.svd(shares[list(chosen)], compute_uv=False)
    if k and values[-1] < _DEPENDENT * max(values[0], 1.0):
        raise RequestError(
            f"independent is {shown(list(names))}, but there one of them follows from the others, or stands still; "
            "name others, or leave it out"
        )
    return chosen
