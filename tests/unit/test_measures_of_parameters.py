"""Measures, goals and constraints name what is varied."""

import math
import pickle

import pytest

import lamc
from lamc.basics.errors import ExpressionError, RequestError
from lamc.report.optimum_text import optimum_summary
from lamc.studies.bench import RunOptions
from lamc.studies.making import study_of
from lamc.studies.measures import Measure, Outputs
from tests.support import studied
from tests.support.ctools import needs_cc

pytestmark = needs_cc

FAST = RunOptions(t_end=0.02, rtol=1e-6, atol=1e-9, rows=5)
OUTPUTS = Outputs({"h": "rad", "t": "s"}, varied={"length": "m", "h.stiffness": "N*m/rad", "angles.h": "rad"})


@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [
        ("length", "m", 0.2),
        ("length + 50 mm", "m", 0.25),
        ("length^2", "m²", 0.04),
        ("0.5 * h.stiffness * angles.h^2", "kg·m²·rad/s²", 0.5 * 3.0 * 0.25),
        ("max(length, 1)", "m", 1.0),
    ],
)
def test_a_varied_parameter_is_a_number_with_its_unit(text: str, unit: str, value: float) -> None:
    measure = Measure.parse(text, OUTPUTS)
    given = {"length": 0.2, "h.stiffness": 3.0, "angles.h": 0.5}
    design = studied.rod()
    result = lamc.compile(design).run(0.02)
    if "stiffness" not in text:
        assert measure.unit == unit
    for each in (measure, pickle.loads(pickle.dumps(measure))):
        assert each.value(result, given) == pytest.approx(value, rel=1e-15)  # one rounding or two
    with pytest.raises(RequestError, match="which was varied; give its value"):
        measure.value(result)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("length + 3 rad", "column 10: m and rad are of different dimensions"),
        ("lenght", r"column 1: no output of a run is named 'lenght'.*'length'"),
        ("max(length)", "max takes a quantity of the run, and this is one number"),
    ],
)
def test_units_and_names_are_checked(text: str, words: str) -> None:
    with pytest.raises(ExpressionError, match=words):
        Measure.parse(text, OUTPUTS)


def test_a_name_of_an_output_and_of_a_dimension_is_refused() -> None:
    both = Outputs({"arm": "rad"}, varied={"arm": "m"})
    with pytest.raises(ExpressionError, match="column 6: 'arm' names an output of the run, and a dimension"):
        Measure.parse("last(arm)", both)


def test_a_sweep_measures_with_what_is_varied() -> None:
    vary = {"length": ["0.1 m", "0.2 m"], "hip.stiffness": [1e-3, 2e-3]}
    measure = {"reach": "length * sin(last(hip))", "sum": "length + hip.stiffness / (1 N*m/rad) * (1 m)"}
    table = study_of(studied.bounded, vary, measure | {"end": "last(hip)"}, run=FAST).run(None, 1)
    assert table.units["reach"] == "m"
    assert table.values["sum"].tolist() == pytest.approx([0.101, 0.102, 0.201, 0.202], rel=1e-15)
    for k in range(4):
        length = table.plan.point(k)[0]
        assert table.values["reach"][k] == length * math.sin(table.values["end"][k])


@pytest.mark.slow
def test_the_largest_rectangle_under_a_line() -> None:
    """length * mass is most where length + 10 mass = 0.4 halves: 0.2 and 0.02, in closed form."""
    best = lamc.optimise(
        studied.rod,
        vary={"length": (0.05, 0.3), "mass": (0.005, 0.04)},
        minimise="-length * mass",
        subject_to=["length + 10 * mass < 0.4"],
        t_end=0.02,
        rows=5,
        starts=2,
    )
    assert best.converged, best.message
    # With slopes in a column of a table, which scipy's method misread, no start came to it by itself.
    assert "2 of 2 starts came to it" in best.message
    assert best.parameters["length"] == pytest.approx(0.2, rel=1e-6)  # what `lamc.optimise` promises
    assert best.parameters["mass"] == pytest.approx(0.02, rel=1e-6)
    assert best.active == ("length + 10 * mass < 0.4",)
    # The value's own bends say nothing of how it is felt where a slope is held.
    assert "flattest" not in optimum_summary(best)


def test_two_fixed_numbers_are_no_constraint() -> None:
    with pytest.raises(ExpressionError, match="compares two fixed numbers; name an output of the run, or"):
        lamc.optimise(studied.rod, {"length": (0.1, 0.3)}, "last(hip)", "1 < 2")


def test_straight_goals_leave_no_warning_of_scipy(recwarn: pytest.WarningsRecorder) -> None:
    """trust-constr finds no second derivatives of theirs, and scipy would say so on the terminal."""
    lamc.optimise(
        studied.rod,
        vary={"length": (0.05, 0.3), "mass": (0.005, 0.04)},
        minimise="-length",
        subject_to=["length + 10 * mass < 0.4"],
        method="trust-constr",
        t_end=0.02,
        rows=5,
        starts=1,
        max_runs=60,
    )
    assert not [each for each in recwarn if "delta_grad" in str(each.message)]
