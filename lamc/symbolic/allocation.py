"""Keeps the cyclic collector out of a stage that makes very many small objects and drops none.

The collector walks all of them again and again: derivation grows like n^1.15 with it and n^1.08 without, and takes
a quarter longer at 100 hinges (`python -m benchmarks.solver_crossover`).
"""

import gc
from collections.abc import Callable
from functools import wraps
from typing import ParamSpec, TypeVar

P = ParamSpec("P")
R = TypeVar("R")


def collector_paused(function: Callable[P, R]) -> Callable[P, R]:
    """`function` with the cyclic collector off while it runs, and as it was afterwards."""

    @wraps(function)
    def paused(*args: P.args, **kwargs: P.kwargs) -> R:
        was_enabled = gc.isenabled()
        gc.disable()
        try:
            return function(*args, **kwargs)
        finally:
            if was_enabled:
                gc.enable()

    return paused
