"""What the verbs of the command line share: one-line errors, exit codes, and options that return.

In: words. Out: click decorators, and a group whose commands return exit codes. It computes nothing.
"""

import functools
import sys
from collections.abc import Callable, Sequence
from contextlib import suppress
from typing import Any

import click

from lamc.basics.errors import DesignError, RequestError
from lamc.codegen.options import PRECISIONS
from lamc.commands.terminal import INTERRUPTED, Terminal, open_streams, tell, unprinted

Function = Callable[..., Any]

SETTINGS = {"help_option_names": ["-h", "--help"], "max_content_width": 110, "show_default": True}


class Cli(click.Group):
    """A group whose errors are one line, and whose commands return exit codes."""

    def main(
        self,
        args: Sequence[str] | None = None,
        prog_name: str | None = None,
        complete_var: str | None = None,
        standalone_mode: bool = True,
        **extra: Any,
    ) -> Any:
        """Runs a verb and ends the process with its exit code."""
        open_streams()
        for stream in (sys.stdout, sys.stderr):
            if hasattr(stream, "reconfigure"):  # an old terminal may lack a sign such as °
                stream.reconfigure(errors="replace")
        try:
            code = super().main(args, prog_name or "lamc", complete_var, standalone_mode=False, **extra)
        except click.UsageError as error:
            where = error.ctx.command_path if error.ctx is not None else "lamc"
            reported = " ".join(error.format_message().split())
            tell(f"error: {reported} (see `{where} --help`)")
            code = error.exit_code
        except click.ClickException as error:
            tell(f"error: {error.format_message()}")
            code = 2
        except (click.Abort, KeyboardInterrupt):
            tell("error: interrupted")
            code = INTERRUPTED
        except OSError as error:  # of help and version; commands guard what they do
            refusal = unprinted(error)
            tell(f"error: {refusal.message}")
            code = refusal.exit_code
        if not standalone_mode:
            return code
        sys.exit(code if isinstance(code, int) else 0)


def seconds(context: click.Context, parameter: click.Parameter, value: str | None) -> float | None:
    """Callback of an option that is a time: a number of seconds, or text with a unit such as '500 ms'."""
    if value is None:
        return None
    with suppress(ValueError):
        return float(value)
    from lamc.basics.units import DURATION, to_si  # `--help` does without it

    try:
        return to_si(value, DURATION)
    except DesignError as error:
        raise click.BadParameter(str(error), context, parameter) from error


def until(what: str) -> Function:
    """--t-end of `what`, "the run" or "the runs"."""
    text = f"End of {what}.  [default: the scene's duration, else 10]"
    return click.option("--t-end", callback=seconds, metavar="SECONDS", help=text)


def _settings(of: str) -> Function:
    text = f"Change a parameter of the design{of}: 0.05 (SI) or '50 mm'."
    return click.option("--set", "settings", metavar="NAME=VALUE", multiple=True, help=text)


dimensions = _settings("")
settings = _settings(", or of the run")


def together(*options: Function) -> Function:
    """Several click decorators as one; the first is shown first."""
    return lambda function: functools.reduce(lambda f, option: option(f), reversed(options), function)


def speaking(function: Function) -> Function:
    """Adds --json, --quiet and --debug, hands the function a Terminal, and turns its errors into exit codes."""

    @click.option(
        "--json", "as_json", is_flag=True, help="Print one JSON document on stdout and nothing else there."
    )
    @click.option("--quiet", is_flag=True, help="Print errors only.")
    @click.option("--debug", is_flag=True, help="Show the traceback of errors.")
    @functools.wraps(function)
    def wrapped(*, as_json: bool, quiet: bool, debug: bool, **given: Any) -> int:
        terminal = Terminal(as_json, quiet, debug)
        return terminal.guard(lambda: function(terminal=terminal, **given))

    return wrapped


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
        help="Of a sheet: the facet that is held, F12, or a point in it, '10 mm, 20 mm'.  [default: in the middle]",
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
        help="Of an SVG or DXF file: how far ends of lines may be off, '50 um'; 0 mends nothing.",
    ),
    click.option(
        "--facets",
        type=click.Choice(["rigid", "bend"]),
        help="Of a sheet of creases: whether facets bend.  [default: where nothing moves otherwise]",
        show_default=False,
    ),
)


def sheeted(function: Function) -> Function:
    """Adds the options of sheets of creases, and hands the function SheetOptions, `sheet`."""

    @functools.wraps(function)
    def wrapped(
        *,
        fixed: str | None,
        card: str | None,
        crease: str | None,
        units: str | None,
        roles: tuple[str, ...],
        roles_file: str | None,
        heal: str | None,
        facets: Any,
        **given: Any,
    ) -> int:
        from lamc.records.card import Card, SheetOptions, fixed_of, roles_of  # `--help` does without it

        try:
            every = roles_of(roles)
            if roles_file is not None:
                from lamc.readers.drawings.roles_file import read_roles

                every = {**read_roles(roles_file), **every}
            sheet = SheetOptions(
                fixed_of(fixed) if fixed else None,
                Card.of(card) if card else None,
                crease,
                units,
                every or None,
                heal,
                facets,
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


def looked(function: Function) -> Function:
    """Adds --format, --camera and --size, and hands the function a Look, `look`."""

    @functools.wraps(function)
    def wrapped(*, format_: str, camera: str | None, size: int | None, **given: Any) -> int:
        from lamc.report.look import Look, camera_of

        try:
            look = Look(camera_of(camera), size, format_)
        except RequestError as error:
            raise click.UsageError(error.message) from error
        return int(function(look=look, **given))

    options = together(
        click.option(
            "--format",
            "format_",
            type=click.Choice(["png", "svg", "pdf"]),
            default="png",
            help="Format of the pictures.",
        ),
        click.option(
            "--camera",
            metavar="VIEW",
            help="front, back, left, right, top, bottom, corner, or AZIMUTH,ELEVATION in degrees.  "
            "[default: where the motion is seen best]",
        ),
        click.option(
            "--size", type=int, metavar="PIXELS", help="Longer side of the device's picture, and of a film."
        ),
    )
    decorated: Function = options(wrapped)
    return decorated


run_folder = click.option(
    "--out",
    metavar="DIR",
    help="Folder to write to.  [default: out/<name of the design>/<name of the scene>]",
    show_default=False,
)
folder = click.option(
    "--out",
    metavar="DIR",
    help="Folder to write to.  [default: out/<name of the design>]",
    show_default=False,
)
