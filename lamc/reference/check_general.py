"""The check of simulators of more than hinges on a fixed world: bases that move, hinges that yield, bodies that bend.

In: a compiled simulator. Out: a report on accelerations, energies and poses, at random states and at those along a run.
The motion itself is not integrated a second time.
"""

from collections.abc import Sequence
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from lamc.records.scene_values import left_to_model
from lamc.reference.check_motion import Progress
from lamc.reference.check_report import Comparison, Largest, Report
from lamc.reference.general_states import general_states, regular
from lamc.reference.inputs import with_inputs
from lamc.reference.interpreter import Interpreter
from lamc.reference.lagrange import ARRANGED, Lagrange
from lamc.reference.loads import known_effects
from lamc.reference.modal_integrals import modal_integrals
from lamc.reference.moving_base import MOVING, MovingNewtonEuler
from lamc.reference.series import following
from lamc.reference.strip_springs import strip_springs
from lamc.run.following import series_of

Array = npt.NDArray[np.float64]

# The interpreter solves M u̇ = f by another library than the C: round-off times the condition of the mass matrix.
SOLVED, INDEPENDENT = 1e-10, 1e-10
ROWS = 21
SOLVERS = (
    30.0  # what two solvers of ill-conditioned equations differ by, over what a last digit of the state makes
)
ROUNDED = 5e-15  # of the size: positions, of which deflections of loops that stiffness closes are left-overs
_SOLVED = "same equations, two solvers of M u̇ = f; round-off times the condition of the mass matrix"
_OTHER = "other operations altogether; round-off times the condition of the mass matrix"


class CrossCheck(Protocol):
    """What is asked of an independent formulation."""

    @property
    def bodies(self) -> tuple[str, ...]: ...
    def acceleration(self, q: Array, u: Array, t: float = 0.0) -> Array: ...
    def energy(self, q: Array, u: Array, t: float = 0.0) -> dict[str, float]: ...
    def poses(self, q: Array, t: float = 0.0) -> tuple[Array, Array]: ...


def check_general(
    simulator: Any, general: Sequence[str], states: int, t_end: float, seed: int, tell: Progress
) -> Report:
    """Compares the cross-checks at `states` random states and along a run of `t_end` seconds.

    general  names of the effects that go beyond hinges on a fixed world
    """
    program = simulator.program
    series = series_of(simulator.scene)
    interpreter = Interpreter(program, series)
    constants = interpreter.constants()
    inputs = {p.name: p.default for p in program.parameters if p.is_input}
    mechanism, joints = simulator.mechanism, program.joints
    effects = with_inputs(mechanism, simulator.effects, inputs | dict.fromkeys(series, 0.0))
    unknown = known_effects(effects, ARRANGED)[1]
    unknown = unknown or ", ".join(left_to_model(simulator.mechanism, simulator.scene))
    names = tuple(rate.name for rate in program.rates)

    def by_lagrange(acting: tuple[Any, ...]) -> Lagrange:
        return Lagrange(mechanism, acting, joints, names, known_effects(acting, ARRANGED)[0])

    def by_newton(acting: tuple[Any, ...]) -> MovingNewtonEuler:
        return MovingNewtonEuler(mechanism, known_effects(acting, ARRANGED)[0], joints)

    lagrange: Lagrange = following(by_lagrange, mechanism, simulator.effects, inputs, series)
    cross_checks: dict[str, CrossCheck] = {"Lagrange": lagrange}
    if set(general) <= set(MOVING):
        cross_checks["Newton-Euler"] = following(by_newton, mechanism, simulator.effects, inputs, series)
    notes = [
        f"{', '.join(sorted(general))}: the motion is not integrated a second time, its accelerations are compared"
    ]
    if unknown:
        notes.append(
            f"the independent cross-checks do not know {unknown}; accelerations and energies are compared between "
            f"the C and "
            "the interpreter only"
        )
    tell("run the C", 0.0)
    result = simulator.run(t_end, rtol=1e-10, atol=1e-12, t_eval=np.linspace(0.0, t_end, ROWS))
    if not result.success:
        notes.append(f"the run of the C did not reach its end: {result.message}")
    along = [(float(t), q, u) for t, q, u in zip(result.t, result.q, result.u, strict=True)]
    random = general_states(lagrange, simulator.mechanism, along[0], states, t_end, seed)
    if len(random) < states:
        notes.append(f"{len(random)} of {states} random states close all loops away from singular positions")
    comparisons: list[Comparison] = strip_springs(simulator.mechanism, effects)
    comparisons += modal_integrals(simulator.mechanism, effects)
    for title, rows in (("random states", random), ("states of the run", regular(lagrange, along))):
        tell(f"compare {title}", 0.5)
        read = Largest(names, ("C", "interpreter"))
        others = {name: Largest(names, ("C", name)) for name in ([] if unknown else cross_checks)}
        for k, (t, q, u) in enumerate(rows):
            where, found = f"state {k}, t = {t:.3g} s", simulator.acceleration(q, u, t)
            least = max(1.0, lagrange.elastic_acceleration(q, ROUNDED / INDEPENDENT))
            if not unknown:
                least = max(least, SOLVERS * lagrange.rounded(q, u, t) / INDEPENDENT)
            read.add(found, interpreter.acceleration(t, q, u, constants), where, least)
            for name, other in others.items():
                other.add(found, cross_checks[name].acceleration(q, u, t), where, least)
        comparisons.append(read.comparison(f"accelerations, {title}", SOLVED, _SOLVED))
        comparisons += [o.comparison(f"accelerations, {title}", INDEPENDENT, _OTHER) for o in others.values()]
    for name, cross_check in cross_checks.items():
        comparisons += _energies_and_poses(interpreter, constants, (name, cross_check), result, bool(unknown))
    return Report(program.name, tuple(comparisons), tuple(notes))


def _energies_and_poses(
    interpreter: Interpreter, constants: Array, named: tuple[str, CrossCheck], result: Any, is_partial: bool
) -> list[Comparison]:
    names, (other, cross_check) = interpreter.program.energies, named
    both = ("C", other)
    total = Largest(("total",), ("C", "interpreter") if is_partial else both)
    parts = Largest(names, ("interpreter", other))
    centres, rotations = Largest(cross_check.bodies, both), Largest(cross_check.bodies, both)
    poses = {body: result.pose(body) for body in cross_check.bodies}
    for k, t in enumerate(result.t.tolist()):
        where, q, u = f"t = {t:.3g} s", result.q[k], result.u[k]
        ours = interpreter.energy(t, q, u, constants)
        size = float(np.abs(ours).sum())
        expected = float(ours.sum())
        if not is_partial:
            theirs = cross_check.energy(q, u, t)
            parts.add(ours, np.array([theirs.get(name, 0.0) for name in names]), where, size)
            expected = sum(theirs.values())
        total.add(np.array([result.energy[k]]), np.array([expected]), where, size)
        centre, rotation = cross_check.poses(q, t)
        centres.add(np.array([poses[b][0][k] for b in cross_check.bodies]), centre, where)
        rotations.add(np.array([poses[b][1][k] for b in cross_check.bodies]), rotation, where)
    return [
        *([] if is_partial else [parts.comparison("energies by effect", INDEPENDENT, _OTHER)]),
        total.comparison("energy", INDEPENDENT, _OTHER),
        centres.comparison("centres of mass", INDEPENDENT, _OTHER),
        rotations.comparison("rotations", INDEPENDENT, _OTHER),
    ]
