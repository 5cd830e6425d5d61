"""Linear algebra on one thread, where matrices are small.

In: a function. Out: the same, during which BLAS has one thread. Threads that share small matrices wait for one another:
on a machine with other work they take ten times as long as one. Never: changes a result but by round-off. OpenBLAS
heeds it in the main thread of Python only.
"""

import functools
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from typing import Any, ParamSpec, TypeVar

P = ParamSpec("P")
R = TypeVar("R")
_within = threading.local()  # whether scipy was there when the context around began; nothing outside of one


def on_one_thread(function: Callable[P, R]) -> Callable[P, R]:
    """The function, with BLAS on one thread while it runs."""

    @functools.wraps(function)
    def alone(*given: P.args, **named: P.kwargs) -> R:
        with one_thread():
            return function(*given, **named)

    return alone


@contextmanager
def one_thread() -> Iterator[None]:
    """During which BLAS has one thread."""
    before, has_scipy = getattr(_within, "has_scipy", None), "scipy.linalg" in sys.modules
    # One of these within another does nothing: to ask the libraries takes longer than a small matrix does.
    if before is has_scipy:
        yield
        return
    _within.has_scipy = has_scipy
    outer, _within.later = getattr(_within, "later", None), ExitStack()
    try:
        with _libraries(has_scipy).limit(limits=1), _within.later:
            yield
    finally:
        _within.has_scipy, _within.later = before, outer


def hold_scipy_too() -> None:
    """Of whoever loads scipy within the context: its BLAS, which came after the context began, has one thread as well
    until that ends."""
    if getattr(_within, "has_scipy", None) is False and "scipy.linalg" in sys.modules:
        _within.later.enter_context(_libraries(True).limit(limits=1))
        _within.has_scipy = True


@functools.cache
def _libraries(has_scipy: bool) -> Any:
    """What has threads: numpy's BLAS, and scipy's once that is there."""
    from threadpoolctl import ThreadpoolController

    return ThreadpoolController().select(user_api="blas")
