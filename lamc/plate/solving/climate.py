"""What makes laminates stretch and bend by themselves: temperature, moisture and electric fields, the same all over a
region or functions of the place.

In: laminates and loads. Out: a climate for every region, its value at places, and the resultants that would stretch and
bend the untouched laminate as much. Never: meshes.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from lamc.errors import DesignError, about
from lamc.mechanism.checks import Array
from lamc.plate.elements.definition import Element
from lamc.plate.laminates.laminate import Laminate
from lamc.plate.loads import CLIMATES, ElectricField, Intensity, LoadRecord, Moisture, Temperature
from lamc.plate.solving.functions import values_at


@dataclass(frozen=True, eq=False)
class Climate:
    """At one place, or at many of shape (...)."""

    temperature: float | Array  # K above where it is free of stress
    moisture: float | Array  # mass over dry mass
    fields: Array  # (..., plies), V/m


@dataclass(frozen=True, eq=False)
class Varying:
    """A function of a load, and what it adds to where it is 1.

    unit  that of one place: 1 K, or 1 of moisture, or 1 V/m in one ply or in all
    """

    load: LoadRecord
    function: Intensity
    what: str  # for messages
    unit: Climate

    def factor(self, points: Array) -> Array:
        """The function at `points` (..., 2), m. Raises DesignError where it fails."""
        with about(self.load):
            return values_at(self.function, points, self.what)


@dataclass(frozen=True, eq=False)
class RegionClimate:
    """Of a region: what is the same everywhere, and functions of the place that add to it."""

    uniform: Climate
    varying: tuple[Varying, ...] = ()

    def at(self, points: Array) -> Climate:
        """At `points` (..., 2), m; the uniform one, without shape, where nothing varies. Raises DesignError where a
        function fails."""
        if not self.varying:
            return self.uniform
        shape = points.shape[:-1]
        temperature = np.full(shape, self.uniform.temperature)
        moisture = np.full(shape, self.uniform.moisture)
        fields = np.tile(self.uniform.fields, (*shape, 1))
        for part in self.varying:
            factor = part.factor(points)
            temperature = temperature + factor * part.unit.temperature
            moisture = moisture + factor * part.unit.moisture
            fields = fields + factor[..., None] * part.unit.fields
        return Climate(temperature, moisture, fields)


def climates(
    laminates: Sequence[Laminate], loads: Sequence[LoadRecord], names: Sequence[str]
) -> list[RegionClimate]:
    """What all of `loads` together make of each region, in the order of `names`."""
    result = []
    for laminate, name in zip(laminates, names, strict=True):
        count = len(laminate.plies)
        uniform = Climate(0.0, 0.0, np.zeros(count))
        varying: list[Varying] = []
        for load in loads:
            if not isinstance(load, CLIMATES) or load.region not in (None, name):
                continue
            with about(load):
                parts = _parts(load, count, name)
            for amount, unit, what in parts:
                if callable(amount):
                    varying.append(Varying(load, amount, what, unit))
                else:
                    uniform = Climate(
                        uniform.temperature + amount * unit.temperature,
                        uniform.moisture + amount * unit.moisture,
                        uniform.fields + amount * unit.fields,
                    )
        result.append(RegionClimate(uniform, tuple(varying)))
    return result


def _parts(
    load: Temperature | Moisture | ElectricField, count: int, name: str
) -> list[tuple[Intensity, Climate, str]]:
    """Amounts, what each is an amount of, and its name. Raises DesignError where fields are not as many as plies."""
    none = np.zeros(count)
    if isinstance(load, Temperature):
        return [(load.rise, Climate(1.0, 0.0, none), "the rise of a Temperature")]
    if isinstance(load, Moisture):
        return [(load.content, Climate(0.0, 1.0, none), "the content of a Moisture")]
    what = "the field of an ElectricField"
    if not isinstance(load.field, Sequence):
        return [(load.field, Climate(0.0, 0.0, np.ones(count)), what)]
    if len(load.field) != count:
        raise DesignError(
            f"an ElectricField has {len(load.field)} fields, and the laminate of region {name!r} has {count} plies; "
            "give one per ply, or name the region it is for"
        )
    return [
        (each, Climate(0.0, 0.0, row), f"{what} in ply {k}")
        for k, (each, row) in enumerate(zip(load.field, np.eye(count), strict=True))
    ]


def resultants(laminate: Laminate, element: Element, climate: Climate) -> Array:
    """Those that would stretch and bend the unloaded laminate as `climate` does, in the order of the element's strains,
    shape (..., 3 or 6), N/m and N."""
    if not np.ndim(climate.temperature):
        return _resultants(
            laminate, element, float(climate.temperature), float(climate.moisture), climate.fields
        )
    count = len(laminate.plies)
    total = np.multiply.outer(climate.temperature, _resultants(laminate, element, 1.0, 0.0, np.zeros(count)))
    total += np.multiply.outer(climate.moisture, _resultants(laminate, element, 0.0, 1.0, np.zeros(count)))
    by_ply = np.array([_resultants(laminate, element, 0.0, 0.0, row) for row in np.eye(count)])
    return np.asarray(total + climate.fields @ by_ply)


def _resultants(
    laminate: Laminate, element: Element, temperature: float, moisture: float, fields: Array
) -> Array:
    of = laminate.expansion(temperature, moisture, fields)
    return np.concatenate([of.force] * element.stretches + [of.moment] * element.bends)


def pulls(laminate: Laminate, climate: RegionClimate) -> bool:
    """Whether it pulls in the plane of the laminate, somewhere at least."""
    return any(
        laminate.expansion(float(each.temperature), float(each.moisture), each.fields).force.any()
        for each in (climate.uniform, *(part.unit for part in climate.varying))
    )
