"""What a run is asked for, what an integrator gives back, and how a run can end.

In: plain arguments of `Simulator.run`. Out: `Request` and `Trajectory`, checked records that every
integrator shares. Never: evaluates anything.
"""

import math
from collections.abc import Callable, Iterable
from contextlib import suppress
from dataclasses import dataclass
from enum import IntEnum
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from lamc.basics.checks import nearest_name, shown
from lamc.basics.errors import DesignError, RequestError
from lamc.basics.units import DURATION, to_si

if TYPE_CHECKING:
    from lamc.run.taping import Tape

Array = npt.NDArray[np.float64]
Progress = Callable[[float, float], None]

MIN_RTOL = 1e-13  # as in runtime_c/src/run.c: below, the error estimate is round-off


class Status(IntEnum):
    """How a run ended: 0 and 1 as in `solve_ivp`, negative numbers where it failed; but for 1 the numbers of
    `lamc_status`."""

    FOLDED = 1  # before its end, where `until_folded` asked for that
    REACHED_END = 0
    STEP_UNDERFLOW = -1
    NOT_FINITE = -2
    STEP_LIMIT = -3
    CANCELLED = -4
    CLOSURE_LOST = -7
    RANK_LOST = -8  # it stays at a singular position
    EVENTS_PILE_UP = -9  # impacts follow each other ever faster (Zeno)
    FAILED = -6  # for a reason of its own, told in the message; scipy's integrators only


# Why there are no derivatives any more, behind the numbers of `lamc_lost`
BETWEEN_STEPS, UNFOLLOWED = 5, 6


@dataclass(frozen=True, eq=False)
class Along:
    """Directions along which a run is differentiated, for a model with columns.

    inputs      (inputs,): what `setup` is given
    directions  (columns of the model, inputs): how they move it
    start       (nq + nu, k): derivatives of y0; columns of the model first, then those that move the start only
    """

    inputs: Array
    directions: Array
    start: Array


@dataclass(frozen=True, eq=False)
class Request:
    """What to integrate to and how well. Made by `checked_request`."""

    y0: Array  # (nq + nu,): coordinates, then rates
    t_end: float  # s
    rtol: float
    atol: float  # rad and rad/s
    t_eval: Array | None  # (m,), s, ascending; None: a row at the start and after every step
    max_steps: int
    max_step: float  # s; infinite: no limit
    progress: Progress | None
    energy_balance: bool = False  # whether the work of effects is kept
    t_start: float = 0.0  # s, of y0
    along: "Along | None" = None  # what the run is differentiated by; None: nothing
    tape: "Tape | None" = None  # what keeps its steps; None: nothing does
    until: Callable[[Array], str] | None = (
        None  # asked of a state now and then: why to end there; empty: go on
    )
    most_work: float = math.inf  # of loops, as `lamc_motion_work_done` counts


@dataclass(frozen=True, eq=False)
class Trajectory:
    """What an integrator gives back; every row is good, also where the run ended early.

    The last row of a run that ended early is the last state reached, whether or not a row was due there.
    """

    t: Array  # (m,), s
    q: Array  # (m, nq)
    u: Array  # (m, nu)
    t_reached: float  # s
    status: Status
    note: str  # the integrator's own words on a failure; may be empty
    evaluations: int
    accepted: int
    rejected: int | None  # None: not told by this integrator
    last_step: float  # s
    work: Array | None = None  # (m, effects and impacts), J, where the energy balance is kept
    effort: float = 0.0  # evaluations, with those that Jacobians and factorisations would pay for
    events: tuple[tuple[float, int], ...] = ()  # s and which guard
    switches: tuple[tuple[float, str], ...] = ()  # s and the integrator taken from there on
    singular_steps: int = 0  # accepted steps that ended with equations of the loops let go
    along: Array | None = None  # (m, nq + nu, k): derivatives of the states, NaN where there are none
    lost: tuple[float, int, int] | None = None  # s, since when there are none, why, and at which guard
    modes: tuple[tuple[float, ...], tuple[float, ...]] = ((), ())  # of guards at the start and at the end


