"""A run to an accuracy of its outputs: integrator and tolerance are found, and the error is estimated.

In: an accuracy, a request, and a function that runs it at a tolerance. Out: the `Result` of the tightest run with its
`Accuracy`. Never: claims an accuracy that runs at different tolerances do not bear out.

An integrator keeps the error of each step below a tolerance; what comes of it at the end depends on the motion. But the
end's error is proportional to the tolerance where steps are small enough (Shampine 1989, Tolerance proportionality in
ODE codes): e(tol) = C tol^k with k near 1. Runs at tolerances a > b > c show k by

    (a^k - c^k) / (b^k - c^k) = |y_a - y_c| / |y_b - y_c|,

and |y_b - y_c| / ((b/c)^k - 1) is the error of the tightest (Richardson), with k taken for 1 where it is above, and
where two runs that differ by less than is wanted are all that was needed. Where errors do not follow the tolerance the
motion is chaotic, meets singular positions or round-off, and the whole difference of the last two runs stands for the
error.
"""

from dataclasses import replace

import numpy as np
import numpy.typing as npt

from lamc.basics.errors import RequestError
from lamc.records.scene import Scene
from lamc.run.accuracy_ladder import PAIRED, SAFETY, Ladder, Run, at_tolerance, bounded
from lamc.run.accuracy_record import Accuracy
from lamc.run.methods import METHODS
from lamc.run.model import Motion
from lamc.run.probe import Choice, choose
from lamc.run.request import Array, Request, Status, finite
from lamc.run.result import Result

Rows = npt.NDArray[np.bool_]

LEAST, MOST = (
    1e-11,
    0.5,
)  # accuracies that can be asked for: round-off of a long run; half of the range says nothing
_ROUGH = (1e-6, 1e-3)  # rtol of the first run, which shows ranges and steps: between these
_FIRST = 1.0  # of the accuracy is the rtol that is tried where nothing else is known
_NEAR = 3.0  # to those beside the first run's
_GRID = 1001  # rows where none are asked for
_COMPARED = 201  # times at which runs are compared, at least, and


def checked_accuracy(accuracy: object, rtol: float | None, atol: float | None) -> float:
    """The accuracy, or RequestError with value and rule."""
    for name, given in (("rtol", rtol), ("atol", atol)):
        if given is not None:
            raise RequestError(
                f"{name} is {given!r} and accuracy is {accuracy!r}; accuracy finds the tolerances: leave {name} out"
            )
    rule = f"an error relative to the range of an output, between {LEAST:g} and {MOST:g}"
    wanted = finite(accuracy, "accuracy", rule)
    if isinstance(accuracy, bool) or not LEAST <= wanted <= MOST:
        raise RequestError(f"accuracy is {accuracy!r}; it must be {rule}")
    return wanted


def reach(wanted: float, integrator: str, motion: Motion, request: Request, run: Run, scene: Scene) -> Result:
    """The result whose estimated error is at most `wanted`, or the best that can be had. integrator: "auto" leaves the
    choice to probes."""
    user = request.t_eval
    request = replace(request, t_eval=_times(request))
    ladder = Ladder(wanted, request, run, scene)
    choice = Choice(integrator, _FIRST * wanted, (), 0.0)
    try:
        if integrator == "auto" and request.t_end > 0.0 and len(request.y0):
            rough = ladder.rough(min(max(0.1 * wanted, _ROUGH[0]), _ROUGH[1]))
            choice, ladder = _chosen(wanted, motion, request, rough, ladder)
        if not ladder.is_borne_out:
            ladder.climb(choice.integrator, bounded(SAFETY * choice.rtol))
    except KeyboardInterrupt:  # between runs, which answer it themselves
        ladder.cancel()
    result, errors, k = ladder.outcome()
    gave_up = result.status in (Status.CANCELLED, Status.STEP_LIMIT)
    if np.inf in errors.values() and choice.integrator not in ("auto", integrator) and not gave_up:
        choice, ladder = (
            replace(choice, integrator="auto"),
            ladder.anew(),
        )  # what was chosen does not get through
        ladder.climb("auto", bounded(SAFETY * _FIRST * wanted))
        result, errors, k = ladder.outcome()
    error = max(errors.values(), default=np.inf if not result.success else 0.0)
    facts = Accuracy(
        asked=wanted,
        error=error,
        reached=bool(result.success and error <= wanted),
        by_output=errors,
        integrator=result.stats.integrator if result.stats.integrator in METHODS else choice.integrator,
        rtol=result.stats.rtol,
        proportionality=k,
        runs=tuple(ladder.rungs),
        candidates={c.integrator: c.effort for c in choice.candidates},
        probe_evaluations=choice.effort,
        evaluations=choice.effort + sum(rung.evaluations for rung in ladder.rungs),
    )
    keep = _kept(result, user)
    return replace(result.at_rows(keep), accuracy=facts, message=_message(result, facts))


def _chosen(
    wanted: float, motion: Motion, request: Request, rough: Result, ladder: "Ladder"
) -> "tuple[Choice, Ladder]":
    """What to run, and the ladder with what is known by then.

    Where the rough run and a looser one, or a tighter one, agree to what is wanted, the tighter of the two is better
    than that, and there is nothing to choose. Elsewhere probes say which integrator does with less.
    """
    auto = Choice("auto", _FIRST * wanted, (), 0.0)
    if rough.status == Status.CANCELLED:
        return auto, ladder
    if wanted >= PAIRED and rough.success:
        ladder.keep_rough()
        name = rough.stats.integrator if rough.stats.integrator in METHODS else "auto"
        for factor in (_NEAR, 1.0 / _NEAR):
            ladder.add(name, bounded(factor * rough.stats.rtol))
            if ladder.is_borne_out:
                return auto, ladder
        ladder = ladder.anew()
    return choose(
        motion, at_tolerance(request, rough.stats.rtol), rough, wanted, bounded(_FIRST * wanted)
    ), ladder


def _times(request: Request) -> Array:
    """The user's times and enough between them to see the range of each output, ascending."""
    if request.t_end == 0.0:
        return np.zeros(1)
    if request.t_eval is None:
        return np.linspace(0.0, request.t_end, _GRID)
    grid = np.linspace(0.0, request.t_end, _COMPARED)
    return np.union1d(grid, request.t_eval) if len(request.t_eval) < _COMPARED else request.t_eval


def _kept(result: Result, times: Array | None) -> Rows:
    """Which rows the user asked for, and the last of a run that ended early; shape (m,), of bool."""
    keep = np.ones(len(result.t), dtype=bool) if times is None else np.isin(result.t, times)
    if not result.success and len(keep):
        keep[-1] = True
    return keep


def _message(result: Result, facts: Accuracy) -> str:
    reported = f"the outputs are known to {facts.error:.1e} of their range"
    if facts.reached:
        return f"{result.message}; {reported}"
    why = (
        ""
        if facts.proportionality is not None
        else ", and tighter tolerances change them as much as loose ones"
    )
    return f"{result.message}; {reported}{why}: an accuracy of {facts.asked:g} was not reached"
