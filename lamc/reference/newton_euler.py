"""Recursive Newton-Euler on the `Mechanism`: a state in, accelerations, energies and poses out. Numbers only.

The second cross-check: it shares no code with the symbolic derivation. The bias comes from one outward and one
inward pass in world axes (Luh, Walker and Paul 1980); the mass matrix from the Jacobians of the bodies, which
checks the recursion against a second road; the solve is numpy's. Joints outside the tree hold by equations.
"""

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from lamc.records.mechanism import Mechanism
from lamc.reference.closure import Closure, ClosureState
from lamc.reference.constrained import constrained, split
from lamc.reference.kinematics import Array, TreeState, cross, motion, walk
from lamc.reference.loads import rigid_loads
from lamc.reference.point_loads import RigidBodyState


class NewtonEuler:
    """Equations of motion of hinged bodies as numbers.

    mechanism   bodies and joints
    effects     what acts, as in `Scene.effects`
    joints      order of q and u: all joints. Default: their own order

    `bodies` names the moving bodies in the order of `poses`, `cuts` the joints that close loops as the walk goes.
    Accelerations are those of closed states. Raises UnsupportedError for an effect that this cross-check does not know,
    TopologyError for a body with no path to the world, DesignError for a joint left out.
    """

    def __init__(
        self, mechanism: Mechanism, effects: Iterable[Any], joints: Sequence[str] | None = None
    ) -> None:
        self.joints = tuple(j.name for j in mechanism.joints) if joints is None else tuple(joints)
        self.links = walk(mechanism, self.joints)
        self.bodies = tuple(link.body.name for link in self.links)
        self.closure = Closure(mechanism, self.links, self.joints)
        self.cuts = self.closure.names
        self.size = mechanism.size
        self._loads = rigid_loads(mechanism, effects, self.joints)
        self._mass = np.array([link.body.mass for link in self.links])
        self._inertia_drawn = np.array([link.body.inertia for link in self.links]).reshape(-1, 3, 3)
        self._supports = self._support_mask()
        self._slot = np.array([link.coordinate for link in self.links], dtype=int)

    def acceleration(self, q: Array, u: Array, t: float = 0.0) -> Array:
        """du/dt, shape (n,), rad/s²; positive opens the fold. q rad, u rad/s, shape (n,); t s."""
        q, u = np.asarray(q, dtype=np.float64), np.asarray(u, dtype=np.float64)
        state = motion(self.links, q, u)
        force = self._loads.hinge_torques(t, q, u)
        forces, moments = self._loads.point_wrenches(t, self.links, state)
        force[self._slot] -= self._bias(state, forces, moments)
        mass = np.zeros((len(q), len(q)))  # of joints that close loops: nought, as they move no body
        mass[np.ix_(self._slot, self._slot)] = self._mass_matrix(state)
        if not self.cuts:
            return np.asarray(np.linalg.solve(mass, force), dtype=np.float64)
        closed = self.closure.at(state, q)
        return constrained(mass, force, closed.jacobian(), closed.bias())

    def energy(self, q: Array, u: Array, t: float = 0.0) -> dict[str, float]:
        """Energy by name, J: "kinetic" first, then what each effect stores."""
        q, u = np.asarray(q, dtype=np.float64), np.asarray(u, dtype=np.float64)
        state = motion(self.links, q, u)
        spin_drawn = np.einsum("bji,bj->bi", state.rotation, state.spin)
        kinetic = 0.5 * float(self._mass @ (state.velocity**2).sum(axis=1))
        kinetic += 0.5 * float(np.einsum("bi,bij,bj->", spin_drawn, self._inertia_drawn, spin_drawn))
        place = RigidBodyState(self.links, state)
        return {"kinetic": kinetic, **self._loads.stored(t, q, self._mass @ state.centre, place)}

    def gaps(self, q: Array) -> tuple[Array, Array]:
        """Residuals φ (6 c,), m, of the joints that close loops, and their Jacobian (6 c, n), m/rad."""
        closed = self.closed(q)
        return closed.residual(), closed.jacobian()

    def closed(self, q: Array) -> ClosureState:
        """The joints that close loops, with the bodies at rest at angles q (n,)."""
        q = np.asarray(q, dtype=np.float64)
        return self.closure.at(self._still(q), q)

    def condition(self, q: Array) -> tuple[int, float]:
        """Rank of the closure at q, and how far its equations are from a smaller one: largest over least singular
        value."""
        parts = split(self.gaps(q)[1])
        return parts.rank, parts.condition

    def poses(self, q: Array) -> tuple[Array, Array]:
        """Centres of mass (m, 3), m, and rotations (m, 3, 3), drawn axes to world, by `bodies`."""
        state = self._still(q)
        return state.centre, state.rotation

    def _still(self, q: Array) -> TreeState:
        q = np.asarray(q, dtype=np.float64)
        return motion(self.links, q, np.zeros(len(q)))

    def _support_mask(self) -> Array:
        """1.0 at [b, j] where link j lies on the way from the world to link b, itself included."""
        mask = np.eye(len(self.links))
        for i, link in enumerate(self.links):
            if link.inner >= 0:
                mask[i] += mask[link.inner]
        return mask

    def _inertia_world(self, state: TreeState) -> Array:
        inertia: Array = state.rotation @ self._inertia_drawn @ state.rotation.transpose(0, 2, 1)
        return inertia

    def _mass_matrix(self, state: TreeState) -> Array:
        arms = state.centre[:, None, :] - state.point[None, :, :]
        turning = self._supports[:, :, None] * state.axis[None, :, :]
        moving = cross(turning, arms)
        momenta = turning @ self._inertia_world(state)
        matrix: Array = np.tensordot(self._mass[:, None, None] * moving, moving, axes=([0, 2], [0, 2]))
        matrix += np.tensordot(momenta, turning, axes=([0, 2], [0, 2]))
        return matrix

    def _bias(self, state: TreeState, forces: Array, moments: Array) -> Array:
        """Hinge torques that hold the joint accelerations at zero, N·m, under gravity and forces and moments about
        the centres of mass, (n, 3), N and N·m."""
        momentum = np.einsum("bij,bj->bi", self._inertia_world(state), state.spin)
        force = self._mass[:, None] * (state.acceleration - self._loads.gravity) - forces
        moment = np.einsum("bij,bj->bi", self._inertia_world(state), state.spin_rate) - moments
        moment += cross(state.spin, momentum) + cross(state.centre - state.point, force)
        for i in range(len(self.links) - 1, -1, -1):
            p = self.links[i].inner
            if p >= 0:
                force[p] += force[i]
                moment[p] += moment[i] + cross(state.point[i] - state.point[p], force[i])
        bias: Array = np.einsum("bi,bi->b", state.axis, moment)
        return bias
