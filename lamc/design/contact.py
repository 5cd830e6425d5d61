"""Contact: which bodies a hinge line touches.

In: hinges, holes, and bodies by layer. Out: for each hinge, the bodies on its left and on its right, the layers
that hold its two sides together, and those where it cuts what it does not join. It raises nothing: what a contact
means is for `split` to say.

Slits leave the material of both sides at SLIT hinge widths from the line. So the line is read off along two
parallels slightly further out, over the length that no hole has taken, in its flexible layer. Parallels
rather than a grown area: they tell the sides apart, and measure a contact in metres of hinge.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from shapely import STRtree
from shapely.geometry import LineString, MultiPolygon, Polygon

from lamc.design.cutting import SLIT
from lamc.design.steps import Hinge

# Distance of the parallels from the line, in hinge widths. Half as far again as the slit's edge: clear of
# round-off, and well inside one width, beyond which a neighbour's material may begin.
REACH = 1.5 * SLIT
# The same in layers other than the flexible one, which are mostly drawn open by one width.
OPEN_REACH = 1.05
# Contacts shorter than this many hinge widths are corners or overshooting ends, not hinges.
SHORTEST = SLIT


@dataclass(frozen=True)
class Contact:
    """Indices of the bodies along a hinge, ascending, and the length of line that the holes have left.

    bridges  where it touches a single body: layers, outside those that the hinge runs through, in which that body lies
             across the line
    strays   (layer, bodies): layers where the slit has bodies on both its sides, and these others among them, as when
             a hinge of one sheet runs through the sheet above it too
    """

    left: tuple[int, ...]
    right: tuple[int, ...]
    free_length: float  # m
    bridges: tuple[int, ...] = ()
    strays: tuple[tuple[int, tuple[int, ...]], ...] = ()

    @property
    def bodies(self) -> tuple[int, ...]:
        return tuple(sorted({*self.left, *self.right}))


class LayerIndex:
    """The polygons of all bodies in one layer, in a search tree."""

    def __init__(self, bodies: Sequence[tuple[tuple[Polygon, ...], ...]], layer: int) -> None:
        owned = [(p, body) for body, polygons in enumerate(bodies) for p in polygons[layer]]
        self._polygons = np.array([p for p, _ in owned], dtype=object)
        self._owners = [body for _, body in owned]
        self._tree = STRtree(self._polygons)

    def along(self, lines: Sequence[LineString]) -> dict[int, float]:
        """Length of `lines` inside each body, m."""
        which = np.array(lines, dtype=object)
        i, j = self._tree.query(which, predicate="intersects")
        lengths = shapely.length(shapely.intersection(which[i], self._polygons[j]))
        inside: dict[int, float] = {}
        for index, length in zip(j, lengths, strict=True):
            owner = self._owners[int(index)]
            inside[owner] = inside.get(owner, 0.0) + float(length)
        return inside

    def touched(self, lines: Sequence[LineString]) -> set[int]:
        """Bodies that the lines touch at all."""
        _, j = self._tree.query(np.array(lines, dtype=object), predicate="intersects")
        return {self._owners[int(index)] for index in j}


def contact(hinge: Hinge, holes: Sequence[MultiPolygon], layers: Sequence[LayerIndex]) -> Contact:
    """The bodies on both sides of a hinge: in its flexible layer, or where that has no material near the
    line, in all layers that it runs through."""
    flexible = hinge.properties.layer
    width = hinge.properties.width
    free = free_parts(hinge, holes[flexible])
    near = [_parallels(free, sign * REACH * width) for sign in (1, -1)]
    sides = [_bodies(lines, [layers[flexible]], width) for lines in near]
    if not any(sides):
        far = [_parallels(free, sign * OPEN_REACH * width) for sign in (1, -1)]
        sides = [_bodies(lines, [layers[i] for i in hinge.layers], width) for lines in far]
    joined = {*sides[0], *sides[1]}
    bridges: tuple[int, ...] = ()
    if len(joined) == 1:
        outside = [i for i in range(len(layers)) if i not in hinge.layers]
        bridges = tuple(i for i in outside if joined & set(_bodies(free, [layers[i]], width)))
    strays = _strays(hinge, near, joined, layers) if joined else ()
    return Contact(sides[0], sides[1], sum(part.length for part in free), bridges, strays)


def _strays(
    hinge: Hinge, near: Sequence[Sequence[LineString]], joined: set[int], layers: Sequence[LayerIndex]
) -> tuple[tuple[int, tuple[int, ...]], ...]:
    """Layers of the hinge where its slit lies between bodies, and not between those that it joins."""
    found = []
    for i in hinge.layers:
        if layers[i].touched([*near[0], *near[1]]) <= joined:
            continue
        left, right = (_bodies(lines, [layers[i]], hinge.properties.width) for lines in near)
        others = {*left, *right} - joined
        if left and right and others:
            found.append((i, tuple(sorted(others))))
    return tuple(found)


def free_parts(hinge: Hinge, hole: MultiPolygon) -> list[LineString]:
    """The stretches of a hinge line that no hole has taken, in the line's direction."""
    left = shapely.get_parts(shapely.difference(hinge.line, hole))
    start = np.array(hinge.line.coords[0])
    along = np.array(hinge.line.coords[-1]) - start
    stretches = []
    for part in left[~shapely.is_empty(left)]:
        ends = sorted(np.array(part.coords), key=lambda point: float((point - start) @ along))
        stretches.append(LineString([ends[0], ends[-1]]))
    return stretches


def _bodies(lines: Sequence[LineString], layers: Sequence[LayerIndex], width: float) -> tuple[int, ...]:
    """Bodies that hold more of the lines, in one of the layers, than a corner would."""
    if not lines:
        return ()
    lengths: dict[int, float] = {}
    for layer in layers:
        for body, length in layer.along(lines).items():
            lengths[body] = max(length, lengths.get(body, 0.0))
    return tuple(sorted(body for body, length in lengths.items() if length > SHORTEST * width))


def _parallels(free: Sequence[LineString], distance: float) -> list[LineString]:
    """The stretches shifted by `distance` m, positive to the left."""
    return [_parallel(part, distance) for part in free if part.length > 0.0]


def _parallel(line: LineString, distance: float) -> LineString:
    a, b = np.array(line.coords)
    along = (b - a) / np.linalg.norm(b - a)
    shift = distance * np.array([-along[1], along[0]])
    return LineString([a + shift, b + shift])
