"""Parameters that a scene gives values: those of hinges and masses go into the mechanism itself.

In: a mechanism and a scene with `parameters`. Out: the mechanism with these numbers, so that all that is made of it
has them, exports and cross-checks too; and the names that are left to the compiled model. Never: knows an effect.
"""

from collections.abc import Mapping
from dataclasses import replace

from lamc.basics.errors import DesignError
from lamc.basics.si_units import in_unit
from lamc.records.mechanism import Body, Joint, Mechanism
from lamc.records.scene import Scene

_OF_JOINT = {"stiffness": "N·m/rad", "damping": "N·m·s/rad", "rest_angle": "rad"}
_LIMITS = ("lower_limit", "upper_limit")


def with_values(mechanism: Mechanism, scene: Scene) -> Mechanism:
    """The mechanism with what the scene says of hinges (stiffness, damping, rest_angle, lower_limit, upper_limit) and
    of masses; itself where it says nothing. Raises DesignError for numbers that they cannot have."""
    if not scene.parameters:
        return mechanism
    joints = tuple(_joint(joint, scene.parameters) for joint in mechanism.joints)
    bodies = tuple(_body(body, scene.parameters) for body in mechanism.bodies)
    if joints == mechanism.joints and all(a is b for a, b in zip(bodies, mechanism.bodies, strict=True)):
        return mechanism
    return replace(mechanism, joints=joints, bodies=bodies)


def left_to_model(mechanism: Mechanism, scene: Scene) -> tuple[str, ...]:
    """Names of the scene's parameters that are none of the mechanism's own, and no inputs."""
    owned = {f"{joint.name}.{what}" for joint in mechanism.joints for what in (*_OF_JOINT, *_LIMITS)}
    owned |= {f"{body.name}.mass" for body in mechanism.bodies} | set(scene.inputs)
    return tuple(name for name in scene.parameters if name not in owned)


def _joint(joint: Joint, values: Mapping[str, float | str]) -> Joint:
    said = {what: _number(values, f"{joint.name}.{what}", unit) for what, unit in _OF_JOINT.items()}
    changed: dict[str, object] = {what: number for what, number in said.items() if number is not None}
    ends = [_number(values, f"{joint.name}.{what}", "rad") for what in _LIMITS]
    if any(end is not None for end in ends):
        changed["limits"] = tuple(
            old if end is None else end for end, old in zip(ends, joint.limits, strict=True)
        )
    return replace(joint, **changed) if changed else joint  # type: ignore[arg-type]


def _body(body: Body, values: Mapping[str, float | str]) -> Body:
    mass = _number(values, f"{body.name}.mass", "kg")
    return body if mass is None else replace(body, mass=mass)


def _number(values: Mapping[str, float | str], name: str, unit: str) -> float | None:
    value = values.get(name)
    if not isinstance(value, str):
        return value
    try:
        return in_unit(value, unit, "number")
    except DesignError as error:
        raise DesignError(f"the parameter {name!r} of the scene: {error.message}") from error
