"""The expressions that scenes may hold, such as "0.01*sin(2*pi*50*t) - 1e-4*rate".

Goes in: text of the language of `lamc.symbolic.grammar`, whose names are those that the effect offers. Comes out:
staged values.
"""

import math
from collections.abc import Iterable, Mapping, Sequence
from itertools import pairwise

from lamc.basics.errors import ExpressionError
from lamc.symbolic.functions import FUNCTIONS
from lamc.symbolic.grammar import CONSTANTS as CONSTANTS
from lamc.symbolic.grammar import MAX_DEPTH as MAX_DEPTH
from lamc.symbolic.grammar import MAX_LENGTH as MAX_LENGTH
from lamc.symbolic.grammar import Grammar, Token, check_length, tokens_of
from lamc.symbolic.scalars import Scalar, Value, call, cos, power, sin


class _Stager(Grammar[Scalar]):
    """What is constant folds."""

    def __init__(self, text: str, names: Mapping[str, Scalar]) -> None:
        super().__init__(text)
        self.names = {**CONSTANTS, **names}

    def whole(self) -> Scalar:
        value = super().whole()
        if not isinstance(value, Value) and not math.isfinite(value):
            raise self.error(f"the value is {value}; it must be finite", 1)
        return value

    def number(self, token: Token) -> Scalar:
        return float(token.text)

    def name(self, token: Token) -> Scalar:
        if token.text not in self.names:
            known = ", ".join([*self.names, *FUNCTIONS])
            raise self.error(f"{token.text!r} is not known; known are {known}", token.column)
        return self.names[token.text]

    def negative(self, value: Scalar) -> Scalar:
        return -value

    def combined(self, sign: str, left: Scalar, right: Scalar, column: int) -> Scalar:
        if sign == "/" and right == 0:
            raise self.error("division by zero", column)
        match sign:
            case "+":
                return left + right
            case "-":
                return left - right
            case "*":
                return left * right
            case "/":
                return left / right
        return power(left, right)

    def called(self, token: Token, arguments: Sequence[Scalar]) -> Scalar:
        match token.text:
            case "sin":
                return sin(arguments[0])
            case "cos":
                return cos(arguments[0])
            case "pow":
                return power(arguments[0], arguments[1])
            case name:
                return call(name, *arguments)


def names_in(text: str) -> Mapping[str, int]:
    """Names in `text` that are no constants and called as no function: each with the column where it first stands.

    Raises ExpressionError for a sign outside the language.
    """
    check_length(text)
    tokens = tokens_of(text)
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
    for token in tokens_of(text):
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
    reader = _Stager(text, names)
    try:
        return reader.whole()
    except ExpressionError:
        raise
    except (ArithmeticError, ValueError) as error:
        raise reader.error(f"a constant part has no finite value ({error})") from error
