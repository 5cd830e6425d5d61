"""Kerf: paths beside the edges of parts, so that what the cutter leaves has the drawn size.

In: a layer as it is cut, and the width that the cutter takes away. Out: lines: outlines half of it outward, holes and
slits inward. What is narrower than the kerf is told, or cut once along its middle where it is a hinge's slit.
"""

from collections.abc import Sequence

import numpy as np
import shapely
from shapely import STRtree
from shapely.geometry import LineString, MultiPolygon, Polygon
from shapely.geometry.base import BaseGeometry

from lamc.basics.brief import counted
from lamc.basics.errors import ExportError
from lamc.design.cutting import as_multipolygon
from lamc.design.linking import millimetres
from lamc.export.cuts.lines import SCORES, SLITS, CutLine, open_line, rings_of
from lamc.export.cuts.plan import CutLayer

_MITRE = 10.0  # kerfs: corners of less than 11 degrees are cut off there
_SHOWN = 1e-3  # of the kerf squared: a region that is smaller is round-off of the offsets
_MOST = 4  # places that a note names


def lines_of(layer: CutLayer, kerf: float) -> tuple[list[CutLine], list[str]]:
    """Lines of a layer, inner ones first, and notes. Raises ExportError where parts would hang together."""
    dashes = [open_line(line, SLITS) for line in layer.lines]
    dashes += [open_line(line, SCORES) for line in layer.creases]
    if kerf == 0.0:
        return rings_of(list(layer.parts.geoms)) + dashes, []
    grown, lines, clash = _apart(layer, kerf, "mitre")
    if clash is not None:  # sharp corners of two parts may meet where the parts are a kerf apart
        grown, lines, clash = _apart(layer, kerf, "round")
    if clash is not None:
        raise clash
    paths = rings_of(list(grown.geoms)) + dashes + [open_line(line, SLITS) for line in lines]
    return paths, _narrow(layer, grown, lines, kerf)


def _apart(
    layer: CutLayer, kerf: float, corners: str
) -> tuple[MultiPolygon, list[LineString], ExportError | None]:
    """The parts grown by half of the kerf, lines of slits that it closes, and what is wrong where they do not part."""
    grown = offset(layer.parts, 0.5 * kerf, corners)
    lines = _thin_slits(layer, grown, kerf)
    return grown, lines, _clash(layer, grown, lines, kerf)


def offset(parts: BaseGeometry, distance: float, corners: str = "mitre") -> MultiPolygon:
    """Grown by a distance, m; corners stay sharp, or become "round". Gaps as wide as the kerf close: what is left of
    them is round-off."""
    grown = as_multipolygon(shapely.buffer(parts, distance, join_style=corners, mitre_limit=_MITRE))
    least = _SHOWN * (2.0 * distance) ** 2
    return MultiPolygon(
        [Polygon(p.exterior, [r for r in p.interiors if Polygon(r).area > least]) for p in grown.geoms]
    )


def _thin_slits(layer: CutLayer, grown: MultiPolygon, kerf: float) -> list[LineString]:
    """Hinge lines whose slits the kerf closes, as far as it does; never into a part, where a slit ends in one."""
    lines: list[LineString] = []
    between = shapely.difference(grown, layer.parts)
    for line, half in layer.slits:
        if 2.0 * half <= kerf:
            (start, end), beyond = np.array(line.coords), half + kerf
            along = (end - start) * (beyond / line.length)
            closed = shapely.intersection(LineString([start - along, end + along]), between)
            parts = [p for p in shapely.get_parts(closed) if isinstance(p, LineString)]
            lines += [
                p for p in parts if p.length > _SHOWN * kerf
            ]  # what is shorter is round-off of the offsets
    return lines


def _clash(layer: CutLayer, grown: MultiPolygon, lines: list[LineString], kerf: float) -> ExportError | None:
    """What is wrong where two parts lie in one piece that no line parts; None where each has its own."""
    cut = shapely.difference(grown, shapely.buffer(shapely.union_all(lines), 1e-4 * kerf))
    return clash_of(
        f"parts of layer {layer.layer.name!r}", list(layer.parts.geoms), as_multipolygon(cut), kerf
    )


def clash_of(what: str, parts: Sequence[Polygon], cut: MultiPolygon, kerf: float) -> ExportError | None:
    """What is wrong where two parts lie in one of the pieces that are cut; None where each has its own."""
    pieces = list(cut.geoms)
    points = np.array([part.representative_point() for part in parts], dtype=object)
    which, held = STRtree(pieces).query(points, predicate="within")
    by_piece: dict[int, int] = {}
    for point, piece in zip(which.tolist(), held.tolist(), strict=True):
        if piece in by_piece:
            one, two = parts[by_piece[piece]], parts[point]
            at = shapely.shortest_line(one, two).interpolate(0.5, normalized=True)
            return ExportError(
                f"two {what} are {_um(one.distance(two))} from each other at {millimetres((at.x, at.y))}, less than "
                f"the kerf of {_um(kerf)}: they would stay one; draw the gap wider, or give the kerf of a finer cutter"
            )
        by_piece[piece] = point
    return None


def _narrow(layer: CutLayer, grown: MultiPolygon, lines: list[LineString], kerf: float) -> list[str]:
    """What the kerf does not get into, and parts that it would eat."""
    name = f"layer {layer.layer.name!r}"
    notes = []
    if lines:
        notes.append(
            f"{name}: {counted(len(lines), 'slit of a hinge is', 'slits of hinges are')} no wider than the kerf of "
            f"{_um(kerf)} and cut once, along the hinge line; each side loses half of what the kerf is wider"
        )
    beams = shapely.buffer(shapely.union_all(lines), 0.51 * kerf)
    return [*notes, *narrow(name, layer.parts, grown, kerf, beams)]


def narrow(
    name: str, parts: MultiPolygon, grown: MultiPolygon, kerf: float, but: BaseGeometry | None = None
) -> list[str]:
    """What the kerf does not get into of parts that were grown by half of it, and parts that it would eat. but: where
    nothing is told."""
    notes = []
    closing = shapely.buffer(grown, -0.5 * kerf, join_style="mitre", mitre_limit=_MITRE)
    known = parts if but is None else shapely.union(parts, but)
    filled = as_multipolygon(shapely.difference(closing, known))
    places = [p.representative_point() for p in filled.geoms if p.area > _SHOWN * kerf * kerf]
    if places:
        notes.append(f"{name}: narrower than the kerf, and not cut: {_listed(places)}")
    thin = [p.representative_point() for p in parts.geoms if shapely.is_empty(shapely.buffer(p, -0.5 * kerf))]
    if thin:
        notes.append(f"{name}: parts narrower than the kerf of {_um(kerf)}: {_listed(thin)}")
    return notes


def _listed(places: list[shapely.Point]) -> str:
    shown = ", ".join(millimetres((p.x, p.y)) for p in places[:_MOST])
    return f"{shown}, … ({len(places)} in all)" if len(places) > _MOST else shown


def _um(length: float) -> str:
    return f"{1e6 * length:.4g} um"
