"""What makes laminates stretch and bend by themselves: temperature, moisture and electric fields, the same all over a
region or functions of the place.

In: laminates and loads. Out: a climate for every region, its value at places, and the resultants that would stretch and
bend the untouched laminate as much. Never: meshes.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from lamc.basics.checks import Array
from lamc.basics.errors import DesignError, about
from lamc.plates.elements.definition import Element
from lamc.plates.functions import values_at
from lamc.plates.laminates.graded import Amount, Graded, gradient_of, is_of_places, level_of, number_of, over
from lamc.plates.laminates.laminate import Laminate
from lamc.plates.loads import CLIMATES, ElectricField, Intensity, LoadRecord, Moisture, Temperature

_SLOPE = Graded(0.0, 1.0)  # 1 per m
_ROUND_OFF = 1e-12  # of a stack's sums, with room


@dataclass(frozen=True, eq=False)
class Climate:
    """At one place, or at many of shape (...); `Graded` where it changes through the thickness."""

    temperature: Amount  # K above where it is free of stress
    moisture: Amount  # mass over dry mass
    fields: Array  # (..., plies), V/m


@dataclass(frozen=True, eq=False)
class Varying:
    """A function of a load, and what it adds to where it is 1.

    unit  that of one place: 1 K or K/m, or 1 or 1/m of moisture, or 1 V/m in one ply or in all
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
        temperature: Amount = over(shape, self.uniform.temperature)
        moisture: Amount = over(shape, self.uniform.moisture)
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
        found = [(load.rise, Climate(1.0, 0.0, none), "the rise of a Temperature")]
        slope = (load.gradient, Climate(_SLOPE, 0.0, none), "the gradient of a Temperature")
        return [*found, slope] if load.has_gradient else found
    if isinstance(load, Moisture):
        found = [(load.content, Climate(0.0, 1.0, none), "the content of a Moisture")]
        slope = (load.gradient, Climate(0.0, _SLOPE, none), "the gradient of a Moisture")
        return [*found, slope] if load.has_gradient else found
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
    if not (is_of_places(climate.temperature) or is_of_places(climate.moisture)):
        return _resultants(laminate, element, climate)
    none = np.zeros(len(laminate.plies))
    by_ply = [_resultants(laminate, element, Climate(0.0, 0.0, row)) for row in np.eye(len(none))]
    total = np.asarray(climate.fields @ np.array(by_ply))
    for amount, of_one, of_slope in (
        (climate.temperature, Climate(1.0, 0.0, none), Climate(_SLOPE, 0.0, none)),
        (climate.moisture, Climate(0.0, 1.0, none), Climate(0.0, _SLOPE, none)),
    ):
        for values, unit in ((level_of(amount), of_one), (gradient_of(amount), of_slope)):
            total = total + np.multiply.outer(np.asarray(values), _resultants(laminate, element, unit))
    return total


def _resultants(laminate: Laminate, element: Element, climate: Climate) -> Array:
    """Of one place."""
    of = laminate.expansion(number_of(climate.temperature), number_of(climate.moisture), climate.fields)
    return np.concatenate([of.force] * element.stretches + [of.moment] * element.bends)


def pulls(laminate: Laminate, climate: RegionClimate) -> bool:
    """Whether it pulls in the plane of the laminate, somewhere at least."""
    for each in (climate.uniform, *(part.unit for part in climate.varying)):
        of = laminate.expansion(number_of(each.temperature), number_of(each.moisture), each.fields)
        # A gradient about the middle of a symmetric stack pulls by round-off only.
        if np.abs(of.force).max() > _ROUND_OFF * np.abs(of.moment).max() / laminate.thickness:
            return True
    return False
