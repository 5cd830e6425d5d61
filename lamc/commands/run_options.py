"""The words of `lamc run`: its options and their help. What simulates is imported when the verb runs."""

from typing import TYPE_CHECKING

import click

from lamc.commands.design_options import (
    compiler,
    design,
    hinges,
    precision,
    settings,
    sheeted,
    sourced,
    staged,
)
from lamc.commands.options import looked, run_folder, speaking, until
from lamc.commands.terminal import Terminal
from lamc.run.methods import SHOWN

if TYPE_CHECKING:
    from lamc.commands.inputs import SceneChanges, Source
    from lamc.report.look import Look


@click.command()
@design
@until("the run")
@click.option(
    "--points",
    type=int,
    metavar="N",
    help="Rows of the results, evenly spread; 0: every step.  [default: 200 a second, 2001 at least]",
)
@click.option(
    "--accuracy",
    metavar="SHARE",
    help="Error of the outputs that is wanted, of their range: 1e-3 or '0.1 %'. It finds integrator and tolerances.",
)
@click.option(
    "--rtol",
    type=float,
    help="Relative tolerance of a step.  [default: 1e-9; 1e-6 where that gets far and nobody says how long]",
)
@click.option(
    "--atol",
    type=float,
    help="Absolute tolerance of a step, rad and rad/s.  [default: 1e-11; 1e-8 beside 1e-6]",
)
@click.option(
    "--integrator",
    default="auto",
    metavar="NAME",
    help=f"{SHOWN}, or scipy:LSODA, ...",
)
@click.option(
    "--max-steps",
    type=int,
    metavar="N",
    help="Steps after which a run gives up.  [default: 1000000; fewer of large mechanisms without a --t-end]",
)
@settings
@staged()
@hinges
@sheeted
@compiler
@precision
@click.option(
    "--energy-balance",
    is_flag=True,
    help="Keep the work of every effect: who stored, supplied, dissipated.",
)
@click.option("--books", is_flag=True, hidden=True)
@click.option(
    "--film/--no-film", default=False, help="Make a film too: MP4 where the extra `video` is, else GIF."
)
@click.option("--no-animation", is_flag=True, hidden=True)
@click.option("--no-pictures", is_flag=True, help="Draw nothing: results only.")
@looked
@click.option("--verbose", is_flag=True, help="Name the effects that are not in, each with the reason.")
@run_folder
@speaking
@sourced
def run(
    source: "Source",
    changes: "SceneChanges",
    t_end: float | None,
    points: int | None,
    accuracy: str | None,
    rtol: float | None,
    atol: float | None,
    integrator: str,
    max_steps: int | None,
    energy_balance: bool,
    books: bool,
    film: bool,
    no_animation: bool,
    no_pictures: bool,
    look: "Look",
    verbose: bool,
    out: str | None,
    terminal: Terminal,
) -> int:
    """Simulate a design; write results and pictures.

    Writes results.npz, results.csv, angles_energy.png, folded.png and manifest.json, and with --film a film. Ctrl-C
    ends the run and keeps what was computed. A run that reaches its end but not its --accuracy says so and ends with
    exit code 0; manifest.json has the error that it reached.

    \b
    Examples:
      lamc run pendulum.cad
      lamc run flaps.yaml --t-end 2 --angle left='20 deg' --set left.stiffness=0.002
      lamc run flaps.yaml --without gravity --with 'torque={left: "0.001*sin(2*pi*5*t)"}'
      lamc run pendulum.yaml --scene driven
      lamc run pendulum.yaml --accuracy '0.1 %'
      lamc run flaps.yaml --hinge-stiffness from-material
      lamc run pendulum.cad --scene scenes.yaml:slow --without hinge_damping
      lamc run --example pendulum --energy-balance
      lamc run --example crawler --film --camera front
    """
    from lamc.commands.run import RunOrder
    from lamc.commands.run import run as work

    if books:
        terminal.warn("--books is --energy-balance now")
    if no_animation:
        terminal.warn("--no-animation is --no-film now, which is what happens unless --film is there")
    order = RunOrder(
        source=source,
        changes=changes,
        t_end=t_end,
        accuracy=accuracy,
        rtol=rtol,
        atol=atol,
        integrator=integrator,
        points=points,
        max_steps=max_steps,
        film=film,
        pictures=not no_pictures,
        look=look,
        verbose=verbose,
        energy_balance=energy_balance or books,
        out=out,
    )
    return work(order, terminal)
