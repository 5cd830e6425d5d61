"""The staged store: what folds, what is shared, what each function means, and derivatives."""

import math
from collections.abc import Callable
from fractions import Fraction

import numpy as np
import pytest
import sympy as sp
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st

from lamc.basics.errors import ExpressionError
from lamc.mechanics.sympy_view import expression, from_sympy
from lamc.reference.interpreter import Interpreter
from lamc.symbolic.derivative import derivative, derivatives
from lamc.symbolic.functions import FUNCTIONS
from lamc.symbolic.program import Space
from lamc.symbolic.scalars import Scalar, Value, call, cos, power, reciprocal, sin
from lamc.symbolic.staging import Level, Store
from lamc.symbolic.substitution import substitute
from tests.support import expressions
from tests.support.ctools import needs_cc, program_of, values_in_c
from tests.support.quick import tries

QUICK = settings(max_examples=tries(150), deadline=None, suppress_health_check=[HealthCheck.filter_too_much])


def symbols(store: Store, count: int = 3) -> list[Value]:
    return [store.symbol("abc"[i], Space.ANGLE, i) for i in range(count)]


def interpreted(store: Store, values: list[Scalar], inputs: list[float]) -> list[float]:
    """`values` by the interpreter; the inputs are the first angles."""
    padded = [*values, *[0] * max(0, len(inputs) - len(values))]
    interpreter = Interpreter(program_of(store, padded))
    q = np.zeros(len(padded))
    q[: len(inputs)] = inputs
    return interpreter.acceleration(0.0, q, np.zeros(len(padded)), interpreter.constants())[
        : len(values)
    ].tolist()


# ---- folding, signs, sharing ----------------------------------------------------------------------------------


def test_numbers_stay_numbers_and_exact_ones_exact() -> None:
    assert power(Fraction(1, 3), 2) == pytest.approx(1 / 9)
    assert reciprocal(3) == Fraction(1, 3)
    assert reciprocal(0.5) == 2.0
    assert sin(0) == 0
    assert cos(0) == 1
    assert call("atan2", 1.0, 1.0) == math.pi / 4


def test_zeros_and_ones_disappear() -> None:
    store = Store()
    a, b, _ = symbols(store)
    before = len(store)
    assert (0 * a, a * 0, 0 + a, a + 0, a - 0, 1 * a, a / 1, +a) == (0, 0, a, a, a, a, a, a)
    assert (a - a, 0 * (a * b)) == (0, 0)
    assert len(store) <= before + 1  # a·b was written by the test itself
    assert a * reciprocal(a) == 1
    assert (-b) / b == -1
    assert power(a, 0) == 1
    assert power(a, 1) == a
    assert reciprocal(reciprocal(-a)) == -a


def test_signs_move_outside() -> None:
    store = Store()
    a, b, _ = symbols(store)
    assert a - b == -(b - a)
    assert (-a) * b == a * (-b) == -(a * b)
    assert (-a) * (-b) == a * b
    assert -a - b == -(a + b)
    assert sin(-a) == -sin(a)
    assert cos(a - b) == cos(b - a)
    assert 2 - a == -(a - 2)
    assert a * -3 == -(a * 3)


def test_equal_expressions_are_one_node() -> None:
    store = Store()
    a, b, c = symbols(store)
    first = (a + b) * c + sin(a * b)
    count = len(store)
    assert sin(b * a) + c * (b + a) == first
    assert len(store) == count
    assert a + a == 2 * a
    assert 2 * (3 * a) == 6 * a == (a * 3) * 2
    assert power(a, 4) == (a * a) * (a * a)


def test_constants_of_the_design_are_kept_apart_and_structure_is_not() -> None:
    store = Store()
    a, *_ = symbols(store)
    half = store.constant(0.5)
    assert isinstance(half, Value)
    assert store.levels[half.index] == Level.PARAMETER
    assert isinstance(half * store.constant(2.5), Value)  # not folded: like links give like code
    assert (store.constant(0.0), store.constant(1.0), store.constant(-1.0)) == (0, 1, -1)
    assert store.constant(0.0) * a == 0


def test_what_depends_on_parameters_only_is_marked() -> None:
    store = Store()
    k = store.symbol("k", Space.PARAMETER, 0)
    q = store.symbol("q", Space.ANGLE, 0)
    product = sin(k) * 2.0
    assert isinstance(product, Value)
    assert store.levels[product.index] == Level.PARAMETER
    mixed = product * q
    assert isinstance(mixed, Value)
    assert store.levels[mixed.index] == Level.STATE


@pytest.mark.parametrize("bad", [math.inf, -math.inf, math.nan])
def test_constants_that_are_not_finite_never_enter(bad: float) -> None:
    store = Store()
    a, *_ = symbols(store)
    for operation in (lambda: a + bad, lambda: a * bad, lambda: a - bad, lambda: call("max", a, bad)):
        with pytest.raises(OverflowError):
            operation()


# ---- functions ------------------------------------------------------------------------------------------------

# Points inside every function's domain; the second pair swaps which argument of min and max counts.
POINTS = ((0.62, 0.31), (0.27, 0.83))


