"""The words of the verbs that answer questions: schema, materials, effects, functions."""

import click

from lamc.commands.options import speaking
from lamc.commands.terminal import Terminal


@click.command()
@click.argument("name", required=False)
@click.option("--list", "listed", is_flag=True, help="List all that can be asked for.")
@click.option("--json", "as_json", is_flag=True, help="JSON Schema of NAME in place of the table.")
@click.option("--out", metavar="DIR", help="Write JSON Schemas into this folder, for editors.")
@click.option("--debug", is_flag=True, help="Show the traceback of errors.")
def schema(name: str | None, listed: bool, as_json: bool, out: str | None, debug: bool) -> int:
    """Show what design, mechanism, scene and plate files may say.

    With NAME, such as design, hinge, layer, scene, laminate or an effect: a table of its fields with type, unit,
    default and meaning, and an example. Without: the JSON Schema of all files; on a terminal the list of names.

    \\b
    Examples:
      lamc schema hinge
      lamc schema linear_motor
      lamc schema --list
      lamc schema > lamc.schema.json
      lamc schema --out schemas
    """
    import sys

    from lamc.commands.schema import schema as work

    is_for_people = name is None and out is None and not as_json and sys.stdout.isatty()
    return Terminal(debug=debug).guard(
        lambda: work(name, out, as_json=as_json, listed=listed or is_for_people)
    )


@click.command()
@click.argument("name", required=False)
@speaking
def materials(name: str | None, terminal: Terminal) -> int:
    """List the materials of lamc's library, or show one with its source.

    \\b
    Examples:
      lamc materials
      lamc materials "Kapton HN"
    """
    from lamc.commands.reference import show_materials

    return show_materials(name, terminal)


@click.command()
@click.argument("name", required=False)
@speaking
def effects(name: str | None, terminal: Terminal) -> int:
    """List the effects that scenes can call for, or show one with its law, fields and an example.

    \\b
    Examples:
      lamc effects
      lamc effects linear_motor
    """
    from lamc.commands.reference import show_effects

    return show_effects(name, terminal)


@click.command()
@speaking
def functions(terminal: Terminal) -> int:
    """List what expressions in scenes and plates may hold: functions, constants, names.

    \\b
    Example:
      lamc functions
    """
    from lamc.commands.reference import show_functions

    return show_functions(terminal)
