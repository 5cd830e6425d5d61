"""Values of parameters that a run may change: numbers that nature allows.

In: parameters by name and the names a model has. Out: floats, or a RequestError with name, value and rule. Which
quantity a parameter is follows from the end of its name, as `link_1.mass` or `wing.air.density`. Never: looks at
defaults.
"""

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from lamc.basics.checks import shown
from lamc.basics.errors import DesignError, RequestError
from lamc.basics.si_units import in_unit
from lamc.mechanics.compliant_hinge import CROSS_FREEDOMS
from lamc.records.mechanism import Joint, Mechanism
from lamc.run.request import did_you_mean, finite


class _Rule(NamedTuple):
    what: str
    may_be_zero: bool
    most: float = math.inf


_RULES: Mapping[str, _Rule] = {
    "mass": _Rule("a mass", may_be_zero=False),
    "stiffness": _Rule("a stiffness", may_be_zero=True),
    "damping": _Rule("a damping", may_be_zero=True),
    "inertia_xx": _Rule("a moment of inertia", may_be_zero=True),
    "inertia_yy": _Rule("a moment of inertia", may_be_zero=True),
    "inertia_zz": _Rule("a moment of inertia", may_be_zero=True),
    "friction": _Rule("a coefficient of friction", may_be_zero=True),
    "static_friction": _Rule("a coefficient of friction", may_be_zero=True),
    "slip_speed": _Rule("a slip speed", may_be_zero=False),
    "restitution": _Rule("a restitution", may_be_zero=False, most=1.0),
    "resistance": _Rule("a resistance", may_be_zero=False),
    "torque_constant": _Rule("the torque constant of a motor", may_be_zero=False),
    "stall_torque": _Rule("the stall torque of a motor", may_be_zero=False),
    "no_load_speed": _Rule("the no-load speed of a motor", may_be_zero=False),
    "nominal_voltage": _Rule("the nominal voltage of a motor", may_be_zero=False),
    "rotor_inertia": _Rule("a moment of inertia", may_be_zero=True),
    "gear_inertia": _Rule("a moment of inertia", may_be_zero=True),
    "backlash": _Rule("a play", may_be_zero=True),
    "gear_stiffness": _Rule("a stiffness", may_be_zero=True),
    "gear_damping": _Rule("a damping", may_be_zero=True),
    "period": _Rule("a sample time", may_be_zero=False),
    "pressure": _Rule("the pressure of a pouch", may_be_zero=True),
    "dead_band": _Rule("a dead band", may_be_zero=True),
    "air.density": _Rule("a density", may_be_zero=True),
    "air.lift": _Rule("the lift of a wing", may_be_zero=True),
    "air.drag_edge_on": _Rule("a coefficient of drag", may_be_zero=True),
    "air.drag_broadside": _Rule("a coefficient of drag", may_be_zero=True),
    "air.rest_speed": _Rule("a rest speed", may_be_zero=False),
    **{f"cross_stiffness.{f}": _Rule("a stiffness", may_be_zero=True) for f in CROSS_FREEDOMS},
    **{f"cross_damping.{f}": _Rule("a damping", may_be_zero=True) for f in CROSS_FREEDOMS},
    "modal_stiffness.n_n": _Rule("a stiffness", may_be_zero=True),
    "modal_damping.n_n": _Rule("a damping", may_be_zero=True),
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
    if isinstance(value, bool | np.bool_):
        raise RequestError(f"parameter {name!r} is {shown(value)}; it must be a number in {units[name]}")
    if isinstance(value, str):
        try:
            value = in_unit(value, units[name], "number")
        except DesignError as error:
            raise RequestError(f"parameter {name!r}: {error.message}") from error
    number = finite(value, f"parameter {name!r}", f"a number in {units[name]}")
    rule = _rule(name)
    if rule is None:
        return number
    if number < 0.0 or (number == 0.0 and not rule.may_be_zero) or number > rule.most:
        bound = "zero or more" if rule.may_be_zero else "above zero"
        if math.isfinite(rule.most):
            bound += f" and at most {rule.most:g}"
        unit = "" if units[name] == "1" else f" {units[name]}"
        raise RequestError(f"parameter {name!r} is {number:g}{unit}; {rule.what} must be {bound}")
    return number


class Bounds(NamedTuple):
    """What a quantity can be: from `least`, itself left out if `is_open`, to `most`; both may be infinite."""

    least: float
    is_open: bool
    most: float


def bounds(name: str) -> Bounds:
    """Bounds of the parameter of this name; infinite ones where nothing is known of its quantity."""
    rule = _rule(name)
    if rule is None:
        return Bounds(-math.inf, False, math.inf)
    return Bounds(0.0, not rule.may_be_zero, rule.most)


def _rule(name: str) -> _Rule | None:
    """By the last part of the name, or the last two, in which 3_3 is n_n: on the diagonal of a matrix."""
    *_, before, last = ("", *name.split("."))
    row, _, column = last.partition("_")
    return _RULES.get(last) or _RULES.get(f"{before}.{'n_n' if row == column else last}")


def with_limits(mechanism: Mechanism, parameters: Mapping[str, float]) -> Mechanism:
    """The mechanism with the joint limits, rad, that `parameters` (checked) give as `joint.lower_limit` and
    `joint.upper_limit`; itself where they give none. Raises RequestError for limits that no joint can have."""
    if not parameters:
        return mechanism
    joints = tuple(_limited(joint, parameters) for joint in mechanism.joints)
    return mechanism if joints == mechanism.joints else replace(mechanism, joints=joints)


def _limited(joint: Joint, parameters: Mapping[str, float]) -> Joint:
    names = (f"{joint.name}.lower_limit", f"{joint.name}.upper_limit")
    if not any(name in parameters for name in names):
        return joint
    lower, upper = (
        float(parameters.get(name, limit)) for name, limit in zip(names, joint.limits, strict=True)
    )
    try:
        return replace(joint, limits=(lower, upper))
    except DesignError as error:
        raise RequestError(f"parameters: {error}") from error
