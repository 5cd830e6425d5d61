"""A search for the best parameters, checked before anything runs, and gone through.

In: what `lamc.optimise` and `lamc optimise` are given. Out: a `Search`, and its `Best`. What is found follows from the
seed: the same search gives the same runs, in the same order, so that one that was stopped goes on where it was.
"""

import inspect
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any

from lamc.basics._version import __version__
from lamc.basics.checks import did_you_mean, shown
from lamc.basics.errors import DesignError, RequestError, SimulationError
from lamc.codegen.options import CompileOptions
from lamc.records.family import Family
from lamc.records.parameters import DesignParameter
from lamc.run.parameters import checked_parameters
from lamc.studies.bench import Bench, Row, RunOptions, Subject
from lamc.studies.crew import Hands
from lamc.studies.derivatives import MANY
from lamc.studies.goals import Constraint, Goal, constraints_of, goal_of
from lamc.studies.identity import digest_of
from lamc.studies.making import AS_EVER, SceneGiven, scene_of
from lamc.studies.measures import Measure, outputs_of
from lamc.studies.optimum import Best
from lamc.studies.problem import Problem
from lamc.studies.space import Space, Value, axis_values, space_of, words_of
from lamc.studies.storage import opened, rows_of
from lamc.studies.strategy import METHODS, Strategy, default_method
from lamc.studies.study import ALONE, Progress, pickled, quietly, workers_of
from lamc.studies.targets import Made, Studied, Target, family_of, known_target, targets_of
from lamc.studies.trier import Trier, Words


@dataclass(frozen=True, eq=False)
class Search:
    """subjects: by the words of choices; start: a point; name: of the design."""

    subjects: Mapping[Words, Subject]
    space: Space
    goals: tuple[Goal, ...]
    constraints: tuple[Constraint, ...]
    start: tuple[float, ...]
    name: str
    strategy: Strategy = field(default_factory=Strategy)
    max_runs: int = 5000

    def asked(
        self, method: str, start: Mapping[str, float | str] | None, starts: int, seed: int, max_runs: int
    ) -> "Search":
        """With a method and starts. Raises RequestError for what makes no search."""
        for name, given, least in (("starts", starts, 1), ("seed", seed, 0), ("max_runs", max_runs, 1)):
            if isinstance(given, bool) or not isinstance(given, int) or not least <= given < 2**31:
                raise RequestError(f"{name} is {shown(given)}; it must be a whole number, {least} or more")
        strategy = Strategy(_method(method, self), starts, seed)
        return replace(self, strategy=strategy, start=_start(self, start or {}), max_runs=max_runs)

    def run(
        self,
        folder: Path | None,
        workers: int = 1,
        *,
        resume: bool = False,
        progress: Progress | None = None,
        alone: float = ALONE,
    ) -> Best:
        """The best, the same whatever the number of workers; they begin after `alone` s of work. Raises
        SimulationError if no run goes well, RequestError for a folder of another search, and what no run can do
        without, such as BuildError."""
        trier = self._trier()
        hands = Hands(trier, trier.width, workers, alone)
        with self._store(folder, resume) as (known, keep), quietly(), hands:
            problem = Problem(self.space, self.goals, self.constraints, trier.row, self.max_runs, hands.crew)
            problem.known, problem.keep, problem.slopes_at = known, keep, trier.slopes
            if progress is not None:
                problem.told = lambda of: progress(len(of.trials), of.most)
            found = self.strategy.best(problem, self.space.places(self.start), trier)
        if found is None:
            raise SimulationError(
                f"no run went well, of {len(problem.trials)}: {problem.reasons() or 'interrupted'}"
            )
        return found

    @contextmanager
    def _store(
        self, folder: Path | None, resume: bool
    ) -> Iterator[tuple[dict[int, Row], Callable[[Row], None]]]:
        """Rows that are there, and where further ones go."""
        if folder is None:
            yield {}, lambda _: None
            return
        with opened(folder, self.manifest(), resume=resume) as store:
            yield {row.index: row for row in rows_of(folder)}, store.add

    def manifest(self) -> dict[str, Any]:
        """What tells one search from another, in JSON's own types."""
        subject = next(iter(self.subjects.values()))
        return {
            "lamc": __version__,
            "design": self.name,
            "drawing": digest_of(
                [(each.design, dict(each.design.parameters)) for each in self.subjects.values()]
            ),
            "scene": digest_of(subject.scene),
            "vary": [list(asdict(each).values()) for each in self.space.variables],
            "start": list(self.start),
            "minimise": [
                [each.text, each.unit, "" if each.function is None else digest_of(each.function)]
                for each in self.goals
            ],
            "subject_to": [each.text for each in self.constraints],
            "method": list(asdict(self.strategy).values()),
            "run": asdict(replace(subject.run, parameters={})) | {"parameters": dict(subject.run.parameters)},
            "compiler": repr(subject.options),
        }

    def workers(self, wanted: int | None) -> int:
        """How many processes: None: as many as processors, or one if the search cannot travel. Raises RequestError."""
        if wanted is None:
            try:
                pickled(self._trier())
            except RequestError:
                return 1
        elif wanted != 1:
            pickled(self._trier())
        return workers_of(wanted)

    def _trier(self) -> Trier:
        return Trier(self.subjects, self.space, self.goals, self.constraints)


