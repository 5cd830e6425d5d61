"""Inputs of a scene for the independent cross-checks: effects with numbers written where inputs stand.

In: effects, and values of inputs by name. Out: effects that hold none, so that no cross-check has to know of inputs.
The names are replaced in the text itself, before any parser reads it.
"""

import re
from collections.abc import Iterable, Mapping
from dataclasses import fields, replace
from typing import Any

from lamc.effects.torque import Torque
from lamc.records.effect import overrides
from lamc.records.mechanism import Mechanism

_NAME = re.compile(r"(?<![\w.])[A-Za-z]\w*", re.ASCII)


def with_inputs(
    mechanism: Mechanism, effects: Iterable[Any], inputs: Mapping[str, float | str]
) -> tuple[Any, ...]:
    """The effects as they act while `inputs` have these values, numbers or expressions in t; a torque from outside that
    has none is zero."""
    effects = tuple(effects)
    if not inputs:
        return effects
    constant = {
        name for e in effects if e.name == "torque" for name, v in e.torques.items() if not isinstance(v, str)
    }
    return tuple(_with_inputs(mechanism, effect, inputs, constant) for effect in effects)


def _with_inputs(
    mechanism: Mechanism, effect: Any, inputs: Mapping[str, float | str], constant: set[str]
) -> Any:
    if effect.name == "external_torque":
        joints = effect.joints or [joint.name for joint in mechanism.joints]
        return Torque({name: inputs.get(f"{name}.torque", 0.0) for name in joints if name not in constant})
    if effect.name == "torque":
        torques = {n: inputs.get(f"{n}.torque", v) if n in constant else v for n, v in effect.torques.items()}
        return replace(effect, torques=_written(torques, inputs))
    if not overrides(effect, "drives"):
        return effect
    texts = {drive.text for drive in effect.drives()}
    said = {f.name: getattr(effect, f.name) for f in fields(effect)}
    held = {name: value for name, value in said.items() if _holds(value, texts)}
    return replace(effect, **{name: _written(value, inputs) for name, value in held.items()})


def _holds(value: object, texts: set[str]) -> bool:
    """Whether a field is a drive, or a row of some."""
    parts = value if isinstance(value, tuple) else (value,)
    return any(isinstance(part, str) and part in texts for part in parts)


def _written(value: Any, inputs: Mapping[str, float | str]) -> Any:
    if isinstance(value, str):
        return _NAME.sub(lambda m: f"({inputs[m[0]]})" if m[0] in inputs else m[0], value)
    if isinstance(value, Mapping):
        return {name: _written(each, inputs) for name, each in value.items()}
    return tuple(_written(each, inputs) for each in value) if isinstance(value, tuple) else value
