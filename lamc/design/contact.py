"""Contact: which bodies a hinge line touches.

In: hinges, holes, and bodies by layer. Out: for each hinge, the bodies on its left and on its right, the layers
that hold its two sides together, and those where it cuts what it does not join. It raises nothing: what a contact
means is for `split` to say.

Slits leave the material of both sides at SLIT hinge widths from the line. So the line is read off along two
parallels slightly further out, over the length that no hole has taken, in its flexible layer. Parallels
rather than a grown area: they tell the sides apart, and measure a contact in metres of hinge.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import STRtree
from shapely.geometry import LineString, MultiPolygon, Polygon

from lamc.design.cutting import SLIT
from lamc.design.steps import Hinge
from lamc.design.work import Geometries

# Distance of the parallels from the line, in hinge widths. Half as far again as the slit's edge: clear of
# round-off, and well inside one width, beyond which a neighbour's material may begin.
REACH = 1.5 * SLIT
# The same in layers other than the flexible one, which are mostly drawn open by one width.
OPEN_REACH = 1.05
# Contacts shorter than this many hinge widths are corners or overshooting ends, not hinges.
SHORTEST = SLIT
_NOTHING = MultiPolygon()


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


@dataclass(frozen=True, eq=False)
class Lines:
    """Straight lines, each of one hinge, by ascending index of the hinge."""

    shapes: Geometries  # (n,)
    hinges: NDArray[np.int64]  # (n,)

    def of(self, chosen: Sequence[int]) -> "Lines":
        """Those of the hinges of these indices."""
        is_chosen = np.zeros(int(self.hinges.max(initial=-1)) + 1, dtype=bool)
        is_chosen[[k for k in chosen if k < len(is_chosen)]] = True
        inside = is_chosen[self.hinges]
        return Lines(self.shapes[inside], self.hinges[inside])


class LayerIndex:
    """The polygons of all bodies in one layer, in a search tree."""

    def __init__(self, owned: Sequence[tuple[Polygon, int]]) -> None:
        """owned: polygons, each with the index of its body."""
        self._polygons = np.array([p for p, _ in owned], dtype=object)
        self._owners = np.array([body for _, body in owned], dtype=np.int64)
        self._tree = STRtree(self._polygons)

    def along(self, lines: Lines) -> dict[int, dict[int, float]]:
        """Hinge → body → length of the hinge's lines inside that body, m; no entry where they meet none."""
        which, piece = self._tree.query(lines.shapes, predicate="intersects")
        lengths = shapely.length(shapely.intersection(lines.shapes[which], self._polygons[piece])).tolist()
        inside: dict[int, dict[int, float]] = {}
        met = zip(lines.hinges[which].tolist(), self._owners[piece].tolist(), lengths, strict=True)
        for hinge, body, length in met:
            of_hinge = inside.setdefault(hinge, {})
            of_hinge[body] = of_hinge.get(body, 0.0) + length
        return inside

    def touched(self, lines: Lines) -> dict[int, set[int]]:
        """Hinge → bodies that its lines touch at all."""
        which, piece = self._tree.query(lines.shapes, predicate="intersects")
        found: dict[int, set[int]] = {}
        for hinge, body in zip(lines.hinges[which].tolist(), self._owners[piece].tolist(), strict=True):
            found.setdefault(hinge, set()).add(body)
        return found


def layer_indices(bodies: Sequence[tuple[tuple[Polygon, ...], ...]], count: int) -> list[LayerIndex]:
    """One of each layer; layers that have the same polygons share it."""
    owned = [[(p, k) for k, layers in enumerate(bodies) for p in layers[i]] for i in range(count)]
    keys = [tuple((id(p), k) for p, k in each) for each in owned]
    made = {key: LayerIndex(each) for key, each in dict(zip(keys, owned, strict=True)).items()}
    return [made[key] for key in keys]


def contacts(
    hinges: Sequence[Hinge], holes: Sequence[MultiPolygon], layers: Sequence[LayerIndex]
) -> tuple[Contact, ...]:
    """The bodies on both sides of each hinge: in its flexible layer, or where that has no material near the
    line, in all layers that it runs through."""
    free, count = _free_lines(hinges, holes), len(hinges)
    both = [*hinges, *hinges]
    near = _beside(free, hinges, REACH)
    sides = _bodies(near, both, [(h.properties.layer,) for h in both], layers)
    open_ones = [k for k in range(count) if not (sides[k] or sides[count + k])]
    if open_ones:
        far = _bodies(_beside(free.of(open_ones), hinges, OPEN_REACH), both, [h.layers for h in both], layers)
        for k in open_ones:
            sides[k], sides[count + k] = far[k], far[count + k]
    joined = [{*left, *right} for left, right in zip(sides[:count], sides[count:], strict=True)]
    bridges = _bridges(free, hinges, joined, layers)
    strays = _strays(hinges, near, joined, layers)
    lengths = np.bincount(free.hinges, shapely.length(free.shapes), count).tolist()
    return tuple(
        Contact(sides[k], sides[count + k], lengths[k], bridges.get(k, ()), strays.get(k, ()))
        for k in range(count)
    )


def free_parts(hinge: Hinge, hole: MultiPolygon) -> list[LineString]:
    """The stretches of a hinge line that no hole has taken, in the line's direction."""
    return list(_free([hinge], hole).shapes)


