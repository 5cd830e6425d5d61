"""Units of computed numbers: what a product, a quotient or a power of SI quantities has.

In: the text of SI units as lamc writes them, "N·m/rad". Out: `Unit`s that multiply, and their text. Angles are a unit
of their own, as everywhere in lamc. Never: scales a number; `factor_of` tells how.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction

from lamc.basics.common_units import COMMON
from lamc.basics.errors import DesignError
from lamc.basics.si_units import si_unit

Powers = tuple[tuple[str, Fraction], ...]  # of base units, sorted by name

_DERIVED: Mapping[str, Mapping[str, int]] = {
    "N": {"kg": 1, "m": 1, "s": -2},
    "J": {"kg": 1, "m": 2, "s": -2},
    "W": {"kg": 1, "m": 2, "s": -3},
    "Pa": {"kg": 1, "m": -1, "s": -2},
    "V": {"kg": 1, "m": 2, "s": -3, "A": -1},
    "Hz": {"s": -1},
    "C": {"A": 1, "s": 1},
    "Ω": {"kg": 1, "m": 2, "s": -3, "A": -2},
}
_WRITTEN = ("N", "J", "W", "Pa", "V", "N/m", "N/rad", "J/rad", "J·s/rad", "m/s", "m/s²", "rad/s", "rad/s²")
_ATOM = re.compile(r"([^·/²³^0-9]+)(²|³|\^-?[0-9.]+)?\Z")
_SIGNS = {"²": Fraction(2), "³": Fraction(3)}
_COMMON = {text: (si, factor) for (text, si), factor in COMMON.items() if si != "deg" and text.isalpha()}


@dataclass(frozen=True)
class Unit:
    """powers: of base units; text: how it is written."""

    powers: Powers
    text: str

    def __mul__(self, other: "Unit") -> "Unit":
        if not other.powers:
            return self
        return other if not self.powers else _unit(_sum(self.powers, other.powers, 1))

    def __truediv__(self, other: "Unit") -> "Unit":
        return self if not other.powers else _unit(_sum(self.powers, other.powers, -1))

    def __pow__(self, exponent: Fraction) -> "Unit":
        return self if exponent == 1 else _unit(tuple((name, p * exponent) for name, p in self.powers))

    def is_like(self, other: "Unit") -> bool:
        """Whether numbers of both can be added."""
        return self.powers == other.powers


def unit_of(text: str) -> Unit:
    """The unit of an SI text such as "N·m/rad"; "1" is none."""
    powers: Powers = ()
    for k, divided in enumerate(text.strip().replace("*", "·").split("/")):
        for atom in divided.split("·"):
            match = _ATOM.match(atom.strip())
            if match is None or atom.strip() == "1":
                continue
            name, sign = match[1].strip(), match[2] or ""
            power = _SIGNS.get(sign) or Fraction(sign[1:] or "1").limit_denominator(12)
            base = _DERIVED.get(name, {name: 1})
            factors = tuple(sorted((part, power * count) for part, count in base.items()))
            powers = _sum(powers, factors, -1 if k else 1)
    return Unit(powers, text.strip() or "1")


def factor_of(word: str) -> tuple[float, Unit]:
    """How many of the SI unit a unit of one word is, "mm": 0.001, and the SI unit. Raises DesignError for no unit."""
    if word in _COMMON:
        text, factor = _COMMON[word][0], _COMMON[word][1]
        return factor, unit_of(text)
    found = si_unit(word)
    return found.factor, unit_of(found.text)


def is_unit(word: str) -> bool:
    """Whether the word is a unit."""
    try:
        factor_of(word)
    except DesignError:
        return False
    return True


def _sum(one: Powers, other: Powers, sign: int) -> Powers:
    powers = dict(one)
    for name, power in other:
        powers[name] = powers.get(name, Fraction(0)) + sign * power
    return tuple(sorted((name, power) for name, power in powers.items() if power))


def _unit(powers: Powers) -> Unit:
    for text in _WRITTEN:
        if unit_of(text).powers == powers:
            return Unit(powers, text)
    above = "·".join(_written(name, power) for name, power in powers if power > 0)
    below = "".join(f"/{_written(name, -power)}" for name, power in powers if power < 0)
    return Unit(powers, (above or "1") + below)


def _written(name: str, power: Fraction) -> str:
    sign = {Fraction(1): "", Fraction(2): "²", Fraction(3): "³"}.get(power)
    return name + (f"^{float(power):g}" if sign is None else sign)


PLAIN, RADIAN, SECOND = unit_of("1"), unit_of("rad"), unit_of("s")
