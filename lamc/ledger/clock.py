"""Time for a ledger: a budget that stages share, and the shortest of repeated runs.

In: jobs. Out: processor seconds. Nothing physical depends on the clocks that are read here.
"""

import time
from collections.abc import Callable, Sequence

_TURN = 0.004  # s that one turn of a short job lasts at least, so that it runs from warm caches
_MOST_TURNS = 9
_TICK = time.get_clock_info("process_time").resolution  # s; some systems count in steps of 16 ms


class OutOfTime(Exception):  # noqa: N818 - a signal, not an error
    """A run has used up what it may take. `reached` is the time of its motion by then, s."""

    def __init__(self, reached: float = 0.0) -> None:
        super().__init__(reached)
        self.reached = reached


class Clock:
    """A budget of wall time, s, from now on."""

    def __init__(self, budget: float) -> None:
        self._budget = budget
        self._started = time.perf_counter()

    @property
    def spent(self) -> float:
        """s since it began."""
        return time.perf_counter() - self._started

    def left(self, share: float = 1.0) -> float:
        """s left until this share of the budget is spent; at least 0."""
        return max(0.0, share * self._budget - self.spent)

    def guard(self, seconds: float) -> Callable[[float, float], None]:
        """A progress function for `Simulator.run` that ends the run by OutOfTime after `seconds` from now."""
        until = time.perf_counter() + seconds

        def check(t: float, _t_end: float) -> None:
            if time.perf_counter() > until:
                raise OutOfTime(t)

        return check


def processor_seconds(job: Callable[[], object]) -> float:
    """Processor time of one call, s; a tick of the clock where it takes less, so that times can be divided by."""
    started = time.process_time()
    job()
    return max(_TICK, time.process_time() - started)


def shortest(
    jobs: Sequence[Callable[[], object]], first: Sequence[float], seconds: float
) -> list[tuple[float, int]]:
    """Shortest processor time, s, and number of turns of each job.

    jobs take turns, so that a busy machine disturbs all alike; cheap ones first, for as long as `seconds` of wall time
    allow. first: a first timing of each, s.
    """
    best, repeats = list(first), [1] * len(jobs)
    order = sorted(range(len(jobs)), key=lambda k: first[k])
    until = time.perf_counter() + seconds
    for _ in range(_MOST_TURNS):
        for k in order:
            calls = max(1, int(_TURN / max(best[k], 1e-6)))
            if time.perf_counter() + calls * best[k] > until:
                continue
            for _ in range(calls):
                best[k] = min(best[k], processor_seconds(jobs[k]))
            repeats[k] += calls
    return list(zip(best, repeats, strict=True))
