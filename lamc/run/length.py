"""How long a run of the command line is: what was asked for, or, where nobody says, 10 s as far as counted work allows.

In: what was asked for, a simulator. Out: an end, a number of steps, and a remark where these ended the run. Never:
looks at a clock, so that a run ends alike on every machine.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from lamc.loops.misfit import length
from lamc.loops.texts import MAY_BEND, ROUND_OFF
from lamc.records.mechanism import Array
from lamc.run.defaults import ATOL, DURATION, MAX_STEPS, MOST_WORK, RTOL, default_rows, default_steps
from lamc.run.request import Status
from lamc.run.result import Result
from lamc.run.simulator import Simulator

_MANY = (
    20_000  # steps; a device that does not come to 10 s in so many is stuck, and has failed when it gives up
)
# What neither drives a sheet for longer than its creases do, nor stops its hinges: with others, runs do not end where a
# fold seems over.
_AT_REST = {"gravity", "hinge_damping", "hinge_stiffness", "rest_angle"}
_ROWS = 2000  # steps of loops, at least, before their count of work ends a run: each has a row then
# Near singular positions accelerations have few digits, and steps are as short as the tolerance asks for: a looser one
# comes tens of times as far. It is taken where it comes farther by this factor.
LOOSE, FARTHER = 1e-6, 2.0
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

    def run(self, simulator: Simulator, rows: int, **arguments: Any) -> Result:
        """A run of this length with so many rows, evenly spread over what there is of it; 0: one after each step. A
        fold that is over before its end is run once more, step by step the same, for rows that show it. One that work
        of lamc's choice ends is run once more at a looser tolerance, if nobody gives one, and is that of both which
        got farther by far. arguments: as for `Simulator.run`."""
        arguments |= {"max_steps": self.steps, "until_folded": self.until_folded, "max_work": self.work}
        result = simulator.run(self.t_end, t_eval=_even(self.t_end, rows), **arguments)
        if result.status == Status.STEP_LIMIT and self.is_own and not _says_how_exact(arguments):
            looser = arguments | {"rtol": LOOSE, "atol": LOOSE * ATOL / RTOL}
            farther = simulator.run(self.t_end, t_eval=_even(self.t_end, rows), **looser)
            if farther.t[-1] > FARTHER * result.t[-1]:
                result, arguments = farther, looser
        if result.status != Status.FOLDED or not rows:
            return result
        return simulator.run(self.t_end, t_eval=_even(float(result.t[-1]), rows), **arguments)

    def remark(self, simulator: Simulator, result: Result) -> str:
        """Why a run of lamc's choice ended before 10 s, and the way out; empty where it did not, or failed."""
        if result.status == Status.FOLDED:
            return (
                "nobody says how long it is to run, and it ends where its fold is over, as nothing keeps facets from "
                f"passing through one another: --t-end {self.t_end:g}, or a duration in its scene, runs on, and "
                "joint_limits: {flat_fold: true} stops hinges at ±180°"
            )
        if not self.is_own or result.status != Status.STEP_LIMIT:
            return ""
        tolerance = ", and a looser --rtol takes longer steps"
        if result.stats.rtol == LOOSE:
            tolerance = f"; at rtol {LOOSE:g} it gets farther than at {RTOL:g} by as much work, and --rtol says another"
        return (
            f"nobody says how long it is to run, and {_tried(result)} steps of {len(simulator.joints)} hinges with "
            f"{simulator.freedoms} freedoms are as much work as a run does by itself: it ends before "
            f"{self.t_end:g} s; --t-end {self.t_end:g}, or a duration in its scene, runs to there however long that "
            f"takes{tolerance}{_of_misfit(simulator)}"
        )


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
        return Length(end, most, until_folded=folds, work=_PATIENCE * MOST_WORK)
    if simulator.cut_joints:
        steps = max(steps, _ROWS)
    return Length(end, steps, is_own=True, until_folded=folds, work=MOST_WORK)


def _says_how_exact(arguments: Mapping[str, Any]) -> bool:
    return any(arguments.get(name) is not None for name in ("rtol", "atol", "accuracy"))


def _tried(result: Result) -> int:
    """Steps that a run in C tried."""
    return result.stats.accepted + (result.stats.rejected or 0)
