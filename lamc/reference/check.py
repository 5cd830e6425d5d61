"""Compares the three voices: a compiled simulator in, a report of the largest differences out.

The voices are the generated C, the same Program interpreted in Python, and Newton-Euler on the Mechanism
(with maximal coordinates beside it). Each comparison has a limit and a reason; nothing is printed here.
"""

import math
from collections.abc import Sequence
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from lamc.codegen.program import Program
from lamc.errors import UnsupportedError
from lamc.mechanism.records import Mechanism
from lamc.reference.check_motion import Budget, Progress, motions
from lamc.reference.check_report import Comparison, Largest, Report
from lamc.reference.integrate import Acceleration
from lamc.reference.interpreter import Interpreter
from lamc.reference.maximal import MaximalCoordinates
from lamc.reference.newton_euler import NewtonEuler

Array = npt.NDArray[np.float64]

SAME_PROGRAM = 1e-12
INDEPENDENT = 1e-10
ROWS = 21  # times along the run that are compared
MAXIMAL_BODIES = 30  # dense systems of 11 n unknowns beyond this take seconds
EVALUATIONS = 240_000  # of the Newton-Euler voice for one run, times the number of bodies and a few
STATEMENTS = 4_000_000  # interpreted for one run
SECONDS = 6.0  # for each of the three runs of other voices

_SAME = "same operations in the same order; only a library function's last digit may differ"
_OTHER = "other operations altogether; round-off times the condition of the mass matrix"


class Subject(Protocol):
    """What `check` needs of a simulator: `effects` are those that act, defaults resolved."""

    @property
    def mechanism(self) -> Mechanism: ...
    @property
    def program(self) -> Program: ...
    @property
    def effects(self) -> Sequence[Any]: ...
    def acceleration(self, q: Array, u: Array, t: float = 0.0) -> Array: ...
    def run(self, t_end: float, *, rtol: float, atol: float, t_eval: Array) -> Any: ...


def check(
    simulator: Subject,
    states: int = 20,
    t_end: float = 1.0,
    seed: int = 0,
    progress: Progress | None = None,
) -> Report:
    """Compares the voices at `states` random states and along a run of `t_end` seconds.

    `progress` is told the stage and how far it is. The runs of the other voices end after a few seconds each, and
    the report says how far they came. Raises UnsupportedError where the independent voice does not know an effect
    or meets a loop.
    """
    program = simulator.program
    if program.cuts:
        raise UnsupportedError(
            f"joint {program.cuts[0]!r} closes a loop, and the independent voices know trees only; "
            "tests/test_loops.py holds loops against published answers"
        )
    tell = progress or (lambda _stage, _fraction: None)
    joints = program.joints
    interpreter = Interpreter(program)
    constants = interpreter.constants()
    newton = NewtonEuler(simulator.mechanism, simulator.effects, joints)
    voices: dict[str, Acceleration] = {
        "C": simulator.acceleration,
        "interpreter": lambda q, u, t: interpreter.acceleration(t, q, u, constants),
        "Newton-Euler": newton.acceleration,
    }
    notes: list[str] = []
    if len(joints) <= MAXIMAL_BODIES:
        maximal = MaximalCoordinates(simulator.mechanism, simulator.effects, joints)
        voices["maximal"] = maximal.acceleration
    else:
        notes.append(
            f'the voice "maximal" is left out: {len(joints)} joints are above the {MAXIMAL_BODIES} it takes'
        )
    tell("run the C", 0.0)
    result = simulator.run(t_end, rtol=1e-10, atol=1e-12, t_eval=np.linspace(0.0, t_end, ROWS))
    random = _random_states(newton, len(joints), states, t_end, seed)
    along = list(zip(result.t.tolist(), result.q, result.u, strict=True))
    sizes = [np.abs(newton.acceleration(q, u, t)).max(initial=0.0) for t, q, u in random]
    typical = float(np.median([size for size in sizes if np.isfinite(size)] or [0.0]))
    comparisons = _accelerations(voices, joints, random, "random states", typical, tell)
    comparisons += _accelerations(voices, joints, along, "states of the run", typical, tell)
    comparisons += _energies_and_poses(interpreter, constants, newton, result)
    motion, missed = motions(voices, _budgets(program), joints, result, tell)
    comparisons += motion
    notes += missed
    return Report(program.name, tuple(comparisons), (*notes, *_not_finite(comparisons)))


