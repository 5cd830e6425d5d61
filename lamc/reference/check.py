"""Compares the three cross-checks: a compiled simulator in, a report of the largest differences out.

The cross-checks are the generated C, the same Program interpreted in Python, and Newton-Euler on the Mechanism
(with maximal coordinates beside it). Each comparison has a limit and a reason; nothing is printed here.
"""

from collections.abc import Callable, Sequence
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from lamc.mechanics.arranging import arrange
from lamc.mechanism.plan import plan
from lamc.records.mechanism import Mechanism
from lamc.records.scene import Scene
from lamc.records.scene_values import left_to_model
from lamc.reference.check_general import check_general
from lamc.reference.check_loops import closures, kept_closed
from lamc.reference.check_motion import Budget, Progress, motions
from lamc.reference.check_report import Comparison, Largest, Report
from lamc.reference.closing import WELL_CONDITIONED, State, random_states
from lamc.reference.inputs import with_inputs
from lamc.reference.integrate import Acceleration
from lamc.reference.interpreter import Interpreter
from lamc.reference.loads import known_effects
from lamc.reference.maximal import MaximalCoordinates
from lamc.reference.newton_euler import NewtonEuler
from lamc.reference.series import following
from lamc.run.following import series_of
from lamc.symbolic.program import Program

Array = npt.NDArray[np.float64]

SAME_PROGRAM = 1e-12
INDEPENDENT = 1e-10
ROWS = 21  # times along the run that are compared
MAXIMAL_BODIES = 30  # joints; dense systems of 11 n unknowns beyond this take seconds
EVALUATIONS = 240_000  # of the Newton-Euler cross-check for one run, times the number of bodies and a few
STATEMENTS = 4_000_000  # interpreted for one run
SECONDS = 6.0  # for each of the three runs of other cross-checks

_SAME = "same operations in the same order; only a library function's last digit may differ"
_SOLVED = (
    "same equations, two solvers of the loops; round-off times the square of their condition, at most 1e4"
)
_OTHER = "other operations altogether; round-off times the condition of the mass matrix"


class Subject(Protocol):
    """What `check` needs of a simulator: `effects` are those that act, defaults resolved."""

    @property
    def mechanism(self) -> Mechanism: ...
    @property
    def scene(self) -> Scene: ...
    @property
    def program(self) -> Program: ...
    @property
    def effects(self) -> Sequence[Any]: ...
    def acceleration(self, q: Array, u: Array, t: float = 0.0) -> Array: ...
    def closure(self, q: Array) -> tuple[Array, Array]: ...
    def run(self, t_end: float, *, rtol: float, atol: float, t_eval: Array) -> Any: ...


