"""`lamc.optimise`: parameters of a design for which a measure of its run is least.

In: as its docstring says. Out: a `Best`. It arranges: a box to walk in (`space`), goals and constraints (`goals`), runs
that are kept (`problem`), methods (`optimisers`), the last digits (`refinement`), and whether it is true (`verdict`).
"""

from collections.abc import Callable, Mapping
from contextlib import nullcontext
from os import PathLike
from pathlib import Path

from lamc.basics.errors import RequestError
from lamc.basics.progress import bar
from lamc.codegen.options import CompileOptions
from lamc.records.scene import Scene
from lamc.run.evaluations import NO_PARAMETERS
from lamc.studies.bench import RunOptions
from lamc.studies.optimum import Best
from lamc.studies.search import search_of
from lamc.studies.targets import Made, Studied

RTOL, ATOL = 1e-11, 1e-13  # of a step: derivatives are differences of runs, and as good as these are alike

Told = Callable[[float, float], None]


def optimise(
    design: Studied | Callable[..., Made],
    vary: Mapping[str, object],
    minimise: object,
    subject_to: object = (),
    scene: Scene | str | None = None,
    *,
    method: str = "auto",
    start: Mapping[str, float | str] | None = None,
    starts: int = 5,
    seed: int = 0,
    max_runs: int = 5000,
    t_end: float | None = None,
    rtol: float | None = RTOL,
    atol: float | None = ATOL,
    max_step: float | None = None,
    integrator: str = "auto",
    rows: int | None = None,
    max_steps: int = 1_000_000,
    parameters: Mapping[str, float | str] = NO_PARAMETERS,
    options: CompileOptions | None = None,
    workers: int | None = None,
    out: str | PathLike[str] | None = None,
    resume: str | PathLike[str] | None = None,
    progress: Told | bool | None = None,
) -> Best:
    """Finds the parameters of a design for which a measure of its run is least.

    design   Design, Mechanism or Family; or a function of dimensions, with defaults, that gives one
    vary     name → range, in SI or text: (0.02, 0.06), "20mm:60mm", "log:1e-4:1e-2"; whole numbers: "3..8",
             range(3, 9); choices: "0.1 mm|0.2 mm", and of a function's argument that is a word: "carbon|glass". Names
             are as of `lamc.sweep`: dimensions, parameters of the model, "angles.h1", "rates.h1", "t_end"
    minimise a measure (`lamc.studies.measures`), "rms(tip.z - 5 mm)", or a function of the Result, or (function, unit);
             a function of several numbers gives their root mean square. Several, in a list, make a front (NSGA-II)
    subject_to  texts such as "max(abs(h1)) < 60 deg", "0 < last(tip.x) < 5 mm", "last(h1) == 0.2"; they, and the goal,
             may name what is varied: "length + width < 0.1 m"
    scene    a Scene, or the name of one of the design's; None: the design's own
    method   "auto", "least-squares", "slsqp", "trust-constr", "nelder-mead", "evolution", "cma-es" (extra: optimise);
             auto: least squares where the goal is rms(…), (…)**2 + (…)**2 or a function of several numbers and nothing
             is subject to anything, slsqp else; evolution where whole numbers or choices are varied
    start    where to begin, by name; else the design's own values if they are in range, else the middle
    starts   how many, the others the best of a Latin hypercube, by seed; evolution looks everywhere from one
    max_runs after which it ends with what it has
    rtol, atol  tighter than a run's own: a place is found by differences of runs
    workers  processes that run generations, several starts and slopes; None: as many as processors, or one where a
             function of yours is in no module of its own. They begin where the search takes more than half a second.
             What is found, and in what order, does not depend on it
    out      a folder that runs are written to as they come; resume: the same, and runs that are there already are
             not made again (but those of least squares)
    progress called with (runs made, runs granted); True: a bar

    The others are as of `lamc.sweep`. Returns the best, which may not be an optimum: `Best.converged` tells.
    Ctrl-C ends it with what it has. Raises RequestError and DesignError before anything runs, SimulationError if no run
    goes well.
    """
    if out is not None and resume is not None:
        raise RequestError("out and resume name two folders; resume writes into its own")
    run = RunOptions(t_end, rtol, atol, max_step, integrator, rows, max_steps, dict(parameters))
    search = search_of(design, vary, minimise, subject_to, scene, run=run, options=options)
    search = search.asked(method, start, starts, seed, max_runs)
    count = search.workers(workers)
    folder = resume if resume is not None else out
    with bar("optimise") if progress is True else nullcontext((None, None)) as (_, part):
        told = progress if callable(progress) else part
        place = None if folder is None else Path(folder)
        return search.run(place, count, resume=resume is not None, progress=told)
