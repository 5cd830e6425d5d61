"""The expressions of measures, such as "rms(tip.z - 5 mm)": read once, evaluated for every run.

Goes in: text, the names of a run's quantities, and of what is varied, with their units, the names of its events. Comes
out: a `Term`. The
language is numbers, with units or without, the names, pi, + - * / **, parentheses, the functions of one and two numbers
that all expressions of lamc have, and those over time below. There is nothing else to reach, and nothing is ever
evaluated by Python. A number without a unit is in SI, whatever it is added to.

    max min mean rms integral first last    of a quantity over the run; of two: the larger, the smaller
    x[-1]                                   a row of a quantity: 0 is the first, -1 the last
    at(x, 0.5 s)                            the value at a time
    time_of(x > 5 mm), time_of(max(x))      the first time at which it is so, s
    events('name'), events()                how many there were
    time_of('name'), time_of('name', -1)    the time of the first event of a name, of the last
"""

import math
from collections.abc import Callable

from lamc.basics.checks import did_you_mean
from lamc.basics.errors import DesignError, ExpressionError
from lamc.studies.dimensions import PLAIN, factor_of, is_unit
from lamc.studies.measure_names import Outputs
from lamc.studies.measure_terms import (
    OVER_TIME,
    Term,
    added,
    counted,
    event_time,
    extreme_time,
    first_time,
    multiplied,
    negated,
    raised,
    reduced,
    row,
    valued_at,
)
from lamc.studies.measure_terms import function as applied
from lamc.studies.measure_tokens import Token, tokens_of
from lamc.symbolic.expression import MAX_DEPTH, MAX_LENGTH
from lamc.symbolic.functions import FUNCTIONS

_WORDS = ("at", "time_of", "events", *OVER_TIME)


def read(text: str, outputs: Outputs) -> Term:
    """The term of a text in names of `outputs`.

    Raises ExpressionError, with the column, for what is outside the language, unknown names with the nearest one, and
    units that do not fit.
    """
    if len(text) > MAX_LENGTH:
        raise ExpressionError(
            f"measure {text[:24] + '…'!r} has {len(text)} characters; at most {MAX_LENGTH} are allowed"
        )
    return _Reader(text, outputs).whole()


def read_part(text: str, outputs: Outputs) -> Term:
    """The term of a text that has been read as a part of another, and may have a value at every time."""
    return _Reader(text, outputs).sum()


