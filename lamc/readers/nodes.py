"""Tagged nodes with their places: what a YAML file says, whatever its tags name.

In: nothing; `inert.compose` makes them of text. Out: values by YAML 1.2's core schema, and plain data. No tag
constructs, imports or calls anything here.
"""

import math
import re
from dataclasses import dataclass, field
from typing import Any

from lamc.basics.errors import DesignError, Place

YAML_TAG_PREFIX = "tag:yaml.org,2002:"
STANDARD_TAGS = frozenset({"", "!", "str", "int", "float", "bool", "null", "seq", "map"})

_NULL = frozenset({"", "~", "null", "Null", "NULL"})
_BOOL = {"true": True, "True": True, "TRUE": True, "false": False, "False": False, "FALSE": False}
_INT = re.compile(r"[-+]?[0-9]+\Z")
_FLOAT = re.compile(r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?\Z")
_INFINITE = re.compile(r"[-+]?\.(inf|Inf|INF)\Z")
_NAN = frozenset({".nan", ".NaN", ".NAN"})
_LONGEST_NUMBER = 400


@dataclass(frozen=True, slots=True, eq=False)
class _NodeBase:
    """tag: "" if the file gave none; `size` is the number of nodes with aliases written out."""

    tag: str
    file: str
    line: int
    column: int
    size: int

    @property
    def place(self) -> Place:
        return Place(self.file, self.line, self.column)

    @property
    def class_name(self) -> str:
        """What a python-object tag or a local tag names, without its package."""
        return re.split(r"[.:!/]", self.tag)[-1]

    def error(self, message: str) -> DesignError:
        """A DesignError at this node."""
        return DesignError(message, self.place)


@dataclass(frozen=True, slots=True, eq=False)
class ScalarNode(_NodeBase):
    """`plain` is True where the text stood without quotes, and so may be a number, a boolean or null."""

    text: str
    plain: bool

    @property
    def value(self) -> str | int | float | bool | None:
        """The value by YAML 1.2's core schema."""
        return resolve(self.text) if self.plain and self.tag != "str" else self.text


@dataclass(frozen=True, slots=True, eq=False)
class ListNode(_NodeBase):
    items: "tuple[Node, ...]"


@dataclass(frozen=True, slots=True, eq=False)
class MapNode(_NodeBase):
    """Keys may be any node: an older popupCAD form keys shapes by material objects."""

    pairs: "tuple[tuple[Node, Node], ...]"
    _by_text: "dict[str, Node]" = field(default_factory=dict, init=False, repr=False)  # once it is asked for

    def get(self, key: str) -> "Node | None":
        """The value under a scalar key of that text, or None; the first of several."""
        if self.pairs and not self._by_text:
            known = {k.text: v for k, v in reversed(self.pairs) if isinstance(k, ScalarNode)}
            self._by_text.update(known)  # at once, for whoever looks meanwhile
        return self._by_text.get(key)


Node = ScalarNode | ListNode | MapNode


def resolve(text: str) -> str | int | float | bool | None:
    """The value of a plain scalar by YAML 1.2's core schema (`no` is a string, `1e-5` a number)."""
    if text in _NULL:
        return None
    if text in _BOOL:
        return _BOOL[text]
    if len(text) <= _LONGEST_NUMBER:
        if _INT.match(text):
            return int(text)
        if _FLOAT.match(text):
            return float(text)
    if _INFINITE.match(text):
        return -math.inf if text[0] == "-" else math.inf
    return math.nan if text in _NAN else text


def plain(node: Node) -> Any:
    """The node as str, int, float, bool, None, lists and string-keyed dicts; tags are dropped.

    Aliased nodes become one shared object. Raises DesignError for a key that is not a scalar.
    """
    return _plain(node, {})


def _plain(node: Node, seen: dict[int, Any]) -> Any:
    if isinstance(node, ScalarNode):
        return node.value
    if id(node) in seen:
        return seen[id(node)]
    result: Any
    if isinstance(node, ListNode):
        result = [_plain(item, seen) for item in node.items]
    else:
        result = {}
        for key, value in node.pairs:
            if not isinstance(key, ScalarNode):
                raise key.error("a list or map stands as a key here; keys must be plain words")
            result[key.text] = _plain(value, seen)
    seen[id(node)] = result
    return result
