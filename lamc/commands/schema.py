"""`lamc schema`: prints the JSON Schema of design, mechanism, scene and plate files."""

import json

from lamc.commands.terminal import print_out
from lamc.readers.plates.problem_schema import PlateFileModel
from lamc.readers.schema import FILES, json_schema


def schema() -> int:
    """The schema on stdout."""
    print_out(json.dumps(json_schema({**FILES, "PlateProblem": PlateFileModel}), indent=2, ensure_ascii=True))
    return 0
