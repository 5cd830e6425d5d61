"""From laminates to what elements read: stiffness entries and resultants of expansion.

In: laminates, an element, loads that make a free laminate stretch and bend. Out: rows of numbers. Never: meshes.

An element that bends reads D, one that stretches A, one that does both A, B and D; of each symmetric matrix the entries
11, 12, 16, 22, 26, 66.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from lamc.errors import DesignError, about
from lamc.mechanism.checks import Array
from lamc.plate.elements.definition import Element
from lamc.plate.laminates.laminate import Laminate
from lamc.plate.loads import CLIMATES, ElectricField, LoadRecord, Moisture, Temperature


@dataclass(frozen=True, eq=False)
class Climate:
    """What makes a region's laminate stretch and bend by itself."""

    temperature: float  # K above where it is free of stress
    moisture: float  # mass over dry mass
    fields: Array  # (plies,), V/m


_ENTRIES = np.triu_indices(3)
_NO_COUPLING = 1e-10  # of B over sqrt(A D): below it is round-off of a stack that is symmetric


def couples(laminate: Laminate) -> bool:
    """Whether bending and stretching are coupled: whether B is more than round-off."""
    size = np.sqrt(np.abs(laminate.A).max() * np.abs(laminate.D).max())
    return bool(np.abs(laminate.B).max() > _NO_COUPLING * size)


def sections(laminates: Sequence[Laminate], element: Element) -> Array:
    """What `element` reads of each laminate, shape (len(laminates), 6 or 18), N/m, N and N·m."""
    rows = []
    for laminate in laminates:
        if element.bends and element.stretches:
            parts = [laminate.A, laminate.B, laminate.D]
        else:
            parts = [laminate.D if element.bends else laminate.A]
        rows.append(np.concatenate([part[_ENTRIES] for part in parts]))
    return np.array(rows)


def matrices(laminates: Sequence[Laminate], element: Element) -> Array:
    """Resultants over strains, shape (len(laminates), 3 or 6, 3 or 6)."""
    if element.bends and element.stretches:
        return np.array([laminate.ABD for laminate in laminates])
    return np.array([laminate.D if element.bends else laminate.A for laminate in laminates])


def climates(
    laminates: Sequence[Laminate], loads: Sequence[LoadRecord], names: Sequence[str]
) -> list[Climate]:
    """What all of `loads` together make of each region, in the order of `names`."""
    result = []
    for laminate, name in zip(laminates, names, strict=True):
        temperature = moisture = 0.0
        fields = np.zeros(len(laminate.plies))
        for load in loads:
            if not isinstance(load, CLIMATES) or load.region not in (None, name):
                continue
            if isinstance(load, Temperature):
                temperature += load.rise
            elif isinstance(load, Moisture):
                moisture += load.content
            else:
                with about(load):
                    fields = fields + checked_fields(laminate, load, name)
        result.append(Climate(temperature, moisture, fields))
    return result


def checked_fields(laminate: Laminate, load: ElectricField, name: str) -> Array:
    """The field in every ply of region `name`, V/m. Raises DesignError where there are not as many."""
    fields = np.asarray(load.field, dtype=float)
    if fields.ndim and len(fields) != len(laminate.plies):
        raise DesignError(
            f"an ElectricField has {len(fields)} fields, and the laminate of region {name!r} has "
            f"{len(laminate.plies)} plies; give one per ply, or name the region it is for"
        )
    return np.broadcast_to(fields, (len(laminate.plies),))


def expansions(laminates: Sequence[Laminate], element: Element, states: Sequence[Climate]) -> Array:
    """Resultants that would stretch and bend each unloaded laminate as its climate does, in the order of the element's
    strains, shape (len(laminates), 3 or 6), N/m and N."""
    rows = []
    for laminate, state in zip(laminates, states, strict=True):
        of = laminate.expansion(state.temperature, state.moisture, state.fields)
        rows.append(np.concatenate([of.force] * element.stretches + [of.moment] * element.bends))
    return np.array(rows)
