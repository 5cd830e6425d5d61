"""Lines of a sheet of creases: outline, windows, cuts, creases by which way they fold.

In: a `CreasedSheet`. Out: lines with pens that lamc's readers of drawings know, so that a drawing of them is the same
sheet. What a drawing has no words for (names, stiffness, card, what is held) is told.
"""

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import shapely
from shapely import STRtree
from shapely.geometry import LineString, Polygon

from lamc.basics.errors import UnsupportedError
from lamc.export.creased import CreasedSheet, Edge
from lamc.export.cuts.lines import ROLES, CutLine, Pen, closed, open_line
from lamc.readers.fold_groups import pieces_of
from lamc.records.mechanism import Array, Joint
from lamc.records.network import listed_names

_SAME = 1e-9  # relative: stiffness by length that is one
_STRAIGHT = 1e-9  # rad: less than pieces of one line turn by where they were parted


def lines_of_sheet(sheet: CreasedSheet, *, is_cut: bool = False) -> list[CutLine]:
    """Windows first, creases, cuts, flats, the outline last. Lines along which facets bend are flats, and left out of
    what is cut: card bends there by itself. Raises UnsupportedError for an angle that is no fold."""
    lines = [CutLine(ring, True, ROLES["hole"]) for ring in sheet.windows]
    rim: dict[tuple[int, ...], list[Edge]] = {}
    for edge in sheet.edges:
        if edge.joint is None and not edge.inner:
            rim.setdefault(tuple(sorted(sheet.spots[v] for v in edge.ends)), []).append(edge)
    cuts = [_line(sheet, pair[0], ROLES["cut"]) for pair in rim.values() if len(pair) > 1]
    outlines = _outlines(sheet, [pair[0] for pair in rim.values() if len(pair) == 1])
    bent = [edge for edge in sheet.edges if edge.joint is not None and not _is_crease(sheet, edge.joint)]
    flats = [] if is_cut else [_line(sheet, edge, ROLES["flat"]) for edge in bent]
    flats += _flats(sheet, outlines)
    folds = [
        (edge.joint, _fold(sheet, edge))
        for edge in sheet.edges
        if edge.joint is not None and _is_crease(sheet, edge.joint)
    ]
    met = {tuple(p) for line in (*cuts, *outlines, *flats) for p in line.points.tolist()}
    lines += sorted(_whole(folds, met), key=lambda line: line.pen.name)
    return lines + cuts + flats + outlines


def _whole(folds: Sequence[tuple[int, CutLine]], met: set[tuple[float, ...]]) -> list[CutLine]:
    """Creases as they were drawn: pieces of one hinge that go on straight where nothing else that is drawn meets them
    are one. Lines that part facets around windows end there, and are not drawn. met: places of all other lines."""
    at: dict[tuple[float, ...], list[int]] = {}
    for k, (_, line) in enumerate(folds):
        for place in line.points.tolist():
            at.setdefault(tuple(place), []).append(k)
    joined: list[tuple[int, int]] = []
    for place, around in at.items():
        if len(around) != 2 or place in met:
            continue
        (joint, first), (other, second) = (folds[k] for k in around)
        ends = [next(p for p in line.points if tuple(p) != place) for line in (first, second)]
        if joint == other and first.pen == second.pen and _is_straight(ends[0], np.array(place), ends[1]):
            joined.append((around[0], around[1]))
    if not folds:
        return []
    return [_end_to_end([folds[k][1] for k in each]) for each in pieces_of(range(len(folds)), joined)]


def _end_to_end(pieces: Sequence[CutLine]) -> CutLine:
    """Pieces of one straight line as one: from the place that one piece has to the other such."""
    places, times = np.unique(np.concatenate([line.points for line in pieces]), axis=0, return_counts=True)
    return replace(pieces[0], points=places[times == 1]) if len(pieces) > 1 else pieces[0]


def _is_straight(start: Array, amid: Array, end: Array) -> bool:
    before, after = amid - start, end - amid
    turn = float(before[0] * after[1] - before[1] * after[0])
    ahead = float(before @ after)
    return ahead > 0.0 and abs(turn) <= _STRAIGHT * ahead


def _is_crease(sheet: CreasedSheet, joint: int) -> bool:
    """Whether a hinge is a crease, and not a line along which a facet bends."""
    return sheet.mechanism.joints[joint].name not in sheet.mechanism.facet_creases


