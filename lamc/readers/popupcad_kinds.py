"""popupCAD's operations on laminates of one design: what each makes of the laminates before it.

In: the design's operations, the node of one and the results so far, by index. Out: a laminate, layer by layer in m.
Each does what popupCAD's own `operate` of that class does. Never: looks at designs inside or beside this one.
"""

from collections.abc import Mapping
from functools import partial, reduce
from typing import TYPE_CHECKING

from lamc.basics.errors import UnsupportedError
from lamc.readers import popupcad_sheets as sheets
from lamc.readers import popupcad_transforms as transforms
from lamc.readers.nodes import MapNode, Node
from lamc.readers.objects import MM, attribute, flag, items, number, object_id, optional, word
from lamc.readers.popupcad_sheets import Sheet
from lamc.readers.popupcad_sketch import shape, sketch_shapes
from lamc.readers.popupcad_transforms import Laminate, each_sheet

if TYPE_CHECKING:
    from lamc.readers.popupcad_operations import Operations

Results = Mapping[int, Laminate]

_LARGEST_RESOLUTION = 256


def drawn(design: "Operations", operation: Node, results: Results) -> Laminate:
    """SimpleSketchOp: sketches in some layers."""
    del results
    links = attribute(
        attribute(operation, "sketch_links", "the sketch operation"), "sketch", "the sketch links"
    )
    shapes = [
        g for link in items(links, "the sketch links") for _, g in sketch_shapes(design.sketch_of(link))
    ]
    sheet = sheets.sheet_of(shapes, design.account)
    empty = Sheet()
    chosen = design.layer_indices(attribute(operation, "layer_links", "the sketch operation"))
    return tuple(sheet if i in chosen else empty for i in range(len(design.layers)))


def frozen(design: "Operations", operation: Node, results: Results) -> Laminate:
    """Freeze: geometry that an operation had once, kept by layer."""
    del results
    what = "the frozen laminate"
    kept = attribute(operation, "generic", "the frozen operation")
    geometry = kept if kept.tag in ("", "map") else attribute(kept, "geoms", what)
    if not isinstance(geometry, MapNode):
        raise geometry.error("the frozen laminate is not a map from layers to shapes; the file is damaged")
    by_layer = {object_id(layer): shapes for layer, shapes in geometry.pairs}
    return tuple(
        sheets.sheet_of([shape(node) for node in items(by_layer[spec.id], "a frozen layer")], design.account)
        if spec.id in by_layer
        else Sheet()
        for spec in design.layers
    )


def buffered(design: "Operations", operation: Node, results: Results) -> Laminate:
    """BufferOperation2 and 3: all within a distance, or shrunk by it."""
    distance, segments = _distance(operation, "the buffer operation")
    parent = _parent(design, operation, results)
    return each_sheet(lambda sheet: sheets.grown(sheet, distance, segments, design.account), parent)


def cleaned(design: "Operations", operation: Node, results: Results) -> Laminate:
    """Cleanup and Cleanup2: shrunk, grown by twice as much, shrunk again; slivers go, slits close."""
    distance, segments = _distance(operation, "the cleanup")

    def clean(sheet: Sheet) -> Sheet:
        for change in (-distance, 2.0 * distance, -distance):
            sheet = sheets.grown(sheet, change, segments, design.account)
        return sheet

    return each_sheet(clean, _parent(design, operation, results))


def simplified(design: "Operations", operation: Node, results: Results) -> Laminate:
    """Simplify and Simplify2: corners left out that are within a tolerance of the rest."""
    values = _values(operation, "the simplification")
    tolerance = number(values[0], "the tolerance", minimum=0.0) / MM
    parent = _parent(design, operation, results)
    return each_sheet(lambda sheet: sheets.simplified(sheet, tolerance, design.account), parent)


def shifted(design: "Operations", operation: Node, results: Results) -> Laminate:
    """ShiftFlip2, 3 and 4: the layers' contents in other layers."""
    parent = _parent(design, operation, results)
    shift, flip = shift_and_flip(operation)
    rotate = flag(optional(operation, "rotate", "the shift"), "the mark of rotation", default=False)
    return transforms.shifted(parent, shift, flip=flip, rotate=rotate)


