"""A drawing of lines as a sheet of creases: healed, its facets found within its outlines, as a mechanism.

In: a `Drawing`, and what a user says of the sheet. Out: a `Mechanism` with its mends; warnings for what was assumed.
Never: changes a line without a mend.
"""

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import shapely
from shapely.geometry import MultiPolygon

from lamc.basics.errors import DesignError, LamcError, Place, warn
from lamc.design.shapes import areas
from lamc.readers.drawings.coarser import coarser, curves_of, fewest, is_straight
from lamc.readers.drawings.faces import faces_within, linked
from lamc.readers.drawings.heal import CREASES, DEFAULT, OUTLINES, Graph, check_tolerance, healed, size_of
from lamc.readers.drawings.loose import GapsError, left_out
from lamc.readers.drawings.material import material_of
from lamc.readers.drawings.outlines import hull, parting
from lamc.readers.drawings.telling import full_notes, mend_notes, name_of
from lamc.readers.fold_faces import Edge, check_count
from lamc.readers.fold_file import LINK, FoldFrame
from lamc.readers.fold_sheet import sheet_mechanism
from lamc.readers.mechanism_as_such import SheetAsSuch
from lamc.records.card import SheetOptions
from lamc.records.drawing import Drawing, Mend, Role, Stroke
from lamc.records.mechanism import Array, Mechanism
from lamc.records.parameters import with_origin

# H is for drawings alone: a crease with a spring, which rests flat.
_KINDS: dict[Role, str] = {
    "border": "B",
    "hole": "B",
    "cut": "C",
    "mountain": "M",
    "valley": "V",
    "hinge": "H",
    "undriven": "U",
    "flat": "F",
}
_LINK = "F"
WIDER = (
    1.0,
    3.0,
    10.0,
    30.0,
)  # times the usual tolerance: drawings of few digits, or by eye; the last is 3 thousandths of the size
# Of a sheet of curved creases; each makes up to three hinges. Six waves across a square take 21 s of processor time
# until there are pictures (`python -m benchmarks.large_drawings --only "6 waves"`).
MOST_CORNERS = 100
# Times the usual tolerance of healing, the first that will do. Off by 64e-4 of the size, a curve is one by eye still.
COARSER = (1.0, 2.0, 4.0, 8.0, 16.0, 32.0, 64.0)
# Of the size: facets narrower than that, on average, and edges that are shorter, are where lines should have met in one
# place, a pixel or so beside another: of a sheet of 100 mm 0.05 mm, less than any card is thick.
NARROW = 5e-4
_HEAP = 1000  # ends of lines that stop short: a heap of lines, which takes minutes at all tolerances, and none joins it
_OVERRUN = 0.25  # of a crease: so much of it beyond outlines is an end that runs over, and no crease of a piece there


def sheet_of(drawing: Drawing, options: SheetOptions) -> Mechanism:
    """The mechanism of a drawn sheet. Raises DesignError for what cannot be, with the line and its place."""
    place = Place(drawing.file)
    try:
        frame, mends, tolerance = _frame(drawing, options)
        options = replace(options, units=None)
        made, notes = sheet_mechanism(frame, options, drawing.name)
    except LamcError as error:
        raise (type(error)(error.message, place) if error.place is None else error) from error
    for note in [*notes, *mend_notes(mends, tolerance)]:
        warn(note, place)
    recipe = SheetAsSuch(frame, options, drawing.name, mends)
    return with_origin(replace(made, mends=mends), recipe)


def _frame(drawing: Drawing, options: SheetOptions) -> tuple[FoldFrame, tuple[Mend, ...], float]:
    strokes = [stroke for stroke in drawing.strokes if stroke.role != "ignore"]
    if not strokes:
        raise DesignError(
            "the drawing has no line that is for anything; say what lines are for (--role red=cut)"
        )
    found, told_slivers = _found(strokes, options.heal, large=options.large)
    graph, kept, loose, tolerance = found.graph, found.kept, found.loose, found.tolerance
    points, edges, origin, faces = found.points, found.edges, found.origin, found.faces
    notes = [*drawing.notes, *found.notes, *told_slivers]
    sides = {side for face in faces for side in zip(face, (*face[1:], face[0]), strict=True)}
    used = [k for k, (a, b) in enumerate(edges) if (a, b) in sides or (b, a) in sides]
    owners = [None if (of := origin[k]) is None else graph.strokes[kept[of]] for k in range(len(edges))]
    beyond = _beyond(points, edges, owners, strokes, set(used))
    lines = [None if (owner := owners[k]) is None else strokes[owner] for k in used]
    notes += full_notes(strokes[k] for k in dict.fromkeys(owners[e] for e in used) if k is not None)
    frame = FoldFrame(
        drawing.name,
        np.column_stack([points, np.zeros(len(points))]),
        tuple(edges[k] for k in used),
        "".join(_LINK if line is None else _KINDS[line.role] for line in lines),
        tuple(None if line is None or line.role not in CREASES else line.angle for line in lines),
        tuple(faces),
        1.0,
        {},
        tuple(notes),
        tuple(LINK if (k := owners[e]) is None else name_of(strokes, k) for e in used),
        2.0 * tolerance,  # an end may have moved by twice it
    )
    return frame, (*graph.mends, *loose, *beyond), tolerance


