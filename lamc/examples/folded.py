"""Fold angles of vertices that fold alike all over a sheet, in closed form.

In: sector angles and some of the fold angles about a vertex, rad. Out: the others. Never: iterates; draws.

Going around a vertex, facets turn by sectors about their normal (z) and by folds about creases (x), and end where they
began. Folds of one sign are valleys.
"""

import math

import numpy as np

from lamc.records.mechanism import Array


def third_of_opposites(sectors: tuple[float, float, float], first: float, second: float) -> float:
    """The fold h of a vertex of six creases of which opposite ones are alike (first, second, h, first, second, h), with
    sectors a, b, c between them, a from the first to the second, that sum up to π.

    Half the way around is a rotation by π, twice which is none: its trace is -1, the least there is. Where the last
    fold makes it least, at one angle, it is -1.
    """
    a, b, c = sectors
    around = _sector(c) @ _fold(first) @ _sector(a) @ _fold(second) @ _sector(b)
    # The trace of around · fold(h) is around[0, 0] + q cos h + r sin h.
    q, r = around[1, 1] + around[2, 2], around[1, 2] - around[2, 1]
    return math.atan2(-r, -q)


def mirrored(known: float, sectors: tuple[float, float, float], far: float) -> tuple[float, float]:
    """Folds (side, last) of a vertex of six creases that is its own mirror image: creases known and last lie in the
    mirror, and between them on either side creases of folds side and far, sectors apart in this order from the known
    one. The last crease stays in the mirror: that gives side; its dihedral angle gives last. Nearer to flat, as above.
    """
    a, b, c = sectors
    start = _fold(0.5 * known) @ _sector(a)
    end = _sector(b) @ _fold(far) @ _sector(c) @ np.array([1.0, 0.0, 0.0])
    # The mirror's normal is y where the known crease is x: y · start · fold(side) · end = 0.
    row = start[1]
    side = _nearest(row[1] * end[1] + row[2] * end[2], row[2] * end[1] - row[1] * end[2], -row[0] * end[0])
    frame = start @ _fold(side) @ _sector(b) @ _fold(far) @ _sector(c)
    # Half the last fold brings the facet's plane into the one that mirrors it: its y axis onto ±y.
    return side, 2.0 * math.atan2(-frame[1, 2], -frame[1, 1])


def _nearest(q: float, r: float, s: float) -> float:
    """The x of least size with q cos x + r sin x = s. Raises ValueError where there is none."""
    middle, spread = math.atan2(r, q), math.acos(s / math.hypot(q, r))
    both = [math.remainder(middle + sign * spread, 2.0 * math.pi) for sign in (1.0, -1.0)]
    return min(both, key=abs)


def _sector(angle: float) -> Array:
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def _fold(angle: float) -> Array:
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])
