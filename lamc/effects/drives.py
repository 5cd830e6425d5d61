"""Drives: the expressions by which effects act on time, and on the angle and rate of a joint.

In: an expression, and what it gives. Out: an error where it is outside the language, or has no value when the run needs
it: nowhere, at the start, or at an instant on the way. Never: changes a value.

An effect that is driven has drives(), which gives its `Drive`s, and makes each with `checked_drive`; what is found at
the start and along the run is then told for it.
"""

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import numpy.typing as npt

from lamc.effects.domain import EVERYWHERE, Undefined, undefined
from lamc.errors import ExpressionError, about

Bounds = tuple[npt.ArrayLike, npt.ArrayLike]
INSTANTS = 1001  # of a run that are looked at


@dataclass(frozen=True)
class Drive:
    """An expression in t (s) and, with a joint, in its angle (rad) and rate (rad/s).

    what  the expression gives, for messages: "the torque of joint 'h1'"
    """

    what: str
    text: str
    joint: str | None = None


def checked_drive(drive: Drive) -> Drive:
    """`drive`, if it is in the language and has a value somewhere, and at t = 0. Raises ExpressionError."""
    try:
        always = undefined(drive.text, _ranges(drive, (0.0, math.inf), EVERYWHERE, EVERYWHERE))
        start = undefined(drive.text, _ranges(drive, (0.0, 0.0), EVERYWHERE, EVERYWHERE))
    except ExpressionError as error:
        raise ExpressionError(f"{drive.what}: {error.message}") from error
    if always is not None:
        raise _refusal(drive, always, "at any time")
    if start is not None:
        raise _refusal(drive, start, "at t = 0 s")
    return drive


def check_drives(
    effects: Iterable[object], angles: Mapping[str, float], rates: Mapping[str, float], t_end: float
) -> None:
    """Raises ExpressionError for a drive without a value at the start or, whatever moves, at an instant of the run.

    angles, rates  of all joints at the start, rad and rad/s; t_end  s
    """
    for effect in effects:
        for drive in getattr(effect, "drives", tuple)():
            with about(effect):
                _check_start(drive, angles, rates)
                _check_instants(drive, t_end)


def _check_start(drive: Drive, angles: Mapping[str, float], rates: Mapping[str, float]) -> None:
    angle, rate = (values.get(drive.joint or "", 0.0) for values in (angles, rates))
    found = _at_start(drive, angle, rate)
    if found is not None:
        at = f" with angle = {angle:.6g} rad and rate = {rate:.6g} rad/s" if drive.joint is not None else ""
        raise _refusal(drive, found, f"at the start{at}")


def _check_instants(drive: Drive, t_end: float) -> None:
    found = _on_the_way(drive, t_end) if np.isfinite(t_end) else None
    if found is not None:
        at = t_end * found.index / (INSTANTS - 1)
        raise _refusal(drive, found, f"at t = {at:.6g} s, within the run of {t_end:g} s")


@lru_cache(maxsize=1024)  # many runs of one scene ask the same
def _at_start(drive: Drive, angle: float, rate: float) -> Undefined | None:
    return undefined(drive.text, _ranges(drive, (0.0, 0.0), (angle, angle), (rate, rate)))


@lru_cache(maxsize=1024)
def _on_the_way(drive: Drive, t_end: float) -> Undefined | None:
    times = np.linspace(0.0, t_end, INSTANTS)
    return undefined(drive.text, _ranges(drive, (times, times), EVERYWHERE, EVERYWHERE))


def _ranges(drive: Drive, t: Bounds, angle: Bounds, rate: Bounds) -> dict[str, Bounds]:
    return {"t": t} if drive.joint is None else {"t": t, "angle": angle, "rate": rate}


def _refusal(drive: Drive, found: Undefined, when: str) -> ExpressionError:
    return ExpressionError(
        f"{drive.what}: expression {drive.text!r} has no value {when}: {found.reason}; keep it in its domain, as by "
        "max(…) or min(…), or end the run before"
    )
