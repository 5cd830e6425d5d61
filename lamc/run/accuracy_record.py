"""What a run to an accuracy came to: the record that `Result.accuracy` holds."""

from collections.abc import Mapping
from dataclasses import dataclass


@dataclass(frozen=True)
class Rung:
    """One run of those that an accuracy took."""

    integrator: str
    rtol: float
    evaluations: float  # of the right-hand side, Jacobians and factorisations counted by what they cost


@dataclass(frozen=True)
class Accuracy:
    """What `Simulator.run(accuracy=…)` came to. Errors are relative to the range of each output over the run.

    asked              the accuracy
    error              the largest error of any output at any row, estimated; infinite where nothing is known of it
    reached            whether it is at most what was asked for, at the end of the run
    by_output          the same for each output by name
    integrator, rtol   of the run that the result is
    proportionality    k of error ~ rtol^k, near 1 where the estimate can be relied on, and taken for 1 where two runs
                       are all that could be had; None: errors do not follow the
                       tolerance, as in chaos, at singular positions or at round-off, and the error is the difference
                       of the two tightest runs
    runs               all of them, in order
    candidates         evaluations by integrator for the parts of the run that were probed, at this accuracy
    probe_evaluations  what the probes took
    evaluations        what all took together
    """

    asked: float
    error: float
    reached: bool
    by_output: Mapping[str, float]
    integrator: str
    rtol: float
    proportionality: float | None
    runs: tuple[Rung, ...]
    candidates: Mapping[str, float]
    probe_evaluations: float
    evaluations: float
