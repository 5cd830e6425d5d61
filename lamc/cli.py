"""The command line: `lamc VERB FILE [options]`.

In: words. Out: a call of one function in `lamc.commands`, and its exit code: 0, 2 bad input, 3 failed simulation,
4 failed build, 130 after Ctrl-C, 1 a bug of lamc. What computes is imported when a verb runs, so that `--help` is
quick.
"""

from typing import TYPE_CHECKING

import click

from lamc.basics._version import __version__
from lamc.commands.design_options import (
    compiler,
    design,
    dimensions,
    hinges,
    precision,
    sheeted,
    sourced,
    staged,
)
from lamc.commands.export_options import export
from lamc.commands.fit_options import fit
from lamc.commands.ledger_options import ledger
from lamc.commands.modes_options import modes
from lamc.commands.optimise_options import optimise
from lamc.commands.options import SETTINGS, Cli, folder, seconds, speaking
from lamc.commands.plate_options import plate
from lamc.commands.project_options import convert, new
from lamc.commands.reference_options import effects, functions, materials, schema
from lamc.commands.run_options import run
from lamc.commands.sweep_options import sweep
from lamc.commands.terminal import Terminal
from lamc.commands.view_options import view

if TYPE_CHECKING:
    from lamc.commands.inputs import SceneChanges, Source


@click.group(cls=Cli, context_settings=SETTINGS, invoke_without_command=True)
@click.version_option(__version__, "--version", "-V", prog_name="lamc")
@click.pass_context
def main(context: click.Context) -> None:
    """Compiles laminate designs (flat layers, materials, hinge lines) into fast native simulators.

    FILE is a native design or mechanism (YAML), a sheet of creases (FOLD, SVG, DXF), a popupCAD design (.cad) or a
    popupCAD joint definition (.joints); its content decides, not its name.

    \b
    Try:
      lamc run --example pendulum      simulate, and write results and pictures
      lamc view --example pendulum     a page that shows it in 3D, with sliders
      lamc sweep --example pendulum    run it at many points, and measure each run
      lamc optimise STUDY.yaml         find the parameters for which a measure is least
      lamc modes --example four_bar    where it rests, and how it vibrates about it
      lamc check --example pendulum    compare generated C, interpreter and an independent formulation
      lamc ledger --example four_bar   what accuracy costs, and which effects matter
      lamc export --example pendulum   sources for programs in C, C++ and other languages
      lamc plate --example strip       bend a laminate: deflection, moments, stress, modes
      lamc new gripper                 start a project: a design and a scene to edit
      lamc convert crane.fold a.svg    another format, and what it does not hold
      lamc examples                    list the designs that ship with lamc
      lamc schema hinge                what a file may say: also design, scene, effects, plate, ...
      lamc doctor                      see whether this machine has what lamc needs

    Exit codes: 2 bad input, 3 failed simulation, 4 failed build, 130 after Ctrl-C.
    """
    if context.invoked_subcommand is None:
        click.echo(context.get_help())


@main.command()
@design
@dimensions
@staged(start=False)
@sheeted
@click.option("--equations", is_flag=True, help="Write the equations too: equations.txt and equations.tex.")
@click.option(
    "--out",
    metavar="DIR",
    help="Folder for the C.  [default: out/<name of the design>_build]",
    show_default=False,
)
@click.option("--force", is_flag=True, help="Replace files that were edited or are not lamc's, too.")
@speaking
@sourced
def build(
    source: "Source",
    changes: "SceneChanges",
    equations: bool,
    out: str | None,
    force: bool,
    terminal: Terminal,
) -> int:
    """Write the generated C into a folder that compiles by itself.

    Tells what one evaluation costs. Files that lamc did not write, or that were edited, are not
    overwritten. `lamc export` writes the C for other programs.

    \b
    Examples:
      lamc build pendulum.cad --out pendulum_c
      lamc build pendulum.cad --equations
    """
    from lamc.commands.build import build as work

    return work(source, changes, out, equations=equations, force=force, terminal=terminal)


