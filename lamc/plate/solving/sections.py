"""From laminates to what elements read: stiffness entries.

In: laminates, an element. Out: rows of numbers. Never: meshes, loads.

An element that bends reads D, one that stretches A, one that does both A, B and D; of each symmetric matrix the entries
11, 12, 16, 22, 26, 66.
"""

from collections.abc import Sequence

import numpy as np

from lamc.mechanism.checks import Array
from lamc.plate.elements.definition import Element
from lamc.plate.laminates.laminate import Laminate

_ENTRIES = np.triu_indices(3)
NO_COUPLING = 1e-10  # of B over sqrt(A D): below it is round-off of a stack that is symmetric


def couples(laminate: Laminate) -> bool:
    """Whether bending and stretching are coupled: whether B is more than round-off."""
    size = np.sqrt(np.abs(laminate.A).max() * np.abs(laminate.D).max())
    return bool(np.abs(laminate.B).max() > NO_COUPLING * size)


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
