"""How far the hinge lines of a plate turn.

In: a solution. Out: rotation, moment and energy of each line, and the rotation at any of its points. Never: solves.

A rotation is positive where both sides rise from the line, a valley, and the spring's moment resists it: the plate's
own moment across the line, positive as its curvature, is -stiffness times the rotation.
"""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt
import shapely

from lamc.basics.checks import Array
from lamc.basics.errors import DesignError
from lamc.plates.hinge_lines import HingeLine
from lamc.plates.locator import points_at
from lamc.plates.solving.hinge_sides import hinge_sides

if TYPE_CHECKING:
    from lamc.plates.answers.solution import Solution


@dataclass(frozen=True, eq=False)
class HingeRotation:
    """Of one hinge line.

    points    (k, 2, 2), m: begin and end of each edge of the mesh on the line
    rotation  (k, 2), rad, there: positive for a valley
    energy    J, in the spring
    """

    hinge: HingeLine
    points: Array
    rotation: Array
    energy: float

    @property
    def moment(self) -> Array:
        """Of the spring per length of the line, N·m/m, shape (k, 2), against the rotation."""
        return np.asarray(self.hinge.stiffness * self.rotation)

    @property
    def length(self) -> float:
        """Of the line on the plate, m."""
        return float(np.linalg.norm(self.points[:, 1] - self.points[:, 0], axis=1).sum())

    @property
    def largest(self) -> float:
        """The rotation of the largest size, rad, with its sign."""
        return float(self.rotation.flat[np.argmax(np.abs(self.rotation))])


def hinge_rotations(solution: "Solution") -> tuple[HingeRotation, ...]:
    """Of all hinge lines of the problem, in their order."""
    problem = solution.problem
    if not problem.hinges:
        return ()
    sides = hinge_sides(problem.dofs)
    found = []
    for index, (hinge, edges) in enumerate(zip(problem.hinges, problem.hinge_edges, strict=True)):
        mine = np.searchsorted(problem.dofs.hinges, edges).astype(np.int32)
        ends = [sides.rotations(mine, np.full(len(mine), s)) @ solution.exact for s in (0.0, 1.0)]
        begin = sides.begin[mine]
        points = np.stack([begin, begin + sides.length[mine, None] * sides.along[mine]], axis=1)
        rotation = np.stack(ends, axis=1).astype(float)
        found.append(HingeRotation(hinge, points, rotation, solution.hinge_energy(index)))
    return tuple(found)


def rotation_at(solution: "Solution", x: npt.ArrayLike, y: npt.ArrayLike) -> Array:
    """Rotation at points on hinge lines, rad, shape of x and y; where lines meet, of one of them. Raises DesignError
    for a point on none."""
    problem = solution.problem
    if not problem.hinges:
        raise DesignError("the plate has no hinge lines, so nothing turns there; give Problem(…, hinges=[…])")
    points, shape = points_at(x, y)
    sides = hinge_sides(problem.dofs)
    lines = shapely.linestrings(
        np.stack([sides.begin, sides.begin + sides.length[:, None] * sides.along], axis=1)
    )
    places = shapely.points(points)
    nearest = shapely.STRtree(lines).nearest(places)
    distance = shapely.distance(lines[nearest], places)
    if len(distance) and distance.max() > problem.places.tolerance:
        k = int(np.argmax(distance))
        raise DesignError(
            f"the point ({points[k, 0]:.6g}, {points[k, 1]:.6g}) lies {distance[k]:.3g} m from the nearest hinge line; "
            "a rotation is of a point on one"
        )
    s = np.clip(shapely.line_locate_point(lines[nearest], places) / sides.length[nearest], 0.0, 1.0)
    rotated = sides.rotations(nearest.astype(np.int32), s) @ solution.exact
    return np.asarray(rotated, dtype=float).reshape(shape)