def check(
    simulator: Subject,
    states: int = 20,
    t_end: float = 1.0,
    seed: int = 0,
    progress: Progress | None = None,
) -> Report:
    """Compares the cross-checks at `states` random states and along a run of `t_end` seconds.

    Random states of loops are closed. `progress` is told the stage and how far it is. The runs of the other
    cross-checks end after a few seconds each, and the report says how far they came. Effects that the independent
    cross-checks do not know are named in its notes, and only the C and the interpreter are then compared in what they
    act on.

    Where fixed bodies move, hinges yield, bodies bend or air goes with them, the run of the C is not repeated by other
    cross-checks.
    """
    program = simulator.program
    tell = progress or (lambda _stage, _fraction: None)
    tree = plan(simulator.mechanism)
    general = [effect.name for effect in simulator.effects if not arrange(tree, (effect,)).is_plain]
    if general:
        return check_general(simulator, general, states, t_end, seed, tell)
    joints = program.joints
    series = series_of(simulator.scene)
    interpreter = Interpreter(program, series)
    constants = interpreter.constants()
    inputs = {p.name: p.default for p in program.parameters if p.is_input}
    effects = with_inputs(simulator.mechanism, simulator.effects, inputs | dict.fromkeys(series, 0.0))
    unknown = known_effects(effects)[1]
    unknown = unknown or ", ".join(left_to_model(simulator.mechanism, simulator.scene))

    def voice(of: Callable[..., Any]) -> Any:
        return following(
            lambda effects: of(simulator.mechanism, known_effects(effects)[0], joints),
            simulator.mechanism,
            simulator.effects,
            inputs,
            series,
        )

    newton: NewtonEuler = voice(NewtonEuler)
    cross_checks: dict[str, Acceleration] = {
        "C": simulator.acceleration,
        "interpreter": lambda q, u, t: interpreter.acceleration(t, q, u, constants),
    }
    notes: list[str] = []
    if unknown:
        notes.append(
            f"the independent cross-checks do not know {unknown}; accelerations, energies and motion are compared "
            "between the C and the interpreter only"
        )
    else:
        cross_checks["Newton-Euler"] = newton.acceleration
        if len(simulator.mechanism.joints) <= MAXIMAL_BODIES:
            maximal = voice(MaximalCoordinates)
            cross_checks["maximal"] = maximal.acceleration
        else:
            notes.append(
                f'the cross-check "maximal" is left out: {len(simulator.mechanism.joints)} joints are above the '
                f"{MAXIMAL_BODIES} it takes"
            )
    tell("run the C", 0.0)
    result = simulator.run(t_end, rtol=1e-10, atol=1e-12, t_eval=np.linspace(0.0, t_end, ROWS))
    random = random_states(newton, result.q[0], states, t_end, seed)
    if len(random) < states:
        notes.append(f"{len(random)} of {states} random states close all loops away from singular positions")
    regular, singular = _regular(newton, result)
    if singular:
        notes.append(
            f"{singular} of {len(result.t)} states of the run are near a singular position, where accelerations are "
            "not compared"
        )
    sizes = [np.abs(cross_checks["interpreter"](q, u, t)).max(initial=0.0) for t, q, u in random]
    typical = float(np.median([size for size in sizes if np.isfinite(size)] or [0.0]))
    comparisons = _accelerations(cross_checks, newton, random, "random states", typical, tell)
    comparisons += _accelerations(cross_checks, newton, regular, "states of the run", typical, tell)
    comparisons += _energies_and_poses(interpreter, constants, newton, result, bool(unknown))
    if program.cuts:
        limits, reasons = (SAME_PROGRAM, INDEPENDENT), (_SAME, _OTHER)
        comparisons += closures(simulator, interpreter, constants, newton, random, limits, reasons)
        comparisons.append(kept_closed(newton, result))
    others = {name: budget for name, budget in _budgets(program).items() if name in cross_checks}
    if any(guard.mode < 0 for guard in program.guards):
        what = "clocks" if program.clocks else "impacts"
        notes.append(f"the motion is not compared: the other cross-checks' runs know no {what}")
    else:
        motion, missed = motions(cross_checks, others, newton, result, tell)
        comparisons += motion
        notes += missed
    return Report(program.name, tuple(comparisons), (*notes, *_not_finite(comparisons)))


def _regular(newton: NewtonEuler, result: Any) -> tuple[list[State], int]:
    """States of the run where the closure determines the accelerations well, and how many others there are."""
    along = list(zip(result.t.tolist(), result.q, result.u, strict=True))
    if not newton.cuts:
        return along, 0
    found = [newton.condition(q) for _, q, _ in along]
    full = max(rank for rank, _ in found)
    kept = [
        state
        for state, (rank, condition) in zip(along, found, strict=True)
        if rank == full and condition <= WELL_CONDITIONED
    ]
    return kept, len(along) - len(kept)


def _not_finite(comparisons: Sequence[Comparison]) -> list[str]:
    """A line per quantity that is no number somewhere, whichever pairs of cross-checks met it."""
    found: dict[tuple[str, str, str], set[str]] = {}
    for c in comparisons:
        if c.infinite:
            found.setdefault((c.quantity, c.at, c.where), set()).update(c.infinite)
    return [
        f"{quantity}: not finite at {where}, {at}, by {', '.join(sorted(cross_checks))}; "
        "an effect has no value there"
        for (quantity, at, where), cross_checks in found.items()
    ]