@dataclass(frozen=True, eq=False)
class _Found:
    """Facets of the drawing healed within one tolerance, m.

    kept    edges of the graph that part something; loose: mends of those left out
    origin  which of those kept each of `edges` is a part of; None: a link to a hole
    """

    graph: Graph
    kept: list[int]
    loose: list[Mend]
    tolerance: float
    points: Array
    edges: Sequence[Edge]
    origin: Sequence[int | None]
    faces: Sequence[tuple[int, ...]]
    notes: list[str]

    def slivers(self, width: float) -> list[tuple[str, Array]]:
        """What lines leave that were to meet in one place, with a place, m: facets that are narrower, on average, than
        `width`, and edges that are shorter, between vertices where three lines or more meet."""
        shapes = [shapely.Polygon(self.points[list(face)]) for face in self.faces]
        slim = [shape for shape in shapes if 2.0 * shape.area < width * shape.length]
        ends = np.array(self.edges).reshape(-1, 2)
        degree = np.bincount(ends.ravel(), minlength=len(self.points))
        short = np.linalg.norm(self.points[ends[:, 1]] - self.points[ends[:, 0]], axis=1) < width
        between = ends[short & (degree[ends].min(axis=1) > 2)]
        return [
            *(("facet", shapely.get_coordinates(shape.representative_point())[0]) for shape in slim),
            *(("edge", place) for place in self.points[between].mean(axis=1)),
        ]


def _found(strokes: Sequence[Stroke], asked: float | None, *, large: bool) -> tuple[_Found, list[str]]:
    """Facets with the tolerance that is asked for; else with the least of the usual ones with which no line stops short
    of another, or with the next that leaves no sliver as lines make that were to meet in one place."""
    size = size_of(strokes)
    if asked is not None:
        check_tolerance(asked, size)
    usual = [asked] if asked is not None else [factor * DEFAULT * size for factor in WIDER]
    for k, tolerance in enumerate(usual):
        try:
            found = _within(strokes, tolerance, large=large)
        except _StopsShortError as error:
            many = isinstance(error.why, GapsError) and error.why.count > _HEAP
            if k == len(usual) - 1 or many:
                raise error.why from error
            continue
        slivers = found.slivers(NARROW * size)
        if not slivers:
            return found, []
        told_slivers = _counted(slivers, NARROW * size)
        for factor, wide in zip(WIDER[k + 1 :], usual[k + 1 :], strict=False):
            try:
                wider = _within(strokes, wide, large=large)
            except (_StopsShortError, DesignError):
                continue
            if not wider.slivers(NARROW * size):
                return wider, [
                    f"lines that all but meet part off {told_slivers}: healed within {factor:g} times the usual"
                ]
        x, y = 1e3 * slivers[0][1]
        return found, [
            f"{told_slivers}, the first at ({x:.6g}, {y:.6g}) mm: they make runs slow, and may stop them; "
            "--heal with a wider tolerance joins lines that were to meet there"
        ]
    raise AssertionError("the last tolerance returns or raises")


def _counted(slivers: Sequence[tuple[str, Array]], width: float) -> str:
    """How many there are, and than what they are narrower or shorter, m."""
    counts = Counter(what for what, _ in slivers)
    told = [
        f"{counts[what]} {what}{'s' if counts[what] > 1 else ''} {smaller} than {1e3 * width:.3g} mm"
        for what, smaller in (("facet", "narrower"), ("edge", "shorter"))
        if counts[what]
    ]
    return " and ".join(told)


class _StopsShortError(Exception):
    """A line stops short of another by more than the tolerance."""

    def __init__(self, why: DesignError) -> None:
        super().__init__(str(why))
        self.why = why


def _within(strokes: Sequence[Stroke], tolerance: float, *, large: bool) -> _Found:
    """Raises _StopsShortError, and DesignError where lines enclose nothing, or so much that it takes minutes."""
    graph = healed(strokes, tolerance)
    kept = parting(graph.points, graph.edges)
    check_count(len(kept), "edges", large=large)
    try:
        loose = left_out(graph, strokes, kept, tolerance)
    except DesignError as error:
        raise _StopsShortError(error) from error
    if not kept:
        raise DesignError(
            f"the lines enclose no facet, of {name_of(strokes, 0)} and others, healed within {1e3 * tolerance:.3g} mm: "
            "draw the sheet's outline, or join its ends (--heal '0.5 mm')"
        )
    notes: list[str] = []
    if not large:
        graph, kept = _coarser(graph, strokes, kept, notes)
    region = _region(graph, strokes, kept, notes)
    points, edges, origin = linked(graph.points, [graph.edges[k] for k in kept])
    faces = faces_within(points, edges, region)
    if not faces:
        raise DesignError("the outlines enclose no facet")
    return _Found(graph, kept, loose, tolerance, points, edges, origin, faces, notes)


