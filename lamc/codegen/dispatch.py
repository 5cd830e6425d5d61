"""One loop over a table of what comes when, in place of many loops: for functions that do a few things in many turns.

In: which of some calls comes, again and again. Out: a table of (which, how many times in a row) and lines of C. What
the C compiler reads does not grow with the turns.
"""

from collections.abc import Iterable, Sequence
from itertools import groupby

from lamc.codegen.pieces import CTable


def in_a_row(cases: Iterable[int]) -> list[tuple[int, int]]:
    """(case, how many times in a row)."""
    return [(case, len(list(turns))) for case, turns in groupby(cases)]


def dispatch(name: str, calls: Sequence[str], cases: Iterable[int]) -> tuple[CTable, list[str]]:
    """The table `name`, and a loop that makes `calls[case]` for each of `cases`, in their order."""
    order = in_a_row(cases)
    table = CTable(name, tuple(f"{case}, {count}" for case, count in order), 2)
    lines = [
        f"for (int k = 0; k < {len(order)}; ++k) {{",
        f"  for (int left = {name}[k][1]; left > 0; --left) {{",
        f"    switch ({name}[k][0]) {{",
        *(f"    case {case}: {call} break;" for case, call in enumerate(calls)),
        "    default: break;",
        "    }",
        "  }",
        "}",
    ]
    return table, lines
