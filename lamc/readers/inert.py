"""YAML read as inert data: tagged nodes with their places, whatever the tags name.

In: text. Out: a `Node` (scalar, list or map) that knows its tag, line and column. This module works on
ruamel.yaml's parser events, below the level where tags mean anything, so no tag constructs, imports or calls.
An alias is a second reference to the same node; its expanded size is counted, never built.

Beyond YAML 1.2 it reads `*id003: 0.65`, an alias as a key without a space before its colon: what PyYAML wrote until
5.1, and with it every popupCAD file of its day.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Any

from ruamel.yaml.error import MarkedYAMLError, YAMLError
from ruamel.yaml.events import (
    AliasEvent,
    DocumentStartEvent,
    MappingEndEvent,
    MappingStartEvent,
    ScalarEvent,
    SequenceEndEvent,
    SequenceStartEvent,
)

from lamc.basics.errors import DesignError, DesignErrors, Place
from lamc.readers.nodes import STANDARD_TAGS as STANDARD_TAGS
from lamc.readers.nodes import YAML_TAG_PREFIX
from lamc.readers.nodes import ListNode as ListNode
from lamc.readers.nodes import MapNode as MapNode
from lamc.readers.nodes import Node as Node
from lamc.readers.nodes import ScalarNode as ScalarNode
from lamc.readers.nodes import plain as plain
from lamc.readers.nodes import resolve as resolve
from lamc.readers.quick_yaml import quick_yaml

Progress = Callable[[str, float], None]

_EVENTS_PER_REPORT = 20_000
_SECONDS, _MEGABYTES = 3e-5, 3e-4  # for each value of a file, measured with 760 000


@dataclass(frozen=True)
class Limits:
    """What a file may cost. Each is named in the error that refuses the file.

    nodes counts values with every alias written out, which takes no time; values those that stand in the file, 10^5
    corners are 3·10^5, a sheet of 5000 facets some more, at some 30 µs each.
    """

    bytes: int = 64 * 1024 * 1024
    nodes: int = 4_000_000
    depth: int = 100
    values: int = 400_000


DEFAULT_LIMITS = Limits()


def compose(
    text: str, file: str = "", *, limits: Limits = DEFAULT_LIMITS, progress: Progress | None = None
) -> Node:
    """The one document in `text` as nodes.

    progress receives ("reading", fraction). Raises DesignError where the text is not YAML, empty, holds
    several documents, or passes a limit, and DesignErrors for keys that stand twice in one map.
    """
    length = max(len(text), 1)
    composer = _Composer(file, limits, length)
    for count, event in enumerate(_events(text, file)):
        composer.take(event)
        if progress is not None and count % _EVENTS_PER_REPORT == 0:
            progress("reading", min(1.0, event.start_mark.index / length))
    if composer.root is None:
        raise DesignError("the file is empty; it must hold a design or a mechanism", Place(file))
    if composer.duplicates:
        raise DesignErrors(composer.duplicates)
    return composer.root


def _beside(key: Node, value: ScalarNode) -> ScalarNode:
    """A value of which nothing is written stands where its key does; the file's next word may be lines away."""
    return replace(value, line=key.line, column=key.column) if value.plain else value


def _events(text: str, file: str) -> Iterator[Any]:
    """ruamel.yaml's parser events, its errors turned into DesignError."""
    try:
        yield from quick_yaml().parse(text)
    except MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        place = Place(file, mark.line + 1, mark.column + 1) if mark else Place(file)
        problem = error.problem or error.context or "it cannot be parsed"
        if "'\\t'" in problem:
            problem += "; indent with spaces, not tabs"
        if problem == "could not find expected ':'":
            problem = "a line above has a key without ': ' behind it, as in units: mm"
        raise DesignError(f"this is not YAML: {problem}", place) from error
    except YAMLError as error:
        raise DesignError(f"this is not YAML: {str(error)[:200]}", Place(file)) from error
    except (AssertionError, OverflowError, ValueError) as error:
        # Not the parser's own errors: it asserts that %YAML names 1.1 or 1.2, and int() and chr() raise the others for
        # a version of thousands of digits and for an escape \U beyond Unicode.
        raise DesignError(
            f"this is not YAML: {str(error)[:200] or type(error).__name__}", Place(file)
        ) from error


@dataclass(slots=True)
class _Open:
    """A list or map whose end has not come yet; a map collects keys and values in turn."""

    event: Any
    items: list[Node]
    size: int = 1


