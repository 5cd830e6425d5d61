"""Whether the mesh follows what holds the plate.

In: places of a problem, and where a support is. Out: nothing, or a refusal that says where the mesh leaves it. Never:
unknowns, equations.

A support holds nodes and edges. Where a line runs through cells, or ends within an edge, only what happens to lie on it
would be held: a plate that is far too soft, and nothing in its answer shows it.
"""

import numpy as np
import shapely
from shapely.geometry import MultiPoint
from shapely.geometry.base import BaseGeometry

from lamc.basics.checks import Array
from lamc.basics.errors import DesignError
from lamc.plates.locator import MeshLocator
from lamc.plates.supports import Where, where_text

# Of the mean length of edges on a support: an area that reaches less beyond what is held is as good as followed, as
# by a box drawn around an edge. So small a shift of a support changes less than its cells do.
_BEYOND = 0.01
_CHORD = 0.07  # of a chord's length: height of the arc above it where both ends turn by 15°
_LEAST = 1e-9  # of the plate's size: round-off of overlays


def check_followed(places: MeshLocator, where: Where, what: str) -> None:
    """Raises DesignError, naming `what`, unless nodes lie on all points of `where`, edges along all lines of it that
    are on the plate, and cells or edges cover its areas there."""
    if isinstance(where, str):
        return
    parts = shapely.get_parts(shapely.get_parts(where))
    for dimension in range(3):
        mine = parts[shapely.get_dimensions(parts) == dimension]
        if not len(mine):
            continue
        place = shapely.union_all(mine)
        if dimension == 0:
            _check_points(places, place, what)
        elif dimension == 1:
            _check_line(places, where, place, what)
        else:
            _check_area(places, where, place, what)


def _check_points(places: MeshLocator, where: BaseGeometry, what: str) -> None:
    points = shapely.get_parts(where)
    on_plate = shapely.dwithin(points, places.covered, places.tolerance)  # of others a note tells, see `idle`
    lost = points[on_plate & ~shapely.dwithin(points, MultiPoint(places.dofs.points), places.tolerance)]
    if len(lost):
        raise DesignError(
            f"{what} at {where_text(lost[0])} touches no node of the mesh there; let the mesh have one: "
            "plate.mesh(…, follow=[point])"
        )


def _check_line(places: MeshLocator, where: BaseGeometry, line: BaseGeometry, what: str) -> None:
    slack = _slack(places)
    # Edge by edge, then joined: a chain of thousands grown in one go by so little takes GEOS many seconds.
    held = shapely.union_all(shapely.buffer(shapely.get_parts(_edges(places, line)), slack))
    left = shapely.difference(shapely.intersection(line, places.covered), held)
    lost = [part for part in shapely.get_parts(left) if part.length > 2.0 * slack]
    at = shapely.line_interpolate_point(lost[:1], 0.5, normalized=True)
    beside = _beside(places, line)
    if len(at) or len(beside):
        _refuse(where, shapely.get_coordinates(at) if len(at) else beside, what)


def _beside(places: MeshLocator, line: BaseGeometry) -> Array:
    """Middles of edges (k, 2) from one point of the line to another that keep beside it, as chords of a curve do."""
    mesh, tolerance = places.dofs.mesh, places.tolerance
    ends = mesh.points[
        mesh.edges[shapely.dwithin(places.corners_drawn, line, tolerance)[mesh.edges].all(axis=1)]
    ]
    middles = ends.mean(axis=1)
    length = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    off = shapely.distance(shapely.points(middles), line)
    return np.asarray(middles[(off > tolerance) & (off < _CHORD * length)])


def _check_area(places: MeshLocator, where: BaseGeometry, area: BaseGeometry, what: str) -> None:
    edges = _edges(places, area)
    held = shapely.union_all([edges, MultiPoint(places.dofs.points[places.nodes(area, what)])])
    rim = shapely.intersection(area.boundary, places.covered)
    count = len(shapely.get_parts(edges))
    length = edges.length / count if count else np.sqrt(places.dofs.mesh.areas.mean())
    beyond = _BEYOND * length
    corners = (
        shapely.get_coordinates(shapely.segmentize(rim, length / 4.0))
        if not rim.is_empty
        else np.zeros((0, 2))
    )
    far = np.flatnonzero(shapely.distance(shapely.points(corners), held) > max(beyond, _slack(places)))
    if len(far):
        _refuse(where, corners[far[:1]], what)


def _edges(places: MeshLocator, where: BaseGeometry) -> BaseGeometry:
    """The edges that lie on `where`, whole, as lines."""
    mesh = places.dofs.mesh
    cells, sides = places.edges_on(where).T
    return shapely.union_all(shapely.linestrings(mesh.points[mesh.edges[mesh.cell_edges[cells, sides]]]))


def _slack(places: MeshLocator) -> float:
    low, high = places.dofs.mesh.points.min(axis=0), places.dofs.mesh.points.max(axis=0)
    return max(2.0 * places.tolerance, _LEAST * float(np.hypot(*(high - low))))


def _refuse(where: BaseGeometry, at: Array, what: str) -> None:
    x, y = at[0]
    raise DesignError(
        f"{what} at {where_text(where)} is not followed by the mesh at ({x:.6g}, {y:.6g}), where it runs through cells "
        "or ends within an edge, and would hold only the nodes that happen to lie on it: let edges run along it, "
        "plate.mesh(…, follow=[line]) (a plate file does so unless it asks for a grid), or move it"
    )
