"""C text as tokens, and tokens as the declarations of a file.

In: C as lamc writes it: no trigraphs, no K&R definitions, one declaration of a function at a time. Out: `Token`s that
joined give the text back, and `Item`s: the declarations at file scope, each with the comment before it and the names
that it declares. Never: expands macros, or looks at types.
"""

import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from itertools import pairwise
from typing import NamedTuple

_LEXER = re.compile(
    r"""
    (?P<space>\s+)
  | (?P<comment>/\*.*?\*/|//[^\n]*)
  | (?P<directive>\#(?:\\\n|/\*.*?\*/|[^\n])*)
  | (?P<string>"(?:\\.|[^"\\\n])*"|'(?:\\.|[^'\\\n])*')
  | (?P<name>[A-Za-z_]\w*)
  | (?P<number>\.?\d(?:[eEpP][+-]|[\w.])*)
  | (?P<mark>->|\+\+|--|<<|>>|[-+*/%&|^!=<>]=|&&|\|\||\.\.\.|.)
    """,
    re.VERBOSE | re.DOTALL,
)

_OPEN, _CLOSE = "([{", ")]}"
QUIET = ("space", "comment")


class Token(
    NamedTuple
):  # tens of thousands in an export: a frozen dataclass takes three times as long to make
    kind: str  # a group of the lexer
    text: str


