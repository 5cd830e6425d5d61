"""The strips of a flat wing: where they lie on its body and how long their chords are.

Goes in: an outline, as drawn, and the line about which the wing pitches. Comes out: strips across the span, in axes of
the wing. Never: how the wing moves, or what the air does.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from shapely.affinity import affine_transform
from shapely.geometry import LineString, Polygon
from shapely.geometry.base import BaseGeometry

from lamc.basics.errors import DesignError
from lamc.records.mechanism import Array, Mechanism

Point = tuple[float, float, float]
Corners = tuple[tuple[float, float], ...]  # m, x and y as drawn

IN_PLANE = 1e-6  # sine of the largest angle between the line of a hinge and the plane of the wing
SIDES_ALIKE = 1e-6  # of the area: where the line halves the wing so nearly, no side is the leading one


@dataclass(frozen=True)
class Strip:
    """A piece of the wing across its span. Chordwise places count from the line, positive towards the leading edge."""

    along: float  # m, of its middle, from the wing's origin along the span
    width: float  # m, by which what happens per span is multiplied
    leading: float  # m, place of the leading edge
    chord: float  # m

    def place(self, fraction: float) -> float:
        """Chordwise place, m, at that fraction of the chord behind the leading edge."""
        return self.leading - fraction * self.chord

    @property
    def axis(self) -> float:
        """Where the line crosses the chord, as a fraction of it from the leading edge."""
        return self.leading / self.chord


@dataclass(frozen=True)
class Wing:
    """A flat wing in axes of its own: chord (towards the leading edge), span (normal × chord), normal (drawn up).

    origin   m, as drawn, on the line
    axes     chord, span, normal: unit vectors as drawn
    strips   along the span
    """

    origin: Point
    axes: tuple[Point, Point, Point]
    strips: tuple[Strip, ...]

    def added_mass(self, fluid_density: float) -> Array:
        """Matrix (6, 6) of the fluid's mass at the origin, of (velocity, angular velocity) in the wing's axes.

        Each strip is a flat plate that moves broadside: π ρ c²/4 per span at mid-chord, and π ρ c⁴/128 about it
        (Sedov 1965, ch. I; Newman 1977, table 4.3).
        """
        matrix = np.zeros((6, 6))
        for strip in self.strips:
            # Velocity of mid-chord along the normal: v_n + along ω_c - middle ω_s
            broadside = np.array([0.0, 0.0, 1.0, strip.along, -strip.place(0.5), 0.0])
            turning = np.array([0.0, 0.0, 0.0, 0.0, 1.0, 0.0])
            mass = 0.25 * math.pi * fluid_density * strip.chord**2 * strip.width
            spin = math.pi / 128.0 * fluid_density * strip.chord**4 * strip.width
            matrix += mass * np.outer(broadside, broadside) + spin * np.outer(turning, turning)
        return matrix


def wing(
    mechanism: Mechanism,
    body: str,
    count: int,
    line: Corners | None,
    leading: tuple[float, float] | None,
    outline: Corners | None,
) -> Wing:
    """The wing that a body of the mechanism is, in `count` strips at Gauss-Legendre points of its span.

    line     two points that the wing pitches about; None: the hinge of the body, which has to have one only
    leading  direction towards the leading edge; None: the side of the line with less area
    outline  corners of the wing; None: the body's own outline

    The chord reaches from the foremost to the rearmost point of the outline. Raises DesignError where there is no
    outline, no line, or no side that leads.
    """
    shape, height = _shape(mechanism, body, outline)
    point, direction = _line(mechanism, body, line)
    ahead = np.array([-direction[1], direction[0]])
    if leading is None:
        ahead = _smaller_side(shape, point, ahead, body)
    else:
        across = float(ahead @ np.array(leading))
        if not abs(across) > 1e-9 * math.hypot(*leading):
            raise DesignError(
                f"leading of the wing {body!r} is {list(leading)}, along the line that it pitches about; it must point "
                "to one side of that"
            )
        ahead = math.copysign(1.0, across) * ahead
    span = np.array([-ahead[1], ahead[0]])
    shape = _in_axes(shape, point, span, ahead)
    axes = ((float(ahead[0]), float(ahead[1]), 0.0), (float(span[0]), float(span[1]), 0.0), (0.0, 0.0, 1.0))
    return Wing((float(point[0]), float(point[1]), height), axes, _strips(shape, count))


def _shape(mechanism: Mechanism, body: str, outline: Corners | None) -> tuple[BaseGeometry, float]:
    """The wing from above, m, as drawn, and the height of its middle plane, m."""
    record = next((b for b in mechanism.bodies if b.name == body), None)
    if record is None:
        known = ", ".join(sorted(b.name for b in mechanism.bodies))
        raise DesignError(f"no body is named {body!r}; the bodies are {known}")
    if outline is not None:
        return Polygon(outline), float(record.com[2])
    if not record.outline:
        raise DesignError(
            f"body {body!r} has no outline to be a wing: give the corners of the wing as outline"
        )
    low = min(plate.z_bottom for plate in record.outline)
    high = max(plate.z_top for plate in record.outline)
    return shapely.union_all([plate.polygon for plate in record.outline]), 0.5 * (low + high)


def _line(mechanism: Mechanism, body: str, line: Corners | None) -> tuple[Array, Array]:
    """A point of the line, m, and its direction; x and y as drawn."""
    if line is not None:
        first, second = np.array(line)
        return first, (second - first) / np.linalg.norm(second - first)
    joints = [joint for joint in mechanism.joints if body in (joint.parent, joint.child)]
    if len(joints) != 1:
        raise DesignError(
            f"body {body!r} has {len(joints)} hinges, so that it is open which one the wing pitches about: give two "
            "points of the line that it pitches about as line"
        )
    axis = joints[0].axis
    if abs(axis[2]) > IN_PLANE:
        raise DesignError(
            f"the hinge {joints[0].name!r} of the wing {body!r} does not lie in the drawing's plane: give two "
            "points of the line that the wing pitches about as line"
        )
    return np.array(joints[0].point[:2]), axis[:2] / np.linalg.norm(axis[:2])


def _smaller_side(shape: BaseGeometry, point: Array, ahead: Array, body: str) -> Array:
    """`ahead` or its opposite, whichever has less of the wing."""
    rotated = _in_axes(shape, point, np.array([-ahead[1], ahead[0]]), ahead)
    low, back, high, front = rotated.bounds
    fore = rotated.intersection(shapely.box(low, 0.0, high, max(front, 0.0))).area
    aft = rotated.intersection(shapely.box(low, min(back, 0.0), high, 0.0)).area
    if abs(fore - aft) <= SIDES_ALIKE * rotated.area:
        raise DesignError(
            f"the line that the wing {body!r} pitches about halves it, so that no edge is the leading one: give the "
            "direction towards it as leading"
        )
    return ahead if fore < aft else -ahead


def _in_axes(shape: BaseGeometry, point: Array, span: Array, ahead: Array) -> BaseGeometry:
    """The outline with x along the span and y towards the leading edge, from the point."""
    shift = [-float(span @ point), -float(ahead @ point)]
    return affine_transform(shape, [*map(float, span), *map(float, ahead), *shift])


def _strips(shape: BaseGeometry, count: int) -> tuple[Strip, ...]:
    """Strips at Gauss-Legendre points: what a strip feels is a polynomial of its place along the span times a power of
    the chord, for which n such points are exact up to degree 2 n - 1. n equal strips err by 1 / n² even in the r² of a
    rectangular wing that revolves."""
    low, back, high, front = shape.bounds
    strips = []
    for place, weight in zip(*gauss(count), strict=True):
        along = 0.5 * (low + high) + 0.5 * (high - low) * place
        cut = shape.intersection(LineString([(along, back - 1.0), (along, front + 1.0)]))
        if not cut.is_empty and cut.bounds[3] > cut.bounds[1]:
            _, rear, _, fore = cut.bounds
            strips.append(Strip(along, 0.5 * (high - low) * weight, fore, fore - rear))
    return tuple(strips)


def gauss(count: int) -> tuple[Sequence[float], Sequence[float]]:
    """Points and weights of Gauss and Legendre's rule on (-1, 1)."""
    places, weights = np.polynomial.legendre.leggauss(count)
    return [float(x) for x in places], [float(w) for w in weights]
