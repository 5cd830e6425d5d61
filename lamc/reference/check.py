"""Compares the three voices: a compiled simulator in, a report of the largest differences out.

The voices are the generated C, the same Program interpreted in Python, and Newton-Euler on the Mechanism
(with maximal coordinates beside it). Each comparison has a limit and a reason; nothing is printed here.
"""

from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from lamc.codegen.program import Program
from lamc.errors import UnsupportedError
from lamc.mechanism.records import Mechanism
from lamc.reference.integrate import Acceleration, simulate
from lamc.reference.interpreter import Interpreter
from lamc.reference.maximal import MaximalCoordinates
from lamc.reference.newton_euler import NewtonEuler

Array = npt.NDArray[np.float64]

SAME_PROGRAM = 1e-12
INDEPENDENT = 1e-10
MOTION = 1e-8
ROWS = 21  # times along the run that are compared
MAXIMAL_BODIES = 30  # dense systems of 11 n unknowns beyond this take seconds
EVALUATIONS = 240_000  # of the Newton-Euler voice for one run, times the number of bodies and a few
STATEMENTS = 4_000_000  # interpreted for one run

_SAME = "same operations in the same order; only a library function's last digit may differ"
_OTHER = "other operations altogether; round-off times the condition of the mass matrix"
_MOTION = "errors of two integrators, times what the motion itself makes of a small change of its start"


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


@dataclass(frozen=True)
class Comparison:
    """One quantity of two voices: the largest difference, relative to the largest value at that state.

    at      the joint, body or energy where it is; empty if there is no difference at all
    where   the state where it is
    """

    quantity: str
    voices: tuple[str, str]
    difference: float
    limit: float
    at: str
    where: str
    reason: str

    @property
    def passed(self) -> bool:
        """True within the limit; a NaN is a failure."""
        return self.difference <= self.limit


@dataclass(frozen=True)
class Report:
    """All comparisons of one mechanism."""

    name: str
    comparisons: tuple[Comparison, ...]
    notes: tuple[str, ...] = ()

    @property
    def passed(self) -> bool:
        return all(c.passed for c in self.comparisons)

    def to_dict(self) -> dict[str, Any]:
        """Plain data for JSON."""
        rows = [{**asdict(c), "voices": list(c.voices), "passed": c.passed} for c in self.comparisons]
        return {"name": self.name, "passed": self.passed, "comparisons": rows, "notes": list(self.notes)}

    def table(self) -> str:
        """The comparisons as aligned text, one line each."""
        head = ("quantity", "voices", "difference", "limit", "", "at", "where")
        rows = [
            (
                c.quantity,
                " / ".join(c.voices),
                f"{c.difference:.1e}",
                f"{c.limit:.0e}",
                "ok" if c.passed else "FAIL",
                c.at or "exact",
                c.where,
            )
            for c in self.comparisons
        ]
        widths = [max(len(row[k]) for row in (head, *rows)) for k in range(len(head))]
        lines = [
            "  ".join(cell.ljust(w) for cell, w in zip(row, widths, strict=True)).rstrip()
            for row in (head, *rows)
        ]
        return "\n".join([*lines, *self.notes])


class _Largest:
    """Keeps the largest relative difference of arrays and what it belongs to."""

    def __init__(self, names: Sequence[str]) -> None:
        self.names = names
        self.difference, self.at, self.where = 0.0, "", ""

    def add(self, found: Array, expected: Array, where: str, scale: float = 0.0) -> None:
        """Rows of both arrays belong to `names`; `scale`: the least size to divide by."""
        if expected.size == 0 or np.isnan(self.difference):
            return
        size = max(float(np.abs(expected).max()), scale)
        gaps = np.abs(found - expected).reshape(len(self.names), -1).max(axis=1)
        k = int(np.argmax(gaps))  # a NaN counts as the largest
        relative = float(gaps[k]) / size if gaps[k] != 0.0 and size > 0.0 else float(gaps[k])
        if not relative <= self.difference:
            self.difference, self.at, self.where = relative, self.names[k], where

    def comparison(self, quantity: str, voices: tuple[str, str], limit: float, reason: str) -> Comparison:
        return Comparison(quantity, voices, self.difference, limit, self.at, self.where, reason)


def check(simulator: Subject, states: int = 20, t_end: float = 1.0, seed: int = 0) -> Report:
    """Compares the voices at `states` random states and along a run of `t_end` seconds.

    Raises UnsupportedError where the independent voice does not know an effect or meets a loop.
    """
    program = simulator.program
    if program.cuts:
        raise UnsupportedError(
            f"joint {program.cuts[0]!r} closes a loop, and the independent voices know trees only; "
            "tests/test_loops.py holds loops against published answers"
        )
    joints = program.joints
    interpreter = Interpreter(program)
    constants = interpreter.constants()
    newton = NewtonEuler(simulator.mechanism, simulator.effects, joints)
    voices: dict[str, Acceleration] = {
        "C": simulator.acceleration,
        "interpreter": lambda q, u, t: interpreter.acceleration(t, q, u, constants),
        "Newton-Euler": newton.acceleration,
    }
    if len(joints) <= MAXIMAL_BODIES:
        maximal = MaximalCoordinates(simulator.mechanism, simulator.effects, joints)
        voices["maximal"] = maximal.acceleration
    result = simulator.run(t_end, rtol=1e-10, atol=1e-12, t_eval=np.linspace(0.0, t_end, ROWS))
    random = _random_states(newton, len(joints), states, t_end, seed)
    along = list(zip(result.t.tolist(), result.q, result.u, strict=True))
    typical = float(
        np.median([np.abs(newton.acceleration(q, u, t)).max(initial=0.0) for t, q, u in random] or [0])
    )
    comparisons = _accelerations(voices, joints, random, "random states", typical)
    comparisons += _accelerations(voices, joints, along, "states of the run", typical)
    comparisons += _energies_and_poses(interpreter, constants, newton, result)
    motion, notes = _motions(voices, joints, result, program)
    return Report(program.name, (*comparisons, *motion), tuple(notes))


