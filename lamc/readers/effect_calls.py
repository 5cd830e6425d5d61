"""Effects as files and options call for them: names with plain data.

In: what stands under `effects` or `with`. Out: names and data one by one, and effects. None is known here by name.
"""

from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

from lamc.basics.errors import DesignError
from lamc.effects.data import refusal
from lamc.effects.registry import by_name
from lamc.readers.checking import Path, did_you_mean
from lamc.records.effect import Effect


class Called(NamedTuple):
    """An effect as a file calls for it."""

    path: Path
    name: str
    value: object


def make_effect(name: str, value: object, where: str, context: Mapping[str, Any] | None = None) -> Effect:
    """The effect of that name in files; messages begin with `where`. context: `file_context` of the file.

    Raises DataError for a name the registry does not have, and for data that does not fit; DesignErrors with several.
    """
    known = by_name()
    if name not in known:
        raise refusal(where, f"no effect is named {name[:40]!r}; {did_you_mean(name, sorted(known))}")
    return known[name].from_data(value, where, context)


def effects_called(effects: object, path: Path) -> Iterator[Called]:
    """The effects of a map, or of a list of names and one-entry maps."""
    if effects is None:
        return
    if isinstance(effects, Mapping):
        for name, value in effects.items():
            yield Called((*path, str(name)), str(name), value)
        return
    if not isinstance(effects, list):
        raise DesignError("effects are a map from name to value, or a list of names and one-entry maps")
    for index, item in enumerate(effects):
        if isinstance(item, str):
            yield Called((*path, index), item, None)
        elif isinstance(item, Mapping) and len(item) == 1:
            ((name, value),) = item.items()
            yield Called((*path, index, str(name)), str(name), value)
        else:
            raise DesignError(f"entry {index} of the effects is neither a name nor a map with one entry")
