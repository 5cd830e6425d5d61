"""The plate that a body is, ready to be reduced: regions and laminates, where it is held, where others are joined.

In: a mechanism's tree and the name of a body. Out: a `BodyPlate`, from the drawing that the mechanism was split from,
or from the body's outline and a laminate that the scene gives. The plate half of lamc is imported when it is needed.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import shapely
from shapely.geometry import LineString, MultiLineString
from shapely.geometry.base import BaseGeometry

from lamc.basics.checks import did_you_mean
from lamc.basics.errors import DesignError
from lamc.mechanism.tree import Tree
from lamc.records.mechanism import Body, Joint, Mechanism

if TYPE_CHECKING:
    from lamc.plates.answers.reduction import Attachment
    from lamc.plates.laminates.laminate import Laminate

_REACH = 1e-3  # of the outline's size: an edge of it that is so near to a hinge line lies along it
_ROUNDING = 1e-8  # of the plate's size: how far its outline may be off what was drawn, by the grid of regions
_HEAVY = 1e-3  # part of its mass by which a body may weigh less than its plate


@dataclass(frozen=True, eq=False)
class BodyPlate:
    """World axes x and y, m.

    regions, laminates  by name
    clamped             line along which the inboard hinge holds it
    attachments         of the other hinges
    height              m, of the laminates' reference surface, world z
    """

    regions: "Mapping[str, BaseGeometry]"
    laminates: "Mapping[str, Laminate]"
    clamped: BaseGeometry
    attachments: "tuple[Attachment, ...]"
    height: float

    @property
    def outline(self) -> BaseGeometry:
        return shapely.union_all(list(self.regions.values()))


def body_plate(tree: Tree, name: str, laminate: "Laminate | None") -> BodyPlate:
    """The plate of the moving body of that name; laminate: of bodies that come from no drawing.

    Raises DesignError for a body that is not there or does not move, whose laminate is not known, or that no edge
    holds, and where the plate weighs more than the body.
    """
    mechanism = tree.mechanism
    inboard = {link.body.name: link.joint for link in tree.links}
    if name not in inboard:
        if name in {body.name for body in mechanism.bodies}:
            raise DesignError(
                f"flexible_links: body {name!r} is fixed; only bodies that move bend here: leave it out"
            )
        raise DesignError(f"flexible_links: no body is named {name!r}; {did_you_mean(name, sorted(inboard))}")
    body, hinge = mechanism.body(name), inboard[name]
    others = [j for j in mechanism.joints if name in (j.parent, j.child) and j.name != hinge.name]
    if abs(float(hinge.axis[2])) > _REACH:
        raise DesignError(
            f"flexible_links: hinge {hinge.name!r} of body {name!r} does not lie in the plane of the plates, world x "
            "and y; leave the body out"
        )
    if laminate is not None:
        found = _from_outline(body, hinge, others, laminate)
    else:
        found = _from_design(mechanism, name, hinge, others)
    weight = sum(found.laminates[n].areal_mass * region.area for n, region in found.regions.items())
    if weight > (1.0 + _HEAVY) * body.mass:
        raise DesignError(
            f"flexible_links: the plate of body {name!r} weighs {weight:.6g} kg, more than the body, {body.mass:.6g} "
            "kg; give a laminate and an outline that fit the body's mass"
        )
    return found


def _from_design(mechanism: Mechanism, name: str, hinge: Joint, others: list[Joint]) -> BodyPlate:
    """Without what bends at its hinges: that is in their stiffness."""
    from lamc.plates.answers.reduction import Attachment
    from lamc.plates.designs.from_design import plate_of

    if mechanism.design is None:
        raise DesignError(
            f"flexible_links: what body {name!r} is made of is not known, as mechanism {mechanism.name!r} comes from "
            "no drawing: give its laminate, or run the design itself"
        )
    try:
        plate = plate_of(mechanism.design, name, hinges="lines")
    except DesignError as error:
        raise DesignError(f"flexible_links: body {name!r} is no plate here: {error.message}") from error
    outline = shapely.union_all(list(plate.regions.values()))
    near = _ROUNDING * float(np.ptp(np.reshape(outline.bounds, (2, 2)), axis=0).max())
    # Regions are laid over one another on a grid, and edges along hinges are not.
    edges = {name: _on_rim(each.line, outline, near) for name, each in plate.hinges.items()}
    clamped = edges[hinge.name]
    if clamped.is_empty:
        raise DesignError(
            f"flexible_links: no edge of body {name!r} lies along its hinge {hinge.name!r}, which is to hold it; leave "
            "the body out"
        )
    attachments = tuple(
        Attachment((float(j.point[0]), float(j.point[1])), None if edges[j.name].is_empty else edges[j.name])
        for j in others
    )
    return BodyPlate(plate.regions, plate.laminates, clamped, attachments, plate.height)


def _on_rim(line: BaseGeometry, outline: BaseGeometry, near: float) -> BaseGeometry:
    """The sides of an outline that a line goes along, m; the line itself where it is not as long as they are."""
    rings = [shapely.get_coordinates(ring) for ring in shapely.get_parts(shapely.boundary(outline))]
    sides = np.concatenate([np.stack([ring[:-1], ring[1:]], axis=1) for ring in rings])
    apart = shapely.distance(line, shapely.points(sides))
    kept = sides[(apart <= near).all(axis=1)]
    if not len(kept):  # the line is empty, or goes along a part of one side
        return line
    found = shapely.line_merge(shapely.multilinestrings(list(kept)))
    return found if abs(found.length - line.length) <= near * (1 + len(kept)) else line


def _from_outline(body: Body, hinge: Joint, others: list[Joint], laminate: "Laminate") -> BodyPlate:
    from lamc.plates.answers.reduction import Attachment

    if not body.outline:
        raise DesignError(
            f"flexible_links: body {body.name!r} has no outline, so it is no plate; give it one, or leave it out"
        )
    area = shapely.union_all([piece.polygon for piece in body.outline])
    if area.geom_type != "Polygon":
        raise DesignError(
            f"flexible_links: the outline of body {body.name!r} is in pieces seen from above; it must be one plate"
        )
    low, high = min(p.z_bottom for p in body.outline), max(p.z_top for p in body.outline)
    clamped = _edge_at(area, hinge)
    if clamped is None:
        raise DesignError(
            f"flexible_links: no edge of the outline of body {body.name!r} lies on the line of hinge {hinge.name!r}, "
            "which is to hold it; draw the outline up to its hinge"
        )
    attachments = tuple(
        Attachment(
            (float(j.point[0]), float(j.point[1])),
            _edge_at(area, j) if abs(float(j.axis[2])) <= _REACH else None,
        )
        for j in others
    )
    middle = 0.5 * (low + high)
    return BodyPlate({"": area}, {"": laminate}, clamped, attachments, middle + laminate.reference_height)


def _edge_at(area: BaseGeometry, hinge: Joint) -> BaseGeometry | None:
    """The stretches of the outline along a hinge line; None where there are none."""
    from lamc.plates.designs.hinge_edges import edges_along

    size = float(np.hypot(*np.ptp(np.reshape(area.bounds, (2, 2)), axis=0)))
    way = hinge.axis[:2] * (
        size + float(np.linalg.norm(hinge.point)) + area.distance(shapely.Point(hinge.point[:2]))
    )
    middle = hinge.point[:2]
    line = LineString([middle - way, middle + way])
    found = [
        piece for piece in edges_along(area.boundary, line, _REACH * size) if piece.length > _REACH * size
    ]
    if not found:
        return None
    return found[0] if len(found) == 1 else MultiLineString(found)
