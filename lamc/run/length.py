"""How long a run of the command line is: what was asked for, or, where nobody says, 10 s as far as counted work allows.

In: what was asked for, a simulator. Out: an end, a number of steps, and a remark where these ended the run. Never:
looks at a clock, so that a run ends alike on every machine.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from lamc.basics.brief import counted
from lamc.basics.progress import Part
from lamc.loops.misfit import length
from lamc.loops.texts import MAY_BEND, ROUND_OFF
from lamc.records.mechanism import Array
from lamc.run.defaults import (
    ATOL,
    DURATION,
    MAX_STEPS,
    MOST_WORK,
    PATIENT_WORK,
    RTOL,
    default_rows,
    default_steps,
)
from lamc.run.request import Status
from lamc.run.result import Result
from lamc.run.simulator import Simulator

_MANY = (
    20_000  # steps; a device that does not come to 10 s in so many is stuck, and has failed when it gives up
)
# What neither drives a sheet for longer than its creases do, nor stops its hinges: with others, runs do not end where a
# fold seems over.
_AT_REST = {"gravity", "hinge_damping", "hinge_stiffness", "rest_angle"}
_ROWS = 2000  # steps of loops, at least: their work, as it is counted, ends a run before
# Near singular positions accelerations have few digits, and steps are as short as the tolerance asks for: a looser one
# comes tens of times as far. It is taken where it comes to the end, or farther by this factor.
LOOSE, FARTHER = 1e-6, 2.0
LOOSE_ATOL = LOOSE * ATOL / RTOL
TRIAL = 0.25  # of the work: what is seen of both tolerances before one of them has all of it
_BOTH = 2.0 * TRIAL / (1.0 + 2.0 * TRIAL)  # of all work, when both have been seen
_FIRST = 0.5 * _BOTH
# What has turned by less, rad, in less than this part of the time, and has come by the second half of its steps to no
# more than so many times what it came to by the first, is stuck next to a singular position: its steps shrink, and all
# of the work would show no more than a part of it does.
STUCK, SOON, GROWS = 5e-3, 1e-3, 1.5
_SEEN = 8  # steps from rest begin short and grow: fewer tell nothing of those to come
_PATIENCE = 5  # times the counted steps: of small loops, which are not stuck after as many, 20 s of work


@dataclass(frozen=True)
class Length:
    """t_end: s. steps: that are tried. is_own: they are lamc's choice, and a run that takes them all is a whole one.
    work: of loops, at most; None: no limit, as somebody says how long.
    until_folded: nobody says how long, so that a sheet that only its creases and gravity move is at its end where its
    fold is over."""

    t_end: float
    steps: int
    is_own: bool = False
    until_folded: bool = False
    work: float | None = None

    def rows(self, size: int) -> int:
        """Rows of a table of states of a size where nobody says; 0: one after each step, as rows that are spread over
        all of it would miss a run that ends early."""
        rows = default_rows(self.t_end, size)
        return 0 if self.is_own and self.steps <= rows else rows

    def run(self, simulator: Simulator, rows: int, **arguments: Any) -> "Ran":
        """A run of this length with so many rows, evenly spread over what there is of it; 0: one after each step. One
        that ends before its end is run once more, step by step the same, for rows that show it. Of loops, one that
        work of lamc's choice ends is tried at a looser tolerance as well, if nobody gives one, and is that of both
        which gets farther by far; Ctrl-C then leaves the one that got farther. arguments: as for `Simulator.run`."""
        is_native = not str(arguments.get("integrator", "")).startswith("scipy:")
        has_work = self.is_own and bool(simulator.cut_joints) and is_native
        steps = max(self.steps, _ROWS) if has_work else self.steps
        arguments |= {"max_steps": steps, "until_folded": self.until_folded, "max_work": self.work}

        def run(rows: int = rows, **changes: Any) -> Result:
            return simulator.run(self.t_end, t_eval=_even(self.t_end, rows), **arguments | changes)

        tries_both = has_work and self.work is not None and not _says_how_exact(arguments)
        made = self._at_best(run, rows, arguments.get("progress")) if tries_both else _Made(run())
        result = made.result
        if result.status == Status.CANCELLED:
            return Ran(result, "")
        is_short = result.status == Status.FOLDED or (result.status == Status.STEP_LIMIT and self.is_own)
        if rows and (result.success if made.by_step else is_short):
            again = arguments | made.changes | {"progress": None}
            end = float(result.t[-1]) if is_short else self.t_end
            # Rows between steps are settled, which next to singular positions is more work than steps are.
            few = result.status == Status.STEP_LIMIT and _tried(result) <= rows
            result = simulator.run(self.t_end, t_eval=None if few else _even(end, rows), **again)
        return Ran(result, self._remark(simulator, replace(made, result=result)))

    def _at_best(self, run: Callable[..., Result], rows: int, progress: Part | None) -> "_Made":
        """The run of this work at the usual tolerance or, where that does not come to its end and gets not nearly as
        far, at a looser one. A part of the work tells which, and is all that is done of what is stuck."""
        assert self.work is not None
        trial, looser = {"max_work": TRIAL * self.work}, {"rtol": LOOSE, "atol": LOOSE_ATOL}
        exact = run(progress=_share(progress, 0.0, _FIRST), **trial)
        if exact.status != Status.STEP_LIMIT:
            return _Made(exact)
        farther = _interruptible(
            exact, lambda: run(progress=_share(progress, _FIRST, _BOTH), **trial, **looser)
        )
        if farther.status == Status.CANCELLED:
            return _Made(farther)
        rest = _share(progress, _BOTH, 1.0)
        if farther.success:  # as exact as ever, if all of the work is enough for that
            whole = _interruptible(farther, lambda: run(progress=rest))
            is_better = whole.success or whole.status == Status.CANCELLED
            return _Made(whole) if is_better else _Made(farther, looser)
        gets_farther = farther.status == Status.STEP_LIMIT and farther.t[-1] > FARTHER * exact.t[-1]
        seen, changes = (farther, looser) if gets_farther else (exact, {})
        if _turned(seen) < STUCK and seen.t[-1] < SOON * self.t_end:
            each = _interruptible(seen, lambda: run(0, progress=None, **trial, **changes)) if rows else seen
            shrinks = len(each.t) > _SEEN and each.t[-1] < GROWS * each.t[len(each.t) // 2]
            if each.status == Status.CANCELLED or shrinks:
                return _Made(each, changes, by_step=True, is_stuck=True)
        by_step = bool(rows) and self._has_few_steps(seen, rows)
        shown = 0 if by_step else rows
        if gets_farther:
            farther = _interruptible(farther, lambda: run(shown, progress=rest, **looser))
            if farther.success or farther.status in (Status.STEP_LIMIT, Status.CANCELLED):
                return _Made(farther, looser, by_step)
            rest = None  # what is looser came apart
        return _Made(_interruptible(exact, lambda: run(shown, progress=rest)), by_step=by_step)

    def _has_few_steps(self, trial: Result, rows: int) -> bool:
        """Whether all of the work will end a run as well, after fewer steps than rows are asked for: each is a row
        then, and no second run has to be made for rows that show it."""
        return float(trial.t[-1]) < TRIAL**2 * self.t_end and _tried(trial) < TRIAL * rows

    def _remark(self, simulator: Simulator, made: "_Made") -> str:
        """Why a run of lamc's choice ended before 10 s, and the way out, and at what tolerance it ran, where that is
        another than usual; empty where neither is to be told, or it failed."""
        result, is_looser = made.result, "rtol" in made.changes
        tolerance = (
            f"at rtol {LOOSE:g} it gets farther than at {RTOL:g} by as much work, and --rtol says another"
        )
        if result.status == Status.REACHED_END:
            return f"nobody says how exact it is to be: {tolerance}" if is_looser else ""
        if result.status == Status.FOLDED:
            return (
                "nobody says how long it is to run, and it ends where its fold is over, as nothing keeps facets from "
                f"passing through one another: --t-end {self.t_end:g}, or a duration in its scene, runs on, and "
                "joint_limits: {flat_fold: true} stops hinges at ±180°"
                + (f"; {tolerance}" if is_looser else "")
            )
        if not self.is_own or result.status != Status.STEP_LIMIT or not result.stats.accepted:
            return ""
        of_tolerance = f"; {tolerance}" if is_looser else ", and a looser --rtol takes longer steps"
        tried, freedoms = _tried(result), counted(simulator.freedoms, "freedom")
        steps = f"{counted(tried, 'step')} of {counted(len(simulator.joints), 'hinge')} with {freedoms}"
        why = (
            f"{steps} have turned them by {_turned(result):.1g} rad at most: it is stuck next to a singular position, "
            "from where another branch of the scene, or angles of some hinges, may lead; it ends before"
            if made.is_stuck
            else f"{steps} {'is' if tried == 1 else 'are'} as much work as a run does by itself: it ends before"
        )
        return (
            f"nobody says how long it is to run, and {why} {self.t_end:g} s; --t-end {self.t_end:g}, or a duration in "
            f"its scene, runs to there however long that takes{of_tolerance}{_of_misfit(simulator)}"
        )


@dataclass(frozen=True)
class _Made:
    """A run; what it was made with instead of what was asked for; whether each of its steps is a row; and whether it is
    stuck."""

    result: Result
    changes: dict[str, float] = field(default_factory=dict)
    by_step: bool = False
    is_stuck: bool = False


@dataclass(frozen=True)
class Ran:
    """A run, and what is to be told of how it ended; empty: nothing, or its message says it."""

    result: Result
    remark: str


def _interruptible(before: Result, run: Callable[[], Result]) -> Result:
    """What `run` gives; after Ctrl-C, as cancelled, whichever of both got farther."""
    try:
        after = run()
    except KeyboardInterrupt:
        after = before
    else:
        if after.status != Status.CANCELLED or after.t[-1] > before.t[-1]:
            return after
    text = f"cancelled at t = {before.t[-1]:.9g} s; what was computed is kept"
    return replace(before, status=Status.CANCELLED, message=text)


def _share(progress: Part | None, begin: float, end: float) -> Part | None:
    """Progress of a run that is the part from `begin` to `end`, of 1, of what is told."""
    if not callable(progress):  # none, or whether `Simulator.run` shows a bar
        return progress
    return lambda done, total: progress(begin + (end - begin) * (done / total if total > 0.0 else 1.0), 1.0)


def _even(end: float, rows: int) -> Array | None:
    return np.linspace(0.0, end, rows) if rows and 0.0 < end < np.inf else None


def _of_misfit(simulator: Simulator) -> str:
    """That loops which close only nearly may take short steps, and what may help; empty of others."""
    misfit = simulator.loops.misfit
    if misfit is None or misfit.gap < ROUND_OFF * simulator.mechanism.size:
        return ""
    return f"; its loops close only within {length(misfit.gap)}, for which steps may be short: {MAY_BEND}"


def length_of(t_end: float | None, max_steps: int | None, simulator: Simulator) -> Length:
    """The length of a run, s and steps; None: not asked for."""
    duration = simulator.scene.duration
    end = duration or DURATION if t_end is None else t_end
    if max_steps is not None:
        return Length(end, max_steps)
    if t_end is not None or duration:
        return Length(end, MAX_STEPS)
    steps = default_steps(
        len(simulator.joints),
        simulator.freedoms,
        has_loops=bool(simulator.cut_joints),
        has_misfit=simulator.loops.accepted_gap > 0.0,
    )
    folds = {effect.name for effect in simulator.effects} <= _AT_REST
    if steps >= _MANY:
        most = min(MAX_STEPS, _PATIENCE * steps)
        return Length(end, most, until_folded=folds, work=PATIENT_WORK)
    return Length(end, steps, is_own=True, until_folded=folds, work=MOST_WORK)


def _says_how_exact(arguments: Mapping[str, Any]) -> bool:
    return any(arguments.get(name) is not None for name in ("rtol", "atol", "accuracy"))


def _turned(result: Result) -> float:
    """How far a joint has turned at most, rad."""
    count = len(result.joints)  # coordinates of bases and of what bends come after them
    return float(np.abs(result.q[-1, :count] - result.q[0, :count]).max(initial=0.0))


def _tried(result: Result) -> int:
    """Steps that a run in C tried."""
    return result.stats.accepted + (result.stats.rejected or 0)
