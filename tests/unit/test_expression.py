"""The expression language of scenes: what Python means where it is accepted, one line with a column where it is not."""

import math
import time

import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st

from lamc.basics.errors import ExpressionError
from lamc.effects import Torque
from lamc.records.scene import Scene
from lamc.symbolic.expression import MAX_DEPTH, MAX_LENGTH, in_python, stage
from lamc.symbolic.functions import FUNCTIONS
from lamc.symbolic.program import Space
from lamc.symbolic.scalars import Scalar, Value
from lamc.symbolic.staging import Store
from lamc.symbolic.substitution import substitute
from tests.support import expressions
from tests.support.quick import tries


def with_names() -> dict[str, Scalar]:
    store = Store()
    return {name: store.symbol(name, Space.ANGLE, i) for i, name in enumerate(("t", "angle", "rate"))}


def value_of(text: str, **inputs: float) -> float:
    """By staging with the names as symbols and then putting numbers in."""
    names = with_names()
    value = stage(text, names)
    given_values = {names[k]: v for k, v in inputs.items() if isinstance(names[k], Value)}
    (result,) = substitute([value], given_values)  # type: ignore[arg-type]
    assert not isinstance(result, Value)
    return float(result)


# ---- accepted -------------------------------------------------------------------------------------------------


@settings(max_examples=tries(300), deadline=None, suppress_health_check=[HealthCheck.filter_too_much])
@given(tree=expressions.trees(), a=st.floats(-2, 2), b=st.floats(-2, 2), c=st.floats(-2, 2))
def test_expressions_mean_what_they_mean_in_python(
    tree: expressions.Tree, a: float, b: float, c: float
) -> None:
    inputs = {"a": a, "b": b, "c": c}
    truth = expressions.rounded(tree, inputs)
    assume(truth is not None)
    assert truth is not None
    text = expressions.text(tree)
    assume(len(text) <= MAX_LENGTH and text.count("(") < MAX_DEPTH)
    store = Store()
    symbols = {name: store.symbol(name, Space.ANGLE, i) for i, name in enumerate("abc")}
    try:
        (found,) = substitute([stage(text, symbols)], {symbols[k]: v for k, v in inputs.items()})
    except ExpressionError as error:
        if "division by zero" not in str(error):
            raise
        assume(False)  # a denominator like a - a: zero whatever a is
    assert not isinstance(found, Value)
    assert (
        abs(found - truth.value) <= 8 * truth.error + 1e-300
    )  # sharing may take another order of operations


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("0.01*sin(2*pi*50*t) - 1e-4*rate", 0.01 * math.sin(2 * math.pi * 50 * 0.3) - 1e-4 * 0.7),
        ("-2**2", -4.0),
        ("2**3**2", 512.0),
        ("2^-1", 0.5),
        ("2**-angle", 2**1.2),
        ("-angle^2", -1.44),
        ("1 - 2 - 3", -4.0),
        ("8/4/2", 1.0),
        ("2*-3", -6.0),
        ("+-+2", -2.0),
        ("1e3", 1000.0),
        ("1.E-1", 0.1),
        (".5", 0.5),
        ("5.", 5.0),
        (" ( 1 )\t", 1.0),
        ("min(t, angle) + max(t, angle)", 0.3 - 1.2),
        ("atan2(angle, t)", math.atan2(-1.2, 0.3)),
        ("pow(t, 2)", 0.09),
        ("abs(angle)*sign(angle)", -1.2),
        ("t*t - 0.09", 0.0),
        ("0*t", 0.0),
    ],
)
def test_the_language_reads_like_python(text: str, expected: float) -> None:
    assert value_of(text, t=0.3, angle=-1.2, rate=0.7) == pytest.approx(expected, abs=1e-15)  # one rounding


