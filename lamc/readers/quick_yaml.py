"""ruamel.yaml's scanner, quicker on what design files are made of: short plain words on lines of their own.

In: the characters of a YAML text. Out: ruamel.yaml's events, marks and errors, as its own classes give them. Never:
decides anything anew; what is not plain text, a comment or a usual break is left to ruamel.yaml, and both are held
against each other by `tests/unit/test_quick_yaml.py`.
"""

import re
from functools import cached_property
from typing import Any

from ruamel.yaml import YAML
from ruamel.yaml.error import StringMark
from ruamel.yaml.parser import Parser
from ruamel.yaml.reader import Reader
from ruamel.yaml.scanner import SimpleKey
from ruamel.yaml.tokens import CommentToken, ScalarToken

from lamc.readers.popupcad_old_keys import ScannerOfOldKeys

_ENDS = "\0 \t\r\n\x85\u2028\u2029"  # of a word
_IN_BLOCK = re.compile(rf"(?:[^{_ENDS}:]|:(?![{_ENDS}]))*")  # the rest of a plain word
_IN_FLOW = re.compile(rf"(?:[^{_ENDS}:,\[\]{{}}]|:(?![{_ENDS}]))*")
_TO_TOKEN_IN_BLOCK = re.compile("( *)(#[^\0\r\n\x85\u2028\u2029]*)?")  # on the same line
_TO_TOKEN_IN_FLOW = re.compile("([ \t]*)(#[^\0\r\n\x85\u2028\u2029]*)?")
_AFTER_A_WORD = re.compile("( *)(\n[ \n]*)?")
_UNUSUAL_BREAKS = "\r\x85\u2028\u2029"
_DOCUMENT_MARKS = ("---", "...")
_NOT_PLAIN = frozenset(
    "\0 \t\r\n\x85\u2028\u2029-?:,[]{}#&*!|>'\"%@`."
)  # where a token begins; ".": may be an end
_FETCHERS = {
    "[": "fetch_flow_sequence_start",
    "{": "fetch_flow_mapping_start",
    "]": "fetch_flow_sequence_end",
    "}": "fetch_flow_mapping_end",
    ",": "fetch_flow_entry",
    "*": "fetch_alias",
    "&": "fetch_anchor",
    "!": "fetch_tag",
    "'": "fetch_single",
    '"': "fetch_double",
}


def _next(pattern: re.Pattern[str], reader: Reader) -> str:
    """What comes next of a pattern that matches nothing too."""
    found = pattern.match(reader.buffer, reader.pointer)
    assert found is not None
    return found[0]


def quick_yaml() -> YAML:
    """ruamel.yaml's safe reader with the classes of this module, for `parse` of a str."""
    yaml = YAML(typ="safe", pure=True)
    yaml.Reader, yaml.Scanner, yaml.Parser = QuickReader, QuickScanner, QuickParser
    return yaml


class QuickReader(Reader):
    """Steps over printable characters at once: none of them breaks a line."""

    _mark: Any = None

    def forward(self, length: int = 1) -> None:
        end = self.pointer + length
        if end + 1 < len(self.buffer) and self.buffer[self.pointer : end].isprintable():
            self.pointer = end
            self.index += length
            self.column += length
        else:
            super().forward(length)

    def get_mark(self) -> Any:
        """Of where the text is read; one for all who ask at the same place."""
        mark = self._mark
        if mark is None or mark.index != self.index or mark.buffer is not self.buffer:
            mark = StringMark(self.name, self.index, self.line, self.column, self.buffer, self.pointer)
            self._mark = mark
        return mark

    def over_breaks(self, text: str) -> None:
        """Steps over spaces and line feeds, the next characters."""
        self.pointer += len(text)
        self.index += len(text)
        self.line += text.count("\n")
        self.column = len(text) - text.rfind("\n") - 1


class QuickParser(Parser):
    @cached_property
    def scanner(self) -> Any:
        return self.loader.scanner


