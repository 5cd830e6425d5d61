"""Lines of a drawing that part nothing: gaps, which are refused, and what is left out.

In: the graph and which of its edges part something. Out: mends. Never: leaves out a line that a little healing would
join to what is near: that line was meant.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from shapely import STRtree

from lamc.basics.errors import DesignError
from lamc.readers.drawings.heal import CREASES, MOST, OUTLINES, Graph, size_of
from lamc.readers.drawings.telling import millimetres, name_of
from lamc.readers.fold_groups import pieces_of
from lamc.records.drawing import STRAY, Mend, Role, Stroke

# Of the size: ends of one line that are farther apart are a side that is missing, and not to be joined.
_SLIP = 0.02
# Of a crease that is the rim, and of the size: a longer line from its end is an outline that goes on there, not a cut,
# which is a slit.
_OVER, _RUN_OVER = 0.25, 0.1
_ON = 1e-6  # of the root of an area: what is nearer to its border lies on it
_CLOSING = "Z at the end of a path, or the closed flag of a polyline"
_GAP = 0.5  # of the length of what dangles: an end that is nearer to another line was to meet it


@dataclass(frozen=True, order=True)
class _Gap:
    apart: float  # m
    vertex: int
    stroke: int
    other: int


class GapsError(DesignError):
    """Lines end near to others, as many as `count`."""

    count: int = 0


def left_out(
    graph: Graph, strokes: Sequence[Stroke], kept: Sequence[int], tolerance: float, option: str = "--heal"
) -> list[Mend]:
    """A mend for each stroke of which something is left out. option: what sets the tolerance.

    Raises GapsError where the end of an outline or a crease has another line near to it, with the tolerance that
    joins them, with a tolerance of 0 of an outline alone; DesignError for an outline that is open.
    """
    gone = sorted(set(range(len(graph.edges))) - set(kept))
    found: dict[int, Mend] = {}
    meant = OUTLINES | CREASES if tolerance else OUTLINES
    tips = [k for k in gone if strokes[graph.strokes[k]].role in meant]
    gaps = _gaps(graph, gone, tips, {v for k in kept for v in graph.edges[k]})
    if gaps:
        error = GapsError(_gaps_text(graph, strokes, gaps, tolerance, option))
        error.count = len(gaps)
        raise error
    _check_closed(graph, strokes, gone, kept)
    for k in gone:
        owner = graph.strokes[k]
        x, y = graph.points[list(graph.edges[k])].mean(axis=0).tolist()
        found.setdefault(owner, Mend(STRAY, (x, y), 0.0, name_of(strokes, owner)))
    return list(found.values())


def _check_closed(graph: Graph, strokes: Sequence[Stroke], gone: Sequence[int], kept: Sequence[int]) -> None:
    """Raises DesignError for an outline that goes on where nothing is parted any more: one of its sides is missing, and
    with it the facets along it would be. What runs over a corner of an outline, or touches it, goes on beside it."""
    ends = np.bincount(np.array(graph.edges, dtype=int).ravel(), minlength=len(graph.points))
    has_outlines = any(stroke.role in OUTLINES for stroke in strokes)
    rims = OUTLINES if has_outlines else frozenset[Role](("cut",))  # of a drawing that has nothing else
    loose = [k for k in gone if strokes[graph.strokes[k]].role in rims]
    if not loose:
        return
    rim = [k for k in _about_all(graph, kept) if strokes[graph.strokes[k]].role in OUTLINES | {"cut"}]
    around = np.bincount(
        np.array([graph.edges[k] for k in rim], dtype=int).ravel(), minlength=len(graph.points)
    )
    odd = set(np.flatnonzero(around % 2).tolist())  # where a rim goes on along a crease, or not at all
    waiting: dict[int, tuple[int, int]] = {}  # of those where a line goes on: its stroke, and where that ends
    is_open = False
    for piece in pieces_of(loose, _touching(graph, loose)):
        vertices = {v for k in piece for v in graph.edges[k]}
        tips = [v for v in sorted(vertices) if ends[v] == 1]
        if tips:
            waiting |= dict.fromkeys(sorted(odd & vertices), (graph.strokes[piece[0]], tips[0]))
            # Of one end alone: a line that runs over a corner is short beside the crease that is the rim there.
            length = sum(math.dist(*graph.points[list(graph.edges[k])]) for k in piece)
            others = [
                math.dist(graph.points[v], graph.points[w]) for v in odd & vertices for w in odd - vertices
            ]
            longest = max(_OVER * min(others, default=0.0), _RUN_OVER * size_of(strokes))
            is_open |= bool(odd & vertices) and has_outlines and length > longest
    if is_open or len(waiting) > 1:
        owner, tip = next(iter(waiting.values()))
        raise DesignError(
            f"the outline is open: {name_of(strokes, owner)} ({strokes[owner].role}) ends at "
            f"{millimetres(graph.points[tip])}, and facets along it would be lost: close it "
            f"({_CLOSING}), or draw the side that is missing"
        )


def _about_all(graph: Graph, kept: Sequence[int]) -> list[int]:
    """Of the edges that part something those with nothing enclosed on one side."""
    lines = shapely.linestrings(
        graph.points[np.array([graph.edges[k] for k in kept], dtype=int).reshape(-1, 2)]
    )
    enclosed = shapely.union_all(shapely.get_parts(shapely.polygonize(lines)))
    middles = shapely.line_interpolate_point(lines, 0.5, normalized=True)
    apart = shapely.distance(shapely.boundary(enclosed), middles)
    return [k for k, far in zip(kept, apart.tolist(), strict=True) if far <= _ON * math.sqrt(enclosed.area)]


def _touching(graph: Graph, edges: Sequence[int]) -> list[tuple[int, int]]:
    """Pairs of these edges that have a vertex in common."""
    at: dict[int, int] = {}
    return [(at.setdefault(v, k), k) for k in edges for v in graph.edges[k]]


def _gaps(graph: Graph, gone: Sequence[int], meant: Sequence[int], held: set[int]) -> list[_Gap]:
    """The nearest line to each end of `meant` that dangles, where it is near; ascending.

    held  vertices of what is kept
    """
    ends = np.bincount(np.array(graph.edges, dtype=int).ravel(), minlength=len(graph.points))
    tips = {v: k for k in meant for v in graph.edges[k] if ends[v] == 1}
    if not tips:
        return []
    lengths = _lengths(graph, gone, held)
    lines = shapely.linestrings(graph.points[np.array(graph.edges)])
    tree = STRtree(lines)
    nearest: list[_Gap] = []
    for v, edge in sorted(tips.items()):
        owner = graph.strokes[edge]
        reach = _GAP * lengths[edge]
        dot = shapely.Point(graph.points[v])
        found = []
        for s in tree.query(dot, predicate="dwithin", distance=reach).tolist():
            apart = float(shapely.distance(dot, lines[s]))
            if graph.strokes[s] == owner:  # only the other end of an open outline
                tip = [w for w in graph.edges[s] if w != v and w in tips]
                apart = math.dist(graph.points[v], graph.points[tip[0]]) if tip else 0.0
            if 0.0 < apart < reach:
                found.append(_Gap(apart, v, owner, graph.strokes[s]))
        nearest += [min(found)] if found else []
    return sorted(nearest)


def _lengths(graph: Graph, gone: Sequence[int], held: set[int]) -> dict[int, float]:
    """m, for each edge that parts nothing: of all edges of its stroke that dangle together with it."""
    at: dict[tuple[int, int], int] = {}
    pairs = []
    for k in gone:
        for v in graph.edges[k]:
            if v not in held:
                pairs.append((at.setdefault((v, graph.strokes[k]), k), k))
    found: dict[int, float] = {}
    for piece in pieces_of(gone, pairs):
        total = sum(math.dist(*graph.points[list(graph.edges[k])]) for k in piece)
        found |= dict.fromkeys(piece, total)
    return found


def _gaps_text(
    graph: Graph, strokes: Sequence[Stroke], gaps: Sequence[_Gap], tolerance: float, option: str
) -> str:
    shown = [
        f"{name_of(strokes, gap.stroke)} ({strokes[gap.stroke].role}) ends at {millimetres(graph.points[gap.vertex])}, "
        f"{1e3 * gap.apart:.3g} mm from {name_of(strokes, gap.other)}"
        for gap in gaps[:4]
    ]
    others = f", and {len(gaps) - 4} more such ends" if len(gaps) > 4 else ""
    creases = any(strokes[gap.stroke].role in CREASES for gap in gaps)
    leave = f"; with {option} 0, creases that end so are left out" if creases else ""
    opened = any(gap.stroke == gap.other for gap in gaps)
    enough, most = _enough(gaps[-1].apart), 1e3 * (_SLIP if opened else MOST) * size_of(strokes)
    more = f", or heal more: {option} '{enough} mm'" if float(enough) <= most else ""
    close = f"; {_CLOSING} closes an outline" if opened and not more else ""
    return (
        f"healed within {1e3 * tolerance:.3g} mm, lines still stop short of one another: {'; '.join(shown)}{others}. "
        f"Draw them to meet{more}{close}{leave}"
    )


def _enough(apart: float) -> str:
    """mm, rounded up to two digits, with one in a hundred to spare."""
    length = 1.01e3 * apart
    step = 10.0 ** (math.floor(math.log10(length)) - 1)
    return f"{math.ceil(length / step) * step:.2g}"
