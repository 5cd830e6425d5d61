"""What a mesh is like, and what that means for an element.

In: a `Mesh`, the name of an element. Out: numbers, and lines of text. Never: solves anything; how far off an element is
was measured once, on the plates named below.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from lamc.basics.checks import Array, checked_kind
from lamc.basics.errors import DesignError
from lamc.plates.elements.definition import SQUARE
from lamc.plates.elements.library import element as element_named
from lamc.plates.meshing.checks import name_cell
from lamc.plates.meshing.mesh import MAKING, Mesh

THREE_DIRECTIONS, GRADED, FOUR_DIRECTIONS = "three directions", "three directions, graded", "four directions"
SHAKEN, IRREGULAR, RECTANGLES, QUADRILATERALS = "six to a point", "irregular", "rectangles", "quadrilaterals"

# Excess of the deflection that BCIZ converges to: square plates, simply supported and clamped, point and uniform load,
# all alike to a tenth of a percent; isotropic, ν = 0.3. FOUR_DIRECTIONS are criss-cross and union-jack, which differ at
# the border only. SHAKEN: points moved by a quarter of the edge, 0.016 to 0.021. IRREGULAR: Delaunay triangles with
# angles of 25° and more; those of lamc's mesher, which are rounder, have BCIZ_ON_ROUND. `python -m
# benchmarks.bciz_bias` measures them.
BCIZ_BIAS = {THREE_DIRECTIONS: 0.0, GRADED: 0.0, FOUR_DIRECTIONS: 0.0323, SHAKEN: 0.018, IRREGULAR: 0.024}
BCIZ_ON_ROUND = (0.009, 0.013)  # from and to, over supports and loads
BCIZ_AT_HINGES = (
    0.2  # excess beside a strip a thousand times softer, two cells across; half with half the size
)

# Deflection over the right one where all cells have this aspect (length over height): simply supported square plate,
# uniform load, four cells along the long sides. DKT is 4 to 5 % too soft on all of them, as it is on four squares.
SLIVERS = np.array([1.0, 4.0, 10.0, 30.0, 100.0, 300.0, 1000.0])
SPECHT_ON_SLIVERS = np.array([0.945, 0.893, 0.607, 0.149, 0.0155, 0.00174, 0.00016])
BCIZ_ON_SLIVERS = np.array([1.075, 1.006, 0.997, 0.979, 0.927, 0.824, 0.672])

_SAME = 1e-6  # of an edge: vectors this near to each other are the same
_BINS = np.arange(0.0, 181.0, 10.0)
_MOSTLY = 0.8
_REPORTED = 8.0  # aspect from which slivers are told of


@dataclass(frozen=True)
class RegionSizes:
    """Cells of one region."""

    name: str
    cells: int
    area: float  # m²
    shortest: float  # m, of edges
    mean: float  # m
    longest: float  # m


@dataclass(frozen=True, eq=False)
class MeshReport:
    """`str` gives the lines.

    kind        how the cells lie, judged by geometry alone
    angles      smallest and largest at any corner, degrees
    histogram   corners by angle, in steps of 10° from 0° to 180°, shape (18,)
    aspect      largest length over height of a cell: longest edge squared over twice a triangle's area
    pieces      parts that no edge connects
    coincident  points that lie upon another one: the plate is cut there
    """

    points: int
    cells: int
    kind: str
    angles: tuple[float, float]
    histogram: NDArray[np.int64]
    aspect: float
    regions: Sequence[RegionSizes]
    pieces: int
    coincident: int
    lines: Sequence[str]

    def __str__(self) -> str:
        return "\n".join(self.lines)


def mesh_report(mesh: Mesh, element: str | None = None) -> MeshReport:
    """Angles, sizes and pattern of `mesh`, and what they mean for the element of that name, "dkt", "bciz+cst", …

    Raises DesignError for an element that is not there.
    """
    checked_kind(mesh, Mesh, "the mesh of a report", MAKING)
    angles = corner_angles(mesh)
    aspects = _aspects(mesh)
    regions = tuple(_sizes(mesh, index) for index in range(len(mesh.region_names)))
    kind, pieces, coincident = kind_of(mesh), _pieces(mesh), _coincident(mesh)
    lines = [
        f"{len(mesh.cells)} {'triangles' if mesh.corner_count == 3 else 'quadrilaterals'}, {len(mesh.points)} points, "
        f"{len(mesh.edges)} edges; pattern: {kind}",
        _worst_line("smallest angle", angles.min(axis=1), mesh, "°", -1),
        _worst_line("largest angle", angles.max(axis=1), mesh, "°", 1),
        _worst_line("largest length over height", aspects, mesh, "", 1),
        *(
            f"region {r.name!r}: {r.cells} cells on {r.area:.6g} m², edges {r.shortest:.3g} to "
            f"{r.longest:.3g} m, mean {r.mean:.3g} m"
            for r in regions
        ),
    ]
    if pieces > 1:
        lines.append(f"the mesh is in {pieces} pieces that no edge connects: each must be held")
    if coincident:
        lines.append(f"{coincident} points lie upon other points: the plate is cut open between them")
    if element is not None:
        lines += _for_element(mesh, element, kind, aspects)
    histogram = np.histogram(angles, _BINS)[0]
    ends = (float(angles.min()), float(angles.max()))
    return MeshReport(
        len(mesh.points),
        len(mesh.cells),
        kind,
        ends,
        histogram,
        float(aspects.max()),
        regions,
        pieces,
        coincident,
        tuple(lines),
    )


def bciz_bias(mesh: Mesh) -> float:
    """Part by which BCIZ's deflections are too large on ever finer meshes like this one; an estimate where the mesh is
    irregular. Raises DesignError for quadrilaterals."""
    kind = kind_of(checked_kind(mesh, Mesh, "the mesh of a bias", MAKING))
    if kind not in BCIZ_BIAS:
        raise DesignError("BCIZ is a triangle, and this mesh has quadrilaterals: take a grid of triangles")
    return BCIZ_BIAS[kind]


def corner_angles(mesh: Mesh) -> Array:
    """Of all cells, degrees, shape (m, 3 or 4)."""
    ahead = np.roll(mesh.corners, -1, axis=1) - mesh.corners
    behind = np.roll(mesh.corners, 1, axis=1) - mesh.corners
    cross = ahead[..., 0] * behind[..., 1] - ahead[..., 1] * behind[..., 0]
    return np.asarray(np.degrees(np.arctan2(cross, np.sum(ahead * behind, axis=2))))


def kind_of(mesh: Mesh) -> str:
    """How the cells lie, by geometry alone, whoever made the mesh.

    THREE_DIRECTIONS: all edges are one of three vectors, so all triangles are equal but for a half turn, and BCIZ
    passes the patch test. GRADED: so in parts, as a grid whose lines are finer here and there. FOUR_DIRECTIONS:
    criss-cross and union-jack, of any parallelogram. SHAKEN: irregular, but six triangles meet at nearly all points
    inside. RECTANGLES have sides along x and y.
    """
    vectors = mesh.points[mesh.edges[:, 1]] - mesh.points[mesh.edges[:, 0]]
    if mesh.corner_count == 4:
        along = np.min(np.abs(vectors), axis=1) <= _SAME * np.max(np.abs(vectors), axis=1)
        return RECTANGLES if along.all() else QUADRILATERALS
    directions = _distinct(vectors, at_most=5)
    if directions == 3:
        return THREE_DIRECTIONS
    inside = np.ones(len(mesh.points), dtype=bool)
    cell, side = mesh.boundary_edges.T
    inside[mesh.cells[cell, side]] = False  # the border is closed: each of its points starts an edge
    meeting = np.bincount(mesh.cells.ravel())[inside]
    if directions == 4 and np.isin(meeting, (4, 8)).all():
        return FOUR_DIRECTIONS
    if _parallelograms(mesh) > _MOSTLY:
        return GRADED
    return SHAKEN if len(meeting) and np.mean(meeting == 6) > _MOSTLY else IRREGULAR


def _distinct(vectors: Array, at_most: int) -> int:
    """How many different vectors there are, opposite ones counted once; stops at `at_most`."""
    tolerance = _SAME * float(np.abs(vectors).max())
    rest, count = vectors, 0
    while len(rest) and count < at_most:
        first = rest[0]
        same = np.minimum(np.abs(rest - first).max(axis=1), np.abs(rest + first).max(axis=1)) <= tolerance
        rest, count = rest[~same], count + 1
    return count


def _parallelograms(mesh: Mesh) -> float:
    """Part of the edges inside whose two triangles make a parallelogram."""
    opposite = np.roll(
        mesh.cells, 1, axis=1
    )  # corner before edge k's start, so the one that edge k does not have
    signs = np.zeros((len(mesh.edges), 2))
    np.add.at(signs, mesh.cell_edges.ravel(), mesh.points[opposite.ravel()])
    uses = np.bincount(mesh.cell_edges.ravel(), minlength=len(mesh.edges))
    ends = mesh.points[mesh.edges]
    misfit = np.abs(signs - ends.sum(axis=1)).max(axis=1)
    length = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    inner = uses == 2
    return float(np.mean(misfit[inner] <= _SAME * length[inner])) if inner.any() else 0.0


def _aspects(mesh: Mesh) -> Array:
    """Longest edge over the height above it, or for quadrilaterals over area per longest edge; shape (m,)."""
    edges = np.roll(mesh.corners, -1, axis=1) - mesh.corners
    longest = np.max(np.sum(edges * edges, axis=2), axis=1)
    return np.asarray(longest / (mesh.areas * (2.0 if mesh.corner_count == 3 else 1.0)))


def _sizes(mesh: Mesh, index: int) -> RegionSizes:
    mine = mesh.regions == index
    ends = mesh.points[mesh.edges[np.unique(mesh.cell_edges[mine])]]
    lengths = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1) if mine.any() else np.zeros(1)
    return RegionSizes(
        mesh.region_names[index],
        int(mine.sum()),
        float(mesh.areas[mine].sum()),
        float(lengths.min()),
        float(lengths.mean()),
        float(lengths.max()),
    )


def _pieces(mesh: Mesh) -> int:
    cells = np.repeat(np.arange(len(mesh.cells)), mesh.corner_count)
    size = len(mesh.cells) + len(mesh.edges)
    links = (np.ones(len(cells)), (cells, len(mesh.cells) + mesh.cell_edges.ravel()))
    return int(connected_components(coo_array(links, shape=(size, size)), directed=False)[0])


def _coincident(mesh: Mesh) -> int:
    return len(mesh.points) - len(np.unique(mesh.points, axis=0))


def _worst_line(what: str, values: Array, mesh: Mesh, unit: str, sense: int) -> str:
    cell = int(np.argmax(sense * values))
    return f"{what} {values[cell]:.3g}{unit}, in {name_cell(mesh.points, mesh.cells, cell)}"


def _for_element(mesh: Mesh, name: str, kind: str, aspects: Array) -> list[str]:
    chosen = element_named(name)
    if chosen.corner_count != mesh.corner_count:
        wanted = "quadrilaterals" if chosen.cell == SQUARE else "triangles"
        return [f"{name}: cannot be used on this mesh; it needs {wanted}"]
    bends = chosen.name.split("+")[0]
    thin = float(np.sum(mesh.areas[aspects > _REPORTED]) / mesh.areas.sum())
    worst = float(aspects.max())
    slivers = f"cells with length over height above {_REPORTED:g} cover {100.0 * thin:.3g} % of the plate"
    if bends == "bciz":
        return [_bciz_line(kind), *([_sliver_line("bciz", slivers, worst, BCIZ_ON_SLIVERS)] if thin else [])]
    if bends == "specht" and thin:
        return [_sliver_line("specht", slivers, worst, SPECHT_ON_SLIVERS) + "; dkt bears them"]
    if bends == "dkt":
        tail = f"; {slivers}, which it bears: as on squares up to 1:1000" if thin else ""
        return [
            f"dkt: converges to the plate's answer on any mesh, its error a quarter with half the size{tail}"
        ]
    if bends == "bfs" and kind != RECTANGLES:
        return [
            "bfs: is for rectangles with sides along x and y, and this mesh has others: take triangles and dkt"
        ]
    return [f"{name}: nothing to tell of this mesh"]


def _bciz_line(kind: str) -> str:
    if kind == THREE_DIRECTIONS:
        return "bciz: passes the patch test on this mesh, and converges to the plate's answer"
    if kind == GRADED:
        return (
            "bciz: does not pass the patch test where the cells' size changes; errors there are of the order of the "
            f"size, up to {100 * BCIZ_AT_HINGES:.0f} % with two cells across a soft hinge: dkt has none of this"
        )
    low, high = (100 * part for part in BCIZ_ON_ROUND)
    round_ones = f" ({low:+.2g} to {high:+.2g} % where triangles are round)" if kind == IRREGULAR else ""
    return (
        f"bciz: does not pass the patch test on this mesh; deflections converge to {100 * BCIZ_BIAS[kind]:+.3g} % off"
        f"{round_ones}, however fine it is: take dkt, or a grid with pattern 'one-diagonal'"
    )


def share_on_slivers(aspect: float, measured: Array) -> float:
    """Deflection over the right one where all cells have this aspect, from a table over `SLIVERS`."""
    return float(np.exp(np.interp(np.log(aspect), np.log(SLIVERS), np.log(measured))))


def _sliver_line(name: str, slivers: str, worst: float, measured: Array) -> str:
    part = share_on_slivers(worst, measured)
    return f"{name}: {slivers}; where all are like the worst, 1:{worst:.3g}, it gives {part:.2g} of the deflection"
