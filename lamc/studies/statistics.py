"""What a table says of a measure: its spread, and which inputs it follows from.

In: a `Table`. Out: quantiles, and Sobol' indices of Saltelli's plan: first-order ones by Saltelli et al. (2010), eq. b
of table 2, total ones by Jansen, eq. f, as `scipy.stats.sobol_indices` computes them. Never: leaves out points that
failed without saying so: indices need all of them.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from lamc.run.request import Array
from lamc.studies.plans import Grid
from lamc.studies.table import Table

SHARES = (0.05, 0.5, 0.95)


@dataclass(frozen=True, eq=False)
class Indices:
    """Shares of a measure's variance. first: (names,), of each name by itself; total: with all that it does together
    with others. NaN where points have no measure, or where it does not vary."""

    first: Array
    total: Array


def quantiles(table: Table, measure: str, shares: Sequence[float] = SHARES) -> Array:
    """Quantiles (shares,) of a measure over the points that have it; NaN if none has."""
    values = table.values[measure]
    known = values[np.isfinite(values)]
    return np.quantile(known, shares) if known.size else np.full(len(shares), np.nan)


def is_saltelli(table: Table) -> bool:
    """Whether its plan has Sobol' indices."""
    return not isinstance(table.plan, Grid) and table.plan.how.get("sample") == "saltelli"


def indices(table: Table) -> Mapping[str, Indices]:
    """Sobol' indices of each measure; none of another plan than Saltelli's."""
    if not is_saltelli(table):
        return {}
    from scipy.stats import sobol_indices

    names = len(table.plan.names)
    count = table.count // (names + 2)
    found = {}
    for name, values in table.values.items():
        if not np.isfinite(values).all() or np.ptp(values[: 2 * count]) == 0.0:
            found[name] = Indices(np.full(names, np.nan), np.full(names, np.nan))
            continue
        first, second, mixed = values[:count], values[count : 2 * count], values[2 * count :]
        given = {
            "f_A": first.reshape(1, -1),
            "f_B": second.reshape(1, -1),
            "f_AB": mixed.reshape(names, 1, count),
        }
        shares = sobol_indices(func=given, n=count)
        found[name] = Indices(np.ravel(shares.first_order), np.ravel(shares.total_order))
    return found
