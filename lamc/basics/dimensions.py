"""Dimensions: what SI units multiply to, so that a sum of a length and an angle is told from one of two lengths.

In: the text of an SI unit, "N*m/rad" or "N·m/rad". Out: powers of base units, which compare; and words for people. An
angle counts as a unit of its own here (rad), as it does where lamc reads units.
"""

import re
from collections.abc import Iterable, Mapping
from fractions import Fraction
from functools import lru_cache

from lamc.basics import units
from lamc.basics.errors import DesignError
from lamc.basics.units import Quantity, with_article

Dimension = tuple[tuple[str, Fraction], ...]  # base units with their powers, sorted; none is 0

PLAIN: Dimension = ()
_BASE: Mapping[str, Mapping[str, int]] = {
    "N": {"kg": 1, "m": 1, "s": -2},
    "Pa": {"kg": 1, "m": -1, "s": -2},
    "J": {"kg": 1, "m": 2, "s": -2},
    "W": {"kg": 1, "m": 2, "s": -3},
    "V": {"kg": 1, "m": 2, "s": -3, "A": -1},
    "C": {"A": 1, "s": 1},
    "F": {"kg": -1, "m": -2, "s": 4, "A": 2},
    "Ω": {"kg": 1, "m": 2, "s": -3, "A": -2},
    "S": {"kg": -1, "m": -2, "s": 3, "A": 2},
    "Wb": {"kg": 1, "m": 2, "s": -2, "A": -1},
    "T": {"kg": 1, "s": -2, "A": -1},
    "H": {"kg": 1, "m": 2, "s": -2, "A": -2},
    "Hz": {"s": -1},
    "deg": {"rad": 1},
}
_FACTOR = re.compile(r"([*·/]?)\s*([^\s*·/^²³0-9.]+|1)(?:\^(-?[0-9.]+)|([²³]))?\s*")
_POWERS = {"²": 2, "³": 3}


@lru_cache(maxsize=1024)
def dimension_of(unit: str) -> Dimension:
    """Of an SI unit as lamc writes it; "" and "1" for a plain number. A name that SI has not is a unit of its own."""
    found: dict[str, Fraction] = {}
    text, at = unit.strip() or "1", 0
    while at < len(text):
        match = _FACTOR.match(text, at)
        if match is None:
            raise DesignError(f"{unit[:80]!r} is not a unit in SI")
        sign, name, power, small = match.groups()
        times = Fraction(power) if power else Fraction(_POWERS.get(small, 1))
        times = -times if sign == "/" else times
        for base, each in _BASE.get(name, {name: 1}).items():
            found[base] = found.get(base, Fraction(0)) + each * times
        at = match.end()
    found.pop("1", None)
    return _sorted(found.items())


def product(one: Dimension, other: Dimension, power: Fraction | int = 1) -> Dimension:
    """Of one times the other to a power."""
    if not other:
        return one
    found = dict(one)
    for base, each in other:
        found[base] = found.get(base, Fraction(0)) + each * power
    return _sorted(found.items())


def unit_text(dimension: Dimension) -> str:
    """The unit as lamc writes it, "N·m/rad"; "1" for a plain number."""
    known = _named().get(dimension)
    if known is not None:
        return known.unit.replace("*", "·").replace("^2", "²").replace("^3", "³") or "1"
    up = [f"{base}{_power(power)}" for base, power in dimension if power > 0]
    down = [f"/{base}{_power(-power)}" for base, power in dimension if power < 0]
    return ("·".join(up) or "1") + "".join(down)


def in_words(dimension: Dimension) -> str:
    """ "a length (m)", "a plain number", "m²/s"."""
    if not dimension:
        return "a plain number"
    known = _named().get(dimension)
    if known is None:
        return unit_text(dimension)
    return f"{with_article(known.name)} ({unit_text(dimension)})"


@lru_cache(maxsize=1)
def _named() -> Mapping[Dimension, Quantity]:
    """Quantities that people have a name for; where two have one dimension, the first."""
    found: dict[Dimension, Quantity] = {dimension_of("N*m"): Quantity("torque", "N*m", "2 N*mm")}
    kinds = (
        "LENGTH",
        "ANGLE",
        "ANGLE_RATE",
        "DENSITY",
        "STIFFNESS",
        "DAMPING",
        "DURATION",
        "MASS",
        "INERTIA",
    )
    for name in (*kinds, "FORCE", "LINE_FORCE", "PRESSURE", "ACCELERATION", "CURVATURE", "LINE_STIFFNESS"):
        kind: Quantity = getattr(units, name)
        found.setdefault(dimension_of(kind.unit), kind)
    return found


def _sorted(powers: Iterable[tuple[str, Fraction]]) -> Dimension:
    return tuple(sorted((base, power) for base, power in powers if power))


def _power(power: Fraction) -> str:
    small = {1: "", 2: "²", 3: "³"}
    return small[int(power)] if power in small else f"^{float(power):g}"
