"""Validation of a file against a schema, with all problems at once and the place of each.

In: nodes (from `inert`) and a pydantic model. Out: the validated model, or DesignErrors whose every line
reads `file:line:column: path: message`. It knows no particular schema.
"""

from collections.abc import Callable, Iterator, Mapping
from pathlib import Path as FilePath
from typing import Any, TypeVar, get_args

from pydantic import BaseModel, ValidationError

from lamc.basics.checks import did_you_mean as did_you_mean
from lamc.basics.errors import DesignError, DesignErrors, LamcError, Place
from lamc.basics.fields import problem_text
from lamc.readers.inert import STANDARD_TAGS, ListNode, MapNode, Node, ScalarNode, plain

Path = tuple[str | int, ...]
CHOICE = (
    "one of: "  # begins the name of a part of a union, which pydantic puts into places and a file has not
)
QUOTE = 'in a list, quote an expression with a comma: ["max(a, b)", 0]'
T = TypeVar("T")
M = TypeVar("M", bound=BaseModel)

_SHOWN_PROBLEMS = 50
_NUMERIC = tuple("+-.0123456789")  # what a number begins with


class Problems:
    """Collects the problems of one file, so that a reader can go on after the first."""

    def __init__(self, root: Node) -> None:
        self._root = root
        self._found: list[DesignError] = []

    @property
    def none(self) -> bool:
        return not self._found

    @property
    def folder(self) -> FilePath | None:
        """Where the file lies, from which it counts the names of other files; None for text that has no file."""
        file = self._root.place.file
        return FilePath(file).parent if file else None

    def place(self, path: Path) -> Place:
        """The place of what stands at `path`, or of the nearest thing around it."""
        return node_at(self._root, path).place

    def places(self, path: Path) -> Mapping[str, Place]:
        """The places of the values of the map at `path`, by key; empty where no map is."""
        node = node_at(self._root, path)
        pairs = node.pairs if isinstance(node, MapNode) else ()
        return {key.text: value.place for key, value in pairs if isinstance(key, ScalarNode)}

    def words(self, path: Path) -> Mapping[str, Place]:
        """The places of all single keys and values within what stands at `path`, of each the first; not of numbers, of
        which there may be thousands."""
        found: dict[str, Place] = {}
        left: list[Node] = [node_at(self._root, path)]
        while left:
            node = left.pop()
            if isinstance(node, ScalarNode):
                if not node.plain or node.text[:1] not in _NUMERIC:
                    found.setdefault(node.text, node.place)
            elif isinstance(node, ListNode):
                left += reversed(node.items)
            else:
                left += [each for pair in reversed(node.pairs) for each in reversed(pair)]
        return found

    def text(self, path: Path) -> str:
        """What is written at `path`; empty where no single value is. Looks through the map that it is in."""
        node = node_at(self._root, path)
        return node.text if isinstance(node, ScalarNode) else ""

    def texts(self, path: Path) -> Mapping[str, str]:
        """What is written in the map at `path`, by key; what is no single value is left out."""
        node = node_at(self._root, path)
        pairs = node.pairs if isinstance(node, MapNode) else ()
        scalars = ((k, v) for k, v in pairs if isinstance(k, ScalarNode) and isinstance(v, ScalarNode))
        return {key.text: value.text for key, value in scalars}

    def add(self, path: Path, message: str, place: Place | None = None) -> None:
        self._found.append(DesignError(f"{shown(path)}: {message}", place or self.place(path)))

    def attempt(self, path: Path, make: Callable[[], T]) -> T | None:
        """What `make` returns, or None after noting the DesignError that it raised."""
        try:
            return make()
        except DesignErrors as errors:
            self._found += errors.problems
        except DesignError as error:
            if error.place is not None:
                self._found.append(error)
            else:
                at = self._within(path, error.part)
                self._found.append(type(error)(f"{shown(at)}: {error.message}", self.place(at)))
        return None

    def _within(self, path: Path, part: Path) -> Path:
        """`path`, and further by the keys of `part` that are written there: a shorthand leaves some out."""
        for key in part:
            if str(key) in self.places(path):
                path = (*path, key)
        return path

    def raise_if_any(self) -> None:
        """Raises DesignErrors with what was found, ordered by place; nothing where all is well."""
        found = sorted(self._found, key=lambda e: e.place or Place())
        if len(found) > _SHOWN_PROBLEMS:
            more = DesignError(f"… and {len(found) - _SHOWN_PROBLEMS} problems more", found[-1].place)
            found = [*found[:_SHOWN_PROBLEMS], more]
        if found:
            raise DesignErrors(found)


