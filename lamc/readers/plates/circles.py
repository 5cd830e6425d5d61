"""How many corners a circle is drawn with.

In: its radius and the length of the mesh's edges. Out: a number of corners. Never: polygons.
"""

import math

from lamc.design.shapes import CIRCLE_SEGMENTS

_DOUBLED = 7  # times at most: 16 384 corners, with sides of a two-thousandth of the radius


def corners_of(radius: float, size: float, finer: int) -> int:
    """Twice as many until a side is no longer than `size`, m, so that finer meshes follow the circle better; then
    `finer` times as many."""
    sides = 2.0 * math.pi * radius / (CIRCLE_SEGMENTS * size)
    return (CIRCLE_SEGMENTS * finer) << min(math.ceil(math.log2(max(sides, 1.0))), _DOUBLED)
