"""Runs with derivatives where the run itself keeps an energy balance, or was chosen by an accuracy.

In: a run as it is asked for, and the same made once more with derivatives. Out: the first, with the derivatives of the
second. Never: changes a bit of the first; takes derivatives of other steps for those of the run.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from lamc.basics.errors import SimulationError
from lamc.run.derivatives import NoDerivative, Sensitivities
from lamc.run.request import Array, Request, Status
from lamc.run.sensitivities import Differentiated

if TYPE_CHECKING:
    from lamc.run.result import Result

CANCELLED = "the run was cancelled before they were worked out"


@dataclass(frozen=True)
class Made:
    """A run, and what made it."""

    result: "Result"
    integrator: str
    asked: Request


def with_derivatives(
    result: "Result",
    made: Sequence[Made],
    found: Differentiated,
    run: "Callable[[str, Request], Result]",
) -> "Result":
    """`result`, or the rows of it that are kept, with derivatives. made: the runs, of which it is one; run: makes a run
    with derivatives."""
    of = next(each for each in made if each.result.stats is result.stats)
    if result.status == Status.CANCELLED:
        return beside(result, None, found)
    # Rows do not sway steps: those of an accuracy are fewer than what its runs had.
    times = None if of.asked.t_eval is None else np.ascontiguousarray(result.t)
    asked = replace(of.asked, t_eval=times, along=found.along, energy_balance=False, progress=None)
    return beside(result, run(of.integrator, asked), found)


def beside(result: "Result", other: "Result | None", found: Differentiated) -> "Result":
    """`result` with the derivatives of `other`, which are those of the same run. other: None: there are none, as the
    run was cancelled."""
    count = len(result.t)
    values = np.full((count, result.y.shape[0], len(found.names)), np.nan)
    if other is None or other.sensitivities is None:
        return replace(result, sensitivities=_padded(found, values, 0.0))
    is_whole = other.status != Status.CANCELLED
    known = count if is_whole else _common(result.t, other.t)
    if (is_whole and len(other.t) != count) or not np.array_equal(
        _rows(result)[:known], _rows(other)[:known]
    ):
        raise SimulationError(
            "a run takes other steps with derivatives than without; please report this as a bug"
        )
    values[:known] = other.sensitivities.values[:known]
    if is_whole:
        return replace(result, sensitivities=other.sensitivities)
    reached = float(result.t[known - 1]) if known else 0.0
    return replace(result, sensitivities=_padded(found, values, reached, other.sensitivities.lost))


def _padded(
    found: Differentiated, values: Array, since: float, lost: NoDerivative | None = None
) -> Sensitivities:
    made = found.sensitivities(values, None)
    return replace(made, values=values, lost=lost or NoDerivative(since, CANCELLED))


def _common(t: Array, other: Array) -> int:
    """How many rows have the same times from the first on."""
    most = min(len(t), len(other))
    differs = np.flatnonzero(t[:most] != other[:most])
    return int(differs[0]) if len(differs) else most


def _rows(result: "Result") -> Array:
    return np.column_stack([result.t, result.y.T])
