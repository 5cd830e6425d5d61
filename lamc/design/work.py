"""How much work a drawing is to overlay, counted before it is done.

In: outlines, lines and hinge lines. Out: nothing, or a DesignError that names the number, its limit and the way out.
Never: overlays; clocks, so that a file is read or refused alike on every machine.

Overlays of lines cost as many steps as these have crossings, and every crossing is a corner of what is overlaid next:
n lines may cross n² times. What is overlaid again and again costs its corners each time.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely.geometry.base import BaseGeometry

from lamc.basics.checks import Array
from lamc.basics.errors import DesignError, Place

Geometries = NDArray[np.object_]
Numbers = NDArray[np.integer]
Pairs = NDArray[np.int64]

MOST_CROSSINGS = 20_000  # of all that is overlaid for one file: a second or two
MOST_CORNERS = (
    1_000_000  # that overlays for one file go through, each as often as it is overlaid: some seconds
)
MOST_MEETINGS = 60_000  # of hinge strips: a Miura fold of n × n plates has 6 (n - 1)²; 0.3 ms each, measured
MOST_OVERLAPS = 2_000_000  # of meetings that meet in turn: 15 about a vertex of four hinges; 2.3 µs each
MOST_LAYERS = 200  # every hinge is looked for in every layer
# What else costs as much as a crossing, some 100 µs, measured: pairs of sides whose boxes meet, which are looked at;
# pairs of sides of areas that grow into each other, 1 to 7 µs, as most of them end up hidden; half a pair of lines that
# do, 60 µs and more.
_LOOKS = 200
_GROWN = 10
_LINES_GROWN = 0.5
_FEW = 100  # sides whose boxes are compared all with all, sooner than a tree is made of them
_AT_ONCE = 200_000  # pairs that one query may give: some 30 MB with what is computed of them
_ROUGH = 0.01  # of a distance: how far GEOS simplifies what is grown by it


@dataclass
class Account:
    """What the overlays for one file come to, added up as they are made.

    corners    of all that was overlaid, each time that it was
    """

    corners: int = 0
    _counted: int = 0  # crossings
    _owed: list[tuple[BaseGeometry, ...]] = field(default_factory=list)  # overlays not looked at yet
    _owed_most: int = 0  # what they come to if every side crosses every other

    @property
    def crossings(self) -> int:
        """Pairs of sides of different shapes that cross, or share a part; those that end at one another, or are alike,
        cost no more than their corners."""
        for shapes in self._owed:
            self._counted += _crossings(*_numbered_sides(*_parts(shapes)), MOST_CROSSINGS)
        self._owed, self._owed_most = [], 0
        return self._counted

    def overlay(self, shapes: Sequence[BaseGeometry], what: str) -> None:
        """Counts an overlay of areas that do not cross themselves, lines and points. Raises DesignError, naming `what`
        (in the plural), where the file's overlays are too much work."""
        given = tuple(shapes)
        corners = int(shapely.get_num_coordinates(np.array(given, dtype=object)).sum())
        self._add_corners(corners, what)
        most = corners * corners // 2 + corners * corners // _LOOKS
        # Too few to be too much work, whatever they do, are looked at when somebody asks.
        if self._counted + self._owed_most + most <= MOST_CROSSINGS:
            self._owed.append(given)
            self._owed_most += most
            return
        left = MOST_CROSSINGS - self.crossings
        self._add_crossings(_crossings(*_numbered_sides(*_parts(given)), left), "cross each other", what)

    def growth(self, shape: BaseGeometry, distance: float, what: str) -> None:
        """Counts what it takes to grow a shape by a distance, m, or to shrink it: bands along sides that are near cross
        each other. Raises as `overlay` does."""
        self._add_corners(int(shapely.get_num_coordinates(shape)), what)
        is_line = shapely.get_dimensions(shape) == 1
        plain = shapely.get_parts(shapely.simplify(shape, _ROUGH * abs(distance), preserve_topology=False))
        sides = _sides(plain if is_line else shapely.get_rings(plain))
        share, reach = _LINES_GROWN if is_line else _GROWN, 2.0 * abs(distance)
        left = MOST_CROSSINGS - self.crossings
        near = len(_meetings(sides, int(share * left), "dwithin", distance=reach))
        self._add_crossings(int(near / share), f"come within {1e3 * reach:.3g} mm of each other", what)

    def _add_crossings(self, count: int, how: str, what: str) -> None:
        self._counted += count
        if self._counted > MOST_CROSSINGS:
            before = ", with those before" if self._counted > count else ""
            raise DesignError(
                f"{what} {how} {self._counted} times or more{before}; at most {MOST_CROSSINGS} crossings are "
                "computed: draw them as fewer shapes, or leave out what others cover"
            )

    def _add_corners(self, count: int, what: str) -> None:
        self.corners += count
        if self.corners > MOST_CORNERS:
            raise DesignError(
                f"{what} bring the corners that are overlaid to {self.corners}, each counted as often as it is "
                f"overlaid; at most {MOST_CORNERS} are for a file: draw with fewer corners, or in fewer operations"
            )


