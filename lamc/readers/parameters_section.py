"""The `parameters:` of a native design: read, checked, and put into an order in which each needs only those before it.

In: nodes of a design's file. Out: `Parameters`, or DesignErrors with every problem and its place.
"""

import keyword
import re
from collections.abc import Container, Iterator, Mapping
from fractions import Fraction
from typing import Any

from lamc.basics.common_units import COMMON
from lamc.basics.dimensions import PLAIN, in_words
from lamc.basics.errors import DesignError, ExpressionError, Place
from lamc.basics.fields import UNIT
from lamc.readers.checking import Path, Problems, did_you_mean
from lamc.readers.nodes import ListNode, MapNode, Node, ScalarNode
from lamc.readers.parameters import SECTION, Declared, Parameters, as_float, default_formula, with_hint
from lamc.symbolic.formula import LENGTH as OF_LENGTH
from lamc.symbolic.formula import Formula, names_of
from lamc.symbolic.functions import FUNCTIONS
from lamc.symbolic.grammar import CONSTANTS

FIELDS = ("default", "min", "max", "meaning")
MOST = 1000  # of one design
LONGEST_NAME = 40
_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]*\Z")
_OF_UNITS = frozenset(unit for pair in COMMON for unit in pair) | {"s", "V", "A", "K", "W", "J", "Hz"}
_VALUE = {"type": ["number", "string"], UNIT: "of the parameter"}
JSON_SCHEMA: dict[str, Any] = {
    "additionalProperties": {
        "anyOf": [
            _VALUE,
            {
                "type": "object",
                "properties": {
                    "default": {
                        **_VALUE,
                        "description": "a number, text with a unit, or an expression in others",
                    },
                    "min": {**_VALUE, "description": "lowest value"},
                    "max": {**_VALUE, "description": "highest value"},
                    "meaning": {"type": "string", "description": "what it is, in a few words"},
                },
                "required": ["default"],
                "additionalProperties": False,
            },
        ]
    }
}


def read_parameters(node: Node, bare: str | None) -> Parameters:
    """The parameters of a design's file; bare: its unit of lengths. Raises DesignErrors with every problem."""
    section = node.get(SECTION) if isinstance(node, MapNode) else None
    if section is None:
        return Parameters(bare=bare)
    problems = Problems(node)
    if not isinstance(section, MapNode):
        problems.add((SECTION,), "a map of names and values is expected here, such as {length: 40 mm}")
        problems.raise_if_any()
        raise AssertionError
    if len(section.pairs) > MOST:
        problems.add((SECTION,), f"the design has {len(section.pairs)} parameters; at most {MOST} are taken")
        problems.raise_if_any()
    reader = _Reader(section, problems, bare)
    return reader.parameters()


