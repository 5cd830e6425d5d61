"""A design's file with other values of its parameters: only what follows from those that changed is validated again.

In: the plain data of one file, numbers of its expressions. Out: the model that validating all of it gives. Never: tells
what is wrong; where an entry does not validate, all are validated as ever, so that every problem is told, and in order.

An entry follows from a parameter at most where some text in it holds its name, as a part of a word or in whole.
"""

from collections.abc import Iterator, Mapping
from functools import cache
from typing import Any, get_args

from pydantic import TypeAdapter, ValidationError

from lamc.readers.checking import validated
from lamc.readers.nodes import Node
from lamc.readers.numbers import Numbers
from lamc.readers.parameters import SECTION
from lamc.readers.schema import DesignModel
from lamc.symbolic.formula import Number

ENTRIES = (
    "materials",
    "layers",
    "shapes",
    "hinges",
    "fixed",
    "bodies",
)  # sections that are taken entry by entry
MOST = 1_000_000  # names looked for in texts

Entry = tuple[str, Any]  # a section, and what stands where in it; None: the section as a whole


class KeptModel:
    """The model of a file as it was validated last, with the values of that time."""

    def __init__(self) -> None:
        self._last: tuple[Mapping[str, Number], DesignModel] | None = None
        self._names: Mapping[Entry, frozenset[str]] | None = None

    def model(self, node: Node, data: Any, context: Mapping[str, Any], numbers: Numbers) -> DesignModel:
        """The model of `data`, which `node` holds. Raises DesignErrors with every problem."""
        found = self._made_again(data, context, numbers) if self._last is not None else None
        if found is None:
            found = validated(DesignModel, node, data, context)
        self._last = numbers.values, found
        return found

    def _made_again(self, data: Any, context: Mapping[str, Any], numbers: Numbers) -> DesignModel | None:
        """The last model with what changed; None where more than entries did, or one is wrong."""
        assert self._last is not None
        values, model = self._last
        changed = {name for name, value in numbers.values.items() if value != values[name]}
        if self._names is None:
            self._names = _names(data, list(numbers.values))
        again = [entry for entry, names in self._names.items() if not names.isdisjoint(changed)]
        sections: dict[str, Any] = {}
        for section, key in again:
            if key is None:
                return None
            if section not in sections:
                sections[section] = getattr(model, section).copy()
            try:
                made = _adapter(section).validate_python(data[section][key], context=dict(context))
            except ValidationError:
                return None
            sections[section][key] = made
        return model.model_copy(update=sections) if sections else model


@cache
def _adapter(section: str) -> TypeAdapter[Any]:
    """What validates one entry of a section: of a list, or of a map by name."""
    return TypeAdapter(get_args(DesignModel.model_fields[section].annotation)[-1])


def _names(data: Mapping[str, Any], names: list[str]) -> dict[Entry, frozenset[str]]:
    """Parameters that entries may follow from, of those that may at all."""
    found: dict[Entry, frozenset[str]] = {}
    known: dict[str, frozenset[str]] = {}
    for section, said in data.items():
        if section == SECTION:  # it does not follow from them; what others see of it are values
            continue
        entries: list[tuple[Any, Any]] = [(None, said)]
        if section in ENTRIES:
            entries = list(said.items()) if isinstance(said, dict) else list(enumerate(said))
        for key, entry in entries:
            held: set[str] = set()
            for text in _texts(entry):
                if text not in known:
                    few = (len(known) + 1) * len(names) <= MOST
                    known[text] = frozenset(name for name in names if not few or name in text)
                held |= known[text]
            if held:
                found[section, key] = frozenset(held)
    return found


def _texts(value: Any) -> Iterator[str]:
    """All texts within plain data, keys too."""
    stack = [value]
    while stack:
        item = stack.pop()
        if isinstance(item, str):
            yield item
        elif isinstance(item, dict):
            stack += [*item, *item.values()]
        elif isinstance(item, list):
            stack += item
