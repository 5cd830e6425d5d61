"""Numbers with units, as people write them in designs: `25 um`, `3 N*mm/deg`, `1.6 g/cm^3`.

In: text or a bare number, and the quantity that is expected. Out: a float in SI (angles in radians). The text
passes a narrow grammar before pint sees the unit part: no length, character or exponent can keep it busy.
"""

import math
import re
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

from lamc.basics.common_units import COMMON
from lamc.basics.errors import DesignError
from lamc.basics.once import remembered

LONGEST = 80
LARGEST = 1e30  # in SI; products of what is below it stay within floating point
_ROUND_OFF = 1e-14

_QUANTITY = re.compile(
    r"\s*(?P<number>[-+]?(?:\.[0-9]+|[0-9]+(?:\.[0-9]*)?)(?:[eE][-+]?[0-9]{1,4})?)\s*(?P<unit>.*?)\s*\Z",
    re.DOTALL,
)
_REPR = re.compile(r"(?:np|numpy)\.[a-z0-9]+\(")  # np.float64(0.5), from a list that a program wrote
# A product of unit names with one-digit powers, groups in parentheses one level deep. No power of a power and
# no bare number gets through: pint would spend years on m^9^9^9.
_FACTOR = r"[A-Za-zµμ°]+(?: ?(?:\^|\*\*) ?-?[0-9])?"
_PRODUCT = rf"{_FACTOR}(?:(?: ?[*/·] ?| ){_FACTOR})*"
_TERM = rf"(?:{_FACTOR}|\({_PRODUCT}\))"
_UNIT = re.compile(rf"{_TERM}(?:(?: ?[*/·] ?| ){_TERM})*\Z")
_FORMULA = re.compile(r"\w\(|\s[+-]\s")  # of an expression: a function, a sum


@dataclass(frozen=True)
class Quantity:
    """A kind of number: its name in errors, its SI unit, and an example for people."""

    name: str
    unit: str
    example: str


LENGTH = Quantity("length", "m", "25 um")
ANGLE = Quantity("angle", "rad", "45 deg")
ANGLE_RATE = Quantity("angular rate", "rad/s", "90 deg/s")
DENSITY = Quantity("density", "kg/m^3", "1.6 g/cm^3")
MODULUS = Quantity("modulus", "Pa", "70 GPa")
STIFFNESS = Quantity("hinge stiffness", "N*m/rad", "3 N*mm/deg")
DAMPING = Quantity("hinge damping", "N*m*s/rad", "2e-6 N*m*s/rad")
DURATION = Quantity("duration", "s", "0.5 s")
MASS = Quantity("mass", "kg", "12 mg")
INERTIA = Quantity("moment of inertia", "kg*m^2", "3 g*mm^2")
RATIO = Quantity("ratio", "", "0.3")
PLY_ANGLE = Quantity("ply angle", "deg", "45 deg")  # degrees stay degrees: 30° is 30 to the last digit
FORCE = Quantity("force", "N", "2 mN")
LINE_FORCE = Quantity("force per length", "N/m", "0.5 N/mm")
LINE_MOMENT = Quantity("moment per length", "N", "2 N*mm/mm")
LINE_STIFFNESS = Quantity("hinge stiffness per length", "N/rad", "3 N*mm/mm/rad")
CURVATURE = Quantity("curvature", "m^-1", "0.2 mm^-1")
PRESSURE = Quantity("pressure", "Pa", "3 kPa")
ACCELERATION = Quantity("acceleration", "m/s^2", "9.81 m/s^2")
WARMING = Quantity("rise in temperature", "K", "-150 K")
WARMING_GRADIENT = Quantity("gradient of temperature", "K/m", "20 K/mm")
MOISTURE_GRADIENT = Quantity("gradient of moisture", "m^-1", "0.1 mm^-1")
FOUNDATION = Quantity("stiffness of a foundation", "N/m^3", "2 MPa/mm")
EXPANSION = Quantity("thermal expansion", "K^-1", "22e-6 K^-1")
STRAIN_PER_FIELD = Quantity("piezoelectric strain", "m/V", "-190 pm/V")
ELECTRIC_FIELD = Quantity("electric field", "V/m", "0.5 kV/mm")

EXAMPLES = {
    q.unit: q.example for q in list(globals().values()) if isinstance(q, Quantity) and q.unit
}  # by unit


def to_si(value: object, quantity: Quantity, bare_unit: str | None = None) -> float:
    """`value` in SI.

    value      a number, or text: a number and a unit
    bare_unit  the unit of a number that has none; SI if None

    Raises DesignError for what is no number, not finite, or of another dimension.
    """
    if isinstance(value, bool) or not isinstance(value, int | float | str):
        raise DesignError(
            f"{_shown(value)} is not {with_article(quantity.name)}; write a number in "
            f"{bare_unit or quantity.unit or 'plain form'}, or with its unit, such as {quantity.example!r}"
        )
    if isinstance(value, str):
        number, unit = _split(value, quantity)
    else:
        number, unit = _as_float(value), ""
    if not math.isfinite(number):
        raise DesignError(f"the {quantity.name} is {number!r}; it must be finite")
    return _scaled(number, unit or bare_unit or quantity.unit, quantity)


def with_article(noun: str) -> str:
    return f"{'an' if noun[0] in 'aeiou' else 'a'} {noun}"


def length_unit(text: object) -> str:
    """`text` if it is a unit of length and nothing else, or DesignError."""
    if not isinstance(text, str) or not text.strip() or text.strip()[0].isdigit():
        raise DesignError(f"{_shown(text)} is not a unit of length; write one such as mm")
    check_unit(text, LENGTH)
    _factor(text, LENGTH)
    return text


def _as_float(value: int | float) -> float:
    try:
        return float(value)
    except OverflowError:
        return math.inf


