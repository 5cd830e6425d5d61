"""Measures: what they read off samples, their units, and what they refuse before anything runs."""

import math
import pickle
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import lamc
from lamc import examples
from lamc.basics.errors import ExpressionError, RequestError
from lamc.run.quantities import names
from lamc.run.run_record import Event
from lamc.studies.dimensions import factor_of, unit_of
from lamc.studies.measures import Measure, Outputs, checked_measures, outputs_of
from lamc.studies.samples import Samples, first_above, highest, mean, rms, value_at
from tests.support.mechanisms import chain
from tests.support.quick import tries

NO_BREAKS = np.zeros(0)
TIMES = np.linspace(0.0, 0.8, 81)
SIGNS = (
    "+ - * / ^ ** ( ( ) ) , [ ] < > . ' ° max( min( at( time_of( events( rms( sqrt( max min flap flap.z "
    "tongue.rate energy.gravity t 1 2.5e-3 1e999 -1 mm deg N pi ü 0"
)
WAVE = Samples(TIMES, np.sin(7.0 * TIMES + 0.3), NO_BREAKS)
H4 = (
    7.0 * 0.01
) ** 4  # what the error of a cubic falls with; 3/128 h⁴ f'''' at most, between two of four even rows


@pytest.fixture(scope="module")
def simulator():
    example = examples.find("limit_stop")
    return lamc.compile(lamc.load(example.path))


@pytest.fixture(scope="module")
def result(simulator):
    return simulator.run(t_end=0.5)


def test_extremes_between_rows_are_of_fourth_order():
    value, at = highest(WAVE)
    assert value == pytest.approx(1.0, abs=H4)  # H4 = 2.4e-5; the rows alone miss it by up to 6e-4
    slope = 49.0  # of the derivative at the peak, 1/s²: an error of the cubic's slope, h³ at most, moves it so far
    assert at == pytest.approx((math.pi / 2 - 0.3) / 7.0, abs=7.0**4 * 0.01**3 / slope)


def test_crossings_and_values_between_rows_are_of_fourth_order():
    crossed = Samples(TIMES, -WAVE.y, NO_BREAKS)
    assert first_above(crossed) == pytest.approx((math.pi - 0.3) / 7.0, abs=H4)
    assert value_at(WAVE, 0.1234) == pytest.approx(math.sin(7.0 * 0.1234 + 0.3), abs=H4)
    assert value_at(WAVE, float(TIMES[37])) == WAVE.y[37]
    assert math.isnan(value_at(WAVE, 0.81))
    assert math.isnan(first_above(Samples(TIMES, -1.0 - 0.0 * TIMES, NO_BREAKS)))


def test_averages_are_trapezoidal():
    t = np.array([0.0, 1.0, 4.0])
    assert mean(Samples(t, np.array([0.0, 2.0, 2.0]), NO_BREAKS)) == (1.0 + 6.0) / 4.0
    assert rms(Samples(t, np.array([3.0, 3.0, 3.0]), NO_BREAKS)) == 3.0
    assert mean(Samples(t[:1], np.array([5.0]), NO_BREAKS)) == 5.0


def test_a_jump_at_an_event_is_not_smoothed():
    """A cubic across a jump would swing out by a tenth of it."""
    t = np.linspace(0.0, 1.0, 11)
    y = np.where(t < 0.45, 0.3 * t, 1.0 - t)
    jump = Samples(t, y, np.array([0.45]))
    assert highest(jump) == (float(y.max()), 0.5)
    assert y[4] < value_at(jump, 0.47) < y[5]
    assert highest(jump._replace(breaks=NO_BREAKS))[0] > y.max()


@pytest.mark.parametrize(
    ("text", "unit"),
    [
        ("max(flap.z)", "m"),
        ("rms(flap.z - 5 mm)", "m"),
        ("energy.gravity[-1]", "J"),
        ("at(flap, 100 ms) / 1 deg", "1"),
        ("max(sqrt(flap.x^2 + flap.z**2))", "m"),
        ("last(flap.rate) * 3 N*mm/rad", "W"),
        ("last(flap.rate) * 2 N*mm*s/rad", "J"),
        ("mean(flap) - 0.5", "rad"),
        ("max(flap, tongue)[0]", "rad"),
        ("integral(energy)", "kg·m²/s"),
        ("time_of(flap > 0)", "s"),
        ("time_of(min('flap.z'))", "s"),
        ("events()", "1"),
        ("sqrt(mean(flap.z * flap.z)) / 5 mm", "1"),
        ("max(sin(flap))", "1"),
        ("last(t)", "s"),
    ],
)
def test_units_follow_from_the_text(simulator, result, text, unit):
    measure = Measure.parse(text, simulator)
    assert measure.unit == unit
    assert math.isfinite(measure.value(result))
    assert pickle.loads(pickle.dumps(measure)).value(result) == measure.value(result)


def test_numbers_are_those_of_the_rows(simulator, result):
    def value(text):
        return Measure.parse(text, simulator).value(result)

    assert value("energy.gravity[-1]") == result.energies["gravity"][-1]
    assert value("flap[0]") == value("first(flap)") == result.angle("flap")[0]
    assert value("last(flap.z) - 5 mm") == pytest.approx(
        result.quantity("flap.z").values[-1] - 0.005, rel=1e-15
    )
    assert value("events()") == len(result.events) > 0
    first = result.events[0]
    assert value(f"time_of('{first.name}')") == first.t
    assert value(f"events('{first.name}')") == sum(each.name == first.name for each in result.events)
    assert math.isnan(value("time_of('lower limit of flap')"))
    assert math.isnan(value("at(flap, 3 s)"))
    assert math.isnan(value("flap[1000000]"))


