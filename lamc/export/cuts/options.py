"""What a user says of cut files, as text or numbers, checked.

In: values of `ExportOptions`, and what to call each. Out: lengths in m. Raises DesignError with the rule.
"""

import re
from typing import Any

from lamc.basics.checks import checked_number, is_list, shown
from lamc.basics.errors import DesignError
from lamc.basics.units import LENGTH

STRAIGHT, CASTELLATED, PERFORATED = STYLES = ("gap", "castellated", "perforated")
DRAWN, GAP = "drawn", "gap"  # widths of hinges that are no lengths
PITCH = 2e-3  # m, of tabs and of perforations
# m: what is larger is a number of millimetres without its unit. Cutters take away 0.5 mm at most, knives less; pins and
# widths of hinges are some mm, sheets up to 3 m.
_KERF, _SMALL, _SHEET = 5e-3, 0.1, 10.0


def style_of(value: Any, what: str) -> tuple[str, float]:
    """Style and pitch, m, of "castellated" or "castellated, 2 mm"."""
    words = [word.strip() for word in value.split(",")] if isinstance(value, str) else []
    if not words or words[0] not in STYLES or len(words) > (1 if words[0] == STRAIGHT else 2):
        raise DesignError(
            f"{what} is {shown(value)}; it must be gap, castellated or perforated, the latter two with a pitch if one "
            "is wanted: 'castellated, 2 mm'"
        )
    return words[0], _length(words[1], f"the pitch of {what}", _SMALL) if len(words) == 2 else PITCH


def checked_style(value: Any, what: str) -> str:
    style_of(value, what)
    return str(value)


def checked_width(value: Any, what: str) -> str | float:
    """ "drawn", "gap", or a width, m."""
    return value if isinstance(value, str) and value in (DRAWN, GAP) else _length(value, what, _SMALL)


def checked_kerf(value: Any, what: str) -> float:
    return _at_most(value, checked_number(value, what, minimum=0.0, quantity=LENGTH), what, _KERF)


def checked_pins(value: Any, what: str) -> float | None:
    return None if value is None else _length(value, what, _SMALL)


def checked_stock(value: Any, what: str) -> tuple[float, float] | None:
    """Width and height, m, of "300 mm x 200 mm" or (0.3, 0.2)."""
    if value is None:
        return None
    sides = re.split(r"\s*[x×]\s*", value.strip()) if isinstance(value, str) else value
    if not is_list(sides) or len(sides) != 2:
        raise DesignError(f"{what} is {shown(value)}; it must be width and height: '300 mm x 200 mm'")
    width, height = (
        _length(side, f"the {name} of {what}", _SHEET)
        for side, name in zip(sides, ("width", "height"), strict=True)
    )
    return width, height


def _length(value: Any, what: str, largest: float) -> float:
    number = checked_number(value, what, minimum=0.0, quantity=LENGTH)
    if not number > 0.0:
        raise DesignError(f"{what} is {number:g} m; it must be above 0")
    return _at_most(value, number, what, largest)


def _at_most(value: Any, number: float, what: str, largest: float) -> float:
    """number: of what was given."""
    if number > largest:
        is_bare = not isinstance(value, str) or value.strip()[-1:] in "0123456789."
        hint = f": numbers without a unit are m; write '{number:g} mm' if it is that" if is_bare else ""
        raise DesignError(
            f"{what} is {1e3 * number:g} mm, and more than {1e3 * largest:g} mm is not cut{hint}"
        )
    return number
