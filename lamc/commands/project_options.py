"""The words of `lamc convert` and `lamc new`: their options and help."""

from typing import TYPE_CHECKING

import click

from lamc.commands.design_options import dimensions, sheeted
from lamc.commands.options import speaking
from lamc.commands.terminal import Terminal

if TYPE_CHECKING:
    from lamc.records.card import SheetOptions


@click.command()
@click.argument("source", metavar="FILE")
@click.argument("target", metavar="NEW_FILE")
@sheeted
@dimensions
@click.option("--force", is_flag=True, help="Replace NEW_FILE where it is there.")
@speaking
def convert(
    source: str,
    target: str,
    sheet: "SheetOptions",
    settings: tuple[str, ...],
    force: bool,
    terminal: Terminal,
) -> int:
    """Write what FILE holds in another format, by the suffix of NEW_FILE.

    .yaml (a native design, or a mechanism), .mechanism.yaml, .joints, .fold, .svg, .dxf. Tells what the new file does
    not hold; what it cannot hold at all, such as layers in FOLD, is refused. Beside an SVG or DXF file of a laminate it
    writes NEW_FILE.yaml, a design that takes its shapes from there. No file is replaced without --force, and
    none that is read.

    \b
    Examples:
      lamc convert pendulum.cad pendulum.yaml
      lamc convert four_bar.yaml four_bar.mechanism.yaml
      lamc convert crane.fold crane.svg
      lamc convert four_bar.yaml four_bar.dxf
    """
    from lamc.commands.convert import convert as work
    from lamc.commands.inputs import Source

    return work(Source(source, sheet=sheet, settings=settings), target, terminal, force=force)


@click.command()
@click.argument("folder", metavar="DIR")
@click.option(
    "--kind",
    type=click.Choice(["laminate", "sheet", "mechanism"]),
    default="laminate",
    help="Layers with hinges, a sheet of card with creases, or bodies and hinges without a drawing.",
)
@speaking
def new(folder: str, kind: str, terminal: Terminal) -> int:
    """Start a project in DIR: a design and a scene to edit, with comments, and a README with what to do next.

    It runs as it is. A folder that holds anything is refused.

    \b
    Examples:
      lamc new gripper
      lamc new map_fold --kind sheet
    """
    from lamc.commands.new import new as work

    return work(folder, kind, terminal)