def _bridges(
    free: Lines, hinges: Sequence[Hinge], joined: Sequence[set[int]], layers: Sequence[LayerIndex]
) -> dict[int, tuple[int, ...]]:
    """For each hinge that touches a single body, the layers beside its own in which that body lies across it."""
    alone = [k for k, bodies in enumerate(joined) if len(bodies) == 1]
    found: dict[int, tuple[int, ...]] = {}
    for i, layer in enumerate(layers if alone else ()):
        across = layer.along(free.of(alone))
        for k in alone:
            if i not in hinges[k].layers and joined[k] & set(_long(across.get(k, {}), hinges[k])):
                found[k] = (*found.get(k, ()), i)
    return found


def _strays(
    hinges: Sequence[Hinge],
    near: Lines,
    joined: Sequence[set[int]],
    layers: Sequence[LayerIndex],
) -> dict[int, tuple[tuple[int, tuple[int, ...]], ...]]:
    """For each hinge, its layers where its slit lies between bodies, and not between those that it joins."""
    found: dict[int, tuple[tuple[int, tuple[int, ...]], ...]] = {}
    run = {i for k, bodies in enumerate(joined) if bodies for i in hinges[k].layers}
    known = {layer: layer.touched(near) for layer in dict.fromkeys(layers[i] for i in sorted(run))}
    for i in sorted(run):
        layer = layers[i]
        touched = known[layer]
        for k, bodies in enumerate(joined):
            if not bodies or i not in hinges[k].layers:
                continue
            here = (k, len(hinges) + k)
            if all(touched.get(side, set()) <= bodies for side in here):
                continue
            inside = layer.along(near.of(here))
            left, right = (_long(inside.get(side, {}), hinges[k]) for side in here)
            others = {*left, *right} - bodies
            if left and right and others:
                found[k] = (*found.get(k, ()), (i, tuple(sorted(others))))
    return found


def _bodies(
    lines: Lines, hinges: Sequence[Hinge], through: Sequence[tuple[int, ...]], layers: Sequence[LayerIndex]
) -> list[tuple[int, ...]]:
    """For each hinge, the bodies that hold more of its lines, in one of the layers `through`, than a corner would."""
    lengths: list[dict[int, float]] = [{} for _ in hinges]
    for i, layer in enumerate(layers):
        chosen = [k for k, its in enumerate(through) if i in its]
        if not chosen:
            continue
        for k, inside in layer.along(lines.of(chosen)).items():
            for body, length in inside.items():
                lengths[k][body] = max(length, lengths[k].get(body, 0.0))
    return [_long(each, hinge) for each, hinge in zip(lengths, hinges, strict=True)]


def _long(lengths: Mapping[int, float], hinge: Hinge) -> tuple[int, ...]:
    """Bodies that hold more of a hinge's lines than a corner would."""
    return tuple(sorted(b for b, length in lengths.items() if length > SHORTEST * hinge.properties.width))


def _free_lines(hinges: Sequence[Hinge], holes: Sequence[MultiPolygon]) -> Lines:
    """The stretches of all hinge lines that holes of their flexible layers have left, ordered by hinge."""
    made = []
    for i, hole in enumerate(holes):
        chosen = [k for k, h in enumerate(hinges) if h.properties.layer == i]
        if chosen:
            free = _free([hinges[k] for k in chosen], hole)
            made.append(Lines(free.shapes, np.array(chosen)[free.hinges]))
    owners = np.concatenate([each.hinges for each in made])
    order = np.argsort(owners, kind="stable")
    return Lines(np.concatenate([each.shapes for each in made])[order], owners[order])


def _free(hinges: Sequence[Hinge], hole: MultiPolygon) -> Lines:
    """The stretches that a layer's holes leave of hinge lines, in the lines' directions, ordered by hinge."""
    drawn = np.array([h.line for h in hinges], dtype=object)
    parts = shapely.get_parts(hole)
    which, near = STRtree(parts).query(drawn, predicate="intersects")
    order = np.argsort(which, kind="stable")
    # Each line less the holes that it meets: those far away would only cost time.
    local = np.full(len(drawn), _NOTHING, dtype=object)
    shapely.multipolygons(parts[near[order]], indices=which[order], out=local)
    whole = drawn if not len(which) else shapely.difference(drawn, local)
    left, owner = shapely.get_parts(whole, return_index=True)
    solid = ~shapely.is_empty(left)
    left, owner = left[solid], owner[solid]
    start, end = shapely.get_coordinates(drawn).reshape(-1, 2, 2).transpose(1, 0, 2)
    points, part = shapely.get_coordinates(left, return_index=True)
    hinge = owner[part]
    order = np.lexsort([((points - start[hinge]) * (end - start)[hinge]).sum(axis=1), part])
    first = np.searchsorted(part, np.arange(len(left)))
    last = np.append(first[1:], len(points)) - 1
    ends = points[np.column_stack([order[first], order[last]])] if len(left) else np.zeros((0, 2, 2))
    return Lines(shapely.linestrings(ends), owner)


def _beside(free: Lines, hinges: Sequence[Hinge], widths: float) -> Lines:
    """The stretches shifted by so many hinge widths to the left, and to the right: these with the number of hinges
    added to their index. Those without length have no side."""
    ends = shapely.get_coordinates(free.shapes).reshape(-1, 2, 2)
    along = ends[:, 1] - ends[:, 0]
    length = np.hypot(along[:, 0], along[:, 1])
    clear = length > 0.0
    ends, along, owner = ends[clear], along[clear] / length[clear, None], free.hinges[clear]
    shift = np.array([h.properties.width for h in hinges])[owner] * widths
    across = shift[:, None] * np.column_stack([-along[:, 1], along[:, 0]])
    sides = np.concatenate([ends + across[:, None], ends - across[:, None]])
    return Lines(shapely.linestrings(sides), np.concatenate([owner, owner + len(hinges)]))
