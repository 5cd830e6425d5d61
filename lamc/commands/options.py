"""What the verbs of the command line share: one-line errors, exit codes, and options that return.

In: words. Out: click decorators, and a group whose commands return exit codes. It computes nothing. Options that name a
design are in `design_options.py`.
"""

import functools
import sys
from collections.abc import Callable, Sequence
from contextlib import suppress
from typing import Any

import click

from lamc.basics.errors import DesignError, RequestError
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


camera_option = click.option(
    "--camera",
    metavar="VIEW",
    help="front, back, left, right, top, bottom, corner, or AZIMUTH,ELEVATION in degrees.  "
    "[default: where the motion is seen best]",
)
size_option = click.option(
    "--size", type=int, metavar="PIXELS", help="Longer side of the device's picture, and of a film."
)


def looked(function: Function) -> Function:
    """Adds --format, --camera and --size, and hands the function a Look, `look`."""
    format_option = click.option(
        "--format",
        "format_",
        type=click.Choice(["png", "svg", "pdf"]),
        default="png",
        help="Format of the pictures.",
    )
    return _looking(function, format_option, camera_option, size_option)


def viewed(function: Function) -> Function:
    """Adds --camera and --size alone, and hands the function a Look, `look`."""
    return _looking(function, camera_option, size_option)


def _looking(function: Function, *options: Function) -> Function:
    """It stands above `speaking`, so that click tells what is wrong with the options, before any work begins."""

    @functools.wraps(function)
    def wrapped(*, camera: str | None, size: int | None, format_: str = "png", **given: Any) -> int:
        from lamc.report.look import Look, camera_of

        try:
            look = Look(camera_of(camera), size, format_)
        except RequestError as error:
            raise click.UsageError(error.message) from error
        return int(function(look=look, **given))

    decorated: Function = together(*options)(wrapped)
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
