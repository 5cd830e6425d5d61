"""Quantities of a run by name: angles, coordinates, rates, positions, energies.

In: a `Result` and a name. Out: values with their unit, or KeyError with the nearest names. Never: interprets what it
gives.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

from lamc.basics.checks import did_you_mean
from lamc.records.scene import OutputPoint
from lamc.run.request import Array

if TYPE_CHECKING:
    from lamc.run.result import Result
    from lamc.run.simulator import Simulator

AXES = ("x", "y", "z")
ENERGY = "energy"


@dataclass(frozen=True, eq=False)
class Quantity:
    """A quantity over a run. values: shape (m,), in `unit`."""

    name: str
    unit: str
    values: Array


def quantity_of(result: "Result", name: str) -> Quantity:
    """One quantity. Where a name means two things, the first of: hinge, coordinate, rate, position, energy;
    "energy.gravity", as measures have it, is that of gravity."""
    for known, unit, values in _all(result):
        if known == name:
            return Quantity(name, unit, values())
    kind, _, effect = str(name).partition(".")
    if kind == ENERGY and effect in result.motion.model.energies:  # as measures call it
        return Quantity(name, "J", result.energies[effect])
    raise KeyError(f"nothing of this run is named {name!r}; {did_you_mean(str(name), names(result))}")


def names(result: "Result") -> list[str]:
    """Everything that `quantity_of` knows, each name once."""
    return list(dict.fromkeys(known for known, _, _ in _all(result)))


def units_of(simulator: "Simulator") -> dict[str, str]:
    """Everything that `quantity_of` will know of the simulator's runs, with its SI unit, before one has run."""
    joints = {joint.name for joint in simulator.mechanism.joints}
    hinges = [c.name for c in simulator.coordinates if c.name in joints]
    points = [each.name for each in simulator.scene.outputs or () if isinstance(each, OutputPoint)]
    found = [(hinge, "rad") for hinge in hinges]
    found += [(f"{point}.{axis}", "m") for point in points for axis in AXES]
    found += [(c.name, c.unit) for c in simulator.coordinates]
    found += [(f"{hinge}.rate", "rad/s") for hinge in hinges]
    found += [(rate.name, rate.unit) for rate in simulator.rates[len(simulator.joints) :]]
    found += [(f"{body}.{axis}", "m") for body in simulator.bodies for axis in AXES]
    found += [(ENERGY, "J"), *((name, "J") for name in simulator.model.energies), ("constraint_error", "m")]
    units: dict[str, str] = {}
    for name, unit in found:
        units.setdefault(name, unit)
    return units


def _all(result: "Result") -> Iterator[tuple[str, str, Callable[[], Array]]]:
    """Name, unit, and what makes the values."""
    for hinge in result.hinges:
        yield hinge, "rad", lambda hinge=hinge: result.angle(hinge)  # type: ignore[misc]
    for point in result.points:
        for k, axis in enumerate(AXES):
            yield f"{point.name}.{axis}", "m", lambda n=point.name, k=k: result.point(n)[:, k]  # type: ignore[misc]
    for c in result.coordinates:
        yield c.name, c.unit, lambda n=c.name: result.coordinate(n)  # type: ignore[misc]
    for hinge in result.hinges:
        yield f"{hinge}.rate", "rad/s", lambda n=hinge: result.rate(n)  # type: ignore[misc]
    for r in result.rates[len(result.joints) :]:
        yield r.name, r.unit, lambda n=r.name: result.rate(n)  # type: ignore[misc]
    for body in result.bodies:
        for k, axis in enumerate(AXES):
            yield f"{body}.{axis}", "m", lambda n=body, k=k: result.pose(n)[0][:, k]  # type: ignore[misc]
    yield ENERGY, "J", lambda: result.energy
    for name in result.motion.model.energies:
        yield name, "J", lambda n=name: result.energies[n]  # type: ignore[misc]
    yield "constraint_error", "m", lambda: result.constraint_error
