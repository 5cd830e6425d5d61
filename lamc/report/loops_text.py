"""The loops of a mechanism as plain text and as plain data: how many, their rank, how well they fit, their branches.

In: a `LoopCount`, and the `Branch`es of a singular position. Out: strings, and numbers for JSON. It finds nothing.
"""

from collections.abc import Sequence

from lamc.loops.branches import Branch
from lamc.loops.misfit import length
from lamc.loops.rank import LoopCount
from lamc.loops.texts import moves, telling

MOST_BRANCHES, MOST_RATIOS = 8, 24  # in a table


def loops_line(count: LoopCount) -> str:
    """Loops, equations, rank, redundancy and misfit in one line; empty without loops."""
    if not count.loops:
        return ""
    text = (
        f"{count.loops} {'loop' if count.loops == 1 else 'loops'}: {count.equations} equations of rank {count.rank}, "
        f"{count.redundant} redundant"
    )
    if count.misfit is None:
        return text
    taken = "accepted" if count.accepted_gap else f"taken exactly, rank {count.misfit.rank} if it is accepted"
    return f"{text}; {count.misfit.text} ({taken}; tolerance {length(count.tolerance)})"


def branch_lines(branches: Sequence[Branch], where: str = "at the start") -> list[str]:
    """A line for each branch: its number and the ratios of its rates; joints that rest are left out, and of
    many those that neither tell it from others nor move most."""
    if not branches:
        return []
    lines = [
        f"singular {where}; the ways out of it, by ratios of rates (a scene's branch chooses, -1 goes back):"
    ]
    few = branches[:MOST_BRANCHES]
    first = telling(few, MOST_RATIOS)
    for number, branch in enumerate(few, start=1):
        names = [name for name, rate in branch.rates.items() if moves(rate)]
        if len(names) > MOST_RATIOS:  # what tells it from others, then what moves most
            places = {name: k for k, name in enumerate(first)}
            names.sort(key=lambda name: (places.get(name, len(places)), -round(abs(branch.rates[name]), 6)))
        ratios = [f"{name} {branch.rates[name]:+.4g}" for name in names]
        family = f" (one of {branch.freedoms} freedoms)" if branch.freedoms > 1 else ""
        more = f", … ({len(ratios)} joints move)" if len(ratios) > MOST_RATIOS else ""
        lines.append(f"  branch {number}: {', '.join(ratios[:MOST_RATIOS])}{more}{family}")
    if len(branches) > MOST_BRANCHES:
        lines.append(f"… {len(branches)} branches in all")
    return lines


def loops_data(count: LoopCount, branches: Sequence[Branch] = ()) -> dict[str, object]:
    """The same as plain data for JSON; lengths in m."""
    misfit = count.misfit
    return {
        "loops": count.loops,
        "equations": count.equations,
        "rank": count.rank,
        "redundant": count.redundant,
        "freedoms": count.freedoms,
        "singular_values": list(count.singular_values),
        "tolerance": count.tolerance,
        "misfit": {"rank": misfit.rank, "gap": misfit.gap, "joint": misfit.cut}
        if misfit is not None
        else None,
        "branches": [{"rates": dict(b.rates), "freedoms": b.freedoms} for b in branches],
    }
