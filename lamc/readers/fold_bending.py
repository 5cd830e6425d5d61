"""Facets that bend: every facet of four corners or more in triangles, with creases along its diagonals.

In: a frame, its facets as they lie flat. Out: the frame with more edges and faces, of the kind `FACET`. Never: moves a
vertex; parts a facet that has three corners.

Facets bend along the diagonals of a constrained Delaunay triangulation, and along edges that are marked flat, as in
bar-and-hinge models (E. T. Filipov, K. Liu, T. Tachi, M. Schenk, G. H. Paulino, 2017).
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import shapely

from lamc.basics.errors import DesignError
from lamc.loops.at_start import loops_of
from lamc.loops.geometry import geometry_of
from lamc.loops.misfit import length
from lamc.loops.rank import LoopCount
from lamc.loops.work import MOST, Work
from lamc.mechanism.plan import plan
from lamc.readers.fold_faces import Edge, Face
from lamc.readers.fold_file import FoldFrame
from lamc.readers.fold_flat import Corners
from lamc.records.mechanism import Array, Mechanism
from lamc.records.scene import Scene

CREASED = "MVUH"  # kinds of creases
FACET = "f"  # the kind of a crease along which a facet bends
STIFFER = 10.0  # than a crease of its length: paper bends along its creases first
# Of the sheet's size: what six digits leave, up to some 8e-5. Rigid facets with such a misfit move as those of the
# exact drawing do, where facets that bend choose ways of their own; beyond, they soon stop or come apart.
NEARLY = 1e-4
# 1/rad: of the largest singular value of the closure, by how far a sheet is from flat. Loops that are meant have some
# 1e-3 and more; those of a hypar with one corner off by a pixel, which move exactly all the same, 1e-6.
BARELY = 1e-5
STILL = "nothing moves while facets are rigid"
NOWHERE = "no way to begin is found while facets are rigid"


def obstacle(sheet: Mechanism) -> str:
    """Why a sheet of rigid facets does not fold, `STILL` if not at all, `NOWHERE` if nobody knows how; empty if it
    does, or where that would take long to find out."""
    if not sheet.joints:
        return STILL
    if not Work.of(sheet).is_within(MOST):
        return ""
    tree = plan(sheet)
    # A vertex takes three freedoms at most, and a hole six: with fewer of them than that, some are left.
    closing = sum(cycle.kind.equations for cycle in geometry_of(tree).cycles)
    try:
        loops = loops_of(tree, sheet.scene or Scene())
    except DesignError:
        return NOWHERE if len(sheet.joints) > closing else STILL
    is_flat = not any(sheet.scene.angles.values()) if sheet.scene else True
    if loops.branch_ranks and is_flat and _weakest(loops) < BARELY:
        return "rigid facets would crawl, as the drawing's rounding alone holds some of their loops"
    if loops.misfit is not None and loops.misfit.farther > NEARLY * sheet.size >= loops.misfit.gap:
        gap = length(loops.misfit.farther)
        return f"rigid facets would come apart, as their loops are open by {gap} when half a radian is folded"
    if loops.misfit is None or loops.misfit.gap <= NEARLY * sheet.size:
        return ""
    return f"rigid facets would stop or come apart, as {loops.misfit.text}"


def _weakest(loops: LoopCount) -> float:
    """What the weakest equation of loops that start flat holds of the strongest, by the way from there, 1/rad."""
    far = max(map(abs, loops.position), default=0.0)
    values = [value / loops.singular_values[0] for value in loops.singular_values]
    return min((value for value in values if value > loops.cutoff), default=1.0) / far if far else 1.0


def bending(frame: FoldFrame, faces: Sequence[Face], corners: Corners) -> FoldFrame:
    """The frame with triangles for faces; the first of each face has its number. corners: m, as they lie flat."""
    known = {frozenset(edge) for edge in frame.edges}
    edges: list[Edge] = list(frame.edges)
    first: list[Face] = []
    others: list[Face] = []
    sources = list(frame.sources)
    for number, (face, places) in enumerate(zip(faces, corners, strict=True)):
        triangles = _triangles(face, places)
        first.append(triangles[0])
        others += triangles[1:]
        for triangle in triangles:
            for side in zip(triangle, (*triangle[1:], triangle[0]), strict=True):
                if frozenset(side) not in known:
                    known.add(frozenset(side))
                    edges.append((min(side), max(side)))
                    sources += [f"a diagonal of facet {number}"] if frame.sources else []
    added = len(edges) - len(frame.edges)
    return replace(
        frame,
        edges=tuple(edges),
        kinds=frame.kinds.replace("F", FACET) + FACET * added,
        angles=(*frame.angles, *(None,) * added),
        faces=(*first, *others),
        sources=tuple(sources),
    )


def _triangles(face: Face, places: Mapping[int, Array]) -> list[Face]:
    """Triangles of a face, by vertices, that run around as it does."""
    if len(face) == 3:
        return [face]
    points = [(float(places[v][0]), float(places[v][1])) for v in face]
    vertex = dict(zip(points, face, strict=True))
    polygon = shapely.Polygon(points)
    found: list[Face] = []
    for part in shapely.get_parts(shapely.constrained_delaunay_triangles(polygon)):
        ring = [vertex[(float(x), float(y))] for x, y in shapely.get_coordinates(part)[:3]]
        if part.exterior.is_ccw != polygon.exterior.is_ccw:
            ring.reverse()
        found.append(tuple(ring))
    return sorted(found, key=lambda triangle: min(face.index(v) for v in triangle)) or [face]
