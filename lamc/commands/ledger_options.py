"""The words of `lamc ledger`: its options and their help. What measures is imported when the verb runs."""

from typing import TYPE_CHECKING

import click

from lamc.commands.design_options import compiler, design, dimensions, sheeted, sourced, staged
from lamc.commands.options import folder, speaking, until
from lamc.commands.terminal import Terminal

if TYPE_CHECKING:
    from lamc.commands.inputs import SceneChanges, Source


@click.command()
@design
@staged()
@sheeted
@compiler
@until("the runs")
@click.option(
    "--accuracy",
    default="1 %",
    metavar="SHARE",
    help="What matters to you, of the outputs' range: 1e-3 or '0.1 %'; effects below it are told.",
)
@click.option(
    "--budget",
    default="30s",
    metavar="TIME",
    help="Time for measuring, after compiling; what does not fit is told.",
)
@click.option(
    "--tightest", type=float, default=1e-12, metavar="RTOL", help="Tightest tolerance of the sweep."
)
@click.option(
    "--integrator",
    "integrators",
    metavar="NAME",
    multiple=True,
    help="Only this one, of lamc, scipy:LSODA, ..., cvode, mujoco; again for more.  [default: all]",
)
@click.option("--no-effects", is_flag=True, help="Leave out the account of effects and of arithmetic.")
@click.option("--full", is_flag=True, help="Print a line for every setting.")
@click.option("--schema", "only_schema", is_flag=True, help="Print the JSON Schema of ledger.json, and end.")
@dimensions
@folder
@speaking
@sourced
def ledger(
    source: "Source",
    changes: "SceneChanges",
    t_end: float | None,
    accuracy: str,
    budget: str,
    tightest: float,
    integrators: tuple[str, ...],
    no_effects: bool,
    full: bool,
    only_schema: bool,
    out: str | None,
    terminal: Terminal,
) -> int:
    """Measure what accuracy costs on a design, and which effects matter.

    Runs the scene with every integrator at tolerances from 1e-3 to 1e-12 against a reference of its own, beside scipy,
    CVODE and MuJoCo where they are installed; then without each effect in turn. Writes ledger.json and ledger.png.

    \b
    Examples:
      lamc ledger pendulum.cad
      lamc ledger --example four_bar --t-end 2 --accuracy '0.1 %' --budget '1 min'
    """
    from lamc.commands.ledger import LedgerOrder, schema
    from lamc.commands.ledger import ledger as work

    if only_schema:
        return schema()
    order = LedgerOrder(
        source=source,
        changes=changes,
        t_end=t_end,
        accuracy=accuracy,
        budget=budget,
        tightest=tightest,
        integrators=integrators,
        account=not no_effects,
        full=full,
        out=out,
    )
    return work(order, terminal)
