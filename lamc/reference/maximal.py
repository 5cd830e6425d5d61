"""Maximal coordinates: every body with six degrees of freedom, hinges held by multipliers. Numbers only.

A state goes in, joint accelerations come out of one dense symmetric system (mass matrix bordered by the
constraint Jacobian). The kinematics at the state are shared with the Newton-Euler voice; the dynamics are
not: no recursion, no mass matrix in joint angles. Small trees, for tests and `check`.
"""

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from lamc.mechanism.records import Mechanism
from lamc.reference.kinematics import Array, Motion, cross, motion, skew, walk
from lamc.reference.loads import numeric_loads


class MaximalCoordinates:
    """Equations of motion with multipliers; arguments and errors as `NewtonEuler`."""

    def __init__(
        self, mechanism: Mechanism, effects: Iterable[Any], joints: Sequence[str] | None = None
    ) -> None:
        self.joints = tuple(j.name for j in mechanism.joints) if joints is None else tuple(joints)
        self.links = walk(mechanism, self.joints)
        self._loads = numeric_loads(mechanism, effects, self.joints)

    def acceleration(self, q: Array, u: Array, t: float = 0.0) -> Array:
        """du/dt, shape (n,), rad/s²; q rad, u rad/s, shape (n,); t s."""
        q, u = np.asarray(q, dtype=np.float64), np.asarray(u, dtype=np.float64)
        n = len(self.links)
        state = motion(self.links, q, u)
        mass, force = self._bodies(state, self._loads.hinge_torques(t, q, u))
        jacobian, bias = self._constraints(state)
        system = np.block([[mass, jacobian.T], [jacobian, np.zeros((5 * n, 5 * n))]])
        # Rows and columns scaled to like size: forces in N beside torques in N·m cost digits otherwise.
        scale = 1.0 / np.sqrt(np.abs(system).max(axis=1))
        solution = scale * np.linalg.solve(system * np.outer(scale, scale), scale * np.append(force, -bias))
        result = np.empty(n)
        for i, link in enumerate(self.links):
            spin_rate = solution[6 * i + 3 : 6 * i + 6]
            if link.inner >= 0:
                spin_rate = spin_rate - solution[6 * link.inner + 3 : 6 * link.inner + 6]
            result[link.coordinate] = state.axis[i] @ spin_rate
        return result

    def _bodies(self, state: Motion, torques: Array) -> tuple[Array, Array]:
        """Mass matrix (6n, 6n) and applied plus gyroscopic forces (6n,), per body force then moment."""
        n = len(self.links)
        mass, force = np.zeros((6 * n, 6 * n)), np.zeros(6 * n)
        for i, link in enumerate(self.links):
            a, b, c = 6 * i, 6 * i + 3, 6 * i + 6
            inertia = state.rotation[i] @ link.body.inertia @ state.rotation[i].T
            mass[a:b, a:b] = link.body.mass * np.eye(3)
            mass[b:c, b:c] = inertia
            force[a:b] = link.body.mass * self._loads.gravity
            moment = torques[link.coordinate] * state.axis[i]
            force[b:c] += moment - cross(state.spin[i], inertia @ state.spin[i])
            if link.inner >= 0:
                force[6 * link.inner + 3 : 6 * link.inner + 6] -= moment
        return mass, force

    def _constraints(self, state: Motion) -> tuple[Array, Array]:
        """Hinge constraints on accelerations, J a + bias = 0: J (5n, 6n) and bias (5n,).

        Per hinge three rows keep its two points together, and two keep the relative spin along the axis.
        """
        n = len(self.links)
        jacobian, bias = np.zeros((5 * n, 6 * n)), np.zeros(5 * n)
        for i, link in enumerate(self.links):
            p = link.inner
            across = _perpendicular(state.axis[i])
            rows = slice(5 * i, 5 * i + 5)
            for body, side in ((i, 1.0), (p, -1.0)):
                if body < 0:
                    continue
                arm = state.point[i] - state.centre[body]
                jacobian[rows, 6 * body : 6 * body + 6] = side * np.block(
                    [[np.eye(3), -skew(arm)], [np.zeros((2, 3)), across]]
                )
                bias[5 * i : 5 * i + 3] += side * cross(state.spin[body], cross(state.spin[body], arm))
            if p >= 0:
                relative = state.spin[i] - state.spin[p]
                bias[5 * i + 3 : 5 * i + 5] = [cross(state.spin[p], e) @ relative for e in across]
        return jacobian, bias


def _perpendicular(axis: Array) -> Array:
    """Two unit vectors across `axis` and each other, shape (2, 3)."""
    helper = np.eye(3)[int(np.argmin(np.abs(axis)))]
    first = cross(axis, helper)
    first = first / np.linalg.norm(first)
    return np.array([first, cross(axis, first)])
