"""The words of `lamc modes`: its options and their help. What computes is imported when the verb runs."""

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
from lamc.commands.options import folder, looked, seconds, speaking
from lamc.commands.terminal import Terminal

if TYPE_CHECKING:
    from lamc.commands.inputs import SceneChanges, Source
    from lamc.report.look import Look


@click.command()
@design
@click.option("--count", type=int, default=6, metavar="N", help="Modes to print and draw, slowest first.")
@click.option("--stable", is_flag=True, help="Rest where loads push to, not at the nearest equilibrium.")
@click.option("--undamped", is_flag=True, help="As if nothing were lost: without damping.")
@click.option(
    "--at", callback=seconds, metavar="SECONDS", help="Hold loads that change with time as they are then."
)
@click.option("--amplitude", default="20 deg", metavar="ANGLE", help="Of what moves most, in the pictures.")
@settings
@staged()
@hinges
@sheeted
@compiler
@precision
@click.option("--no-pictures", is_flag=True, help="Draw nothing: numbers only.")
@looked
@folder
@speaking
@sourced
def modes(
    source: "Source",
    changes: "SceneChanges",
    count: int,
    stable: bool,
    undamped: bool,
    at: float | None,
    amplitude: str,
    no_pictures: bool,
    look: "Look",
    out: str | None,
    terminal: Terminal,
) -> int:
    """Find where a design rests, and how it vibrates about it.

    The equilibrium next to the scene's start, stable or not, then frequencies, damping ratios and shapes of the small
    motions about it. Writes modes.json, modes.csv and a picture of each mode at both ends of its swing. Exit code 3
    where there is no equilibrium, or none that has modes, with the reason.

    \b
    Examples:
      lamc modes --example four_bar
      lamc modes --example vertex --angle c1='-60 deg' --set c2.stiffness=2e-4
      lamc modes flaps.yaml --without gravity --undamped
      lamc modes --example shutter --at '10 ms'
    """
    from lamc.basics.checks import checked_number
    from lamc.basics.units import ANGLE
    from lamc.commands.modes import ModesOrder
    from lamc.commands.modes import modes as work

    order = ModesOrder(
        source=source,
        changes=changes,
        count=count,
        stable=stable,
        damping=not undamped,
        at=at,
        amplitude=checked_number(amplitude, "--amplitude", quantity=ANGLE),
        pictures=not no_pictures,
        look=look,
        out=out,
    )
    return work(order, terminal)
