"""Words for what a start was given and for the branches that it may take. In: records. Out: parts of sentences."""

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from lamc.loops.branches import Branch

# What lets loops close that rigid facets do not.
MAY_BEND = "facets of a sheet may bend (--facets bend), and those of a design (facet_creases)"
ROUND_OFF = 1e-9  # of the largest rate; null spaces of large sheets have rows of some 1e-13


def named(values: Mapping[str, float]) -> str:
    """Names with their values, in the order of the names."""
    return ", ".join(f"{name} = {value:g}" for name, value in sorted(values.items())) or "none"


def telling(branches: Sequence[Branch], most: int) -> list[str]:
    """Joints by which the branches are told apart, and then those that move most; up to `most`, the most telling first.

    Those that move in none are left out."""
    names = list(branches[0].rates)
    rates = np.array([[branch.rates[name] for name in names] for branch in branches])
    rates[np.abs(rates) <= ROUND_OFF] = 0.0
    first, second = np.triu_indices(len(branches), 1)
    apart = np.abs(rates[first] - rates[second])  # (pairs, joints)
    largest = np.abs(rates).max(axis=0)
    left, known = largest > 0.0, np.zeros((len(apart), 1))
    chosen: list[str] = []
    while len(chosen) < most and left.any():
        # What one more joint adds to the largest difference between any two; of equal ones the first that moves most.
        gain = np.round(np.maximum(apart - known, 0.0).sum(axis=0), 6) + ROUND_OFF * np.round(largest, 6)
        k = int(np.argmax(np.where(left, gain, -1.0)))
        known = np.maximum(known, apart[:, k : k + 1])
        left[k] = False
        chosen.append(names[k])
    return chosen


def ratios(branch: Branch, most: int = 8, beside: Sequence[Branch] = ()) -> str:
    """The rates of a few joints, relative to the largest: all, or those that tell it from those beside it."""
    some = len(branch.rates) > most
    names = telling(beside or (branch,), most) if some else branch.rates
    rates = {name: rate if moves(rate) else 0.0 for name, rate in branch.rates.items()}
    texts = [f"{name} {rates[name]:.4g}" for name in names]
    return ", ".join(texts + ["…"] * some)


def moves(rate: float) -> bool:
    """Whether a rate, relative to the largest, is more than round-off."""
    return abs(rate) > ROUND_OFF


def listed(branches: Sequence[Branch], most: int = 4) -> str:
    """The branches with their ratios of rates, numbered as the scene chooses them."""
    few = branches[:most]
    texts = [f"{number}: ({ratios(branch, beside=few)})" for number, branch in enumerate(few, start=1)]
    more = f"; {len(branches) - most} more in Simulator.branches" if len(branches) > most else ""
    return "; ".join(texts) + more


def elsewhere_note(given: Mapping[str, float]) -> str:
    """That a start is not on the way from the drawing."""
    return (
        f"the drawn mechanism does not move to {named(given)} rad without a dead point on its way, or at its start: of "
        "the closed positions with these angles the one of smallest angles is the start, which may be another way of "
        "assembly; angles of all joints say which is meant"
    )


def pushed_note(number: int, branches: Sequence[Branch]) -> str:
    """Which branch of a singular start at rest is taken, and the others."""
    others = [k for k in range(1, len(branches) + 1) if k != abs(number)]
    few = [branches[k - 1] for k in (abs(number), *others[:4])]
    text = (
        f"the start is singular and at rest; it takes branch {number} ({ratios(few[0], beside=few)}), on which the "
        "loads do most work"
    )
    if not others:
        return text
    listing = "; ".join(
        f"{k}: ({ratios(branch, beside=few)})" for k, branch in zip(others, few[1:], strict=False)
    )
    more = " …" if len(others) > 4 else ""
    return f"{text}; others: {listing}{more}; choose by the scene's branch"


def resistance(given: Mapping[str, float], without: Callable[[str], float | None], unit: str) -> str:
    """The given value that, left free, lets the others be had, and what it becomes; the least change of all.

    without: of a name, what its value becomes when it is left free; None where that does not help."""
    possible = []
    for name, value in sorted(given.items()):
        instead = without(name)
        if instead is not None:
            possible.append((abs(instead - value), name, instead))
    if not possible:
        return "no single one of them is to blame: give fewer, or others"
    _, name, instead = min(possible)
    return f"joint {name!r} resists: left out, it comes to {instead:.4g} {unit} instead of {given[name]:g}"
