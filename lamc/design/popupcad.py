"""popupCAD designs (`.cad`): from inert nodes to the `Design` record.

In: nodes of a design file, lengths in mm, angles in degrees. Out: the Design that its joint operation
describes: the laminate before splitting, the fixed region, hinge sets, contact points. Only operations on the
path to the joint operation are carried out; one that lamc does not know is refused by name. Stored code is
refused wherever it stands.
"""

from collections.abc import Mapping
from functools import reduce
from pathlib import PurePath

import shapely

from lamc.design import sheets
from lamc.design.inert import MapNode, Node, ScalarNode
from lamc.design.objects import MM, attribute, items, number, object_id, optional, refuse_stored_code, word
from lamc.design.popupcad_layers import degrees, read_layers
from lamc.design.popupcad_sketch import hinge_lines, sketch_shapes, texts_left_out
from lamc.design.records import Design, HingeSet, Layer, Material, Places
from lamc.design.sheets import Sheet
from lamc.errors import UnsupportedError

JOINT_OPERATIONS = ("JointOperation3", "JointOperation2")
_LARGEST_RESOLUTION = 256

Laminate = tuple[Sheet, ...]


def is_design(node: Node) -> bool:
    """True if the file's object is a popupCAD design."""
    return isinstance(node, MapNode) and node.tag.startswith("python/") and node.class_name == "Design"


def read_design(node: Node, materials: Mapping[str, Material]) -> Design:
    """The design in `node`; `materials` replace the file's own of the same name.

    Raises DesignError where the file is damaged or impossible, UnsupportedError for stored code and for
    operations that lamc does not know.
    """
    refuse_stored_code(node)
    return _Reader(node, materials).design()


