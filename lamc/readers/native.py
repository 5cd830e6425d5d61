"""Native design files, which may be made again with other values of their parameters.

In: nodes of a design file. Out: a Design that knows its `Document`, or DesignErrors with every problem of the file and
its place.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from typing import Any

from lamc.basics.errors import DesignError, Place
from lamc.basics.fields import EXPRESSIONS
from lamc.basics.units import length_unit
from lamc.readers.checking import Problems, check_tags
from lamc.readers.fields import LENGTH_UNIT
from lamc.readers.inert import MapNode, Node, ScalarNode, plain
from lamc.readers.native_drawings import Drawings
from lamc.readers.native_reader import DesignReader
from lamc.readers.native_shapes import Kept
from lamc.readers.numbers import Numbers
from lamc.readers.parameters import SECTION, Parameters
from lamc.readers.parameters_section import read_parameters
from lamc.readers.popupcad_beside import Beside
from lamc.records.design import Design
from lamc.records.parameters import DesignParameter, with_origin


def read_design(node: Node, beside: Beside | None = None) -> Design:
    """The design in `node`; beside: the folder of its drawings. Raises DesignErrors with every problem."""
    unit = length_unit_of(node)
    document = Document(node, read_parameters(node, unit), unit, Kept(Drawings(beside or Beside())))
    check_tags(node)
    design, used = document.read()
    document.check_used(used)
    return with_origin(design, document) if document.declared.declared else design


@dataclass(frozen=True, eq=False)
class Document:
    """A design's file as it was read, with values of its parameters: see `lamc.records.parameters.Recipe`.

    kept   what was read and made before
    given  SI, those that are not the defaults
    """

    node: Node
    declared: Parameters
    length_unit: str | None
    kept: Kept
    given: Mapping[str, float] = field(default_factory=dict)

    @cached_property
    def parameters(self) -> Mapping[str, DesignParameter]:
        return self.declared.records(self.declared.values(self.given))

    @property
    def listed(self) -> Mapping[str, DesignParameter]:
        return self.parameters

    @cached_property
    def _data(self) -> Any:
        return plain(self.node)

    def made(self, values: Mapping[str, float]) -> Design:
        """Raises DesignErrors, with places, for a drawing that is impossible with these values."""
        document = replace(self, given={**self.given, **values})
        document.__dict__["_data"] = self._data  # of the same nodes
        return with_origin(document.read()[0], document)

    def __getstate__(self) -> dict[str, object]:
        return {each.name: getattr(self, each.name) for each in fields(self)}

    def place(self, name: str) -> Place | None:
        return self.declared.by_name[name].place

    def read(self) -> tuple[Design, set[str]]:
        """The design, and which parameters it follows from."""
        numbers = Numbers(self.declared, self.given)
        context = {LENGTH_UNIT: self.length_unit, EXPRESSIONS: numbers}
        model = self.kept.model.model(self.node, self._data, context, numbers)
        problems = Problems(self.node)
        reader = DesignReader(model, problems, self.node.place.file, self.length_unit, numbers, self.kept)
        return reader.design(), numbers.used

    def check_used(self, used: Iterable[str]) -> None:
        """Raises DesignErrors for parameters that nothing follows from."""
        problems, needed = Problems(self.node), self.declared.needed_by(used)
        for name in self.declared.listed:
            if name not in needed:
                text = f"nothing of the design follows from {name!r}; write it into an expression, or take it away"
                problems.add((SECTION, name), text, self.declared.by_name[name].of_name)
        problems.raise_if_any()


def length_unit_of(node: Node) -> str | None:
    """The file's `units`, needed before anything else is read; None (metres) where it says nothing usable."""
    unit = node.get("units") if isinstance(node, MapNode) else None
    if not isinstance(unit, ScalarNode):
        return None
    try:
        return length_unit(unit.text)
    except DesignError:
        return None  # the schema says so, once; every length of the file need not