def search_of(
    design: Studied | Callable[..., Made],
    vary: Mapping[str, object],
    minimise: object,
    subject_to: object = (),
    scene: SceneGiven = None,
    *,
    run: RunOptions = AS_EVER,
    options: CompileOptions | None = None,
) -> Search:
    """The search of a design's parameters, checked: names, units, ranges, goals. Raises RequestError and DesignError;
    nothing has run."""
    families, words = _families(design, vary)
    compiler = options or CompileOptions()
    chosen = next(iter(families.values()))
    scene = scene_of(chosen, scene)
    first = Bench(Subject(chosen, scene, compiler, RunOptions(), (), {})).simulator(())
    targets = targets_of(chosen, first)
    space = space_of(vary, targets, words)
    varied = {v.name: v.unit for v in space.variables if not v.has_words}
    outputs = replace(outputs_of(first), varied=varied)
    several = isinstance(minimise, list | tuple) and not _has_unit(minimise)
    if not minimise:
        raise RequestError(
            "nothing is minimised; name a goal, such as --minimise 'rms(tip.z - 5 mm)' (minimise=…)"
        )
    goals = tuple(goal_of(each, outputs) for each in (list(minimise) if several else [minimise]))  # type: ignore[call-overload]
    constraints = constraints_of(subject_to, outputs)
    asked = [*(g.text for g in goals), *(c.text for c in constraints)]
    if len(set(asked)) != len(asked):
        raise RequestError("a goal or a constraint is there twice; leave one out")
    numeric = tuple(targets[v.name] for v in space.variables if not v.has_words)
    for name in run.parameters:
        if known_target(name, targets).kind != "parameter" or name in space.names:
            raise RequestError(f"the parameter {name!r} is varied, or is none of the model; set it no value")
    run = replace(run, parameters=checked_parameters(run.parameters, first.parameter_units))
    measures = {each.text: each for each in _measures(goals, constraints)}
    subjects = {key: Subject(each, scene, compiler, run, numeric, measures) for key, each in families.items()}
    start = tuple(_usual(space, targets, k) for k in range(len(space.variables)))
    return Search(subjects, space, goals, constraints, start, first.mechanism.name)


def _has_unit(minimise: object) -> bool:
    """Whether it is (function, unit)."""
    return (
        isinstance(minimise, tuple)
        and len(minimise) == 2
        and callable(minimise[0])
        and isinstance(minimise[1], str)
    )


def _measures(goals: tuple[Goal, ...], constraints: tuple[Constraint, ...]) -> list[Measure]:
    """Of them runs learn at which times they are asked for values."""
    return [*(g.measure for g in goals if g.measure is not None), *(c.measure for c in constraints)]


def _families(design: object, vary: object) -> tuple[dict[Words, Studied], dict[str, Words]]:
    """What is studied, by the words that arguments of a function take, and these words by name."""
    if isinstance(design, Family) or not inspect.isfunction(design) or not isinstance(vary, Mapping):
        return {(): family_of(design)}, {}
    arguments = inspect.signature(design).parameters
    worded = [name for name, each in arguments.items() if _is_word(each.default)]
    choices = {name: words_of(vary[name]) for name in vary if name in worded}
    for name, words in choices.items():
        if words is None:
            raise RequestError(
                f"vary {name!r}: {shown(vary[name])}; an argument that is a word takes words: carbon|glass"
            )
    found: dict[Words, Studied] = {}
    left = {name: each.default for name, each in arguments.items() if name not in worded}
    known = {name: words for name, words in choices.items() if words is not None}
    for key in _combinations(list(known.values())):
        named = {name: arguments[name].default for name in worded} | dict(zip(known, key, strict=True))
        found[key] = Family(partial(design, **named), left) if worded else family_of(design)
    return found, known


