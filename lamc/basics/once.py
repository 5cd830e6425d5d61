"""Values that are made once, whichever thread asks first: of an object (`lazy`, and for packages of floors above it
`kept_with`), of arguments (`remembered`).

In: a function. Out: its value, the same object for every thread; who comes while it is made waits. Never: holds a lock
beyond that, so that objects can be copied, pickled and forked; makes callers of other objects wait.

functools' do not do this. From Python 3.12 on cached_property takes no lock and calls the function once for each
thread, up to 3.11 it has one lock for all objects of a class; lru_cache calls it once for each thread that comes early.
That is no matter for a pure function of numbers. It is one where the work is long, as deriving equations is, or where
two equal objects are not interchangeable, as pint's registries are not.
"""

import os
import threading
from collections.abc import Callable, Hashable, Iterator
from contextlib import contextmanager
from functools import update_wrapper
from typing import Any, Generic, ParamSpec, Self, TypeVar, overload

_P = ParamSpec("_P")
_T = TypeVar("_T")


class _Turn:
    """A lock, and how many threads hold or await it."""

    def __init__(self) -> None:
        self.lock = threading.RLock()  # a function may ask for its own value by a detour, as recursion does
        self.count = 0


_guard = threading.Lock()
_turns: dict[Hashable, _Turn] = {}


def _afresh() -> None:
    """After a fork: threads that held locks are not there any more."""
    global _guard, _turns
    _guard, _turns = threading.Lock(), {}


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_afresh)


@contextmanager
def _in_turn(key: Hashable) -> Iterator[None]:
    """One thread at a time for each key."""
    with _guard:
        turn = _turns.setdefault(key, _Turn())
        turn.count += 1
    try:
        with turn.lock:
            yield
    finally:
        with _guard:
            turn.count -= 1
            if not turn.count and _turns.get(key) is turn:
                del _turns[key]


class lazy(Generic[_T]):  # noqa: N801  (lower case, as `property` is)
    """A property that is computed when it is first asked for, once, and kept in the object's `__dict__`."""

    def __init__(self, function: Callable[[Any], _T]) -> None:
        self._function = function
        self.__doc__ = function.__doc__

    def __set_name__(self, owner: type, name: str) -> None:
        self._name = name

    @overload
    def __get__(self, instance: None, owner: type | None = None) -> Self: ...
    @overload
    def __get__(self, instance: object, owner: type | None = None) -> _T: ...
    def __get__(self, instance: object | None, owner: type | None = None) -> Self | _T:
        if instance is None:
            return self
        return kept_with(instance, self._name, self._function)


def kept_with(owner: Any, name: str, function: Callable[[Any], _T]) -> _T:
    """The function's value of an object, computed once and kept in its `__dict__` by that name, as `lazy` does."""
    values = owner.__dict__
    if name not in values:  # to take one's turn takes longer than most that ask for a value that is there
        with _in_turn((id(owner), name)):
            if name not in values:
                values[name] = function(owner)
    made: _T = values[name]
    return made


def remembered(function: Callable[_P, _T]) -> Callable[_P, _T]:
    """A function of hashable arguments that is called once for each of them; what it raises is not kept."""
    values: dict[Hashable, _T] = {}

    def wrapped(*given: _P.args, **named: _P.kwargs) -> _T:
        key = (given, tuple(sorted(named.items())))
        if key not in values:
            with _in_turn((id(values), key)):
                if key not in values:
                    values[key] = function(*given, **named)
        return values[key]

    update_wrapper(wrapped, function)
    return wrapped
