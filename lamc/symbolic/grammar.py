"""The grammar of lamc's expressions, whatever their values are: staged scalars, dimensions of a design.

Goes in: text, and what numbers, names, sums, … make. Comes out: what they make of the whole. The language is numbers,
names, pi, + - * / **, parentheses and the functions of `FUNCTIONS`. There is nothing else to reach: no attribute, no
index, no call of anything but those functions, and nothing is ever evaluated by Python. Length and depth are bounded,
numbers are floats, so no expression takes long to read.
"""

import math
import re
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Generic, TypeVar

from lamc.basics.errors import ExpressionError
from lamc.symbolic.functions import FUNCTIONS

MAX_LENGTH = 1000
MAX_DEPTH = 40
CONSTANTS: Mapping[str, float] = {"pi": math.pi}

_TOKEN = re.compile(
    r"\s*(?:(\d+\.?\d*(?:[eE][+-]?\d+)?|\.\d+(?:[eE][+-]?\d+)?)|([A-Za-z_]\w*)|(\*\*|[-+*/^(),]))",
    re.ASCII,  # else ٣ would be a digit
)
_SPACE = re.compile(r"\s*", re.ASCII)
T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class Token:
    kind: str  # "number", "name", "sign" or "end"
    text: str
    column: int


class Grammar(ABC, Generic[T]):
    """Recursive descent; builds the value as it reads, by the methods that say what each construct makes."""

    def __init__(self, text: str) -> None:
        check_length(text)
        self.text = text
        self.tokens = tokens_of(text)
        self.position = 0
        self.depth = 0

    @abstractmethod
    def number(self, token: Token) -> T:
        """What a finite number makes."""

    @abstractmethod
    def name(self, token: Token) -> T:
        """What a name that is no function makes."""

    @abstractmethod
    def negative(self, value: T) -> T:
        """What -value makes."""

    @abstractmethod
    def combined(self, sign: str, left: T, right: T, column: int) -> T:
        """What `left sign right` makes, sign being one of + - * / ^; column: where `right` stands."""

    @abstractmethod
    def called(self, token: Token, arguments: Sequence[T]) -> T:
        """What a function of as many arguments as it takes makes."""

    @property
    def token(self) -> Token:
        return self.tokens[self.position]

    def error(self, problem: str, column: int | None = None) -> ExpressionError:
        at = self.token.column if column is None else column
        return ExpressionError(f"expression {self.text!r}, column {at}: {problem}")

    def accept(self, *signs: str) -> str | None:
        if self.token.kind == "sign" and self.token.text in signs:
            self.position += 1
            return self.tokens[self.position - 1].text
        return None

    def nested(self, read: Callable[[], T]) -> T:
        self.depth += 1
        if self.depth > MAX_DEPTH:
            raise self.error(f"nested deeper than {MAX_DEPTH} levels; split the expression")
        value = read()
        self.depth -= 1
        return value

    def whole(self) -> T:
        value = self.sum()
        if self.token.kind != "end":
            raise self.error(f"{self.token.text!r} is not expected here")
        return value

    def sum(self) -> T:
        value = self.product()
        while sign := self.accept("+", "-"):
            column = self.token.column
            value = self.combined(sign, value, self.product(), column)
        return value

    def product(self) -> T:
        value = self.signed()
        while sign := self.accept("*", "/"):
            column = self.token.column
            value = self.combined(sign, value, self.signed(), column)
        return value

    def signed(self) -> T:
        if sign := self.accept("+", "-"):
            value = self.nested(self.signed)
            return value if sign == "+" else self.negative(value)
        return self.power()

    def power(self) -> T:
        base = self.atom()
        if self.accept("**", "^"):
            column = self.token.column
            return self.combined("^", base, self.nested(self.signed), column)
        return base

    def atom(self) -> T:
        token = self.token
        if token.kind == "number":
            self.position += 1
            if not math.isfinite(float(token.text)):
                raise self.error(f"{token.text} is too large for a number", token.column)
            return self.number(token)
        if token.kind == "name":
            self.position += 1
            return self.function(token) if token.text in FUNCTIONS else self.name(token)
        if self.accept("("):
            value = self.nested(self.sum)
            if not self.accept(")"):
                raise self.error("')' is missing")
            return value
        raise self.error(f"{token.text!r} is not expected here" if token.text else "it ends too early")

    def function(self, token: Token) -> T:
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
        return self.called(token, arguments)


def tokens_of(text: str) -> list[Token]:
    """The signs, names and numbers, and an end. Raises ExpressionError for a sign outside the language."""
    tokens: list[Token] = []
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
                tokens.append(Token(kind, part, match.end() - len(part) + 1))
        position = match.end()
    return [*tokens, Token("end", "", end + 1)]


def check_length(text: str) -> None:
    if len(text) > MAX_LENGTH:
        raise ExpressionError(
            f"expression {text[:24] + '…'!r} has {len(text)} characters; at most {MAX_LENGTH} are allowed"
        )
