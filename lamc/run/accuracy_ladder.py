"""Runs at ever tighter tolerances, and what they tell of each other's errors.

In: an accuracy, a request, and a function that runs it at a tolerance. Out: the tightest run, the error of each output,
and k of errors C tol^k; see `accuracy`. Never: chooses an integrator.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from lamc.records.scene import Scene
from lamc.run.accuracy_record import Rung
from lamc.run.outputs_error import common_rows, compared_outputs, output_errors, ranges
from lamc.run.request import MIN_RTOL, Array, Request, Status
from lamc.run.result import Result

Run = Callable[[str, Request], tuple[Result, float]]  # and what it took, in evaluations

ATOL = 1e-2  # of rtol
LOOSEST = 1e-2  # rtol
PAIRED = 1e-4  # accuracies from here on may be borne out by the first two runs alone, or by the first three
STEP = 10.0  # from one tolerance to the next, and
_LONGEST = 1e3  # when the error is far above what is asked for
SAFETY = 0.3  # of the accuracy is aimed at
_FOLLOWING = 0.3  # k above this: errors follow the tolerance somehow
_MOST_K = 2.0
_TRUSTED = (0.7, 1.25)  # k between these: proportional, but for what the choice of steps adds
_MORE = 3  # further runs at most where k is outside, and the error small enough
_MOST_RUNS = 9
_PATIENCE = 20  # times the steps of the run before
# Of what two runs differ by, as k = 0.8 leaves over _LONGEST: a law of near tolerances need not hold over three decades
_LEAST_PART = 0.004
_GLANCED = 101  # about so many where a run is compared with a looser one


class Ladder:
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

    def keep_rough(self) -> None:
        """The rough run is the first of the ladder."""
        self._runs = [(self.rungs[-1].rtol, self._poor.pop())]

    @property
    def is_borne_out(self) -> bool:
        """Whether the two tightest runs differ by no more than is wanted: the tighter is better than that."""
        if len(self._runs) < 2 or self._poor:
            return False
        (_, loose), (_, tight) = self._runs[-2:]
        return max(_differences(loose, tight, self._scene).values(), default=0.0) <= self._wanted

    def add(self, name: str, rtol: float) -> Result:
        """One more run; among those that count if it reached the end."""
        result = self._made(name, rtol, self._patience())
        if result.success:
            self._runs = sorted([*self._runs, (rtol, result)], key=lambda each: -each[0])
        else:
            self._poor.append(result)
        return result

    def anew(self) -> "Ladder":
        """One without runs, but for those that count as work."""
        fresh = Ladder(self._wanted, self._request, self._run, self._scene)
        fresh.rungs = list(self.rungs)
        return fresh

    def climb(self, name: str, rtol: float) -> None:
        """Runs until the accuracy is borne out by three of them, or cannot be had."""
        following: float | None = min(STEP * rtol, LOOSEST)
        if self._poor and self._poor[-1].status == Status.CANCELLED:
            return
        most = len(self.rungs) + _MOST_RUNS
        while following is not None and len(self.rungs) < most:
            rtol = following
            result = self.add(name, rtol)
            if not result.success:
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
        asked = replace(at_tolerance(self._request, rtol), max_steps=max_steps)
        if self._runs and rtol > self._runs[-1][0]:  # it is compared, and never the result
            assert asked.t_eval is not None
            asked = replace(asked, t_eval=_few(asked.t_eval, self._runs[-1][1], self._scene))
        result, effort = self._run(name, asked)
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
                return _lower(last / STEP) if last > MIN_RTOL else None
            return self._looser(max([self._barred, *(rtol for rtol, _ in self._runs)]))
        if self.is_borne_out and self._wanted >= PAIRED:
            return None
        tightest = self._runs[-1][0]
        errors, k = self._estimate()
        error = max(errors.values(), default=0.0)
        tighter = _lower(tightest / STEP)
        if tighter <= self._barred or tightest <= MIN_RTOL:
            return self._looser(self._runs[0][0]) if len(self._runs) < 3 else None
        # By a law an estimate may be a few times too small; without one it is all that two runs differ by.
        if error > (self._wanted if k is None else SAFETY * self._wanted):
            factor = max(SAFETY * self._wanted / error, 1.0 / _LONGEST)
            wide = tightest * min(factor, 1.0 / STEP) if k is not None else tightest / _LONGEST
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
        return rtol * STEP if rtol * STEP <= LOOSEST else None

    def _estimate(self) -> tuple[dict[str, float], float | None]:
        """Errors of the tightest run by output, and k; None where errors do not follow the tolerance."""
        if len(self._runs) < 2:
            return _unknown(self._runs[0][1], self._scene), None
        (b, middle), (c, tight) = self._runs[-2:]
        near = _differences(middle, tight, self._scene)
        k: float | None = 1.0
        if len(self._runs) > 2 and _alike(*(result for _, result in self._runs[-3:])):
            a, loose = self._runs[-3]
            far = _differences(loose, tight, self._scene)
            k = power(a, b, c, max(far.values(), default=0.0), max(near.values(), default=0.0))
        part = 1.0 if k is None else 1.0 / ((b / c) ** min(k, 1.0) - 1.0)  # a larger k is chance
        part = max(part, _LEAST_PART)
        return {name: part * gap for name, gap in near.items()}, k


def _alike(*results: Result) -> bool:
    """Whether runs took the same methods: only then their errors follow one law."""
    return len({result.stats.integrator for result in results}) == 1


def _differences(loose: Result, tight: Result, scene: Scene) -> dict[str, float]:
    """By output, at the rows of the looser run, which may have fewer."""
    if len(loose.t) < len(tight.t):
        tight = tight.at_rows(np.isin(tight.t, loose.t))
    return output_errors(loose, tight, scene)


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


def at_tolerance(request: Request, rtol: float) -> Request:
    return replace(request, rtol=rtol, atol=ATOL * rtol)


def _lower(rtol: float) -> float:
    return max(rtol, MIN_RTOL)


def bounded(rtol: float) -> float:
    return min(max(rtol, MIN_RTOL), LOOSEST)


def _few(times: Array, result: Result, scene: Scene) -> Array:
    """Some of the times, the last among them: rows of loops are projected, which costs as much as their steps. They lie
    evenly in time, and along the way of the outputs in `result`: a start that is over in some rows has them all."""
    if len(result.t) != len(times):
        return np.union1d(times[:: -(-len(times) // _GLANCED)], times[-1:])
    outputs = compared_outputs(result, scene)
    scale = ranges(outputs, chosen=scene.outputs is not None)  # round-off of what stands still is no way
    way = sum(np.abs(np.diff(each.values)) / scale[each.name] for each in outputs)
    shares = [np.arange(len(times)) / max(len(times) - 1, 1), np.concatenate([[0.0], np.cumsum(way)])]
    chosen = [
        np.searchsorted(share / (share[-1] or 1.0), np.linspace(0.0, 1.0, _GLANCED // 2 + 1))
        for share in shares
    ]
    return np.union1d(times[np.minimum(np.concatenate(chosen), len(times) - 1)], times[-1:])
