"""What a reader of drawings tells of what it assumed or left out: a line for each kind, with the first few places."""

_SHOWN = 4


class Notes:
    """Lines in the order of their first place."""

    def __init__(self) -> None:
        self._found: dict[str, list[str]] = {}

    def say(self, line: str) -> None:
        """A line of its own, once."""
        self._found.setdefault(line, [])

    def add(self, what: str, source: str) -> None:
        """One more thing that is as `what` says: "is text"."""
        self._found.setdefault(what, []).append(source)

    @property
    def lines(self) -> tuple[str, ...]:
        return tuple(_line(what, sources) for what, sources in self._found.items())


def _line(what: str, sources: list[str]) -> str:
    if not sources:
        return what
    names = ", ".join(sources[:_SHOWN])
    if len(sources) == 1:
        return f"{names}: {what}"
    more = f" and {len(sources) - _SHOWN} more" if len(sources) > _SHOWN else ""
    return f"{names}{more}: each {what}"
