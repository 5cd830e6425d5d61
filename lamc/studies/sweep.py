"""`lamc.sweep`: a design run at many points, as a Dataset of what was measured.

In: as its docstring says. Out: an xarray Dataset. It arranges; the work is in `study` and below.
"""

from collections.abc import Callable, Mapping
from contextlib import nullcontext
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING

from lamc.basics.errors import RequestError
from lamc.basics.progress import bar
from lamc.codegen.options import CompileOptions
from lamc.records.scene import Scene
from lamc.run.evaluations import NO_PARAMETERS
from lamc.studies.bench import RunOptions
from lamc.studies.making import study_of
from lamc.studies.statistics import indices
from lamc.studies.study import Progress
from lamc.studies.table import need_xarray
from lamc.studies.targets import Made, Studied

if TYPE_CHECKING:
    import xarray


def sweep(
    design: Studied | Callable[..., Made],
    vary: Mapping[str, object] | None = None,
    measure: object = None,
    scene: Scene | str | None = None,
    *,
    sample: str | None = None,
    seed: int = 0,
    points: object = None,
    t_end: float | None = None,
    rtol: float | None = None,
    atol: float | None = None,
    max_step: float | None = None,
    integrator: str = "auto",
    rows: int | None = None,
    max_steps: int = 1_000_000,
    parameters: Mapping[str, float | str] = NO_PARAMETERS,
    options: CompileOptions | None = None,
    workers: int | None = None,
    scheduler: str | None = None,
    out: str | PathLike[str] | None = None,
    resume: str | PathLike[str] | None = None,
    progress: Progress | bool | None = None,
    yes: bool = False,
) -> "xarray.Dataset":
    """Runs a design at many points and measures each run.

    design   Design, Mechanism or Family; or a function of dimensions, with defaults, that gives one
    vary     name → numbers, in SI, or text: "20mm:60mm:9", "log:1e-4:1e-2:7", "1,2,3"; with `sample` "20mm:60mm", or
             a distribution: normal(mean, deviation), uniform(least, most), triangular(least, likeliest, most),
             lognormal(median, deviation of the logarithm), truncated(mean, deviation, least, most). Names are
             dimensions of the design, parameters of its model (`Simulator.parameters`, inputs too), starts
             ("angles.h1", "rates.h1") and "t_end", "rtol", "atol", "max_step"
    measure  name → text, such as "max(tip.z)" (`lamc.studies.measures`), or a function of the Result, or (function,
             unit); a list of texts has them as names
    scene    a Scene, or the name of one of the design's; None: the design's own
    sample   "lhs:200", "sobol:256", "halton:100", "random:1000"; "saltelli:256" for Sobol' indices; None: a grid
    points   in place of vary: name → list, one entry for each point, or the path of a CSV file
    rows     of each run, which measures look at; None: 200 a second, 2001 at least
    workers  processes; None: as many as processors, or one where a function of yours is in no module of its own. What
             is found does not depend on it
    scheduler  address of a Dask cluster's scheduler, which does the work in place of processes here
    out      a folder that rows are written to as they come; None: memory
    resume   the same, and rows that are there already are not computed again
    progress called with (points done, points in all); True: a bar
    yes      whether more than a million points are meant

    The others are as of `Simulator.run`. Returns measures over what was varied (of a grid) or over "point", SI units in
    `attrs`, with `status` ("ok", "refused", "failed", "undefined", "error", "died", "missing") and `reason`, and
    `structure`: points of one number share their equations and one compile (-1: none), of which `attrs` tell how many
    "structures" there were, and in "topology" where and how it changed; of
    "saltelli" there are also NAME.first_order and NAME.total over "varied". Ctrl-C ends it and keeps what is there.
    Raises RequestError and DesignError before anything runs; LamcError without xarray.
    """
    need_xarray()
    if out is not None and resume is not None:
        raise RequestError("out and resume name two folders; resume writes into its own")
    run = RunOptions(t_end, rtol, atol, max_step, integrator, rows, max_steps, dict(parameters))
    study = study_of(
        design, vary or {}, measure, scene, sample=sample, seed=seed, points=points, run=run, options=options
    )
    count = study.workers(workers)
    if not yes:
        study.check_size(count)
    folder = resume if resume is not None else out
    with bar("sweep") if progress is True else nullcontext((None, None)) as (_, part):
        told: Callable[[float, float], None] | None = progress if callable(progress) else part
        table = study.run(
            None if folder is None else Path(folder),
            count,
            resume=resume is not None,
            progress=told,
            scheduler=scheduler,
        )
    dataset = table.dataset()
    for name, shares in indices(table).items():
        dataset[f"{name}.first_order"] = ("varied", shares.first)
        dataset[f"{name}.total"] = ("varied", shares.total)
        dataset.coords["varied"] = list(table.plan.names)
    return dataset
