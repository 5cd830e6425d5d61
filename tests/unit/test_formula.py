"""Expressions in dimensions mean what they mean in Python, decimals exactly; units go together or are refused."""

import math
import time
from fractions import Fraction

import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st

import lamc
from lamc.basics.dimensions import PLAIN, dimension_of, in_words, product, unit_text
from lamc.basics.errors import ExpressionError, LamcError
from lamc.basics.units import registry
from lamc.readers.load import load_text
from lamc.symbolic.formula import exact, formula
from lamc.symbolic.functions import FUNCTIONS
from tests.support import expressions
from tests.support.quick import tries
from tests.unit.test_design_parameters import BODY, HEAD

MM = Fraction(1, 1000)
DIMENSIONS = {
    "length": dimension_of("m"),
    "w": dimension_of("m"),
    "tilt": dimension_of("rad"),
    "k": dimension_of("N*m/rad"),
    "n": PLAIN,
}
VALUES = {"length": exact(0.04), "w": exact(0.0113), "tilt": exact(0.5), "k": exact(2e-3), "n": exact(4.0)}
SIGNS = [
    *"+-*/^(),. ",
    "**",
    *DIMENSIONS,
    *FUNCTIONS,
    "pi",
    "3",
    "0",
    "0.1",
    "1e9",
    "mm",
    " deg",
    "N*m",
    "x",
    "é",
]
SIGNS += ["\n"]
PLACES = [
    "30 deg",
    "length/4",
    "2*t",
    "k*tilt",
    "w + 1",
    "10, max",
]  # in the file, where something else is written


def value(text: str) -> float:
    return float(formula(text, DIMENSIONS, MM).value(VALUES))


@settings(max_examples=tries(200), deadline=None, suppress_health_check=[HealthCheck.filter_too_much])
@given(tree=expressions.trees(), a=st.floats(-2, 2), b=st.floats(-2, 2), c=st.floats(-2, 2))
def test_formulas_mean_what_they_mean_in_python(tree: expressions.Tree, a: float, b: float, c: float) -> None:
    text, values = expressions.text(tree), {"a": a, "b": b, "c": c}
    # atan gives an angle, which cannot be added to a number; 1.7 is a decimal here, and Python's nearest float there.
    assume("atan" not in text and "1.7" not in text and len(text) <= 1000)
    truth = expressions.rounded(tree, values)
    assume(truth is not None)
    assert truth is not None
    made = formula(text, dict.fromkeys("abc", PLAIN))
    found = float(made.value({name: Fraction(each) for name, each in values.items()}))
    last = 4 * expressions.EPS * abs(truth.value) + math.ulp(
        0.0
    )  # roundings at the end, subnormal numbers' too
    assert abs(found - truth.value) <= truth.error + last


@settings(max_examples=tries(300), deadline=None)
@given(parts=st.lists(st.sampled_from(SIGNS), max_size=30) | st.text(max_size=40))
def test_any_text_is_a_formula_or_an_error_soon(parts: list[str] | str) -> None:
    text = "".join(parts)
    registry()  # is made once; pint takes a second to import
    began = time.process_time()
    message = "a number"
    try:
        found = formula(text, DIMENSIONS, MM)
        assert math.isfinite(found.value(VALUES))
    except ExpressionError as error:
        message = str(error)
    assert message == "a number" or "expression" in message
    assert time.process_time() - began < 5.0  # a second at most; the machine may be busy


@settings(max_examples=tries(100), deadline=None)
@given(data=st.data())
def test_any_parameters_are_a_design_or_an_error_with_a_place(data: st.DataObject) -> None:
    """Lines of the section, and expressions in the file, replaced by pieces of others."""
    pieces = st.lists(st.sampled_from(SIGNS), min_size=1, max_size=6).map("".join)
    text = HEAD + BODY
    for old in data.draw(st.lists(st.sampled_from(PLACES), max_size=3)):
        text = text.replace(old, data.draw(pieces).replace("\n", " "), 1)
    message = ""
    try:
        made = load_text(text, "d.yaml")
    except LamcError as error:
        message = str(error)
    else:
        assert isinstance(made, lamc.Design)
        assert made.with_parameters(length=0.04) == made
    assert all(line.startswith("d.yaml") for line in message.splitlines())


