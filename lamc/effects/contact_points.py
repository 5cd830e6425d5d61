"""Which points of the bodies can touch something: corners of their outlines, or points that are listed.

Goes in: a mechanism and what a user said. Comes out: points by body, as drawn. Never: where they are in motion.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import shapely
from shapely.geometry import MultiPolygon, Polygon

from lamc.basics.errors import DesignError
from lamc.records.mechanism import Body, Mechanism

Point = tuple[float, float, float]  # m, drawn configuration, world axes
DRAWN: Literal["drawn"] = "drawn"
SAME_HEIGHT = 1e-9  # of the body's extent: faces nearer to each other than this are one


@dataclass(frozen=True)
class ContactPoint:
    """A point of a moving body."""

    body: str
    point: Point


def check_points(points: Mapping[str, tuple[Point, ...]] | Literal["drawn"] | None) -> None:
    """Raises DesignError for maps and lists that are empty."""
    if not isinstance(points, Mapping):
        return
    if not points:
        raise DesignError(
            "points of ground contact name no body; map bodies to lists of points, as in {foot: [[0, 0, 0]]}, or give "
            f"{DRAWN!r}"
        )
    for body, given in points.items():
        if not given:
            raise DesignError(
                f"points of ground contact of body {body!r} are none; give a list of points [x, y, z] in m"
            )


def contact_points(
    mechanism: Mechanism,
    moving: Sequence[str],
    bodies: Sequence[str] | None,
    points: Mapping[str, Sequence[Point]] | Literal["drawn"] | None,
    corners: int,
) -> tuple[ContactPoint, ...]:
    """The points that can touch, body by body in the mechanism's order, each once.

    moving   names of the bodies that move
    bodies   whose corners count; None: all moving bodies with an outline, or no corners where points are listed
    points   further points by body; DRAWN: the contact points of the drawing; or None
    corners  how many a body has at most on each of its faces

    Raises DesignError for a body that is not there, that is fixed or has no outline, and where nothing can touch.
    """
    known = {body.name: body for body in mechanism.bodies}
    listed = drawn_points(mechanism, moving) if isinstance(points, str) else points or {}
    for name in (*(bodies or ()), *listed):
        if name not in known:
            raise DesignError(f"no body is named {name!r}; the bodies are {', '.join(sorted(known))}")
        if name not in moving:
            raise DesignError(f"body {name!r} does not move and so touches nothing; name bodies that move")
    if bodies is None:
        drawn = () if points else tuple(b.name for b in mechanism.bodies if b.name in moving and b.outline)
    else:
        drawn = tuple(bodies)
    found: dict[ContactPoint, None] = {}
    for body in mechanism.bodies:
        each: list[Point] = list(corners_of(body, corners)) if body.name in drawn else []
        each += listed.get(body.name, ())
        found |= dict.fromkeys(ContactPoint(body.name, point) for point in each)
    if not found:
        raise DesignError(
            "no moving body has an outline, so none has corners that could touch: list points by body"
        )
    return tuple(found)


def drawn_points(mechanism: Mechanism, moving: Sequence[str]) -> Mapping[str, tuple[Point, ...]]:
    """The contact points of the drawing by body: where each goes in and out of the moving bodies that it lies on.

    Raises DesignError where the drawing has none, and for one that lies on no moving body.
    """
    if not mechanism.contact_points:
        raise DesignError(
            f"the drawing of {mechanism.name!r} has no contact points: draw some, list points by body, or name bodies "
            "whose corners touch"
        )
    found: dict[str, tuple[Point, ...]] = {}
    for x, y in mechanism.contact_points:
        at = shapely.Point(x, y)
        hit = False
        for body in mechanism.bodies:
            reach = SAME_HEIGHT * mechanism.size
            plates = [p for p in body.outline if body.name in moving and p.polygon.distance(at) <= reach]
            if plates:
                hit = True
                heights = {min(p.z_bottom for p in plates), max(p.z_top for p in plates)}
                found[body.name] = (*found.get(body.name, ()), *((x, y, z) for z in sorted(heights)))
        if not hit:
            raise DesignError(
                f"the drawing's contact point ({x * 1e3:.6g}, {y * 1e3:.6g}) mm lies on no moving body; move it, or "
                "list points by body"
            )
    return found


def corners_of(body: Body, most: int) -> tuple[Point, ...]:
    """Corners of the convex hulls of the body's lowest and highest face, at most `most` on each.

    Raises DesignError for a body without an outline.
    """
    if not body.outline:
        raise DesignError(f"body {body.name!r} has no outline and so no corners; list its points instead")
    low = min(plate.z_bottom for plate in body.outline)
    high = max(plate.z_top for plate in body.outline)
    xs, ys = zip(*(xy for plate in body.outline for xy in plate.polygon.exterior.coords), strict=True)
    near = SAME_HEIGHT * (max(xs) - min(xs) + max(ys) - min(ys))
    bottom = [plate.polygon for plate in body.outline if plate.z_bottom <= low + near]
    top = [plate.polygon for plate in body.outline if plate.z_top >= high - near]
    faces = [(low, bottom), (high, top)] if high - low > near else [(low, bottom)]
    return tuple((x, y, float(z)) for z, polygons in faces for x, y in hull_corners(polygons, most))


def hull_corners(polygons: Sequence[Polygon], most: int) -> tuple[tuple[float, float], ...]:
    """Corners of the convex hull, m, anticlockwise from the lowest x. Beyond `most`, those go whose loss takes the
    least area, one after the other (Visvalingam & Whyatt 1993)."""
    hull = MultiPolygon(list(polygons)).convex_hull.normalize().exterior.coords[:-1]
    corners = [(float(x), float(y)) for x, y in hull][::-1]
    while len(corners) > most:
        lost = [
            _area(corners[i - 1], corners[i], corners[(i + 1) % len(corners)]) for i in range(len(corners))
        ]
        # Among equals the first goes, whatever their round-off: a round outline keeps its symmetry
        del corners[next(i for i, area in enumerate(lost) if area <= min(lost) * (1.0 + 1e-9))]
    return tuple(corners)


def _area(a: tuple[float, float], b: tuple[float, float], c: tuple[float, float]) -> float:
    return 0.5 * abs((b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1]))
