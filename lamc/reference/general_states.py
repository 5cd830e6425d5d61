"""Random states of mechanisms whose bases move, hinges yield and bodies bend, for comparisons. Numbers only.

In: the cross-check, which knows what there is, and a start. Out: states with forces of every kind of about one size, so
that none hides another; closed where joints close loops rigidly.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from lamc.records.mechanism import Mechanism
from lamc.reference.closing import CLOSED, WELL_CONDITIONED, State, random_states
from lamc.reference.constrained import split
from lamc.reference.kinematics import Array
from lamc.reference.lagrange import Lagrange
from lamc.reference.newton_euler import NewtonEuler

_ROUNDS = 20  # of Gauss-Newton, from small deflections


def general_states(
    cross_check: Lagrange, mechanism: Mechanism, start: State, count: int, t_end: float, seed: int
) -> list[State]:
    """Joints at random, closed where there are loops; deflections at which elastic forces are as large as weights; with
    any pose and motion of a floating base, at any time. They may be fewer than `count`."""
    n, (_, q0, u0) = len(cross_check.joints), start
    loose = replace(mechanism, joints=tuple(j for j in mechanism.joints if j.name not in cross_check.held))
    rng = np.random.default_rng(seed)
    most_q, most_u = cross_check.typical()
    own, held = cross_check.own, len(cross_check.held)
    found: list[State] = []
    # Where stiffness closes a loop, states that close it rigidly are near those that it is in, if there are any.
    closed = NewtonEuler(mechanism, (), (*cross_check.joints, *cross_check.held))
    rigid = [(closed, np.append(q0[:n], q0[own : own + held]))]
    rigid += [(NewtonEuler(loose, (), cross_check.joints), q0[:n])] if cross_check.held else []
    tries = (random_states(still, q, count, t_end, seed) for still, q in rigid)
    for t, angles, rates in next((states for states in tries if states), []):
        q = np.append(angles[:n], rng.uniform(-1.0, 1.0, own - n) * most_q[n:own])
        q = np.append(q, angles[n:] if len(angles) > n else np.zeros(held))
        u = np.append(rates[:n], rng.uniform(-1.0, 1.0, own - n) * most_u[n:own])
        pose, motion = rng.normal(size=len(q0) - own - held), rng.uniform(-3.0, 3.0, len(u0) - own)
        state = _closed(cross_check, t, np.append(q, pose), np.append(u, motion))
        if state is not None:
            found.append(state)
    return regular(cross_check, found)


def regular(cross_check: Lagrange, states: Sequence[State]) -> list[State]:
    """States where the closure determines the accelerations well."""
    if not cross_check.cuts:
        return list(states)
    parts = [split(cross_check.gaps(q)[1]) for _, q, _ in states]
    full = max((p.rank for p in parts), default=0)
    return [
        state
        for state, p in zip(states, parts, strict=True)
        if p.rank == full and p.condition <= WELL_CONDITIONED
    ]


def _closed(cross_check: Lagrange, t: float, q: Array, u: Array) -> State | None:
    """The state with its loops closed by the least change of coordinates; None where they do not close. A base moves no
    loop: its columns are nought."""
    if not cross_check.cuts:
        return t, q, u
    for _ in range(_ROUNDS):
        residual, jacobian = cross_check.gaps(q)
        if np.abs(residual).max() <= CLOSED * cross_check.size:
            free = split(jacobian).free
            return t, q, free @ (free.T @ u)
        q = q + np.append(split(jacobian).least(-residual), np.zeros(len(q) - len(u)))
    return None
