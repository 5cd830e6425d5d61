"""The work of a study at one point: from values to a row.

In: a `Subject`, which travels between processes, and points. Out: `Row`s. What a point gives depends on nothing but the
point: not on those before it, on the process or the clock. A point that makes no run is a row with its reason.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from lamc.basics.errors import BuildError, LamcError
from lamc.basics.readonly import ReadOnlyDict
from lamc.codegen.cache import Cache, cache_root
from lamc.codegen.options import CompileOptions
from lamc.design.split import split
from lamc.pipeline import compile as compile_design
from lamc.records.design import Design
from lamc.records.mechanism import Mechanism
from lamc.records.scene import Scene
from lamc.run.defaults import DURATION, default_rows
from lamc.run.request import Array, Status
from lamc.run.result import Result
from lamc.run.simulator import Simulator
from lamc.studies.measures import Measure
from lamc.studies.targets import ANGLES, RATES, SLOW, Studied, Target, made, started

OK = "ok"
REFUSED = "refused"  # no such design, start or parameter can be
FAILED = "failed"  # the run did not reach its end
UNDEFINED = "undefined"  # a measure is no finite number
ERROR = "error"  # a function of the user's raised an exception
DIED = "died"  # the process that computed it ended
MISSING = "missing"  # not computed
STATUSES = (OK, REFUSED, FAILED, UNDEFINED, ERROR, DIED, MISSING)

_KEPT = 4  # simulators
_DIGITS = 16  # of a digest of 64: enough to tell all structures of a study apart
_LONGEST_REASON = 400


@dataclass(frozen=True)
class RunOptions:
    """How all runs of a study go, where a point says nothing else. As of `Simulator.run`; rows: of each run, evenly
    spread, to which times that measures ask for are added."""

    t_end: float | None = None  # s; None: the scene's duration, or 10 s
    rtol: float | None = None
    atol: float | None = None
    max_step: float | None = None  # s
    integrator: str = "auto"
    rows: int | None = None  # None: 200 a second, and 2001 at least
    max_steps: int = 1_000_000
    parameters: Mapping[str, float | str] = field(default_factory=lambda: ReadOnlyDict({}))


@dataclass(frozen=True)
class Subject:
    """What is studied: a design in a scene, what is varied of it and what is measured.

    scene  None: the design's own; or what gives it of a mechanism
    """

    design: Studied
    scene: Scene | Callable[[Mechanism], Scene] | None
    options: CompileOptions
    run: RunOptions
    targets: tuple[Target, ...]  # in the order of a point's values
    measures: Mapping[str, Measure]

    def bench(self) -> "Bench":
        """What works on its points."""
        return Bench(self)


@dataclass(frozen=True)
class Row:
    """What came of a point. values: of the measures, in their order; NaN where there are none. structure: the first
    digits of its equations' digest (`Simulator.structure`); empty where there are none."""

    index: int
    status: str
    reason: str
    values: tuple[float, ...]
    structure: str = ""


