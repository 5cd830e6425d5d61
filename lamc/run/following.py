"""Inputs that follow series in a run: which ones, whether they reach over the run, and where steps end for them.

In: series by name, and what the model reads of them. Out: checked series in the model's order, times of breaks, and the
C record of both. Never: looks up a value; C does.

A step ends where an input jumps, or has a kink, that the run could see. A table of a smooth signal has a kink at every
row, and most are nothing: between two rows the table is off a smooth curve through it by no more than the jump of its
slope times their distance over 8. Where that is less than the run's rtol times the range of the input, no step ends. So
a table of more rows takes no more steps, once it is as smooth as the run is accurate. The derivative is compared that
the equations hold: of the motion of a base, the second.
"""

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise
from typing import Any

import numpy as np

from lamc.basics.checks import did_you_mean, shown
from lamc.basics.errors import DesignError, RequestError, about, warn
from lamc.records.inputs import rough
from lamc.records.scene import Scene
from lamc.records.series import Series
from lamc.run.request import Array, Request

MANY = 10_000  # steps that end at breaks, from which on a run is told to be slow for them
_ROUND_OFF = 16.0 * np.finfo(np.float64).eps


def series_of(scene: Scene) -> dict[str, Series]:
    """What the inputs of a scene follow, by name."""
    return {name: each.series for name, each in scene.inputs.items() if each.series is not None}


def with_series(
    parameters: Mapping[str, Any],
    given: Mapping[str, Any] | None,
    known: Sequence[str],
    inputs: Collection[str],
) -> Mapping[str, Any]:
    """`parameters` with the series given for one run, by name. known: inputs that follow series; inputs: all.

    Raises RequestError for what are no series, and for inputs that follow none.
    """
    if given is None:
        return parameters
    if not isinstance(given, Mapping):
        raise RequestError(f"series is {shown(given)}; it must map names of inputs to lamc.Series(…)")
    for name, each in given.items():
        if name not in known:
            hint = (
                "give it one in the scene, as by lamc.Input(series=lamc.Series.constant(0.0)), and runs may replace it"
                if name in inputs
                else did_you_mean(str(name), list(known))
            )
            raise RequestError(f"no input {shown(name)} of the scene follows a series; {hint}")
        if not isinstance(each, Series):
            raise RequestError(f"series {name!r} is {shown(each)}; make one with lamc.Series(t, values)")
    return {**parameters, **given}


def parted(
    parameters: Mapping[str, Any], names: Sequence[str], own: Mapping[str, Series], orders: Sequence[int]
) -> tuple[Mapping[str, Any], tuple[Series, ...]]:
    """Parameters that are numbers, and the series that inputs follow, in the order of `names`: those given among the
    parameters, a number for a constant, else their own.

    Raises RequestError where a series is missing, or has no derivative that the equations hold.
    """
    if not names or not isinstance(parameters, Mapping):
        return parameters, ()
    found = []
    for name, order in zip(names, orders, strict=True):
        each = parameters.get(name, own.get(name))
        if isinstance(each, int | float) and not isinstance(each, bool) and math.isfinite(each):
            each = Series.constant(each)
        if not isinstance(each, Series):
            what = "missing" if each is None else shown(each)
            raise RequestError(
                f"the series of the input {name!r} is {what}; give series={{{name!r}: lamc.Series(…)}}"
            )
        if each.smoothness < order:
            text = rough(name, each, order, "what moves with it")
            if each is not own.get(name):
                raise RequestError(text)
            with about(("inputs", name)):
                raise DesignError(text)
        found.append(each)
    return {name: value for name, value in parameters.items() if name not in names}, tuple(found)