@pytest.mark.parametrize("name", sorted(FUNCTIONS))
def test_every_function_of_the_table_can_be_called(name: str) -> None:
    arguments = ["0.6", "0.3"][: FUNCTIONS[name].arity]
    on_numbers = value_of(f"{name}({', '.join(arguments)})")
    on_symbols = value_of(f"{name}({', '.join(['t', 'angle'][: len(arguments)])})", t=0.6, angle=0.3)
    assert on_numbers == on_symbols


@pytest.mark.parametrize(
    ("text", "spelled"),
    [
        ("0.01*sin(2*pi*50*t) - 1e-4*rate", "0.01*sin(2.0*pi*50.0*t)-0.0001*rate"),
        ("-angle^2", "-angle**2.0"),
        ("max( t, .5 )", "max(t,0.5)"),
        ("lambda*angle", 'inputs["lambda"]*angle'),
        ("9^9^9^9", "9.0**9.0**9.0**9.0"),  # of integers, Python would try to work it out
    ],
)
def test_expressions_are_spelled_for_python_with_floats_alone(text: str, spelled: str) -> None:
    assert in_python(text, ("t", "angle", "rate")) == spelled


# ---- refused --------------------------------------------------------------------------------------------------

REFUSED = [
    ("", 1, "ends too early"),
    ("   ", 1, "ends too early"),
    ("t.__class__", 2, "'.' is not in the language"),
    ("t[0]", 2, "'['"),
    ("__import__('os')", 12, '"\'" is not in the language'),
    ("__import__", 1, "'__import__' is not known; known are pi, t, angle, rate, sqrt"),
    ("eval(t)", 1, "'eval' is not known"),
    ("lambda: t", 7, "':'"),
    ("lambda", 1, "not known"),
    ("'text'", 1, "not in the language"),
    ('"text"', 1, "not in the language"),
    ("t if t else 0", 3, "'if' is not expected"),
    ("t and t", 3, "'and'"),
    ("t = 1", 3, "'='"),
    ("t; t", 2, "';'"),
    ("t, t", 2, "',' is not expected"),
    ("t < 1", 3, "'<'"),
    ("1 2", 3, "'2' is not expected"),
    ("2t", 2, "'t' is not expected"),
    ("2 pi", 3, "'pi' is not expected"),
    ("t(1)", 2, "'(' is not expected"),
    ("sin", 4, "sin is a function: write sin(…)"),
    ("sin()", 5, "')' is not expected"),
    ("sin(t, t)", 1, "sin takes 1 arguments, not 2"),
    ("atan2(t)", 1, "atan2 takes 2 arguments, not 1"),
    ("sin(t", 6, "')' is missing"),
    ("(t", 3, "')' is missing"),
    ("t)", 2, "')' is not expected"),
    ("1 +", 4, "ends too early"),
    ("* t", 1, "'*' is not expected"),
    ("t ** * t", 6, "'*' is not expected"),
    ("t // 2", 4, "'/' is not expected"),
    ("t % 2", 3, "'%'"),
    ("1/0", 3, "division by zero"),
    ("t/0.0", 3, "division by zero"),
    ("t/(t-t)", 3, "division by zero"),
    ("1e400", 1, "too large"),
    ("t*1e309", 3, "too large"),
    ("1e308*10", 1, "inf; it must be finite"),
    ("t*(1e308*10)", None, "finite"),
    ("9**9**9**9", None, "no finite value"),
    ("exp(1000)", None, "no finite value"),
    ("sqrt(-1)", None, "no finite value"),
    ("log(0)", None, "no finite value"),
    ("0**-1", None, "no finite value"),
    ("(-8)**(1/3)", None, "no finite value"),
    ("1_000", 2, "'_000' is not expected"),
    ("0x10", 2, "'x10' is not expected"),
    ("1j", 2, "'j' is not expected"),
    ("inf", 1, "not known"),
    ("nan", 1, "not known"),
    ("t\x00", 2, "not in the language"),
    ("t\n\n@", 4, "not in the language"),
    ("π", 1, "not in the language"),
    ("2\u00b2", 2, "not in the language"),
    ("٣", 1, "not in the language"),
    ("\u2003t", 1, "not in the language"),
    ("🦊", 1, "not in the language"),
    ("\ud800", 1, "not in the language"),
]


