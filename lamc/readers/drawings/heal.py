"""Healing: strokes become a planar graph of edges that meet at vertices only, and every change is told as a `Mend`.

In: strokes, m, and the distance by which they may be off. Out: vertices, edges with the stroke of each, mends. Never:
closes a gap that is wider than the tolerance; depends on the order of strokes or on their directions, but for names.

A crossing and an end that lies on a line are no defects: lines are parted there, and nothing is told. Points of one
stroke are not joined with one another, but its ends: curves are flattened to pieces shorter than a large tolerance.
"""

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import shapely

from lamc.basics.errors import DesignError
from lamc.readers.drawings.geometry import (
    Segments,
    crossing,
    drawn,
    gathered,
    meeting,
    near_pairs,
)
from lamc.readers.drawings.telling import names_of
from lamc.readers.fold_faces import NEAR, Edge, Indices, crossing_pairs
from lamc.records.drawing import ROLES, Mend, Role, Stroke
from lamc.records.mechanism import Array

DEFAULT = 1e-4  # of the drawing's size: two decimals of a pixel in a drawing of 500 leave 3e-5; a laser's kerf is more
MOST_EDGES = 100_000  # 5 s, and far more facets than are ever run
_ROUNDS = 50  # of parting lines where they meet; each mends what the one before it moved, three are usual
MOST = 0.05  # of the size: lines that are farther apart were not meant to meet
OUTLINES = frozenset[Role]({"border", "hole"})
CREASES = frozenset[Role]({"mountain", "valley", "hinge", "undriven"})


@dataclass(frozen=True)
class Graph:
    """points (n, 2), m, ascending by x and y; edges ascending, the lower vertex first; `strokes`: the stroke of each
    edge, by its index."""

    points: Array
    edges: tuple[Edge, ...]
    strokes: tuple[int, ...]
    mends: tuple[Mend, ...]


def size_of(strokes: Iterable[Stroke]) -> float:
    """The wider side of the box around all strokes, m; 1 for none."""
    boxes = np.array([[s.points.min(axis=0), s.points.max(axis=0)] for s in strokes])
    return float((boxes[:, 1].max(axis=0) - boxes[:, 0].min(axis=0)).max()) or 1.0 if len(boxes) else 1.0


def check_tolerance(asked: float, size: float, option: str = "--heal") -> None:
    """Raises DesignError for a tolerance, m, within which a drawing of that size, m, would lose its shape."""
    if asked > MOST * size:
        raise DesignError(
            f"the tolerance of healing is {1e3 * asked:g} mm, and the drawing {1e3 * size:.3g} mm wide: it must be at "
            f"most {1e3 * MOST * size:.3g} mm; numbers without a unit are metres: {option} '0.1 mm'"
        )


def healed(strokes: Sequence[Stroke], tolerance: float) -> Graph:
    """The graph of the strokes. tolerance: m; 0: lines are parted and doubled ones left out, and nothing moves.

    Raises DesignError for more edges than are read, and where a tolerance is so large that lines fall together.
    """
    if sum(len(stroke.points) for stroke in strokes) > MOST_EDGES:
        raise _too_many()
    return _Healer(strokes, tolerance).graph()


def check_crossings(ends: Array) -> None:
    """Raises DesignError where lines (n, 2, 2) cross so often that more edges would come of it than are read."""
    turned = np.lexsort((ends[..., 1], ends[..., 0]), axis=1)
    ordered = np.take_along_axis(ends, turned[..., None], axis=1)
    # Of lines drawn again one will do; that they do not cross one another takes long to tell.
    grid = NEAR * (float(np.ptp(ends.reshape(-1, 2), axis=0).max()) if len(ends) else 0.0) or 1.0
    _, once = np.unique(np.round(ordered.reshape(-1, 4) / grid), axis=0, return_index=True)
    if len(crossing_pairs(shapely.linestrings(ends[once]), MOST_EDGES)[0]) > MOST_EDGES:
        raise _too_many()


