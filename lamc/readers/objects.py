"""Reading objects that another program pickled into YAML, as inert data.

In: nodes with python-object tags. Out: numbers, words, lists, or a DesignError at the node that is not what
it should be. Nothing here imports, constructs or calls what a tag names.
"""

import math
from collections.abc import Iterator

from lamc.basics.errors import UnsupportedError
from lamc.basics.units import LARGEST
from lamc.readers.inert import ListNode, MapNode, Node, ScalarNode
from lamc.readers.numpy_scalars import numpy_scalar

MM = 1000.0  # mm per m: dividing by it rounds once, so 19.8 mm is the float nearest to 0.0198 m


def refuse_stored_code(root: Node) -> None:
    """Raises UnsupportedError where any object in the file is popupCAD's operation that runs stored code."""
    for node in walk(root):
        if "code_exec_op" in node.tag or "CodeExec" in node.tag:
            raise UnsupportedError(
                "the file stores program code (code_exec_op); lamc never runs stored code: take it out",
                node.place,
            )


def walk(root: Node) -> Iterator[Node]:
    """Every node once, aliases too, in the order of the file."""
    seen: set[int] = set()
    stack = [root]
    while stack:
        node = stack.pop()
        if id(node) in seen:
            continue
        seen.add(id(node))
        yield node
        if isinstance(node, ListNode):
            stack.extend(reversed(node.items))
        elif isinstance(node, MapNode):
            stack.extend(n for pair in reversed(node.pairs) for n in reversed(pair))


def attribute(node: Node, name: str, what: str) -> Node:
    """The object's attribute, or DesignError."""
    found = optional(node, name, what)
    if found is None:
        raise node.error(f"{what} has no {name!r}; the file is damaged or of another kind")
    return found


def optional(node: Node, name: str, what: str) -> Node | None:
    """The object's attribute, or None where it has none or says null."""
    if not isinstance(node, MapNode):
        raise node.error(f"{what} is not an object with named values; the file is damaged or of another kind")
    found = node.get(name)
    return None if isinstance(found, ScalarNode) and found.value is None else found


def items(node: Node, what: str) -> tuple[Node, ...]:
    """The list's items, or DesignError."""
    if not isinstance(node, ListNode):
        raise node.error(f"{what} is not a list; the file is damaged or of another kind")
    return node.items


def number(node: Node, what: str, *, minimum: float = -math.inf, above: float = -math.inf) -> float:
    """A finite number within bounds, or DesignError. A numpy scalar is one too."""
    value = node.value if isinstance(node, ScalarNode) else numpy_scalar(node, what)
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise node.error(f"{what} is not a number")
    try:
        result = float(value)
    except OverflowError:
        result = math.inf
    if not abs(result) < LARGEST or result < minimum or result <= above:
        bound = (
            f" and at least {minimum:g}"
            if minimum > -math.inf
            else f" and above {above:g}"
            if above > -math.inf
            else ""
        )
        raise node.error(f"{what} is {result!r}; it must be finite, below {LARGEST:g}{bound}")
    return result


def word(node: Node, what: str) -> str:
    """The text of a single value, or DesignError."""
    if not isinstance(node, ScalarNode):
        raise node.error(f"{what} is not a single value; the file is damaged or of another kind")
    return node.text


def flag(node: Node | None, what: str, *, default: bool) -> bool:
    """True or false, `default` where there is nothing, or DesignError."""
    if node is None:
        return default
    value = node.value if isinstance(node, ScalarNode) else None
    if not isinstance(value, bool):
        raise node.error(f"{what} is not true or false")
    return value


def object_id(node: Node) -> str:
    """The object's id as text, or DesignError."""
    return word(attribute(node, "id", f"the {node.class_name[:60] or 'object'}"), "an id")