class _Reader:
    """Recursive descent; builds the term as it reads."""

    def __init__(self, text: str, outputs: Outputs) -> None:
        self.text, self.outputs = text, outputs
        self.tokens = tokens_of(text)
        self.position = 0
        self.depth = 0

    @property
    def token(self) -> Token:
        return self.tokens[self.position]

    def error(self, problem: str, column: int | None = None) -> ExpressionError:
        at = self.token.column if column is None else column
        return ExpressionError(f"measure {self.text!r}, column {at}: {problem}")

    def accept(self, *signs: str) -> str | None:
        if self.token.kind == "sign" and self.token.text in signs:
            self.position += 1
            return self.tokens[self.position - 1].text
        return None

    def need(self, sign: str) -> None:
        if not self.accept(sign):
            raise self.error(f"{sign!r} is missing")

    def built(self, column: int, make: Callable[[], Term]) -> Term:
        """A term, with the column in what is wrong with its units."""
        try:
            return make()
        except ExpressionError as error:
            raise self.error(error.message, column) from error

    def nested(self, read: Callable[[], Term]) -> Term:
        self.depth += 1
        if self.depth > MAX_DEPTH:
            raise self.error(f"nested deeper than {MAX_DEPTH} levels; split the expression")
        term = read()
        self.depth -= 1
        return term

    def whole(self) -> Term:
        term = self.sum()
        if self.token.kind != "end":
            hint = " outside of time_of(…)" if self.token.text in "<>" else ""
            raise self.error(f"{self.token.text!r} is not expected here{hint}")
        if term.over_time:
            raise self.error(
                "it has a value at every time; take one, as max(…), last(…), mean(…) or at(…, 0.5 s)", 1
            )
        return term

    def sum(self) -> Term:
        term = self.product()
        while sign := self.accept("+", "-"):
            column, left = self.token.column, term
            right = self.product()
            if sign == "-":
                right = negated(right)
            term = self.built(column, lambda left=left, right=right: added(left, right))  # type: ignore[misc]
        return term

    def product(self) -> Term:
        term, measured = self.signed()
        while sign := self.accept("*", "/"):
            column, left = self.token.column, term
            if measured and self.is_unit_here():
                right = self.unit()
            else:
                right, measured = self.signed()
                measured = measured and sign == "*"
            term = self.built(column, lambda left=left, right=right: multiplied(left, right, sign))  # type: ignore[misc]
        return term

    def signed(self) -> tuple[Term, bool]:
        """A term, and whether it is a number with a unit, to which more units may follow."""
        if sign := self.accept("+", "-"):
            self.depth += 1
            if self.depth > MAX_DEPTH:
                raise self.error(f"nested deeper than {MAX_DEPTH} levels; split the expression")
            term, measured = self.signed()
            self.depth -= 1
            return (term if sign == "+" else negated(term)), measured
        return self.power()

    def power(self) -> tuple[Term, bool]:
        column = self.token.column
        base, measured = self.atom()
        while self.accept("["):
            base = self.row(base)
        if not measured and self.accept("**", "^"):
            exponent = self.nested(lambda: self.signed()[0])
            return self.built(column, lambda: raised(base, exponent)), False
        return base, measured

    def row(self, term: Term) -> Term:
        column = self.token.column
        sign = -1 if self.accept("-") else 1
        token = self.token
        if token.kind != "number" or not token.text.isdigit() or len(token.text) > 9:
            raise self.error("a row is a whole number: 0 is the first, -1 the last")
        self.position += 1
        self.need("]")
        return self.built(column, lambda: row(term, sign * int(token.text)))

    def atom(self) -> tuple[Term, bool]:
        token = self.token
        if token.kind == "number":
            return self.number()
        if token.kind == "quoted":
            self.position += 1
            return self.named(token), False
        if token.kind == "name":
            self.position += 1
            called = self.token.kind == "sign" and self.token.text == "("
            known = token.text in FUNCTIONS or token.text in _WORDS
            if called and known:
                self.position += 1
                return self.call(token), False
            if self.outputs.knows(token.text) or not known:
                return self.named(token), False
            raise self.error(f"{token.text} is a function: write {token.text}(…)", token.column)
        if self.accept("("):
            term = self.nested(self.sum)
            self.need(")")
            return term, False
        raise self.error(f"{token.text!r} is not expected here" if token.text else "it ends too early")

    def number(self) -> tuple[Term, bool]:
        token = self.token
        value = float(token.text)
        if not math.isfinite(value):
            raise self.error(f"{token.text} is too large for a number", token.column)
        self.position += 1
        plain = Term.of_number(value, PLAIN, is_bare=True)
        if self.token.kind != "name":
            return plain, False
        if not self.is_unit_here():
            raise self.error(
                f"{self.token.text!r} is no unit, and between a number and a name there is a sign"
            )
        return multiplied(plain, self.unit(), "*"), True

    def is_unit_here(self) -> bool:
        return self.token.kind == "name" and is_unit(self.token.text)

    def unit(self) -> Term:
        """One of a unit, with its power."""
        token = self.token
        self.position += 1
        try:
            factor, unit = factor_of(token.text)
        except DesignError as error:
            raise self.error(error.message, token.column) from error
        term = Term.of_number(factor, unit)
        if self.accept("**", "^"):
            exponent = self.signed()[0]
            return self.built(token.column, lambda: raised(term, exponent))
        return term

    def named(self, token: Token) -> Term:
        if token.text == "pi" and not self.outputs.knows("pi"):
            return Term.of_number(math.pi, PLAIN, is_bare=True)
        return self.built(token.column, lambda: self.outputs.term(token.text))

    def call(self, token: Token) -> Term:
        """What a function gives; its name and the bracket after it have been read."""
        if token.text == "events":
            return self.event_call(counted)
        if token.text == "time_of":
            if self.token.kind == "quoted" and not self.outputs.knows(self.token.text):
                return self.event_call(event_time)
            return self.time_of()
        arguments = [self.nested(self.sum)]
        while self.accept(","):
            arguments.append(self.nested(self.sum))
        self.need(")")
        return self.built(token.column, lambda: self.made(token, arguments))

    def made(self, token: Token, arguments: list[Term]) -> Term:
        if token.text == "at":
            return valued_at(*self.counted(token, arguments, 2))
        if token.text in OVER_TIME and len(arguments) == 1:
            return reduced(token.text, arguments[0])
        if token.text not in FUNCTIONS:
            return reduced(token.text, *self.counted(token, arguments, 1))
        return applied(token.text, self.counted(token, arguments, FUNCTIONS[token.text].arity))

    def counted(self, token: Token, arguments: list[Term], count: int) -> list[Term]:
        if len(arguments) != count:
            raise ExpressionError(
                f"{token.text} takes {count} argument{'s' * (count > 1)}, not {len(arguments)}"
            )
        return arguments

    def time_of(self) -> Term:
        if self.token.text in ("max", "min") and self.tokens[self.position + 1].text == "(":
            start, name = self.position, self.token.text
            self.position += 2
            term = self.nested(self.sum)
            if self.accept(")") and self.accept(")"):
                return self.built(self.tokens[start].column, lambda: extreme_time(name, term))
            self.position = start
        left = self.nested(self.sum)
        sign, column = self.accept("<", ">"), self.token.column
        if sign is None:
            raise self.error("time_of takes a comparison, x > 5 mm, an extreme, max(x), or an event, 'name'")
        right = self.nested(self.sum)
        self.need(")")
        return self.built(column, lambda: first_time(left, right, sign))

    def event_call(self, make: Callable[[str | None, int], Term]) -> Term:
        name, which, token = None, 0, self.token
        if token.kind == "quoted":
            self.position += 1
            name = token.text
            if name not in self.outputs.events:
                raise self.error(
                    f"no event is named {name!r}; {did_you_mean(name, list(self.outputs.events))}",
                    token.column,
                )
            if make is event_time and self.accept(","):
                sign = -1 if self.accept("-") else 1
                number = self.token.text
                if not number.isdigit() or len(number) > 9:
                    raise self.error("which event is a whole number: 0 is the first, -1 the last")
                self.position += 1
                which = sign * int(number)
        self.need(")")
        return make(name, which)
