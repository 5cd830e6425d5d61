"""The words of `lamc plate`: its options, and what they stand for.

In: words. Out: a call of `lamc.commands.plate`, imported when the verb runs so that `--help` is quick.
"""

import click

from lamc.commands.options import folder, speaking, together
from lamc.commands.terminal import Terminal

of_designs = together(
    click.option("--body", metavar="NAME", multiple=True, help="Of a design: the body that is the plate."),
    click.option(
        "--hinges",
        type=click.Choice(["none", "lines", "strips"]),
        help="Of a design: strips that bend end where they were cut, are left out, or belong to it.  [default: none]",
        show_default=False,
    ),
    click.option(
        "--material",
        "materials",
        metavar="NAME=MATERIAL",
        multiple=True,
        help="Of a design: a material of lamc's library, or numbers, in place of the file's own.",
    ),
    click.option("--clamp", "clamps", metavar="PLACE", multiple=True, help="Of a design: clamped there."),
    click.option("--hinge", "hinged", metavar="PLACE", multiple=True, help="Of a design: on a hinge there."),
    click.option(
        "--load",
        "loads",
        metavar="LOAD",
        multiple=True,
        help="Of a design: PLACE=FORCE, or as in a plate file.",
    ),
)
shown = together(
    click.argument("file", required=False),
    click.option("--example", metavar="NAME", help="An example instead of FILE; see --examples."),
    click.option("--examples", "listed", is_flag=True, help="List the plates that ship with lamc."),
    click.option(
        "--copy",
        metavar="DIR",
        help="Write the example's file into this folder, to edit; no file is replaced.",
    ),
)


@click.command()
@shown
@click.option(
    "--element",
    metavar="NAME",
    help="Element, such as dkt, dkmt (with shear) or dkt+lst; auto: one of the first two; alone: tells what it is.",
)
@click.option(
    "--size", metavar="LENGTH", help="Length of the mesh's edges, such as '2 mm'; bare numbers are m."
)
@click.option("--modes", type=int, metavar="N", help="Natural modes to compute.")
@click.option("--buckling", type=int, metavar="N", help="Buckling loads to compute.")
@click.option("--case", "cases", metavar="NAME", multiple=True, help="Solve this case only.")
@click.option(
    "--solver",
    type=click.Choice(["auto", "cholmod", "superlu", "pardiso"]),
    default="auto",
    help="Of the sparse equations.",
)
@of_designs
@click.option(
    "--two-meshes",
    is_flag=True,
    help="Solve again on halved cells, and tell how far off outputs, modes and buckling loads are.",
)
@click.option("--no-pictures", is_flag=True, help="Draw nothing.")
@folder
@speaking
def plate(
    file: str | None,
    example: str | None,
    listed: bool,
    copy: str | None,
    element: str | None,
    size: str | None,
    modes: int | None,
    buckling: int | None,
    cases: tuple[str, ...],
    solver: str,
    body: tuple[str, ...],
    hinges: str | None,
    materials: tuple[str, ...],
    clamps: tuple[str, ...],
    hinged: tuple[str, ...],
    loads: tuple[str, ...],
    two_meshes: bool,
    no_pictures: bool,
    out: str | None,
    terminal: Terminal,
) -> int:
    """Bend a laminate: deflections, moments, ply stress, modes, buckling.

    FILE is a plate file (YAML), or a design of which one body is the plate. Writes fields.vtu, fields.csv,
    summary.json and pictures.

    PLACE is boundary, left, right, bottom, top, fixed, the name of a hinge, or as in a plate file: 'point: [0, 1]'.

    \b
    Examples:
      lamc plate --example square --size '2.5 mm'
      lamc plate flaps.yaml --body link_1 --hinges lines --clamp 'hinge: left' --load left='-1 mN'
      lamc plate --element dkt
    """
    from lamc.commands.plate_input import PlateSource

    if listed or copy is not None:
        from lamc.commands.plate_examples import copy_example, list_examples

        return list_examples(terminal) if copy is None else copy_example(example, copy, terminal)
    from lamc.commands.plate import PlateOrder
    from lamc.commands.plate import plate as work

    return work(
        PlateOrder(
            source=PlateSource(file, example, body, hinges, clamps, hinged, loads, materials),
            element=element,
            size=size,
            modes=modes,
            buckling=buckling,
            cases=cases,
            solver=solver,
            pictures=not no_pictures,
            two_meshes=two_meshes,
            out=out,
        ),
        terminal,
    )
