"""The words of `lamc optimise`: its options and their help. What works is imported when the verb runs."""

from dataclasses import replace
from typing import TYPE_CHECKING

import click

from lamc.commands.design_options import design, sourced
from lamc.commands.options import looked, speaking
from lamc.commands.study_options import each_run
from lamc.commands.terminal import Terminal

if TYPE_CHECKING:
    from lamc.commands.inputs import SceneChanges, Source
    from lamc.report.look import Look

METHODS = ("auto", "least-squares", "slsqp", "trust-constr", "nelder-mead", "evolution", "cma-es", "nsga2")


@click.command()
@design
@click.option("--study", metavar="NAME", help="A study that ships with lamc instead of FILE: jump.")
@click.option(
    "--vary",
    multiple=True,
    metavar="NAME=RANGE",
    help="FROM:TO, log:FROM:TO, whole numbers 3..8, or choices A|B|C.",
)
@click.option(
    "--minimise",
    multiple=True,
    metavar="EXPRESSION",
    help="The goal: 'rms(tip.z - 5 mm)'. Two of them make a front (extra: optimise).",
)
@click.option(
    "--subject-to",
    multiple=True,
    metavar="COMPARISON",
    help="What must hold: 'max(abs(h1)) < 60 deg', '0 < last(tip.x) < 5 mm', 'last(h1) == 0.2'.",
)
@click.option(
    "--method",
    metavar="NAME",
    help=f"{', '.join(METHODS)}.  [default: auto, by goal and constraints]",
    show_default=False,
)
@click.option(
    "--start", multiple=True, metavar="NAME=VALUE", help="Where to begin.  [default: the design's own]"
)
@click.option("--starts", type=int, metavar="N", help="How many; others by a Latin hypercube.  [default: 5]")
@click.option("--seed", type=int, metavar="N", help="Of all that is drawn.  [default: 0]")
@click.option("--max-runs", type=int, metavar="N", help="Runs after which it ends.  [default: 5000]")
@each_run("1e-11", "1e-13")
@click.option("--workers", type=int, metavar="N", help="Processes.  [default: one for each processor]")
@click.option(
    "--resume",
    is_flag=True,
    help="Go on with the search in the folder; runs that are there are not made again.",
)
@click.option(
    "--to",
    type=click.Choice(["csv", "netcdf"]),
    multiple=True,
    default=("csv",),
    help="Format of the history; may stand several times.",
)
@click.option("--no-pictures", is_flag=True, help="Draw nothing.")
@looked
@click.option(
    "--out",
    metavar="DIR",
    help="Folder to write to.  [default: out/<name of the design>_optimise]",
    show_default=False,
)
@speaking
@sourced
def optimise(
    source: "Source",
    study: str | None,
    vary: tuple[str, ...],
    minimise: tuple[str, ...],
    subject_to: tuple[str, ...],
    method: str | None,
    start: tuple[str, ...],
    starts: int | None,
    seed: int | None,
    max_runs: int | None,
    t_end: float | None,
    rtol: float | None,
    atol: float | None,
    integrator: str,
    rows: int | None,
    max_steps: int,
    changes: "SceneChanges",
    workers: int | None,
    resume: bool,
    to: tuple[str, ...],
    no_pictures: bool,
    look: "Look",
    out: str | None,
    terminal: Terminal,
) -> int:
    """Find the parameters of a design for which a measure is least.

    FILE is a design, or a study (kind: study; `lamc schema study`), over which options go.
    NAME is what `lamc sweep` can vary: a dimension of the design, a parameter of its model (h1.stiffness), an input, a
    start (angles.h1, rates.h1), t_end. Goals and constraints are made of its measures. A run that fails counts as bad.
    It says "converged" only where it has looked: slopes vanish, and no point beside is lower. After Ctrl-C, --resume.

    \b
    Writes study.json, rows.jsonl (a line for each run), history.csv and optimum.png.
    Tells each parameter with what it is known to and how far it may move for 1 % of the value, and what holds it.
    Exit code 3 if it did not converge: what was found is written all the same.

    \b
    Examples:
      lamc optimise leg.yaml --vary length=20mm:60mm --minimise 'rms(tip.z - 5 mm)'
      lamc optimise leg.yaml --vary h1.stiffness=log:1e-4:1e-2 --minimise 'time_of(h1 < 0)' \\
        --subject-to 'max(abs(h1.rate)) < 5 rad/s'
      lamc optimise crane.yaml --vary facets=3..8 --minimise='-max(tip.z)' --method evolution
    """
    from lamc.commands.optimise import OptimiseOrder
    from lamc.commands.optimise import optimise as work
    from lamc.commands.sweep import study_path
    from lamc.studies.bench import RunOptions

    if study is not None:
        source = replace(source, file=study_path(study, source.file, source.example))
    order = OptimiseOrder(
        source=source,
        changes=changes,
        vary=vary,
        minimise=minimise,
        subject_to=subject_to,
        method=method,
        start=start,
        starts=starts,
        seed=seed,
        max_runs=max_runs,
        run=RunOptions(t_end, rtol, atol, None, integrator, rows, max_steps),
        resume=resume,
        to=to,
        pictures=not no_pictures,
        look=look,
        out=out,
        workers=workers,
    )
    return work(order, terminal)
