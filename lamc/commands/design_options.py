"""Options that name a design and its scene, change them, and say how they are compiled.

In: words. Out: click decorators, which hand a verb its design as one `Source`, its sheet as `SheetOptions`, and what
becomes of its scene as `SceneChanges`. It reads no file but that of `--roles`, and computes nothing.
"""

import functools
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import click

from lamc.basics.errors import DesignError
from lamc.codegen.options import PRECISIONS
from lamc.commands.options import Function, together

if TYPE_CHECKING:
    from lamc.records.card import SheetOptions


def _settings(of: str) -> Function:
    text = f"Change a parameter of the design{of}: 0.05 (SI) or '50 mm'."
    return click.option("--set", "settings", metavar="NAME=VALUE", multiple=True, help=text)


dimensions = _settings("")
settings = _settings(", or of the run")


design = together(
    click.argument("file", required=False),
    click.option("--example", metavar="NAME", help="An example instead of FILE; see `lamc examples`."),
)
compiler = together(
    click.option("--cc", metavar="COMMAND", help="C compiler, such as gcc or 'zig cc'."),
    click.option("--fast", is_flag=True, help="This machine's own instructions, and inline sine and cosine."),
)
hinges = together(
    click.option(
        "--hinge-stiffness",
        type=click.Choice(["drawn", "from-material"]),
        default="drawn",
        help="Stiffness of hinges: as the file says, or from the flexible layer's material and the hinge's size.",
    ),
    click.option(
        "--material",
        "materials",
        metavar="NAME=MATERIAL",
        multiple=True,
        help="With from-material: a material of lamc's library (`lamc materials`) in place of the file's NAME.",
    ),
)
_sheet = together(
    click.option(
        "--fixed",
        metavar="FACET",
        multiple=True,
        help="Of a sheet: a facet that is held, F12, or a point in it, '10 mm, 20 mm'.  [default: in the middle]",
        show_default=False,
    ),
    click.option(
        "--card",
        metavar="CARD",
        help="Of a sheet: thickness and density.  [default: '0.3 mm, 700 kg/m^3']",
        show_default=False,
    ),
    click.option(
        "--crease",
        metavar="STIFFNESS",
        help="Of a sheet: of creases by length.  [default: '1e-3 N*mm/rad/mm']",
        show_default=False,
    ),
    click.option(
        "--units",
        metavar="UNIT",
        help="Of a sheet: what 1 is.  [default: what the file says, else mm]",
        show_default=False,
    ),
    click.option(
        "--role",
        "roles",
        metavar="LINE=ROLE",
        multiple=True,
        help="Of an SVG or DXF file: what lines of a colour or layer are for, red=cut.",
    ),
    click.option(
        "--roles",
        "roles_file",
        metavar="FILE",
        help="Of an SVG or DXF file: the same for many lines, YAML: {'#ff0000': cut, engraving: ignore}.",
    ),
    click.option(
        "--heal",
        metavar="LENGTH",
        help="Of a drawing, or FOLD file without faces: how far ends of lines may be off, '50 um'; 0 mends nothing.",
    ),
    click.option(
        "--facets",
        type=click.Choice(["rigid", "bend"]),
        help="Of a sheet of creases: whether facets bend.  [default: where rigid ones do not fold well]",
        show_default=False,
    ),
    click.option(
        "--large", is_flag=True, help="Facets, hinges and loops so many that they take minutes are meant."
    ),
)


def sheeted(function: Function) -> Function:
    """Adds the options of sheets of creases, and hands the function SheetOptions, `sheet`."""

    @functools.wraps(function)
    def wrapped(
        *,
        fixed: tuple[str, ...],
        card: str | None,
        crease: str | None,
        units: str | None,
        roles: tuple[str, ...],
        roles_file: str | None,
        heal: str | None,
        facets: Any,
        large: bool,
        **given: Any,
    ) -> int:
        from lamc.records.card import Card, SheetOptions, fixed_of, roles_of  # `--help` does without it

        try:
            every = roles_of(roles)
            if roles_file is not None:
                from lamc.readers.drawings.roles_file import read_roles

                every = {**read_roles(roles_file), **every}
            sheet = SheetOptions(
                [fixed_of(each) for each in fixed] or None,
                Card.of(card) if card else None,
                crease,
                units,
                every or None,
                heal,
                facets,
                large,
            )
        except DesignError as error:
            raise click.UsageError(str(error)) from error
        return int(function(sheet=sheet, **given))

    decorated: Function = _sheet(wrapped)
    return decorated


precision = click.option(
    "--precision",
    type=click.Choice(PRECISIONS),
    default="double",
    help="Arithmetic of accelerations; float leaves errors of some 1e-7 in them, whatever the tolerance.",
)
_effects = together(
    click.option(
        "--scene",
        metavar="SCENE",
        help="What to simulate: a scene of the design by its NAME, or FILE, or FILE:NAME.",
    ),
    click.option(
        "--with",
        "with_",
        metavar="EFFECT",
        multiple=True,
        help="Add an effect to the scene: NAME or NAME=VALUE, as in a file of scenes.",
    ),
    click.option("--without", metavar="EFFECT", multiple=True, help="Leave an effect of the scene out."),
)
_start = together(
    click.option(
        "--angle",
        "angles",
        metavar="HINGE=ANGLE",
        multiple=True,
        help="Initial angle: 0.3 (rad) or '20 deg'.",
    ),
    click.option(
        "--rate",
        "rates",
        metavar="HINGE=RATE",
        multiple=True,
        help="Initial rate: 1.5 (rad/s) or '90 deg/s'.",
    ),
    click.option(
        "--branch",
        type=int,
        metavar="N",
        help="Way out of a singular start: 1, 2, ...; -1 the same the other way.",
    ),
)


def staged(*, start: bool = True) -> Callable[[Function], Function]:
    """Adds the options that name a scene and change it, and hands the function a SceneChanges, `changes`.

    start  False for verbs to which it makes no difference where the mechanism starts
    """

    def decorate(function: Function) -> Function:
        @functools.wraps(function)
        def wrapped(
            *,
            scene: str | None,
            with_: tuple[str, ...],
            without: tuple[str, ...],
            angles: tuple[str, ...] = (),
            rates: tuple[str, ...] = (),
            branch: int | None = None,
            **given: Any,
        ) -> int:
            from lamc.commands.inputs import SceneChanges  # `--help` need not wait for it

            changes = SceneChanges(with_, without, angles, rates, branch, scene)
            return int(function(changes=changes, **given))

        options: list[Function] = [_effects, _start] if start else [_effects]
        decorated: Function = together(*options)(wrapped)
        return decorated

    return decorate


def sourced(function: Function) -> Function:
    """Hands the function a Source, `source`, made of the options of a design that its verb has."""

    @functools.wraps(function)
    def wrapped(
        *,
        file: str | None,
        example: str | None = None,
        cc: str | None = None,
        fast: bool = False,
        precision: str = "double",
        hinge_stiffness: str = "drawn",
        materials: tuple[str, ...] = (),
        sheet: "SheetOptions",
        settings: tuple[str, ...] = (),
        **given: Any,
    ) -> int:
        from lamc.commands.hinge_choice import HingeChoice  # `--help` need not wait for it
        from lamc.commands.inputs import Source

        hinges = HingeChoice(hinge_stiffness, materials)
        source = Source(file, example, cc, fast, precision, hinges, sheet, settings)
        return int(function(source=source, **given))

    return wrapped
