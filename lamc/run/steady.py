"""What an operating point may rest on: loads that do not change with time, contacts that are made or are not, loops
whose rank holds.

In: a `Stand`, a scene's guards. Out: names of contacts that are made, or an error that says why nothing can be said of
the place. Never: searches.
"""

from collections.abc import Sequence

import numpy as np

from lamc.basics.errors import RequestError, SimulationError, UnsupportedError
from lamc.records.network import listed_names
from lamc.run.at_rest import Rest, Stand
from lamc.run.model import Model
from lamc.run.request import Array

FADED = 1e-5  # of the strongest equation of the loops: such a position is known to 1e-8 at best; see CLOSED
CLOSED = 1e-13  # rad, or of the size: to which the runtime closes loops (tolerances.h)
EDGE = 1e-7  # rad, or of the size: closer than this, round-off says on which side of a contact a place is
_JUMP = (
    1e-3  # of the stiffness: smooth loads change by about EDGE over the edge, a contact by a part of itself
)
_INSTANTS = 512  # at which loads are looked at
_ODD = 0.6180339887498949  # of the spacing: periodic loads have no period in common with it
_SAME = 1e-12  # of the accelerations: round-off of the same sums


def check_clocks(model: Model) -> None:
    """Raises UnsupportedError for what samples: between samples it holds what it took, and no stiffness in continuous
    time has that."""
    if model.has_clocks:
        clock = model.guards[model.handle.clock_guards[0]]
        raise UnsupportedError(
            f"{clock}: what is held between samples has no stiffness and no linear model; leave its period out, which "
            "balances at the same place and is the limit of short periods, or look at runs"
        )


def check_time(rest: Rest, q: Array, duration: float) -> None:
    """Raises RequestError where the loads at rest change within the duration, s."""
    times = np.concatenate(
        [[rest.t], duration * (np.arange(_INSTANTS) + _ODD) / _INSTANTS, *_extremes(rest, duration)]
    )
    rows = np.repeat(rest.row(q), len(times), axis=0)
    found = rest.motion.accelerations(times, rows)
    changes = np.abs(found - found[0]).max(initial=0.0, where=np.isfinite(found))
    if changes > _SAME * np.abs(found).max(initial=0.0, where=np.isfinite(found)):
        worst = int(np.abs(found - found[0]).max(axis=0).argmax())
        raise RequestError(
            f"loads of this scene depend on time (the acceleration of {rest.motion.model.rates[worst].name!r} from "
            f"rest changes within {duration:g} s), and nothing balances for good; give t=… (--at) to hold them as they "
            "are then, or leave the load out"
        )


def _extremes(rest: Rest, duration: float) -> list[Array]:
    """Where series that inputs follow are largest and smallest, (2,) each, s: a pulse may be short."""
    found = []
    for series in rest.motion.following.series:
        within = (series.t >= 0.0) & (series.t <= duration)
        if np.any(within):
            values = np.where(within, series.values, np.nan)
            found.append(series.t[[np.nanargmax(values), np.nanargmin(values)]])
    return found


def check_rank(stand: Stand) -> None:
    """Raises SimulationError at a singular position."""
    if stand.weakest < FADED:
        raise SimulationError(
            f"the position is singular: an equation of the loops has faded to {stand.weakest:.1e} of the strongest, so "
            "that the motion can go more ways than one and a linear model does not exist; take another start, or a "
            "rest angle off the flat or stretched position"
        )


def contacts(rest: Rest, q: Array) -> tuple[str, ...]:
    """Names of the guards that are passed: stops and points that touch."""
    model = rest.motion.model
    return tuple(name for name, value in zip(model.guards, rest.guards(q), strict=True) if value > 0.0)


def check_edges(stand: Stand) -> None:
    """Raises SimulationError where the stiffness is one on this side, and another on that: at a contact that is about
    to be made or lost, at a kink of a law, and on an impact, which holds nothing at rest."""
    rest = stand.rest
    model = rest.motion.model
    here = rest.guards(stand.q)
    impacts = [k for k in range(len(model.guards)) if model.handle.guard_modes[k] < 0]
    here_resists = _resistances(stand)
    size = float(np.abs(here_resists).max(initial=0.0))
    k = len(stand.push)
    axes = [np.ones(k), *(np.eye(k) if len(here) else ())][: k and None]
    for axis in axes:
        step = axis * (EDGE / stand.reach(axis))
        sides = [stand.moved(step), stand.moved(-step)]
        if None in sides:
            raise SimulationError(
                "loads have no value right beside the position; it lies on the edge of what they know"
            )
        there = [rest.guards(side.q) for side in sides if side is not None]
        changed = [k for k in range(len(here)) if len({bool(g[k] > 0.0) for g in (here, *there)}) > 1]
        struck = [k for k in impacts if k in changed or here[k] > 0.0]
        if struck:
            raise SimulationError(
                f"{_named(model.guards, struck)} is reached there, and an impact gives no force at rest; let it "
                "yield: give the limit a stiffness instead of a restitution"
            )
        jump = max(
            float(np.abs(_resistances(s) - here_resists).max(initial=0.0)) for s in sides if s is not None
        )
        if jump > _JUMP * size:
            what = _named(model.guards, changed) if changed else "a load"
            raise SimulationError(
                f"{what} is on the edge there: the stiffness changes by {jump / size:.1%} within {EDGE:g} rad (or "
                "parts of the size), and no one linear model holds on both sides; press it on or take it off by a load"
            )


def _resistances(stand: Stand) -> Array:
    """Eigenvalues (k,) of the stiffness, which are the same in any basis."""
    return np.asarray(np.sort_complex(np.linalg.eigvals(stand.response)))


def _named(names: Sequence[str], which: Sequence[int]) -> str:
    return listed_names([names[k] for k in which])
