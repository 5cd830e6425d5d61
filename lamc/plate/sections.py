"""From laminates to what elements read: stiffness entries and resultants of expansion.

In: laminates, an element, loads that make a free laminate stretch and bend. Out: rows of numbers. Never: meshes.

An element that bends reads D, one that stretches A, one that does both A, B and D; of each symmetric matrix the entries
11, 12, 16, 22, 26, 66.
"""

from collections.abc import Sequence

import numpy as np

from lamc.errors import UnsupportedError
from lamc.mechanism.checks import Array
from lamc.plate.elements.definition import Element
from lamc.plate.laminate import Laminate, Resultants
from lamc.plate.loads import ElectricField, LoadRecord, Moisture, Temperature

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


def resultants(laminates: Sequence[Laminate], element: Element, load: LoadRecord) -> Array:
    """Of the expansion under `load`, in the order of the element's strains, shape (len(laminates), 3 or 6)."""
    rows = []
    for laminate in laminates:
        of_load = expansion(laminate, load)
        parts = [of_load.force] * element.stretches + [of_load.moment] * element.bends
        rows.append(np.concatenate(parts))
    return np.array(rows)


def expansion(laminate: Laminate, load: LoadRecord) -> Resultants:
    """Force and moment per width that would stretch and bend the unloaded laminate as `load` does; zero for a load of
    another kind."""
    if isinstance(load, Temperature):
        unit, amount = laminate.thermal, load.rise
    elif isinstance(load, Moisture):
        unit, amount = laminate.moisture, load.content
    elif isinstance(load, ElectricField):
        raise UnsupportedError("a laminate without piezoelectric plies takes no ElectricField")
    else:
        return Resultants(np.zeros(3), np.zeros(3))
    return Resultants(amount * unit.force, amount * unit.moment)
