"""Values of parameters that a run may change: numbers that nature allows.

In: parameters by name and the names a model has. Out: floats, or a RequestError with name, value and rule. Which
quantity a parameter is follows from the end of its name, as `link_1.mass`. Never: looks at defaults.
"""

from collections.abc import Mapping
from typing import NamedTuple

from lamc.errors import RequestError
from lamc.mechanism.checks import shown
from lamc.run.request import did_you_mean, finite


class _Rule(NamedTuple):
    what: str
    may_be_zero: bool


_RULES: Mapping[str, _Rule] = {
    "mass": _Rule("a mass", may_be_zero=False),
    "stiffness": _Rule("a stiffness", may_be_zero=True),
    "damping": _Rule("a damping", may_be_zero=True),
    "inertia_xx": _Rule("a moment of inertia", may_be_zero=True),
    "inertia_yy": _Rule("a moment of inertia", may_be_zero=True),
    "inertia_zz": _Rule("a moment of inertia", may_be_zero=True),
}


def checked_parameters(wanted: object, units: Mapping[str, str]) -> dict[str, float]:
    """`wanted` by name; `units` are the model's, by the names it has.

    Raises RequestError for what is no mapping, a name that is not there, a value that is no finite number, and one
    that its quantity cannot have.
    """
    if not isinstance(wanted, Mapping):
        raise RequestError(
            f"parameters is {shown(wanted)}; it must map names to numbers, and may be left out for the defaults"
        )
    return {name: _value(name, value, units) for name, value in wanted.items()}


def _value(name: str, value: object, units: Mapping[str, str]) -> float:
    if name not in units:
        raise RequestError(f"no parameter is named {shown(name)}; {did_you_mean(name, units)}")
    number = finite(value, f"parameter {name!r}", f"a number in {units[name]}")
    rule = _RULES.get(name.rpartition(".")[2])
    if rule is not None and (number < 0.0 or (number == 0.0 and not rule.may_be_zero)):
        bound = "zero or more" if rule.may_be_zero else "above zero"
        raise RequestError(f"parameter {name!r} is {number:g} {units[name]}; {rule.what} must be {bound}")
    return number
