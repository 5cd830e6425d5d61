"""Units as FMI defines them: exponents of SI base units.

In: a unit as lamc writes it, such as "N·m·s/rad". Out: exponents of kg, m, s, A, K and rad, or nothing where FMI, which
knows whole exponents only, has no definition for it. Never: a factor; all of lamc's numbers are SI.
"""

import re
from collections.abc import Mapping

BASE = ("kg", "m", "s", "A", "K", "mol", "cd", "rad")

_BY_SYMBOL: Mapping[str, Mapping[str, int]] = {
    **{symbol: {symbol: 1} for symbol in BASE},
    "1": {},
    "N": {"kg": 1, "m": 1, "s": -2},
    "J": {"kg": 1, "m": 2, "s": -2},
    "W": {"kg": 1, "m": 2, "s": -3},
    "Hz": {"s": -1},
    "C": {"s": 1, "A": 1},
    "F": {"kg": -1, "m": -2, "s": 4, "A": 2},
    "H": {"kg": 1, "m": 2, "s": -2, "A": -2},
    "T": {"kg": 1, "s": -2, "A": -1},
    "Pa": {"kg": 1, "m": -1, "s": -2},
    "V": {"kg": 1, "m": 2, "s": -3, "A": -1},
    "Ω": {"kg": 1, "m": 2, "s": -3, "A": -2},
}
_FACTOR = re.compile(r"([A-Za-zΩ1]+)(?:\^(\d+)|([²³]))?")
_RAISED = {"²": 2, "³": 3}


def base_units(unit: str) -> dict[str, int] | None:
    """Exponents that are not zero, in the order of BASE; None where the unit is not a product of whole powers."""
    total = dict.fromkeys(BASE, 0)
    for sign, factor in _factors(unit):
        match = _FACTOR.fullmatch(factor)
        known = _BY_SYMBOL.get(match[1]) if match else None
        if match is None or known is None:
            return None
        power = int(match[2] or _RAISED.get(match[3], 1))
        for symbol, exponent in known.items():
            total[symbol] += sign * power * exponent
    return {symbol: exponent for symbol, exponent in total.items() if exponent}


def _factors(unit: str) -> list[tuple[int, str]]:
    """Factors with 1, those behind a stroke with -1; a pair of brackets may stand behind the stroke."""
    over, stroke, under = unit.replace("*", "·").partition("/")
    below = under.removeprefix("(").removesuffix(")").replace("/", "·") if stroke else ""
    return [(1, f) for f in over.split("·")] + [(-1, f) for f in below.split("·") if f]