def _flats(sheet: CreasedSheet, outlines: Sequence[CutLine]) -> list[CutLine]:
    """Lines along which facets hold together, but for those to windows: they part facets around holes, which readers
    do of themselves, and on the card they would be marks that nobody drew."""
    holes = {tuple(point) for line in outlines if line.pen == ROLES["hole"] for point in line.points.tolist()}
    inner = [_line(sheet, e, ROLES["flat"]) for e in sheet.edges if e.joint is None and e.inner]
    return [line for line in inner if holes.isdisjoint(map(tuple, line.points.tolist()))]


def crease_of(sheet: CreasedSheet) -> float | None:
    """N/rad, the stiffness by length that all sprung creases have; None where they differ, or there are none."""
    lengths: dict[int, float] = {}
    for edge in sheet.edges:
        if edge.joint is not None and _is_crease(sheet, edge.joint):
            start, end = sheet.vertices[list(edge.ends)]
            lengths[edge.joint] = lengths.get(edge.joint, 0.0) + math.dist(start, end)
    joints = sheet.mechanism.joints
    found = [joints[k].stiffness / length for k, length in lengths.items() if joints[k].stiffness]
    if not found or max(found) - min(found) > _SAME * max(found):
        return None
    return found[0]


def point_of(sheet: CreasedSheet) -> Array:
    """A point inside a facet that the world holds, m."""
    held = [k for k, body in enumerate(sheet.mechanism.bodies) if body.fixed]
    ring = next(r for r, body in zip(sheet.rings, sheet.bodies, strict=True) if body in held)
    return np.array(Polygon(ring).representative_point().coords[0])


def role_of(joint: Joint, sign: float) -> str:
    """What a drawing calls a hinge. sign: 1 where its positive angles are valleys."""
    if not joint.stiffness:
        return "undriven"
    if not joint.rest_angle:
        return "hinge"
    return "valley" if sign * joint.rest_angle > 0.0 else "mountain"


def _fold(sheet: CreasedSheet, edge: Edge) -> CutLine:
    assert edge.joint is not None
    joint = sheet.mechanism.joints[edge.joint]
    role = role_of(joint, sheet.sign(edge))
    if abs(joint.rest_angle) > math.pi:
        raise UnsupportedError(
            f"hinge {joint.name!r} rests at {math.degrees(joint.rest_angle):g} degrees; drawings hold up to 180"
        )
    angle = abs(joint.rest_angle) if role in ("mountain", "valley") else None
    return _line(sheet, edge, ROLES[role], angle)


def _line(sheet: CreasedSheet, edge: Edge, pen: Pen, angle: float | None = None) -> CutLine:
    return CutLine(_places(sheet, edge), False, pen, angle)


def _places(sheet: CreasedSheet, edge: Edge) -> Array:
    """Ends of an edge, m; vertices at one place are one to the last digit."""
    found: Array = sheet.places[[sheet.spots[v] for v in edge.ends]]
    return found


def _outlines(sheet: CreasedSheet, edges: list[Edge]) -> list[CutLine]:
    """Rims as closed lines, holes first; what stays open at corners that two rims share is left as it is."""
    merged = shapely.line_merge(shapely.multilinestrings([LineString(_places(sheet, e)) for e in edges]))
    parts = [part for part in shapely.get_parts(merged) if isinstance(part, LineString)]
    rings = [part for part in parts if part.is_ring]
    around = [Polygon(ring) for ring in (*rings, *sheet.windows)]
    tree = STRtree(around)
    # The rim of a piece in a window lies within two lines, that of a window on a crease within one. A point of what a
    # rim encloses tells nothing: it may lie in a window.
    holes = [
        sum(around[j].area > around[k].area for j in tree.query(rings[k], predicate="covered_by").tolist())
        % 2
        for k in range(len(rings))
    ]
    loose = [open_line(part, ROLES["border"]) for part in parts if not part.is_ring]
    inner, outer = ([r for r, hole in zip(rings, holes, strict=True) if hole == k] for k in (1, 0))
    return (
        [closed(ring.coords, ROLES["hole"]) for ring in inner]
        + [closed(ring.coords, ROLES["border"]) for ring in outer]
        + loose
    )


def lost_in_drawing(sheet: CreasedSheet, lines: Sequence[CutLine]) -> list[str]:
    """What the lines do not say, beside what keeps the mechanism from being a sheet, and numbers that reading them back
    tells."""
    names = [joint.name for joint in sheet.mechanism.joints]
    lost = [f"names of hinges and bodies ({listed_names(names)})"] if names else []
    bent = sum(edge.joint is not None and not _is_crease(sheet, edge.joint) for edge in sheet.edges)
    flats = sum(line.pen == ROLES["flat"] for line in lines) - bent
    if flats:
        lines_were = "a line inside of a body was" if flats == 1 else f"{flats} lines inside of bodies were"
        lost.append(f"what {lines_were} drawn as: flat here")
    return lost