@settings(max_examples=tries(200), deadline=None)
@given(
    a=st.integers(-(10**6), 10**6), b=st.integers(1, 10**6), places=st.integers(0, 6), by=st.integers(1, 9)
)
def test_decimals_are_exact_and_rounded_once(a: int, b: int, places: int, by: int) -> None:
    """Against integers: (a + b) · by / 10^places."""
    text = f"({a}/1e{places} + {b}/1e{places})*{by}"
    assert value(text) == float(Fraction((a + b) * by, 10**places))
    assert value(f"length*{a} - {a}*length") == 0.0


@pytest.mark.parametrize(
    ("text", "unit", "number"),
    [
        ("length + 6", "m", 0.046),
        ("6 + length", "m", 0.046),
        ("max(length, 50)", "m", 0.05),
        ("length/2 + 3 mm", "m", 0.023),
        ("length*w", "m²", 0.000452),
        ("sqrt(length*length)", "m", 0.04),
        ("length**2/w", "m", 0.0016 / 0.0113),
        ("k*tilt", "N·m", 1e-3),
        ("2 N*mm/rad*tilt", "N·m", 1e-3),
        ("atan2(w, length)", "rad", math.atan2(0.0113, 0.04)),
        ("length*tilt/(1 rad)", "m", 0.02),
        ("sin(30 deg)", "1", math.sin(30 * 0.017453292519943295)),
        ("n*2 - pi", "1", 8.0 - math.pi),
        ("abs(-length)", "m", 0.04),
        ("1/(2 mm)", "m^-1", 500.0),
        ("-length^2", "m²", -0.0016),
    ],
)
def test_units_go_along(text: str, unit: str, number: float) -> None:
    made = formula(text, DIMENSIONS, MM)
    assert made.dimension == dimension_of(unit)
    assert value(text) == pytest.approx(number, rel=1e-15)  # one rounding of each function


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("length + tilt", "column 10: a length (m) and an angle (rad) cannot be added"),
        (
            "length - n",
            "column 10: a length (m) and a plain number cannot be subtracted or compared; give the plain",
        ),
        ("min(length, k)", "column 1: a length (m) and a hinge stiffness (N·m/rad) cannot be given to min"),
        ("exp(length)", "column 1: exp takes a plain number, and this is a length (m)"),
        ("sin(length)", "column 1: sin takes an angle or a plain number"),
        ("length^n", "column 8: a length (m) takes a power that is written out"),
        ("2^length", "column 3: an exponent is a plain number, and this is a length (m)"),
        ("lenght", "column 1: no parameter is named 'lenght'; did you mean 'length'?"),
        ("2 length", "column 3: write 2*length"),
        ("3 mmm", "column 1: 'mmm' is not a unit"),
        ("mm", "column 1: mm is a unit, and a unit follows a number"),
        ("length.x", "column 7: '.' is not in the language"),
        ("__import__('os')", "is not in the language"),
        ("w/(n - 4)", "column 3: division by zero"),
        ("(n - 4)^-1", "column 9: division by zero"),
        ("log(n - 4)", "column 1: log(0) has no finite value"),
        ("1e300*1e300", "it has no finite value"),
        ("(" * 60 + "1" + ")" * 60, "nested deeper"),
        ("1+" * 600 + "1", "characters"),
    ],
)
def test_what_does_not_go_together_is_refused_with_its_column(text: str, said: str) -> None:
    with pytest.raises(ExpressionError) as caught:
        formula(text, DIMENSIONS, MM).value(VALUES)
    assert said in str(caught.value)


def test_long_chains_of_squares_end_soon() -> None:
    """Exact numbers would have 64^20 digits."""
    chain = ["p: 1.1", *(f"p{k}: p{'' if k == 1 else k - 1}^64" for k in range(1, 20))]
    text = HEAD.replace("  count: 2\n", "  count: p19\n" + "".join(f"  {line}\n" for line in chain))
    began = time.process_time()
    with pytest.raises(lamc.DesignError, match=r"which is 1e[+]30 or more"):
        load_text(text + BODY, "d.yaml")
    assert time.process_time() - began < 5.0  # a tenth of a second


def test_dimensions_are_told_in_words() -> None:
    assert in_words(dimension_of("N*m/rad")) == "a hinge stiffness (N·m/rad)"
    assert in_words(PLAIN) == "a plain number"
    assert unit_text(product(dimension_of("m"), dimension_of("s"), -2)) == "m/s²"
    assert dimension_of("Pa") == dimension_of("N/m^2") == dimension_of("kg/m/s²")