def staged_call(name: str, x: Scalar, y: Scalar) -> Scalar:
    arguments = (x, y)[: FUNCTIONS[name].arity]
    if name == "sin":
        return sin(x)
    if name == "cos":
        return cos(x)
    return power(x, y) if name == "pow" else call(name, *arguments)


def by_math(name: str, x: float, y: float) -> float:
    """Written out here: nothing of the table under test."""
    special: dict[str, Callable[[], float]] = {
        "abs": lambda: math.fabs(x),
        "sign": lambda: math.copysign(1.0, x) if x else 0.0,
        "min": lambda: x if x < y else y,
        "max": lambda: x if x > y else y,
        "pow": lambda: x**y,
        "atan2": lambda: math.atan2(x, y),
    }
    return special[name]() if name in special else getattr(math, name)(x)


@needs_cc
def test_every_function_means_the_same_in_python_in_the_interpreter_and_in_c() -> None:
    store = Store()
    a, b = symbols(store, 2)
    names = sorted(FUNCTIONS)
    values = [staged_call(name, a, b) for name in names]
    values += [
        staged_call(name, -a, b) for name in ("sin", "cos", "abs", "sign", "min", "max", "atan2", "tanh")
    ]
    checks = [(name, 1.0) for name in names]
    checks += [(name, -1.0) for name in ("sin", "cos", "abs", "sign", "min", "max", "atan2", "tanh")]
    program = program_of(store, values)
    interpreter = Interpreter(program)
    u = np.zeros(len(values))
    for x, y in POINTS:
        q = np.zeros(len(values))
        q[:2] = x, y
        expected = [by_math(name, s * x, y) for name, s in checks]
        # a libm's functions are good to a few units in the last place, and libms differ by as much
        assert interpreter.acceleration(0.0, q, u, interpreter.constants()) == pytest.approx(
            expected, rel=1e-15
        )
        assert values_in_c(program, [(0.0, q, u)])[0] == pytest.approx(expected, rel=1e-15)


@pytest.mark.parametrize("name", sorted(FUNCTIONS))
@pytest.mark.parametrize(("x", "y"), POINTS)
def test_derivatives_of_every_function_are_those_of_sympy_and_of_differences(
    name: str, x: float, y: float
) -> None:
    store = Store()
    a, b = symbols(store, 2)
    sx, sy = sp.symbols("a b", real=True)
    value = staged_call(name, 0.5 * a * b + 0.3, 0.1 + 0.5 * a)
    in_sympy = getattr(sp, FUNCTIONS[name].sympy_name)
    inner = (sx * sy / 2 + sp.Rational(3, 10), sp.Rational(1, 10) + sx / 2)
    formula = in_sympy(*inner[: FUNCTIONS[name].arity])
    slopes = [derivative(value, {s: 1}) for s in (a, b)]
    found = interpreted(store, slopes, [x, y])
    expected = [float(formula.diff(s).subs({sx: x, sy: y})) for s in (sx, sy)]
    assert found == pytest.approx(expected, rel=1e-13, abs=1e-15)  # some ten roundings
    step = 1e-5
    for slope, (dx, dy) in zip(found, ((step, 0.0), (0.0, step)), strict=True):
        high, low = (
            interpreted(store, [value], [x + dx, y + dy]),
            interpreted(store, [value], [x - dx, y - dy]),
        )
        # central differences: step² times a third derivative below 1e2, and round-off / step
        assert slope == pytest.approx((high[0] - low[0]) / (2 * step), rel=1e-7, abs=1e-8)


def test_a_derivative_follows_speeds_that_are_expressions() -> None:
    store = Store()
    q, u, w = symbols(store)
    # d/dt (q² u) with q̇ = u, u̇ = w
    found = derivatives([power(q, 2) * u, 3, -q], {q: u, u: w})
    assert interpreted(store, [found[0], found[2]], [0.7, -1.1, 0.4]) == pytest.approx(
        [2 * 0.7 * 1.21 + 0.49 * 0.4, 1.1], rel=1e-15
    )
    assert found[1] == 0
    assert derivative(sin(w) * 2.0, {q: 1}) == 0


@pytest.mark.parametrize("exponent", [2, 3, 7, 16, -1, -4, 0.5, Fraction(1, 2), 2.5, 17, -0.5])
def test_powers_by_products_and_by_the_library_agree(exponent: float) -> None:
    store = Store()
    a, *_ = symbols(store)
    (found,) = interpreted(store, [power(a, exponent)], [1.3])
    assert found == pytest.approx(1.3 ** float(exponent), rel=4e-15)  # sixteen roundings at most


# ---- substitution, sympy --------------------------------------------------------------------------------------


def test_substitution_folds_what_becomes_constant() -> None:
    store = Store()
    a, b, c = symbols(store)
    value = (a + b) * c - sin(a) * b
    assert substitute([value, 7], {a: 0, c: 0}) == [0, 7]
    assert substitute([value], {a: 0}) == [b * c]
    assert substitute([value], {b: -a}) == [sin(a) * a]
    (swapped,) = substitute([a - 2 * b], {a: b, b: a})
    assert swapped == b - 2 * a


