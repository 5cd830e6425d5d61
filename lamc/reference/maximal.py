"""Maximal coordinates: every body with six degrees of freedom, hinges held by multipliers. Numbers only.

A state goes in, joint accelerations come out of M a = F + Jᵀ λ under J a + bias = 0 for the accelerations a of the
bodies. All hinges are alike, those that close loops too, and their equations may be redundant. The kinematics at the
state are shared with the Newton-Euler cross-check; the dynamics are not: no recursion, no mass matrix in joint angles.
Small mechanisms, for tests and `check`.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from lamc.records.mechanism import Joint, Mechanism
from lamc.reference.closure import Closure, perpendicular
from lamc.reference.constrained import constrained
from lamc.reference.kinematics import Array, TreeState, cross, motion, skew, walk
from lamc.reference.loads import rigid_loads


@dataclass(frozen=True)
class _Hinge:
    """A joint between two bodies of the walk (-1: the world). axis_sign: the inner to outer sense is the joint's
    parent to child (+1) or the other way."""

    joint: Joint
    outer: int
    inner: int
    axis_sign: float


class MaximalCoordinates:
    """Equations of motion with multipliers; arguments and errors as `NewtonEuler`."""

    def __init__(
        self, mechanism: Mechanism, effects: Iterable[Any], joints: Sequence[str] | None = None
    ) -> None:
        self.joints = tuple(j.name for j in mechanism.joints) if joints is None else tuple(joints)
        self.links = walk(mechanism, self.joints)
        self._size, cuts = mechanism.size, Closure(mechanism, self.links, self.joints).hinges
        hinges = {
            link.coordinate: _Hinge(link.joint, i, link.inner, link.sign) for i, link in enumerate(self.links)
        }
        hinges |= {cut.coordinate: _Hinge(cut.joint, cut.child, cut.parent, 1.0) for cut in cuts}
        self._hinges = [hinges[k] for k in range(len(self.joints))]
        self._loads = rigid_loads(mechanism, effects, self.joints)

    def acceleration(self, q: Array, u: Array, t: float = 0.0) -> Array:
        """du/dt, shape (n,), rad/s²; q rad, u rad/s, shape (n,); t s."""
        q, u = np.asarray(q, dtype=np.float64), np.asarray(u, dtype=np.float64)
        state = motion(self.links, q, u)
        mass, force = self._bodies(t, state, self._loads.hinge_torques(t, q, u))
        jacobian, bias = self._constraints(state)
        # Turns times the size beside displacements, m: equations and unknowns are then of one unit.
        scale = np.tile([1.0, 1.0, 1.0, *(3 * [1.0 / self._size])], len(self.links))
        found = constrained(mass * np.outer(scale, scale), scale * force, scale * jacobian, bias)
        solution = scale * found
        return np.array([self._opening(hinge, state, solution) for hinge in self._hinges])

    def _opening(self, hinge: _Hinge, state: TreeState, solution: Array) -> Array:
        """Acceleration of a joint, rad/s², from those of the bodies: the rest of the difference of the two spin rates
        is across the axis."""
        spin_rate = np.zeros(3)
        for place, sign in ((hinge.outer, 1.0), (hinge.inner, -1.0)):
            if place >= 0:
                spin_rate = spin_rate + sign * solution[6 * place + 3 : 6 * place + 6]
        return self._axis(hinge, state) @ spin_rate

    def _axis(self, hinge: _Hinge, state: TreeState) -> Array:
        """The joint's axis in the world, from the inner to the outer body."""
        drawn = hinge.axis_sign * hinge.joint.axis
        return drawn if hinge.inner < 0 else state.rotation[hinge.inner] @ drawn

    def _bodies(self, t: float, state: TreeState, torques: Array) -> tuple[Array, Array]:
        """Mass matrix (6n, 6n) and applied plus gyroscopic forces (6n,), per body force then moment."""
        n = len(self.links)
        mass, force = np.zeros((6 * n, 6 * n)), np.zeros(6 * n)
        pulls, moments = self._loads.point_wrenches(t, self.links, state)
        for i, link in enumerate(self.links):
            a, b, c = 6 * i, 6 * i + 3, 6 * i + 6
            inertia = state.rotation[i] @ link.body.inertia @ state.rotation[i].T
            mass[a:b, a:b] = link.body.mass * np.eye(3)
            mass[b:c, b:c] = inertia
            force[a:b] = link.body.mass * self._loads.gravity + pulls[i]
            force[b:c] = moments[i] - cross(state.spin[i], inertia @ state.spin[i])
        for hinge, torque in zip(self._hinges, torques, strict=True):
            moment = torque * self._axis(hinge, state)
            for place, sign in ((hinge.outer, 1.0), (hinge.inner, -1.0)):
                if place >= 0:
                    force[6 * place + 3 : 6 * place + 6] += sign * moment
        return mass, force

    def _constraints(self, state: TreeState) -> tuple[Array, Array]:
        """Hinge constraints on accelerations, J a + bias = 0: J (5h, 6n) and bias (5h,).

        Per hinge three rows, m/s², keep its two points together, and two, rad/s² times the size, keep the relative
        spin along the axis.
        """
        size = self._size
        h, n = len(self._hinges), len(self.links)
        jacobian, bias = np.zeros((5 * h, 6 * n)), np.zeros(5 * h)
        for k, hinge in enumerate(self._hinges):
            across = perpendicular(self._axis(hinge, state))
            rows = slice(5 * k, 5 * k + 5)
            spins = [np.zeros(3), np.zeros(3)]
            for which, (body, side) in enumerate(((hinge.outer, 1.0), (hinge.inner, -1.0))):
                if body < 0:
                    continue
                arm = state.rotation[body] @ (hinge.joint.point - self.links[body].body.com)
                spins[which] = state.spin[body]
                jacobian[rows, 6 * body : 6 * body + 6] = side * np.block(
                    [[np.eye(3), -skew(arm)], [np.zeros((2, 3)), size * across]]
                )
                bias[5 * k : 5 * k + 3] += side * cross(state.spin[body], cross(state.spin[body], arm))
            relative = spins[0] - spins[1]
            bias[5 * k + 3 : 5 * k + 5] = [size * (cross(spins[1], e) @ relative) for e in across]
        return jacobian, bias
