"""Linear models about an equilibrium: x' = A x + B w, y = C x + D w, in independent coordinates.

In: a simulator, an `Equilibrium`, names of parameters and of quantities. Out: a `LinearModel`. Never: integrates.

x holds deviations of k independent positions, then of their rates. At rest in balance the tangent of the closed
positions may be taken as it stands: what its turning would add is multiplied by rates and accelerations that are zero.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, fields
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from lamc.basics.brief import brief
from lamc.basics.checks import did_you_mean, shown
from lamc.basics.errors import LamcError, RequestError, SimulationError
from lamc.basics.readonly import ReadOnlyDict
from lamc.basics.threads import on_one_thread
from lamc.run.at_rest import Stand
from lamc.run.chart import Chart, chart_of
from lamc.run.equilibrium import Equilibrium
from lamc.run.linear_outputs import outputs_of
from lamc.run.model import Motion, Unchanging
from lamc.run.request import Array
from lamc.run.ridders import derivative_any

if TYPE_CHECKING:
    from scipy.signal import StateSpace

    from lamc.run.simulator import Simulator

_CLOSED = 1e-13  # rad, or of the size: what a parameter may open the loops by


@dataclass(frozen=True, eq=False)
class LinearModel(Unchanging):
    """x' = A x + B w and y = C x + D w, of deviations from an equilibrium, SI units.

    A, B, C, D   (2k, 2k), (2k, inputs), (outputs, 2k), (outputs, inputs)
    states       names: k independent positions, then their rates; state_units
    inputs       names of parameters; input_units
    outputs      names of quantities; output_units
    offset       (outputs,): values at the equilibrium, to which y is added
    errors       largest estimates of an entry's error by matrix, "A", "B", "C", "D"; 0: derivatives are exact but for
                 round-off
    """

    A: Array
    B: Array
    C: Array
    D: Array
    states: tuple[str, ...]
    state_units: tuple[str, ...]
    inputs: tuple[str, ...]
    input_units: tuple[str, ...]
    outputs: tuple[str, ...]
    output_units: tuple[str, ...]
    offset: Array
    errors: Mapping[str, float]
    point: Equilibrium = field(repr=False)

    def __reduce__(self) -> tuple[Any, ...]:
        return partial(type(self), **{each.name: getattr(self, each.name) for each in fields(self)}), ()

    def __post_init__(self) -> None:
        for matrix in (self.A, self.B, self.C, self.D, self.offset):
            matrix.flags.writeable = False

    def __repr__(self) -> str:
        pairs = zip(self.states, self.state_units, strict=True)
        states = ", ".join(f"{name} {unit}" for name, unit in pairs)
        return brief("LinearModel", "", f"states {states}", f"inputs {', '.join(self.inputs) or 'none'}")

    def state_space(self) -> "StateSpace":
        """A `scipy.signal.StateSpace`; for python-control: `control.ss(m.A, m.B, m.C, m.D)`, or `to_control`."""
        from scipy.signal import StateSpace

        if not self.inputs or not self.outputs:
            raise RequestError("a state space needs an input and an output; linearise with inputs=[…]")
        return StateSpace(self.A, self.B, self.C, self.D)

    def to_control(self) -> object:
        """A `control.StateSpace` of python-control, with all names, where it has no dots: "h1_rate". Raises LamcError
        where it is not installed."""
        try:
            import control
        except ImportError as error:
            raise LamcError("python-control is not installed; pip install control") from error
        named = {"states": self.states, "inputs": self.inputs, "outputs": self.outputs}
        names = {what: [name.replace(".", "_") for name in each] for what, each in named.items()}
        return control.ss(self.A, self.B, self.C, self.D, **names)


@on_one_thread
def linear_model_of(
    simulator: "Simulator",
    point: Equilibrium,
    inputs: Sequence[str] | None,
    outputs: Sequence[str] | None,
    independent: Sequence[str] | None,
) -> LinearModel:
    """As `Simulator.linearise`."""
    check_point(simulator, point)
    stand, chart = point.stand, chart_of(point.stand, independent)
    chosen = _inputs(simulator, inputs)
    told = outputs_of(simulator, stand, chart, outputs)
    a, a_error = system_of(stand, chart)
    b, d, b_error, d_error = _by_parameters(stand, chart, chosen, told.by_parameter, len(told.names))
    c, c_error = told.by_state()
    return LinearModel(
        A=a,
        B=b,
        C=c,
        D=d,
        states=(*chart.positions, *chart.rates),
        state_units=(*chart.position_units, *chart.rate_units),
        inputs=chosen,
        input_units=tuple(simulator.parameter_units[name] for name in chosen),
        outputs=told.names,
        output_units=told.units,
        offset=told.values(),
        errors=ReadOnlyDict({"A": a_error, "B": b_error, "C": c_error, "D": d_error}),
        point=point,
    )


def check_point(simulator: "Simulator", point: object) -> None:
    """Raises RequestError for what is no equilibrium of this simulator."""
    if not isinstance(point, Equilibrium):
        raise RequestError(
            f"point is {shown(point)}; it must be an equilibrium, as sim.equilibrium() finds it: about a position that "
            "accelerates, or moves, the linear model changes with time"
        )
    if point.motion.model.digest != simulator.model.digest:
        raise RequestError("point is an equilibrium of another simulator; find one of this")


def system_of(stand: Stand, chart: Chart) -> tuple[Array, float]:
    """A (2k, 2k), and an estimate of its error; 0 where the model has exact derivatives."""
    k, own = len(chart.chosen), stand.tangent[list(chart.chosen)]
    by_positions, by_rates, error = stand.slopes
    back = np.linalg.inv(own) if k else np.zeros((0, 0))
    lower = np.hstack([own @ by_positions @ back, own @ by_rates @ back])
    upper = np.hstack([np.zeros((k, k)), np.eye(k)])
    return np.vstack([upper, lower]), error


def _inputs(simulator: "Simulator", inputs: Sequence[str] | None) -> tuple[str, ...]:
    if inputs is None:
        return simulator.inputs
    if isinstance(inputs, str) or not isinstance(inputs, Sequence):
        raise RequestError(f"inputs is {shown(inputs)}; it must be a list of names, such as ['drive']")
    for name in inputs:
        if name not in simulator.parameters:
            raise RequestError(
                f"inputs has {shown(name)}; {did_you_mean(str(name), list(simulator.parameters))}"
            )
    return tuple(inputs)


def _by_parameters(
    stand: Stand,
    chart: Chart,
    names: Sequence[str],
    outputs: Callable[[Callable[[Callable[[Motion], Array]], Array]], Array],
    count: int,
) -> tuple[Array, Array, float, float]:
    """B, D, and estimates of their errors."""
    k, errors = len(chart.chosen), {"B": 0.0, "D": 0.0}
    b, d = np.zeros((2 * k, len(names))), np.zeros((count, len(names)))
    here = stand.rest.row(stand.q)
    for column, name in enumerate(names):
        vary = _Varied(stand, name)

        def by(function: Callable[[Motion], Array], what: str, vary: "_Varied" = vary) -> Array:
            found, error = derivative_any(lambda x: function(vary.motion(x)), vary.value)
            if not np.isfinite(error):
                raise SimulationError(
                    f"accelerations or outputs have no derivative by parameter {vary.name!r} at {vary.value:g}; leave "
                    "it out of the inputs"
                )
            errors[what] = max(errors[what], error)
            return found

        def pushed(motion: Motion) -> Array:
            return motion.accelerations(np.array([stand.rest.t]), here)[0, list(chart.chosen)]

        vary.check_closed()
        b[k:, column] = by(pushed, "B")
        d[:, column] = outputs(lambda function, by=by: by(function, "D"))  # type: ignore[misc]
    return b, d, errors["B"], errors["D"]


class _Varied:
    """A motion with one parameter that varies; nothing checks its value, so that a damping may be less than zero."""

    def __init__(self, stand: Stand, name: str) -> None:
        self.name, self._stand = name, stand
        self._k = stand.rest.motion.model.parameters.index(name)
        self.value = float(stand.rest.motion.parameters[self._k])

    def motion(self, value: float) -> Motion:
        motion = self._stand.rest.motion
        parameters = motion.parameters.copy()
        parameters[self._k] = value
        return Motion(motion.model, parameters, series=motion.following.series)

    def check_closed(self) -> None:
        """Raises RequestError for a parameter that opens the loops."""
        model, here = self._stand.rest.motion.model, self._stand.rest.row(self._stand.q)
        if not model.cuts:
            return
        moved = self.motion(self.value + 1e-3 * (abs(self.value) or 1.0))
        gaps = [m.closures(here)[0, : model.closure_count] for m in (moved, self._stand.rest.motion)]
        if np.abs(gaps[0] - gaps[1]).max(initial=0.0) > _CLOSED:
            raise RequestError(
                f"parameter {self.name!r} changes the shape of the loops, and is no input of a linear model"
            )
