"""The check of simulators whose fixed bodies move: accelerations, energies and poses of the C against other voices.

In: a compiled simulator. Out: a report. States are random ones and those along a run. The motion itself is not
integrated a second time.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from lamc.reference.check_motion import Progress
from lamc.reference.check_report import Comparison, Largest, Report
from lamc.reference.closing import WELL_CONDITIONED, State, random_states
from lamc.reference.constrained import split
from lamc.reference.interpreter import Interpreter
from lamc.reference.loads import told_apart
from lamc.reference.moving_base import MOVING, MovingNewtonEuler
from lamc.reference.newton_euler import NewtonEuler

Array = npt.NDArray[np.float64]

# The interpreter solves M u̇ = f by another library than the C: round-off times the condition of the mass matrix.
SOLVED, INDEPENDENT = 1e-10, 1e-10
ROWS = 21
_SOLVED = "same equations, two solvers of M u̇ = f; round-off times the condition of the mass matrix"
_OTHER = "other operations altogether; round-off times the condition of the mass matrix"


def check_moving(simulator: Any, states: int, t_end: float, seed: int, tell: Progress) -> Report:
    """Compares the voices at `states` random states and along a run of `t_end` seconds."""
    program = simulator.program
    interpreter = Interpreter(program)
    constants = interpreter.constants()
    movers = tuple(effect for effect in simulator.effects if effect.name in MOVING)
    known, unknown = told_apart(e for e in simulator.effects if e.name not in MOVING)
    voice = MovingNewtonEuler(simulator.mechanism, (*movers, *known), program.joints)
    notes = ["the base moves: the motion is not integrated a second time, its accelerations are compared"]
    if unknown:
        notes.append(
            f"the independent voices do not know {unknown}; accelerations and energies are compared between the C and "
            "the interpreter only"
        )
    tell("run the C", 0.0)
    result = simulator.run(t_end, rtol=1e-10, atol=1e-12, t_eval=np.linspace(0.0, t_end, ROWS))
    along = [(float(t), q, u) for t, q, u in zip(result.t, result.q, result.u, strict=True)]
    random = _random(simulator, voice, along[0], states, t_end, seed)
    if len(random) < states:
        notes.append(f"{len(random)} of {states} random states close all loops away from singular positions")
    comparisons: list[Comparison] = []
    for title, rows in (
        ("random states", random),
        ("states of the run", _regular(voice, along)),
    ):
        tell(f"compare {title}", 0.5)
        names = tuple(rate.name for rate in program.rates)
        read, other = Largest(names, ("C", "interpreter")), Largest(names, ("C", "Newton-Euler"))
        for k, (t, q, u) in enumerate(rows):
            where, found = f"state {k}, t = {t:.3g} s", simulator.acceleration(q, u, t)
            read.add(found, interpreter.acceleration(t, q, u, constants), where, 1.0)
            if not unknown:
                other.add(found, voice.acceleration(q, u, t), where, 1.0)
        comparisons.append(read.comparison(f"accelerations, {title}", SOLVED, _SOLVED))
        if not unknown:
            comparisons.append(other.comparison(f"accelerations, {title}", INDEPENDENT, _OTHER))
    comparisons += _energies_and_poses(interpreter, constants, voice, result, bool(unknown))
    return Report(program.name, tuple(comparisons), tuple(notes))


def _random(
    simulator: Any, voice: MovingNewtonEuler, start: State, count: int, t_end: float, seed: int
) -> list[State]:
    """Joints at random, closed where there are loops, with any pose and motion of a floating base, at any time."""
    still = NewtonEuler(simulator.mechanism, (), voice.joints)
    rng = np.random.default_rng(seed)
    n, (_, q0, u0) = len(voice.joints), start
    found: list[State] = []
    for t, angles, rates in random_states(still, q0[:n], count, t_end, seed):
        pose, motion = rng.normal(size=len(q0) - n), rng.uniform(-3.0, 3.0, len(u0) - n)
        found.append((t, np.append(angles, pose), np.append(rates, motion)))
    return found


def _regular(voice: MovingNewtonEuler, along: Sequence[State]) -> list[State]:
    """States where the closure determines the accelerations well."""
    if not voice.cuts:
        return list(along)
    parts = [split(voice.gaps(q)) for _, q, _ in along]
    full = max(p.rank for p in parts)
    return [
        state
        for state, p in zip(along, parts, strict=True)
        if p.rank == full and p.condition <= WELL_CONDITIONED
    ]


def _energies_and_poses(
    interpreter: Interpreter, constants: Array, voice: MovingNewtonEuler, result: Any, is_partial: bool
) -> list[Comparison]:
    names, both = interpreter.program.energies, ("C", "Newton-Euler")
    total = Largest(("total",), ("C", "interpreter") if is_partial else both)
    parts = Largest(names, ("interpreter", "Newton-Euler"))
    centres, turns = Largest(voice.bodies, both), Largest(voice.bodies, both)
    poses = {body: result.pose(body) for body in voice.bodies}
    for k, t in enumerate(result.t.tolist()):
        where, q, u = f"t = {t:.3g} s", result.q[k], result.u[k]
        ours = interpreter.energy(t, q, u, constants)
        size = float(np.abs(ours).sum())
        expected = float(ours.sum())
        if not is_partial:
            theirs = voice.energy(q, u, t)
            parts.add(ours, np.array([theirs.get(name, 0.0) for name in names]), where, size)
            expected = sum(theirs.values())
        total.add(np.array([result.energy[k]]), np.array([expected]), where, size)
        centre, rotation = voice.poses(q, t)
        centres.add(np.array([poses[b][0][k] for b in voice.bodies]), centre, where)
        turns.add(np.array([poses[b][1][k] for b in voice.bodies]), rotation, where)
    return [
        *([] if is_partial else [parts.comparison("energies by effect", INDEPENDENT, _OTHER)]),
        total.comparison("energy", INDEPENDENT, _OTHER),
        centres.comparison("centres of mass", INDEPENDENT, _OTHER),
        turns.comparison("rotations", INDEPENDENT, _OTHER),
    ]
