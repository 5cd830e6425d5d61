"""lamc's mesher beside Triangle (by `triangle` and by MeshPy) and Gmsh, where they are installed.

    pip install -e '.[meshers]'    # Triangle may not be used commercially; Gmsh is under the GPL
    python -m benchmarks.meshers [--size M] [--repeats N] [--out FILE]

In: outlines with holes, narrow strips and borders that a mesh has to keep. Out: a table, and JSON with the machine:
triangles, the least angle, the share of angles below lamc's 25°, the thinnest cells and the time of each, and the time
over lamc's. Never: a judgement of results on these meshes; `python -m benchmarks.plates` has some.

All are asked for edges of about `size` and borders kept, those that can also for 25° at least. Times are the shortest
of several, taken in turn; of lamc they hold all checks and the `Mesh` made ready, of others the arguments and the call.
"""

import argparse
import importlib.util
import math
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np
import shapely
from shapely.geometry import Point, Polygon, box
from shapely.geometry.base import BaseGeometry

from benchmarks.measure import environment, interleaved, seconds, table, write_json
from lamc import plate

ANGLE = 25.0  # degrees, what lamc promises
STRIPS = (100.0, 1000.0)  # length of a link over the width of the film between two, as in flexure hinges
AREA = 0.41  # of a triangle over the squared size: lamc's edges are 0.9 of it on average, and √3/4 of an edge's square

Triangles = tuple[np.ndarray, np.ndarray]  # points (n, 2), m; cells (m, 3)


