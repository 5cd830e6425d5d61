"""The signs of expressions of measures: numbers, names with dots, names in quotes, operators.

Goes in: text. Comes out: tokens with their columns, or an ExpressionError for a sign that is not in the language.
"""

import re
from dataclasses import dataclass

from lamc.basics.errors import ExpressionError

_TOKEN = re.compile(
    r"\s*(?:([0-9]+\.?[0-9]*(?:[eE][+-]?[0-9]+)?|\.[0-9]+(?:[eE][+-]?[0-9]+)?)"
    r"|([^\W\d]\w*(?:\.\w+)*|°)|'([^']*)'|\"([^\"]*)\"|(\*\*|[-+*/^(),\[\]<>]))"
)
_KINDS = ("number", "name", "quoted", "quoted", "sign")


@dataclass(frozen=True, slots=True)
class Token:
    kind: str  # "number", "name", "quoted", "sign" or "end"
    text: str
    column: int


def tokens_of(text: str) -> list[Token]:
    """All tokens, and one for the end."""
    tokens: list[Token] = []
    position, end = 0, len(text.rstrip())
    while position < end:
        match = _TOKEN.match(text, position)
        if match is None:
            column = position + len(text[position:]) - len(text[position:].lstrip()) + 1
            raise ExpressionError(
                f"measure {text!r}, column {column}: {text[column - 1]!r} is not in the language"
            )
        for kind, part in zip(_KINDS, match.groups(), strict=True):
            if part is not None:
                quotes = 2 if kind == "quoted" else 0
                tokens.append(Token(kind, part, match.end() - len(part) - quotes + 1))
        position = match.end()
    return [*tokens, Token("end", "", end + 1)]
