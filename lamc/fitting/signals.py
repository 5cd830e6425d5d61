"""What of a state is seen: angles, rates, coordinates, and points of bodies in world axes.

In: a simulator, names of columns and markers. Out: `Signals`, which give values (m, k) of states (m, n), and their
derivatives (m, k, n). Those of points are differences of poses, which are smooth functions of a state and cost no run.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from lamc.basics.checks import did_you_mean
from lamc.basics.errors import RequestError
from lamc.records.recording import Marker
from lamc.records.scene import OutputPoint
from lamc.run.model import Motion
from lamc.run.request import Array
from lamc.run.simulator import Simulator

_STEP = 1e-3  # rad or m: four points miss 1e-13 of sines and cosines, and round-off comes to as much
_AXES = ("x", "y", "z")


@dataclass(frozen=True)
class Column:
    """A coordinate or rate of the state, at its place."""

    place: int
    unit: str


@dataclass(frozen=True, eq=False)
class Point:
    """A point that moves with a body. body: its place among moving bodies, None: it stands still; arm: (3,), m, from
    the centre of mass, as drawn; axis: 0, 1, 2."""

    body: int | None
    arm: Array
    drawn: Array
    axis: int
    unit: str = "m"


Signal = Column | Point


@dataclass(frozen=True, eq=False)
class Signals:
    """Signals of one model, in the order of columns."""

    all: tuple[Signal, ...]

    @property
    def has_points(self) -> bool:
        return any(isinstance(each, Point) for each in self.all)

    def values(self, motion: Motion, t: Array, rows: Array) -> Array:
        """(m, k) of states (m, n)."""
        poses = motion.poses(t, np.ascontiguousarray(rows)) if self.has_points else None
        return np.stack([_value(each, rows, poses) for each in self.all], axis=1)

    def slopes(self, motion: Motion, t: Array, rows: Array) -> Array:
        """(m, k, n), by the state."""
        m, n = rows.shape
        found = np.zeros((m, len(self.all), n))
        for k, each in enumerate(self.all):
            if isinstance(each, Column):
                found[:, k, each.place] = 1.0
        if self.has_points:
            points = [k for k, each in enumerate(self.all) if isinstance(each, Point)]
            for j in range(len(motion.model.coordinates)):
                found[:, points, j] = self._by_coordinate(motion, t, rows, j)[:, points]
        return found

    def _by_coordinate(self, motion: Motion, t: Array, rows: Array, j: int) -> Array:
        found = np.zeros((len(rows), len(self.all)))
        for weight, offset in ((1.0, -2.0), (-8.0, -1.0), (8.0, 1.0), (-1.0, 2.0)):
            moved = rows.copy()
            moved[:, j] += offset * _STEP
            found += weight / (12.0 * _STEP) * self.values(motion, t, moved)
        return found


def _value(signal: Signal, rows: Array, poses: Array | None) -> Array:
    if isinstance(signal, Column):
        return rows[:, signal.place]
    if signal.body is None:
        return np.full(len(rows), signal.drawn[signal.axis])
    assert poses is not None
    at = poses[:, signal.body]
    rotation = at[:, 3 + 3 * signal.axis : 6 + 3 * signal.axis]
    return at[:, signal.axis] + rotation @ signal.arm


def signal_of(simulator: Simulator, name: str, markers: Mapping[str, object], what: str) -> Signal:
    """The signal of a column's name. Raises RequestError with the nearest name."""
    model = simulator.model
    for place, each in enumerate(model.coordinates):
        if each.name == name:
            return Column(place, each.unit)
    nq = len(model.coordinates)
    for place, each in enumerate(model.rates):
        if name in (each.name, f"{each.name}.rate") and not (each.name in model.joints and name == each.name):
            return Column(nq + place, each.unit)
    owner, _, axis = name.rpartition(".")
    if axis in _AXES:
        place = _AXES.index(axis)
        if owner in markers:
            return _point(simulator, Marker.of(markers[owner], owner), place, f"marker {owner!r} of {what}")
        for output in simulator.scene.outputs or ():
            if isinstance(output, OutputPoint) and output.name == owner:
                return _point(simulator, Marker(output.body, output.point), place, owner)
        if owner in simulator.bodies:
            com = tuple(float(x) for x in simulator.mechanism.body(owner).com)
            return _point(simulator, Marker(owner, com), place, owner)  # type: ignore[arg-type]
    known = [each.name for each in model.coordinates] + [f"{joint}.rate" for joint in model.joints]
    known += [f"{marker}.{each}" for marker in markers for each in _AXES]
    known += [f"{body}.{each}" for body in simulator.bodies for each in _AXES]
    raise RequestError(
        f"{what} has a column {name!r}, which is nothing of this model; {did_you_mean(name, known)}; a tracked "
        "point needs "
        "a marker: link_2@(30mm, 0, 0)"
    )


def _point(simulator: Simulator, marker: Marker, axis: int, what: str) -> Point:
    if marker.body not in simulator.bodies:
        raise RequestError(
            f"{what} is on {marker.body!r}, and there is no such body; {did_you_mean(marker.body, simulator.bodies)}"
        )
    com = np.asarray(simulator.mechanism.body(marker.body).com, dtype=np.float64)
    drawn = np.array(marker.point)
    moving = simulator.model.bodies
    body = moving.index(marker.body) if marker.body in moving else None
    return Point(body, drawn - com, drawn, axis)
