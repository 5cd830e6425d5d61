"""A run to an accuracy of its outputs: integrator and tolerance are found, and the error is estimated.

In: an accuracy, a request, and a function that runs it at a tolerance. Out: the `Result` of the tightest run with its
`Accuracy`. Never: claims an accuracy that runs at different tolerances do not bear out.

An integrator keeps the error of each step below a tolerance; what comes of it at the end depends on the motion. But the
end's error is proportional to the tolerance where steps are small enough (Shampine 1989, Tolerance proportionality in
ODE codes): e(tol) = C tol^k with k near 1. Runs at tolerances a > b > c show k by

    (a^k - c^k) / (b^k - c^k) = |y_a - y_c| / |y_b - y_c|,

and |y_b - y_c| / ((b/c)^k - 1) is the error of the tightest (Richardson), with k taken for 1 where it is above. Where
errors do not follow the tolerance the motion is chaotic, meets singular positions or round-off, and the whole
difference of the last two runs stands for the error.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from lamc.basics.errors import RequestError
from lamc.records.scene import Scene
from lamc.run.accuracy_record import Accuracy, Rung
from lamc.run.model import Motion
from lamc.run.outputs_error import common_rows, output_errors
from lamc.run.probe import Choice, choose
from lamc.run.request import MIN_RTOL, Array, Request, Status, finite
from lamc.run.result import Result

Rows = npt.NDArray[np.bool_]
Run = Callable[[str, Request], tuple[Result, float]]  # and what it took, in evaluations

LEAST, MOST = (
    1e-11,
    0.5,
)  # accuracies that can be asked for: round-off of a long run; half of the range says nothing
ATOL = 1e-2  # of rtol
_ROUGH = (1e-6, 1e-4)  # rtol of the first run, which shows ranges and steps: between these
_LOOSEST = 1e-2  # rtol
_FIRST = 1.0  # of the accuracy is the rtol that is tried where nothing else is known
_STEP = 10.0  # from one tolerance to the next
_LONGEST = 1e3  # when the error is far above what is asked for
_SAFETY = 0.3  # of the accuracy is aimed at
_FOLLOWING = 0.3  # k above this: errors follow the tolerance somehow
_MOST_K = 2.0
_TRUSTED = (0.7, 1.25)  # k between these: proportional, but for what the choice of steps adds
_MORE = 3  # further runs at most where k is outside, and the error small enough
_MOST_RUNS = 9
_PATIENCE = 20  # times the steps of the run before
_GRID = 1001  # times at which runs are compared; rows where none are asked for


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
    ladder = _Ladder(wanted, request, run, scene)
    choice = Choice(integrator, _FIRST * wanted, (), 0.0)
    try:
        if integrator == "auto" and request.t_end > 0.0 and len(request.y0):
            choice = _chosen(wanted, motion, request, ladder)
        ladder.climb(choice.integrator, _bounded(_SAFETY * choice.rtol))
    except KeyboardInterrupt:  # between runs, which answer it themselves
        ladder.cancel()
    result, errors, k = ladder.outcome()
    gave_up = result.status in (Status.CANCELLED, Status.STEP_LIMIT)
    if np.inf in errors.values() and choice.integrator not in ("auto", integrator) and not gave_up:
        choice, ladder = (
            replace(choice, integrator="auto"),
            ladder.anew(),
        )  # what was chosen does not get through
        ladder.climb("auto", _bounded(_SAFETY * _FIRST * wanted))
        result, errors, k = ladder.outcome()
    error = max(errors.values(), default=np.inf if not result.success else 0.0)
    facts = Accuracy(
        asked=wanted,
        error=error,
        reached=bool(result.success and error <= wanted),
        by_output=errors,
        integrator=choice.integrator,
        rtol=result.stats.rtol,
        proportionality=k,
        runs=tuple(ladder.rungs),
        candidates={c.integrator: c.effort for c in choice.candidates},
        probe_evaluations=choice.effort,
        evaluations=choice.effort + sum(rung.evaluations for rung in ladder.rungs),
    )
    keep = _kept(result, user)
    return replace(result.at_rows(keep), accuracy=facts, message=_message(result, facts))


def _chosen(wanted: float, motion: Motion, request: Request, ladder: "_Ladder") -> Choice:
    """What probes say, after a rough run."""
    rtol = min(max(0.1 * wanted, _ROUGH[0]), _ROUGH[1])
    rough = ladder.rough(rtol)
    if rough.status == Status.CANCELLED:
        return Choice("auto", rtol, (), 0.0)
    return choose(motion, _at(request, rtol), rough, wanted, _bounded(_FIRST * wanted))


class _Ladder:
    """Runs at ever tighter tolerances."""

    def __init__(self, wanted: float, request: Request, run: Run, scene: Scene) -> None:
        self._wanted, self._request, self._run, self._scene = wanted, request, run, scene
        self._runs: list[tuple[float, Result]] = []  # tolerances fall
        self._poor: list[Result] = []  # runs that did not reach the end, and rough ones
        self.rungs: list[Rung] = []
        self._more = _MORE
        self._barred = 0.0  # rtol that takes too many steps

    def rough(self, rtol: float) -> Result:
        """A first look, which is no part of the ladder."""
        self._poor = [self._made("auto", rtol, self._request.max_steps)]
        return self._poor[0]

    def anew(self) -> "_Ladder":
        """One without runs, but for those that count as work."""
        fresh = _Ladder(self._wanted, self._request, self._run, self._scene)
        fresh.rungs = list(self.rungs)
        return fresh

    def climb(self, name: str, rtol: float) -> None:
        """Runs until the accuracy is borne out by three of them, or cannot be had."""
        following: float | None = min(_STEP * rtol, _LOOSEST)
        if self._poor and self._poor[-1].status == Status.CANCELLED:
            return
        most = len(self.rungs) + _MOST_RUNS
        while following is not None and len(self.rungs) < most:
            rtol = following
            result = self._made(name, rtol, self._patience())
            if result.success:
                self._runs = sorted([*self._runs, (rtol, result)], key=lambda each: -each[0])
            else:
                self._poor.append(result)
                if result.status == Status.STEP_LIMIT:
                    self._barred = max(self._barred, rtol)
                elif result.status == Status.CANCELLED or len(self._poor) > 2 or self._runs:
                    return  # a tighter tolerance may pass what a loose one stumbles over, but not always
            following = self._next(rtol)

    def cancel(self) -> None:
        """What was under way was interrupted."""
        known = [*self._poor, *(result for _, result in self._runs)]
        if not known:
            raise KeyboardInterrupt
        self._poor = [
            replace(known[-1], status=Status.CANCELLED, message="cancelled; what was computed is kept")
        ]

    def outcome(self) -> tuple[Result, dict[str, float], float | None]:
        """The best run, its errors by output (relative), and k; infinite errors where nothing is known of them."""
        last = self._poor[-1] if self._poor else None
        if self._runs and (last is None or last.status != Status.CANCELLED):
            errors, k = self._estimate()
            return self._runs[-1][1], errors, k
        assert last is not None
        others = [*(result for _, result in self._runs), *self._poor[:-1]]
        if others and common_rows(last, others[-1]):
            return last, output_errors(others[-1], last, self._scene), None
        return last, _unknown(last, self._scene), None

    def _made(self, name: str, rtol: float, max_steps: int) -> Result:
        result, effort = self._run(name, replace(_at(self._request, rtol), max_steps=max_steps))
        self.rungs.append(Rung(result.stats.integrator, rtol, effort))
        return result

    def _patience(self) -> int:
        """Steps for the next run: not too many where it only confirms what is known. Implicit methods that step over
        fast motion at one tolerance may have to follow it at the next, with a thousand times the steps."""
        if len(self._runs) < 2 or max(self._estimate()[0].values(), default=0.0) > self._wanted:
            return self._request.max_steps
        return min(self._request.max_steps, _PATIENCE * self._runs[-1][1].stats.accepted + _PATIENCE)

    def _next(self, last: float) -> float | None:
        """The next tolerance; None if the ladder is complete, or further rungs would be no better."""
        if len(self._runs) < 2:
            if self._barred == 0.0:
                return _lower(last / _STEP) if last > MIN_RTOL else None
            return self._looser(max([self._barred, *(rtol for rtol, _ in self._runs)]))
        tightest = self._runs[-1][0]
        errors, k = self._estimate()
        error = max(errors.values(), default=0.0)
        tighter = _lower(tightest / _STEP)
        if tighter <= self._barred or tightest <= MIN_RTOL:
            return self._looser(self._runs[0][0]) if len(self._runs) < 3 else None
        if error > self._wanted:
            factor = max(_SAFETY * self._wanted / error, 1.0 / _LONGEST)
            wide = tightest * min(factor, 1.0 / _STEP) if k is not None else tightest / _LONGEST
            return max(_lower(wide), 1.0001 * self._barred)
        if error == 0.0:
            return None
        if len(self._runs) < 3:
            return self._looser(self._runs[0][0]) or tighter
        if self._more == 0 or (k is not None and _TRUSTED[0] <= k <= _TRUSTED[1]):
            return None
        self._more -= 1
        return tighter

    def _looser(self, rtol: float) -> float | None:
        return rtol * _STEP if rtol * _STEP <= _LOOSEST else None

    def _estimate(self) -> tuple[dict[str, float], float | None]:
        """Errors of the tightest run by output, and k; None where errors do not follow the tolerance."""
        if len(self._runs) < 2:
            return _unknown(self._runs[0][1], self._scene), None
        (b, middle), (c, tight) = self._runs[-2:]
        near = output_errors(middle, tight, self._scene)
        k: float | None = 1.0
        if len(self._runs) > 2:
            a, loose = self._runs[-3]
            far = output_errors(loose, tight, self._scene)
            k = power(a, b, c, max(far.values(), default=0.0), max(near.values(), default=0.0))
        part = 1.0 if k is None else 1.0 / ((b / c) ** min(k, 1.0) - 1.0)  # a larger k is chance
        return {name: part * gap for name, gap in near.items()}, k


def _unknown(result: Result, scene: Scene) -> dict[str, float]:
    """Infinite errors, by output."""
    return dict.fromkeys(output_errors(result, result, scene), np.inf)


def power(a: float, b: float, c: float, far: float, near: float) -> float | None:
    """k of errors C tol^k at tolerances a > b > c, from their distances to the run at c; None where it is not near 1.

    far: |y_a - y_c|, near: |y_b - y_c|.
    """
    if near == 0.0:
        return 1.0

    def excess(k: float) -> float:
        return float((a**k - c**k) / (b**k - c**k) - far / near)

    low, high = _FOLLOWING, _MOST_K
    if excess(low) > 0.0:
        return None
    if excess(high) < 0.0:
        return high  # errors fell by more: what is left is smaller still
    while high - low > 1e-3:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if excess(middle) < 0.0 else (low, middle)
    return 0.5 * (low + high)


def _at(request: Request, rtol: float) -> Request:
    return replace(request, rtol=rtol, atol=ATOL * rtol)


def _lower(rtol: float) -> float:
    return max(rtol, MIN_RTOL)


def _bounded(rtol: float) -> float:
    return min(max(rtol, MIN_RTOL), _LOOSEST)


def _times(request: Request) -> Array:
    """The user's times and enough between them to see the range of each output, ascending."""
    grid = np.linspace(0.0, request.t_end, _GRID if request.t_end > 0.0 else 1)
    return grid if request.t_eval is None else np.union1d(grid, request.t_eval)


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
