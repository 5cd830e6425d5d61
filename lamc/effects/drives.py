"""Drives: the expressions by which effects act on time, on the angle and rate of a joint, and on inputs of the scene.

In: an expression, and what it gives. Out: an error where it is outside the language, names an input that the scene does
not have, has no value when the run needs it (nowhere, at the start, or at an instant on the way), or has a kink where
the effect takes its derivatives. Never: changes a value.

An effect that is driven has drives(), which gives its `Drive`s, and makes each with `checked_drive`; what is found at
the start and along the run is then told for it. Which inputs there are is the scene's to say, so a name that is no
other's passes when a drive is made, and is looked for when a scene is.
"""

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import lru_cache
from types import MappingProxyType

import numpy as np
import numpy.typing as npt

from lamc.basics.errors import ExpressionError, about
from lamc.records.effect import hooked
from lamc.records.series import Series
from lamc.symbolic.domain import EVERYWHERE, Undefined, undefined
from lamc.symbolic.expression import CONSTANTS, names_in
from lamc.symbolic.kinks import Kink, first_kink

Bounds = tuple[npt.ArrayLike, npt.ArrayLike]
_Given = tuple[tuple[str, float | Series], ...]  # inputs with their values, or what they follow
INSTANTS = 1001  # of a run that are looked at
OF_JOINT = ("angle", "rate")
NO_INPUTS: Mapping[str, float] = MappingProxyType({})


@dataclass(frozen=True)
class Drive:
    """An expression in t (s), inputs of the scene and, with a joint, in its angle (rad) and rate (rad/s).

    what    the expression gives, for messages: "the torque of joint 'h1'"
    smooth  the effect differentiates it twice by t, so neither it nor its rate may jump within a run
    field   of the effect in which it stands, by keys
    """

    what: str
    text: str
    joint: str | None = None
    smooth: bool = False
    field: tuple[str | int, ...] = ()

    @property
    def names(self) -> tuple[str, ...]:
        """What it may name besides inputs and functions."""
        return (*CONSTANTS, "t", *(OF_JOINT if self.joint is not None else ()))

    def inputs(self) -> Mapping[str, int]:
        """Names that can only be inputs, each with the column where it first stands; in order of their columns."""
        own = ("t", *OF_JOINT)  # without a joint, angle and rate are nobody's
        return {name: column for name, column in names_in(self.text).items() if name not in own}


def checked_drive(drive: Drive) -> Drive:
    """`drive`, if it is in the language and has a value somewhere, and at t = 0. Raises ExpressionError, about its
    field."""
    with about(drive.field):
        try:
            anything = dict.fromkeys(drive.inputs(), EVERYWHERE)
            always = undefined(drive.text, anything | _ranges(drive, (0.0, math.inf), EVERYWHERE, EVERYWHERE))
            start = undefined(drive.text, anything | _ranges(drive, (0.0, 0.0), EVERYWHERE, EVERYWHERE))
        except ExpressionError as error:
            raise ExpressionError(f"{drive.what}: {error.message}") from error
        if always is not None:
            raise _refusal(drive, always, "at any time")
        if start is not None:
            raise _refusal(drive, start, "at t = 0 s")
    return drive


def check_drives(
    effects: Iterable[object],
    angles: Mapping[str, float],
    rates: Mapping[str, float],
    t_end: float,
    inputs: Mapping[str, float | Series] = NO_INPUTS,
) -> None:
    """Raises ExpressionError for a drive without a value at the start or, whatever moves, at an instant of the run,
    and for one with a kink within the run that has to be smooth.

    angles, rates  of all joints at the start, rad and rad/s; t_end  s; inputs  values of the run, by name, or series
    that reach over it
    """
    for effect in effects:
        for drive in hooked(effect).drives():
            given = tuple((name, inputs[name]) for name in drive.inputs())
            with about(effect, *drive.field):
                _check_start(drive, angles, rates, given)
                _check_instants(drive, t_end, given)
                _check_smooth(drive, t_end, given)


def _check_start(
    drive: Drive, angles: Mapping[str, float], rates: Mapping[str, float], given: _Given
) -> None:
    angle, rate = (values.get(drive.joint or "", 0.0) for values in (angles, rates))
    found = _at_start(drive, angle, rate, given)
    if found is not None:
        state = [("angle", angle, " rad"), ("rate", rate, " rad/s")] if drive.joint is not None else []
        values = [(name, _at(value, 0.0), "") for name, value in given]
        at = " and ".join(f"{n} = {v:.6g}{unit}" for n, v, unit in [*state, *values])
        raise _refusal(drive, found, f"at the start{' with ' if at else ''}{at}")


def _check_instants(drive: Drive, t_end: float, given: _Given) -> None:
    found = _on_the_way(drive, t_end, given) if np.isfinite(t_end) else None
    if found is not None:
        at = t_end * found.index / (INSTANTS - 1)
        reported = "".join(f", {name} = {_at(value, at):.6g}" for name, value in given)
        raise _refusal(drive, found, f"at t = {at:.6g} s{reported}, within the run of {t_end:g} s")


def _check_smooth(drive: Drive, t_end: float, given: _Given) -> None:
    kink = _kink(drive.text, given, t_end) if drive.smooth and 0.0 < t_end < np.inf else None
    if kink is not None:
        found = "its rate jumps" if kink.order else "it jumps"
        raise ExpressionError(
            f"{drive.what}: expression {drive.text!r} has a kink at t = {kink.t:.6g} s, within the run of {t_end:g} s: "
            f"{found} by {kink.jump:.6g}, and no step feels such a blow; round it off, as by tanh(…), or end the run "
            "before"
        )


@lru_cache(maxsize=1024)  # many runs of one scene ask the same
def _kink(text: str, given: _Given, t_end: float) -> Kink | None:
    return first_kink(text, dict(given), t_end, INSTANTS)


@lru_cache(maxsize=1024)
def _at_start(drive: Drive, angle: float, rate: float, given: _Given) -> Undefined | None:
    ranges = _ranges(drive, (0.0, 0.0), (angle, angle), (rate, rate))
    return undefined(drive.text, ranges | {name: (_at(v, 0.0), _at(v, 0.0)) for name, v in given})


@lru_cache(maxsize=1024)
def _on_the_way(drive: Drive, t_end: float, given: _Given) -> Undefined | None:
    times = np.linspace(0.0, t_end, INSTANTS)
    ranges = _ranges(drive, (times, times), EVERYWHERE, EVERYWHERE)
    for name, value in given:
        at = value.at(times) if isinstance(value, Series) else value
        ranges[name] = (at, at)
    return undefined(drive.text, ranges)


def _at(value: float | Series, t: float) -> float:
    return float(value.at(t)) if isinstance(value, Series) else value


def _ranges(drive: Drive, t: Bounds, angle: Bounds, rate: Bounds) -> dict[str, Bounds]:
    return {"t": t} if drive.joint is None else {"t": t, "angle": angle, "rate": rate}


def _refusal(drive: Drive, found: Undefined, when: str) -> ExpressionError:
    return ExpressionError(
        f"{drive.what}: expression {drive.text!r} has no value {when}: {found.reason}; keep it in its domain, as by "
        "max(…) or min(…), or end the run before"
    )
