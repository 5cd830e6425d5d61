"""Hinges inside a plate: lines along which its two sides may turn against each other.

In: a line and the stiffness of its rotational spring. Out: a record, checked by itself, and the edges of a mesh that it
runs along. Never: unknowns; `doubling.py` gives each side its own.

Both sides keep one deflection and one displacement in the plane along the line, and so one slope along it; the slope
across it may jump. The axis lies in the reference surface of the laminates.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from lamc.basics.checks import checked_name, checked_number, shown
from lamc.basics.errors import DesignError, UnsupportedError, about
from lamc.plates.edge_parts import edge_parts_on
from lamc.plates.elements.definition import CORNERS, Element
from lamc.plates.locator import MeshLocator
from lamc.plates.meshing.mesh import Integers
from lamc.plates.supports import checked_where, where_text


@dataclass(frozen=True, eq=False)
class HingeLine:
    """Both sides of a line inside the plate are hinged to each other.

    where      shapely LineString, or several as a MultiLineString, m, along edges of the mesh (`plate.mesh(…,
               follow=[where])`); it may end at the plate's edge, at another hinge line or inside the plate, where the
               rotation is zero. Where its segments turn by less than 30° it is one smooth curve, as the mesh gives it;
               at sharper corners it cannot turn
    stiffness  of the rotational spring, N·m/rad per metre of line; 0: turns freely
    name       for messages and results; "": by its place

    Raises DesignError for what is no line, for one without length, and for a stiffness below zero.
    """

    where: BaseGeometry
    stiffness: float = 0.0
    name: str = ""

    def __post_init__(self) -> None:
        if not isinstance(self.where, BaseGeometry) or (
            not self.where.is_empty and shapely.get_dimensions(self.where) != 1
        ):
            raise DesignError(
                f"a HingeLine is at {shown(self.where)}; it must be a shapely LineString inside the plate"
            )
        if not self.where.is_empty and self.where.length == 0.0:
            raise DesignError(
                f"a HingeLine at {where_text(self.where)} has no length; give two points that differ"
            )
        checked_where(self.where, "a HingeLine")
        value = checked_number(self.stiffness, "the stiffness of a HingeLine", minimum=0.0)
        object.__setattr__(self, "stiffness", value)
        if self.name != "":
            checked_name(self.name, "a HingeLine")

    @property
    def title(self) -> str:
        """Its kind, with its name."""
        return f"the HingeLine {self.name!r}" if self.name else "the HingeLine"

    @property
    def text(self) -> str:
        """As a message names it."""
        return f"{self.title} at {where_text(self.where)}"


def hinge_edges(places: MeshLocator, hinges: Sequence[HingeLine]) -> tuple[Integers, ...]:
    """For every hinge the numbers of the mesh's edges on it, ascending.

    Raises DesignError for a line off the plate, along its edge, beside the mesh's edges or upon another hinge line, and
    for the name of another one; UnsupportedError for an element without slopes.
    """
    mesh = places.dofs.mesh
    owner = np.full(len(mesh.edges), -1, dtype=np.int32)
    found = []
    named: dict[str, HingeLine] = {}
    for number, hinge in enumerate(hinges):
        with about(hinge):
            if hinge.name and hinge.name in named:
                raise DesignError(
                    f"{hinge.text} has the name of the one at {where_text(named[hinge.name].where)}; results are told "
                    "by it: give each line a name of its own, or both as one line, a MultiLineString"
                )
            named[hinge.name] = hinge
            _check_element(places.dofs.element, hinge)
            edges = _edges_of(places, hinge)
            taken = edges[owner[edges] >= 0]
            if len(taken):
                x, y = mesh.points[mesh.edges[taken[0]]].mean(axis=0)
                raise DesignError(
                    f"{hinge.text} lies upon {hinges[owner[taken[0]]].text} at ({x:.6g}, {y:.6g}); a place has one "
                    "hinge: cut one of them at the other, or take it away"
                )
            owner[edges] = number
            found.append(edges)
    return tuple(found)


def _edges_of(places: MeshLocator, hinge: HingeLine) -> Integers:
    mesh = places.dofs.mesh
    parts = edge_parts_on(places, hinge.where, hinge.title)
    cells, local = parts.edges.T
    edges = mesh.cell_edges[cells, local]
    ends = (
        mesh.points[mesh.cells[cells, local]],
        mesh.points[mesh.cells[cells, (local + 1) % mesh.corner_count]],
    )
    broken = np.flatnonzero((parts.ends != (0.0, 1.0)).any(axis=1))
    if len(broken):
        k = broken[0]
        t = parts.ends[k, 0] if parts.ends[k, 0] > 0.0 else parts.ends[k, 1]
        x, y = ends[0][k] + t * (ends[1][k] - ends[0][k])
        raise DesignError(
            f"{hinge.text} ends at ({x:.6g}, {y:.6g}), within an edge of the mesh; let the mesh follow it: "
            "plate.mesh(…, follow=[line])"
        )
    outer = np.flatnonzero(places.on_boundary[edges])
    if len(outer):
        x, y = 0.5 * (ends[0] + ends[1])[outer[0]]
        raise DesignError(
            f"{hinge.text} runs along the edge of the plate at ({x:.6g}, {y:.6g}), where there is plate on one side "
            "only; move it inside, or take a Hinged support if the edge is hinged to what stands still"
        )
    return np.sort(edges).astype(np.int32)


def _check_element(element: Element, hinge: HingeLine) -> None:
    if not element.bends:
        raise DesignError(
            f"{hinge.text} lets the plate fold, and element {element.name!r} only stretches; choose one that bends, "
            f"such as 'dkt+{element.name}'"
        )
    corners = [tuple(map(float, at)) for at in CORNERS[element.cell]]
    at_corners = [node.dofs for node in element.nodes if tuple(map(float, node.at)) in corners]
    if len(at_corners) < len(corners) or not all({"w", "w_x", "w_y"} <= set(names) for names in at_corners):
        raise UnsupportedError(
            f"{hinge.text} needs an element with w, w_x and w_y at its corners, and {element.name!r} has "
            f"{', '.join(sorted(set().union(*at_corners))) or 'nothing'} there; take 'dkt'"
        )
