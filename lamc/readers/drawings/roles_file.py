"""A file that says what the lines of drawings are for: a YAML map of colours and layers to roles.

In: a path. Out: roles by line, as `SheetOptions.roles` takes them. The convention of a shop, written once.
"""

from pathlib import Path

from lamc.basics.errors import DesignError, Place
from lamc.basics.files import read_bytes
from lamc.readers.inert import DEFAULT_LIMITS, Limits, compose
from lamc.readers.nodes import MapNode, ScalarNode
from lamc.records.drawing import ROLES, Role

_EXAMPLE = "'#ff0000': cut, engraving: ignore"


def read_roles(path: Path | str, limits: Limits = DEFAULT_LIMITS) -> dict[str, Role]:
    """The roles in a file. Raises DesignError with the line for what is no colour or layer with a role."""
    file = str(path)
    try:
        text = read_bytes(Path(path), limits.bytes).decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise DesignError("the file of roles is no text; it is YAML in UTF-8", Place(file)) from error
    lines = [line.strip() for line in text.splitlines() if line.strip()]
    if all(line.startswith("#") for line in lines):
        raise DesignError(
            f"the file says no role; colours stand in quotes, as # begins a comment: {_EXAMPLE}",
            Place(file, 1),
        )
    node = compose(text, file, limits=limits)
    if not isinstance(node, MapNode):
        raise node.error(f"a file of roles is a map of colours and layers to roles: {_EXAMPLE}")
    roles: dict[str, Role] = {}
    for key, value in node.pairs:
        if not isinstance(key, ScalarNode) or not key.text.strip():
            raise key.error(f"a role is given for a colour or a layer by its name: {_EXAMPLE}")
        role = next((role for role in ROLES if isinstance(value, ScalarNode) and value.text == role), None)
        if role is None:
            found = repr(value.text[:40]) if isinstance(value, ScalarNode) else "no word"
            raise value.error(f"the role of {key.text[:40]!r} is {found}; roles are {', '.join(ROLES)}")
        roles[key.text.strip()] = role
    return roles