def meetings_of(strips: Geometries, place: Place | None) -> Pairs:
    """Pairs of indices (k, 2), sorted, of the strips of hinge lines (the lines, grown by half their gaps) that meet.

    Raises DesignError where too many do."""
    pairs = _meetings(strips, MOST_MEETINGS)
    if len(pairs) > MOST_MEETINGS:
        raise DesignError(
            f"the strips of {len(strips)} hinge lines, each half a gap to either side, meet {len(pairs)} times "
            f"or more; at most {MOST_MEETINGS} meetings are cut: let lines end where they meet, lower the gap, or "
            "draw the device in parts",
            place,
        )
    return pairs


def check_overlaps(overlaps: Geometries, place: Place | None) -> None:
    """Raises DesignError where too many of the areas in which strips meet lie on one another, by their boxes: joining k
    of them to one hole takes k² steps."""
    count = len(_meetings(overlaps, MOST_OVERLAPS, None))
    if count > MOST_OVERLAPS:
        raise DesignError(
            f"the {len(overlaps)} areas in which strips of hinge lines meet, each half a gap to either side of a line, "
            f"lie on one another {count} times or more; at most {MOST_OVERLAPS} times are joined to holes: let fewer "
            "lines run through one place, or lower the gap",
            place,
        )


def _parts(shapes: Sequence[BaseGeometry]) -> tuple[Geometries, Numbers]:
    """All parts of shapes, and of which shape each is, by its index."""
    some, outer = shapely.get_parts(np.asarray(shapes, dtype=object), return_index=True)
    parts, inner = shapely.get_parts(some, return_index=True)
    return parts, outer[inner]


def _numbered_sides(parts: Geometries, shape: Numbers) -> tuple[Array, Numbers]:
    """The ends of every side of every ring and line, (n, 2, 2), and for each an ascending number: one for all areas of
    a shape, but one for each side of lines, which may cross themselves."""
    is_area = shapely.get_dimensions(parts) == 2
    rings, part = shapely.get_rings(parts[is_area], return_index=True)
    ends, ring = _ends(rings)
    owner = shape[is_area][part][ring]
    if is_area.all():
        return ends, owner
    of_lines, line = _ends(parts[~is_area])
    # Areas of shape k come before its lines, and these before the areas of shape k + 1.
    shapes = np.concatenate([owner, shape[~is_area][line]])
    is_line = np.arange(len(shapes)) >= len(owner)
    order = np.lexsort([is_line, shapes])
    begins = is_line[order]
    begins[1:] |= np.diff(shapes[order]) > 0
    return np.concatenate([ends, of_lines])[order], np.cumsum(begins)


def _ends(lines: Geometries) -> tuple[Array, Numbers]:
    """The ends of the sides of rings and lines, (n, 2, 2), in order, and of which line each is; points have none."""
    coordinates, line = shapely.get_coordinates(lines, return_index=True)
    inside = line[1:] == line[:-1]
    return np.stack([coordinates[:-1], coordinates[1:]], axis=1)[inside], line[1:][inside]


