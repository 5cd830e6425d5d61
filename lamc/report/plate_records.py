"""What `lamc plate` found, as records.

In: values that were computed. Out: the same, together. Never: text, files.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from lamc.basics.checks import Array
from lamc.basics.errors import LamcError
from lamc.basics.times import Times
from lamc.plates.answers.buckling import Buckling
from lamc.plates.answers.convergence import QuantityError
from lamc.plates.answers.corner_fields import CornerFields, Extreme
from lamc.plates.answers.estimate import ErrorEstimate
from lamc.plates.answers.failure import PlateFailure
from lamc.plates.answers.modes import PlateModes
from lamc.plates.answers.shape_pairs import ShapePair
from lamc.plates.answers.solution import Solution
from lamc.plates.problem import Problem
from lamc.readers.plates.problem_records import Output, PlateFile


@dataclass(frozen=True)
class Printed:
    """The value of an output in one case, SI."""

    output: Output
    value: float
    unit: str


@dataclass(frozen=True)
class Halved:
    """The value of an output in one case, on the mesh and on one of halved cells."""

    output: Output
    unit: str
    error: QuantityError


@dataclass(frozen=True, eq=False)
class CaseReport:
    """One case and what was found in it.

    extremes  least and largest value by the name of a field, with its unit
    notes     what may make the answer worse than the reader expects
    strength  None where the strengths of no material are known
    halved    what a second mesh says of the outputs, or of the largest displacement; empty where it was not asked
    """

    name: str
    solution: Solution
    fields: CornerFields
    estimate: ErrorEstimate
    extremes: Mapping[str, tuple[str, Extreme, Extreme]]
    printed: Sequence[Printed]
    notes: Sequence[str]
    strength: PlateFailure | None
    halved: Sequence[Halved] = ()


@dataclass(frozen=True, eq=False)
class ShapeReport:
    """What is known of the errors of frequencies or buckling factors.

    errors  relative, of each; of buckling, the positive factors first
    notes   what may make them worse than the reader expects
    halved  what a second mesh says of each; empty where it was not asked
    """

    errors: Array
    notes: Sequence[str]
    halved: Sequence[ShapePair] = ()


MODES = "modes"


def buckling_key(case: str) -> str:
    """Under which `PlateReport.shapes` has the factors of a case."""
    return f"buckling {case}"


@dataclass(frozen=True, eq=False)
class PlateReport:
    """A plate and all that was asked of it.

    errors  why cases, modes or buckling loads are missing
    failed  cases that could not be solved
    shapes  how far off modes and buckling factors are, by MODES and `buckling_key(case)`
    """

    file: PlateFile
    source: str
    problem: Problem
    cases: Sequence[CaseReport]
    modes: PlateModes | None
    buckling: Mapping[str, Buckling]
    times: Times
    errors: Sequence[LamcError] = ()
    failed: Sequence[str] = ()
    shapes: Mapping[str, ShapeReport] = field(default_factory=dict)
