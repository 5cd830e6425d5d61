"""Words for what a start was given and for the branches that it may take. In: records. Out: parts of sentences."""

from collections.abc import Mapping, Sequence

from lamc.loops.branches import Branch


def named(values: Mapping[str, float]) -> str:
    """Names with their values, in the order of the names."""
    return ", ".join(f"{name} = {value:g}" for name, value in sorted(values.items())) or "none"


def ratios(branch: Branch, most: int = 8) -> str:
    """The rates of the first joints, relative to the largest."""
    texts = [f"{name} {rate:.4g}" for name, rate in branch.rates.items()]
    return ", ".join(texts[:most] + ["…"] * (len(texts) > most))


def counted(branches: Sequence[Branch]) -> str:
    """How many branches there are."""
    return f"{len(branches)} branch" if len(branches) == 1 else f"{len(branches)} branches"


def listed(branches: Sequence[Branch], most: int = 4) -> str:
    """The branches with their ratios of rates, numbered as the scene chooses them."""
    texts = [f"{number}: ({ratios(branch)})" for number, branch in enumerate(branches[:most], start=1)]
    more = f"; {len(branches) - most} more in Simulator.branches" if len(branches) > most else ""
    return "; ".join(texts) + more
