"""Expressions that have no value where a run needs one are refused, with the instant; all others pass."""

import math
from pathlib import Path

import mpmath
import numpy as np
import pytest
from hypothesis import assume, event, given, settings
from hypothesis import strategies as st

import lamc
from lamc.basics.errors import ExpressionError, LamcError
from lamc.effects.base_motion import BaseMotion
from lamc.effects.drives import Drive, checked_drive
from lamc.effects.motor import LinearMotor
from lamc.readers.load_scene import scene_of_text
from lamc.symbolic.domain import EVERYWHERE, undefined
from lamc.symbolic.expression import stage
from tests.support.mechanisms import chain
from tests.support.quick import tries

ANY = {"t": (0.0, math.inf), "angle": EVERYWHERE, "rate": EVERYWHERE}


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("sqrt(-1 - t)", "sqrt of -inf to -1"),
        ("sqrt(-2)*t", None),  # a constant part: the reader of expressions refuses it
        ("log(-t)", "log of -inf to -0"),
        ("asin(2 + t)", "asin of 2 to inf"),
        ("acos(-1.5 - angle*angle - sin(t)**2*0)", None),  # angle*angle may be anything to this arithmetic
        ("acos(-1.5 - abs(angle))", "acos of -inf to -1.5"),
        ("(-1 - t)**0.5", "sqrt of"),
        ("(-1 - t)**1.3", "to the power 1.3"),
        ("1/(t - t)", None),  # 0 is known when it is read
        ("exp(1000 + t)", "it is too large for a number"),
    ],
)
def test_what_has_no_value_anywhere_is_found(text: str, reason: str | None) -> None:
    try:
        found = undefined(text, ANY)
    except ExpressionError:
        assert reason is None
        return
    assert (found is None) == (reason is None)
    assert found is None or reason in found.reason


@pytest.mark.parametrize(
    ("text", "reason"),
    [("1/t", "division by zero"), ("log(t)", "log of 0"), ("sqrt(t - 1)", "sqrt of -1"), ("t**-2", "division by zero"),
     ("sin(t)/t", "division by zero"), ("angle/(rate*t)", "division by zero"), ("t**(-1.5)", "0 to the power -1.5")],
)  # fmt: skip
def test_what_has_no_value_at_the_start_is_refused_when_it_is_made(text: str, reason: str) -> None:
    with pytest.raises(ExpressionError) as caught:
        lamc.Torque({"h0": text})
    reported = f"the torque of joint 'h0': expression {text!r} has no value at t = 0 s: {reason}; keep it in its domain"
    assert caught.value.message.startswith(reported)


@pytest.mark.parametrize(
    "text",
    ["sqrt(t)", "1/(t + 1)", "1/angle", "log(rate)", "sqrt(1 - sin(t)**2 - cos(t)**2)", "tan(t)", "max(t, 1)**0.5",
     "atan2(t, angle)", "sqrt(max(1 - t, 0))", "abs(angle)**1.5", "angle**rate", "exp(t)", "cosh(rate)", "sign(t)",
     "1/(1 + exp(2000*(t + 1)))", "1/cosh(800*t)", "1/exp(-800*(t + 1))*exp(-800*(t + 1))"],
)  # fmt: skip
def test_what_may_have_a_value_is_made(text: str) -> None:
    assert checked_drive(Drive("a torque", text, "h")).text == text


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("1/angle", "at the start with angle = 0 rad and rate = 0 rad/s: division by zero"),
        ("log(rate)", "at the start with angle = 0 rad and rate = 0 rad/s: log of 0"),
        ("sqrt(1 - t)", "at t = 1.002 s, within the run of 2 s: sqrt of -0.002"),
        ("1/(1 - t)", "at t = 1 s, within the run of 2 s: division by zero"),
        ("asin(2*t)", "at t = 0.502 s, within the run of 2 s: asin of 1.004"),
        ("exp(800*t)", "at t = 0.888 s, within the run of 2 s: it is too large for a number"),
    ],
)
def test_what_has_no_value_on_the_way_is_refused_before_the_run(text: str, said: str) -> None:
    simulator = lamc.compile(chain(1), lamc.Scene(effects=(lamc.Torque({"h0": text}),)))
    with pytest.raises(ExpressionError) as caught:
        simulator.run(t_end=2.0)
    assert said in caught.value.message


def test_what_overflows_on_the_way_runs() -> None:
    """A switch of logistic form and a pulse: exp and cosh overflow, and their inverses are zero."""
    torques = {"h0": "0.1/(1 + exp(2000*(t - 0.5))) + 0.1/cosh(2000*(t - 0.2))"}
    assert lamc.compile(chain(1), lamc.Scene(effects=(lamc.Torque(torques),))).run(t_end=1.0).success


def test_it_runs_where_it_has_a_value() -> None:
    scene = lamc.Scene(effects=(lamc.Torque({"h0": "1/angle + sqrt(1 - t)"}),), angles={"h0": 1.0})
    assert lamc.compile(chain(1), scene).run(t_end=0.5).success


