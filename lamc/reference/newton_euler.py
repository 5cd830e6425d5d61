"""Recursive Newton-Euler on the `Mechanism`: a state in, accelerations, energies and poses out. Numbers only.

The second voice: it shares no code with the symbolic derivation. The bias comes from one outward and one
inward pass in world axes (Luh, Walker and Paul 1980); the mass matrix from the Jacobians of the bodies, which
checks the recursion against a second road; the solve is numpy's. Trees only.
"""

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from lamc.mechanism.records import Mechanism
from lamc.reference.kinematics import Array, Motion, cross, motion, walk
from lamc.reference.loads import numeric_loads


class NewtonEuler:
    """Equations of motion of a tree of hinged bodies as numbers.

    mechanism   bodies and joints
    effects     what acts, as in `Scene.effects`
    joints      order of q and u; default: the order of `mechanism.joints`

    `bodies` names the moving bodies in the order of `poses`. Raises UnsupportedError for a loop or an effect
    that this voice does not know, TopologyError for a body with no path to the world.
    """

    def __init__(
        self, mechanism: Mechanism, effects: Iterable[Any], joints: Sequence[str] | None = None
    ) -> None:
        self.joints = tuple(j.name for j in mechanism.joints) if joints is None else tuple(joints)
        self.links = walk(mechanism, self.joints)
        self.bodies = tuple(link.body.name for link in self.links)
        self._loads = numeric_loads(mechanism, effects, self.joints)
        self._mass = np.array([link.body.mass for link in self.links])
        self._inertia_drawn = np.array([link.body.inertia for link in self.links]).reshape(-1, 3, 3)
        self._supports = self._support_mask()
        self._slot = np.array([link.coordinate for link in self.links], dtype=int)

    def acceleration(self, q: Array, u: Array, t: float = 0.0) -> Array:
        """du/dt, shape (n,), rad/s²; positive opens the fold. q rad, u rad/s, shape (n,); t s."""
        q, u = np.asarray(q, dtype=np.float64), np.asarray(u, dtype=np.float64)
        state = motion(self.links, q, u)
        torque = self._loads.hinge_torques(t, q, u)[self._slot]
        result = np.empty(len(self.links))
        result[self._slot] = np.linalg.solve(self._mass_matrix(state), torque - self._bias(state))
        return result

    def energy(self, q: Array, u: Array) -> dict[str, float]:
        """Energy by name, J: "kinetic" first, then what each effect stores."""
        q, u = np.asarray(q, dtype=np.float64), np.asarray(u, dtype=np.float64)
        state = motion(self.links, q, u)
        spin_drawn = np.einsum("bji,bj->bi", state.rotation, state.spin)
        kinetic = 0.5 * float(self._mass @ (state.velocity**2).sum(axis=1))
        kinetic += 0.5 * float(np.einsum("bi,bij,bj->", spin_drawn, self._inertia_drawn, spin_drawn))
        return {"kinetic": kinetic, **self._loads.stored(q, self._mass, state.centre)}

    def poses(self, q: Array) -> tuple[Array, Array]:
        """Centres of mass (m, 3), m, and rotations (m, 3, 3), drawn axes to world, by `bodies`."""
        state = motion(self.links, np.asarray(q, dtype=np.float64), np.zeros(len(self.links)))
        return state.centre, state.rotation

    def _support_mask(self) -> Array:
        """1.0 at [b, j] where link j lies on the way from the world to link b, itself included."""
        mask = np.eye(len(self.links))
        for i, link in enumerate(self.links):
            if link.inner >= 0:
                mask[i] += mask[link.inner]
        return mask

    def _inertia_world(self, state: Motion) -> Array:
        inertia: Array = state.rotation @ self._inertia_drawn @ state.rotation.transpose(0, 2, 1)
        return inertia

    def _mass_matrix(self, state: Motion) -> Array:
        arms = state.centre[:, None, :] - state.point[None, :, :]
        turning = self._supports[:, :, None] * state.axis[None, :, :]
        moving = cross(turning, arms)
        matrix: Array = np.einsum("b,bji,bki->jk", self._mass, moving, moving)
        matrix += np.einsum("bji,bil,bkl->jk", turning, self._inertia_world(state), turning, optimize=True)
        return matrix

    def _bias(self, state: Motion) -> Array:
        """Hinge torques that hold the joint accelerations at zero, gravity included, N·m."""
        momentum = np.einsum("bij,bj->bi", self._inertia_world(state), state.spin)
        force = self._mass[:, None] * (state.acceleration - self._loads.gravity)
        moment = np.einsum("bij,bj->bi", self._inertia_world(state), state.spin_rate)
        moment += cross(state.spin, momentum) + cross(state.centre - state.point, force)
        for i in range(len(self.links) - 1, -1, -1):
            p = self.links[i].inner
            if p >= 0:
                force[p] += force[i]
                moment[p] += moment[i] + cross(state.point[i] - state.point[p], force[i])
        bias: Array = np.einsum("bi,bi->b", state.axis, moment)
        return bias