@lru_cache(maxsize=4096)  # files are full of the same few, and studies read them again and again
def _split(text: str, quantity: Quantity) -> tuple[float, str]:
    if len(text) > LONGEST:
        raise DesignError(
            f"{with_article(quantity.name)} of {len(text)} characters; at most {LONGEST} are allowed"
        )
    match = _QUANTITY.match(text)
    if match is None and _REPR.match(text):
        raise DesignError(
            f"{text!r} is how Python shows a number of numpy's; where the text is made, write float(x) or f'{{x:.9g}}'"
        )
    if match is None:
        raise DesignError(
            f"{text!r} is not {with_article(quantity.name)}; write a number and a unit, such as {quantity.example!r}"
        )
    unit = match["unit"]
    check_unit(unit, quantity)
    return float(match["number"]), unit


def is_quantity(text: str) -> bool:
    """Whether the text reads as a number, with a unit or without; whether there is such a unit is not asked."""
    match = _QUANTITY.match(text) if len(text) <= LONGEST else None
    return match is not None and (
        not match["unit"] or _UNIT.match(" ".join(match["unit"].split())) is not None
    )


def check_unit(unit: str, quantity: Quantity) -> None:
    """Refuses what pint should not see."""
    if len(unit) > LONGEST:
        raise DesignError(f"a unit of {len(unit)} characters; at most {LONGEST} are allowed")
    if re.match(r",\s*[0-9]", unit):
        raise DesignError(f"{unit!r} behind a number is no unit; numbers have a decimal point, as in 0.5")
    if unit and not _UNIT.match(" ".join(unit.split())):
        if _FORMULA.search(unit):
            raise DesignError(
                f"{unit!r} is not a unit of {quantity.name}; a unit stands behind a number alone, as in "
                f"{quantity.example!r}: write an expression without units"
            )
        raise DesignError(
            f"{unit!r} is not a unit of {quantity.name}; write unit names with * / and small whole powers, "
            f"such as in {quantity.example!r}"
        )


def _scaled(number: float, unit: str, quantity: Quantity) -> float:
    by, divides = _scale(unit, quantity)
    result = number / by if divides else number * by
    if not abs(result) < LARGEST:
        raise DesignError(
            f"the {quantity.name} {number!r} {unit} is {LARGEST:g} {quantity.unit} or more; no design is"
        )
    return result


@lru_cache(maxsize=1024)
def _scale(unit: str, quantity: Quantity) -> tuple[float, bool]:
    """What takes a number from `unit` to SI, and whether it divides."""
    factor = 1.0 if unit == quantity.unit else _factor(unit, quantity)
    # pint's factors carry round-off (g/cm^3 is 999.9999999999999 kg/m^3); those of SI prefixes are whole, or
    # one over a whole number. Dividing by a whole number rounds once: 19.8 mm is 0.0198 m to the last digit.
    if factor >= 1.0:
        whole = round(factor)
        return (whole if abs(whole / factor - 1.0) < _ROUND_OFF else factor), False
    whole = round(min(1.0 / factor, 1e18))
    return (whole, True) if abs(whole * factor - 1.0) < _ROUND_OFF else (factor, False)


@lru_cache(maxsize=1024)
def _factor(unit: str, quantity: Quantity) -> float:
    """How many SI units one `unit` is. Raises DesignError for an unknown unit or another dimension."""
    common = COMMON.get((unit, quantity.unit))
    return common if common is not None else _asked(unit, quantity)


def _asked(unit: str, quantity: Quantity) -> float:
    """The same by pint."""
    known = registry()
    try:
        given = known.parse_units(unit.replace("°", "degree").replace("·", "*"))
    except Exception as error:  # pint's tokenizer and evaluator fail in many ways, all meaning the same here
        raise DesignError(
            f"{unit!r} is not a unit that lamc knows; {with_article(quantity.name)} looks like {quantity.example!r}"
        ) from error
    expected = known.parse_units(quantity.unit)
    if given.dimensionality != expected.dimensionality:
        raise DesignError(
            f"{unit!r} is not a unit of {quantity.name}; expected {quantity.unit or 'a plain number'} "
            f"or the like, such as {quantity.example!r}"
        )
    if _angles(given) != _angles(expected):
        # Angles have no dimension, so that N*mm would pass for N*mm/rad where N*mm/deg was meant, and Hz for rad/s.
        reported = "names no angle" if _angles(expected) else "names an angle"
        raise DesignError(
            f"{unit!r} {reported}, and {with_article(quantity.name)} is in {quantity.unit or 'plain form'} or the "
            f"like: write it such as {quantity.example!r}"
        )
    try:
        factor = float(known.Quantity(1.0, given).to(expected).magnitude)
    except Exception as error:  # offset and logarithmic units (degC, dB) refuse plain scaling
        raise DesignError(f"{unit!r} cannot be used as a unit of {quantity.name}") from error
    if not math.isfinite(factor) or factor <= 0.0:
        raise DesignError(f"{unit!r} cannot be used as a unit of {quantity.name}; its size is {factor!r}")
    return factor


def _angles(unit: Any) -> float:
    """The power of angle in a unit: -1 for N*mm/deg. 0 for one that cannot be scaled, which fails later."""
    try:
        return float(dict(registry().Quantity(1.0, unit).to_root_units().unit_items()).get("radian", 0))
    except Exception:  # offset and logarithmic units
        return 0.0


@remembered  # units of one registry mean nothing to another
def registry() -> Any:
    """pint's registry, made when the first unit is met: importing it costs half a second."""
    import pint

    return pint.UnitRegistry()


def _shown(value: object) -> str:
    text = repr(value)
    return text if len(text) <= 40 else text[:39] + "…"
