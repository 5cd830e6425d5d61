"""Units of computed numbers: what a product, a quotient or a power of SI quantities has.

In: the text of SI units as lamc writes them, "N·m/rad". Out: `Unit`s that multiply, and their text. Never: scales a
number; `factor_of` tells how.
"""

from dataclasses import dataclass
from fractions import Fraction

from lamc.basics.common_units import COMMON
from lamc.basics.dimensions import PLAIN as NOTHING
from lamc.basics.dimensions import Dimension, dimension_of, product, unit_text
from lamc.basics.errors import DesignError
from lamc.basics.si_units import si_unit

_ENERGY, _POWER = dimension_of("J"), dimension_of("W")
_COMMON = {text: (si, factor) for (text, si), factor in COMMON.items() if si != "deg" and text.isalpha()}


@dataclass(frozen=True)
class Unit:
    """dimension: powers of base units; text: how it is written."""

    dimension: Dimension
    text: str

    def __mul__(self, other: "Unit") -> "Unit":
        if not other.dimension:
            return self
        return other if not self.dimension else _unit(product(self.dimension, other.dimension))

    def __truediv__(self, other: "Unit") -> "Unit":
        return self if not other.dimension else _unit(product(self.dimension, other.dimension, -1))

    def __pow__(self, exponent: Fraction) -> "Unit":
        return self if exponent == 1 else _unit(product(NOTHING, self.dimension, exponent))

    def is_like(self, other: "Unit") -> bool:
        """Whether numbers of both can be added."""
        return self.dimension == other.dimension


def unit_of(text: str) -> Unit:
    """The unit of an SI text such as "N·m/rad"; "1" is none."""
    return Unit(dimension_of(text), text.strip() or "1")


def factor_of(word: str) -> tuple[float, Unit]:
    """How many of the SI unit a unit of one word is, "mm": 0.001, and the SI unit. Raises DesignError for no unit."""
    if word in _COMMON:
        text, factor = _COMMON[word]
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


def _unit(dimension: Dimension) -> Unit:
    known = {_ENERGY: "J", _POWER: "W"}  # what runs tell of these dimensions is no torque
    return Unit(dimension, known.get(dimension) or unit_text(dimension))


PLAIN, RADIAN, SECOND = unit_of("1"), unit_of("rad"), unit_of("s")
