"""popupCAD's operations: what each makes of sketches and of the laminates before it.

In: the nodes of one design file. Out: laminates, layer by layer in metres. Only operations that something rests on
are carried out; one that lamc does not know is refused by name. A design stored inside another is read once, however
often it is placed.
"""

from collections.abc import Mapping
from functools import reduce

import shapely
from shapely.geometry import LineString

from lamc.design import popupcad_transforms as transforms
from lamc.design import sheets
from lamc.design.inert import MapNode, Node, ScalarNode
from lamc.design.objects import MM, attribute, flag, items, number, object_id, optional, word
from lamc.design.popupcad_layers import read_layers
from lamc.design.popupcad_sketch import kind_of, sketch_shapes, texts_left_out
from lamc.design.popupcad_transforms import Laminate
from lamc.design.records import Material
from lamc.design.sheets import Sheet
from lamc.errors import DesignError, UnsupportedError

_KNOWN = (
    "SimpleSketchOp",
    "BufferOperation3",
    "LaminateOperation2",
    "ShiftFlip3",
    "TransformInternal",
    "TransformExternal",
    "PlaceOperation8",
)
_LARGEST_RESOLUTION = 256


class Operations:
    """One popupCAD design: its layers, sketches and operations by id."""

    def __init__(
        self, node: Node, materials: Mapping[str, Material], readers: "dict[int, Operations] | None" = None
    ) -> None:
        self.node = node
        self.materials = materials
        self.readers = {} if readers is None else readers  # of designs inside this one, each read once
        self.results: dict[int, Laminate] = {}  # of operations, by index
        definition = optional(node, "_layerdef", "the design") or attribute(node, "layerdef", "the design")
        sheets_drawn = items(attribute(definition, "layers", "the layer definition"), "the layers")
        self.layers = read_layers(sheets_drawn, materials)
        if not self.layers:
            raise definition.error("the design has no layers; add at least one")
        self.sketches = _by_key(attribute(node, "sketches", "the design"))
        self.operations = items(attribute(node, "operations", "the design"), "the operations")
        self.order = {object_id(op): i for i, op in enumerate(self.operations)}
        self.notes: dict[str, None] = {}  # each once, in the order met

    def linked(self, operation: Node, role: str) -> list[int]:
        """Indices of the operations that `operation` refers to in a role. Raises DesignError."""
        links = optional(
            attribute(operation, "operation_links", "an operation"), role, "the operation's links"
        )
        indices: list[int] = []
        for link in items(links, "the operation's links") if links is not None else ():
            pair = items(link, "a link to an operation")
            if len(pair) != 2:
                raise link.error("a link to an operation is not a pair of id and output")
            target, output = word(pair[0], "an operation's id"), number(pair[1], "an output's number")
            if target not in self.order:
                raise link.error(f"operation {_label(operation)} refers to {target[:40]!r}, which is missing")
            if self.order[target] >= self.order[object_id(operation)]:
                raise link.error(f"operation {_label(operation)} refers to one that comes after it")
            if output != 0:
                raise UnsupportedError(
                    f"operation {_label(operation)} uses output {output:g} of another; lamc has the first",
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
                stack += [
                    i for role in ("parent", "unary", "binary", "from") for i in self.linked(operation, role)
                ]
        for index in sorted(needed - self.results.keys()):
            self.results[index] = self._operate(self.operations[index], self.results)
        return self.results

    def _operate(self, operation: Node, results: Mapping[int, Laminate]) -> Laminate:
        kind = operation.class_name
        if kind == "SimpleSketchOp":
            return self._drawn(operation)
        if kind == "BufferOperation3":
            return self._buffered(operation, results)
        if kind == "LaminateOperation2":
            return self._combined(operation, results)
        if kind == "ShiftFlip3":
            return self._shifted(operation, results)
        return self._placed(operation, results)

    def _shifted(self, operation: Node, results: Mapping[int, Laminate]) -> Laminate:
        parents = self.linked(operation, "parent")
        if len(parents) != 1:
            raise operation.error(f"the shift {_label(operation)} has {len(parents)} parents; it needs one")
        shift, flip = self._shift_and_flip(operation)
        rotate = flag(optional(operation, "rotate", "the shift"), "the mark of rotation", default=False)
        return transforms.shifted(results[parents[0]], shift, flip=flip, rotate=rotate)

    def _shift_and_flip(self, operation: Node) -> tuple[int, bool]:
        shift = number(attribute(operation, "shift", "the operation"), "the shift of layers")
        if shift != int(shift):
            raise operation.error(f"layers are shifted by {shift:g}; it must be a whole number")
        flip = flag(optional(operation, "flip", "the operation"), "the mark of flipped layers", default=False)
        return int(shift), flip

    def _placed(self, operation: Node, results: Mapping[int, Laminate]) -> Laminate:
        """TransformInternal, TransformExternal or PlaceOperation8: a laminate at each line of a sketch."""
        kind = operation.class_name
        links = attribute(operation, "sketch_links", "the transform")
        if kind == "TransformInternal":
            source, reader = self.linked(operation, "from"), self
            line = self._first_line(self._one(links, "sketch_from"))
        else:
            reader = self._inner(operation)
            source = [reader._output(attribute(operation, "subopref", "the transform"))]
            if kind == "TransformExternal":
                line = reader._first_line(attribute(operation, "sub_sketch_id", "the transform"))
            else:
                line = reader._locate_line()
            results = reader.carry_out(source)
            self.notes |= reader.notes
        if len(source) != 1:
            raise operation.error(
                f"the transform {_label(operation)} has {len(source)} sources; it needs one"
            )
        ends = self._lines(self._one(links, "place" if kind == "PlaceOperation8" else "sketch_to"))
        shift, flip = self._shift_and_flip(operation)
        how = transforms.Placing(shift, flip, self._scale(operation, "x"), self._scale(operation, "y"))
        try:
            return transforms.placed(results[source[0]], len(self.layers), line, ends, how)
        except DesignError as error:
            raise operation.error(error.message) from error

    def _scale(self, operation: Node, axis: str) -> float | None:
        kind = word(attribute(operation, f"transformtype_{axis}", "the transform"), "a kind of scale")
        if kind == "scale":
            return None
        if kind != "custom":
            raise operation.error(f"the scale of {axis} is {kind[:40]!r}; it is 'scale' or 'custom'")
        scale = number(attribute(operation, f"scale{axis}", "the transform"), f"the scale of {axis}")
        if scale == 0.0:
            raise operation.error(f"the scale of {axis} is 0; it leaves nothing")
        return scale

    def _one(self, links: Node, role: str) -> Node:
        """The first id of a role among links."""
        found = items(attribute(links, role, "the links"), "the links")
        if not found:
            raise links.error(f"the links have nothing under {role!r}")
        return found[0]

    def _inner(self, operation: Node) -> "Operations":
        """The design stored inside this one that an operation takes its laminate from."""
        link = self._one(attribute(operation, "design_links", "the transform"), "subdesign")
        key = word(link, "a design's id")
        stored = optional(self.node, "subdesigns", "the design")
        found = _by_key(stored).get(key) if stored is not None else None
        if found is None:
            raise link.error(f"no design {key[:40]!r} is stored inside this one; save it in popupCAD again")
        if id(found) not in self.readers:
            self.readers[id(found)] = Operations(found, self.materials, self.readers)
        return self.readers[id(found)]

    def _output(self, reference: Node) -> int:
        """The index of the operation that a pair of id and output names."""
        pair = items(reference, "a reference to an operation")
        key = word(pair[0], "an operation's id") if len(pair) == 2 else ""
        if key not in self.order or number(pair[1], "an output's number") != 0:
            raise reference.error("the transform names an operation that its design does not have")
        return self.order[key]

    def _lines(self, link: Node) -> list[transforms.Line]:
        """The first two points of each shape of a sketch."""
        found = []
        for node, geometry in sketch_shapes(self.sketch_of(link)):
            points = shapely.get_coordinates(geometry)
            if not isinstance(geometry, LineString):
                raise node.error(f"a laminate is placed by lines, and this is a {kind_of(node)}; draw a line")
            found.append(
                ((float(points[0][0]), float(points[0][1])), (float(points[1][0]), float(points[1][1])))
            )
        return found

    def _first_line(self, link: Node) -> transforms.Line:
        lines = self._lines(link)
        if not lines:
            raise link.error("the sketch by which a laminate is placed has no line; draw one")
        return lines[0]

    def _locate_line(self) -> transforms.Line:
        """The line that the last locate operation of a design names."""
        for operation in reversed(self.operations):
            if operation.class_name.startswith("LocateOperation"):
                links = attribute(operation, "sketch_links", "the locate operation")
                return self._first_line(self._one(links, "sketch"))
        raise self.node.error("a design that is placed has no locate operation, which says by what line")

    def _drawn(self, operation: Node) -> Laminate:
        links = attribute(
            attribute(operation, "sketch_links", "the sketch operation"), "sketch", "the sketch links"
        )
        drawn = [
            g for link in items(links, "the sketch links") for _, g in sketch_shapes(self.sketch_of(link))
        ]
        sheet = sheets.sheet_of(drawn)
        chosen = self.layer_indices(attribute(operation, "layer_links", "the sketch operation"))
        return tuple(sheet if i in chosen else Sheet() for i in range(len(self.layers)))

    def _buffered(self, operation: Node, results: Mapping[int, Laminate]) -> Laminate:
        parents = self.linked(operation, "parent")
        if len(parents) != 1:
            raise operation.error(
                f"the buffer operation {_label(operation)} has {len(parents)} parents; it needs one"
            )
        values = items(attribute(operation, "values", "the buffer operation"), "the buffer's values")
        if not values:
            raise operation.error("the buffer operation has no distance")
        distance = number(values[0], "the buffer's distance") / MM
        segments = number(values[1], "the buffer's resolution") if len(values) > 1 else 5.0
        if segments > _LARGEST_RESOLUTION:
            raise values[1].error(f"the buffer's resolution is {segments:g}, above {_LARGEST_RESOLUTION}")
        return tuple(sheets.grown(s, distance, max(1, int(segments))) for s in results[parents[0]])

    def _combined(self, operation: Node, results: Mapping[int, Laminate]) -> Laminate:
        function = attribute(operation, "function", "the laminate operation")
        name = word(function, "the laminate operation's function")
        if name not in sheets.COMBINE:
            known = ", ".join(sorted(sheets.COMBINE))
            raise UnsupportedError(
                f"the laminate function {name[:40]!r} is unknown; known are {known}", function.place
            )
        first = [results[i] for i in self.linked(operation, "unary")]
        if not first:
            raise operation.error(f"the laminate operation {_label(operation)} has no operand")
        combine = sheets.COMBINE[name]

        def each_layer(a: Laminate, b: Laminate) -> Laminate:
            return tuple(combine(x, y) for x, y in zip(a, b, strict=True))

        if name in ("union", "intersection"):
            return reduce(each_layer, first)
        second = [results[i] for i in self.linked(operation, "binary")]
        if not second:
            raise operation.error(f"the laminate operation {_label(operation)} has no second operand")
        return each_layer(reduce(union_of, first), reduce(union_of, second))

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
    if operation.class_name not in _KNOWN:
        raise UnsupportedError(
            f"the joint operation rests on {_label(operation)}, an operation of kind "
            f"{operation.class_name[:60]!r}, which lamc cannot carry out; replace it in popupCAD by sketch, "
            "buffer, laminate, shift and transform operations",
            operation.place,
        )


def union_of(a: Laminate, b: Laminate) -> Laminate:
    return tuple(sheets.union(x, y) for x, y in zip(a, b, strict=True))


def _by_key(node: Node) -> dict[str, Node]:
    if not isinstance(node, MapNode):
        raise node.error(
            "the sketches are not a map from id to sketch; the file is damaged or of another kind"
        )
    return {key.text: value for key, value in node.pairs if isinstance(key, ScalarNode)}


def _label(operation: Node) -> str:
    named = optional(operation, "customname", "the operation")
    text = named.text if isinstance(named, ScalarNode) else ""
    return repr(text[:40]) if text else f"number {object_id(operation)[:20]}"
