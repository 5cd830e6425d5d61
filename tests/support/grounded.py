"""Blocks that move freely in the x-z plane, for tests of contact: a boom of two long hinges carries them.

Any position in the plane is one of the two hinges' angles, and the boom weighs a millionth of a millionth of the block,
so that the block moves as a free one does; poses say where it is.
"""

import numpy as np
from shapely.geometry import Polygon

from lamc import Body, Joint, Mechanism, Slab
from lamc.records.mechanism import Array
from lamc.run.result import Result

G = 9.81  # m/s²
UP, FORWARD = np.array([0.0, 0.0, 1.0]), np.array([1.0, 0.0, 0.0])
REACH = 5.0  # m, of either hinge of the boom
BOOM = 1e-12  # of the block's mass


def block(
    length: float, height: float, bottom: float = 0.0, depth: float = 0.04, mass: float = 0.05
) -> Mechanism:
    """A block, m and kg, with its corners as outline, whose lower face is drawn at z = bottom.

    Hinges: x and z move it along these axes at first, and "pitch" turns it about its centre, about y.
    """
    centre = np.array([0.0, 0.0, bottom + 0.5 * height])
    box = [
        [-length / 2, -depth / 2],
        [length / 2, -depth / 2],
        [length / 2, depth / 2],
        [-length / 2, depth / 2],
    ]
    inertia = mass / 12.0 * np.diag([depth**2 + height**2, length**2 + height**2, length**2 + depth**2])
    light = BOOM * mass * np.diag([height**2, height**2, height**2])
    bodies = (
        Body("world", fixed=True),
        Body("boom", BOOM * mass, centre, light),
        Body("arm", BOOM * mass, centre, light),
        Body("block", mass, centre, inertia, outline=(Slab(Polygon(box), bottom, bottom + height),)),
    )
    joints = (
        Joint("x", "world", "boom", centre - REACH * UP, (0.0, 1.0, 0.0)),
        Joint("z", "boom", "arm", centre + REACH * FORWARD, (0.0, 1.0, 0.0)),
        Joint("pitch", "arm", "block", centre, (0.0, 1.0, 0.0)),
    )
    return Mechanism(bodies, joints)


def velocities(result: Result, body: str = "block") -> Array:
    """Of the body's centre, (m, 3), m/s, by differences of its positions between rows."""
    centre, _ = result.pose(body)
    return np.gradient(centre, result.t, axis=0)


def pitch(result: Result, body: str = "block") -> Array:
    """Turn of the body about y, (m,), rad."""
    _, rotation = result.pose(body)
    return np.arctan2(rotation[:, 0, 2], rotation[:, 0, 0])
