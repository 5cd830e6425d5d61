"""Numbers with units, and names, for people.

In: a value in SI and its unit, or a name. Out: text, or a scale and a unit with a prefix. It rounds, so nothing is
computed from what it gives.
"""

import math
import re

_PREFIXES = (
    *((1e12, "T"), (1e9, "G"), (1e6, "M"), (1e3, "k"), (1.0, "")),
    *((1e-3, "m"), (1e-6, "µ"), (1e-9, "n"), (1e-12, "p")),
)
_LENGTHS = _PREFIXES[3:]  # nobody reads megametres
_FIRST = re.compile(r"([A-Za-zΩ]+)(?:\^([1-9])|([²³]))?(?![0-9^])")  # of a unit: what a prefix goes with
_POWERS = {None: 1, "²": 2, "³": 3}
_UNPREFIXED = ("rad", "deg")


def prefixed(largest: float, unit: str) -> tuple[float, str]:
    """Scale and unit in which numbers up to `largest` read well: value / scale is in the unit.

    A prefix goes with the first factor, and is raised to its power: 1e-6 m² is 1 mm². That of kg is g's.
    """
    size = abs(largest)
    first = _FIRST.match(unit)
    if not math.isfinite(size) or size == 0.0 or first is None or first[1] in _UNPREFIXED:
        return 1.0, unit
    name, whole = ("g", 1e-3) if first[1] == "kg" else (first[1], 1.0)
    power = int(first[2]) if first[2] else _POWERS[first[3]]
    scales = _LENGTHS if name == "m" else _PREFIXES
    choices = [((scale * whole) ** power, prefix + name + unit[len(first[1]) :]) for scale, prefix in scales]
    return next(((scale, text) for scale, text in choices if size >= scale * (1.0 - 1e-9)), choices[-1])


def shown_number(value: float, unit: str, digits: int = 5) -> str:
    """A value with its unit and the prefix that suits it."""
    scale, name = prefixed(value, unit)
    return f"{value / scale:.{digits}g} {name}".rstrip()


def place_text(at: tuple[float, float], size: float) -> str:
    """(x, y) in the unit that suits a plate of `size` m."""
    scale, unit = prefixed(size, "m")
    return f"({', '.join(f'{round(c / scale, 4) + 0.0:.5g}' for c in at)}) {unit}"


def duration(seconds: float) -> str:
    """A time in the unit that suits it."""
    for scale, unit in ((86400.0, "d"), (3600.0, "h"), (1.0, "s"), (1e-3, "ms"), (1e-6, "µs")):
        if seconds >= scale:
            return f"{seconds / scale:.3g} {unit}"
    return f"{seconds * 1e9:.3g} ns"


def length_text(metres: float) -> str:
    """A length in m, mm or µm."""
    for scale, unit in ((1.0, "m"), (1e-3, "mm")):
        if metres >= 0.1 * scale:
            return f"{metres / scale:.3g} {unit}"
    return f"{metres * 1e6:.3g} µm"


def shortened(name: str, count: int) -> str:
    """The name, cut to `count` characters."""
    return name if len(name) <= count else name[: count - 1] + "…"
