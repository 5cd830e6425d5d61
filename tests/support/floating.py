"""Mechanisms with fixed bodies that have mass, for tests of bases that move, and what numpy alone says of them."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from lamc.records.mechanism import Body, Joint, Mechanism
from lamc.reference.kinematics import motion, walk

Array = npt.NDArray[np.float64]

BASE_INERTIA = np.array([[0.30, 0.02, 0.01], [0.02, 0.40, -0.03], [0.01, -0.03, 0.50]])  # kg·m²


def with_base(
    mechanism: Mechanism,
    mass: float = 2.0,
    com: Sequence[float] = (0.1, -0.2, 0.3),
    inertia: Array = BASE_INERTIA,
) -> Mechanism:
    """`mechanism` whose fixed body has mass, kg, centre of mass, m, and inertia, kg·m²."""
    bodies = tuple(
        Body(b.name, mass, np.array(com), inertia, fixed=True) if b.fixed else b for b in mechanism.bodies
    )
    return replace(mechanism, bodies=bodies)


def lone_body(mass: float, inertia: Array) -> Mechanism:
    """One fixed body at the origin, to be let go, with a speck of dust hinged to it: a mechanism needs a hinge.

    The speck weighs 1e-12 of the body and is a sphere about its hinge, so that it feels nothing of a turning base.
    """
    speck = Body("speck", 1e-12 * mass, np.zeros(3), 1e-12 * np.eye(3) * np.trace(inertia))
    ground = Body("ground", mass, np.zeros(3), inertia, fixed=True)
    return Mechanism((ground, speck), (Joint("h", "ground", "speck"),), name="lone body")


def quaternion_matrix(quaternion: Array) -> Array:
    """World from body of (w, x, y, z), by v + 2 w (r × v) + 2 r × (r × v) of the unit quaternion."""
    w, *r = quaternion / np.linalg.norm(quaternion)
    columns = [v + 2.0 * w * np.cross(r, v) + 2.0 * np.cross(r, np.cross(r, v)) for v in np.eye(3)]
    return np.column_stack(columns)


def momenta(mechanism: Mechanism, joints: Sequence[str], q: Array, u: Array) -> tuple[Array, Array]:
    """Linear, kg·m/s, and angular momentum about the world's origin, kg·m²/s, of a mechanism on a floating base.

    q and u as the equations have them: joints, then the base. The bodies' motion relative to the base is that of
    lamc/reference/kinematics.py, which shares nothing with the derivation; the rest is vectors.
    """
    n = len(joints)
    links = walk(mechanism, joints)
    state = motion(links, q[:n], u[:n])
    base = next(body for body in mechanism.bodies if body.fixed)
    R, spin = quaternion_matrix(q[-4:]), u[-3:]
    bodies = [(base.mass, base.com, np.zeros(3), np.eye(3), np.zeros(3), base.inertia)]
    for i, link in enumerate(links):
        bodies.append(
            (
                link.body.mass,
                state.centre[i],
                state.velocity[i],
                state.rotation[i],
                state.spin[i],
                link.body.inertia,
            )
        )
    linear, angular = np.zeros(3), np.zeros(3)
    for mass, centre, velocity, rotation, turning, inertia in bodies:
        arm = centre - base.com
        place = q[-7:-4] + R @ arm
        v = u[-6:-3] + R @ (np.cross(spin, arm) + velocity)
        linear += mass * v
        own = R @ (rotation @ inertia @ rotation.T @ (spin + turning))
        angular += mass * np.cross(place, v) + own
    return linear, angular
