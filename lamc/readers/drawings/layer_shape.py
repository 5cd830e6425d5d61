"""A layer of a drawing as a shape of material, or as hinge lines: for designs that take them from files.

In: a drawing, the name of one of its layers, how far lines may be off. Out: a region, or lines, and mends. Never: makes
a sheet of creases.
"""

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np
import shapely
from shapely import STRtree
from shapely.geometry import MultiPolygon
from shapely.geometry.base import BaseGeometry

from lamc.basics.errors import DesignError
from lamc.readers.drawings.heal import CREASES, DEFAULT, OUTLINES, Graph, check_tolerance, healed, size_of
from lamc.readers.drawings.loose import left_out
from lamc.readers.drawings.material import material_of
from lamc.readers.drawings.outlines import parting
from lamc.readers.drawings.telling import mend_notes, name_of
from lamc.readers.fold_faces import aside
from lamc.records.design import Line
from lamc.records.drawing import Drawing, Mend, Role, Stroke
from lamc.records.mechanism import Array
from lamc.records.network import listed_names

Point = tuple[float, float]
_ROUND = frozenset[Role]({"border", "hole", "cut"})
_HEAL = "heal:"  # as a design says it
_NO_WIDTH = "line that parts nothing, as it has no width"  # a slit does
_STRAIGHT = 1e-6  # of a line's length: corners that lie so near to it are none


def shape_of(
    drawing: Drawing, layer: str | None, heal: float | None
) -> tuple[MultiPolygon, tuple[Mend, ...]]:
    """What the outlines of a layer enclose, those within others by turns left out, m; and what was mended.

    layer  None: the whole drawing
    heal   m; None: `DEFAULT` of the drawing's size

    Raises DesignError for a layer that there is not, for gaps, and where nothing is enclosed.
    """
    drawn = _chosen(drawing, layer, _ROUND, "outlines")
    # A layer of holes alone is asked for as a shape: to be cut.
    only = all(stroke.role == "hole" for stroke in drawn)
    strokes = [s if s.role == "hole" and not only else replace(s, role="border") for s in drawn]
    tolerance = tolerance_of(drawing, heal)
    if heal is not None:
        check_tolerance(heal, size_of(drawing.strokes), _HEAL)
    graph = healed(strokes, tolerance)
    kept = parting(graph.points, graph.edges)
    loose = left_out(graph, strokes, kept, tolerance, _HEAL)
    found = material_of(graph, strokes, kept, OUTLINES)
    region = found.region
    if region.is_empty:
        if kept:
            raise DesignError(
                f"the outlines of {_where(layer)} leave nothing: one within another is a window of it; draw tiles "
                "without a frame about them, or the frame alone"
            )
        raise DesignError(f"the lines of {_where(layer)} enclose nothing; draw closed outlines")
    across = {graph.strokes[k]: k for k in reversed(found.within)}
    whole = [
        Mend(_NO_WIDTH, _middle(graph, k), 0.0, name_of(strokes, owner))
        for owner, k in sorted(across.items())
    ]
    return region, (*graph.mends, *loose, *whole)


def lines_of(
    drawing: Drawing, layer: str | None, heal: float | None
) -> tuple[tuple[Line, ...], tuple[Mend, ...]]:
    """The straight hinge lines of a layer, m, from start to end as drawn, in the order of their lower left ends.

    Doubled ones count once, and pieces in a row are one line, of one stroke. Raises DesignError for a layer that
    there is not.
    """
    strokes = _chosen(drawing, layer, CREASES, "hinge lines")
    pieces = [
        Stroke(np.array([a, b]), False, "hinge", source=stroke.source)
        for stroke in strokes
        for a, b in pairwise(_corners(stroke))
    ]
    graph = healed(pieces, tolerance_of(drawing, heal))
    found: list[Line] = []
    by_piece: dict[int, list[Array]] = {}
    for (a, b), k in zip(graph.edges, graph.strokes, strict=True):
        by_piece.setdefault(k, []).append(graph.points[[a, b]])
    for k, edges in by_piece.items():
        start, end = pieces[k].points
        along = end - start
        places = sorted(np.concatenate(edges).tolist(), key=lambda p: float(np.subtract(p, start) @ along))
        (x0, y0), (x1, y1) = places[0], places[-1]
        found.append(((x0, y0), (x1, y1)))
    return tuple(sorted(found, key=lambda line: (min(line), max(line)))), graph.mends


