"""Numbers that PyYAML wrote as numpy scalars: a type and its bytes in base64, decoded as data.

In: the node of such a scalar. Out: a number, None for any other node, or a DesignError where the bytes are damaged.
Never: imports or calls what a tag names; of a type only its letter, width and byte order are read.

    !!python/object/apply:numpy.core.multiarray.scalar
    - !!python/object/apply:numpy.dtype
      args: [f8, 0, 1]
      state: !!python/tuple [3, <, null, null, null, -1, -1, 0]
    - !!binary AAAAAAAA8D8=
"""

import base64
import binascii
import re
import struct

from lamc.readers.inert import ListNode, MapNode, Node, ScalarNode

_SCALARS = frozenset(
    f"python/object/apply:numpy.{core}.multiarray.scalar" for core in ("core", "_core")
)  # numpy 2 renamed the module
_TYPES = {"f8": "d", "f4": "f", "i8": "q", "i4": "i", "i2": "h", "i1": "b", "u8": "Q", "u4": "I", "u2": "H"}
_LONGEST = 64  # characters of base64 and white space: eight bytes are 12


def numpy_scalar(node: Node, what: str) -> float | int | None:
    """The value of a numpy scalar; None for a node that is none. Raises DesignError where it cannot be decoded."""
    if not isinstance(node, ListNode) or node.tag not in _SCALARS:
        return None
    if len(node.items) != 2:
        raise node.error(f"{what} is a numpy scalar of {len(node.items)} parts; it has a type and bytes")
    kind, data = node.items
    letters, order = _type(kind, what)
    if not isinstance(data, ScalarNode) or data.tag != "binary" or len(data.text) > _LONGEST:
        raise data.error(f"{what} is a numpy scalar without the bytes of one number; write it as a number")
    try:
        raw = base64.b64decode("".join(data.text.split()), validate=True)
        (value,) = struct.unpack(order + _TYPES[letters], raw)
    except (binascii.Error, struct.error, ValueError) as error:
        raise data.error(
            f"{what} is a numpy scalar of type {letters} whose bytes are damaged; write it as a number"
        ) from error
    assert isinstance(value, int | float)
    return value


def _type(node: Node, what: str) -> tuple[str, str]:
    """Letter with width, and byte order as `struct` has it, of a numpy.dtype."""
    arguments: Node | None = node
    state: Node | None = None
    if isinstance(node, MapNode):
        arguments, state = node.get("args"), node.get("state")
    known = (
        node.tag == "python/object/apply:numpy.dtype" and isinstance(arguments, ListNode) and arguments.items
    )
    first = arguments.items[0] if known and isinstance(arguments, ListNode) else None
    text = first.text if isinstance(first, ScalarNode) else ""
    match = re.fullmatch(r"([<>=|]?)([fiu][1248])", text)
    if match is None or match[2] not in _TYPES:
        raise node.error(f"{what} is a numpy scalar of a type that lamc does not know; write it as a number")
    order = match[1]
    if isinstance(state, ListNode) and len(state.items) > 1 and isinstance(state.items[1], ScalarNode):
        order = state.items[1].text
    return match[
        2
    ], ">" if order == ">" else "<"  # "=" and "|": PyYAML's machines are little-endian, as numpy says "<"
