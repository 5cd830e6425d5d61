"""`lamc schema`: prints the JSON Schema of design, mechanism, scene and plate files."""

import json

import click

from lamc.design.schema import FILES, json_schema
from lamc.plate.files.problem_schema import PlateFileModel


def schema() -> int:
    """The schema on stdout."""
    click.echo(
        json.dumps(json_schema({**FILES, "PlateProblem": PlateFileModel}), indent=2, ensure_ascii=True)
    )
    return 0
