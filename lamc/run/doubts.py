"""In what a result may not be what it seems: hinges that pass through themselves, and of loops equations let go and a
rank from elsewhere.

In: a `Result`. Out: lines for people. Never: changes a number, or looks at more rows than it says.
"""

import math
from typing import TYPE_CHECKING

import numpy as np

from lamc.basics.threads import on_one_thread
from lamc.loops.linear import DENSE, Linear
from lamc.run.methods import IMPLICIT
from lamc.run.unresolved import Modes, Steps, unresolved_note

if TYPE_CHECKING:
    from lamc.records.mechanism import Array
    from lamc.run.result import Result

_THROUGH = np.pi + 1e-6  # rad: a fold that is drawn or held flat is not beyond
_NAMED = 4  # hinges in a line
_ROWS = 5  # at which the rank of the closure is looked at
_MOST = 8_000_000  # numbers in a closure's Jacobian that are looked at: 64 MB
_INDEPENDENT = (
    1e-9  # of the largest singular value: above what a closed state has left of dependent equations, 1e-13
)


def notes(result: "Result") -> tuple[str, ...]:
    """The lines."""
    if not len(result.t):
        return ()
    loops = (*_let_go(result), *_rank_from_elsewhere(result)) if result.motion.model.cuts else ()
    return (*_folded_through(result), *loops, *_no_derivative(result))


def _no_derivative(result: "Result") -> list[str]:
    found = result.sensitivities
    if found is None:
        return []
    lines = []
    if found.lost is not None:
        lines.append(f"there is no derivative from t = {found.lost.t:.6g} s on: {found.lost.reason}")
    if (longest := _too_long(result)) is not None:
        lines.append(unresolved_note(longest, result.stats.integrator))
    if (horizon := found.horizon(result)) is not None:
        lines.append(
            f"from t = {horizon[0]:.4g} s on a change of {horizon[1]} by the run's tolerance moves the state by more "
            "than a hundredth of its range: the motion is chaotic there, and derivatives say nothing of finite changes"
        )
    return lines


def _too_long(result: "Result") -> float | None:
    """How long steps may be, s, where an implicit method has collocated derivatives over longer ones, on average. Those
    of explicit methods go by steps of their own."""
    stats = result.stats
    used = stats.integrator.split(", ")
    if not {*used} & {*IMPLICIT} or not stats.accepted:
        return None
    y0, span = np.concatenate([result.q[0], result.u[0]]), float(result.t[-1] - result.t[0])
    tolerance = max(stats.rtol, stats.atol)
    modes = Modes(result.motion, y0, float(result.t[0]), result.mechanism.size, tolerance)
    longest = modes.bear(Steps(used, span / stats.accepted, span, tolerance))
    return longest if math.isfinite(longest) else None


def _folded_through(result: "Result") -> list[str]:
    """Hinges between plates that pass ±180°, where a fold's faces meet, and have no limits: with the first time."""
    has_plates = {body.name: bool(body.outline) for body in result.mechanism.bodies}
    passed: list[tuple[float, str]] = []
    for joint in result.mechanism.joints:
        stopped = f"{joint.name}.upper_limit" in result.motion.model.parameters
        if stopped or not (has_plates[joint.parent] and has_plates[joint.child]):
            continue
        angle = np.abs(result.angle(joint.name))
        beyond = np.flatnonzero((angle[1:] > _THROUGH) & (angle[:-1] <= _THROUGH))
        if len(beyond):
            k = int(beyond[0])
            share = (_THROUGH - angle[k]) / (angle[k + 1] - angle[k])
            passed.append((float(result.t[k] + share * (result.t[k + 1] - result.t[k])), joint.name))
    if not passed:
        return []
    said = [f"{name!r} at t = {t:.4g} s" for t, name in sorted(passed)[:_NAMED]]
    more = f" and {len(passed) - _NAMED} more" if len(passed) > _NAMED else ""
    hinges = "hinges" if len(passed) > 1 else "hinge"
    return [
        f"{hinges} {', '.join(said)}{more} went through ±180°, where the two faces of a fold "
        "meet: nothing stops them there; joint_limits: {flat_fold: true} does, and limits of the hinge do earlier"
    ]


def _let_go(result: "Result") -> list[str]:
    count = result.stats.singular_steps
    if not count:
        return []
    return [
        f"{count} of {result.stats.accepted} steps ended near a singular position, where equations of the loops fade "
        "and were let go: there forces choose the branch of the motion; see whether the angles beyond are those meant"
    ]


@on_one_thread
def _rank_from_elsewhere(result: "Result") -> list[str]:
    """Where the rank that the runtime takes at most is met in other postures only, or is not the largest met."""
    model = result.motion.model
    width = len(model.rates)
    if model.rank == 0 or len(result.t) < _ROWS or model.closure_count * width > _MOST:
        return []
    rows = np.unique(np.linspace(0, len(result.t) - 1, _ROWS).astype(int))
    met, before = 0, None
    for k in rows:
        state = np.hstack([result.q[k : k + 1], result.u[k : k + 1]])
        jacobian = result.motion.closures(state)[0, model.closure_count :].reshape(-1, width)
        before = _taken_apart(jacobian).after(before)
        met = max(met, before.rank(_INDEPENDENT))
    if met > model.rank and not result.motion.gap:  # a misfit that is accepted has a rank of its own
        return [
            f"the loops have {met} independent equations at some of the {len(rows)} rows that were looked at, and the "
            f"run took {model.rank}, as at its start: it has left the motion that it began with; compare with a run "
            "from there"
        ]
    if met >= model.rank:
        return []
    return [
        f"the loops have {model.rank} independent equations in other postures, and {met} "
        f"at the {len(rows)} rows that were looked at: the rank was taken from elsewhere; "
        "compare with a run from another start"
    ]


def _taken_apart(jacobian: "Array") -> Linear:
    if jacobian.shape[1] <= DENSE:
        return Linear(jacobian)
    from scipy import sparse  # a quarter of a second, which small mechanisms do not need

    return Linear(sparse.csr_array(jacobian))
