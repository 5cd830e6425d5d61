"""Newton and Euler for mechanisms whose fixed bodies move: freely, or as prescribed. Numbers only.

The second cross-check of floating and moved bases. The motion of the bodies relative to the base is that of
`kinematics.py`; the base's is put on top by the rules of relative motion. Forces and masses are projected by the
Jacobians of all bodies: no recursion, no frame of a link, and no fixed bodies taken together.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from lamc.records.mechanism import Joint, Mechanism
from lamc.reference.closure import Closure
from lamc.reference.constrained import constrained
from lamc.reference.jets import jet
from lamc.reference.kinematics import Array, Link, TreeState, cross, motion, rodrigues, skew, walk
from lamc.reference.loads import rigid_loads
from lamc.reference.point_loads import RigidBodyState

MOVING = ("free_base", "base_motion")


@dataclass(frozen=True)
class _Base:
    """Where the base is, and its velocities and, for unchanging rates, accelerations; world axes.

    reference  the drawn point, m, that is at `position`
    """

    reference: Array
    rotation: Array
    position: Array
    velocity: Array
    spin: Array
    acceleration: Array
    spin_rate: Array


class MovingNewtonEuler:
    """Equations of motion as numbers. States as the compiler has them: q is the joints' angles, then of a floating base
    position and quaternion; u their rates, then velocity, world axes, and angular velocity, axes of the base.

    `bodies` names the moving bodies in the order of `poses`: those of the walk, then the fixed ones. Raises
    UnsupportedError for an effect that this cross-check does not know.
    """

    def __init__(self, mechanism: Mechanism, effects: Iterable[Any], joints: Sequence[str]) -> None:
        effects = tuple(effects)
        self._mover = next(effect for effect in effects if effect.name in MOVING)
        self.floats = self._mover.name == "free_base"
        self.joints = tuple(joints)
        self.links = walk(mechanism, self.joints)
        fixed = [body for body in mechanism.bodies if body.fixed]
        if not self.floats:
            # What moves as prescribed needs no force for itself: its own mass is no part of the equations.
            fixed = [replace(body, mass=0.0, inertia=np.zeros((3, 3))) for body in fixed]
        nowhere = Joint("fixed", "a", "b")
        self._all = (*self.links, *(Link(body, nowhere, -1, 1.0, -1) for body in fixed))
        self.bodies = tuple(link.body.name for link in self._all)
        self.closure = Closure(mechanism, self.links, self.joints)
        self.cuts = self.closure.names
        others = [effect for effect in effects if effect.name not in MOVING]
        self._loads = rigid_loads(mechanism, others, self.joints, self.bodies)
        self._mass = np.array([link.body.mass for link in self._all])
        self._drawn = np.array([link.body.inertia for link in self._all]).reshape(-1, 3, 3)
        weights = [body.mass for body in fixed]
        self._reference = np.zeros(3)
        if self.floats:
            self._reference = np.average([body.com for body in fixed], axis=0, weights=weights)
        ways = np.eye(len(self.links))
        for i, link in enumerate(self.links):
            if link.inner >= 0:
                ways[i] += ways[link.inner]
        self._ways = np.vstack([ways, np.zeros((len(fixed), len(self.links)))])

    def acceleration(self, q: Array, u: Array, t: float = 0.0) -> Array:
        """du/dt, (nu,)."""
        n, base = len(self.joints), self._base(q, u, t)
        relative = motion(self.links, q[:n], u[:n])
        state = self._moved(relative, base)
        forces, moments = self._loads.point_wrenches(t, self._all, state)
        turning, moving = self._jacobians(state, base)
        inertia = state.rotation @ self._drawn @ state.rotation.transpose(0, 2, 1)
        mass = np.einsum("b,bki,bli->kl", self._mass, moving, moving)
        mass += np.einsum("bki,bij,blj->kl", turning, inertia, turning)
        gyration = cross(state.spin, np.einsum("bij,bj->bi", inertia, state.spin))
        forces = forces - self._mass[:, None] * (state.acceleration - self._loads.gravity)
        moments = moments - gyration - np.einsum("bij,bj->bi", inertia, state.spin_rate)
        force = np.einsum("bki,bi->k", moving, forces) + np.einsum("bki,bi->k", turning, moments)
        force[:n] += self._loads.hinge_torques(t, q[:n], u[:n])
        if not self.cuts:
            return np.asarray(np.linalg.solve(mass, force), dtype=np.float64)
        closed = self.closure.at(relative, q[:n])
        jacobian = np.pad(closed.jacobian(), ((0, 0), (0, len(u) - n)))
        return constrained(mass, force, jacobian, closed.bias())

    def energy(self, q: Array, u: Array, t: float = 0.0) -> dict[str, float]:
        """Energy by name, J, in the world's frame: "kinetic" first, then what each effect stores."""
        n = len(self.joints)
        relative = motion(self.links, q[:n], u[:n])
        state = self._moved(relative, self._base(q, u, t))
        spin = np.einsum("bji,bj->bi", state.rotation, state.spin)
        kinetic = 0.5 * float(self._mass @ (state.velocity**2).sum(axis=1))
        kinetic += 0.5 * float(np.einsum("bi,bij,bj->", spin, self._drawn, spin))
        place = RigidBodyState(self._all, state)
        return {"kinetic": kinetic, **self._loads.stored(t, q[:n], self._mass @ state.centre, place)}

    def gaps(self, q: Array) -> Array:
        """Jacobian of the loops by the joints' rates, (6 c, n), m/rad."""
        n = len(self.joints)
        return self.closure.at(motion(self.links, q[:n], np.zeros(n)), q[:n]).jacobian()

    def poses(self, q: Array, t: float = 0.0) -> tuple[Array, Array]:
        """Centres of mass (m, 3), m, and rotations (m, 3, 3), drawn axes to world, by `bodies`."""
        n = len(self.joints)
        nothing = np.zeros(n + (6 if self.floats else 0))
        state = self._moved(motion(self.links, q[:n], nothing[:n]), self._base(q, nothing, t))
        return state.centre, state.rotation

    def _base(self, q: Array, u: Array, t: float) -> _Base:
        if self.floats:
            w, *axis = q[-4:] / np.linalg.norm(q[-4:])
            turn = skew(np.array(axis))
            rotation = np.eye(3) + 2.0 * w * turn + 2.0 * turn @ turn
            still = np.zeros(3)
            return _Base(self._reference, rotation, q[-7:-4], u[-6:-3], rotation @ u[-3:], still, still)
        prescribed = self._mover
        axis, point = np.array(prescribed.axis) / np.linalg.norm(prescribed.axis), np.array(prescribed.point)
        shift, angle = [jet(x, t) for x in prescribed.displacement], jet(prescribed.angle, t)
        return _Base(
            reference=point,
            rotation=rodrigues(axis, angle.value),
            position=point + [x.value for x in shift],
            velocity=np.array([x.first for x in shift]),
            spin=angle.first * axis,
            acceleration=np.array([x.second for x in shift]),
            spin_rate=angle.second * axis,
        )

    def _moved(self, relative: TreeState, base: _Base) -> TreeState:
        """The motion of all bodies in the world, the fixed ones last."""
        fixed = [link.body.com for link in self._all[len(self.links) :]]
        count = len(fixed)

        def rows(values: Array, more: Array | None = None) -> Array:
            """Of the walk, then of the fixed bodies; world axes."""
            below = np.zeros((count, 3)) if more is None else more
            return np.vstack([values.reshape(-1, 3), below]) @ base.rotation.T

        arms = rows(relative.centre - base.reference, np.array(fixed) - base.reference)
        velocity, spin = rows(relative.velocity), rows(relative.spin)
        omega = np.broadcast_to(base.spin, arms.shape)
        alpha = np.broadcast_to(base.spin_rate, arms.shape)
        rotated = np.concatenate([relative.rotation, np.tile(np.eye(3), (count, 1, 1))])
        return TreeState(
            rotation=base.rotation @ rotated,
            centre=base.position + arms,
            point=base.position + rows(relative.point - base.reference),
            axis=rows(relative.axis),
            spin=omega + spin,
            velocity=base.velocity + cross(omega, arms) + velocity,
            spin_rate=alpha + rows(relative.spin_rate) + cross(omega, spin),
            acceleration=base.acceleration
            + cross(alpha, arms)
            + cross(omega, cross(omega, arms))
            + 2.0 * cross(omega, velocity)
            + rows(relative.acceleration),
        )

    def _jacobians(self, state: TreeState, base: _Base) -> tuple[Array, Array]:
        """Angular and linear velocities of all bodies by the rates, both (b, nu, 3), world axes."""
        n, count = len(self.links), len(self._all)
        slots = [link.coordinate for link in self.links]
        turning, placed = np.zeros((2, count, len(self.joints), 3))
        turning[:, slots] = self._ways[:, :, None] * state.axis[None, :n, :]
        placed[:, slots] = state.centre[:, None, :] - state.point[None, :n, :]
        moving = cross(turning, placed)
        if not self.floats:
            return turning, moving
        spins = np.broadcast_to(base.rotation.T, (count, 3, 3))
        from_base = np.broadcast_to((state.centre - base.position)[:, None, :], (count, 3, 3))
        along = np.broadcast_to(np.eye(3), (count, 3, 3))
        turning = np.concatenate([turning, np.zeros((count, 3, 3)), spins], axis=1)
        return turning, np.concatenate([moving, along, cross(spins, from_base)], axis=1)
