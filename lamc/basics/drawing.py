"""What draws what: verbs of records (`result.plot()`) whose work is done on a floor above them.

In: the kind of a record, a verb, and where its function stands, as "module:function"; the front door, `lamc`, fills the
table. Out: that function, imported when the verb is used. Never: imports anything before; knows what a picture is.
"""

from collections.abc import Callable, Mapping
from importlib import import_module
from typing import Any

from lamc.basics.errors import LamcError

_places: dict[tuple[str, str], str] = {}


def tell(places: Mapping[tuple[str, str], str]) -> None:
    """Adds entries: (kind, verb) → "module:function"; kind is the name of the record's class."""
    _places.update(places)


def registered() -> Mapping[tuple[str, str], str]:
    """All entries."""
    return dict(_places)


def drawer(kind: str, verb: str) -> Callable[..., Any]:
    """The function behind a verb of a kind of record; its first argument is the record. Raises LamcError where there
    is none."""
    try:
        module, _, function = _places[kind, verb].partition(":")
    except KeyError:
        raise LamcError(f"this lamc has nothing to {verb} a {kind} with") from None
    found: Callable[..., Any] = getattr(import_module(module), function)
    return found
