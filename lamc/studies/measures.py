"""Measures: one number of a run, such as "max(tip.z)" or what a Python function of the result gives.

In: text, or a function, and what a simulator's runs tell (`outputs_of`). Out: `Measure`s, which give a number of a
result. Text passes a grammar of its own (`measure_text`), and unknown names are refused when it is read, before any
run. Never: runs anything.

Averages over time are by the trapezoidal rule on the rows of the result. Extremes, crossings and values between rows
are those of the cubic through the four nearest rows (`samples`); what happens between rows and leaves no trace on them
is not seen.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any

from lamc.basics.checks import shown
from lamc.basics.errors import ExpressionError, RequestError, warn
from lamc.basics.once import lazy
from lamc.run.quantities import units_of
from lamc.run.result import Result
from lamc.run.simulator import Simulator
from lamc.studies.dimensions import unit_of
from lamc.studies.measure_names import NOTHING_GIVEN
from lamc.studies.measure_names import Outputs as Outputs
from lamc.studies.measure_slopes import Gathered
from lamc.studies.measure_terms import Rows, Term
from lamc.studies.measure_text import read

Function = Callable[[Result], float]


def outputs_of(simulator: Simulator) -> Outputs:
    """Quantities as `Result.quantity` names them; "energy.NAME" for what an effect stores, and the time, "t"."""
    named = units_of(simulator)
    joints = {joint.name for joint in simulator.mechanism.joints}
    if "t" in named:
        warn(
            "measures take t for the time, and a hinge or coordinate is named so too: rename it to measure it"
        )
    for hinge in sorted(joints):
        if f"{hinge}.rate" in joints:
            warn(
                f"measures take {hinge}.rate for the hinge of this name, not for the rate of {hinge}: rename one"
            )
    energies = {f"energy.{name}": "J" for name in simulator.model.energies}
    return Outputs({**named, **energies, "t": "s"}, simulator.model.guards)


@dataclass(frozen=True)
class Measure:
    """A number of a run.

    text   as it was written, or the name of the function
    unit   SI, as "N·m"; "1" for a plain number
    times  at which it asks for values, s: a run that has rows there answers exactly
    """

    text: str
    unit: str
    times: tuple[float, ...] = ()
    known: Outputs = field(default=Outputs({}), repr=False)  # of the names in it
    function: Function | None = field(default=None, repr=False)

    @classmethod
    def parse(cls, text: str, outputs: Outputs | Simulator) -> "Measure":
        """The measure of a text. Raises ExpressionError, with the column, for what is outside the language, for unknown
        outputs and events, with the nearest, and for units that do not fit."""
        if not isinstance(text, str):
            raise ExpressionError(f"a measure is {shown(text)}; it must be text, such as 'max(tip.z)'")
        known = outputs if isinstance(outputs, Outputs) else outputs_of(outputs)
        term = read(text, known)
        return cls(text, term.unit.text, tuple(sorted(set(term.times))), known.of(term.names))

    @classmethod
    def of_function(cls, function: Function, unit: str = "1") -> "Measure":
        """The measure that a function of the result gives, in `unit`."""
        if not callable(function):
            raise RequestError(
                f"a measure is {shown(function)}; it must be text, a function of the result, or (function, unit)"
            )
        return cls(getattr(function, "__qualname__", type(function).__name__), unit, function=function)

    def value(self, result: Result, given: Mapping[str, float] = NOTHING_GIVEN) -> float:
        """The number of this run, in `unit`; NaN where there is none, as the time of what does not happen. given: what
        was varied for it, SI, by name."""
        if self.function is not None:
            return _as_number(self.function(result), self.text)
        if not len(result.t):
            return math.nan
        return float(self._term.value(Rows.of(result, given)))

    def slopes(self, result: Result, given: Mapping[str, float] = NOTHING_GIVEN) -> Gathered:
        """Its derivatives by quantities of this run, and by what was varied. Raises NoSlopeError where it has none."""
        assert self.function is None, "functions have no derivatives"
        gathered = Gathered()
        self._term.slope(Rows.of(result, given), 1.0, gathered)
        return gathered

    @lazy
    def _term(self) -> Term:
        return read(self.text, self.known)

    def __reduce__(self) -> tuple[Any, ...]:
        return partial(Measure, self.text, self.unit, self.times, self.known, self.function), ()


def checked_measures(measures: object, outputs: Outputs) -> dict[str, Measure]:
    """Measures by name: of texts, functions, (function, unit), or measures; a sequence of texts are their own names.

    Raises RequestError and ExpressionError for what is none.
    """
    if isinstance(measures, str):
        measures = [measures]
    if isinstance(measures, Sequence):
        if not all(isinstance(each, str) for each in measures):
            raise RequestError("measures without names must be texts; else give a dict of them by name")
        measures = {text: text for text in measures}
    if not isinstance(measures, Mapping) or not measures:
        raise RequestError(
            f"measure is {shown(measures)}; it must map names to measures, {{'top': 'max(tip.z)'}}"
        )
    return {_name(name): _measure(each, outputs) for name, each in measures.items()}


def _measure(given: object, outputs: Outputs) -> Measure:
    if isinstance(given, Measure):
        return given
    if isinstance(given, str):
        return Measure.parse(given, outputs)
    if isinstance(given, tuple) and len(given) == 2 and isinstance(given[1], str):
        return Measure.of_function(given[0], unit_of(given[1]).text)
    return Measure.of_function(given)  # type: ignore[arg-type]


def _name(name: object) -> str:
    if not isinstance(name, str) or not name.strip() or not name.isprintable():
        raise RequestError(f"a measure is named {shown(name)}; a name is text that prints")
    return name


def _as_number(value: object, name: str) -> float:
    try:
        number = float(value)  # type: ignore[arg-type]
    except (TypeError, ValueError, OverflowError) as error:
        raise RequestError(f"the measure {name!r} gives {shown(value)}; it must give one number") from error
    return number
