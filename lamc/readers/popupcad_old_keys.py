"""Aliases as keys without a space before their colon, as older YAML writers left them.

In: the characters of a YAML text. Out: ruamel.yaml's tokens. Never: changes what a text means that YAML 1.2 can read.
"""

from typing import Any

from ruamel.yaml.scanner import Scanner

_AFTER_A_NAME = frozenset("\0 \t\r\n\x85\u2028\u2029\ufeff,[]{}")  # of an anchor


class ScannerOfOldKeys(Scanner):
    """YAML 1.2 lets the name of an anchor hold a colon, so that `*id003: 0.65` is an alias named `id003:`. Older
    writers mean the key `*id003`. They are believed where the file has no anchor of the longer name and has the
    shorter one; such a text is refused otherwise, so nothing that could be read changes its meaning."""

    def __init__(self, *arguments: Any, **named: Any) -> None:
        super().__init__(*arguments, **named)
        self._anchors: set[str] = set()

    def scan_anchor(self, TokenClass: Any) -> Any:
        reader = self.reader
        if reader.peek() != "*":
            token = super().scan_anchor(TokenClass)
            self._anchors.add(token.value)
            return token
        length = 1
        while reader.peek(length) not in _AFTER_A_NAME:
            length += 1
        name = reader.prefix(length)[1:]
        if name in self._anchors or not (name.endswith(":") and name[:-1] in self._anchors):
            return super().scan_anchor(TokenClass)
        start = reader.get_mark()
        reader.forward(length - 1)
        return TokenClass(name[:-1], start, reader.get_mark())
