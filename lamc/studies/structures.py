"""Which points of a study have the same equations, and what is another where they have not.

In: digests of structures by point. Out: structures numbered in the order of the points, and what changed in words.
Whatever worked on the points, the numbers are the same. Never: compiles.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np

from lamc.basics.errors import LamcError
from lamc.basics.numbers import shown_number
from lamc.run.topology import changes
from lamc.studies.bench import Bench, Subject
from lamc.studies.plans import Plan

NONE = -1  # of a point that has no equations, as one whose drawing is refused
MOST_TOLD = 8  # structures of which it is told what is another

Numbers = np.ndarray[Any, np.dtype[np.int32]]


def numbered(digests: Mapping[int, str], count: int) -> Numbers:
    """(count,): 0 for the structure of the first point that has one, 1 for the next that is another, …, or NONE."""
    found = np.full(count, NONE, dtype=np.int32)
    known: dict[str, int] = {}
    for index in sorted(digests):
        if digests[index]:
            found[index] = known.setdefault(digests[index], len(known))
    return found


def structure_notes(subject: Subject, plan: Plan, structures: Numbers) -> tuple[str, ...]:
    """Of each structure but the first, where it is met and what is another than in the first."""
    count = min(int(structures.max(initial=NONE)) + 1, MOST_TOLD)
    if count < 2:
        return ()
    bench, firsts = Bench(subject), [int(np.argmax(structures == k)) for k in range(count)]
    lines = []
    for k in range(1, count):
        point = plan.point(firsts[k])
        try:
            what = changes(*(bench.mechanism(plan.point(first)) for first in (firsts[0], firsts[k])))
        except LamcError:  # of a drawing that follows from more than its numbers
            what = "its topology"
        values = [
            f"{target.name} = {shown_number(value, '' if target.unit == '1' else target.unit, 4)}"
            for target, value in zip(subject.targets, point, strict=True)
        ]
        points = int(np.count_nonzero(structures == k))
        where = f"{points} points, first {firsts[k]}" if points > 1 else f"point {firsts[k]}"
        lines.append(f"structure {k} ({where}: {', '.join(values[:4])}): {what}")
    return tuple(lines)
