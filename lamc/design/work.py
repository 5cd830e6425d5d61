"""How much work a drawing is to overlay, counted before it is done.

In: outlines and hinge lines. Out: nothing, or a DesignError that names the number, its limit and the way out. Never:
overlays; clocks, so that a file is read or refused alike on every machine.

Overlays of lines cost as many steps as these have crossings, and every crossing is a corner of what is overlaid next:
n lines may cross n² times.
"""

from collections.abc import Sequence

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely.geometry.base import BaseGeometry

from lamc.basics.errors import DesignError, Place

Geometries = NDArray[np.object_]

MOST_CROSSINGS = 20_000  # of outlines in one layer: a second or two to overlay
MOST_MEETINGS = 5_000  # of hinge strips: a Miura fold of n × n plates has 6 n²; some seconds to cut
MOST_LAYERS = 200  # every hinge is looked for in every layer
_AT_ONCE = 1_000_000  # pairs that one query may give: 16 MB


def check_outlines(outlines: Sequence[BaseGeometry], layer: str) -> None:
    """Raises DesignError where outlines that are drawn in one layer cross or touch too often."""
    edges = [_edges(outline) for outline in outlines]
    owner = np.repeat(np.arange(len(edges)), [len(each) for each in edges])
    count = _meetings(np.concatenate([np.zeros(0, dtype=object), *edges]), owner, MOST_CROSSINGS)
    if count > MOST_CROSSINGS:
        raise DesignError(
            f"the outlines in layer {layer!r} cross or touch each other {count} times or more; at most "
            f"{MOST_CROSSINGS} crossings are computed: draw them as fewer shapes, or leave out what others cover"
        )


def check_strips(strips: Geometries, place: Place | None) -> None:
    """Raises DesignError where too many strips of hinge lines (the lines, grown by their widths) meet."""
    count = _meetings(strips, np.arange(len(strips)), MOST_MEETINGS)
    if count > MOST_MEETINGS:
        raise DesignError(
            f"the strips of {len(strips)} hinge lines, each a width to both sides of its line, meet {count} times or "
            f"more; at most {MOST_MEETINGS} meetings are cut: let lines end where they meet, lower the width, or draw "
            "the device in parts",
            place,
        )


def _edges(outline: BaseGeometry) -> Geometries:
    """Every side of every ring, as lines."""
    coordinates, ring = shapely.get_coordinates(
        shapely.get_rings(shapely.get_parts(outline)), return_index=True
    )
    inside = ring[1:] == ring[:-1]
    lines: Geometries = shapely.linestrings(np.stack([coordinates[:-1], coordinates[1:]], axis=1)[inside])
    return lines


def _meetings(shapes: Geometries, owner: NDArray[np.integer], most: int) -> int:
    """How many pairs of different owners have a point in common; counted until they are more than `most`."""
    if len(np.unique(owner)) < 2:
        return 0
    tree, count = shapely.STRtree(shapes), 0
    step = max(1, _AT_ONCE // len(shapes))
    for start in range(0, len(shapes), step):
        first, second = tree.query(shapes[start : start + step], predicate="intersects")
        count += int(np.count_nonzero(owner[first + start] < owner[second]))
        if count > most:
            break
    return count
