"""Outlines as they were drawn: closed strokes, and strokes that join end to end to a ring, wherever it touches others.

In: strokes, and the healed graph of them. Out: outlines, and which strokes are of none. Never: tells what is material.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from shapely import STRtree
from shapely.geometry.base import BaseGeometry

from lamc.readers.drawings.heal import Graph
from lamc.records.drawing import Role, Stroke
from lamc.records.mechanism import Array


@dataclass(frozen=True, eq=False)
class Outline:
    """What an outline encloses; is_patched: strokes that are no ring do."""

    shape: BaseGeometry
    is_hole: bool
    is_patched: bool = False


def rings_of(
    graph: Graph, strokes: Sequence[Stroke], roles: frozenset[Role]
) -> tuple[list[Outline], set[int]]:
    """Closed strokes of those roles and rings of open ones, and the numbers of all others."""
    chosen = [k for k, stroke in enumerate(strokes) if stroke.role in roles]
    found: list[Outline] = []
    others: set[int] = set()
    open_ones: dict[Role, list[int]] = {}
    for k in chosen:
        stroke = strokes[k]
        shape = shapely.Polygon(stroke.points) if stroke.closed and len(stroke.points) > 2 else None
        if shape is not None and shape.is_valid and shape.area > 0.0:
            found.append(Outline(shape, stroke.role == "hole"))
        elif stroke.closed:
            others.add(k)
        else:
            open_ones.setdefault(stroke.role, []).append(k)
    vertices = STRtree(shapely.points(graph.points))
    for role, numbers in open_ones.items():
        ends = vertices.nearest(shapely.points([strokes[k].points[e] for k in numbers for e in (0, -1)]))
        pairs = dict(zip(numbers, ends.reshape(-1, 2).tolist(), strict=True))
        straight = {k for k in numbers if len(strokes[k].points) == 2}
        for chain in _chains(pairs, straight):
            corners = _corners(graph, strokes, pairs, chain)
            shape = shapely.Polygon(corners) if len(corners) > 2 else shapely.Polygon()
            if shape.is_valid and shape.area > 0.0:
                found.append(Outline(shape, role == "hole"))
                for k in chain:
                    del pairs[k]
        # What is shorter than points are apart is of no outline.
        others |= {k for k, (a, b) in pairs.items() if a != b or len(strokes[k].points) > 2}
    return found, others


def _chains(pairs: Mapping[int, list[int]], straight: set[int]) -> list[list[int]]:
    """Rings of strokes, by number, each from one end to the next: those that end where they begin, those that follow
    one another in the file, then those of what is left in which two ends meet wherever one is.

    pairs     ends of each stroke, vertices
    straight  strokes without a corner
    """
    loops = [[k] for k, (a, b) in pairs.items() if a == b]
    left = {k: ends for k, ends in pairs.items() if ends[0] != ends[1]}
    in_a_row = list(_in_a_row(left, straight))
    drawn = {k for chain in in_a_row for k in chain}
    return [*loops, *in_a_row, *_closed({k: ends for k, ends in left.items() if k not in drawn})]


def _in_a_row(pairs: dict[int, list[int]], straight: set[int]) -> Iterator[list[int]]:
    """Strokes each of which begins where the one before it in the file ends, to where the first begins. One that is the
    line before it, drawn again, is taken out of `pairs`."""
    chain: list[int] = []
    start = end = -1
    for k, (a, b) in list(pairs.items()):
        if chain and {chain[-1], k} <= straight and {a, b} == set(pairs[chain[-1]]):
            del pairs[k]
            continue
        if chain and end in (a, b):
            chain.append(k)
            end = b if end == a else a
        elif len(chain) == 1 and start in (a, b):  # the first was drawn the other way
            start, end = end, b if start == a else a
            chain.append(k)
        else:
            chain, start, end = [k], a, b
        if start == end:
            yield chain
            chain = []


def _closed(pairs: Mapping[int, list[int]]) -> Iterator[list[int]]:
    """Strokes that hold together, of which two ends meet wherever one is."""
    at: dict[int, list[int]] = {}
    for k, ends in pairs.items():
        for v in ends:
            at.setdefault(v, []).append(k)
    seen: set[int] = set()
    for first in pairs:
        if first not in seen:
            chain = _walked(first, pairs, at)
            seen |= set(chain)
            if all(len(at[v]) == 2 for k in chain for v in pairs[k]):
                yield chain


def _walked(first: int, pairs: Mapping[int, list[int]], at: Mapping[int, list[int]]) -> list[int]:
    """Strokes from one to the next, from the end of the first on, until there is none that was not passed."""
    chain, passed, end = [first], {first}, pairs[first][1]
    while True:
        following = next((k for k in at[end] if k not in passed), None)
        if following is None:
            return chain
        chain.append(following)
        passed.add(following)
        a, b = pairs[following]
        end = b if end == a else a


def _corners(
    graph: Graph, strokes: Sequence[Stroke], pairs: Mapping[int, list[int]], chain: Sequence[int]
) -> Array:
    """Corners (n, 2) of a ring of strokes; ends are where healing has put them."""
    if len(chain) == 1:
        return strokes[chain[0]].points
    a, b = pairs[chain[0]]
    end = a if a not in pairs[chain[1]] else b if b not in pairs[chain[1]] else a
    points: list[Array] = []
    for k in chain:
        start, other = pairs[k]
        forward = start == end
        own = strokes[k].points if forward else strokes[k].points[::-1]
        points += [graph.points[[end]], own[1:-1]]
        end = other if forward else start
    return np.concatenate(points)
