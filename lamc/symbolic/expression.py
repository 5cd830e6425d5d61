"""The expressions that scenes may hold, such as "0.01*sin(2*pi*50*t) - 1e-4*rate".

Goes in: text. Comes out: staged values. The language is numbers, the names the effect offers, pi, + - * / **,
parentheses and the functions of `FUNCTIONS`. There is nothing else to reach: no attribute, no index, no call of
anything but those functions, and nothing is ever evaluated by Python. Length and depth are bounded, numbers are
floats, so no expression takes long to read.
"""

import math
import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from itertools import pairwise

from lamc.basics.errors import ExpressionError
from lamc.symbolic.functions import FUNCTIONS
from lamc.symbolic.scalars import Scalar, Value, call, cos, power, sin

MAX_LENGTH = 1000
MAX_DEPTH = 40
CONSTANTS: Mapping[str, float] = {"pi": math.pi}

_TOKEN = re.compile(
    r"\s*(?:(\d+\.?\d*(?:[eE][+-]?\d+)?|\.\d+(?:[eE][+-]?\d+)?)|([A-Za-z_]\w*)|(\*\*|[-+*/^(),]))",
    re.ASCII,  # else ٣ would be a digit
)
_SPACE = re.compile(r"\s*", re.ASCII)


@dataclass(frozen=True, slots=True)
class _Token:
    kind: str  # "number", "name", "sign" or "end"
    text: str
    column: int


class _Reader:
    """Recursive descent; builds the value as it reads."""

    def __init__(self, text: str, names: Mapping[str, Scalar]) -> None:
        self.text = text
        self.names = {**CONSTANTS, **names}
        self.tokens = _tokens(text)
        self.position = 0
        self.depth = 0

    @property
    def token(self) -> _Token:
        return self.tokens[self.position]

    def error(self, problem: str, column: int | None = None) -> ExpressionError:
        at = self.token.column if column is None else column
        return ExpressionError(f"expression {self.text!r}, column {at}: {problem}")

    def accept(self, *signs: str) -> str | None:
        if self.token.kind == "sign" and self.token.text in signs:
            self.position += 1
            return self.tokens[self.position - 1].text
        return None

    def nested(self, read: Callable[[], Scalar]) -> Scalar:
        self.depth += 1
        if self.depth > MAX_DEPTH:
            raise self.error(f"nested deeper than {MAX_DEPTH} levels; split the expression")
        value = read()
        self.depth -= 1
        return value

    def whole(self) -> Scalar:
        value = self.sum()
        if self.token.kind != "end":
            raise self.error(f"{self.token.text!r} is not expected here")
        if not isinstance(value, Value) and not math.isfinite(value):
            raise self.error(f"the value is {value}; it must be finite", 1)
        return value

    def sum(self) -> Scalar:
        value = self.product()
        while sign := self.accept("+", "-"):
            term = self.product()
            value = value + term if sign == "+" else value - term
        return value

    def product(self) -> Scalar:
        value = self.signed()
        while sign := self.accept("*", "/"):
            column = self.token.column
            factor = self.signed()
            if sign == "/" and factor == 0:
                raise self.error("division by zero", column)
            value = value * factor if sign == "*" else value / factor
        return value

    def signed(self) -> Scalar:
        if sign := self.accept("+", "-"):
            value = self.nested(self.signed)
            return value if sign == "+" else -value
        return self.power()

    def power(self) -> Scalar:
        base = self.atom()
        if self.accept("**", "^"):
            return power(base, self.nested(self.signed))
        return base

    def atom(self) -> Scalar:
        token = self.token
        if token.kind == "number":
            self.position += 1
            if not math.isfinite(float(token.text)):
                raise self.error(f"{token.text} is too large for a number", token.column)
            return float(token.text)
        if token.kind == "name":
            self.position += 1
            return self.named(token)
        if self.accept("("):
            value = self.nested(self.sum)
            if not self.accept(")"):
                raise self.error("')' is missing")
            return value
        raise self.error(f"{token.text!r} is not expected here" if token.text else "it ends too early")

    def named(self, token: _Token) -> Scalar:
        if token.text in FUNCTIONS:
            return self.function(token)
        if token.text not in self.names:
            known = ", ".join([*self.names, *FUNCTIONS])
            raise self.error(f"{token.text!r} is not known; known are {known}", token.column)
        return self.names[token.text]

    def function(self, token: _Token) -> Scalar:
        if not self.accept("("):
            raise self.error(f"{token.text} is a function: write {token.text}(…)")
        arguments = [self.nested(self.sum)]
        while self.accept(","):
            arguments.append(self.nested(self.sum))
        if not self.accept(")"):
            raise self.error("')' is missing")
        arity = FUNCTIONS[token.text].arity
        if len(arguments) != arity:
            raise self.error(f"{token.text} takes {arity} arguments, not {len(arguments)}", token.column)
        match token.text:
            case "sin":
                return sin(arguments[0])
            case "cos":
                return cos(arguments[0])
            case "pow":
                return power(arguments[0], arguments[1])
            case name:
                return call(name, *arguments)


def _tokens(text: str) -> list[_Token]:
    tokens: list[_Token] = []
    position = 0
    end = len(text.rstrip(" \t\n\r\f\v"))
    while position < end:
        match = _TOKEN.match(text, position)
        if match is None or match.end() > len(text):
            gap = _SPACE.match(text, position)
            column = (gap.end() if gap else position) + 1
            raise ExpressionError(
                f"expression {text!r}, column {column}: {text[column - 1]!r} is not in the language"
            )
        for kind, part in zip(("number", "name", "sign"), match.groups(), strict=True):
            if part is not None:
                tokens.append(_Token(kind, part, match.end() - len(part) + 1))
        position = match.end()
    return [*tokens, _Token("end", "", end + 1)]


def _check_length(text: str) -> None:
    if len(text) > MAX_LENGTH:
        raise ExpressionError(
            f"expression {text[:24] + '…'!r} has {len(text)} characters; at most {MAX_LENGTH} are allowed"
        )


def names_in(text: str) -> Mapping[str, int]:
    """Names in `text` that are no constants and called as no function: each with the column where it first stands.

    Raises ExpressionError for a sign outside the language.
    """
    _check_length(text)
    tokens = _tokens(text)
    found: dict[str, int] = {}
    for token, following in pairwise(tokens):
        known = token.text in FUNCTIONS or token.text in CONSTANTS
        if token.kind == "name" and not known and following.text != "(":
            found.setdefault(token.text, token.column)
    return found


def in_python(text: str, names: Iterable[str]) -> str:
    """The expression as Python writes it, of floats, `names`, those of `math`, and sign; any other name is an item of
    `inputs`. Raises ExpressionError for what is no sign, name or number; what else is outside the language is for
    `stage` to tell."""
    known = {*names, *FUNCTIONS, *CONSTANTS}
    parts = []
    for token in _tokens(text):
        if token.kind == "number":
            parts.append(repr(float(token.text)))
        elif token.kind == "name" and token.text not in known:
            parts.append(f'inputs["{token.text}"]')
        else:
            parts.append(token.text.replace("^", "**"))
    return "".join(parts)


def stage(text: str, names: Mapping[str, Scalar]) -> Scalar:
    """The value of `text`, in which `names` stand for the given scalars.

    Raises ExpressionError, with the column, for everything outside the language and for constants that overflow.
    """
    _check_length(text)
    reader = _Reader(text, names)
    try:
        return reader.whole()
    except ExpressionError:
        raise
    except (ArithmeticError, ValueError) as error:
        raise reader.error(f"a constant part has no finite value ({error})") from error
