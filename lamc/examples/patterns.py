"""Folded sheets of any size: Yoshimura's, Kresling's, the waterbomb's and Resch's patterns, as text of native designs.

In: how many cells. Out: YAML, the same to the byte for the same numbers. Never: reads or writes files, simulates.

All are of triangles, so that they fold with rigid facets and many freedoms: three less for each vertex than there are
creases. They start folded alike all over, by closed forms (`folded`), where one is known.
"""

import math
from collections import Counter
from collections.abc import Callable, Mapping, Sequence

from lamc.examples.folded import mirrored, third_of_opposites
from lamc.examples.sheet import Crease, CreasePattern, Point, creases_of, rim, sheet

BASE = 30.0  # mm, of triangles
_DIGITS = 1e-9  # mm, to tell points apart

TITLES = {
    "yoshimura": "Yoshimura's pattern",
    "kresling": "Kresling's pattern",
    "waterbomb_sheet": "A waterbomb tessellation",
    "resch": "Resch's pattern of triangles",
}
_FREE = """
{count} creases and {vertices} inner vertices of three equations each leave {freedoms} freedoms, and springs of film
hold them all. It has no weight here: with gravity it sags. """
_YOSHIMURA = (
    """\
Yoshimura's pattern of {columns} by {rows} cells, in which a thin cylinder buckles: rows of isosceles triangles, six
creases at every inner vertex. Level creases are valleys and slanted ones mountains, and the sheet rolls up as they
fold.""",
    """\
Look at results.csv: it starts and comes to rest with all vertices alike, and not in between, as its rim is free.""",
)
_KRESLING = (
    """\
Kresling's pattern of {columns} by {rows} cells, in which a twisted cylinder buckles: one parallelogram over and over,
with a diagonal. Diagonals are valleys, all else are mountains. Glued to a tube it would have two rigid states and none
between; as a sheet it moves.""",
    """\
Look at results.csv: it starts and comes to rest as a helix, on which all vertices are alike.""",
)
_WATERBOMB = (
    """\
The waterbomb tessellation of {columns} by {rows} cells: squares with both diagonals and an upright midline, shifted by
half a square from row to row. Diagonals are valleys, all others mountains, and there are two kinds of vertices.""",
    """\
Look at results.csv: creases of a kind (d, m, h, u) start and come to rest alike, as in a sheet without an end.""",
)
_RESCH = (
    """\
Resch's pattern of triangles, {columns} by {rows} stars of six right triangles between equilateral facets, each star in
the shape of a triangle of twice a facet's side. Fully folded, facets would tile the plane, with all stars tucked away
below it. On the way there no sheet of rigid facets folds alike all over, so it bulges, and no spring is at ease where
it rests. It starts with one star folded, and the others follow.""",
    """\
Look at results.csv: long creases of stars, v, are valleys, and not alike.""",
)


def yoshimura(columns: int, rows: int) -> str:
    """The design of columns x rows cells of two triangles each, folded alike at all vertices."""
    height = 18.0
    points, facets, names = _rows_of_triangles(
        columns, rows, [0.5 * BASE * (j % 2) for j in range(rows + 1)], height
    )
    base = math.atan2(height, 0.5 * BASE)

    def folds(slanted: float) -> dict[str, float]:
        level = third_of_opposites((math.pi - 2.0 * base, base, base), slanted, slanted)
        return {"h": level, "s": slanted}

    def kind(a: int, b: int) -> str:
        return "h" if points[a][1] == points[b][1] else "s"

    return _made(
        "yoshimura", _YOSHIMURA, (columns, rows), (points, facets, names), kind, folds, (-20.0, -60.0)
    )


def kresling(columns: int, rows: int) -> str:
    """The design of columns x rows parallelograms with a diagonal each, folded alike at all vertices."""
    shift, height = 10.0, 25.0
    points, facets, names = _rows_of_triangles(columns, rows, [shift * j for j in range(rows + 1)], height)
    side, diagonal = math.atan2(height, shift), math.atan2(height, shift - BASE)

    def folds(fold: float) -> dict[str, float]:
        level = third_of_opposites((diagonal - side, math.pi - diagonal, side), fold, -0.8 * fold)
        return {"h": level, "s": fold, "d": -0.8 * fold}

    def kind(a: int, b: int) -> str:
        (xa, ya), (xb, yb) = points[a], points[b]
        return "h" if ya == yb else "s" if (xb - xa) * (yb - ya) > 0.0 else "d"

    return _made("kresling", _KRESLING, (columns, rows), (points, facets, names), kind, folds, (-12.0, -30.0))


def waterbomb(columns: int, rows: int) -> str:
    """The design of columns x rows squares of six triangles each, folded alike all over."""
    half = 0.5 * BASE
    mesh = _Mesh()
    for j in range(rows):
        for i in range(columns):
            x, y = (2 * i + j % 2) * half, j * BASE
            low = [mesh.point(x + k * half, y) for k in range(3)]
            high = [mesh.point(x + k * half, y + BASE) for k in range(3)]
            centre = mesh.point(x + half, y + half)
            ring = [low[0], low[1], low[2], high[2], high[1], high[0]]
            for part, a, b in zip("abcdef", ring, [*ring[1:], ring[0]], strict=True):
                mesh.facet(f"f{i}_{j}{part}", (a, b, centre))
    centres = {k for k, (_, y) in enumerate(mesh.points) if round(y / half) % 2 == 1}

    def folds(diagonal: float) -> dict[str, float]:
        right, eighth = 0.5 * math.pi, 0.25 * math.pi
        midline = third_of_opposites((right, eighth, eighth), diagonal, diagonal)
        level, upright = mirrored(midline, (right, eighth, eighth), diagonal)
        return {"d": diagonal, "m": midline, "h": level, "u": upright}

    def kind(a: int, b: int) -> str:
        (xa, ya), (xb, yb) = mesh.points[a], mesh.points[b]
        if ya == yb:
            return "h"
        if abs(xa - xb) > _DIGITS:
            return "d"
        return "m" if {a, b} & centres else "u"

    shape = (mesh.points, mesh.facets, mesh.names)
    return _made("waterbomb_sheet", _WATERBOMB, (columns, rows), shape, kind, folds, (20.0, 50.0))


