"""Linear algebra on one thread, where matrices are small.

In: a function. Out: the same, during which BLAS has one thread. Threads that share small matrices wait for one another:
on a machine with other work they take ten times as long as one. Never: changes a result but by round-off. OpenBLAS
heeds it in the main thread of Python only.
"""

import functools
import sys
from collections.abc import Callable
from contextlib import AbstractContextManager
from typing import Any, ParamSpec, TypeVar

P = ParamSpec("P")
R = TypeVar("R")


def on_one_thread(function: Callable[P, R]) -> Callable[P, R]:
    """The function, with BLAS on one thread while it runs."""

    @functools.wraps(function)
    def alone(*given: P.args, **named: P.kwargs) -> R:
        with one_thread():
            return function(*given, **named)

    return alone


def one_thread() -> AbstractContextManager[object]:
    """During which BLAS has one thread."""
    limited: AbstractContextManager[object] = _libraries("scipy.linalg" in sys.modules).limit(limits=1)
    return limited


@functools.cache
def _libraries(has_scipy: bool) -> Any:
    """What has threads: numpy's BLAS, and scipy's once that is there."""
    from threadpoolctl import ThreadpoolController

    return ThreadpoolController().select(user_api="blas")
