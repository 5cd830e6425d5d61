"""Derivatives of a number of a run by the quantities of its rows, as derivatives by states, poses and energies.

In: a result, and derivatives by quantities (m,), by name. Out: `Weights`; and what a dimension does to positions
beside the motion: places of points and of bodies that stand still follow from the drawing. Raises RequestError for
quantities that have no gradient. Never: evaluates a pose.
"""

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from lamc.basics.errors import RequestError
from lamc.run.gradients import Weights
from lamc.run.quantities import AXES, ENERGY
from lamc.run.request import Array
from lamc.run.sensitivities import drawn_beside

if TYPE_CHECKING:
    from lamc.run.result import Result


class _Weighing:
    """What quantities come to, one after the other."""

    def __init__(self, result: "Result") -> None:
        model, m = result.motion.model, len(result.t)
        self.result, self.model = result, model
        self.states = np.zeros((m, model.state_size))
        self.poses = np.zeros((m, len(model.bodies), 12))
        self.energies = np.zeros((m, len(model.energies)))
        self.positions: dict[str, Array] = {}

    def add(self, name: str, weight: Array) -> None:
        """In the order of `quantities`, which says what a name means."""
        result, nq = self.result, self.result.q.shape[1]
        coordinates = [c.name for c in result.coordinates]
        rates = [f"{joint}.rate" for joint in result.joints]
        others = [rate.name for rate in result.rates[len(result.joints) :]]
        base, _, axis = name.rpartition(".")
        is_place = axis in AXES
        if name in result.hinges and name in coordinates:
            self.states[:, coordinates.index(name)] += weight
        elif is_place and base in (point.name for point in result.points):
            self._point(base, AXES.index(axis), weight)
        elif name in coordinates:
            self.states[:, coordinates.index(name)] += weight
        elif name in rates:
            self.states[:, nq + rates.index(name)] += weight
        elif name in others:
            self.states[:, nq + len(result.joints) + others.index(name)] += weight
        elif is_place and base in result.bodies:
            self._body(base, AXES.index(axis), weight)
        elif name == ENERGY:
            self.energies += weight[:, None]
        elif (effect := name.removeprefix("energy.")) in self.model.energies:
            self.energies[:, self.model.energies.index(effect)] += weight
        elif name != "t":
            raise RequestError(
                f"there is no gradient of {name!r}; take sensitivities, or differences of runs"
            )

    def _point(self, name: str, axis: int, weight: Array) -> None:
        (point,) = (each for each in self.result.points if each.name == name)
        self.positions[f"{name}.{AXES[axis]}"] = weight
        if point.body in self.model.bodies:
            local = np.array(point.point) - self.result.mechanism.body(point.body).com
            pose = self.poses[:, self.model.bodies.index(point.body)]
            pose[:, axis] += weight
            pose[:, 3 + 3 * axis : 6 + 3 * axis] += weight[:, None] * local

    def _body(self, name: str, axis: int, weight: Array) -> None:
        self.positions[f"{name}.{AXES[axis]}"] = weight
        if name in self.model.bodies:
            self.poses[:, self.model.bodies.index(name), axis] += weight


def weights_of(result: "Result", by_quantities: Mapping[str, Array]) -> Weights:
    """What a number weighs the rows with, whose derivatives by quantities these are."""
    weighing = _Weighing(result)
    for name, weight in by_quantities.items():
        if np.any(weight):
            weighing.add(name, weight)
    poses, energies = weighing.poses, weighing.energies
    return Weights(
        weighing.states,
        poses if np.any(poses) else None,
        energies if np.any(energies) else None,
        weighing.positions,
    )


def moved_beside(result: "Result", weights: Weights, name: str) -> float:
    """What a dimension does to positions at a given motion."""
    if not weights.positions:
        return 0.0
    assert result.tape is not None
    total = 0.0
    for share, mechanism in drawn_beside(result.tape.simulator, name):
        at = replace(result, mechanism=mechanism, sensitivities=None, tape=None)
        values = (float(weight @ at.quantity(each).values) for each, weight in weights.positions.items())
        total += share * sum(values)
    return total