class QuickScanner(ScannerOfOldKeys):
    """Methods are those of ruamel.yaml's `Scanner`, of the same name; comments tell where they go another way."""

    @cached_property
    def reader(self) -> Any:
        return self.loader.reader

    def reset_scanner(self) -> None:
        self._settled = False  # True: the next token is known to be the first of `tokens`, until it is taken
        super().reset_scanner()

    def check_token(self, *choices: Any) -> bool:
        if not self._settled:
            self._settle()
        return bool(self.tokens) and (not choices or isinstance(self.tokens[0], choices))

    def peek_token(self) -> Any:
        if not self._settled:
            self._settle()
        return self.tokens[0] if self.tokens else None

    def get_token(self) -> Any:
        token = self.peek_token()
        if token is not None:
            self.tokens_taken += 1
            self._settled = False
            del self.tokens[0]
        return token

    def _settle(self) -> None:
        while self.need_more_tokens():
            self.fetch_more_tokens()
        self._settled = True

    def need_more_tokens(self) -> bool:
        if self.done or not self.tokens:
            return not self.done
        if not self.possible_simple_keys:
            return False
        self.stale_possible_simple_keys()
        return bool(self.next_possible_simple_key() == self.tokens_taken)

    def stale_possible_simple_keys(self) -> None:
        line, index = self.reader.line, self.reader.index
        for key in self.possible_simple_keys.values():
            if key.line != line or index - key.index > 1024:
                super().stale_possible_simple_keys()
                return

    def save_possible_simple_key(self) -> None:
        if not self.allow_simple_key:
            return
        level = len(self.flow_context)
        if level in self.possible_simple_keys:
            self.remove_possible_simple_key()
        reader = self.reader
        self.possible_simple_keys[level] = SimpleKey(
            self.tokens_taken + len(self.tokens),
            not level and self.indent == reader.column,
            reader.index,
            reader.line,
            reader.column,
            reader.get_mark(),
        )

    def fetch_more_tokens(self) -> Any:
        self.scan_to_next_token()
        self.stale_possible_simple_keys()
        reader = self.reader
        self.unwind_indent(reader.column)
        first = reader.peek()
        if first not in _NOT_PLAIN:
            return self.fetch_plain()
        if first in _FETCHERS:
            return getattr(self, _FETCHERS[first])()
        if first == ":" and self.check_value():
            return self.fetch_value()
        if first == "-" and reader.column > 0:  # else it may be the mark of a document
            return self.fetch_block_entry() if self.check_block_entry() else self.fetch_plain()
        return super().fetch_more_tokens()  # finds itself at this token, and changes nothing until then

    def check_value(self) -> Any:
        return super().check_value() if self.flow_context else self.reader.peek(1) in _ENDS

    def scan_to_next_token(self) -> Any:
        reader = self.reader
        if reader.index == 0:  # a byte order mark may stand here
            return super().scan_to_next_token()
        way = _TO_TOKEN_IN_FLOW if self.flow_context else _TO_TOKEN_IN_BLOCK
        while True:
            length = len(_next(way, reader))
            if length:
                reader.forward(length)
            if not self.scan_line_break():
                return None
            if not self.flow_context:
                self.allow_simple_key = True

    def scan_line_break(self) -> Any:
        reader = self.reader
        next_one = reader.peek()
        if next_one == "\n":
            reader.over_breaks("\n")
            return "\n"
        return super().scan_line_break() if next_one in _UNUSUAL_BREAKS else ""

    def scan_plain(self) -> Any:
        reader, in_flow = self.reader, bool(self.flow_context)
        pattern = _IN_FLOW if in_flow else _IN_BLOCK
        chunks: list[str] = []
        spaces: Any = []
        start = end = reader.get_mark()
        indent = self.indent + 1
        while reader.peek() != "#":
            word = _next(pattern, reader)
            if in_flow and "?" in word and self.scanner_processing_version == (1, 1):
                word = word[: word.index("?")]
            if not word:
                break
            self.allow_simple_key = False
            chunks += [*spaces, word]
            reader.forward(len(word))
            end = reader.get_mark()
            spaces = self.scan_plain_spaces(indent, start)
            if not spaces or (not in_flow and reader.column < indent):
                break
        token = ScalarToken("".join(chunks), True, start, end)
        if spaces and spaces[0] == "\n":
            token.add_post_comment(CommentToken("".join(spaces) + "\n", start, end))
        return token

    def scan_plain_spaces(self, indent: Any, start_mark: Any) -> Any:
        reader = self.reader
        buffer = reader.buffer
        after = _AFTER_A_WORD.match(buffer, reader.pointer)
        assert after is not None  # it matches nothing too
        text, spaces, breaks = after[0], after[1], after[2]
        following = buffer[after.end()]
        if following in _UNUSUAL_BREAKS or (breaks and buffer.startswith(_DOCUMENT_MARKS, after.end())):
            return super().scan_plain_spaces(indent, start_mark)
        if breaks is None:
            if spaces:
                reader.forward(len(spaces))
            return [spaces] if spaces else []
        reader.over_breaks(text)
        self.allow_simple_key = True
        return ["\n"] * (breaks.count("\n") - 1) or [" "]
