"""Numbers as tables and designs write them, told from words, gaps and expressions.

In: text. Out: whether it is a number, or begins as a quantity; it converts nothing. Nothing but ASCII digits counts:
`float` also takes "1_000", "nan" and digits of other scripts.
"""

import re

# Digits are possessive, so that a long row has one reading. Groups are not: CPython before 3.11.5 lets a possessive or
# atomic group match less than it holds, "0E" for a number (CPython issue 106052).
_EXPONENT = r"[eE][-+]?[0-9]++"
_NUMBER = re.compile(rf"[-+]?(?:[0-9]++(?:\.[0-9]*+)?|\.[0-9]++)(?:{_EXPONENT})?", re.ASCII)
_COMMA_NUMBER = re.compile(rf"[-+]?[0-9]*+,[0-9]++(?:{_EXPONENT})?", re.ASCII)

# No expression begins with a number and goes on with a unit: "3 N*mm" is a quantity, "3*sin(t)" is none.
_MEASURED = re.compile(
    rf"\s*[-+]?(?:\.[0-9]++|[0-9]++(?:\.[0-9]*+)?)(?:{_EXPONENT}|(?!{_EXPONENT}))\s*[A-Za-zµμ°(]", re.ASCII
)


def is_number(text: str) -> bool:
    """True for a number with a decimal point, or without."""
    return _NUMBER.fullmatch(text) is not None


def is_comma_number(text: str) -> bool:
    """True for a number with a decimal comma."""
    return _COMMA_NUMBER.fullmatch(text) is not None


def is_measured(text: str) -> bool:
    """True for a number with a unit, which no expression looks like."""
    return _MEASURED.match(text) is not None
