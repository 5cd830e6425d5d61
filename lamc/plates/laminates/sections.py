"""From laminates to what elements read: stiffness entries.

In: laminates, an element. Out: rows of numbers. Never: meshes, loads.

An element that bends reads D, one that stretches A, one that does both A, B and D; of each symmetric matrix the entries
11, 12, 16, 22, 26, 66. One with shear through the thickness reads H too (11, 12, 22), and D about the neutral surface.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from lamc.basics.checks import Array
from lamc.plates.elements.definition import Element
from lamc.plates.laminates.laminate import Laminate

_ENTRIES = np.triu_indices(3)
NO_COUPLING = 1e-10  # of B over sqrt(A D): below it is round-off of a stack that is symmetric


def couples(laminate: Laminate) -> bool:
    """Whether bending and stretching are coupled: whether B is more than round-off."""
    size = np.sqrt(np.abs(laminate.A).max() * np.abs(laminate.D).max())
    return bool(np.abs(laminate.B).max() > NO_COUPLING * size)


def sections(laminates: Sequence[Laminate], element: Element) -> Array:
    """What `element` reads of each laminate, shape (len(laminates), 6 or 18, and 9 more with shear), N/m, N and N·m.

    Raises DesignError for a laminate with a gap, where shear through the thickness is asked for."""
    rows = []
    for laminate in laminates:
        if element.bends and element.stretches:
            parts = [laminate.A, laminate.B, laminate.D]
        else:
            parts = [laminate.D if element.bends else laminate.A]
        row = [part[_ENTRIES] for part in parts]
        if element.shear:
            neutral = laminate.D - laminate.B @ np.linalg.solve(laminate.A, laminate.B)
            row += [laminate.H[np.triu_indices(2)], (0.5 * (neutral + neutral.T))[_ENTRIES]]
        rows.append(np.concatenate(row))
    return np.array(rows)


def in_cells(
    laminates: Sequence[Laminate], element: Element, regions: npt.NDArray[np.integer[Any]]
) -> Array | None:
    """Sections of cells of these `regions` (k,), (k, entries), for elements whose strains go by them; else None."""
    return sections(laminates, element)[regions] if element.shear else None


def matrices(laminates: Sequence[Laminate], element: Element) -> Array:
    """Resultants over strains, shape (len(laminates), 3 or 6, 3 or 6)."""
    if element.bends and element.stretches:
        return np.array([laminate.ABD for laminate in laminates])
    return np.array([laminate.D if element.bends else laminate.A for laminate in laminates])
