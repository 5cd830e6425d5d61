"""The words of `lamc view`: its options and their help. What simulates is imported when the verb runs."""

from typing import TYPE_CHECKING

import click

from lamc.commands.design_options import compiler, settings, sheeted, staged
from lamc.commands.options import speaking, until
from lamc.commands.terminal import Terminal

if TYPE_CHECKING:
    from lamc.commands.inputs import SceneChanges
    from lamc.records.card import SheetOptions


@click.command()
@click.argument("files", nargs=-1, metavar="[FILE]...")
@click.option("--example", "examples", metavar="NAME", multiple=True, help="An example besides the FILEs.")
@until("the run")
@settings
@staged()
@compiler
@sheeted
@click.option("--fold", is_flag=True, help="No run: the mechanism as drawn, folded by sliders.")
@click.option(
    "--no-live", is_flag=True, help="Without the model: a smaller page that plays what was recorded."
)
@click.option("--out", metavar="FILE", help="Page to write.  [default: out/<name>.html]", show_default=False)
@click.option("--open", "open_", is_flag=True, help="Open it in the browser.")
@speaking
def view(
    files: tuple[str, ...],
    examples: tuple[str, ...],
    t_end: float | None,
    settings: tuple[str, ...],
    changes: "SceneChanges",
    sheet: "SheetOptions",
    cc: str | None,
    fast: bool,
    fold: bool,
    no_live: bool,
    out: str | None,
    open_: bool,
    terminal: Terminal,
) -> int:
    """Show a device in motion, or a plate that bends, as one HTML page.

    The page needs no network and no files beside it. With a compiler for WebAssembly the model runs in it: sliders
    change parameters, inputs and start angles. FILE is a design, a mechanism, a plate file, or the folder of a finished
    `lamc run`; several are shown side by side.

    \b
    Examples:
      lamc view flaps.yaml --open
      lamc view pendulum.yaml --scene driven --out driven.html
      lamc view out/pendulum
      lamc view strip.yaml
      lamc view --example vertex --fold
      lamc view pendulum.cad flaps.yaml
    """
    from lamc.commands.inputs import Source
    from lamc.commands.view import ViewOrder
    from lamc.commands.view import view as work

    sources = [Source(file, None, cc, fast, sheet=sheet, settings=settings) for file in files] + [
        Source(None, name, cc, fast, sheet=sheet, settings=settings) for name in examples
    ]
    return work(ViewOrder(tuple(sources), changes, t_end, fold, not no_live, out, open_), terminal)
