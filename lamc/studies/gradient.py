"""`Result.gradient`: derivatives of a measure of a run by any number of parameters, by the run's own steps backwards.

In: a taped result, a measure, names. Out: a `Gradient`. The cost is that of some evaluations for each stage of the
run, whatever the number of names; sensitivities, which give derivatives of all outputs, cost more with each. Never:
runs anything.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from lamc.basics.errors import ExpressionError, RequestError, SimulationError
from lamc.basics.readonly import ReadOnlyDict
from lamc.records.series import Series
from lamc.run.derivatives import ANGLES, RATES
from lamc.run.gradients import Gradient, by_names, checked_tape, pulled_back
from lamc.run.quantity_slopes import moved_beside, weights_of
from lamc.run.result import Result
from lamc.run.taping import Tape
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
    """As of `Result.gradient`; given: what was varied, SI, by name, where the measure names it; else the run's own."""
    tape = checked_tape(result)
    simulator = tape.simulator
    units, own = _own(tape)
    measure = _checked(measure, simulator, units)
    given = {**own, **given}
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


def _own(tape: Tape) -> tuple[dict[str, str], dict[str, float]]:
    """Units and values, SI, of what a measure can name beside outputs, by name: dimensions of the design, and
    parameters that the run was given, which do not follow from them."""
    simulator, model = tape.simulator, tape.motion.model
    source = simulator.mechanism.design or simulator.mechanism
    units = {name: each.unit for name, each in source.parameters.items()}
    own = {name: each.default for name, each in source.parameters.items()}
    for name, said in tape.parameters.items():
        if name in simulator.parameters and not isinstance(said, Series):
            units[name] = simulator.parameter_units[name]
            own[name] = float(tape.motion.parameters[model.parameters.index(name)])
    return units, own


def _checked(measure: object, simulator: "Simulator", units: Mapping[str, str]) -> Measure:
    if callable(measure):
        measure = Measure.of_function(measure)
    made = measure if isinstance(measure, Measure) else _parsed(measure, simulator, units)
    if made.function is not None:
        raise RequestError(
            f"the measure {made.text!r} is a function, whose derivatives are not known; write it as text, such as "
            "'max(tip.z)', or take sensitivities"
        )
    return made


def _parsed(text: object, simulator: "Simulator", units: Mapping[str, str]) -> Measure:
    outputs = outputs_of(simulator)
    own = {name: unit for name, unit in units.items() if name not in outputs.units}
    try:
        return Measure.parse(text, replace(outputs, varied=own))  # type: ignore[arg-type]
    except ExpressionError as error:
        name = next((name for name in simulator.parameters if f"is named {name!r}" in error.message), None)
        if name is None:
            raise
        raise RequestError(
            f"{name!r} is a parameter of the model, and a measure can name it where the run was given it: "
            f"sim.run(parameters={{{name!r}: …}}, taped=True)"
        ) from error
