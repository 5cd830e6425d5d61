"""Effects in files: numbers with units, fields by name, and refusals that point at the part at fault."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated

import pytest

from lamc.basics.errors import DesignError
from lamc.basics.number_text import is_measured
from lamc.basics.quantity_fields import Unit
from lamc.effects import Gravity, JointLimits, Spring, Torque
from lamc.effects.data import DataError, file_context, validated
from lamc.readers.effect_calls import make_effect

SPRING = {"body_a": "a", "point_a": (0, 0, 0), "body_b": "b", "point_b": (1, 0, 0), "stiffness": 1}


@pytest.mark.parametrize(
    ("value", "unit", "si"),
    [
        (2, "N*m/rad", 2.0),
        ("3 N*mm/deg", "N·m/rad", 3e-3 * 180 / math.pi),  # 3e-3 N·m per π/180 rad
        ("2.5 mm", "m", 2.5e-3),
        ("0.6", "1", 0.6),
        ("12 g*mm^2", "kg·m²", 12e-9),
    ],
)
def test_a_quantity_is_read_in_si(value: object, unit: str, si: float) -> None:
    # one rounding in the unit's factor and one in the product
    assert Unit(unit).number(value, "stiffness") == pytest.approx(si, rel=1e-15)


def test_a_bare_length_counts_in_the_unit_of_its_file() -> None:
    context = file_context("um")
    assert Unit("m").number(25, "width", context) == 25e-6
    assert Unit("m").number(25, "width", file_context()) == 25.0
    assert Unit("N/m").number(25, "stiffness", context) == 25.0
    data = {"body_a": "a", "point_a": [1, "1 m", 0], "body_b": "b", "point_b": [0, 0, 0], "stiffness": 1}
    assert make_effect("spring", data, "x", context).point_a == (1e-6, 1.0, 0.0)  # type: ignore[attr-defined]


@pytest.mark.parametrize(
    "value", ["3 kg", "x", "1 N*m/rad/s", True, None, [], {}, math.nan, math.inf, "1e999", 10**400]
)
def test_what_is_no_such_quantity_is_refused_with_its_field(value: object) -> None:
    with pytest.raises(DataError) as caught:
        make_effect("spring", SPRING | {"stiffness": value}, "scene.effects.stop")
    assert caught.value.message.startswith("scene.effects.stop.stiffness: ")
    assert caught.value.path == ("stiffness",)


def test_effects_take_units_in_files() -> None:
    # the same numbers as in SI: prefixes are whole powers of ten, and a division rounds once
    assert make_effect("gravity", ["0 m/s^2", 0, "-981 cm/s^2"], "x") == Gravity((0.0, 0.0, -9.81))
    assert make_effect("joint_limits", {"stiffness": "2 N*mm/rad", "damping": 1e-6}, "x") == JointLimits(
        2e-3, 1e-6
    )
    given = {
        "body_a": "a",
        "point_a": ["1 mm", 0, 0],
        "body_b": "b",
        "point_b": [0, 0, 0],
        "stiffness": "4 N/mm",
    }
    assert make_effect("spring", given, "x") == Spring("a", (1e-3, 0.0, 0.0), "b", (0.0, 0.0, 0.0), 4000.0)
    assert make_effect("torque", {"h": "2 mN*m", "k": "2*t"}, "x") == Torque({"h": 2e-3, "k": "2*t"})


@pytest.mark.parametrize(
    ("name", "value", "said"),
    [
        ("gravty", None, "x: no effect is named 'gravty'; did you mean 'gravity'?"),
        ("joint_limits", {"stifness": 1}, "x.stifness: joint_limits has no field 'stifness'; did you mean 'stif"),
        ("joint_limits", {"stiffness": "1 N/m"}, "x.stiffness: 'N/m' is not a unit of stiffness; expected N*m/rad"),
        ("joint_limits", {"stiffness": "1 N*mm"}, "x.stiffness: 'N*mm' names no angle"),
        ("joint_limits", {"stiffness": -1}, "x.stiffness: the stiffness is -1 N*m/rad; it must be above 0"),
        ("joint_limits", 3, "x: joint_limits is 3; give a map of its fields: stiffness, damping"),
        ("gravity", ["1 m", 0, 0], "x[0]: 'm' is not a unit of acceleration"),
        ("spring", {"body_a": "a"}, "x: spring needs point_a and body_b and point_b and stiffness: give body_a, "),
        ("hinge_stiffness", 3, "x: hinge_stiffness takes no value"),
        ("torque", {"h": "3 kg"}, "x.h: 'kg' is not a unit of torque of 'h'; expected N*m"),
        ("torque", {"h": "3 N*mm*sin(t)"}, "x.h: 'N*mm*sin(t)' is not a unit of torque of 'h'; a unit stands behind"),
        ("torque", {"h": "3 N*mm - 1"}, "x.h: 'N*mm - 1' is not a unit of torque of 'h'; a unit stands behind"),
        ("torque", 3, "x: torques is 3; give a map from names to numbers (N*m)"),
        ("torque", {"h": "3*x()"}, "x.h: the torque of joint 'h': expression '3*x()', column 3: 'x' is not known"),
    ],
)  # fmt: skip
def test_data_that_does_not_fit_is_refused_with_the_way_out(name: str, value: object, said: str) -> None:
    with pytest.raises(DesignError) as caught:
        make_effect(name, value, "x")
    assert caught.value.message.startswith(said)


@pytest.mark.parametrize("text", ["3 N*mm", "-2e-3 N*m", ".5N*m", "1 (N*m)", "3 µN*m"])
def test_a_number_with_a_unit_is_no_expression(text: str) -> None:
    assert is_measured(text)


@pytest.mark.parametrize("text", ["3*sin(t)", "3", "1e-3", "sin(3 * t)", "-1e3*rate", "2 + t", "t"])
def test_an_expression_is_no_number_with_a_unit(text: str) -> None:
    assert not is_measured(text)


def test_a_record_of_ones_own_is_read_by_its_units() -> None:
    @dataclass(frozen=True)
    class Table:
        table: Annotated[Mapping[str, tuple[float, ...]], Unit("deg")]
        kind: str = "cubic"

    read = validated(Table, {"table": {"a": [1, f"{math.pi} rad"]}, "kind": "line"}, "x")
    # pi has 16 digits in the text, and the unit's factor is rounded once
    assert read == {"table": {"a": (1.0, pytest.approx(180.0, rel=1e-15))}, "kind": "line"}