def test_the_place_in_the_file_is_reported(tmp_path: Path) -> None:
    scene = scene_of_text("with:\n  torque: {h0: sqrt(1 - t)}\n", "s.yaml")
    with pytest.raises(LamcError, match=r"^s\.yaml:2:16: the torque of joint 'h0': expression"):
        lamc.compile(chain(1), scene).run(t_end=2.0)


def test_the_place_is_that_of_the_field(tmp_path: Path) -> None:
    motor = (
        "linear_motor:\n    joint: h0\n    torque_constant: 1\n    resistance: 1\n    voltage: sqrt(1 - t)\n"
    )
    with pytest.raises(LamcError, match=r"^s\.yaml:6:14: the voltage of the motor on joint 'h0': expression"):
        lamc.compile(chain(1), scene_of_text(f"with:\n  {motor}", "s.yaml")).run(t_end=2.0)
    base = "with:\n  base_motion:\n    displacement: [0, 'log(1 - t)', 0]\n"
    with pytest.raises(LamcError, match=r"^s\.yaml:3:19: the y displacement of base_motion: expression"):
        lamc.compile(chain(1), scene_of_text(base, "s.yaml")).run(t_end=2.0)


def test_moved_bases_and_motors_are_looked_at_too() -> None:
    with pytest.raises(ExpressionError, match=r"the x displacement of base_motion: .* at t = 0 s: log of 0"):
        BaseMotion(displacement=("log(t)", 0.0, 0.0))
    with pytest.raises(ExpressionError, match=r"the voltage of the motor on joint 'h': .* division by zero"):
        LinearMotor("h", "1/t", torque_constant=1e-3, resistance=1.0)


NAMES = {"t": (0.0, 3.0), "angle": (-2.0, 2.0), "rate": (-5.0, 5.0)}
FAINT = 1e-60  # rad, rad/s, s: a quintic power of it is a number still
LEAF = st.sampled_from(["t", "angle", "rate", "0.5", "2", "1"])


def compound(inner: st.SearchStrategy[str]) -> st.SearchStrategy[str]:
    two = st.tuples(inner, st.sampled_from("+-*/"), inner).map(lambda p: f"({p[0]} {p[1]} {p[2]})")
    one = st.tuples(st.sampled_from(["sqrt", "log", "asin", "acos", "sin", "cos", "tan", "exp", "abs", "atan", "tanh",
                                     "sinh", "cosh", "sign"]), inner).map(lambda p: f"{p[0]}({p[1]})")  # fmt: skip
    both = st.tuples(st.sampled_from(["min", "max", "atan2", "pow"]), inner, inner).map(
        lambda p: f"{p[0]}({p[1]}, {p[2]})"
    )
    power = st.tuples(inner, st.sampled_from(["2", "3", "-1", "0.5", "1.5", "-2"])).map(
        lambda p: f"({p[0]})**({p[1]})"
    )
    return one | two | both | power


MATHS = {
    name: getattr(mpmath, name)
    for name in "sqrt log asin acos sin cos tan exp atan tanh sinh cosh sign atan2".split()  # noqa: SIM905
}
MATHS |= {"abs": abs, "min": min, "max": max, "pow": lambda x, y: x**y}


@settings(max_examples=tries(400), deadline=None)
@given(text=st.recursive(LEAF, compound, max_leaves=8), data=st.data())
def test_nothing_that_has_a_value_is_refused(text: str, data: st.DataObject) -> None:
    """mpmath is the other cross-check, with exponents that do not overflow: where it gives a value, no refusal is
    right."""
    try:
        found = undefined(text, NAMES)
    except ExpressionError:
        return
    event("refused" if found else "passes")
    if found is None:
        return
    values = {name: mpmath.mpf(data.draw(st.floats(*bounds))) for name, bounds in NAMES.items()}
    try:
        value = eval(text, {"__builtins__": {}}, MATHS | values)  # text of this test's own making
    except (ArithmeticError, ValueError, TypeError):
        return
    has_value = isinstance(value, mpmath.mpf) and mpmath.isfinite(value) and abs(value) < 1e300
    assert not has_value, (text, values, found)


@settings(max_examples=tries(200), deadline=None)
@given(text=st.recursive(LEAF, compound, max_leaves=8), data=st.data())
def test_at_a_point_nothing_that_has_a_value_is_refused(text: str, data: st.DataObject) -> None:
    values = {name: data.draw(st.floats(*bounds)) for name, bounds in NAMES.items()}
    # Powers of fainter ones are below 1e-308, which bounds cannot tell from 0: 1 / angle**1.4 at 1e-222 rad.
    assume(all(value == 0.0 or abs(value) > FAINT for value in values.values()))
    try:
        found = undefined(text, {name: (value, value) for name, value in values.items()})
        stage(text, values)
    except ExpressionError:
        return  # where numbers have no value, the point may have been found, or is within round-off of one
    except (ArithmeticError, ValueError, TypeError):
        return
    assert found is None, (text, values)


def test_an_instant_in_a_thousand_is_found_at_once() -> None:
    times = np.linspace(0.0, 2.0, 1001)
    found = undefined("sqrt(1.5 - t) + angle", {"t": (times, times), "angle": EVERYWHERE})
    assert found is not None
    assert times[found.index] == 1.502  # the first of the grid beyond 1.5