@main.command()
@design
@dimensions
@staged()
@sheeted
@compiler
@click.option("--states", type=int, default=20, metavar="N", help="Random states to compare at.")
@click.option(
    "--t-end", callback=seconds, default="1.0", metavar="SECONDS", help="End of the run that is compared."
)
@speaking
@sourced
def check(
    source: "Source",
    changes: "SceneChanges",
    states: int,
    t_end: float,
    terminal: Terminal,
) -> int:
    """Compare generated C, interpreter and an independent formulation.

    Exit code 3 if any difference is beyond its limit.

    \b
    Independent formulations, all in numbers:
      Newton-Euler  hinges between rigid bodies, with all forces and torques of lamc's effects; moving bases too
      maximal       the same with six freedoms per body and multipliers, up to 30 joints
      Lagrange      free_base, base_motion, twist_compliance, flexible_links, added mass of blade_element_drag
    Effects of one's own have none: C and interpreter are compared then, and a note says so.

    \b
    Example:
      lamc check pendulum.cad
    """
    from lamc.commands.check import check as work

    return work(source, changes, states, t_end, terminal)


@main.command()
@design
@dimensions
@hinges
@sheeted
@folder
@speaking
@sourced
def split(
    source: "Source",
    out: str | None,
    terminal: Terminal,
) -> int:
    """Find the bodies and hinges of a design; write them as files.

    Prints the tables, what the loops come to and the ways out of a singular drawing; writes a joint definition
    (.joints), a mechanism file and a picture of the steps.

    \b
    Example:
      lamc split pendulum.cad --out parts
      lamc split flaps.yaml --hinge-stiffness from-material --material "film=Kapton HN"
    """
    from lamc.commands.split import split as work

    return work(source, out, terminal)


@main.command()
@design
@dimensions
@staged()
@sheeted
@compiler
@precision
@folder
@speaking
@sourced
def bench(
    source: "Source",
    changes: "SceneChanges",
    out: str | None,
    terminal: Terminal,
) -> int:
    """Measure symbolic evaluation against generated C on a design.

    Compares sympy's subs and evalf, lambdified numpy, lamc's interpreter and the generated C; writes bench.json and
    bench.png.

    \b
    Example:
      lamc bench pendulum.cad
    """
    from lamc.commands.bench import bench as work

    return work(source, changes, out, terminal)


main.add_command(convert)
main.add_command(export)
main.add_command(fit)
main.add_command(ledger)
main.add_command(new)
main.add_command(optimise)
main.add_command(modes)
main.add_command(plate)
main.add_command(run)
main.add_command(sweep)
main.add_command(view)


@main.command()
@click.argument("name", required=False)
@click.option("--copy", metavar="DIR", help="Write its file into this folder, to edit; no file is replaced.")
@click.option("--picture", metavar="FILE", help="Run them all and draw them, folded, into this PNG file.")
@speaking
def examples(name: str | None, copy: str | None, picture: str | None, terminal: Terminal) -> int:
    """List the designs that ship with lamc, or tell one's story.

    Each is hard in a way of its own and runs as it is. Two are made to any size: miura:COLUMNSxROWS and n_four_bar:N.

    \b
    Examples:
      lamc examples
      lamc examples miura:4x5
      lamc examples sarrus --copy mine
    """
    from lamc.basics.errors import LamcError
    from lamc.commands.examples import list_examples, show_example

    if picture is not None:
        if name is not None or copy is not None:
            raise LamcError("--picture draws all examples; name neither one of them nor --copy with it")
        from lamc.commands.gallery import picture as draw

        return draw(picture, terminal)
    if name is not None:
        return show_example(name, copy, terminal)
    if copy is not None:
        raise LamcError("--copy needs the name of an example: lamc examples NAME --copy DIR")
    return list_examples(terminal)


main.add_command(schema)
main.add_command(materials)
main.add_command(effects)
main.add_command(functions)


@main.command()
@click.option("--cc", metavar="COMMAND", help="C compiler to try.")
@speaking
def doctor(cc: str | None, terminal: Terminal) -> int:
    """See whether this machine has what lamc needs.

    Exit code 4 without a C compiler that works, or a cache that can be written.
    """
    from lamc.commands.doctor import doctor as work

    return work(cc, terminal)


if __name__ == "__main__":
    main()