def _accelerations(
    cross_checks: dict[str, Acceleration],
    newton: NewtonEuler,
    states: Sequence[State],
    title: str,
    typical: float,
    tell: Progress,
) -> list[Comparison]:
    """`typical`, rad/s²: where the mechanism nearly rests, accelerations are left-overs of such terms."""
    same = (INDEPENDENT, _SOLVED) if newton.cuts else (SAME_PROGRAM, _SAME)
    pairs = [("C", "interpreter", *same)]
    pairs += [
        ("C", name, INDEPENDENT, _OTHER) for name in ("Newton-Euler", "maximal") if name in cross_checks
    ]
    largest = {pair: Largest(newton.joints, (pair[0], pair[1])) for pair in pairs}
    for k, (t, q, u) in enumerate(states):
        tell(f"compare {title}", k / len(states))
        values = {name: np.asarray(cross_check(q, u, t)) for name, cross_check in cross_checks.items()}
        for pair in pairs:
            largest[pair].add(values[pair[0]], values[pair[1]], f"state {k}, t = {t:.3g} s", typical)
    return [largest[pair].comparison(f"accelerations, {title}", pair[2], pair[3]) for pair in pairs]


def _energies_and_poses(
    interpreter: Interpreter, constants: Array, newton: NewtonEuler, result: Any, is_partial: bool
) -> list[Comparison]:
    """Energies and poses of the C along its run; `is_partial`: Newton-Euler lacks an effect, so energies are compared
    with the interpreter's."""
    names = interpreter.program.energies
    both = ("C", "Newton-Euler")
    split, total = Largest(names, ("interpreter", "Newton-Euler")), Largest(("total",), both)
    read = Largest(("total",), ("C", "interpreter"))
    centres, rotations = Largest(newton.bodies, both), Largest(newton.bodies, both)
    poses = {body: result.pose(body) for body in newton.bodies}
    for k, t in enumerate(result.t.tolist()):
        where = f"t = {t:.3g} s"
        q, u = result.q[k], result.u[k]
        ours = interpreter.energy(t, q, u, constants)
        theirs = newton.energy(q, u, t)
        size = sum(abs(v) for v in theirs.values())
        split.add(ours, np.array([theirs.get(name, 0.0) for name in names]), where, size)
        total.add(np.array([result.energy[k]]), np.array([sum(theirs.values())]), where, size)
        read.add(np.array([result.energy[k]]), np.array([ours.sum()]), where, float(np.abs(ours).sum()))
        centre, rotation = newton.poses(q)
        if newton.bodies:
            centres.add(np.array([poses[b][0][k] for b in newton.bodies]), centre, where)
            rotations.add(np.array([poses[b][1][k] for b in newton.bodies]), rotation, where)
    energies = [
        split.comparison("energies by effect", INDEPENDENT, _OTHER),
        total.comparison("energy", INDEPENDENT, _OTHER),
    ]
    return [
        *([read.comparison("energy", SAME_PROGRAM, _SAME)] if is_partial else energies),
        centres.comparison("centres of mass", INDEPENDENT, _OTHER),
        rotations.comparison("rotations", INDEPENDENT, _OTHER),
    ]


def _budgets(program: Program) -> dict[str, Budget]:
    """Evaluations by the size of the mechanism and of the program, so that quick checks stay quick; and seconds."""
    statements = sum(len(program.functions[name].statements) for name in program.motion)
    if "momenta" in program.motion:  # M is put together from as many columns
        statements += len(program.rates) * len(program.functions["momenta"].statements)
    own = max(1, EVALUATIONS // (len(program.joints) + 15))
    read = max(1, min(own, STATEMENTS // max(1, statements)))
    return {"interpreter": Budget(read, SECONDS), "Newton-Euler": Budget(own, SECONDS)}
