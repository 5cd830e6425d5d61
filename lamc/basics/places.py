"""Where the parts of a design or a scene stand in its file, so that later stages can point at them in messages.

In: places from readers of files. Out: the place for an error. Records that were made by hand have none.
"""

import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass

from lamc.basics.errors import DesignErrors, LamcError, Place

Path = tuple[str | int, ...]
_NAMED = re.compile(r"'([^']+)'")


@dataclass(frozen=True)
class Places:
    """Keys from the top of the file, or of the scene, and the place; and records that errors may be about, each with
    the places of its keys, and of the words in it."""

    known: tuple[tuple[Path, Place], ...] = ()
    records: tuple[tuple[object, Place, Mapping[str, Place]], ...] = ()

    def of(self, *path: str | int) -> Place | None:
        """The place of what stands at `path`, or of the nearest thing around it; None where nothing is known."""
        known = dict(self.known)
        return next((known[path[:n]] for n in range(len(path), -1, -1) if path[:n] in known), None)

    def of_subject(self, subject: object, part: Path = ()) -> Place | None:
        """The place of what an error is about: a record of these or a part of it, or a path."""
        if isinstance(subject, tuple):
            return self.of(*subject)
        for record, place, keys in self.records:
            if record is subject:
                return next((keys[str(key)] for key in part if str(key) in keys), place)
        return None


@contextmanager
def located_at(places: Places) -> Iterator[None]:
    """LamcErrors of the block that know their subject, and not its place, get the place."""
    try:
        yield
    except DesignErrors:
        raise
    except LamcError as error:
        place = None
        if error.place is None and error.subject is not None:
            # What the message names, such as a joint that there is not, is at fault where nobody knows the part.
            part = error.part or tuple(_NAMED.findall(error.message))
            place = places.of_subject(error.subject, part)
        if place is None:
            raise
        raise type(error)(error.message, place) from error