def _random_states(
    voice: NewtonEuler, n: int, count: int, t_end: float, seed: int
) -> list[tuple[float, Array, Array]]:
    """(t, q, u) with angles within ±π and rates large enough for forces of motion to matter."""
    rng = np.random.default_rng(seed)
    states = []
    for _ in range(count):
        t, q = float(rng.uniform(0.0, t_end)), rng.uniform(-np.pi, np.pi, n)
        pace = max(1.0, float(np.sqrt(np.abs(voice.acceleration(q, np.zeros(n), t)).max(initial=0.0))))
        states.append((t, q, rng.uniform(-pace, pace, n)))
    return states


def _accelerations(
    voices: dict[str, Acceleration],
    joints: Sequence[str],
    states: Iterable[tuple[float, Array, Array]],
    title: str,
    typical: float,
) -> list[Comparison]:
    """`typical`, rad/s²: where the mechanism nearly rests, accelerations are left-overs of such terms."""
    pairs = [("C", "interpreter", SAME_PROGRAM, _SAME), ("C", "Newton-Euler", INDEPENDENT, _OTHER)]
    if "maximal" in voices:
        pairs.append(("C", "maximal", INDEPENDENT, _OTHER))
    largest = {pair: _Largest(joints) for pair in pairs}
    for k, (t, q, u) in enumerate(states):
        values = {name: np.asarray(voice(q, u, t)) for name, voice in voices.items()}
        for pair in pairs:
            largest[pair].add(values[pair[0]], values[pair[1]], f"state {k}, t = {t:.3g} s", typical)
    return [largest[pair].comparison(f"accelerations, {title}", pair[:2], pair[2], pair[3]) for pair in pairs]


def _energies_and_poses(
    interpreter: Interpreter, constants: Array, newton: NewtonEuler, result: Any
) -> list[Comparison]:
    """Energies and poses of the C along its run against both other voices."""
    names = interpreter.program.energies
    split, total = _Largest(names), _Largest(("total",))
    centres, turns = _Largest(newton.bodies), _Largest(newton.bodies)
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
        split.comparison("energies by effect", ("interpreter", "Newton-Euler"), INDEPENDENT, _OTHER),
        total.comparison("energy", ("C", "Newton-Euler"), INDEPENDENT, _OTHER),
        centres.comparison("centres of mass", ("C", "Newton-Euler"), INDEPENDENT, _OTHER),
        turns.comparison("rotations", ("C", "Newton-Euler"), INDEPENDENT, _OTHER),
    ]


def _motions(
    voices: dict[str, Acceleration], joints: Sequence[str], result: Any, program: Program
) -> tuple[list[Comparison], list[str]]:
    """Angles of the C's run against scipy's DOP853 on the other voices."""
    start = np.concatenate([result.q[0], result.u[0]])
    statements = max(1, len(program.functions["acceleration"].statements))
    own_budget = EVALUATIONS // (len(joints) + 15)
    budgets = {"Newton-Euler": own_budget, "interpreter": min(own_budget, STATEMENTS // statements)}
    nudge = 1e-8  # rad: far above the integrators' errors, far below what is not linear
    plain, nudged = (
        simulate(voices["Newton-Euler"], s, joints, result.t, 1e-11, 1e-13, "DOP853", own_budget)
        for s in (start, start + np.repeat([nudge, 0.0], len(joints)))
    )
    comparisons: list[Comparison] = []
    notes = [] if result.success else [f"the run of the C did not reach its end: {result.message}"]
    for name, budget in budgets.items():
        run = plain
        if name != "Newton-Euler":
            run = simulate(voices[name], start, joints, result.t, 1e-11, 1e-13, "DOP853", budget)
        rows = min(len(run.t), len(nudged.t), len(result.t))
        growth = float(np.abs(nudged.q[:rows] - plain.q[:rows]).max(initial=nudge)) / nudge
        largest = _Largest(joints)
        for k in range(rows):
            largest.add(result.q[k], run.q[k], f"t = {run.t[k]:.3g} s", scale=1.0)
        comparisons.append(largest.comparison("angles of the run", ("C", name), MOTION * growth, _MOTION))
        if rows < len(result.t):
            reached = run.t[rows - 1] if rows else 0.0
            notes.append(
                f"the run of the voice {name} was compared up to t = {reached:.3g} s only: it is slow"
            )
    return comparisons, notes