def test_expressions_of_sympy_enter_and_come_back() -> None:
    store = Store()
    a, b, c = symbols(store)
    known = {"a": a, "b": b, "c": c}
    x, y, z = sp.symbols("a b c")
    for formula in (
        x + 2 * y - z / 3,
        sp.sqrt(x**2 + y**2) * sp.exp(-z),
        sp.atan2(y, x) ** 3 + sp.Max(x, y, z) - sp.Min(x, 1),
        sp.pi * x + sp.Rational(1, 7) + sp.Float(0.1) * sp.Abs(y) * sp.sign(z),
        x ** sp.Rational(-3, 2) + x**y,
        sp.tanh(x) + sp.log(y) + sp.asin(x) + sp.E,
    ):
        staged = from_sympy(formula, known)
        back = expression(staged, {})
        point = {x: 0.31, y: 0.57, z: 0.92}
        expected = float(formula.subs(point))
        assert float(back.subs(point)) == pytest.approx(expected, rel=1e-14)
        assert interpreted(store, [staged], [0.31, 0.57, 0.92]) == pytest.approx([expected], rel=1e-14)


def test_fractions_stay_exact_on_the_way_through() -> None:
    store = Store()
    a, *_ = symbols(store)
    formula = sp.Rational(1, 3) * sp.Symbol("a") + sp.Rational(2, 7)
    assert expression(from_sympy(formula, {"a": a}), {}) == formula


@pytest.mark.parametrize(
    ("formula", "words"),
    [
        (sp.Symbol("height"), "'height'; known are a"),
        (sp.gamma(sp.Symbol("a")), "gamma, which has no C form"),
        (sp.Function("f")(sp.Symbol("a")), "f, which has no C form"),
        (sp.Piecewise((1, sp.Symbol("a") > 0), (0, True)), "no C form"),
        (sp.I * sp.Symbol("a"), "no C form"),
        (sp.oo + sp.Symbol("a"), "oo is not finite"),
        (sp.Symbol("a") * sp.exp(sp.Integer(1000)), "no finite value"),
        (sp.zoo * sp.Symbol("a"), "no C form"),
        ("a", "'a' is a str; give a number or a sympy expression"),
    ],
)
def test_what_has_no_c_form_is_refused(formula: sp.Expr, words: str) -> None:
    store = Store()
    with pytest.raises(ExpressionError, match=words):
        from_sympy(formula, {"a": store.symbol("a", Space.ANGLE, 0)})


# ---- random expressions ---------------------------------------------------------------------------------------

INPUTS = st.fixed_dictionaries({name: st.floats(-2.0, 2.0) for name in expressions.VARIABLES})


@QUICK
@given(tree=expressions.trees(), inputs=INPUTS)
def test_random_expressions_mean_the_same_staged_interpreted_and_in_sympy(
    tree: expressions.Tree, inputs: dict[str, float]
) -> None:
    truth = expressions.rounded(tree, inputs)
    assume(truth is not None)
    assert truth is not None
    store = Store()
    values = symbols(store)
    try:
        value = expressions.staged(tree, dict(zip(expressions.VARIABLES, values, strict=True)))
    except ZeroDivisionError:
        assume(False)
    tolerance = 8 * truth.error + 1e-300  # the bound is for one order of operations; sharing may take another
    (found,) = interpreted(store, [value], [inputs[k] for k in expressions.VARIABLES])
    assert abs(found - truth.value) <= tolerance
    point = {sp.Symbol(k): v for k, v in inputs.items()}
    shown = expression(value, {}).subs(point)
    assert abs(float(shown) - truth.value) <= tolerance
    exact = expressions.in_sympy(tree).subs(
        {sp.Symbol(k, real=True): sp.Rational(v) for k, v in inputs.items()}
    )
    assert abs(float(exact.evalf(30)) - truth.value) <= tolerance


@QUICK
@given(tree=expressions.trees(), inputs=INPUTS)
def test_derivatives_of_random_expressions_are_those_of_sympy(
    tree: expressions.Tree, inputs: dict[str, float]
) -> None:
    assume(expressions.rounded(tree, inputs) is not None)
    store = Store()
    values = symbols(store)
    try:
        value = expressions.staged(tree, dict(zip(expressions.VARIABLES, values, strict=True)))
        slope = derivative(value, {values[0]: 1})
    except ZeroDivisionError:
        assume(False)
    point = {sp.Symbol(k, real=True): sp.Rational(v) for k, v in inputs.items()}
    exact = complex(expressions.in_sympy(tree).diff(sp.Symbol("a", real=True)).subs(point).evalf(30))
    assume(exact == exact and abs(exact) < 1e6)
    (found,) = interpreted(store, [slope], [inputs[k] for k in expressions.VARIABLES])
    # denominators down to 1e-3, squared by the rule for quotients, a few of them in a row
    assert abs(found - exact.real) <= 1e-7 * max(1.0, abs(exact.real))