def validate(model: type[M], node: Node, context: Mapping[str, Any] | None = None) -> M:
    """`node` as `model`. Raises DesignErrors with every problem."""
    check_tags(node)
    return validated(model, node, plain(node), context)


def check_tags(node: Node) -> None:
    """Raises DesignErrors for tags that mean nothing in lamc's own files, and for what is no map."""
    problems = Problems(node)
    for tagged in _tagged(node):
        problems.add(
            (), f"the tag !{tagged.tag.lstrip('!')[:60]} has no meaning here; remove it", tagged.place
        )
    problems.raise_if_any()
    if not isinstance(node, MapNode):
        raise node.error(f"a {_kind(node)} stands where a map of keys and values is expected")


def validated(model: type[M], node: Node, data: Any, context: Mapping[str, Any] | None = None) -> M:
    """`data`, which `node` holds, as `model`. Raises DesignErrors with every problem."""
    problems = Problems(node)
    try:
        return model.model_validate(data, context=dict(context or {}))
    except ValidationError as error:
        for item in error.errors(include_url=False):
            path: Path = tuple(step for step in item["loc"] if not str(step).startswith(CHOICE))
            problems.add(path, _message(model, path, item), _place_of(node, path, item["type"]))
    problems.raise_if_any()
    raise LamcError("a validation failed without a problem")


def node_at(root: Node, path: Path) -> Node:
    """The node at `path`, or the innermost one on the way there."""
    node = root
    for step in path:
        following = None
        if isinstance(node, MapNode):
            following = node.get(str(step))
        elif isinstance(node, ListNode) and isinstance(step, int) and step < len(node.items):
            following = node.items[step]
        if following is None:
            break
        node = following
    return node


def shown(path: Path) -> str:
    """`("layers", 0, "name")` as `layers[0].name`."""
    text = ""
    for step in path:
        text += f"[{step}]" if isinstance(step, int) else f".{step}" if text else str(step)
    return text or "the file"


def _tagged(node: Node) -> Iterator[Node]:
    """Nodes with a tag that a hand-written file has no use for; shared nodes are looked at once."""
    seen: set[int] = set()
    stack = [node]
    while stack:
        item = stack.pop()
        if id(item) in seen:
            continue
        seen.add(id(item))
        if item.tag not in STANDARD_TAGS:
            yield item
        if isinstance(item, ListNode):
            stack.extend(reversed(item.items))
        elif isinstance(item, MapNode):
            stack.extend(n for pair in reversed(item.pairs) for n in reversed(pair))


def _place_of(root: Node, path: Path, kind: str) -> Place:
    """An unknown key is marked at the key, everything else at the value."""
    if kind == "extra_forbidden":
        parent = node_at(root, path[:-1])
        if isinstance(parent, MapNode):
            for key, _ in parent.pairs:
                if isinstance(key, ScalarNode) and key.text == path[-1]:
                    return key.place
    return node_at(root, path).place


def _message(model: type[BaseModel], path: Path, item: Any) -> str:
    kind = item["type"]
    if kind == "extra_forbidden":
        known = sorted(_fields_at(model, path[:-1]))
        return f"the key {str(path[-1])[:40]!r} is unknown; {did_you_mean(str(path[-1]), known)}"
    if kind == "missing" and isinstance(path[-1], int):
        return "a value is missing here"
    if kind == "missing":
        return "this key is missing, and it is required"
    text = problem_text(item)
    if kind == "too_long" and any(isinstance(each, str) and "(" in each for each in item["input"]):
        return f"{text}; {QUOTE}"  # an expression that YAML took apart
    return text


def _fields_at(model: type[BaseModel], path: Path) -> list[str]:
    """Names of the keys allowed at `path`."""
    current: type[BaseModel] | None = model
    for step in path:
        if current is None or isinstance(step, int):
            continue
        field = next((f for n, f in current.model_fields.items() if step in (n, f.alias)), None)
        current = _model_in(field.annotation) if field is not None else current
    return [f.alias or n for n, f in current.model_fields.items()] if current is not None else []


def _model_in(annotation: Any) -> type[BaseModel] | None:
    """The model that an annotation such as `list[Layer] | None` speaks of."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return annotation
    return next((found for found in map(_model_in, get_args(annotation)) if found is not None), None)


def _kind(node: Node) -> str:
    return {ListNode: "list", MapNode: "map"}.get(type(node), "single value")
