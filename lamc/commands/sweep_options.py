"""The words of `lamc sweep`: its options and their help. What works is imported when the verb runs."""

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


@click.command()
@design
@click.option(
    "--study", metavar="NAME", help="A study that ships with lamc instead of FILE: leg, wing, jump."
)
@click.option("--copy", metavar="DIR", help="With --study: write its files into this folder, to edit.")
@click.option(
    "--vary",
    multiple=True,
    metavar="NAME=RANGE",
    help="FROM:TO:COUNT, log:FROM:TO:COUNT, A,B,C, or with --sample FROM:TO or normal(MEAN, DEVIATION), ...",
)
@click.option(
    "--measure",
    "measures",
    multiple=True,
    metavar="[NAME=]EXPRESSION",
    help="What to read off each run: 'max(tip.z)', 'reach=last(tip.x) - 5 mm', ...",
)
@click.option(
    "--points", metavar="FILE", help="Points one by one: a CSV file whose first line has the names."
)
@click.option(
    "--sample",
    metavar="METHOD:COUNT",
    help="lhs, sobol, halton, random; saltelli for Sobol' indices: lhs:200.",
)
@click.option("--seed", type=int, metavar="N", help="Of the samples.  [default: 0]")
@each_run("1e-9", "1e-11")
@click.option("--workers", type=int, metavar="N", help="Processes.  [default: one for each processor]")
@click.option("--scheduler", metavar="ADDRESS", help="Of a Dask cluster that does the work: tcp://HOST:8786.")
@click.option(
    "--resume", is_flag=True, help="Go on with the study in the folder; what is there is not run again."
)
@click.option("--yes", is_flag=True, help="More than a million points are meant.")
@click.option(
    "--to",
    type=click.Choice(["csv", "netcdf", "zarr"]),
    multiple=True,
    default=("csv",),
    help="Format of the table; may stand several times.",
)
@click.option("--no-pictures", is_flag=True, help="Draw nothing: the table only.")
@looked
@click.option(
    "--out",
    metavar="DIR",
    help="Folder to write to.  [default: out/<name of the design>_sweep]",
    show_default=False,
)
@speaking
@sourced
def sweep(
    source: "Source",
    study: str | None,
    copy: str | None,
    vary: tuple[str, ...],
    measures: tuple[str, ...],
    points: str | None,
    sample: str | None,
    seed: int | None,
    t_end: float | None,
    rtol: float | None,
    atol: float | None,
    integrator: str,
    rows: int | None,
    max_steps: int,
    changes: "SceneChanges",
    workers: int | None,
    scheduler: str | None,
    resume: bool,
    yes: bool,
    to: tuple[str, ...],
    no_pictures: bool,
    look: "Look",
    out: str | None,
    terminal: Terminal,
) -> int:
    """Run a design at many points; write a table of what is measured.

    FILE is a design, or a study (kind: study; `lamc schema study`), over which options go.
    NAME is a dimension of the design, a parameter of its model (h1.stiffness), an input, a start (angles.h1, rates.h1),
    t_end, rtol, atol or max_step. A point that makes no run is a row with its reason. Rows are kept as they come:
    after Ctrl-C or a kill, --resume goes on, and the table is the same, byte for byte.

    \b
    Writes study.json (what it is of), rows.jsonl (a line for each point), table.csv and study.png.
    Measures: max min mean rms integral first last of any output of a run (tip.z, h1, h1.rate, energy.gravity),
      at(h1, 0.5 s), h1[-1], time_of(h1 > 20 deg), time_of(max(h1)), events('upper limit of h1'), with units.

    \b
    Examples:
      lamc sweep --study leg
      lamc sweep flaps.yaml --vary left.stiffness=log:1e-4:1e-2:7 --measure 'time_of(left < 0)' --t-end 2
      lamc sweep flaps.yaml --vary 'left.stiffness=normal(1e-3, 1e-4)' --sample lhs:200 --measure 'max(left)'
    """
    from lamc.commands.sweep import SweepOrder, copy_study, study_path
    from lamc.commands.sweep import sweep as work
    from lamc.studies.bench import RunOptions

    if copy is not None:
        return copy_study(study, copy, terminal)
    if study is not None:
        source = replace(source, file=study_path(study, source.file, source.example))
    order = SweepOrder(
        source=source,
        changes=changes,
        vary=vary,
        measures=measures,
        points=points,
        sample=sample,
        seed=seed,
        run=RunOptions(t_end, rtol, atol, None, integrator, rows, max_steps),
        workers=workers,
        scheduler=scheduler,
        resume=resume,
        yes=yes,
        to=to,
        pictures=not no_pictures,
        look=look,
        out=out,
    )
    return work(order, terminal)