class Bench:
    """Works on the points of one subject, one after the other. Points that share what is slow to change are quickest in
    a row."""

    def __init__(self, subject: Subject) -> None:
        self.subject = subject
        self._simulators: dict[tuple[float, ...], Simulator | LamcError] = {}
        self._slow = [k for k, target in enumerate(subject.targets) if target.kind in SLOW]
        # The cache keeps what all points share; notes of single ones would be thousands of files that nobody reads.
        self._cache = Cache(cache_root(), passing=bool(self._slow))

    def row(self, index: int, point: Sequence[float]) -> Row:
        """Raises KeyboardInterrupt if the run is cancelled."""
        return replace(self._row(index, point), structure=self.structure(point))

    def given(self, point: Sequence[float]) -> dict[str, float]:
        """What was varied, SI, by name."""
        return {target.name: value for target, value in zip(self.subject.targets, point, strict=True)}

    def structure(self, point: Sequence[float]) -> str:
        """As of `Row`, of the point that was worked on last; empty where it has no simulator."""
        found = self._simulators.get(self._key(point))
        return found.structure[:_DIGITS] if isinstance(found, Simulator) else ""

    def _row(self, index: int, point: Sequence[float]) -> Row:
        try:
            result = self.result(point)
            if result.status == Status.CANCELLED:
                raise KeyboardInterrupt
            if not result.success:
                return self._without(index, FAILED, result.message)
            given = self.given(point)
            values = tuple(measure.value(result, given) for measure in self.subject.measures.values())
        except BuildError:
            raise  # no point would fare better
        except LamcError as error:
            return self._without(index, REFUSED, error.message)
        except Exception as error:  # of a function that the user gave; it shall not end the study
            return self._without(index, ERROR, f"{type(error).__name__}: {error}")
        asked = [measure.times for measure in self.subject.measures.values()]
        undefined = undefined_values(tuple(self.subject.measures), values, asked, result)
        return Row(index, UNDEFINED if undefined else OK, ", ".join(undefined), values)

    def _without(self, index: int, status: str, reason: str) -> Row:
        return without_values(index, status, reason, len(self.subject.measures))

    def result(self, point: Sequence[float], *, taped: bool = False) -> Result:
        """The run of a point; taped: with its steps, for gradients. Raises LamcError where there is none."""
        simulator, run = self.simulator(point), self.subject.run
        fast = [(t, v) for t, v in zip(self.subject.targets, point, strict=True) if t.kind not in SLOW]
        options = {target.name: value for target, value in fast if target.kind == "option"}
        own = {target.name: value for target, value in fast if target.kind == "parameter"}
        t_end = options.get("t_end", run.t_end)
        if t_end is None:
            t_end = simulator.scene.duration or DURATION
        return simulator.run(
            t_end,
            options.get("rtol", run.rtol),
            options.get("atol", run.atol),
            self._times(t_end, len(simulator.start)),
            run.integrator,
            {**run.parameters, **own},
            max_steps=run.max_steps,
            max_step=options.get("max_step", run.max_step),
            taped=taped,
        )

    def _times(self, t_end: float, size: int) -> Array | None:
        """Times of the rows; None where t_end makes none."""
        if not (math.isfinite(t_end) and t_end > 0.0):
            return None
        rows = default_rows(t_end, size) if self.subject.run.rows is None else self.subject.run.rows
        even = np.linspace(0.0, t_end, rows)
        asked = [each for m in self.subject.measures.values() for each in m.times if 0.0 <= each <= t_end]
        return np.union1d(even, asked) if asked else even

    def simulator(self, point: Sequence[float]) -> Simulator:
        """The simulator of a point, kept for the next. Raises LamcError where there is none."""
        key = self._key(point)
        found = self._simulators.get(key)
        if found is None:
            if len(self._simulators) >= _KEPT:
                del self._simulators[next(iter(self._simulators))]
            try:
                found = self._compiled(point)
            except BuildError:
                raise
            except LamcError as error:
                found = error
            self._simulators[key] = found
        if isinstance(found, LamcError):
            raise found
        return found

    def mechanism(self, point: Sequence[float]) -> Mechanism:
        """The drawing of a point, split. Raises LamcError where there is none."""
        design = made(self.subject.design, self._by_kind(point)["dimension"])
        return split(design) if isinstance(design, Design) else design

    def _key(self, point: Sequence[float]) -> tuple[float, ...]:
        return tuple(point[k] for k in self._slow)

    def _by_kind(self, point: Sequence[float]) -> dict[str, dict[str, float]]:
        """Values of what is slow to change, by kind and name."""
        found: dict[str, dict[str, float]] = {kind: {} for kind in SLOW}
        for k in self._slow:
            target = self.subject.targets[k]
            name = target.name.removeprefix(ANGLES if target.kind == "angle" else RATES)
            found[target.kind][target.name if target.kind == "dimension" else name] = point[k]
        return found

    def _compiled(self, point: Sequence[float]) -> Simulator:
        by_kind, subject = self._by_kind(point), self.subject
        design = made(subject.design, by_kind["dimension"])
        scene = subject.scene
        if callable(scene) or (scene is None and (by_kind["angle"] or by_kind["rate"])):
            mechanism = split(design) if isinstance(design, Design) else design
            scene = scene(mechanism) if callable(scene) else mechanism.scene or Scene()
            design = mechanism
        if scene is not None:
            scene = started(scene, by_kind["angle"], by_kind["rate"])
        return compile_design(design, scene, subject.options, cache=self._cache)


def undefined_values(
    names: Sequence[str], values: Sequence[float], times: Sequence[Sequence[float]], result: Result
) -> list[str]:
    """Which values are no numbers, in words. times: at which each asks for values, s."""
    found = []
    for name, value, asked in zip(names, values, times, strict=True):
        if not math.isfinite(value):
            end = float(result.t[-1]) if len(result.t) else 0.0
            late = f": the run ends at {end:g} s" if max(asked, default=0.0) > end else ""
            found.append(f"{name!r} is {value}{late}")
    return found


def without_values(index: int, status: str, reason: str, count: int) -> Row:
    """The row of a point that gives no measures."""
    text = " ".join(reason.split())
    short = text if len(text) <= _LONGEST_REASON else f"{text[:_LONGEST_REASON]}…"
    return Row(index, status, short, (math.nan,) * count)