class _Reader:
    """One popupCAD file: its layers, sketches and operations by id."""

    def __init__(self, node: Node, materials: Mapping[str, Material]) -> None:
        self.node = node
        definition = optional(node, "_layerdef", "the design") or attribute(node, "layerdef", "the design")
        sheets_drawn = items(attribute(definition, "layers", "the layer definition"), "the layers")
        self.layers = read_layers(sheets_drawn, materials)
        if not self.layers:
            raise definition.error("the design has no layers; add at least one")
        self.sketches = _by_key(attribute(node, "sketches", "the design"))
        self.operations = items(attribute(node, "operations", "the design"), "the operations")
        self.order = {object_id(op): i for i, op in enumerate(self.operations)}
        self.notes: dict[str, None] = {}  # each once, in the order met

    def design(self) -> Design:
        joint = self._joint_operation()
        parents = self._linked(joint, "parent")
        if len(parents) != 1:
            raise joint.error(f"the joint operation has {len(parents)} parent laminates; it needs one")
        held = self._linked(joint, "fixed")
        results = self._carry_out([*parents, *held])
        parent = results[parents[0]]
        empty: Laminate = (Sheet(),) * len(self.layers)
        fixed = reduce(_union, (results[index] for index in held), empty)
        layers = tuple(
            Layer(spec.name, spec.material, spec.thickness, sheet.areas)
            for spec, sheet in zip(self.layers, parent, strict=True)
        )
        definitions = items(attribute(joint, "joint_defs", "the joint operation"), "the joint definitions")
        hinges = tuple(self._hinge_set(d) for d in definitions)
        file = PurePath(self.node.place.file).name
        name = PurePath(file).stem or "design"
        world = tuple(sheet.areas for sheet in fixed)
        return Design(
            name,
            layers,
            hinges,
            world,
            source=file,
            places=Places((((), self.node.place),)),
            contact_points=self._contact_points(joint),
            notes=tuple(self.notes),
        )

    def _joint_operation(self) -> Node:
        found = [op for op in self.operations if op.class_name in JOINT_OPERATIONS]
        if len(found) != 1:
            raise self.node.error(
                f"the design has {len(found)} joint operations (JointOperation3 or 2); it needs exactly one, "
                "which says where the hinges are"
            )
        return found[0]

    def _contact_points(self, joint: Node) -> tuple[tuple[float, float], ...]:
        """Points of the joint operation's contact sketch, and corners of what else is drawn there, m; none without."""
        links = optional(joint, "sketch_links", "the joint operation")
        sketches = optional(links, "contact_points", "the joint operation's sketches") if links else None
        found: dict[tuple[float, float], None] = {}
        for link in items(sketches, "the contact sketches") if sketches is not None else ():
            for _, geometry in sketch_shapes(self._sketch(link)):
                found |= dict.fromkeys((float(x), float(y)) for x, y in shapely.get_coordinates(geometry))
        return tuple(found)

    def _linked(self, operation: Node, role: str) -> list[int]:
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

    def _carry_out(self, wanted: list[int]) -> dict[int, Laminate]:
        """Results of the wanted operations and of all that they rest on, by index."""
        needed: set[int] = set()
        stack = list(wanted)
        while stack:
            index = stack.pop()
            if index not in needed:
                needed.add(index)
                operation = self.operations[index]
                _check_known(operation)
                stack += [i for role in ("parent", "unary", "binary") for i in self._linked(operation, role)]
        results: dict[int, Laminate] = {}
        for index in sorted(needed):
            results[index] = self._operate(self.operations[index], results)
        return results

    def _operate(self, operation: Node, results: Mapping[int, Laminate]) -> Laminate:
        kind = operation.class_name
        if kind == "SimpleSketchOp":
            return self._drawn(operation)
        if kind == "BufferOperation3":
            return self._buffered(operation, results)
        return self._combined(operation, results)

    def _drawn(self, operation: Node) -> Laminate:
        links = attribute(
            attribute(operation, "sketch_links", "the sketch operation"), "sketch", "the sketch links"
        )
        drawn = [g for link in items(links, "the sketch links") for _, g in sketch_shapes(self._sketch(link))]
        sheet = sheets.sheet_of(drawn)
        chosen = self._layer_indices(attribute(operation, "layer_links", "the sketch operation"))
        return tuple(sheet if i in chosen else Sheet() for i in range(len(self.layers)))

    def _buffered(self, operation: Node, results: Mapping[int, Laminate]) -> Laminate:
        parents = self._linked(operation, "parent")
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
        first = [results[i] for i in self._linked(operation, "unary")]
        if not first:
            raise operation.error(f"the laminate operation {_label(operation)} has no operand")
        combine = sheets.COMBINE[name]

        def each_layer(a: Laminate, b: Laminate) -> Laminate:
            return tuple(combine(x, y) for x, y in zip(a, b, strict=True))

        if name in ("union", "intersection"):
            return reduce(each_layer, first)
        second = [results[i] for i in self._linked(operation, "binary")]
        if not second:
            raise operation.error(f"the laminate operation {_label(operation)} has no second operand")
        return each_layer(reduce(_union, first), reduce(_union, second))

    def _hinge_set(self, node: Node) -> HingeSet:
        what = "the joint definition"
        layer = self._layer_index(attribute(node, "joint_layer", what))
        through = self._layer_indices(attribute(node, "sublaminate_layers", what))
        limits = tuple(
            degrees(optional(node, name, what), f"the {name} of a joint", default)
            for name, default in (("limit_negative", -180.0), ("limit_positive", 180.0))
        )
        if not limits[0] < limits[1]:
            raise node.error(
                f"the joint's limits run from {limits[0]:g} to {limits[1]:g} rad; the lower comes first"
            )
        return HingeSet(
            lines=hinge_lines(self._sketch(attribute(node, "sketch", what))),
            width=number(attribute(node, "width", what), "the hinge width", above=0.0) / MM,
            layer=layer,
            sublaminate=tuple(sorted(through)),
            stiffness=number(attribute(node, "stiffness", what), "the stiffness", minimum=0.0),
            damping=number(attribute(node, "damping", what), "the damping", minimum=0.0),
            rest_angle=degrees(optional(node, "preload_angle", what), "the preload angle", 0.0),
            limits=(limits[0], limits[1]),
        )

    def _sketch(self, link: Node) -> Node:
        key = word(link, "a sketch's id")
        if key not in self.sketches:
            raise link.error(f"the design has no sketch {key[:40]!r}")
        self.notes |= dict.fromkeys(texts_left_out(self.sketches[key]))
        return self.sketches[key]

    def _layer_indices(self, links: Node) -> set[int]:
        return {self._layer_index(link) for link in items(links, "the layer links")}

    def _layer_index(self, link: Node) -> int:
        key = word(link, "a layer's id")
        for index, spec in enumerate(self.layers):
            if spec.id == key:
                return index
        raise link.error(f"the design has no layer with id {key[:40]!r}")


def _check_known(operation: Node) -> None:
    if operation.class_name not in ("SimpleSketchOp", "BufferOperation3", "LaminateOperation2"):
        raise UnsupportedError(
            f"the joint operation rests on {_label(operation)}, an operation of kind "
            f"{operation.class_name[:60]!r}, which lamc cannot carry out; replace it in popupCAD by sketch, "
            "buffer and laminate operations",
            operation.place,
        )


def _union(a: Laminate, b: Laminate) -> Laminate:
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