def checked_request(
    y0: Array,
    t_end: float | str,
    rtol: float,
    atol: float,
    t_eval: npt.ArrayLike | None,
    max_steps: int,
    max_step: float | str | None,
    progress: Progress | None,
    energy_balance: bool = False,
    max_work: float | None = None,
) -> Request:
    """The request, or RequestError with the argument, its value and the rule."""
    end = finite(_seconds(t_end), "t_end", "a time in seconds, zero or later")
    if end < 0.0:
        raise RequestError(f"t_end is {end!r} s; a run starts at t = 0 and cannot end before")
    relative = finite(rtol, "rtol", f"between {MIN_RTOL:g} and 1")
    if not MIN_RTOL <= relative <= 1.0:
        raise RequestError(
            f"rtol is {relative!r}; it must lie between {MIN_RTOL:g} (below, round-off hides the error) and 1"
        )
    absolute = finite(atol, "atol", "zero or more, in rad and rad/s")
    if absolute < 0.0:
        raise RequestError(f"atol is {absolute!r}; it must be zero or more")
    longest = math.inf if max_step is None else finite(_seconds(max_step), "max_step", "a time above zero")
    if longest <= 0.0:
        raise RequestError(f"max_step is {longest!r} s; it must be above zero (leave it out for no limit)")
    if isinstance(max_steps, bool) or not isinstance(max_steps, int | np.integer) or max_steps <= 0:
        raise RequestError(f"max_steps is {shown(max_steps)}; it must be a whole number above zero")
    if progress is not None and not callable(progress):
        raise RequestError(f"progress is {shown(progress)}; it must be a function of (t, t_end), or None")
    if not isinstance(energy_balance, bool):
        raise RequestError(f"energy_balance is {shown(energy_balance)}; it must be True or False")
    steps = min(int(max_steps), 2**62)  # what the C counter holds
    work = math.inf if max_work is None else finite(max_work, "max_work", "operations, above zero")
    if work <= 0.0:
        raise RequestError(f"max_work is {max_work!r}; it must be above zero (leave it out for no limit)")
    asked = (_times(t_eval, end), steps, longest, progress, energy_balance)
    return Request(y0, end, relative, absolute, *asked, most_work=work)


def _seconds(time: object) -> object:
    """Text with a unit, "500 ms", in s; anything else as it is, for `finite` to judge."""
    if isinstance(time, str):
        with suppress(DesignError):
            return to_si(time, DURATION)
    return time


def finite(value: object, name: str, rule: str) -> float:
    """`value` as a finite float, or RequestError that tells the rule."""
    try:
        number = float(value)  # type: ignore[arg-type]
    except (TypeError, ValueError) as error:
        raise RequestError(f"{name} is {shown(value)}; it must be a number: {rule}") from error
    except OverflowError as error:
        raise RequestError(
            f"{name} is {shown(value)}, which no float holds; it must be finite: {rule}"
        ) from error
    if not math.isfinite(number):
        raise RequestError(f"{name} is {number!r}; it must be finite: {rule}")
    return number


def _times(t_eval: npt.ArrayLike | None, t_end: float) -> Array | None:
    """`t_eval` under the rules of `solve_ivp`: one-dimensional, within 0 … t_end, strictly ascending."""
    if t_eval is None:
        return None
    try:
        times = np.array(t_eval, dtype=np.float64, order="C")
    except (TypeError, ValueError, OverflowError) as error:
        raise RequestError("t_eval must be a sequence of times in seconds") from error
    if times.ndim != 1:
        raise RequestError(f"t_eval has shape {times.shape}; it must be one-dimensional")
    is_within = bool(len(times) == 0 or (times[0] >= 0.0 and times[-1] <= t_end))
    if is_within and (
        len(times) < 2 or (times[1:] > times[:-1]).all()
    ):  # the usual case, at a tenth of the cost
        return times
    outside = times[~((times >= 0.0) & (times <= t_end))]
    if outside.size:
        raise RequestError(
            f"t_eval holds {float(outside[0])!r} s; every time must lie within 0 … {t_end:g} s"
        )
    falling = np.flatnonzero(np.diff(times) <= 0.0)
    if falling.size:
        i = int(falling[0])
        raise RequestError(
            f"t_eval goes from {float(times[i])!r} to {float(times[i + 1])!r} s at position {i + 1}; "
            "it must ascend: sort it and drop repeated times"
        )
    return times


def did_you_mean(name: str, names: Iterable[str]) -> str:
    """The end of an error message: the nearest names, then all there are (eight at most)."""
    known = list(names)
    if not known:
        return "there are none"
    near = nearest_name(str(name), known)
    shown = ", ".join(known[:8]) + (f", … ({len(known)} in all)" if len(known) > 8 else "")
    return (f"did you mean {near!r}? " if near is not None else "") + f"there are {shown}"
