"""`lamc schema`: prints the JSON Schema of design and mechanism files."""

import json

import click

from lamc.design.schema import json_schema


def schema() -> int:
    """The schema on stdout."""
    click.echo(json.dumps(json_schema(), indent=2, ensure_ascii=True))
    return 0
