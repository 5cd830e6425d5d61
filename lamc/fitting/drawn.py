"""How a model follows from a dimension of its drawing: by the drawings beside it.

In: simulators of the drawing with a dimension a little smaller and larger, weights. Out: derivatives of the numbers
that the equations take of a drawing, and a motion that knows them. A drawing has no noise, as a run has, so that
differences of it are nearly exact: two points 1e-4 apart err by 1e-8, four that are 2e-3 apart by 1e-11.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from lamc.basics.errors import RequestError
from lamc.mechanics.tangents import PACE, Columns, parameter_key
from lamc.records.series import Series
from lamc.run.model import Model, Motion
from lamc.run.request import Array
from lamc.run.simulator import Simulator
from lamc.symbolic.staging import DrawnKey


@dataclass(frozen=True, eq=False)
class Drawn:
    """A dimension.

    weights     (k,): of what the simulators beside have: the sum is the derivative by the dimension
    simulators  of the drawings beside
    starts      (k, n): where their runs start
    """

    weights: Array
    simulators: tuple[Simulator, ...]
    starts: Array

    @property
    def start(self) -> Array:
        """(n,): how the start follows from the dimension."""
        found: Array = self.weights @ self.starts
        return found


def moving(
    simulator: Simulator,
    columns: Columns,
    drawn: Mapping[str, Drawn],
    parameters: Mapping[str, float | Series],
) -> tuple[Model, Motion, Array]:
    """The model with derivatives by columns, its motion, and directions (columns, inputs): how these move what `setup`
    is given. Raises RequestError where a drawing beside has other equations."""
    model, keys = simulator.with_columns(columns)
    motion = model.motion(parameters)
    inputs = motion.parameters.copy()
    directions = np.zeros((max(len(columns.names), 1), max(len(inputs), 1)))
    for row, name in enumerate(columns.parameters):
        directions[row, model.parameters.index(name)] = 1.0
    given = [k for k, name in enumerate(model.parameters) if name in parameters]
    paces = {
        name: _pace(simulator, columns, keys, name, drawn[name], len(inputs)) for name in columns.dimensions
    }
    for row, name in enumerate(columns.dimensions, len(columns.parameters)):
        paces[name][given] = 0.0  # what is given does not follow from the drawing
        directions[row] = paces[name]
    place = {parameter_key(name): k for k, name in enumerate(model.parameters)}
    place |= {key: len(model.parameters) + k for k, key in enumerate(keys)}
    for key, k in place.items():
        if key[0] == PACE:
            inputs[k] = paces[str(key[1])][place[key[2:]]]
    return model, Motion(model, inputs, 0.0, motion.following.series), directions


def _pace(
    simulator: Simulator,
    columns: Columns,
    keys: tuple[DrawnKey, ...],
    name: str,
    drawn: Drawn,
    count: int,
) -> Array:
    """Derivatives (inputs,) of what `setup` is given by a dimension."""
    found = np.zeros(count)
    for weight, other in zip(drawn.weights, drawn.simulators, strict=True):
        if other.structure != simulator.structure:
            raise RequestError(f"beside its value {name!r} makes a device of another structure")
        made, there = other.with_columns(columns)
        if there != keys:
            raise RequestError(f"beside the value of {name!r} other numbers count")
        found += weight * np.concatenate([made.defaults, made.geometry])
    return found
