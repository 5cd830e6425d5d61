"""Layup notation: "[0/90/±45]s" as a list of ply angles.

In: text. Out: angles in degrees, bottom to top; or a DesignError that shows the place. Never: executes anything; text
passes the grammar below and nothing else.

    layup  = "[" list "]" [ count ] [ "s" | "t" ]  |  list       s: the list, then its mirror image; t: the list is all
    list   = item { "/" item }
    item   = [ sign ] angle [ count ]  |  "(" list ")" [ count ]
    sign   = "+" | "-" | "±" | "+-" | "∓" | "-+"                 ±45 is 45 and then -45
    count  = [ "_" ] digits

After an angle a count needs its "_" (or is written in subscript digits), since 902 would be an angle. Spaces mean
nothing. [0/90]2s is [0/90/0/90]s. Source: the laminate orientation code of MIL-HDBK-17-2F, section 1.6.
"""

import math
import re

from lamc.basics.checks import shown
from lamc.basics.errors import DesignError

MOST_PLIES = 10_000
_DEEPEST = 20  # brackets in brackets
_SUBSCRIPTS = str.maketrans("₀₁₂₃₄₅₆₇₈₉", "0123456789")
_PLAIN = str.maketrans({"−": "-", "±": "+-", "∓": "-+", "°": None})
_SIGNS = {"": (1.0,), "+": (1.0,), "-": (-1.0,), "+-": (1.0, -1.0), "-+": (-1.0, 1.0)}
_SIGN = re.compile(r"[+-]{0,2}")
_ANGLE = re.compile(r"[0-9]+(\.[0-9]*)?|\.[0-9]+", re.ASCII)
_COUNT = re.compile(r"[0-9]{1,9}", re.ASCII)


def layup_angles(text: str) -> tuple[float, ...]:
    """The angles of a layup, degrees, bottom to top. Raises DesignError with the place of what is wrong."""
    if not isinstance(text, str):
        raise DesignError(f'a layup is {shown(text)}; it must be text such as "[0/90/±45]s"')
    reader = _Reader(text)
    bracketed = reader.took("[")
    angles = reader.items(0)
    if bracketed:
        reader.need("]", "or '/' and one more ply")
        angles = reader.repeated(angles, bare=True)
        if reader.took("s") or reader.took("S"):
            angles = reader.checked(angles + angles[::-1])
        elif not reader.took("t"):
            reader.took("T")
    reader.end()
    return tuple(angles)


class _Reader:
    """The text without spaces, and how far it is read."""

    def __init__(self, text: str) -> None:
        self.shown = shown(text)
        counts = re.sub("[₀-₉]+", lambda found: "_" + found.group().translate(_SUBSCRIPTS), text)
        self.text = re.sub(r"\s+", "", counts.translate(_PLAIN))
        self.at = 0

    def items(self, depth: int) -> list[float]:
        angles: list[float] = []
        while True:
            angles = self.checked(angles + self.item(depth))
            if not self.took("/"):
                return angles

    def item(self, depth: int) -> list[float]:
        if self.took("("):
            if depth >= _DEEPEST:
                raise self.error(f"brackets lie deeper than {_DEEPEST}")
            inner = self.items(depth + 1)
            self.need(")", "or '/' and one more ply")
            return self.repeated(inner, bare=True)
        sign = self.take(_SIGN)
        digits = self.take(_ANGLE)
        if sign not in _SIGNS or not digits:
            raise self.error("there must be an angle in degrees")
        angle = float(digits)
        if not math.isfinite(angle):
            raise self.error("an angle must be finite")
        return self.repeated([factor * angle for factor in _SIGNS[sign]], bare=False)

    def repeated(self, angles: list[float], bare: bool) -> list[float]:
        """`angles` as often as the count that may follow says; `bare`: it needs no "_"."""
        marked = self.took("_")
        digits = self.take(_COUNT) if marked or bare else ""
        if marked and not digits:
            raise self.error("there must be a number of plies after '_'")
        count = int(digits or 1)
        if count < 1:
            raise self.error("a count must be at least 1")
        if count * len(angles) > MOST_PLIES:
            raise self.error(f"it has more than {MOST_PLIES} plies")
        return angles * count

    def checked(self, angles: list[float]) -> list[float]:
        if len(angles) > MOST_PLIES:
            raise self.error(f"it has more than {MOST_PLIES} plies")
        return angles

    def took(self, character: str) -> bool:
        found = self.text.startswith(character, self.at)
        self.at += found
        return found

    def take(self, pattern: re.Pattern[str]) -> str:
        found = pattern.match(self.text, self.at)
        self.at = found.end() if found else self.at
        return found.group() if found else ""

    def need(self, character: str, otherwise: str) -> None:
        if not self.took(character):
            raise self.error(f"there must be {character!r} {otherwise}")

    def end(self) -> None:
        if self.at < len(self.text):
            raise self.error("nothing may follow but a count and s or t after ']'")

    def error(self, rule: str) -> DesignError:
        rest = self.text[self.at :]
        place = f"at {shown(rest[:20])}" if rest else "at its end"
        return DesignError(f'the layup {self.shown} is not understood {place}: {rule}, as in "[0_2/90/±45]s"')
