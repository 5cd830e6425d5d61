"""Links of popupCAD's operations to the operations that they rest on, in the forms of all its years.

In: the node of an operation. Out: nodes of ids and outputs by role. Newer operations have `operation_links`, a map from
role to pairs of id and output; older ones have `operation_link1` with `outputref`, or lists of pairs by number.
"""

from lamc.readers.nodes import Node
from lamc.readers.objects import attribute, items, optional

Link = tuple[Node, Node | None]  # id, number of the output; None: the first

ROLES = ("parent", "unary", "binary", "from")
_LISTS = {"unary": "operation_links1", "binary": "operation_links2"}
_OF_ONE = frozenset({"BufferOperation2", "Cleanup", "LayerOp", "ShiftFlip2", "Simplify"})


def links_of(operation: Node, role: str) -> list[Link]:
    """The links of a role, in the file's order. Raises DesignError where they are no links."""
    kind = operation.class_name
    if kind == "Freeze":  # holds its geometry itself; what it was frozen of may be gone
        return []
    if kind in _OF_ONE:
        if role != "parent":
            return []
        target = attribute(operation, "operation_link1", "the operation")
        return [(target, optional(operation, "outputref", "the operation"))]
    if kind == "LaminateOperation":
        name = _LISTS.get(role)
        found = optional(operation, name, "the laminate operation") if name is not None else None
    else:
        links = attribute(operation, "operation_links", "an operation")
        found = optional(links, role, "the operation's links")
    return [_pair(link) for link in items(found, "the operation's links")] if found is not None else []


def _pair(link: Node) -> Link:
    pair = items(link, "a link to an operation")
    if len(pair) != 2:
        raise link.error("a link to an operation is not a pair of id and output")
    return pair[0], pair[1]
