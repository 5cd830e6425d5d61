"""What an optimisation is asked for: ranges, goals and constraints are refused in one line before anything runs."""

import sys
from typing import Any

import pytest

import lamc
from lamc.basics.errors import LamcError
from lamc.studies.goals import constraints_of, goal_of
from lamc.studies.measures import Outputs
from tests.support.ctools import needs_cc
from tests.unit.test_optimise import rotor, wheel

OUTPUTS = Outputs({"h": "rad", "h.rate": "rad/s", "tip.z": "m", "t": "s"}, ("stop",))
RANGE = {"h.stiffness": (0.2, 1.0)}
GOAL = "time_of(h < 0)"


@needs_cc
@pytest.mark.parametrize(
    ("vary", "told"),
    [
        ({"h.stifness": (0.2, 1.0)}, "named 'h.stifness'; did you mean 'h.stiffness'?"),
        ({"h.stiffness": (1.0, 0.2)}, "the range from 1 to 0.2 runs backwards"),
        ({"h.stiffness": (1.0, 1.0)}, "the range from 1 to 1 is empty"),
        ({"h.stiffness": "1:1"}, "is empty"),
        ({"h.stiffness": "5 mm:6 mm"}, "'mm'"),
        ({"h.stiffness": "log:0:1"}, "lies above zero"),
        ({"h.stiffness": "6..3"}, "holds no two whole numbers"),
        ({"h.stiffness": "1|1"}, "not two or more different values"),
        ({"h.stiffness": 3.0}, "is no range"),
        ({"h.stiffness": "normal(1, 0.1)"}, "is no range"),
        ({"h.stiffness": (-1.0, 1.0)}, "out of bounds"),
        ({}, "it must map names to ranges"),
    ],
)
def test_ranges_that_are_none(vary: Any, told: str) -> None:
    with pytest.raises(LamcError) as error:
        lamc.optimise(rotor(), vary, GOAL)
    assert told in str(error.value)
    assert "\n" not in str(error.value)


@needs_cc
@pytest.mark.parametrize(
    ("given", "told"),
    [
        ({"minimise": ""}, "nothing is minimised"),
        ({"minimise": "time_of(hh < 0)"}, "no output of a run is named 'hh'"),
        ({"minimise": "h"}, "it has a value at every time"),
        ({"minimise": 3.0}, "minimise is 3.0"),
        ({"minimise": "2*pi"}, "the goal '2*pi' is the same in every run"),
        ({"subject_to": ["max(h)"]}, "is no comparison"),
        ({"subject_to": ["max(h) = 1"]}, "is no comparison"),
        (
            {"subject_to": ["max(h) < 5 mm"]},
            "constraint 'max(h) < 5 mm': rad and m are of different dimensions",
        ),
        ({"subject_to": ["max(hh) < 1"]}, "constraint 'max(hh) < 1': measure 'max(hh) ', column 5"),
        ({"subject_to": ["1 < 2"]}, "compares two fixed numbers"),
        ({"subject_to": 3}, "subject_to is 3"),
        ({"start": {"h.stiffness": 2.0}}, "2 N·m/rad is outside of its range, 0.2 to 1 N·m/rad"),
        ({"start": {"stiffness": 2.0}}, "'stiffness' is not varied"),
        ({"method": "slsq"}, "no method is named 'slsq'; did you mean 'slsqp'?"),
        ({"method": "least-squares"}, "takes a goal of squares"),
        ({"method": "nsga2"}, "there is one"),
        ({"starts": 0}, "starts is 0"),
        ({"max_runs": True}, "max_runs is True"),
        ({"minimise": [GOAL, "max(h)"], "method": "slsqp"}, "slsqp takes one goal, and there are 2"),
        ({"minimise": [GOAL, GOAL]}, "is there twice"),
        ({"vary": {"h.stiffness": "1|2"}, "method": "slsqp"}, "takes no whole numbers and choices"),
        ({"parameters": {"h.stiffness": 1.0}}, "is varied"),
        ({"out": "a", "resume": "b"}, "two folders"),
    ],
)
def test_questions_that_are_none(given: Any, told: str) -> None:
    words: dict[str, Any] = {"vary": RANGE, "minimise": GOAL, **given}
    with pytest.raises(LamcError) as error:
        lamc.optimise(rotor(), **words)
    assert told in str(error.value)


@needs_cc
def test_words_are_of_arguments_that_are_words() -> None:
    with pytest.raises(lamc.RequestError, match="takes words"):
        lamc.optimise(wheel, {"material": (0.1, 0.2)}, GOAL)
    with pytest.raises(lamc.RequestError, match=r"'glass' is none of wood\|steel"):
        lamc.optimise(wheel, {"material": "wood|steel"}, GOAL, start={"material": "glass"})


@needs_cc
@pytest.mark.parametrize(("method", "package"), [("cma-es", "cma"), ("auto", "pymoo")])
def test_a_package_that_is_missing_is_named(
    method: str, package: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in [package, *(each for each in sys.modules if each.startswith(f"{package}."))]:
        monkeypatch.setitem(sys.modules, name, None)
    if package == "pymoo":
        monkeypatch.setitem(sys.modules, "pymoo.algorithms.moo.nsga2", None)
    goal: Any = [GOAL, "max(h)"] if package == "pymoo" else GOAL
    with pytest.raises(LamcError, match=r"pip install lamc\[optimise\]"):
        lamc.optimise(rotor(), RANGE, goal, method=method, starts=1)


@pytest.mark.parametrize(
    ("text", "is_root", "parts"),
    [
        ("rms(tip.z - 5 mm)", True, 1),
        ("(last(h) - 0.3)**2", False, 1),
        ("(last(h) - 0.3)**2 + max(h)^2", False, 2),
        ("last(h)**2 + 1e-3 * max(h)**2", False, 0),
        ("rms(h) + rms(h)", False, 0),
        ("last(h)**3", False, 0),
        ("-last(h)**2", False, 0),
        ("max(h)", False, 0),
    ],
)
def test_goals_that_are_made_of_squares_are_seen(text: str, is_root: bool, parts: int) -> None:
    goal = goal_of(text, OUTPUTS)
    assert (goal.is_root, len(goal.parts)) == (is_root, parts)


def test_a_chain_makes_two_constraints_and_quotes_hide_signs() -> None:
    found = constraints_of("1 mm < last(tip.z) < 5 mm", OUTPUTS)
    assert [each.text for each in found] == ["1 mm < last(tip.z)", "last(tip.z) < 5 mm"]
    assert [each.measure.text for each in found] == ["(1 mm) - (last(tip.z))", "(last(tip.z)) - (5 mm)"]
    (one,) = constraints_of(["time_of(h > 10 deg) >= time_of('stop')"], OUTPUTS)
    assert one.measure.text == "(time_of('stop')) - (time_of(h > 10 deg))"
    assert not one.is_equal
    assert constraints_of("last(h) == 0.2", OUTPUTS)[0].is_equal
