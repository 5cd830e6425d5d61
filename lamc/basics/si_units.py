"""Units of numbers whose quantity is not known beforehand: to SI, prefix by prefix.

In: the text of a unit, such as "N*mm". Out: the SI unit in which people would write the same, "N·m", and how many of it
the given one is. The text passes the grammar of `units` before pint sees it.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache

from lamc.basics.common_units import COMMON
from lamc.basics.errors import DesignError
from lamc.basics.units import EXAMPLES, Quantity, check_unit, registry, to_si

_ANY = Quantity("input", "", "0.5 N*mm")
_SIGNS: Mapping[str, str] = {"·": "*", "²": "^2", "³": "^3", "Ω": "ohm", "µ": "u", "μ": "u"}
_POWERS = {1: "", 2: "²", 3: "³"}
# Those that need no pint, whose import takes half a second.
_PLAIN = (
    "1",
    "m",
    "rad",
    "s",
    "kg",
    "N",
    "N·m",
    "V",
    "A",
    "Pa",
    "W",
    "J",
    "K",
    "m/s",
    "m/s²",
    "kg/m³",
    "N/rad",
    "rad/s",
    "rad/s²",
)


@dataclass(frozen=True)
class SIUnit:
    """text: of the SI unit, such as "N·m"; "1" for none; factor: how many of it the given unit is."""

    text: str
    factor: float


# Those that designs are mostly written in, as pint would have them.
_COMMON: Mapping[str, SIUnit] = {
    unit: SIUnit(si.replace("*", "·").replace("^2", "²").replace("^3", "³"), factor)
    for (unit, si), factor in COMMON.items()
    if si != "deg" and unit not in ("mg/mm^3", "N/mm^2", "mm^-1")  # which pint makes otherwise
}


def si_unit(text: str) -> SIUnit:
    """The SI unit of `text`. Raises DesignError for what is no unit, or one that cannot be scaled, such as degC."""
    given = text.strip().replace("*", "·").replace("^2", "²").replace("^3", "³")
    if given in ("", *_PLAIN):
        return SIUnit(given or "1", 1.0)
    return _COMMON.get(text.strip()) or _parsed(_spelled(text))


def measured(text: str) -> tuple[float, str]:
    """A number with a unit, "3 N*mm", in SI: 0.003 and "N·m"; one without is plain, and has "1".

    Raises DesignError for what is no number with a unit.
    """
    spelled = _spelled(text)
    number = spelled[: len(spelled) - len(spelled.lstrip("+-.0123456789eE "))]
    while number and not _is_number(number):  # "5 e" of "5 eV" is none
        number = number[:-1]
    unit = si_unit(spelled[len(number) :])
    plain = unit.text if unit.text != "1" else ""
    return to_si(spelled, Quantity("input", _spelled(plain), _ANY.example)), unit.text


def in_unit(text: str, unit: str, name: str) -> float:
    """A number of the quantity `name`, "3 N*mm/deg", in its SI `unit`, "N·m/rad"; one without a unit is in it already.

    Raises DesignError for what is no number of that dimension.
    """
    spelled = "" if unit == "1" else _spelled(unit)
    return to_si(_spelled(text), Quantity(name, spelled, EXAMPLES.get(spelled) or f"0.5 {spelled}".rstrip()))


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def _spelled(text: str) -> str:
    """In the signs that the grammar of units has."""
    for sign, plain in _SIGNS.items():
        text = text.replace(sign, plain)
    return text.strip()


@lru_cache(maxsize=1024)
def _parsed(text: str) -> SIUnit:
    check_unit(text.removeprefix("1/"), _ANY)
    known = registry()
    try:
        given = known.parse_units(text.replace("°", "degree"))
        items = dict(known.Quantity(1.0, given).unit_items())
    except Exception as error:  # pint's tokenizer and evaluator fail in many ways, all meaning the same here
        raise DesignError(
            f"{text!r} is not a unit that lamc knows; a unit looks like 'N*mm' or 'rad/s'"
        ) from error
    factor, powers = 1.0, dict[str, float]()
    for name, power in items.items():
        try:
            size, parts = _rooted(name)
        except Exception as error:  # logarithmic units refuse to be scaled
            raise DesignError(f"{text!r} cannot be used as a unit: {name} has no size") from error
        factor *= size**power
        for part, more in parts.items():
            powers[part] = powers.get(part, 0.0) + more * power
    if not math.isfinite(factor) or factor <= 0.0:
        raise DesignError(f"{text!r} cannot be used as a unit; its size is {factor!r}")
    return SIUnit(_written(powers), 1.0 if abs(factor - 1.0) < 1e-14 else factor)


def _rooted(name: str) -> tuple[float, dict[str, float]]:
    """A single unit: its size, and the SI unit of the same name without a prefix, or its base units."""
    known = registry()
    ((_, stem, _), *_) = known.parse_unit_name(name)
    if known.Quantity(0.0, name).to_base_units().magnitude != 0.0:
        raise ValueError(f"{name} counts from another zero")
    if known.Quantity(1.0, stem).to_base_units().magnitude == 1.0:
        return float(known.Quantity(1.0, name).to(stem).magnitude), {stem: 1.0}
    base = known.Quantity(1.0, name).to_base_units()
    return float(base.magnitude), {unit: float(power) for unit, power in base.unit_items()}


def _written(powers: Mapping[str, float]) -> str:
    """ "N·m/rad": products, then what divides."""
    symbols = {registry().get_symbol(name): power for name, power in powers.items() if power}
    factors = [f"{symbol}{_power(power)}" for symbol, power in symbols.items() if power > 0.0]
    divisors = [f"/{symbol}{_power(-power)}" for symbol, power in symbols.items() if power < 0.0]
    return ("·".join(factors) or "1") + "".join(divisors)


def _power(power: float) -> str:
    return _POWERS.get(int(power), f"^{power:g}") if power == int(power) else f"^{power:g}"