@dataclass(frozen=True)
class Case:
    """A domain of pieces side by side, m; the borders between them are to be kept."""

    name: str
    pieces: tuple[Polygon, ...]

    @property
    def whole(self) -> Polygon:
        return shapely.union_all(self.pieces)

    @property
    def segments(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Points (n, 2), segments (s, 2) and a point in each hole (h, 2) of all borders, each once."""
        lines = shapely.union_all([piece.boundary for piece in self.pieces])
        pairs = np.concatenate(
            [
                np.stack([at[:-1], at[1:]], axis=1)
                for at in map(shapely.get_coordinates, shapely.get_parts(lines))
            ]
        )
        points, index = np.unique(pairs.reshape(-1, 2), axis=0, return_inverse=True)
        holes = [Polygon(ring).representative_point().coords[0] for ring in self.whole.interiors]
        return points, index.reshape(-1, 2), np.array(holes).reshape(-1, 2)


def cases() -> tuple[Case, ...]:
    """A square, a perforated plate, two links with a strip of film between them, and an irregular star."""
    holes = [Point(x, y).buffer(0.04, quad_segs=8) for x in (0.25, 0.5, 0.75) for y in (0.25, 0.5, 0.75)]
    turn = np.linspace(0.0, 2.0 * math.pi, 23, endpoint=False)
    radius = np.random.default_rng(7).uniform(0.2, 0.5, len(turn))
    star = Polygon(np.stack([radius * np.cos(turn), radius * np.sin(turn)], axis=1))
    return (
        Case("square", (box(0, 0, 1, 1),)),
        Case("holes", (box(0, 0, 1, 1).difference(shapely.union_all(holes)),)),
        *(_hinge(ratio) for ratio in STRIPS),
        Case("star", (star,)),
    )


def _hinge(ratio: float) -> Case:
    ends = (0.0, 0.5, 0.5 + 0.5 / ratio, 1.0)
    pieces = tuple(box(a, 0.0, b, 0.5) for a, b in pairwise(ends))
    return Case(f"hinge strip 1:{ratio:g}", pieces)


def by_lamc(case: Case, size: float) -> Triangles:
    regions = {str(k): piece for k, piece in enumerate(case.pieces)} if len(case.pieces) > 1 else None
    mesh = plate.mesh(case.whole, size, regions=regions)
    return mesh.points, mesh.cells


def by_triangle(case: Case, size: float) -> Triangles:
    import triangle  # type: ignore[import-not-found, unused-ignore]

    points, segments, holes = case.segments
    given = {"vertices": points, "segments": segments} | ({"holes": holes} if len(holes) else {})
    found = triangle.triangulate(given, f"pq{ANGLE:g}a{AREA * size * size:.12f}")
    return found["vertices"], found["triangles"]


def by_meshpy(case: Case, size: float) -> Triangles:
    from meshpy import triangle  # type: ignore[import-not-found, unused-ignore]

    points, segments, holes = case.segments
    info = triangle.MeshInfo()
    info.set_points(points.tolist())
    info.set_facets(segments.tolist())
    info.set_holes(holes.tolist())
    found = triangle.build(info, min_angle=ANGLE, max_volume=AREA * size * size)
    return np.array(found.points), np.array(found.elements)


def by_gmsh(case: Case, size: float) -> Triangles:
    import gmsh  # type: ignore[import-not-found, unused-ignore]

    points, segments, _ = case.segments
    gmsh.initialize(["-nt", "1"], False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        geo = gmsh.model.geo
        corners = [geo.addPoint(x, y, 0.0, size) for x, y in points]
        lines = {frozenset((a, b)): geo.addLine(corners[a], corners[b]) for a, b in segments.tolist()}
        number = {tuple(at): k for k, at in enumerate(points.tolist())}
        for piece in _split(case):
            loops = []
            for ring in (piece.exterior, *piece.interiors):
                around = [number[tuple(at)] for at in ring.coords[:-1]]
                pairs = zip(around, [*around[1:], around[0]], strict=True)
                loops.append(geo.addCurveLoop([lines[frozenset(pair)] for pair in pairs], reorient=True))
            geo.addPlaneSurface(loops)
        geo.synchronize()
        gmsh.model.mesh.generate(2)
        tags, at, _ = gmsh.model.mesh.getNodes()
        place = np.zeros(int(tags.max()) + 1, dtype=int)
        place[tags] = np.arange(len(tags))
        cells = gmsh.model.mesh.getElementsByType(2)[1].reshape(-1, 3)
        return at.reshape(-1, 3)[:, :2], place[cells]
    finally:
        gmsh.finalize()


def _split(case: Case) -> Sequence[Polygon]:
    """The pieces, with each other's corners on their borders."""
    lines = shapely.union_all([piece.boundary for piece in case.pieces])
    faces: Sequence[BaseGeometry] = shapely.get_parts(shapely.polygonize(shapely.get_parts(lines)))
    return [
        face for face in faces if isinstance(face, Polygon) and case.whole.covers(face.representative_point())
    ]


MESHERS: dict[str, tuple[str, Callable[[Case, float], Triangles]]] = {
    "lamc": ("lamc", by_lamc),
    "Triangle": ("triangle", by_triangle),
    "Triangle by MeshPy": ("meshpy", by_meshpy),
    "Gmsh": ("gmsh", by_gmsh),
}


@dataclass(frozen=True)
class Row:
    """One mesh."""

    case: str
    mesher: str
    triangles: int
    least_angle: float  # degrees
    below: float  # share of triangles with an angle below ANGLE
    thinnest: float  # height over longest edge, of the thinnest triangle; 0.87 if equilateral
    covered: float  # area over that of the case, less 1
    seconds: float


def measured(case: Case, size: float, repeats: int) -> list[Row]:
    """One row for each mesher that is installed."""
    able = {name: make for name, (module, make) in MESHERS.items() if importlib.util.find_spec(module)}
    jobs = {name: lambda make=make: make(case, size) for name, make in able.items()}  # type: ignore[misc]
    meshes = {name: job() for name, job in jobs.items()}  # the first call of each compiles or loads
    best = interleaved(jobs, repeats)
    return [_row(case, name, *meshes[name], best[name]) for name in able]


def _row(case: Case, name: str, points: np.ndarray, cells: np.ndarray, seconds: float) -> Row:
    at = points[cells]
    edges = np.roll(at, -1, axis=1) - at
    lengths = np.hypot(edges[..., 0], edges[..., 1])
    area = 0.5 * np.abs(edges[:, 0, 0] * edges[:, 1, 1] - edges[:, 0, 1] * edges[:, 1, 0])
    a, b, c = np.sort(lengths, axis=1).T
    least = np.degrees(np.arccos(np.clip((b * b + c * c - a * a) / (2.0 * b * c), -1.0, 1.0)))
    return Row(
        case.name,
        name,
        len(cells),
        float(least.min()),
        float((least < ANGLE - 1e-9).mean()),
        float((2.0 * area / c**2).min()),
        float(area.sum()) / case.whole.area - 1.0,
        seconds,
    )


def main() -> None:
    """Prints the table and writes the rows."""
    parser = argparse.ArgumentParser(description="lamc's mesher beside Triangle and Gmsh")
    parser.add_argument("--size", type=float, default=0.01, help="length of edges, m; the cases are 1 m wide")
    parser.add_argument("--repeats", type=int, default=5, help="times that each is measured")
    parser.add_argument("--out", type=Path, default=Path("out/bench/meshers.json"), help="where the rows go")
    options = parser.parse_args()
    rows = [row for case in cases() for row in measured(case, options.size, options.repeats)]
    own = {row.case: row.seconds for row in rows if row.mesher == "lamc"}
    head = ["case", "mesher", "triangles", "least angle", "below 25°", "thinnest", "time", "over lamc"]
    lines = [
        [
            row.case, row.mesher, str(row.triangles), f"{row.least_angle:.1f}°", f"{row.below:.2%}",
            f"{row.thinnest:.3f}", seconds(row.seconds), f"{row.seconds / own[row.case]:.2f}",
        ]
        for row in rows
    ]  # fmt: skip
    print(table(head, lines))
    data = {"environment": environment(), "size": options.size, "rows": [asdict(row) for row in rows]}
    write_json(options.out, data)
    print(f"written to {options.out}")


if __name__ == "__main__":
    main()