@dataclass(frozen=True)
class Item:
    """A declaration at file scope, or a group of directives, with the comment before it and after it on its line.

    kind  "function" (with a body), "prototype", "object", "extern" (an object that stands elsewhere), "type" or
          "directive"
    """

    unit: str
    kind: str
    tokens: tuple[Token, ...]
    declares: tuple[str, ...]
    gap: int  # empty lines before it

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Every identifier, once, those of directives too."""
        found: dict[str, None] = {}
        for token in self.tokens:
            if token.kind == "name":
                found[token.text] = None
            elif token.kind == "directive":
                found.update(dict.fromkeys(re.findall(r"[A-Za-z_]\w*", token.text)))
        return tuple(found)

    @cached_property
    def significant(self) -> list[Token]:
        return [token for token in self.tokens if token.kind not in QUIET]

    @property
    def is_static(self) -> bool:
        return any(token.text == "static" for token in self.significant[:1])


@lru_cache(maxsize=256)  # the runtime has fifty files, which every export of a process reads
def tokens(text: str) -> tuple[Token, ...]:
    """All of `text`; joined, they give it back."""
    return tuple(_scan(text))


def _scan(text: str) -> Iterator[Token]:
    return (Token(str(match.lastgroup), match.group()) for match in _LEXER.finditer(text))


def items(unit: str, stream: Sequence[Token]) -> list[Item]:
    """The declarations of a file whose includes and guards are gone."""
    found: list[Item] = []
    current: list[Token] = []
    depth, is_body, groups = 0, False, 0
    position = 0
    while position < len(stream):
        token = stream[position]
        position += 1
        current.append(token)
        is_over = False
        if token.kind == "directive" and depth == 0:
            groups += _change_of_groups(token.text)
            is_over = groups == 0
        elif token.text in _OPEN and token.kind == "mark":
            if token.text == "{" and depth == 0:
                is_body = _last_significant(current[:-1]) == ")"
            depth += 1
        elif token.text in _CLOSE and token.kind == "mark":
            depth -= 1
            is_over = depth == 0 and token.text == "}" and is_body and groups == 0
        elif token.text == ";" and depth == 0:
            is_over = groups == 0
        if is_over:
            position = _take_comment_behind(stream, position, current)
            found.append(_item(unit, current))
            current, is_body = [], False
    assert all(token.kind in QUIET for token in current), f"{unit}: what comes last is not closed"
    return found


def head_comment(text: str) -> str:
    """The comment that a file opens with; empty where there is none."""
    first = next((token for token in _scan(text) if token.kind != "space"), None)
    return first.text if first is not None and first.kind == "comment" else ""


def _change_of_groups(directive: str) -> int:
    word = directive[1:].split(None, 1)[0]
    return 1 if word in ("if", "ifdef", "ifndef") else -1 if word == "endif" else 0


def _last_significant(stream: Iterable[Token]) -> str:
    texts = [token.text for token in stream if token.kind not in QUIET]
    return texts[-1] if texts else ""


def _take_comment_behind(stream: Sequence[Token], position: int, current: list[Token]) -> int:
    """Adds the comment that follows on the same line. The position behind it."""
    ahead = list(stream[position : position + 2])
    if len(ahead) == 2 and ahead[0].kind == "space" and "\n" not in ahead[0].text:
        if ahead[1].kind == "comment":
            current += ahead
            return position + 2
    elif ahead and ahead[0].kind == "comment":
        current.append(ahead[0])
        return position + 1
    return position


def _item(unit: str, stream: list[Token]) -> Item:
    gap = 0
    while stream and stream[0].kind == "space":
        gap = max(0, min(2, stream[0].text.count("\n")) - 1)
        stream = stream[1:]
    significant = [token for token in stream if token.kind not in QUIET]
    kind, declares = _declared(significant)
    return Item(unit, kind, tuple(stream), tuple(declares), gap)


def _declared(stream: list[Token]) -> tuple[str, list[str]]:
    """Kind and names of what a declaration declares."""
    first = stream[0]
    if first.kind == "directive":
        return "directive", _declared_by_directives(stream)
    texts = [token.text for token in stream]
    if first.text in ("typedef", "enum", "struct", "union") and ("{" in texts or first.text == "typedef"):
        return "type", _declared_by_type(stream)
    until = texts.index("=") if "=" in texts else len(texts)
    if "(" in texts[:until]:
        return "function" if texts[-1] == "}" else "prototype", [texts[texts.index("(") - 1]]
    return "extern" if first.text == "extern" else "object", _declared_objects(stream)


def _declared_by_directives(stream: list[Token]) -> list[str]:
    """Macros, and functions and types within a group."""
    macros = [re.match(r"#\s*define\s+(\w+)", token.text) for token in stream if token.kind == "directive"]
    names = [match.group(1) for match in macros if match is not None]
    inner = [token for token in stream if token.kind != "directive"]
    depth, is_type = 0, False
    for before, token in zip([Token("mark", ""), *inner], inner, strict=False):
        if depth == 0 and before.kind == "name":
            ends_type = is_type and token.text in (";", "__attribute__")
            if ends_type or (token.text == "(" and before.text != "__attribute__"):
                names.append(before.text)
        if depth == 0 and token.text in ("typedef", ";"):
            is_type = token.text == "typedef"
        depth += (token.text in _OPEN and token.kind == "mark") - (
            token.text in _CLOSE and token.kind == "mark"
        )
    return list(dict.fromkeys(names))


def _declared_by_type(stream: list[Token]) -> list[str]:
    """Tag, enumerators and the name of a typedef."""
    names: list[str] = []
    depth = 0
    is_enum = any(token.text == "enum" for token in stream[:2])
    for before, token, after in zip(
        [Token("mark", ""), *stream], stream, [*stream[1:], Token("mark", "")], strict=False
    ):
        if token.kind == "name":
            is_tag = before.text in ("struct", "enum", "union") and after.text == "{"
            is_enumerator = is_enum and depth == 1 and before.text in ("{", ",")
            is_name = stream[0].text == "typedef" and depth == 0 and after.text == ";"
            if is_tag or is_enumerator or is_name:
                names.append(token.text)
        depth += (token.text == "{") - (token.text == "}")
    return list(dict.fromkeys(names))


def _declared_objects(stream: list[Token]) -> list[str]:
    """Names before =, [, a comma or the end, outside of initialisers."""
    names: list[str] = []
    depth, is_initialiser = 0, False
    for token, after in pairwise(stream):
        if depth == 0 and token.text == "=":
            is_initialiser = True
        elif depth == 0 and token.text == ",":
            is_initialiser = False
        elif depth == 0 and not is_initialiser and token.kind == "name" and after.text in "=[,;":
            names.append(token.text)
        depth += (token.text in _OPEN) - (token.text in _CLOSE) if token.kind == "mark" else 0
    return names
