"""For `make docs`: tables in docstrings, such as lists of fields with their meanings, stay tables.

In: what griffe read of lamc. Out: the same with such lines fenced, as Markdown would run them together.
"""

import re
from typing import Any

import griffe

_ROW = re.compile(r"\S.*? {2,}\S|\w+ {2,}\S")  # a name, a gap, what it is


class PlainTables(griffe.Extension):  # type: ignore[misc]
    """Fences runs of rows, with the lines that continue them."""

    def on_object(self, *, obj: griffe.Object, **_named: Any) -> None:
        if obj.docstring is not None:
            obj.docstring.value = fenced(obj.docstring.value)


def fenced(text: str) -> str:
    """The text with its tables between fences; what is indented already is code for Markdown."""
    lines: list[str] = []
    is_table, column = False, 0
    for line in text.splitlines():
        row = _ROW.match(line)
        column = row.end() - 1 if row and not is_table else column
        begins = row is not None or (is_table and _in_column(line, column))
        goes_on = line.startswith("  ") and is_table
        if is_table and not (begins or goes_on):
            lines += ["```", ""]
        if begins and not is_table:
            lines += ["", "```text"]
        is_table = begins or goes_on
        lines.append(line)
    return "\n".join([*lines, "```"] if is_table else lines)


def _in_column(line: str, column: int) -> bool:
    """A name that fills the gap before the column."""
    return line[column - 1 : column] == " " and " " not in line[: column - 1] and line[column:].strip() != ""
