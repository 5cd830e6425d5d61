"""Counts of ranges where nothing is counted: they are told, not passed over."""

import warnings
from collections.abc import Mapping

import pytest

from lamc.basics.errors import DesignWarning
from lamc.studies.making import _plan
from lamc.studies.space import _variable
from lamc.studies.targets import Target


def warned(told: list[warnings.WarningMessage]) -> list[str]:
    return [str(each.message) for each in told if each.category is DesignWarning]


@pytest.mark.parametrize(("given", "count"), [("30mm:48mm:4", 4), ("log:30mm:48mm:3", 3), ("30mm:48mm", 0)])
def test_a_count_in_the_range_of_an_optimisation_is_told(given: str, count: int) -> None:
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        variable = _variable(Target("a", "dimension", "m"), given)
    assert (variable.low, variable.high) == pytest.approx((0.03, 0.048))
    assert variable.is_real
    found = warned(told)
    assert len(found) == bool(count)
    assert all(f"not at {count} points of it; leave out the count, or list values" in note for note in found)


@pytest.mark.parametrize(
    ("vary", "named"),
    [
        ({"a": "30mm:48mm:3", "b": "1:2"}, "'a'"),
        ({"a": "30mm:48mm:3", "b": "1:2:5"}, "'a', 'b'"),
        ({"a": "30mm:48mm"}, ""),
    ],
)
def test_a_count_beside_samples_is_told(vary: Mapping[str, str], named: str) -> None:
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        plan = _plan(vary, {"a": "m", "b": "1"}, "lhs:5", 0, None)
    assert plan.count == 5
    assert [note.partition(":")[0] for note in warned(told)] == ([f"vary {named}"] if named else [])
