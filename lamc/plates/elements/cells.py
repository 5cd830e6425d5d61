"""Whether cells of a mesh are ones that an element is for.

In: an element and corners. Out: nothing, or a DesignError that names a cell. Never: symbols.
"""

import numpy as np

from lamc.basics.checks import Array
from lamc.basics.errors import DesignError
from lamc.plates.elements.definition import SQUARE, Element

_SKEW = 1e-9  # of a cell's size: round-off of coordinates, and far below what the answer would show


def check_cells(element: Element, corners: Array) -> None:
    """Raises DesignError where a square that bends meets a cell, (m, 4, 2), that is no rectangle with sides along x and
    y whose first corner is the lower left one: w_x, w_y and w_xy are along the sides of such cells only.
    """
    if element.cell != SQUARE or not element.bends:
        return
    low, high = corners[:, 0], corners[:, 2]
    expected = np.stack(
        [low, np.stack([high[:, 0], low[:, 1]], axis=1), high, np.stack([low[:, 0], high[:, 1]], axis=1)],
        axis=1,
    )
    size = np.abs(high - low).max(axis=1)
    wrong = np.abs(corners - expected).max(axis=(1, 2)) > _SKEW * size
    wrong |= (high <= low).any(axis=1)
    if wrong.any():
        cell = int(np.argmax(wrong))
        shape = ", ".join(f"({x:g}, {y:g})" for x, y in corners[cell])
        raise DesignError(
            f"element {element.name!r} is for rectangles with sides along x and y, from the lower left corner on; "
            f"{int(wrong.sum())} cells are none, such as cell {cell} with corners {shape}: mesh with triangles, and "
            "take an element for these"
        )
