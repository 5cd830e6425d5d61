"""Names that every engine takes: made of the design's own, each once.

In: names as a design has them, which may hold anything. Out: the same order of names of letters, digits, _ and - alone,
which need no escape in XML, as file names or in a URI. Never: remembers a name from one call to the next.
"""

import re
from collections.abc import Iterable

MAX_LENGTH = 60
_OTHERS = re.compile(r"[^A-Za-z0-9_-]+")


def engine_names(names: Iterable[str], reserved: Iterable[str] = ()) -> list[str]:
    """One name each, all different, in the order given. What is no letter, digit, _ or - becomes _, and names that are
    then alike are numbered: _2, _3, …; they differ by more than case, since files are named after them."""
    taken = {name.casefold() for name in reserved}
    made: list[str] = []
    for name in names:
        core = _OTHERS.sub("_", name).strip("_-")[:MAX_LENGTH].rstrip("_-") or "unnamed"
        candidate, number = core, 1
        while candidate.casefold() in taken:
            number += 1
            candidate = f"{core}_{number}"
        taken.add(candidate.casefold())
        made.append(candidate)
    return made
