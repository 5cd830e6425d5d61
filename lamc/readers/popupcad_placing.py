"""popupCAD's transforms: a laminate of this design, or of one inside or beside it, placed by lines.

In: the design's operations, the node of one and the results so far, by index. Out: a laminate in this design's stack.
"""

from collections.abc import Mapping
from typing import TYPE_CHECKING

import shapely
from shapely.geometry import LineString

from lamc.basics.errors import DesignError
from lamc.readers import popupcad_transforms as transforms
from lamc.readers.nodes import Node
from lamc.readers.objects import attribute, items, number, word
from lamc.readers.popupcad_kinds import label, shift_and_flip
from lamc.readers.popupcad_sketch import kind_of, sketch_shapes
from lamc.readers.popupcad_transforms import Laminate

if TYPE_CHECKING:
    from lamc.readers.popupcad_operations import Operations


def placed(design: "Operations", operation: Node, results: Mapping[int, Laminate]) -> Laminate:
    """TransformInternal, TransformExternal or PlaceOperation8: a laminate at each line of a sketch."""
    kind = operation.class_name
    links = attribute(operation, "sketch_links", "the transform")
    if kind == "TransformInternal":
        source = design.linked(operation, "from")
        if len(source) != 1:
            raise operation.error(f"the transform {label(operation)} has {len(source)} sources; it needs one")
        laminate = results[source[0]]
        line = _first_line(design, _one(links, "sketch_from"))
    else:
        laminate, line = _of_another(design, operation)
    ends = _lines(design, _one(links, "place" if kind == "PlaceOperation8" else "sketch_to"))
    shift, flip = shift_and_flip(operation)
    how = transforms.Placing(shift, flip, _scale(operation, "x"), _scale(operation, "y"))
    try:
        return transforms.placed(laminate, len(design.layers), line, ends, how, design.account)
    except DesignError as error:
        raise operation.error(error.message) from error


def _of_another(design: "Operations", operation: Node) -> tuple[Laminate, transforms.Line]:
    """The laminate of another design, and its line that comes to lie on this one's lines."""
    link = _one(attribute(operation, "design_links", "the transform"), "subdesign")
    reader = design.inner(link)
    with design.beside.entered(reader.node, link):
        source = reader.output(attribute(operation, "subopref", "the transform"))
        laminate = reader.carry_out([source])[source]
        if operation.class_name == "TransformExternal":
            line = _first_line(reader, attribute(operation, "sub_sketch_id", "the transform"))
        else:
            line = _locate_line(reader)
    design.notes |= reader.notes
    return laminate, line


def _scale(operation: Node, axis: str) -> float | None:
    kind = word(attribute(operation, f"transformtype_{axis}", "the transform"), "a kind of scale")
    if kind == "scale":
        return None
    if kind != "custom":
        raise operation.error(f"the scale of {axis} is {kind[:40]!r}; it is 'scale' or 'custom'")
    scale = number(attribute(operation, f"scale{axis}", "the transform"), f"the scale of {axis}")
    if scale == 0.0:
        raise operation.error(f"the scale of {axis} is 0; it leaves nothing")
    return scale


def _one(links: Node, role: str) -> Node:
    """The first id of a role among links."""
    found = items(attribute(links, role, "the links"), "the links")
    if not found:
        raise links.error(f"the links have nothing under {role!r}")
    return found[0]


def _lines(design: "Operations", link: Node) -> list[transforms.Line]:
    """The first two points of each shape of a sketch."""
    found = []
    for node, geometry in sketch_shapes(design.sketch_of(link)):
        points = shapely.get_coordinates(geometry)
        if not isinstance(geometry, LineString):
            raise node.error(f"a laminate is placed by lines, and this is a {kind_of(node)}; draw a line")
        found.append(((float(points[0][0]), float(points[0][1])), (float(points[1][0]), float(points[1][1]))))
    return found


def _first_line(design: "Operations", link: Node) -> transforms.Line:
    lines = _lines(design, link)
    if not lines:
        raise link.error("the sketch by which a laminate is placed has no line; draw one")
    return lines[0]


def _locate_line(design: "Operations") -> transforms.Line:
    """The line that the last locate operation of a design names."""
    for operation in reversed(design.operations):
        if operation.class_name.startswith("LocateOperation"):
            links = attribute(operation, "sketch_links", "the locate operation")
            return _first_line(design, _one(links, "sketch"))
    raise design.node.error("a design that is placed has no locate operation, which says by what line")
