"""What `lamc sweep` and `lamc optimise` ask alike: how each of many runs goes, on which design, compiled how."""

from collections.abc import Callable
from typing import Any

import click

from lamc.commands.design_options import compiler, hinges, precision, settings, sheeted, staged
from lamc.commands.options import until

Command = Callable[..., Any]


def each_run(rtol: str, atol: str) -> Callable[[Command], Command]:
    """Adds t_end, rtol, atol, integrator, rows, max_steps, and what changes scene, design and compilation. rtol, atol:
    the defaults, for people."""
    words = (
        until("the runs"),
        click.option("--rtol", type=float, help=f"Relative tolerance of a step.  [default: {rtol}]"),
        click.option(
            "--atol", type=float, help=f"Absolute tolerance of a step, rad and rad/s.  [default: {atol}]"
        ),
        click.option("--integrator", default="auto", metavar="NAME", help="As of `lamc run`."),
        click.option(
            "--rows",
            type=int,
            metavar="N",
            help="Rows of each run that measures look at.  [default: 200 a second, 2001 at least]",
        ),
        click.option(
            "--max-steps", type=int, default=1_000_000, metavar="N", help="Steps after which a run gives up."
        ),
        settings,
        staged(),
        hinges,
        sheeted,
        compiler,
        precision,
    )

    def asked(command: Command) -> Command:
        for word in reversed(words):
            command = word(command)
        return command

    return asked