def resch(columns: int, rows: int) -> str:
    """The design of columns x rows stars and the facets between them, the first star folded."""
    side, height = BASE, 0.5 * math.sqrt(3.0) * BASE
    # In half sides and heights: corners of a star, and of the six facets about it their lower ones.
    corners = [(0, 0), (2, 0), (4, 0), (3, 1), (2, 2), (1, 1)]
    tips = [(1, -1), (3, -1), (4, 0), (3, 1), (0, 0), (1, 1)]
    stars = [(3 * i, i % 2 + 2 * j) for j in range(rows) for i in range(columns)]
    around = Counter((x + dx, y + dy) for x, y in stars for dx, dy in tips)
    mesh = _Mesh()

    def at(x: int, y: int) -> int:
        return mesh.point(0.5 * side * x, height * y)

    for k, (x, y) in enumerate(sorted((tip for tip in around if around[tip] > 1), key=lambda tip: tip[::-1])):
        mesh.facet(f"t{k}", (at(x, y), at(x + 1, y + 1), at(x - 1, y + 1)))
    centres: list[int] = []
    for k, (x, y) in enumerate(stars):
        centre = mesh.point(0.5 * side * (x + 2), height * (y + 2.0 / 3.0))
        centres.append(centre)
        ring = [at(x + dx, y + dy) for dx, dy in corners]
        for part, a, b in zip("abcdef", ring, [*ring[1:], ring[0]], strict=True):
            mesh.facet(f"s{k % columns}_{k // columns}{part}", (a, b, centre))

    inner = set(centres)

    def kind(a: int, b: int) -> str:
        if not {a, b} & inner:
            return "e"
        return "v" if math.dist(mesh.points[a], mesh.points[b]) > side else "m"

    def folds(long: float) -> dict[str, float]:
        # In the ratios of when it is folded all the way: 180, 60 and 90 degrees.
        return {"v": long, "m": -long / 3.0, "e": -0.5 * long}

    def is_given(crease: Crease) -> bool:
        return crease.name.startswith("v") and centres[0] in (crease.start, crease.end)

    shape = (mesh.points, mesh.facets, mesh.names)
    return _made("resch", _RESCH, (columns, rows), shape, kind, folds, (20.0, 90.0), is_given)


class _Mesh:
    """Points and facets as they are met; points that are alike are one."""

    def __init__(self) -> None:
        self.points: list[Point] = []
        self.facets: list[tuple[int, ...]] = []
        self.names: list[str] = []
        self._index: dict[tuple[int, int], int] = {}

    def point(self, x: float, y: float) -> int:
        key = (round(x / _DIGITS), round(y / _DIGITS))
        if key not in self._index:
            self._index[key] = len(self.points)
            self.points.append((x, y))
        return self._index[key]

    def facet(self, name: str, corners: tuple[int, ...]) -> None:
        self.facets.append(corners)
        self.names.append(name)


Shape = tuple[Sequence[Point], Sequence[Sequence[int]], Sequence[str]]


def _rows_of_triangles(columns: int, rows: int, offsets: Sequence[float], height: float) -> Shape:
    """Rows of cells between level lines of points that are offset along x, mm; each cell of two triangles, parted along
    the diagonal that leads up and to the left where the offset grows by half a side or less, and to the right."""
    mesh = _Mesh()
    for j in range(rows):
        for i in range(columns):
            low = [mesh.point((i + k) * BASE + offsets[j], j * height) for k in range(2)]
            high = [mesh.point((i + k) * BASE + offsets[j + 1], (j + 1) * height) for k in range(2)]
            if offsets[j + 1] > offsets[j]:
                halves = ((low[0], low[1], high[0]), (low[1], high[1], high[0]))
            else:
                halves = ((low[0], low[1], high[1]), (low[0], high[1], high[0]))
            for part, half in zip("ab", halves, strict=True):
                mesh.facet(f"f{i}_{j}{part}", half)
    return mesh.points, mesh.facets, mesh.names


def _made(
    name: str,
    story: tuple[str, str],
    size: tuple[int, int],
    shape: Shape,
    kind: Callable[[int, int], str],
    folds: Callable[[float], Mapping[str, float]],
    leading: tuple[float, float],
    is_given: Callable[[Crease], bool] = lambda _crease: True,
) -> str:
    """The text: it starts and rests at what `folds` gives for the leading folds, degrees; creases that are not given at
    the start follow the others."""
    start, rest = (folds(math.radians(each)) for each in leading)
    pattern = CreasePattern(shape[0], shape[1], lambda a, b: (kind(a, b), rest[kind(a, b)]), shape[2])
    creases = creases_of(pattern)
    vertices = len(pattern.points) - len(rim(pattern))
    facts = {"columns": size[0], "rows": size[1], "count": len(creases), "vertices": vertices}
    freedoms = len(creases) - 3 * vertices
    cells = "stars" if name == "resch" else "cells"
    return sheet(
        f"{name}_{size[0]}x{size[1]}",
        f"{TITLES[name]} of {size[0]} x {size[1]} {cells}: {vertices} vertices of six creases, {freedoms} freedoms.",
        _FREE.join(story).format(freedoms=freedoms, **facts),
        pattern,
        {crease.name: math.degrees(start[crease.name[0]]) for crease in creases if is_given(crease)},
    )