@dataclass(frozen=True, eq=False)
class Following:
    """The series of one motion, in the order of the model's inputs, and the highest derivative of each that
    accelerations hold. own: those of the scene, for messages."""

    names: tuple[str, ...] = ()
    series: tuple[Series, ...] = ()
    orders: tuple[int, ...] = ()
    own: Mapping[str, Series] | None = None

    def check_run(self, t_end: float) -> None:
        """Raises DesignError, about the input, or RequestError if it was given for this run, where a series does not
        reach from 0 to t_end, s."""
        for name, each in zip(self.names, self.series, strict=True):
            begin, end = each.pieces.begin, each.pieces.end
            if begin <= 0.0 and t_end <= end:
                continue
            what = f"starts at t = {begin:.9g} s, after the run does at 0 s" if begin > 0.0 else ""
            ends = f"ends at t = {end:.9g} s, before the run does at {t_end:.9g} s" if t_end > end else ""
            text = (
                f"the series of the input {name!r} {' and '.join(filter(None, (what, ends)))}; let it hold its first "
                "and last value there (beyond: hold), or "
                + ("shift its times" if what else f"run to {end:.9g} s at most")
            )
            if self.own is None or self.own.get(name) is not each:
                raise RequestError(text)
            with about(("inputs", name)):
                raise DesignError(text)

    def check_times(self, t: Array) -> None:
        """Raises RequestError for a time at which an input has no value."""
        for name, each in zip(self.names, self.series, strict=True):
            begin, end = each.pieces.begin, each.pieces.end
            outside = t[(t < begin) | (t > end)]
            if len(outside):
                raise RequestError(
                    f"the input {name!r} has no value at t = {float(outside.flat[0]):.9g} s; its series goes from "
                    f"{begin:.9g} s to {end:.9g} s; let it hold its first and last value beyond (beyond: hold)"
                )

    def breaks(self, rtol: float, t_start: float, t_end: float) -> Array:
        """Times within t_start … t_end at which a step ends, (k,), s, strictly ascending."""
        each = [
            _breaks(series, order, rtol, t_start, t_end)
            for series, order in zip(self.series, self.orders, strict=True)
        ]
        return np.unique(np.concatenate(each)) if each else np.zeros(0)

    def breaks_of_run(self, request: Request) -> Array:
        """`breaks` of a run. Warns where they make it long; raises RequestError where it could not take that many
        steps."""
        if not self.series:
            return np.zeros(0)
        found = self.breaks(request.rtol, request.t_start, request.t_end)
        if len(found) > MANY:
            counts = {
                name: len(_breaks(series, order, request.rtol, request.t_start, request.t_end))
                for name, series, order in zip(self.names, self.series, self.orders, strict=True)
            }
            name = max(counts, key=lambda each: counts[each])
            text = (
                f"the input {name!r} jumps or has a kink at {counts[name]} times within the run that rtol = "
                f"{request.rtol:g} can see, and a step ends at each"
            )
            out = "hold: cubic, a smoothed or a thinned series, or a larger rtol takes fewer"
            if len(found) >= request.max_steps:
                raise RequestError(f"{text}; max_steps is {request.max_steps}; {out}")
            warn(f"{text}; {out}")
        return found

    @property
    def digests(self) -> dict[str, str]:
        """Of each series, by the name of its input."""
        return {name: each.digest for name, each in zip(self.names, self.series, strict=True)}


NOTHING = Following()


@lru_cache(maxsize=64)  # fits and sweeps run over the same series again and again
def _breaks(series: Series, order: int, rtol: float, t_start: float, t_end: float) -> Array:
    pieces = series.pieces
    t = pieces.t
    if len(t) < 2:
        return np.zeros(0)
    lengths = np.diff(t)
    if math.isinf(pieces.begin):
        lengths[0] = math.inf  # the first value has held for ever
    gaps = np.minimum(lengths, np.append(lengths[1:], math.inf))  # beside rows 1, 2, …
    off = np.zeros(len(gaps))
    for power in range(order, series.degree + 1):
        jumps = np.abs(pieces.jumps(power))
        if power < series.degree:  # continuous but for round-off, save where values begin and end to hold
            inner = slice(1, -1) if math.isinf(pieces.begin) else slice(None)
            jumps[inner if power >= 2 or series.hold != "cubic" else slice(None)] = 0.0
        with np.errstate(invalid="ignore", over="ignore"):
            share = gaps ** (power - order) / (8.0 * math.factorial(power - order))
            off = np.maximum(off, jumps if power == order else np.where(jumps > 0.0, jumps * share, 0.0))
    within = (t[1:] > t_start) & (t[1:] <= t_end)
    seen = off > np.maximum(rtol * _range(series, order, t_start, t_end), _floor(series, order, gaps))
    found = t[1:][within & seen]
    found.flags.writeable = False
    return found


def _range(series: Series, order: int, t_start: float, t_end: float) -> float:
    """Between the least and the largest value of the derivative of that order within the times."""
    t = series.pieces.t
    t_start, t_end = max(t_start, float(t[0])), min(t_end, float(t[-1]))
    times = np.concatenate([[t_start, t_end], t[(t > t_start) & (t < t_end)]])
    if order == 2:  # linear between rows, and at their ends: the value before each row counts too
        times = np.concatenate([times, np.nextafter(times[1:], -math.inf)])
    values = series.at(times, order)
    values = values[np.isfinite(values)]
    return float(np.ptp(values)) if len(values) else 0.0


def _floor(series: Series, order: int, gaps: Array) -> Array:
    """What derivatives of that order have for round-off."""
    most = float(np.abs(series.values).max())
    return np.asarray(_ROUND_OFF * most / np.minimum(gaps, 1e300) ** order)


class Recorded:
    """What C follows: a `lamc_recording`, and the memory that it points to."""

    def __init__(self, ffi: Any, following: Following, breaks: Array) -> None:
        def address(array: Array) -> Any:
            return ffi.from_buffer("double[]", array)

        self._kept = [breaks, *(each.pieces for each in following.series)]
        self._series = ffi.new("lamc_series[]", len(following.series))
        for record, each in zip(self._series, following.series, strict=True):
            pieces = each.pieces
            record.count, record.width = len(pieces.t), pieces.rows.shape[1]
            record.begin, record.end = max(pieces.begin, -1e300), min(pieces.end, 1e300)
            record.t, record.rows = address(pieces.t), address(pieces.rows)
        self.handle: Any = ffi.new("lamc_recording *")
        self.handle.series = self._series
        self.handle.breaks, self.handle.break_count = address(breaks), len(breaks)


def stretches(breaks: Array, t_start: float, t_end: float) -> list[tuple[float, float]]:
    """The run in parts, from break to break."""
    ends = [t_start, *breaks.tolist(), t_end]
    return [(a, b) for a, b in pairwise(ends) if b > a]
