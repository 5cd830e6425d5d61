"""popupCAD's operations: what each makes of sketches and of the laminates before it.

In: the nodes of one design file. Out: laminates, layer by layer in metres. Only operations that something rests on
are carried out; one that lamc does not know is refused by name. A design stored inside another is read once, however
often it is placed.
"""

from collections.abc import Callable, Mapping

from lamc.basics.errors import DesignError, UnsupportedError
from lamc.design.work import MOST_LAYERS, Account
from lamc.readers import popupcad_kinds as kinds
from lamc.readers.nodes import MapNode, Node, ScalarNode
from lamc.readers.objects import attribute, items, number, object_id, optional, word
from lamc.readers.popupcad_beside import Beside
from lamc.readers.popupcad_kinds import label
from lamc.readers.popupcad_layers import read_layers
from lamc.readers.popupcad_links import ROLES, links_of
from lamc.readers.popupcad_placing import placed
from lamc.readers.popupcad_sketch import texts_left_out
from lamc.readers.popupcad_transforms import Laminate
from lamc.records.design import Material

_MAKERS: dict[str, Callable[["Operations", Node, Mapping[int, Laminate]], Laminate]] = {
    "SimpleSketchOp": kinds.drawn,
    "Freeze": kinds.frozen,
    "BufferOperation2": kinds.buffered,
    "BufferOperation3": kinds.buffered,
    "Cleanup": kinds.cleaned,
    "Cleanup2": kinds.cleaned,
    "Simplify": kinds.simplified,
    "Simplify2": kinds.simplified,
    "LaminateOperation": kinds.combined,
    "LaminateOperation2": kinds.combined,
    "LayerOp": kinds.layered,
    "LayerOp2": kinds.layered,
    "ShiftFlip2": kinds.shifted,
    "ShiftFlip3": kinds.shifted,
    "ShiftFlip4": kinds.shifted,
    "TransformInternal": placed,
    "TransformExternal": placed,
    "PlaceOperation8": placed,
}


class Operations:
    """One popupCAD design: its layers, sketches and operations by id."""

    def __init__(
        self,
        node: Node,
        materials: Mapping[str, Material],
        beside: Beside,
        outer: "Operations | None" = None,
    ) -> None:
        self.node = node
        self.materials = materials
        self.beside = beside
        # Of all designs inside one another: each is read once, and their overlays are one file's work.
        self.readers: dict[int, Operations] = {} if outer is None else outer.readers
        self.account: Account = Account() if outer is None else outer.account
        self.results: dict[int, Laminate] = {}  # of operations, by index
        definition = optional(node, "_layerdef", "the design") or attribute(node, "layerdef", "the design")
        sheets_drawn = items(attribute(definition, "layers", "the layer definition"), "the layers")
        if len(sheets_drawn) > MOST_LAYERS:
            raise definition.error(
                f"the design has {len(sheets_drawn)} layers; at most {MOST_LAYERS} are split: join neighbours of one "
                "material"
            )
        self.layers = read_layers(sheets_drawn, materials)
        if not self.layers:
            raise definition.error("the design has no layers; add at least one")
        self.sketches = _by_key(attribute(node, "sketches", "the design"))
        self.operations = items(attribute(node, "operations", "the design"), "the operations")
        self.order = {object_id(op): i for i, op in enumerate(self.operations)}
        self.notes: dict[str, None] = {}  # each once, in the order met

    def linked(self, operation: Node, role: str) -> list[int]:
        """Indices of the operations that `operation` refers to in a role. Raises DesignError."""
        indices: list[int] = []
        for link, place in links_of(operation, role):
            target = word(link, "an operation's id")
            output = 0.0 if place is None else number(place, "an output's number")
            if target not in self.order:
                raise link.error(f"operation {label(operation)} refers to {target[:40]!r}, which is missing")
            if self.order[target] >= self.order[object_id(operation)]:
                raise link.error(f"operation {label(operation)} refers to one that comes after it")
            if output != 0:
                raise UnsupportedError(
                    f"operation {label(operation)} uses output {output:g} of another; lamc has the first",
                    link.place,
                )
            indices.append(self.order[target])
        return indices

    def carry_out(self, wanted: list[int]) -> dict[int, Laminate]:
        """Results of the wanted operations and of all that they rest on, by index."""
        needed: set[int] = set()
        stack = list(wanted)
        while stack:
            index = stack.pop()
            if index not in needed:
                needed.add(index)
                operation = self.operations[index]
                _check_known(operation)
                stack += [i for role in ROLES for i in self.linked(operation, role)]
        for index in sorted(needed - self.results.keys()):
            operation = self.operations[index]
            try:
                self.results[index] = _MAKERS[operation.class_name](self, operation, self.results)
            except DesignError as error:
                if error.place is not None:
                    raise
                raise operation.error(f"operation {label(operation)}: {error.message}") from error
        return self.results

    def inner(self, key: Node) -> "Operations":
        """The design that `key` (an id) names, stored inside this one or in a file beside it. Raises DesignError."""
        stored = optional(self.node, "subdesigns", "the design")
        found = _by_key(stored).get(word(key, "a design's id")) if stored is not None else None
        found = self.beside.design_of(key, found)
        if id(found) not in self.readers:
            self.readers[id(found)] = Operations(found, self.materials, self.beside, self)
        return self.readers[id(found)]

    def output(self, reference: Node) -> int:
        """The index of the operation that a pair of id and output names. Raises DesignError."""
        pair = items(reference, "a reference to an operation")
        key = word(pair[0], "an operation's id") if len(pair) == 2 else ""
        if key not in self.order or number(pair[1], "an output's number") != 0:
            raise reference.error("the transform names an operation that its design does not have")
        return self.order[key]

    def sketch_of(self, link: Node) -> Node:
        key = word(link, "a sketch's id")
        if key not in self.sketches:
            raise link.error(f"the design has no sketch {key[:40]!r}")
        self.notes |= dict.fromkeys(texts_left_out(self.sketches[key]))
        return self.sketches[key]

    def layer_indices(self, links: Node) -> set[int]:
        return {self.layer_index(link) for link in items(links, "the layer links")}

    def layer_index(self, link: Node) -> int:
        key = word(link, "a layer's id")
        for index, spec in enumerate(self.layers):
            if spec.id == key:
                return index
        raise link.error(f"the design has no layer with id {key[:40]!r}")


def _check_known(operation: Node) -> None:
    if operation.class_name not in _MAKERS:
        raise UnsupportedError(
            f"the joint operation rests on {label(operation)}, an operation of kind "
            f"{operation.class_name[:60]!r}, which lamc cannot carry out; replace it in popupCAD by sketch, "
            "buffer, laminate, layer, shift and transform operations",
            operation.place,
        )


def _by_key(node: Node) -> dict[str, Node]:
    if not isinstance(node, MapNode):
        raise node.error(
            "the sketches are not a map from id to sketch; the file is damaged or of another kind"
        )
    return {key.text: value for key, value in node.pairs if isinstance(key, ScalarNode)}