class _Reader:
    """The section on its way to a record; every step adds to `problems` and goes on."""

    def __init__(self, section: MapNode, problems: Problems, bare: str | None) -> None:
        self.problems = problems
        self.bare = bare
        self.length = Parameters(bare=bare).length
        self.nodes: dict[str, Node] = {}
        self.of_names: dict[str, Place] = {}
        self.formulas: dict[str, Formula] = {}
        for key, value in section.pairs:
            if not isinstance(key, ScalarNode):
                problems.add((SECTION,), "a name of a parameter is expected here", key.place)
            elif problems.attempt((SECTION, key.text), lambda key=key: _checked_name(key)):  # type: ignore[misc]
                self.nodes[key.text] = value
                self.of_names[key.text] = key.place

    def parameters(self) -> Parameters:
        texts = {
            name: text for name, node in self.nodes.items() if (text := self._text(name, node)) is not None
        }
        order = list(self._ordered(texts))
        declared = tuple(each for name in order if (each := self._declared(name, texts[name])) is not None)
        self.problems.raise_if_any()
        return Parameters(declared, tuple(self.nodes), self.bare)

    def _text(self, name: str, node: Node) -> str | None:
        """The text of the default."""
        path: Path = (SECTION, name)
        if isinstance(node, MapNode):
            for key, _ in node.pairs:
                said = key.text if isinstance(key, ScalarNode) else ""
                if said not in FIELDS:
                    text = f"a parameter has no {said[:40]!r}; {did_you_mean(said, FIELDS)}"
                    self.problems.add(path, text, key.place)
            default = node.get("default")
            if default is None:
                self.problems.add(
                    path, "a parameter needs its default, such as {default: 0.3 mm, min: 0.1 mm}"
                )
                return None
            path, node = (*path, "default"), default
        return self._scalar(path, node)

    def _scalar(self, path: Path, node: Node) -> str | None:
        wrong = not isinstance(node, ScalarNode) or isinstance(node.value, bool) or node.value is None
        if wrong or (isinstance(node, ScalarNode) and not node.text.strip()):
            kind = {ListNode: "a list", MapNode: "a map"}.get(type(node), "no number")
            text = f"it is {kind}; write a number with its unit, such as 40 mm, or an expression"
            self.problems.add(path, text, node.place)
            return None
        assert isinstance(node, ScalarNode)
        return node.text.strip()

    def _place(self, name: str) -> Place:
        node = self.nodes[name]
        default = node.get("default") if isinstance(node, MapNode) else None
        return (default or node).place

    def _ordered(self, texts: Mapping[str, str]) -> Iterator[str]:
        """Names, each after those that it needs; those that need themselves are told, and left out."""
        needs = {name: self._needs(text, texts) for name, text in texts.items()}
        done: dict[str, bool] = {}
        for first in texts:
            chain = [first] if first not in done else []
            while chain:
                name = chain[-1]
                left = [each for each in needs[name] if each not in done]
                again = next((each for each in left if each in chain), None)
                if again is not None:
                    self._tell_cycle(chain[chain.index(again) :])
                    done.update(dict.fromkeys(chain, False))
                    break
                if left:
                    chain.append(left[0])
                    continue
                chain.pop()
                done[name] = all(done[each] for each in needs[name])
                if done[name]:
                    yield name

    def _needs(self, text: str, among: Container[str]) -> list[str]:
        try:
            return [name for name in names_of(text) if name in among]
        except ExpressionError:  # told when it is read
            return []

    def _tell_cycle(self, ring: list[str]) -> None:
        said = ", which needs ".join(repr(name) for name in [*ring[:6], ring[0]])
        text = f"{said}: a parameter cannot follow from itself; give one of them as a number"
        self.problems.add((SECTION, ring[0]), text, self._place(ring[0]))

    def _declared(self, name: str, text: str) -> Declared | None:
        """None after noting what is wrong with it."""
        place, path = self._place(name), (SECTION, name)
        try:
            known = {each: of.dimension for each, of in self.formulas.items()}
            if any(each not in known for each in self._needs(text, self.nodes)):
                return None  # what is wrong with that one is told
            self.formulas[name] = default_formula(text, known, self.length)
        except DesignError as error:
            self.problems.add(path, with_hint(error.message, text), place)
            return None
        node = self.nodes[name]
        low, high = (self._bound(node, name, key) for key in ("min", "max"))
        if low is not None and high is not None and low > high:
            self.problems.add(path, f"its min is {low:g} and its max {high:g}, in SI; the lower comes first")
        return Declared(name, text, place, self.of_names[name], (low, high), self._meaning(node, name))

    def _meaning(self, node: Node, name: str) -> str:
        meaning = node.get("meaning") if isinstance(node, MapNode) else None
        if meaning is None:
            return ""
        if not isinstance(meaning, ScalarNode):
            self.problems.add((SECTION, name, "meaning"), "a text is expected here")
            return ""
        return " ".join(meaning.text.split())

    def _bound(self, node: Node, name: str, key: str) -> float | None:
        """A bound, SI: a number with a unit, or a plain one, which counts as where a number of that kind stands."""
        bound = node.get(key) if isinstance(node, MapNode) else None
        path: Path = (SECTION, name, key)
        text = self._scalar(path, bound) if bound is not None else None
        if text is None:
            return None
        own = self.formulas[name].dimension

        def read() -> float:
            made = default_formula(text, {}, self.length)
            scale = self.length if own == OF_LENGTH and made.dimension == PLAIN else Fraction(1)
            if made.dimension not in (own, PLAIN):
                raise DesignError(f"it is {in_words(made.dimension)}, and the default {in_words(own)}")
            return as_float(made.value({}) * scale, "it")

        return self.problems.attempt(path, read)


def _checked_name(key: ScalarNode) -> bool:
    """Raises DesignError for a name that no parameter can have."""
    name = key.text
    if _NAME.match(name) is None or len(name) > LONGEST_NAME:
        raise key.error(
            f"a parameter is named {name[:60]!r}; a name is of letters a to z, digits and _, begins with a letter, and "
            f"has at most {LONGEST_NAME} characters"
        )
    kinds = {
        "a function": FUNCTIONS,
        "a constant": CONSTANTS,
        "a word of Python": keyword.kwlist,
        "a unit": _OF_UNITS,
    }
    taken = next((kind for kind, names in kinds.items() if name in names), None)
    if taken is not None:
        raise key.error(
            f"a parameter is named {name!r}, which is {taken}; choose another, such as {name + '_0'!r}"
        )
    return True
