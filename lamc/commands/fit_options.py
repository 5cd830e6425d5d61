"""The words of `lamc fit`: its options and their help. What works is imported when the verb runs."""

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
from lamc.commands.options import speaking, viewed
from lamc.commands.terminal import Terminal

if TYPE_CHECKING:
    from lamc.commands.inputs import SceneChanges, Source
    from lamc.report.look import Look


@click.command()
@design
@click.option(
    "--data",
    multiple=True,
    metavar="FILE",
    help="A recording: CSV, or an export of Tracker or Motive; several may stand.",
)
@click.option(
    "--map",
    "maps",
    multiple=True,
    metavar="NAME=WHAT",
    help="What a column is (h1, h1.rate, t), or where a marker sits as drawn: marker1='link_2@(30mm, 0, 0)'.",
)
@click.option(
    "--free",
    multiple=True,
    metavar="NAME[=RANGE]",
    help="A number to find: LOW:HIGH, log:LOW:HIGH, 'MEAN ± DEVIATION'; of recordings delay=LOW:HIGH, angles.h1, …",
)
@click.option(
    "--hold-out", multiple=True, metavar="FILE", help="A recording that is left out and compared afterwards."
)
@click.option(
    "--start",
    type=click.Choice(["known", "estimated"]),
    default="known",
    help="Of the recordings: as the scene starts, at t = 0, or to be found from the first row on.",
)
@click.option(
    "--frame",
    metavar="AXES",
    help="Markers are in a frame along these world axes, x,-z or x,y,z, whose scale, rotation and origin are found.",
)
@click.option("--unit", metavar="UNIT", help="Of markers whose heading says none, such as mm.  [default: m]")
@click.option(
    "--loss",
    type=click.Choice(["linear", "soft_l1", "huber", "cauchy", "arctan"]),
    default="linear",
    help="How outliers count.",
)
@click.option(
    "--starts", type=int, default=4, metavar="N", help="Places to begin at, where the first leads nowhere."
)
@click.option("--seed", type=int, default=0, metavar="N", help="Of these places.")
@click.option(
    "--design",
    multiple=True,
    metavar="COLUMN",
    help="What might be recorded beside (h2, link_2.x): says how much more each would tell.",
)
@settings
@staged()
@hinges
@sheeted
@compiler
@precision
@click.option(
    "--film/--no-film",
    default=False,
    help="Film each recording over the fitted motion: MP4 where the extra `video` is, else GIF.",
)
@viewed
@click.option("--no-pictures", is_flag=True, help="Draw nothing.")
@click.option(
    "--out",
    metavar="DIR",
    help="Folder to write to.  [default: out/<name of the design>_fit]",
    show_default=False,
)
@speaking
@sourced
def fit(
    source: "Source",
    data: tuple[str, ...],
    maps: tuple[str, ...],
    free: tuple[str, ...],
    hold_out: tuple[str, ...],
    start: str,
    frame: str | None,
    unit: str | None,
    loss: str,
    starts: int,
    seed: int,
    design: tuple[str, ...],
    changes: "SceneChanges",
    film: bool,
    look: "Look",
    no_pictures: bool,
    out: str | None,
    terminal: Terminal,
) -> int:
    """Find numbers of a model from recordings of the device.

    NAME is a parameter of the model (h1.stiffness, link_1.mass) or a dimension of the design. Columns that are named as
    the model's hinges need no --map; headings hold units: t [s], h1 [deg], tip.x [mm]. Empty cells and NaN are gaps.

    \b
    Writes scene.yaml with what was found, for `lamc run FILE --scene`; fit.json, overlay.png, residuals.png, fit.html;
    with --film overlay.mp4 (overlay_2.mp4, ...), in which recorded points and angles are drawn over the fitted motion.
    Tells 95 % intervals, what the data cannot tell, and where residuals are no noise.
    Exit code 3 if it did not converge: what was found is written all the same.

    \b
    Examples:
      lamc fit flap.yaml --data run1.csv --data run2.csv --free h1.stiffness --free h1.damping
      lamc fit flap.yaml --data cam.csv --map 'tip=link_2@(30mm, 0, 0)' --frame x,-z --free h1.stiffness \\
        --free delay=0:20ms --hold-out other.csv --film
    """
    from lamc.commands.fit import FitOrder
    from lamc.commands.fit import fit as work

    order = FitOrder(
        source=source,
        changes=changes,
        data=data,
        maps=maps,
        free=free,
        hold_out=hold_out,
        start=start,
        frame=frame,
        unit=unit,
        loss=loss,
        starts=starts,
        seed=seed,
        pictures=not no_pictures,
        film=film,
        look=look,
        design=design,
        out=out,
    )
    return work(order, terminal)
