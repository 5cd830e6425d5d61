"""JSON as plain values, within limits.

In: text. Out: maps, lists, texts and numbers. Never: takes NaN for a number, or the last of two equal keys, but for
those that only tell of a file.
"""

import json
from collections.abc import Callable
from typing import Any, NoReturn

from lamc.basics.checks import shown
from lamc.basics.errors import DesignError, Place, warn
from lamc.readers.inert import Limits

# Keys of FOLD by which nothing is drawn. Some files have them twice, and other programs read the last of them.
TELLING = frozenset(
    f"{of}_{what}"
    for of in ("file", "frame")
    for what in ("spec", "creator", "author", "title", "description", "classes", "attributes")
)


def parsed(text: str, file: str, limits: Limits) -> Any:
    """What the text holds. Raises DesignError with the place for what is no JSON; RecursionError for deep nests."""
    # Each value but the first of a list or map has a comma before it, and those in texts are few.
    count = text.count(",") + 1
    if count > limits.values:
        raise DesignError(
            f"the file has some {count} values; at most {limits.values} are read (limit 'values'): keep one frame, or "
            "raise it with lamc.load(…, limits=lamc.Limits(values=…))",
            Place(file),
        )

    def refused(word: str) -> NoReturn:
        raise DesignError(
            f"the file holds {word}, which is no JSON: numbers must be finite", _word_place(text, word, file)
        )

    try:
        return json.loads(text.lstrip("\ufeff"), parse_constant=refused, object_pairs_hook=_map(file))
    except json.JSONDecodeError as error:
        raise DesignError(
            f"the file is no JSON: {error.msg}; write it anew with the program that made it",
            Place(file, error.lineno, error.colno),
        ) from error
    except ValueError as error:  # an integer of more digits than Python reads
        raise DesignError(f"a number is beyond reading: {str(error)[:80]}", Place(file)) from error


def _map(file: str) -> Callable[[list[tuple[str, Any]]], dict[str, Any]]:
    told: set[str] = set()

    def made(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
        found: dict[str, Any] = {}
        for key, value in pairs:
            if key in found and key not in TELLING:
                raise DesignError(f"{key[:40]!r} stands twice in one map; keep one of them", Place(file))
            if key in found and found[key] != value and key not in told:
                told.add(key)
                said = f"{key!r} stands twice in one map, {shown(found[key])} and {shown(value)}: the last is read"
                warn(said, Place(file))
            found[key] = value
        return found

    return made


def _word_place(text: str, word: str, file: str) -> Place:
    at = text.find(word)
    return Place(file, text.count("\n", 0, at) + 1, at - text.rfind("\n", 0, at))
