"""The summary of a study for people.

In: a `Table`. Out: lines of text. It computes nothing but what the table is sorted by.
"""

from collections.abc import Sequence

import numpy as np

from lamc.basics.numbers import shortened, shown_number
from lamc.studies.bench import MISSING, OK
from lamc.studies.statistics import SHARES, indices, quantiles
from lamc.studies.table import Table

_MOST_REASONS = 3


def study_summary(table: Table) -> str:
    """How many points went how, and what was measured."""
    lines = [f"design    {table.design}", f"points    {_tally(table)}"]
    lines += [f"          {line}" for line in _reasons(table)]
    lines += [
        f"compiled  {_structures(table)}",
        *(f"          {line}" for line in table.changes[:_MOST_REASONS]),
    ]
    lines += ["", *_measures(table)]
    shares = indices(table)
    if shares:
        lines += [
            "",
            "Sobol' indices: share of the variance by itself, and with all that it does together with others",
        ]
    for name, each in shares.items():
        rows = zip(table.plan.names, each.first, each.total, strict=True)
        lines += [f"  {shortened(name, 30)}"]
        lines += [
            f"    {shortened(varied, 30):<30}  {first:8.3f}  {total:8.3f}" for varied, first, total in rows
        ]
        if not np.isfinite(each.first).all():
            lines += ["    none: points without this measure would bias them, or it does not vary"]
    return "\n".join(lines)


def _tally(table: Table) -> str:
    tally = table.tally()
    if tally == {OK: table.count}:
        return f"{table.count}, all ok"
    return f"{table.count}: " + ", ".join(f"{count} {status}" for status, count in tally.items())


def _structures(table: Table) -> str:
    count = table.structure_count
    if count < 2:
        return "one structure for all points" if count else "nothing"
    left = count - 1 - min(len(table.changes), _MOST_REASONS)
    more = f" ({left} more than are told here: column structure)" if left else ""
    return f"{count} structures, as the topology changes with what is varied{more}"


def _reasons(table: Table) -> list[str]:
    """The reasons of most points, each with the first of them."""
    groups: dict[tuple[str, str], list[int]] = {}
    for index, reason in sorted(table.reasons.items()):
        groups.setdefault((table.status(index), reason), []).append(index)
    ordered = sorted(groups.items(), key=lambda item: (-len(item[1]), item[1][0]))
    lines = [
        f"{status} ({len(points)}, first point {points[0]}): {reason}"
        for (status, reason), points in ordered[:_MOST_REASONS]
        if status != MISSING
    ]
    left = len(ordered) - _MOST_REASONS
    return [*lines, f"… and {left} more reasons, in table.csv"] if left > 0 else lines


def _measures(table: Table) -> list[str]:
    heads = ("least", "at point", "most", "at point", *(f"{100 * share:g} %" for share in SHARES))
    lines = [_line("measure", heads)]
    for name, values in table.values.items():
        unit = "" if table.units[name] == "1" else table.units[name]
        if not np.isfinite(values).any():
            lines.append(_line(name, ("no point has it",)))
            continue
        least, most = int(np.nanargmin(values)), int(np.nanargmax(values))
        ends = [(shown_number(float(values[k]), unit, 4), str(k)) for k in (least, most)]
        others = [shown_number(float(each), unit, 4) for each in quantiles(table, name)]
        lines.append(_line(name, (*ends[0], *ends[1], *others)))
    return lines


def _line(name: str, cells: Sequence[str]) -> str:
    return f"{shortened(name, 30):<30}" + "".join(f"  {cell:>12}" for cell in cells)
