"""What a mechanism's loops come to, kept in the cache: counting takes up to a second, reading less than a millisecond.

In: a digest of all that the count follows from, a cache, and how to count. Out: a `LoopCount`. A note that is damaged
or cannot be written costs a count, and nothing else.
"""

from collections.abc import Callable
from dataclasses import asdict
from typing import Any

from lamc.codegen.cache import Cache
from lamc.loops.misfit import Misfit
from lamc.loops.rank import Found, LoopCount


def kept_loops(alias: str | None, cache: Cache, count: Callable[[], LoopCount]) -> LoopCount:
    """The count. Raises what `count` raises; a mechanism that is refused is counted, and told, each time.

    alias: of `loops_digest`; None: there is no telling, so it is counted"""
    if alias is None:
        return count()
    found = _read(cache.kept(alias))
    if found is None:
        found = count()
        cache.keep(alias, asdict(found))
    return found


def _read(values: Any) -> LoopCount | None:
    try:
        misfit, start = values.pop("misfit"), values.pop("start")
        for name in ("singular_values", "branch_ranks", "position"):
            values[name] = tuple(values[name])
        if misfit is not None:
            misfit["place"] = tuple(misfit["place"])
        if start is not None:
            start = Found(
                tuple((name, angle) for name, angle in start["given"]),
                *(tuple(start[name]) for name in ("joints", "angles")),
            )
        return LoopCount(**values, misfit=None if misfit is None else Misfit(**misfit), start=start)
    except (ValueError, TypeError, KeyError, AttributeError):
        return None