def _combinations(words: list[Words]) -> Iterator[Words]:
    if not words:
        yield ()
        return
    for first in words[0]:
        yield from ((first, *rest) for rest in _combinations(words[1:]))


def _is_word(default: object) -> bool:
    """Whether the default of an argument is text that is no quantity."""
    if not isinstance(default, str):
        return False
    try:
        DesignParameter(default)
    except DesignError:
        return True
    return False


def _usual(space: Space, targets: Mapping[str, Target], k: int) -> float:
    """Where the search begins if nobody says: at the design's own value, or in the middle."""
    variable = space.variables[k]
    own = targets[variable.name].default if variable.name in targets else None
    if variable.levels:
        return (
            own
            if own in variable.levels and own is not None
            else variable.number(0.0 if variable.has_words else 0.5)
        )
    return own if own is not None and variable.low <= own <= variable.high else variable.number(0.5)


def _start(search: Search, given: Mapping[str, float | str]) -> tuple[float, ...]:
    """The start with other values of some names. Raises RequestError."""
    if not isinstance(given, Mapping):
        raise RequestError(f"start is {shown(given)}; it must map names to values, start={{'length': 0.05}}")
    names = search.space.names
    found = dict(zip(names, search.start, strict=True))
    for name, value in given.items():
        if name not in names:
            raise RequestError(f"start: {shown(name)} is not varied; {did_you_mean(str(name), list(names))}")
        found[name] = _placed(search.space, names.index(name), value)
    return tuple(found[name] for name in names)


def _placed(space: Space, k: int, value: Value) -> float:
    variable = space.variables[k]
    if variable.has_words:
        if value not in variable.levels:
            raise RequestError(
                f"start {variable.name!r}: {shown(value)} is none of {'|'.join(map(str, variable.levels))}"
            )
        return float(variable.levels.index(value))
    (number,) = axis_values(variable.name, [value], variable.unit)
    unit = "" if variable.unit == "1" else f" {variable.unit}"
    if variable.levels and number not in variable.levels:
        raise RequestError(f"start {variable.name!r}: {number:g}{unit} is none of its values")
    if not variable.low <= number <= variable.high:
        raise RequestError(
            f"start {variable.name!r}: {number:g}{unit} is outside of its range, "
            f"{variable.low:g} to {variable.high:g}{unit}"
        )
    return number


def _method(method: object, search: Search) -> str:
    """The method, or that which suits. Raises RequestError for what it cannot do."""
    if not isinstance(method, str) or method not in ("auto", *METHODS):
        raise RequestError(
            f"no method is named {shown(method)}; {did_you_mean(str(method), ['auto', *METHODS])}"
        )
    if len(search.goals) > 1:
        if method not in ("auto", "nsga2"):
            raise RequestError(
                f"{method} takes one goal, and there are {len(search.goals)}; nsga2 finds their front"
            )
        return "nsga2"
    if method == "nsga2":
        raise RequestError("nsga2 finds the front of several goals, and there is one; take another method")
    has_levels = len(search.space.real) < len(search.space.variables)
    if method == "auto":
        is_many = len(search.space.real) > MANY
        is_subject = bool(search.constraints)
        return default_method(search.goals[0], has_levels=has_levels, is_subject=is_subject or is_many)
    if has_levels and not METHODS[method]:
        raise RequestError(f"{method} takes no whole numbers and choices; take evolution, or cma-es")
    if method == "least-squares" and search.constraints:
        raise RequestError("least-squares takes no constraints; take slsqp, or trust-constr")
    if method == "least-squares" and not search.goals[0].is_squares and search.goals[0].function is None:
        raise RequestError(
            "least-squares takes a goal of squares: rms(…), (…)**2 + (…)**2, or a function of several numbers"
        )
    return method
