"""What a fit answers: values, intervals, correlations, what the data cannot tell, and the runs that go with them.

In: a solved problem. Out: a `Fit`. It runs the model where a run is asked for, and fits nothing but a held-back
recording's own numbers.
"""

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from lamc.basics.drawing import drawer
from lamc.basics.errors import RequestError
from lamc.basics.once import lazy
from lamc.basics.readonly import ReadOnlyDict
from lamc.fitting.candidates import Candidate, candidates
from lamc.fitting.compared import Compared
from lamc.fitting.holding import held_back
from lamc.fitting.predictions import Predictor
from lamc.fitting.setting import Setting
from lamc.fitting.solve import Solved
from lamc.fitting.uncertainty import Account, Combination
from lamc.records.recording import Recording
from lamc.records.scene import Scene
from lamc.run.request import Array, Request
from lamc.run.result import Result
from lamc.run.simulator import Simulator
from lamc.studies.targets import Made

_ROWS = 200  # a second, of results


@dataclass(frozen=True, eq=False)
class Fit:
    """Numbers fitted to recordings. SI.

    values      by name: those of the model, and those of single recordings ("run1.delay", "run1.angles.h1")
    units       by name
    intervals   (low, high) by name, 95 %; infinite where the data say nothing; NaN at a bound
    errors      standard errors by name, of the logarithm where that was sought (`logarithms`)
    correlations  (p, p), in the order of `names`; NaN where there are none
    unidentifiable  what the data cannot tell: each with `names`, and as text in words
    noise       by column's unit or camera: standard deviation of what is left; said ones as given
    converged, message  how the search ended
    notes       in which the answer may not be what it seems
    runs        that were made
    compared    the recordings beside the model
    derivatives how they were had
    """

    values: Mapping[str, float]
    units: Mapping[str, str]
    intervals: Mapping[str, tuple[float, float]]
    errors: Mapping[str, float]
    logarithms: tuple[str, ...]
    correlations: Array
    unidentifiable: tuple[Combination, ...]
    converged: bool
    message: str
    notes: tuple[str, ...]
    runs: int
    compared: tuple[Compared, ...]
    setting: Setting = field(repr=False)
    predictor: Predictor = field(repr=False)
    solved: Solved = field(repr=False)
    account: Account = field(repr=False)
    derivatives: str = ""

    def __repr__(self) -> str:
        told = ", ".join(f"{name}={value:.4g}" for name, value in list(self.values.items())[:6])
        return f"<Fit {told}: {self.message}>"

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(self.values)

    @property
    def parameters(self) -> dict[str, float]:
        """Of the model, fitted: what `Simulator.run(parameters=…)` takes."""
        return self._of("parameter")

    @property
    def dimensions(self) -> dict[str, float]:
        """Of the drawing, fitted: what `design.with_parameters(…)` takes."""
        return self._of("dimension")

    def _of(self, kind: str) -> dict[str, float]:
        return {u.name: self.values[u.name] for u in self.setting.unknowns.all if u.kind == kind}

    @property
    def design(self) -> Made:
        """The design with fitted dimensions."""
        return self.setting.simulators.drawn(self.dimensions)

    @property
    def simulator(self) -> Simulator:
        """Of the design with fitted dimensions; its parameters are as ever."""
        return self.setting.simulators.of(self.dimensions)

    @property
    def scene(self) -> Scene:
        """The scene with fitted parameters: `lamc.compile(fit.design, fit.scene)`. Of one recording alone, it starts as
        that does, with the numbers of its parameters; series that they follow are of a run:
        `Simulator.run(parameters=recording.series)`. Of several it starts as ever, and `starts` has theirs."""
        scene, runs = self.simulator.scene, self.setting.runs
        alone = runs[0] if len(runs) == 1 else None
        angles, rates = next(iter(self.starts.values())) if alone else ({}, {})
        own = alone.own_numbers if alone else {}
        return replace(
            scene,
            parameters=ReadOnlyDict(
                {**scene.parameters, **self.setting.parameters, **own, **self.parameters}
            ),
            angles=ReadOnlyDict({**scene.angles, **angles}),
            rates=ReadOnlyDict({**scene.rates, **rates}),
        )

    @property
    def starts(self) -> dict[str, tuple[dict[str, float], dict[str, float]]]:
        """By recording: angles, rad, and rates, rad/s, of joints at its start, found or given, over the scene's. It is
        at zero of its clock, or at its first row where all of the start was to be found."""
        return {run.name: self.predictor.start(run, self.values) for run in self.setting.runs}

    @lazy
    def result(self) -> Result:
        """The run of the first recording, with what was fitted."""
        return self.result_of(0)

    def result_of(self, which: int | str) -> Result:
        """The run of a recording, by its place or name, from its start to its end, 200 rows a second."""
        place = self.place_of(which)
        task = self.predictor.task(place, self.values, sloped=False)
        end = float(task.times[-1])
        span = end - task.t_start
        times = np.linspace(task.t_start, end, max(int(_ROWS * span) + 1, 101))
        request = Request(task.y0, end, 1e-9, 1e-11, times, 1_000_000, np.inf, None, t_start=task.t_start)
        given: dict[str, Any] = dict(task.parameters)
        return task.simulator.integrated(task.simulator.model.motion(given), given, request, "auto")

    def animate(
        self,
        path: "str | os.PathLike[str]",
        which: int | str = 0,
        *,
        camera: str | Sequence[float] | None = None,
        size: int | None = None,
        progress: Callable[[int, int], None] | None = None,
    ) -> Path:
        """A film of the fitted model with what was recorded over it: .mp4 or .gif, as the suffix says.

        which   recording, by its place or name
        camera, size, progress  as of `Result.animate`

        Rings are points as recorded, dots the model's; outlines are bodies turned about their hinges as recorded.
        Raises as `Result.animate` does.
        """
        film: Path = drawer("Fit", "animate")(self, path, which, camera=camera, size=size, progress=progress)
        return film

    def held_back(self, recording: Recording) -> Compared:
        """A recording that the fit was not made of, beside the model: cross-validation. Its own ranges are found."""
        return held_back(self, recording)

    def candidates(
        self, columns: Sequence[str], markers: Mapping[str, object] | None = None
    ) -> tuple[Candidate, ...]:
        """What each of these columns would tell if it were recorded beside, by D-optimality; the best first."""
        return candidates(self, columns, markers)

    def place_of(self, which: int | str) -> int:
        """The place of a recording. Raises RequestError for one that is not there."""
        for place, run in enumerate(self.setting.runs):
            if which in (place, run.name):
                return place
        known = ", ".join(run.name for run in self.setting.runs)
        raise RequestError(f"no recording is named {which!r}; there are {known}")
