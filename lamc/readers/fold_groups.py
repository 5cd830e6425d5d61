"""Which facets of a drawn sheet are one body, and which edges are one hinge.

In: edges with their kinds and the faces beside them. Out: groups of faces, hinges between them. Never: drops an edge
without a note.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from lamc.readers.fold_faces import Edge
from lamc.readers.fold_file import FoldFrame
from lamc.readers.fold_flat import Beside, Corners, pair_of
from lamc.records.mechanism import Array
from lamc.records.network import listed_names

IN_LINE = 1e-6  # of the sheet's size: ends of pieces that lie so near to a line are on it
_FLAT = 1e-3  # rad; an edge F folded by more is a hinge


@dataclass(frozen=True)
class Crease:
    """Pieces of one hinge, edges by number, ascending."""

    edges: tuple[int, ...]
    groups: tuple[int, int]  # lowest faces of the bodies, ascending


def joined_edges(frame: FoldFrame, beside: Beside, notes: list[str]) -> list[int]:
    """Edges along which two facets hold together; what is marked otherwise than it lies is told."""
    kinds = frame.kinds
    joined = [
        k for k, (a, b) in enumerate(beside) if a is not None and b is not None and kinds[k] not in "BC"
    ]
    inner = [k for k, (a, b) in enumerate(beside) if kinds[k] == "B" and a is not None and b is not None]
    if inner:
        named = "drawn as outlines" if frame.sources else "marked B"
        notes.append(f"{frame.edges_named(inner)} {named} with a facet on either side: taken for cuts (C)")
    rim = [k for k, pair in enumerate(beside) if kinds[k] in "MV" and (pair[0] is None) != (pair[1] is None)]
    if rim:
        named = "drawn as creases" if frame.sources else "marked M or V"
        notes.append(f"{frame.edges_named(rim)} {named} with a facet on one side only: taken for the rim (B)")
    alone = [k for k, pair in enumerate(beside) if pair == (None, None)]
    if alone and frame.faces is not None:  # where facets are looked for, what parts none is told there
        notes.append(
            f"{frame.edges_named(alone)}: beside no facet that the file lists; left out, and no hinge"
        )
    return joined


def grouped(
    frame: FoldFrame,
    beside: Beside,
    joined: Sequence[int],
    corners: Corners,
    angles: Mapping[int, float],
    together: Sequence[Sequence[int]],
    size: float,
    notes: list[str],
) -> tuple[list[int], list[Crease]]:
    """The lowest face of each face's body, and the hinges in the order of their first edges.

    together  faces that are one body because the file says so
    """
    kinds, edges = frame.kinds, frame.edges
    union = _Union(len(corners))
    for faces in together:
        for face in faces[1:]:
            union.join(faces[0], face)
    bent = [k for k in joined if kinds[k] in "FJ" and abs(angles.get(k, 0.0)) > _FLAT]
    if bent:
        notes.append(f"{frame.edges_named(bent)} marked F or J, and folded: taken for hinges")
    for k in joined:
        if kinds[k] in "FJ" and k not in bent:
            union.join(*pair_of(beside, k))
    hinged = [k for k in joined if kinds[k] not in "FJ" or k in bent]
    while True:
        creases: dict[tuple[int, int], list[int]] = {}
        for k in hinged:
            a, b = (union.find(face) for face in pair_of(beside, k))
            if a != b:
                creases.setdefault((min(a, b), max(a, b)), []).append(k)
        off = max(IN_LINE * size, frame.off)
        askew = [pair for pair, found in creases.items() if not _in_line(found, edges, beside, corners, off)]
        if not askew:
            break
        notes.append(
            "two facets that meet along lines at an angle cannot turn and are one body: "
            + listed_names([f"F{a} and F{b} ({frame.edges_named(creases[(a, b)])})" for a, b in askew])
        )
        for a, b in askew:
            union.join(a, b)
    within = sorted(set(hinged) - {k for found in creases.values() for k in found})
    if within:
        notes.append(f"{frame.edges_named(within)} with one body on either side: no hinges")
    made = [Crease(tuple(found), pair) for pair, found in creases.items()]
    return [union.find(face) for face in range(len(corners))], sorted(made, key=lambda c: c.edges)


def ends_of(
    crease: Crease, edges: Sequence[Edge], beside: Beside, corners: Corners
) -> tuple[Array, Array, float]:
    """The outermost ends of a hinge's pieces, (2,) each, m, and the length of all, m."""
    places = np.array([corners[pair_of(beside, k)[0]][vertex] for k in crease.edges for vertex in edges[k]])
    lengths = np.linalg.norm(places[1::2] - places[::2], axis=1)
    longest = 2 * int(lengths.argmax())
    along = places[longest + 1] - places[longest]
    order = (places - places[0]) @ along
    return places[int(order.argmin())], places[int(order.argmax())], float(lengths.sum())


def _in_line(
    found: Sequence[int], edges: Sequence[Edge], beside: Beside, corners: Corners, off: float
) -> bool:
    if len(found) == 1:
        return True
    start, end, _ = ends_of(Crease(tuple(found), (0, 0)), edges, beside, corners)
    along = (end - start) / np.linalg.norm(end - start)
    places = np.array([corners[pair_of(beside, k)[0]][v] for k in found for v in edges[k]]) - start
    return bool(np.abs(places[:, 0] * along[1] - places[:, 1] * along[0]).max() <= off)


def pieces_of(items: Iterable[int], pairs: Iterable[tuple[int, int]]) -> list[list[int]]:
    """What hangs together, each piece ascending, in the order of their lowest items."""
    every = sorted(items)
    union = _Union(every[-1] + 1)
    for a, b in pairs:
        union.join(a, b)
    found: dict[int, list[int]] = {}
    for item in every:
        found.setdefault(union.find(item), []).append(item)
    return list(found.values())


class _Union:
    """Disjoint sets; the lowest member stands for each."""

    def __init__(self, count: int) -> None:
        self.above = list(range(count))

    def find(self, item: int) -> int:
        while self.above[item] != item:
            self.above[item] = self.above[self.above[item]]
            item = self.above[item]
        return item

    def join(self, a: int, b: int) -> None:
        a, b = self.find(a), self.find(b)
        self.above[max(a, b)] = min(a, b)
