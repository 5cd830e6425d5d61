"""Antiderivatives of staged values, for the energy of a torque that an expression gives.

Goes in: a staged value and the value that it is a function of. Comes out: a function whose derivative it is, staged, or
None: the rules below cover sums of polynomials and of elementary functions of a·x + b, and no more. Never: quadrature.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence

from lamc.symbolic.scalars import Scalar, Value, call, cos, power, sin
from lamc.symbolic.staging import Store

MAX_DEGREE = 32


def antiderivative(value: Scalar, x: Value) -> Scalar | None:
    """F with dF/dx = value, its constant left open; None where no rule applies. `x` may be any node."""
    if not _depends(value, x):
        return value * x
    assert isinstance(value, Value)
    coefficients = _polynomial(value, x)
    if coefficients is not None:
        return _sum(c * power(x, k + 1) / (k + 1) for k, c in enumerate(coefficients))
    operation, arguments = _parts(value)
    result: Scalar | None
    match operation:
        case "+" | "-":
            parts = [antiderivative(a, x) for a in arguments]
            if parts[0] is None or parts[1] is None:
                return None
            result = parts[0] + parts[1] if operation == "+" else parts[0] - parts[1]
        case "neg":
            part = antiderivative(arguments[0], x)
            result = None if part is None else -part
        case "*":
            result = _product(arguments, x)
        case "min" | "max":  # the mean, and half the distance to either side
            ends = antiderivative(arguments[0] + arguments[1], x)
            apart = antiderivative(call("abs", arguments[0] - arguments[1]), x)
            if ends is None or apart is None:
                return None
            result = 0.5 * (ends + apart if operation == "max" else ends - apart)
        case _:
            result = _of_line(Value(value.store, value.index, 1), x)
    return None if result is None else value.sign * result


def _product(factors: Sequence[Scalar], x: Value) -> Scalar | None:
    for factor, other in (tuple(factors), tuple(factors)[::-1]):
        if not _depends(factor, x):
            part = antiderivative(other, x)
            return None if part is None else factor * part
    return None


def _of_line(value: Value, x: Value) -> Scalar | None:
    """f(a x + b) has the antiderivative F(a x + b) / a."""
    operation, arguments = _parts(value)
    line = _polynomial(arguments[0], x)
    if line is None or len(line) > 2:
        return None
    if len(line) == 1:  # x has cancelled
        return None if any(_depends(a, x) for a in arguments[1:]) else value * x
    y, slope = arguments[0], line[1]
    if operation == "pow":
        exponent = arguments[1]
        if isinstance(exponent, Value) or exponent == -1:
            return None
        return power(y, exponent + 1) / ((exponent + 1) * slope)
    rule = _RULES.get(operation)
    return None if rule is None else rule(y) / slope


def _log_cosh(y: Scalar) -> Scalar:
    """log cosh y, less log 2, without overflow."""
    size = call("abs", y)
    return size + call("log", 1 + call("exp", -2 * size))


_RULES: Mapping[str, Callable[[Scalar], Scalar]] = {
    "sin": lambda y: -cos(y),
    "cos": sin,
    "tan": lambda y: -call("log", call("abs", cos(y))),
    "asin": lambda y: y * call("asin", y) + call("sqrt", 1 - y * y),
    "acos": lambda y: y * call("acos", y) - call("sqrt", 1 - y * y),
    "atan": lambda y: y * call("atan", y) - 0.5 * call("log", 1 + y * y),
    "sinh": lambda y: call("cosh", y),
    "cosh": lambda y: call("sinh", y),
    "tanh": _log_cosh,
    "exp": lambda y: call("exp", y),
    "log": lambda y: y * call("log", y) - y,
    "sqrt": lambda y: y * call("sqrt", y) / 1.5,
    "reciprocal": lambda y: call("log", call("abs", y)),
    "abs": lambda y: 0.5 * (y * call("abs", y)),
    "sign": lambda y: call("abs", y),
}


def _parts(value: Value) -> tuple[str, list[Scalar]]:
    """Operation and arguments of the node, without the value's sign."""
    store: Store = value.store
    return store.operations[value.index], [store.scalar(i) for i in store.arguments[value.index]]


def _depends(value: Scalar, x: Value) -> bool:
    return isinstance(value, Value) and x.index in value.store.live([value])


def _polynomial(value: Scalar, x: Value) -> list[Scalar] | None:
    """Coefficients by rising power of x, the last not zero; None for what is no polynomial."""
    if not _depends(value, x):
        return [value]
    assert isinstance(value, Value)
    if value.index == x.index:
        return [0, value.sign * x.sign]
    operation, arguments = _parts(value)
    if operation not in ("+", "-", "*", "neg"):
        return None
    parts = [_polynomial(a, x) for a in arguments]
    first, second = parts[0], parts[-1]
    if first is None or second is None:
        return None
    match operation:
        case "neg":
            result = [-c for c in first]
        case "*":
            if len(first) + len(second) > MAX_DEGREE:
                return None
            result = [
                _sum(first[i] * second[k - i] for i in range(len(first)) if 0 <= k - i < len(second))
                for k in range(len(first) + len(second) - 1)
            ]
        case _:
            sign = 1 if operation == "+" else -1
            pairs = zip(_padded(first, len(second)), _padded(second, len(first)), strict=True)
            result = [a + sign * b for a, b in pairs]
    while len(result) > 1 and not isinstance(result[-1], Value) and result[-1] == 0:
        result.pop()
    return [value.sign * c for c in result]


def _padded(coefficients: list[Scalar], count: int) -> list[Scalar]:
    return coefficients + [0] * (count - len(coefficients))


def _sum(terms: Iterable[Scalar]) -> Scalar:
    total: Scalar = 0
    for term in terms:
        total = total + term
    return total