def test_every_output_of_a_run_is_known_before_it_with_its_unit():
    for name in ("limit_stop", "six_bar", "crawler"):
        simulator = lamc.compile(lamc.load(examples.find(name).path))
        outputs, result = outputs_of(simulator), simulator.run(t_end=0.01)
        energies = {f"energy.{each}" for each in result.energies}
        assert set(outputs.units) == {*names(result), *energies, "t"}
        for each in names(result):
            assert outputs.units[each] == result.quantity(each).unit


@pytest.mark.parametrize(
    ("text", "column", "words"),
    [
        ("max(flp.z)", 5, "no output of a run is named 'flp.z'; did you mean 'flap.z'?"),
        ("max(flap.z + flap)", 14, "m and rad are of different dimensions"),
        ("flap", 1, "a value at every time"),
        ("max(sin(flap.z))", 5, "an angle or a plain number, and this is in m"),
        ("events('upper limit of flop')", 8, "did you mean 'upper limit of flap'?"),
        ("__import__('os')", 1, "no output of a run is named '__import__'"),
        ("max(flap.z", 11, "')' is missing"),
        ("max(flap.z; 3)", 11, "';' is not in the language"),
        ("1 / 0", 5, "division by zero"),
        ("max", 1, "write max(…)"),
        ("max(3 mm)", 1, "takes a quantity of the run"),
        ("time_of(flap)", 13, "time_of takes a comparison"),
        ("max(flap) > 3", 11, "outside of time_of"),
        ("at(flap, flap)", 1, "the time in at(…) is a number"),
        ("at(flap, 3 mm)", 1, "it must be in s"),
        ("last(flap) / 5 N*mm", 18, "into parentheses"),
        ("2 flap", 3, "no unit"),
        ("max(flap, 1, 2)", 1, "takes 2 arguments"),
        ("(" * 50 + "1" + ")" * 50, 42, "nested deeper"),
        ("exp(exp(exp(10)))", 5, "must be finite"),
        ("", 1, "too early"),
        ("max(flap.z ^ 100)", 5, "to the power of 12 at most"),
    ],
)
def test_refusals_name_the_column(simulator, text, column, words):
    with pytest.raises(ExpressionError) as caught:
        Measure.parse(text, simulator)
    assert f"column {column}:" in str(caught.value)
    assert words in str(caught.value)
    assert str(caught.value).count("column") == 1


def test_functions_of_the_result_are_measures(result):
    found = checked_measures({"turns": (lambda each: each.angle("flap")[-1] / 7.0, "rad")}, Outputs({}))
    assert found["turns"].unit == "rad"
    assert found["turns"].value(result) == result.angle("flap")[-1] / 7.0
    bad = checked_measures({"bad": lambda each: "much"}, Outputs({}))["bad"]
    with pytest.raises(RequestError, match="one number"):
        bad.value(result)
    with pytest.raises(RequestError, match="must be text, a function"):
        checked_measures({"bad": 3}, Outputs({}))
    with pytest.raises(RequestError, match="must map names"):
        checked_measures({}, Outputs({}))


def test_events_break_the_curve_of_a_result(simulator, result):
    """The extreme of a rate that jumps at an impact is that of its rows."""
    events = tuple(Event(float(each), "upper limit of flap") for each in result.t[1:-1])
    rows = replace(result, events=events)
    assert Measure.parse("max(flap.rate)", simulator).value(rows) == result.rate("flap").max()


def test_units_multiply():
    torque, rate = unit_of("N·m/rad"), unit_of("rad/s")
    assert (torque * rate).text == "W"
    assert (unit_of("m") / unit_of("s")).text == "m/s"
    assert (unit_of("1") / unit_of("kg")).text == "1/kg"
    assert unit_of("N·m/rad").is_like(unit_of("J/rad"))
    assert not unit_of("rad").is_like(unit_of("1"))
    assert factor_of("mm") == (0.001, unit_of("m"))
    assert factor_of("deg")[0] == math.pi / 180.0
    assert unit_of("kg·m²").is_like(unit_of("kg") * unit_of("m") * unit_of("m"))


@settings(max_examples=tries(300), deadline=None)
@given(
    st.lists(
        st.sampled_from(SIGNS.split()),
        max_size=14,
    ).map(" ".join)
)
def test_any_text_is_a_measure_or_a_refusal_of_one_line(simulator, result, text):
    """What reads gives a number, be it NaN or infinite."""
    try:
        measure = Measure.parse(text, simulator)
    except ExpressionError as error:
        told = str(error)
    else:
        told = ""
        assert isinstance(measure.value(result), float)
        assert Measure.parse(text, simulator).unit == measure.unit
    assert "\n" not in told


def test_a_hinge_that_is_named_as_the_time_or_a_rate_has_a_warning():
    """`max(t)` is of the time, and had been taken for the hinge's by who named it so."""
    first, second = chain(2).joints
    for named, words in ((("t", "a"), "take t for the time"), (("a", "a.rate"), "take a.rate for the hinge")):
        renamed = [replace(joint, name=name) for joint, name in zip((first, second), named, strict=True)]
        mechanism = replace(chain(2), joints=tuple(renamed))
        with pytest.warns(lamc.DesignWarning, match=words):
            outputs_of(lamc.compile(mechanism))


def test_a_name_with_a_blank_is_offered_between_quotes():
    known = Outputs({"x y": "rad", "tip.x": "m"})
    with pytest.raises(ExpressionError, match='between quotes: "x y"'):
        Measure.parse("max(x)", known)
    assert Measure.parse('max("x y")', known).unit == "rad"
    with pytest.raises(ExpressionError) as caught:
        Measure.parse("max(tip)", known)
    assert "quotes" not in str(caught.value)
