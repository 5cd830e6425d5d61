"""Outputs of a linear model: how quantities of a result change with the state and with parameters.

In: names as `Result.quantity` has them. Out: rows of C and D. Never: evaluates forces.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from lamc.basics.checks import did_you_mean, shown
from lamc.basics.errors import RequestError
from lamc.records.scene import OutputPoint
from lamc.run.as_result import as_result
from lamc.run.at_rest import Stand
from lamc.run.chart import Chart, rate_names
from lamc.run.model import Motion
from lamc.run.quantities import AXES, units_of
from lamc.run.request import Array
from lamc.run.ridders import derivative

if TYPE_CHECKING:
    from lamc.run.simulator import Simulator

_WIDTH = 0.02  # rad, or of the size: of the widest difference; poses are smooth over a radian
_ROUGH = ("constraint_error",)  # has no derivative where it is zero


@dataclass(frozen=True, eq=False)
class Outputs:
    """names with units, and how they are had."""

    simulator: "Simulator"
    stand: Stand
    chart: Chart
    names: tuple[str, ...]
    units: tuple[str, ...]

    def values(self) -> Array:
        """(outputs,): at the equilibrium."""
        here = self.stand.rest.row(self.stand.q)
        if not self.names:
            return np.zeros(0)
        return self._values(self.stand.rest.motion, here, self.names)[:, 0]

    def by_state(self) -> tuple[Array, float]:
        """C (outputs, 2 k), and the largest estimate of an error in it."""
        chart, k = self.chart, len(self.chart.chosen)
        found, error = np.zeros((len(self.names), 2 * k)), 0.0
        known = self._exact()
        for row, name in enumerate(self.names):
            if name in known:
                found[row] = known[name]
        rest = [row for row, name in enumerate(self.names) if name not in known]
        if rest and k:
            here = self.stand.rest.row(self.stand.q)
            moves = np.zeros((2 * k, here.shape[1]))
            moves[:k, : self.stand.rest.nq], moves[k:, self.stand.rest.nq :] = chart.flow.T, chart.follow.T
            per_radian = self.stand.rest.per_radian[list(chart.chosen)]
            lengths = np.tile(per_radian, 2)[:, None]
            names = [self.names[row] for row in rest]
            slopes, error = derivative(
                lambda x: self._values(self.stand.rest.motion, here + x * lengths * moves, names),
                0.0,
                self.stand.width(_WIDTH),
            )
            found[rest] = slopes / lengths.T
        return found, error

    def by_parameter(self, differentiate: Callable[[Callable[[Motion], Array]], Array]) -> Array:
        """A column (outputs,) of D. differentiate: a function of the motion, by the parameter."""
        here, known = self.stand.rest.row(self.stand.q), self._exact()
        names = [name for name in self.names if name not in known]
        found = np.zeros(len(self.names))
        if names:
            rows = [row for row, name in enumerate(self.names) if name not in known]
            found[rows] = differentiate(lambda motion: self._values(motion, here, names)[:, 0])
        return found

    def _values(self, motion: Motion, rows: Array, names: Sequence[str]) -> Array:
        """(names, m)."""
        times = np.full(len(rows), self.stand.rest.t)
        result = as_result(self.simulator, motion, times, rows, "")
        return np.array([result.quantity(name).values for name in names])

    def _exact(self) -> dict[str, Array]:
        """Rows of C of what the state tells itself."""
        rest, chart = self.stand.rest, self.chart
        none = np.zeros(len(chart.chosen))
        coordinates = {
            c.name: np.append(row, none)
            for c, row in zip(rest.motion.model.coordinates, chart.flow, strict=True)
        }
        rates = {name: np.append(none, row) for name, row in zip(rate_names(rest), chart.follow, strict=True)}
        return {**rates, **coordinates}


def outputs_of(simulator: "Simulator", stand: Stand, chart: Chart, names: Sequence[str] | None) -> Outputs:
    """Raises RequestError for what is no quantity of the results, with the nearest."""
    units = {**dict(zip(rate_names(stand.rest), (r.unit for r in simulator.rates), strict=True))}
    units |= {name: unit for name, unit in units_of(simulator).items() if name not in _ROUGH}
    if isinstance(names, str) or not isinstance(names, Sequence | None):
        raise RequestError(f"outputs is {shown(names)}; it must be a list of names, such as ['h1', 'tip.x']")
    for name in names or ():
        if name not in units:
            raise RequestError(f"outputs has {shown(name)}; {did_you_mean(str(name), list(units))}")
    chosen = tuple(names) if names is not None else _usual(simulator)
    return Outputs(simulator, stand, chart, chosen, tuple(units[name] for name in chosen))


def _usual(simulator: "Simulator") -> tuple[str, ...]:
    """The scene's outputs, or all joints."""
    found: list[str] = []
    for each in simulator.scene.outputs or simulator.joints:
        found += [f"{each.name}.{a}" for a in AXES] if isinstance(each, OutputPoint) else [each]
    return tuple(found)