@pytest.mark.parametrize(("text", "column", "words"), REFUSED, ids=[repr(r[0]) for r in REFUSED])
def test_what_is_outside_the_language_is_refused_with_its_column(
    text: str, column: int | None, words: str
) -> None:
    with pytest.raises(ExpressionError) as caught:
        stage(text, with_names())
    message = str(caught.value)
    assert words in message
    assert f"column {column}:" in message if column else "column " in message
    assert "\n" not in message


def test_torques_tell_the_joint_the_expression_and_the_column() -> None:
    with pytest.raises(
        ExpressionError, match=r"the torque of joint 'h1': expression '2\*q', column 3: 'q' is not"
    ):
        Scene(effects=(Torque({"h1": "2*q"}),))
    with pytest.raises(
        ExpressionError, match=r"joint 'h1': expression '1e308\*10', column 1: the value is inf"
    ):
        Torque({"h1": "1e308*10"})


def test_length_and_depth_are_bounded() -> None:
    stage("+".join(["t"] * (MAX_LENGTH // 2)), with_names())
    with pytest.raises(ExpressionError, match=f"has 10001 characters; at most {MAX_LENGTH} are allowed"):
        stage("t+" * 5000 + "t", with_names())
    for nest in (
        "(" * 400 + "t" + ")" * 400,
        "-" * 900 + "t",
        "t" + "**t" * 300,
        "sin(" * 190 + "t" + ")" * 190,
    ):
        with pytest.raises(ExpressionError, match=f"column .* nested deeper than {MAX_DEPTH} levels"):
            stage(nest, with_names())
    stage("(" * MAX_DEPTH + "t" + ")" * MAX_DEPTH, with_names())


# ---- any text -------------------------------------------------------------------------------------------------

TOKENS = st.sampled_from(
    [
        *"()+-*/^,. \t'\"[]{}:;=<>%@!\\_",
        "**",
        "t",
        "angle",
        "rate",
        "pi",
        "1",
        "2.5",
        "1e300",
        "1e-320",
        "0",
        "__class__",
        *FUNCTIONS,
    ]
)


def value_or_refusal(text: str) -> None:
    start = time.perf_counter()
    try:
        value, refusal = stage(text, with_names()), ""
    except ExpressionError as error:
        value, refusal = 0, str(error)
    assert isinstance(value, Value) or math.isfinite(value)
    assert not refusal or "column" in refusal or "characters" in refusal
    assert "\n" not in refusal
    assert time.perf_counter() - start < 1.0  # takes milliseconds; the rest is for a loaded machine


@pytest.mark.slow
@settings(max_examples=tries(500), deadline=None)
@given(st.text(max_size=200))
def test_any_text_is_a_value_or_one_error(text: str) -> None:
    value_or_refusal(text)


@settings(max_examples=tries(500), deadline=None)
@given(st.lists(TOKENS, max_size=40))
def test_any_row_of_tokens_is_a_value_or_one_error(tokens: list[str]) -> None:
    value_or_refusal("".join(tokens))


@settings(max_examples=tries(100), deadline=None)
@given(st.lists(TOKENS, min_size=150, max_size=400))
def test_long_rows_of_tokens_end_soon(tokens: list[str]) -> None:
    value_or_refusal(" ".join(tokens)[:MAX_LENGTH])


@pytest.mark.parametrize("text", ["t" + "*t" * 499, "(" * 30 + "t" + "+t)**2" * 30, "(t**16)**16**16"])
def test_expressions_made_to_grow_are_staged_at_once(text: str) -> None:
    value_or_refusal(text)