class _Composer:
    """Builds nodes from events with an explicit stack, so that depth is a limit and not a crash."""

    def __init__(self, file: str, limits: Limits, length: int) -> None:
        self.file = file
        self.limits = limits
        self.length = length
        self.root: Node | None = None
        self.duplicates: list[DesignError] = []
        self._stack: list[_Open] = []
        self._anchors: dict[str, Node | None] = {}  # None: the anchored node is still open
        self._documents = 0
        self._read = 0

    def take(self, event: Any) -> None:
        if isinstance(event, ScalarEvent):
            is_plain = bool(event.implicit[0]) or (
                event.style is None and _tag(event) in STANDARD_TAGS - {"", "!", "str"}
            )
            self._add(ScalarNode(_tag(event), self.file, *_where(event), 1, event.value, is_plain), event)
        elif isinstance(event, SequenceStartEvent | MappingStartEvent):
            self._open(event)
        elif isinstance(event, SequenceEndEvent):
            top = self._stack.pop()
            self._add(
                ListNode(_tag(top.event), self.file, *_where(top.event), top.size, tuple(top.items)),
                top.event,
            )
        elif isinstance(event, MappingEndEvent):
            top = self._stack.pop()
            self._add(self._map(top), top.event)
        elif isinstance(event, AliasEvent):
            self._alias(event)
        elif isinstance(event, DocumentStartEvent):
            self._documents += 1
            if self._documents > 1:
                raise self._error(event, "a second YAML document starts here; a file holds one")

    def _open(self, event: Any) -> None:
        if len(self._stack) >= self.limits.depth:
            raise self._error(
                event, f"the file nests deeper than the limit 'depth' of {self.limits.depth} levels"
            )
        if event.anchor is not None:
            self._anchors[event.anchor] = None
        self._stack.append(_Open(event, []))

    def _alias(self, event: Any) -> None:
        if event.anchor not in self._anchors:
            raise self._error(event, f"the alias *{event.anchor} names an anchor that the file does not have")
        node = self._anchors[event.anchor]
        if node is None:
            raise self._error(event, f"the alias *{event.anchor} stands inside its own anchor; data must end")
        self._place(node, event)

    def _add(self, node: Node, event: Any) -> None:
        if event.anchor is not None:
            self._anchors[event.anchor] = node
        self._read += 1
        if self._read > self.limits.values:
            total = float(f"{self._read * self.length / max(event.start_mark.index, 1):.2g}")
            raise self._error(
                event,
                f"the file holds more values than the limit 'values' of {self.limits.values}, each coordinate and each "
                f"pair of them counted: {total:.0f} or so, to read which takes some {_SECONDS * total:.0f} s and "
                f"{_MEGABYTES * total:.0f} MB; draw with fewer corners, or allow more in Python: load(path, "
                "limits=Limits(values=…))",
            )
        self._place(node, event)

    def _place(self, node: Node, event: Any) -> None:
        if not self._stack:
            self.root = node
            return
        top = self._stack[-1]
        top.items.append(node)
        top.size += node.size
        if top.size > self.limits.nodes:
            raise self._too_many(event)

    def _map(self, top: _Open) -> MapNode:
        pairs = tuple(
            (key, _beside(key, value) if isinstance(value, ScalarNode) and not value.text else value)
            for key, value in zip(top.items[::2], top.items[1::2], strict=True)
        )
        seen: dict[str, int] = {}
        for key, _ in pairs:
            if not isinstance(key, ScalarNode):
                continue
            if key.text in seen:
                self.duplicates.append(
                    key.error(
                        f"the key {key.text[:40]!r} stands twice in one map, first in line {seen[key.text]}"
                    )
                )
            seen.setdefault(key.text, key.line)
        return MapNode(_tag(top.event), self.file, *_where(top.event), top.size, pairs)

    def _too_many(self, event: Any) -> DesignError:
        return self._error(
            event,
            f"the file holds more values, aliases written out, than the limit 'nodes' of {self.limits.nodes}; let it "
            "have fewer aliases of large values",
        )

    def _error(self, event: Any, message: str) -> DesignError:
        return DesignError(message, Place(self.file, *_where(event)))


def _where(event: Any) -> tuple[int, int]:
    return event.start_mark.line + 1, event.start_mark.column + 1


def _tag(event: Any) -> str:
    return str(event.tag).removeprefix(YAML_TAG_PREFIX) if event.tag is not None else ""
