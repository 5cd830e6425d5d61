"""Coordinates that do not know the unit of length.

In: outlines and sizes in m. Out: the same in coordinates of order one, rounded to a grid, and the way back. Never:
cells.

A mesher decides by comparing numbers, and on regular outlines many are equal but for round-off. The same plate written
in m, mm or µm has other round-off; rounded to a grid of 2⁻³⁶ of its extent it is the same plate again, and so are all
decisions about it.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

from lamc.basics.checks import Array
from lamc.plates.meshing.linework import Path
from lamc.plates.meshing.outlines import Area, extent_of

Integers = NDArray[np.int32]

_STEPS = 2.0**36  # per extent; corners are one where they are within 68 steps, `outlines.TOLERANCE`


@dataclass(frozen=True, eq=False)
class MeshScaling:
    """Coordinates (x - middle) / extent, rounded."""

    middle: Array  # (2,), m
    extent: float  # m
    given: dict[tuple[float, ...], tuple[float, ...]]  # points of paths: rounded → as given, m

    def rounded(self, points: Array) -> Array:
        """Of order one, from m."""
        return np.round((points - self.middle) / self.extent * _STEPS) / _STEPS + 0.0  # no -0.0

    def metres(self, points: Array) -> Array:
        """From order one, m."""
        return np.asarray(points * self.extent + self.middle)

    def moved(self, area: Area) -> Area:
        """In rounded coordinates."""
        return shapely.transform(area, self.rounded)

    def moved_path(self, path: Path) -> Path:
        """In rounded coordinates."""
        return Path(self.rounded(path.points), path.kind, float(self.lengths(np.array(path.size))))

    def lengths(self, values: Array) -> Array:
        """Over the extent, to as many digits as coordinates have."""
        fraction, exponent = np.frexp(values / self.extent)
        return np.asarray(np.ldexp(np.round(fraction * _STEPS) / _STEPS, exponent))

    def placed(self, points: Array, corners: int, segment_of: Integers, segments: Integers) -> Array:
        """All points, (n, 2), in m: the first `corners` as they were given; those on a segment between the corners
        `segments`, (s, 2), on the line between these as given; others by the way back."""
        result = self.metres(points)
        result[:corners] = [self.given[key] for key in map(tuple, points[:corners].tolist())]
        on = np.flatnonzero(segment_of >= 0)
        a, b = segments[segment_of[on]].T
        along = points[b] - points[a]
        t = np.sum(along * (points[on] - points[a]), axis=1) / np.sum(along * along, axis=1)
        result[on] = result[a] + t[:, None] * (result[b] - result[a])
        return result


def frame_of(polygon: Area, paths: Sequence[Path]) -> MeshScaling:
    """The frame of a plate; of points that are one when rounded, that of the first path counts."""
    low_x, low_y, high_x, high_y = polygon.bounds
    middle = np.array([0.5 * (low_x + high_x), 0.5 * (low_y + high_y)])
    frame = MeshScaling(middle, extent_of(polygon), {})
    points = np.concatenate([path.points for path in paths])
    for key, point in zip(map(tuple, frame.rounded(points).tolist()), points.tolist(), strict=True):
        frame.given.setdefault(key, tuple(point))
    return frame
