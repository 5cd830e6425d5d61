"""Words for what a start was given and for the branches that it may take. In: records. Out: parts of sentences."""

from collections.abc import Callable, Mapping, Sequence

from lamc.loops.branches import Branch


def named(values: Mapping[str, float]) -> str:
    """Names with their values, in the order of the names."""
    return ", ".join(f"{name} = {value:g}" for name, value in sorted(values.items())) or "none"


def ratios(branch: Branch, most: int = 8) -> str:
    """The rates of the first joints, relative to the largest."""
    texts = [f"{name} {rate:.4g}" for name, rate in branch.rates.items()]
    return ", ".join(texts[:most] + ["…"] * (len(texts) > most))


def listed(branches: Sequence[Branch], most: int = 4) -> str:
    """The branches with their ratios of rates, numbered as the scene chooses them."""
    texts = [f"{number}: ({ratios(branch)})" for number, branch in enumerate(branches[:most], start=1)]
    more = f"; {len(branches) - most} more in Simulator.branches" if len(branches) > most else ""
    return "; ".join(texts) + more


def pushed_note(number: int, branches: Sequence[Branch]) -> str:
    """Which branch of a singular start at rest is taken, and the others."""
    others = [k for k in range(1, len(branches) + 1) if k != abs(number)]
    text = (
        f"the start is singular and at rest; it takes branch {number} ({ratios(branches[abs(number) - 1])}), on which "
        "the loads do most work"
    )
    if not others:
        return text
    listing = "; ".join(f"{k}: ({ratios(branches[k - 1])})" for k in others[:4])
    more = " …" if len(others) > 3 else ""
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
    return f"joint {name!r} resists: {instead:.4g} {unit} instead of {given[name]:g} would do"