def _not_finite(comparisons: Sequence[Comparison]) -> list[str]:
    """A line per quantity that is no number somewhere, whichever pairs of voices met it."""
    found: dict[tuple[str, str, str], set[str]] = {}
    for c in comparisons:
        if c.infinite:
            found.setdefault((c.quantity, c.at, c.where), set()).update(c.infinite)
    return [
        f"{quantity}: not finite at {where}, {at}, by {', '.join(sorted(voices))}; "
        "an effect has no value there"
        for (quantity, at, where), voices in found.items()
    ]


def _random_states(
    voice: NewtonEuler, n: int, count: int, t_end: float, seed: int
) -> list[tuple[float, Array, Array]]:
    """(t, q, u) with angles within ±π and rates large enough for forces of motion to matter."""
    rng = np.random.default_rng(seed)
    states = []
    for _ in range(count):
        t, q = float(rng.uniform(0.0, t_end)), rng.uniform(-np.pi, np.pi, n)
        size = float(np.abs(voice.acceleration(q, np.zeros(n), t)).max(initial=0.0))
        pace = max(1.0, math.sqrt(size)) if math.isfinite(size) else 1.0
        states.append((t, q, rng.uniform(-pace, pace, n)))
    return states


def _accelerations(
    voices: dict[str, Acceleration],
    joints: Sequence[str],
    states: Sequence[tuple[float, Array, Array]],
    title: str,
    typical: float,
    tell: Progress,
) -> list[Comparison]:
    """`typical`, rad/s²: where the mechanism nearly rests, accelerations are left-overs of such terms."""
    pairs = [("C", "interpreter", SAME_PROGRAM, _SAME), ("C", "Newton-Euler", INDEPENDENT, _OTHER)]
    if "maximal" in voices:
        pairs.append(("C", "maximal", INDEPENDENT, _OTHER))
    largest = {pair: Largest(joints, (pair[0], pair[1])) for pair in pairs}
    for k, (t, q, u) in enumerate(states):
        tell(f"compare {title}", k / len(states))
        values = {name: np.asarray(voice(q, u, t)) for name, voice in voices.items()}
        for pair in pairs:
            largest[pair].add(values[pair[0]], values[pair[1]], f"state {k}, t = {t:.3g} s", typical)
    return [largest[pair].comparison(f"accelerations, {title}", pair[2], pair[3]) for pair in pairs]


def _energies_and_poses(
    interpreter: Interpreter, constants: Array, newton: NewtonEuler, result: Any
) -> list[Comparison]:
    """Energies and poses of the C along its run against both other voices."""
    names = interpreter.program.energies
    both = ("C", "Newton-Euler")
    split, total = Largest(names, ("interpreter", "Newton-Euler")), Largest(("total",), both)
    centres, turns = Largest(newton.bodies, both), Largest(newton.bodies, both)
    poses = {body: result.pose(body) for body in newton.bodies}
    for k, t in enumerate(result.t.tolist()):
        where = f"t = {t:.3g} s"
        q, u = result.q[k], result.u[k]
        ours = interpreter.energy(t, q, u, constants)
        theirs = newton.energy(q, u)
        size = sum(abs(v) for v in theirs.values())
        split.add(ours, np.array([theirs.get(name, 0.0) for name in names]), where, size)
        total.add(np.array([result.energy[k]]), np.array([sum(theirs.values())]), where, size)
        centre, rotation = newton.poses(q)
        if newton.bodies:
            centres.add(np.array([poses[b][0][k] for b in newton.bodies]), centre, where)
            turns.add(np.array([poses[b][1][k] for b in newton.bodies]), rotation, where)
    return [
        split.comparison("energies by effect", INDEPENDENT, _OTHER),
        total.comparison("energy", INDEPENDENT, _OTHER),
        centres.comparison("centres of mass", INDEPENDENT, _OTHER),
        turns.comparison("rotations", INDEPENDENT, _OTHER),
    ]


def _budgets(program: Program) -> dict[str, Budget]:
    """Evaluations by the size of the mechanism and of the program, so that quick checks stay quick; and seconds."""
    statements = max(1, len(program.functions["acceleration"].statements))
    own = max(1, EVALUATIONS // (len(program.joints) + 15))
    read = max(1, min(own, STATEMENTS // statements))
    return {"Newton-Euler": Budget(own, SECONDS), "interpreter": Budget(read, SECONDS)}