class _Healer:
    """One drawing. `at`: places of vertices; `segments`: what runs between them; `ends`: (vertex, stroke)."""

    def __init__(self, strokes: Sequence[Stroke], tolerance: float) -> None:
        self.strokes = strokes
        self.exact = NEAR * size_of(strokes)
        self.near = max(tolerance, self.exact)
        self.mends: list[Mend] = []
        self.doubled: dict[tuple[int, int], tuple[float, float]] = {}
        self.at, self.segments, self.ends = drawn(self._courses())

    def graph(self) -> Graph:
        check_crossings(self.at[self.segments.pairs()])
        self._join(self.exact)
        if self.near > self.exact:
            self._join(self.near)
        for _ in range(_ROUNDS):
            self._leave_doubled()
            if len(self.segments) > MOST_EDGES:
                raise _too_many()
            if not (self._part_at_vertices() or self._part_at_crossings() or self._cut_back()):
                return self._ordered()
            self._join(self.exact)
        raise DesignError(
            f"lines that are {self.near:g} m apart fall together again and again; heal with less"
        )

    def _courses(self) -> Iterator[tuple[int, Array, bool]]:
        """Points of each stroke, and whether they close: closed dots are left out, an open one runs from end to end."""
        for k, stroke in enumerate(self.strokes):
            points = np.asarray(stroke.points, dtype=float)
            wide = float(np.linalg.norm(np.ptp(points, axis=0)))
            if wide > self.near:
                yield k, points, stroke.closed
            elif stroke.closed:
                self._tell("stray mark", points[0], wide, stroke.source)
            else:
                yield k, points[[0, -1]], False

    def _join(self, near: float) -> None:
        """Points that are nearer than `near` become one, the one where most lines end."""
        used = np.unique(self.segments.pairs())
        unique, inverse = np.unique(self.at[used], axis=0, return_inverse=True)
        number = np.full(len(self.at), -1)
        number[used] = inverse.ravel()
        self._renumber(unique, number)
        weight = self.segments.degrees(len(self.at))
        if near == self.exact:  # rounding, of which nothing is told
            self._renumber(self.at, gathered(self.at, weight, near, lambda a, b: True))
            return
        touching = self._touching()

        def may_join(a: int, b: int) -> bool:
            return all((v, k) in self.ends for k in touching[a] & touching[b] for v in (a, b))

        kept = gathered(self.at, weight, near, may_join)
        places = self.at.copy()
        for a, others in _groups(kept):
            if len(others) == 1 and weight[a] == weight[others[0]] == 1:
                self._meet(places, a, others[0])
            for b in others:
                moved = max(float(np.linalg.norm(places[a] - self.at[v])) for v in (a, b))
                beyond = touching[a] - touching[b]
                source = self._sources(touching[b]) + (f" at {self._sources(beyond)}" if beyond else "")
                self._tell(self._joint(touching[a], touching[b]), places[a], moved, source)
        self._renumber(places, kept)

    def _joint(self, first: set[int], second: set[int]) -> str:
        """What joins two places, by the strokes that they are of."""
        if first == second and all(len(self.strokes[k].points) == 2 for k in first):
            return "stray mark"
        if all(any(self.strokes[k].role in OUTLINES for k in each) for each in (first, second)):
            return "gap in an outline"
        return "end points joined"

    def _meet(self, places: Array, a: int, b: int) -> None:
        """Two lines that stop short of one corner are drawn on to it."""
        lines = [self.segments.line_at(v, self.at) for v in (a, b)]
        corner = meeting(*lines[0], *lines[1])
        if corner is not None and max(np.linalg.norm(corner - self.at[v]) for v in (a, b)) <= self.near:
            places[a] = corner

    def _renumber(self, places: Array, kept: Indices) -> None:
        self.at = places
        self.segments = self.segments.renumbered(kept)
        self.ends = {(int(kept[v]), k) for v, k in self.ends if kept[v] >= 0}

    def _touching(self) -> list[set[int]]:
        """Strokes at each vertex."""
        found: list[set[int]] = [set() for _ in self.at]
        for a, b, k in self.segments.rows():
            found[a].add(k)
            found[b].add(k)
        return found

    def _part_at_vertices(self) -> bool:
        """Parts lines at vertices that are near to them, which move onto them; True where one was."""
        vertices, lines, apart = near_pairs(self.at, self.segments, self.near, self.exact)
        if not len(vertices):
            return False
        touching = self._touching()
        owner = self.segments.owner
        cuts: dict[int, list[int]] = {}
        beside: dict[int, list[int]] = {}
        for v, s, d in zip(vertices.tolist(), lines.tolist(), apart.tolist(), strict=True):
            k = int(owner[s])
            if d > self.exact and k in touching[v] and (v, k) not in self.ends:
                continue
            cuts.setdefault(s, []).append(v)
            if d > self.exact:
                beside.setdefault(v, []).append(s)
        degree = self.segments.degrees(len(self.at))
        places = self.at.copy()
        for v in sorted(beside):
            places[v] = self._moved(v, beside[v], int(degree[v]), touching[v])
            for s in self._not_parted(beside[v], places[v]):
                cuts[s].remove(v)
        self.segments = self.segments.parted(cuts, self.at)
        self.at = places
        return bool(cuts)

    def _not_parted(self, lines: Sequence[int], place: Array) -> list[int]:
        """Which of the lines beside a vertex are not parted where it went: that end there, or are the other side of a
        corner of one that it went onto."""
        where = {s: self._along(s, place) for s in lines}
        corners = {
            v
            for s, (_, apart, _) in where.items()
            if apart <= self.exact
            for v in (int(self.segments.a[s]), int(self.segments.b[s]))
        }
        found = []
        for s, (share, apart, length) in where.items():
            margin = self.exact if apart <= self.exact else self.near
            is_other = apart > self.exact and not corners.isdisjoint(
                (int(self.segments.a[s]), int(self.segments.b[s]))
            )
            if is_other or not margin < share < length - margin:
                found.append(s)
        return found

    def _along(self, s: int, place: Array) -> tuple[float, float, float]:
        """How far along a line the foot of a place is, how far the place is from it, and the line's length, m."""
        a, b = self.at[self.segments.a[s]], self.at[self.segments.b[s]]
        length = float(np.linalg.norm(b - a))
        share = float((place - a) @ (b - a)) / length
        return share, float(np.linalg.norm(a + share / length * (b - a) - place)), length

    def _moved(self, v: int, lines: Sequence[int], degree: int, strokes: set[int]) -> Array:
        """Where a vertex goes that lies beside lines: along its own line, if it is the end of one, else straight."""
        place = self.at[v]
        chosen = min(lines, key=lambda s: (self._rank(int(self.segments.owner[s])), -self._length(s), s))
        a, b = self.at[self.segments.a[chosen]], self.at[self.segments.b[chosen]]
        length = float(np.linalg.norm(b - a))
        along = (b - a) / length
        target: Array = a + float((place - a) @ along) * along
        what = "T-junction"
        kind = "hinge" if any(self.strokes[k].role in CREASES for k in strokes) else "line"
        if degree == 1:
            own = self.segments.line_at(v, self.at)
            found = meeting(*own, a, b)
            # Twice: at 30 degrees a line's end is twice as far from another, along itself, as straight across.
            if found is not None and float(np.linalg.norm(found - place)) <= 2.0 * self.near:
                target = found
                outward = float((found - place) @ (own[0] - own[1])) > 0.0
                what = f"{kind} extended" if outward else f"{kind} cut back"
        target = a + min(max(float((target - a) @ along), 0.0), length) * along  # no farther than to a corner
        other = self._sources([int(self.segments.owner[chosen])])
        moved = float(np.linalg.norm(target - place))
        self._tell(what, target, moved, f"{self._sources(strokes)} at {other}")
        return target

    def _length(self, s: int) -> float:
        return float(np.linalg.norm(self.at[self.segments.a[s]] - self.at[self.segments.b[s]]))

    def _part_at_crossings(self) -> bool:
        """Parts lines that cross; crossings nearer to one another than the tolerance become one vertex."""
        lines = shapely.linestrings(self.at[self.segments.pairs()])
        first, second = crossing_pairs(lines, MOST_EDGES)
        if not len(first):
            return False
        if len(first) > MOST_EDGES:
            raise _too_many()
        found = crossing(self.at, self.segments, first, second)
        order = np.lexsort((found[:, 1], found[:, 0]))
        found, first, second = found[order], first[order], second[order]
        kept = gathered(found, np.zeros(len(found), dtype=np.int64), self.near, lambda a, b: True)
        cuts: dict[int, list[int]] = {}
        base = len(self.at)
        for k, rep in enumerate(kept.tolist()):
            moved = float(np.linalg.norm(found[k] - found[rep]))
            pair = [int(first[k]), int(second[k])]
            if moved > self.exact:
                self._tell(
                    "crossings joined", found[rep], moved, self._sources(self.segments.owner[pair].tolist())
                )
            for s in pair:
                cuts.setdefault(s, []).append(base + rep)
        self.at = np.concatenate([self.at, found])
        self.segments = self.segments.parted({s: sorted(set(v)) for s, v in cuts.items()}, self.at)
        return True

    def _cut_back(self) -> bool:
        """Leaves out what ends no farther than the tolerance beyond a junction, as a curve may whose last piece is
        shorter than that: its end joins no point of its own stroke. True where something did. Of outlines nothing: they
        have gaps."""
        if self.near <= self.exact:
            return False
        degree = self.segments.degrees(len(self.at))
        touching: dict[int, list[int]] = {}
        for s, (a, b, _) in enumerate(self.segments.rows()):
            touching.setdefault(a, []).append(s)
            touching.setdefault(b, []).append(s)
        over: set[int] = set()
        for tip in np.flatnonzero(degree == 1).tolist():
            way, v, long = [touching[tip][0]], tip, 0.0
            while True:
                long += self._length(way[-1])
                v = int(self.segments.a[way[-1]] + self.segments.b[way[-1]]) - v
                if degree[v] != 2 or long > self.near:
                    break
                way += [s for s in touching[v] if s != way[-1]]
            strokes = sorted({int(self.segments.owner[s]) for s in way})
            roles = {self.strokes[k].role for k in strokes}
            if degree[v] > 2 and long <= self.near and not roles & OUTLINES:
                over.update(way)
                kind = "hinge" if roles & CREASES else "line"
                self._tell(f"{kind} cut back", self.at[v], long, self._sources(strokes))
        if over:
            self.segments = self.segments.without(over)
        return bool(over)

    def _leave_doubled(self) -> None:
        """Segments without length, and all but one of those between the same vertices."""
        best: dict[Edge, int] = {}
        for a, b, k in self.segments.rows():
            if a == b:
                continue
            edge = (min(a, b), max(a, b))
            other = best.get(edge, k)
            if other != k:
                kept, left = sorted((k, other), key=self._rank)
                where = 0.5 * (self.at[a] + self.at[b])
                self.doubled.setdefault((kept, left), (float(where[0]), float(where[1])))
                best[edge] = kept
            else:
                best[edge] = k
        self.segments = Segments.of([(a, b, k) for (a, b), k in best.items()])

    def _rank(self, k: int) -> tuple[int, bool, int]:
        """Which of two strokes counts: by role, then the one that says its angle, then the first."""
        stroke = self.strokes[k]
        return ROLES.index(stroke.role), stroke.angle is None, k

    def _tell(self, what: str, at: Array, moved: float, source: str) -> None:
        if moved > self.exact:
            self.mends.append(Mend(what, (float(at[0]), float(at[1])), moved, source))

    def _sources(self, strokes: Iterable[int]) -> str:
        return names_of(self.strokes, strokes)

    def _ordered(self) -> Graph:
        """Vertices by place and edges by vertices, so that numbers do not follow the order of the file."""
        for (kept, left), where in self.doubled.items():
            roles = self.strokes[kept].role, self.strokes[left].role
            angles = self.strokes[kept].angle, self.strokes[left].angle
            which = "" if roles[0] == roles[1] else f": {roles[0]} counts, not {roles[1]}"
            if OUTLINES.issuperset(roles):  # a line of an outline and of a hole is of both
                which = ""
            elif roles[0] == roles[1] and angles[1] is not None and angles[0] != angles[1]:
                which = f": {_degrees(angles[0])} counts, not {_degrees(angles[1])}"
            self.mends.append(Mend("doubled line", where, 0.0, self._sources((kept, left)) + which))
        used = np.unique(self.segments.pairs())
        order = used[np.lexsort((self.at[used, 1], self.at[used, 0]))]
        number = {int(v): k for k, v in enumerate(order)}
        rows = sorted((*sorted((number[a], number[b])), k) for a, b, k in self.segments.rows())
        mends = sorted(self.mends, key=lambda m: (m.what, m.at, m.source))
        return Graph(
            self.at[order], tuple((a, b) for a, b, _ in rows), tuple(k for _, _, k in rows), tuple(mends)
        )


def _groups(kept: Indices) -> list[tuple[int, list[int]]]:
    """Each vertex that others join, and those."""
    found: dict[int, list[int]] = {}
    for v in np.flatnonzero(kept != np.arange(len(kept))).tolist():
        found.setdefault(int(kept[v]), []).append(v)
    return sorted(found.items())


def _degrees(angle: float | None) -> str:
    return "no angle" if angle is None else f"{math.degrees(angle):.6g} degrees"


def _too_many() -> DesignError:
    return DesignError(
        f"the drawing has more than {MOST_EDGES} lines, curves flattened and lines parted where they cross; draw the "
        "sheet alone, or with coarser curves"
    )
