"""Inputs that follow series, for the independent cross-checks: between two rows an input is a polynomial in t.

In: series, and what makes a cross-check of effects. Out: a cross-check for every time, made of effects in which the
polynomials of that time are written where the inputs stand. Splines come from another basis (B-splines, by scipy) than
those that the C looks up, and nothing is shared with the runtime's look-up.
"""

import inspect
from bisect import bisect_right
from collections.abc import Callable, Iterable, Mapping
from typing import Any

import numpy as np
from scipy.interpolate import PPoly, make_interp_spline

from lamc.records.mechanism import Mechanism
from lamc.records.series import Series
from lamc.reference.inputs import with_inputs

_KEPT = 64  # cross-checks of pieces that were met last


class _Table:
    """One series as text."""

    def __init__(self, series: Series) -> None:
        self._series = series
        self.times = series.t.tolist()
        if series.hold == "cubic" and len(self.times) > 1:
            count = len(self.times)
            ends = "clamped" if series.beyond == "hold" else None
            degree = 3 if ends is not None else min(3, count - 1)
            spline = make_interp_spline(series.t, series.values, k=degree, bc_type=ends)
            self._local = PPoly.from_spline(spline)

    def piece(self, t: float) -> int:
        """Which rows t lies between: 0 is before the first."""
        times = self.times
        if t == times[-1] and self._series.beyond == "refuse" and self._series.hold != "previous":
            return len(times) - 1
        return bisect_right(times, t)

    def text(self, piece: int) -> str:
        """The polynomial in t, Horner's way."""
        values, count = self._series.values, len(self.times)
        if piece in (0, count) or self._series.hold == "previous":
            return repr(float(values[max(piece - 1, 0)]))
        start = self.times[piece - 1]
        rows = self._coefficients(piece)
        text = repr(rows[-1])
        for each in reversed(rows[:-1]):
            text = (
                f"({each!r} + (t - ({start!r}))*{text})"
                if text[0] == "("
                else f"({each!r} + (t - ({start!r}))*({text}))"
            )
        return text

    def _coefficients(self, piece: int) -> list[float]:
        a, b = self.times[piece - 1], self.times[piece]
        values = self._series.values
        if self._series.hold == "linear":
            return [float(values[piece - 1]), float((values[piece] - values[piece - 1]) / (b - a))]
        middle = 0.5 * (a + b)
        degree = self._local.c.shape[0] - 1
        at = [
            float(self._local(middle, nu=k)) / float(np.prod(np.arange(1, k + 1))) for k in range(degree + 1)
        ]
        shifted = np.polynomial.Polynomial(at)(np.polynomial.Polynomial([a - middle, 1.0]))
        return [float(c) for c in shifted.coef]


class Followed:
    """Stands for a cross-check: what takes a time t is asked of the one that holds at t, all else of the one at 0."""

    def __init__(self, make: Callable[[Mapping[str, str]], Any], series: Mapping[str, Series]) -> None:
        self._make = make
        self._tables = {name: _Table(each) for name, each in series.items()}
        self._made: dict[tuple[int, ...], Any] = {}

    def at(self, t: float) -> Any:
        """The cross-check at t, s."""
        key = tuple(table.piece(t) for table in self._tables.values())
        if key not in self._made:
            if len(self._made) >= _KEPT:
                self._made.clear()
            texts = {n: table.text(k) for (n, table), k in zip(self._tables.items(), key, strict=True)}
            self._made[key] = self._make(texts)
        return self._made[key]

    def __getattr__(self, name: str) -> Any:
        first = getattr(self.at(0.0), name)
        if not callable(first) or "t" not in inspect.signature(first).parameters:
            return first
        signature = inspect.signature(first)

        def asked(*args: Any, **named: Any) -> Any:
            given = signature.bind(*args, **named)
            given.apply_defaults()
            return getattr(self.at(float(given.arguments["t"])), name)(*args, **named)

        return asked


def following(
    make: Callable[[tuple[Any, ...]], Any],
    mechanism: Mechanism,
    effects: Iterable[Any],
    inputs: Mapping[str, float],
    series: Mapping[str, Series],
) -> Any:
    """What `make` makes of the effects with numbers where inputs stand, and what each series comes to."""
    effects = tuple(effects)
    if not series:
        return make(with_inputs(mechanism, effects, inputs))
    return Followed(lambda texts: make(with_inputs(mechanism, effects, {**inputs, **texts})), series)
