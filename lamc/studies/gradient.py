"""`Result.gradient`: derivatives of a measure of a run by any number of parameters, by the run's own steps backwards.

In: a taped result, a measure, names. Out: a `Gradient`. The cost is that of some evaluations for each stage of the
run, whatever the number of names; sensitivities, which give derivatives of all outputs, cost more with each. Never:
runs anything.
"""

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from lamc.basics.errors import RequestError, SimulationError
from lamc.basics.readonly import ReadOnlyDict
from lamc.run.derivatives import ANGLES, RATES
from lamc.run.gradients import Gradient, by_names, checked_tape, pulled_back
from lamc.run.quantity_slopes import moved_beside, weights_of
from lamc.run.result import Result
from lamc.studies.measure_names import NOTHING_GIVEN
from lamc.studies.measures import Measure, outputs_of

if TYPE_CHECKING:
    from lamc.run.simulator import Simulator


def gradient(
    result: Result,
    measure: str | Measure,
    names: Sequence[str] | None = None,
    given: Mapping[str, float] = NOTHING_GIVEN,
) -> Gradient:
    """As of `Result.gradient`; given: what was varied, SI, by name, where the measure names it."""
    simulator = checked_tape(result).simulator
    measure = _checked(measure, simulator)
    value = measure.value(result, given)
    if not math.isfinite(value):
        raise SimulationError(f"the measure {measure.text!r} is {value}, which has no gradient")
    gathered = measure.slopes(result, given)
    weights = weights_of(result, gathered.quantities)
    found = by_names(result, names, pulled_back(result, weights))
    for name in found:
        if name not in simulator.parameters and not name.startswith((ANGLES, RATES)):
            found[name] += moved_beside(result, weights, name)
        found[name] += gathered.given.get(name, 0.0)
    return Gradient(value, measure.unit, ReadOnlyDict(found))


def _checked(measure: object, simulator: "Simulator") -> Measure:
    if callable(measure):
        measure = Measure.of_function(measure)
    made = measure if isinstance(measure, Measure) else Measure.parse(measure, outputs_of(simulator))  # type: ignore[arg-type]
    if made.function is not None:
        raise RequestError(
            f"the measure {made.text!r} is a function, whose derivatives are not known; write it as text, such as "
            "'max(tip.z)', or take sensitivities"
        )
    return made