def _coarser(
    graph: Graph, strokes: Sequence[Stroke], kept: list[int], notes: list[str]
) -> tuple[Graph, list[int]]:
    """The graph, and which of its edges part something, with fewer corners along curves where creases are curved and
    corners too many for facets that bend: along a curved crease they must."""
    edges, owners = [graph.edges[k] for k in kept], [graph.strokes[k] for k in kept]
    curves = curves_of(graph.points, edges, [(strokes[k].role, strokes[k].angle) for k in owners])
    before = len({v for edge in edges for v in edge})
    size = size_of(strokes)
    creases = [curve for curve in curves if strokes[owners[curve.edge]].role in CREASES]
    if before <= MOST_CORNERS or all(is_straight(graph.points, c, DEFAULT * size) for c in creases):
        return graph, kept
    for factor in COARSER:
        most_off = factor * DEFAULT * size
        if factor < COARSER[-1] and fewest(graph.points, curves, most_off) > MOST_CORNERS:
            continue
        rows = coarser(graph.points, curves, most_off)
        after = len({v for edge, _ in rows for v in edge})
        if after <= MOST_CORNERS:
            break
    if after == before:
        return graph, kept
    notes.append(
        f"its curves have {after} corners of {before}, off by up to {1e3 * factor * DEFAULT * size:.3g} mm, as facets "
        "bend from corner to corner and more take minutes (--large keeps all)"
    )
    rows.sort()
    made = replace(graph, edges=tuple(e for e, _ in rows), strokes=tuple(owners[k] for _, k in rows))
    return made, list(range(len(rows)))


def _region(graph: Graph, strokes: Sequence[Stroke], kept: Sequence[int], notes: list[str]) -> MultiPolygon:
    """Where material is: within outlines, else within cuts, else wherever lines enclose something."""

    def of(*roles: Role) -> list[Edge]:
        return [graph.edges[k] for k in kept if strokes[graph.strokes[k]].role in roles]

    points, holes = graph.points, of("hole")
    drawn, cuts, roles = of("border", "hole"), of("cut"), OUTLINES
    # More than rounding of the area, of lines that are a billionth of the size apart. Cuts that run over the edge of
    # what outlines enclose with all creases are notches.
    within = hull(points, drawn)
    is_outside = _has_creases_beyond(graph, strokes, kept, within) or not of("border")
    if cuts and is_outside and hull(points, drawn + cuts).area > (1.0 + 1e-6) * within.area:
        notes.append(
            "no outline is drawn about all: cuts that enclose something are taken for outlines and holes"
        )
        roles = OUTLINES | {"cut"}
    found = material_of(graph, strokes, kept, roles).region
    if found.is_empty:
        notes.append("no outline is drawn: the sheet ends where its lines enclose nothing more")
        every = [graph.edges[k] for k in kept]
        found = areas(shapely.difference(hull(points, every), hull(points, holes)))
    return found


def _has_creases_beyond(
    graph: Graph, strokes: Sequence[Stroke], kept: Sequence[int], within: MultiPolygon
) -> bool:
    """Whether a crease lies beyond what outlines enclose, by more than an end that runs over into a relief."""
    far = 1e-6 * math.sqrt(within.area)
    creases = [k for k in kept if strokes[graph.strokes[k]].role in CREASES]
    ends = graph.points[np.array([graph.edges[k] for k in creases], dtype=int).reshape(-1, 2)]
    lengths = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    beyond = shapely.distance(within, shapely.points(ends.mean(axis=1))) > far
    owners = [graph.strokes[k] for k in creases]
    whole = np.bincount(owners, weights=lengths, minlength=len(strokes))
    outside = np.bincount(owners, weights=np.where(beyond, lengths, 0.0), minlength=len(strokes))
    return bool((outside > _OVERRUN * whole).any())


def _beyond(
    points: Array,
    edges: Sequence[Edge],
    owners: Sequence[int | None],
    strokes: Sequence[Stroke],
    used: set[int],
) -> list[Mend]:
    """A mend for each stroke of which something lies in a hole or beyond the outlines."""
    found: dict[int, Mend] = {}
    for k, (a, b) in enumerate(edges):
        owner = owners[k]
        if k not in used and owner is not None and owner not in found:
            at = 0.5 * (points[a] + points[b])
            found[owner] = Mend(
                "line outside the material", (float(at[0]), float(at[1])), 0.0, name_of(strokes, owner)
            )
    return [found[owner] for owner in sorted(found)]