def lengthened(
    lines: Sequence[Line], material: BaseGeometry, tolerance: float
) -> tuple[tuple[Line, ...], list[Mend]]:
    """The lines, those that end within material, and within a tolerance, m, of its edge, drawn on to that."""
    found: list[Line] = []
    mends: list[Mend] = []
    if material.is_empty:
        return tuple(lines), mends
    edge = shapely.boundary(material)
    for start, end in lines:
        made = []
        for tip, other in ((start, end), (end, start)):
            way = np.subtract(tip, other)
            reach = np.array(tip) + tolerance / float(np.hypot(*way)) * way
            meets = shapely.intersection(edge, shapely.LineString([tip, reach]))
            apart = float(shapely.distance(meets, shapely.Point(tip))) if not meets.is_empty else 0.0
            if apart > 0.0 and shapely.contains_xy(material, *tip):
                on = np.array(tip) + apart / float(np.hypot(*way)) * way
                mends.append(Mend("hinge extended", (float(on[0]), float(on[1])), apart, "a hinge line"))
                made.append((float(on[0]), float(on[1])))
            else:
                made.append(tip)
        found.append((made[0], made[1]))
    return tuple(found), mends


def in_a_row(lines: Sequence[Line], tolerance: float) -> list[Point]:
    """Places, m, where two lines meet, and no third one, and go on straight: pieces of one hinge, perhaps."""
    far: dict[Point, list[Point]] = {}
    for start, end in lines:
        far.setdefault(start, []).append(end)
        far.setdefault(end, []).append(start)
    straight = [
        place
        for place, ends in far.items()
        if len(ends) == 2
        and np.subtract(place, ends[0]) @ np.subtract(ends[1], place) > 0.0
        and aside(*map(np.array, (place, *ends))) <= tolerance
    ]
    if not straight:
        return []
    tree = STRtree(shapely.linestrings(lines))
    near = tree.query(shapely.points(straight), "dwithin", tolerance)[0]
    counts = np.bincount(near, minlength=len(straight))
    return [place for place, count in zip(straight, counts.tolist(), strict=True) if count == 2]


def says_angles(drawing: Drawing, layer: str | None) -> bool:
    """Whether a hinge line of a layer rests at an angle that is drawn, other than by an opacity that nobody chose."""
    chosen = _chosen(drawing, layer, CREASES, "hinge lines")
    return any(stroke.angle and not stroke.full for stroke in chosen)


def mend_notes_of(mends: Sequence[Mend], heal: float | None, drawing: Drawing) -> list[str]:
    """Lines for a user."""
    return mend_notes(mends, tolerance_of(drawing, heal), _HEAL)


def _chosen(drawing: Drawing, layer: str | None, roles: frozenset[Role], what: str) -> list[Stroke]:
    """Strokes of those roles; on a layer without any, which was named for this, all but those to ignore."""
    drawn = [stroke for stroke in drawing.strokes if stroke.role != "ignore"]
    if layer is not None:
        layers = sorted({stroke.layer for stroke in drawing.strokes if stroke.layer})
        if not any(layer in (stroke.layer, *stroke.groups) for stroke in drawing.strokes):
            named = f"its layers are {listed_names(layers)}" if layers else "it has none"
            alike = [name for name in layers if name.lower() == layer.lower()]
            hint = (
                f"; did you mean {alike[0]!r}?" if alike else ", and layers that are not shown are not read"
            )
            raise DesignError(f"the drawing has no layer {layer[:60]!r}; {named}{hint}")
        drawn = [stroke for stroke in drawn if layer in (stroke.layer, *stroke.groups)]
    found = [stroke for stroke in drawn if stroke.role in roles]
    if not found and layer is not None:
        found = drawn
    if not found:
        raise DesignError(f"{_where(layer)} has no {what}; say what its lines are for (roles: {{red: cut}})")
    return found


def _corners(stroke: Stroke) -> Array:
    """Its corners, closed, without those in line with their neighbours."""
    points = np.vstack([stroke.points, stroke.points[:1]]) if stroke.closed else stroke.points
    kept = [points[0]]
    for here, after in pairwise(points[1:]):
        before = here - kept[-1]
        onward = after - here
        turn = before[0] * onward[1] - before[1] * onward[0]
        if (
            abs(turn) > _STRAIGHT * float(np.linalg.norm(before) * np.linalg.norm(onward))
            or before @ onward < 0
        ):
            kept.append(here)
    return np.array([*kept, points[-1]])


def _middle(graph: Graph, edge: int) -> tuple[float, float]:
    x, y = graph.points[list(graph.edges[edge])].mean(axis=0).tolist()
    return x, y


def tolerance_of(drawing: Drawing, heal: float | None) -> float:
    """How far lines may be off, m."""
    return DEFAULT * size_of(drawing.strokes) if heal is None else heal


def _where(layer: str | None) -> str:
    return "the drawing" if layer is None else f"layer {layer[:60]!r}"
