"""Text of a design in a line of Markdown: READMEs of all exports.

In: any text. Out: text that Markdown shows as it is.
"""

import re

# What Markdown reads as markup, where it does: _ within a word is none.
_MARKUP = re.compile(r"([\\`*\[\]<>|~$&@#]|(?<![A-Za-z0-9])_|_(?![A-Za-z0-9]))")


def markdown(text: str) -> str:
    """`text` as it is, in a line of Markdown: no markup, no tag, no cell's end, no character that steers."""
    line = "".join(ch if ch.isprintable() else " " for ch in text)
    return _MARKUP.sub(r"\\\1", line)