def shift_and_flip(operation: Node) -> tuple[int, bool]:
    """By how many layers an operation shifts, and whether it turns the stack over first. Raises DesignError."""
    shift = number(attribute(operation, "shift", "the operation"), "the shift of layers")
    if shift != int(shift):
        raise operation.error(f"layers are shifted by {shift:g}; it must be a whole number")
    flip = flag(optional(operation, "flip", "the operation"), "the mark of flipped layers", default=False)
    return int(shift), flip


def combined(design: "Operations", operation: Node, results: Results) -> Laminate:
    """LaminateOperation 1 and 2: laminates joined, or one group taken from another, layer by layer."""
    name = _function(operation, "laminate")
    first = [results[i] for i in design.linked(operation, "unary")]
    if not first:
        raise operation.error(f"the laminate operation {label(operation)} has no operand")

    def each_layer(function: str, a: Laminate, b: Laminate) -> Laminate:
        return each_sheet(lambda x, y: sheets.combined(function, x, y, design.account), a, b)

    if name in ("union", "intersection"):
        return reduce(partial(each_layer, name), first)
    second = [results[i] for i in design.linked(operation, "binary")]
    if not second:
        raise operation.error(f"the laminate operation {label(operation)} has no second operand")
    join = partial(each_layer, "union")
    return each_layer(name, reduce(join, first), reduce(join, second))


def layered(design: "Operations", operation: Node, results: Results) -> Laminate:
    """LayerOp and LayerOp2: layers of one laminate combined; the other layers are left empty, as popupCAD has it."""
    name = _function(operation, "layer")
    parent = _parent(design, operation, results)
    groups: list[list[Sheet]] = []
    of_one = name in ("union", "intersection")
    for key in ("unary_layer_links",) if of_one else ("unary_layer_links", "pair_layer_links"):
        chosen = design.layer_indices(attribute(operation, key, "the layer operation"))
        if not chosen:
            raise operation.error(f"the layer operation {label(operation)} has no layer in {key!r}")
        groups.append([parent[i] for i in sorted(chosen)])

    def combine(function: str, a: Sheet, b: Sheet) -> Sheet:
        return sheets.combined(function, a, b, design.account)

    if of_one:
        result = reduce(partial(combine, name), groups[0])
    else:
        result = combine(name, *(reduce(partial(combine, "union"), group) for group in groups))
    goal = design.layer_indices(attribute(operation, "output_layer_links", "the layer operation"))
    return tuple(result if i in goal else Sheet() for i in range(len(design.layers)))


def label(operation: Node) -> str:
    """What to call an operation in messages: the name that it was given, or its id."""
    named = optional(operation, "customname", "the operation")
    text = str(getattr(named, "text", ""))
    return repr(text[:40]) if text else f"number {object_id(operation)[:20]}"


def _parent(design: "Operations", operation: Node, results: Results) -> Laminate:
    parents = design.linked(operation, "parent")
    if len(parents) != 1:
        raise operation.error(
            f"the operation {label(operation)} ({operation.class_name}) has {len(parents)} parents; it needs one"
        )
    return results[parents[0]]


def _function(operation: Node, kind: str) -> str:
    function = attribute(operation, "function", f"the {kind} operation")
    name = word(function, f"the {kind} operation's function")
    if name not in sheets.COMBINE:
        known = ", ".join(sorted(sheets.COMBINE))
        raise UnsupportedError(
            f"the {kind} function {name[:40]!r} is unknown; known are {known}", function.place
        )
    return name


def _values(operation: Node, what: str) -> tuple[Node, ...]:
    values = items(attribute(operation, "values", what), f"the values of {what}")
    if not values:
        raise operation.error(f"{what} has no distance")
    return values


def _distance(operation: Node, what: str) -> tuple[float, int]:
    """A distance, m, and the segments of a quarter circle."""
    values = _values(operation, what)
    distance = number(values[0], f"the distance of {what}") / MM
    segments = number(values[1], f"the resolution of {what}") if len(values) > 1 else 5.0
    if segments > _LARGEST_RESOLUTION:
        raise values[1].error(f"the resolution of {what} is {segments:g}, above {_LARGEST_RESOLUTION}")
    return distance, max(1, int(segments))
