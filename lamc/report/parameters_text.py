"""The parameters of a design, in a line and as plain data.

In: `DesignParameter`s by name. Out: text, lengths in mm below 1 m and angles in degrees; numbers, SI.
"""

import math
from collections.abc import Mapping
from typing import Any

from lamc.basics.numbers import shortened
from lamc.records.parameters import DesignParameter

_MOST = 12  # in a line


def parameters_line(parameters: Mapping[str, DesignParameter]) -> str:
    """ "length 40 mm, tilt 30°"; empty where there are none."""
    said = [f"{shortened(name, 24)} {_value(each)}" for name, each in list(parameters.items())[:_MOST]]
    return ", ".join(said) + (f", … ({len(parameters)} in all)" if len(parameters) > _MOST else "")


def parameters_data(parameters: Mapping[str, DesignParameter]) -> dict[str, Any]:
    """By name: value, unit, minimum, maximum and meaning."""
    return {
        name: {
            "value": each.default,
            "unit": each.unit,
            "minimum": each.minimum,
            "maximum": each.maximum,
            "meaning": each.meaning,
        }
        for name, each in parameters.items()
    }


def _value(parameter: DesignParameter) -> str:
    value = parameter.default
    if parameter.unit == "rad":
        return f"{math.degrees(value):.6g}°"
    if parameter.unit == "m" and abs(value) < 1.0:
        return f"{1e3 * value:.6g} mm"
    return f"{value:.6g}" + ("" if parameter.unit == "1" else f" {parameter.unit}")
