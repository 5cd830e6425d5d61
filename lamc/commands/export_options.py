"""The words of `lamc export`: its options and their help. What exports is imported when the verb runs."""

from typing import TYPE_CHECKING

import click

from lamc.commands.design_options import design, dimensions, sheeted, sourced, staged
from lamc.commands.options import speaking
from lamc.commands.terminal import Terminal
from lamc.export import TARGETS
from lamc.run.methods import SHOWN

if TYPE_CHECKING:
    from lamc.commands.inputs import SceneChanges, Source


_HELP = f"""Write a design's simulator, or a plate's elements, for other programs. Targets:
{", ".join(f"{name} ({target.users})" for name, target in TARGETS.items())}. A plate's file, with --to c only,
gives the matrix of its elements, its loads and a solver.

The folder of --to c needs neither lamc nor Python: sources, CMake and pkg-config files, an example, and a README
with the mechanism's picture. Files that lamc did not write, or that were edited, are not replaced; options that
the target has no use for are refused.

\b
Examples:
  lamc export pendulum.cad --out pendulum_c
  lamc export flaps.yaml --integrator rk45 --single-header
  lamc export flaps.yaml --scene driven --real-time --prefix flaps_rt
  lamc export flaps.yaml --to fmu --fmi 3
  lamc export four_bar.yaml --to mjcf --step 5e-4
  lamc export flaps.yaml --to cut --kerf '0.1 mm' --sheet '300 mm x 200 mm' --pins '3 mm'
  lamc export strip.yaml --size '1 mm'
"""


@click.command(help=_HELP, short_help="Write a simulator, or a plate, for other programs.")
@design
@click.option(
    "--to",
    "target",
    default="c",
    metavar="TARGET",
    help=f"{', '.join(TARGETS)}; `lamc export --to list` tells what each is.",
    show_default=True,
)
@dimensions
@staged()
@sheeted
@click.option(
    "--prefix", metavar="NAME", help="What all names in the C begin with.  [default: the design's name]"
)
@click.option(
    "--real-time", is_flag=True, help="Steps of fixed length and known cost only; their operations are told."
)
@click.option(
    "--no-libm",
    is_flag=True,
    help="Call no mathematical library: the same bits on every machine and compiler.",
)
@click.option(
    "--float",
    "single",
    is_flag=True,
    help="All numbers in single precision, for processors without doubles; with --real-time.",
)
@click.option("--single-header", is_flag=True, help="One file, NAME.h, with the sources in it.")
@click.option(
    "--integrator",
    default="auto",
    metavar="NAME",
    help=f"What steps are taken with: {SHOWN}; only what is needed is exported. With "
    "--real-time, rodas5p takes steps that are stable with stiff hinges.",
)
@click.option(
    "--fmi", type=click.Choice(["2", "3"]), help="Of --to fmu: the version of the standard.  [default: 2]"
)
@click.option(
    "--step",
    type=float,
    metavar="SECONDS",
    help="Of --to mjcf: the time step of the model.  [default: one that suits]",
)
@click.option(
    "--size",
    metavar="LENGTH",
    help="Of a plate: length of the mesh's edges, such as '2 mm'; bare numbers are m.",
)
@click.option(
    "--hinge-style",
    default="gap",
    metavar="STYLE",
    help="Of --to cut: how hinges are cut, gap, castellated or perforated; with a pitch, 'perforated, 1 mm'.",
)
@click.option(
    "--hinge-width",
    default="drawn",
    metavar="WIDTH",
    help="Of --to cut: what boards leave free at hinges: drawn (as simulated), gap, or a length.",
)
@click.option(
    "--kerf", default="0", metavar="LENGTH", help="Of --to cut: what the cutter takes away, '0.1 mm'."
)
@click.option(
    "--pins", metavar="LENGTH", help="Of --to cut: diameter of pins that layers are put on, '3 mm'."
)
@click.option("--sheet", "stock", metavar="SIZE", help="Of --to cut: size of the sheets, '300 mm x 200 mm'.")
@click.option(
    "--lossy", is_flag=True, help="Leave out what the target's format cannot tell, instead of refusing it."
)
@click.option(
    "--inputs",
    default="hinges",
    metavar="NAMES",
    help="Torques from outside: on all hinges (hinges), none, or on those named, with commas between.",
    show_default=True,
)
@click.option("--force", is_flag=True, help="Replace files that were edited or are not lamc's, too.")
@click.option(
    "--out",
    metavar="DIR",
    help="Folder to write to.  [default: out/<name of the design>_<target>]",
    show_default=False,
)
@speaking
@sourced
def export(
    source: "Source",
    target: str,
    changes: "SceneChanges",
    prefix: str | None,
    real_time: bool,
    no_libm: bool,
    single: bool,
    single_header: bool,
    integrator: str,
    fmi: str | None,
    step: float | None,
    size: str | None,
    hinge_style: str,
    hinge_width: str,
    kerf: str,
    pins: str | None,
    stock: str | None,
    lossy: bool,
    inputs: str,
    force: bool,
    out: str | None,
    terminal: Terminal,
) -> int:
    from lamc.commands.export import ExportOrder, inputs_of
    from lamc.commands.export import export as work
    from lamc.commands.export_plate import edge_length
    from lamc.export.options import ExportOptions

    options = ExportOptions(
        prefix=prefix,
        precision="float" if single else "double",
        integrator=integrator,
        real_time=real_time,
        libm=not no_libm,
        single_header=single_header,
        fmi=None if fmi is None else int(fmi),
        inputs=inputs_of(inputs),
        lossy=lossy,
        step=step,
        edge_length=edge_length(size),
        hinge_style=hinge_style,
        hinge_width=hinge_width,
        kerf=kerf,
        pins=pins,
        stock=stock,
    )
    return work(
        ExportOrder(source, changes, target, options, force, out),
        terminal,
    )