def _sides(lines: Geometries) -> Geometries:
    """The sides of rings and lines, in order; points have none."""
    sides: Geometries = shapely.linestrings(_ends(lines)[0])
    return sides


def _meetings(
    shapes: Geometries, most: int, predicate: str | None = "intersects", **distance: float
) -> Pairs:
    """Pairs of indices (k, 2), a < b, sorted, of shapes that meet as a predicate says, or whose boxes do; no further
    ones once they are more than `most`."""
    tree, found, count = shapely.STRtree(shapes), [np.zeros((0, 2), dtype=np.int64)], 0
    start, step = 0, max(1, _AT_ONCE // max(1, len(shapes)))
    order = np.arange(len(shapes))
    if step < len(shapes):
        # In no order, so that the next shapes meet about as many as the last ones, and their number can be chosen by
        # that.
        order = np.random.default_rng(0).permutation(len(shapes))
    while start < len(shapes) and count <= most:
        rows = order[start : start + step]
        first, second = tree.query(shapes[rows], predicate=predicate, **distance)
        once = rows[first] < second
        found.append(np.column_stack([rows[first[once]], second[once]]))
        count += len(found[-1])
        start += step
        step = 2 * step if len(first) < _AT_ONCE // 4 else max(1, step // 2)
    pairs = np.concatenate(found)
    return pairs[np.lexsort([pairs[:, 1], pairs[:, 0]])]


def _crossings(ends: Array, owner: Numbers, most: int) -> int:
    """How many pairs of sides (n, 2, 2) of different owners cross within both, or lie on one line and share a part of
    it; and the pairs that were looked at, at their cost. Counted until they are more than `most`."""
    if not len(owner) or owner[0] == owner[-1]:
        return 0
    found, seen = 0, 0
    for first, second in _near(ends):
        others = owner[first] < owner[second]
        a, b = ends[first[others]], ends[second[others]]
        seen += len(first)
        found += int(np.count_nonzero((_parted(a, b) & _parted(b, a)) | _share(a, b)))
        if found + seen // _LOOKS > most:
            break
    return found + seen // _LOOKS


def _near(ends: Array) -> Iterator[tuple[Numbers, Numbers]]:
    """Pairs of indices of sides whose boxes meet, itself and either order counted, some at a time."""
    if len(ends) <= _FEW:
        low, high = ends.min(axis=1), ends.max(axis=1)
        meets = (low[:, None] <= high[None]) & (high[:, None] >= low[None])
        first, second = np.nonzero(meets[..., 0] & meets[..., 1])
        yield first, second
        return
    sides = shapely.linestrings(ends)
    tree, step = shapely.STRtree(sides), max(1, _AT_ONCE // len(sides))
    for start in range(0, len(sides), step):
        first, second = tree.query(sides[start : start + step])
        yield first + start, second


def _parted(lines: Array, others: Array) -> NDArray[np.bool_]:
    """Which of the segments `others` (k, 2, 2) have an end on either side of the lines through those of `lines`."""
    along, offset = lines[:, 1] - lines[:, 0], others - lines[:, :1]
    rotation = along[:, None, 0] * offset[..., 1] - along[:, None, 1] * offset[..., 0]
    return np.asarray(np.sign(rotation[:, 0]) * np.sign(rotation[:, 1]) < 0.0)


def _share(a: Array, b: Array) -> NDArray[np.bool_]:
    """Which segments (k, 2, 2) lie on one line and share a part of it, but are not alike."""
    along, offset = a[:, 1] - a[:, 0], b - a[:, :1]
    on_line = (along[:, None, 0] * offset[..., 1] == along[:, None, 1] * offset[..., 0]).all(axis=1)
    low, high = np.sort((offset * along[:, None]).sum(axis=2), axis=1).T
    length = (along * along).sum(axis=1)
    return np.asarray(on_line & (low < length) & (high > 0.0) & ~((low == 0.0) & (high == length)))
