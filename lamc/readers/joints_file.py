"""popupCAD joint definitions (`.joints`), both forms, read as inert data.

In: nodes of a file. Out: a Mechanism. The current form is an object of lists, lengths in metres, polygons as
WKT; the older one a tuple of four, lengths in mm, shapes keyed by material objects. Angles are degrees.
"""

import re
from pathlib import PurePath

import numpy as np
import shapely
from shapely.geometry import Polygon
from shapely.geometry.base import BaseGeometry

from lamc.basics.errors import DesignError
from lamc.design import shapes
from lamc.readers.inert import ListNode, MapNode, Node, ScalarNode
from lamc.readers.joint_definition import DefinedBody, DefinedJoint, JointDefinition, assemble, checked_pair
from lamc.readers.mechanism_as_such import JointsAsSuch
from lamc.readers.objects import MM, attribute, items, number, object_id, optional, refuse_stored_code, word
from lamc.readers.popupcad_layers import LayerSpec, degrees, read_material
from lamc.readers.popupcad_sketch import is_construction, is_text, shape, vertex
from lamc.records.design import Line
from lamc.records.mechanism import Mechanism
from lamc.records.parameters import with_origin

OLD_PROPERTIES = 6  # stiffness, damping, preload, lower limit, upper limit, z
# Only kinds that do not nest: GEOS reads nested collections by recursion, which a file could exhaust.
_WKT = re.compile(r"\s*(MULTIPOLYGON|POLYGON)\s*(Z\s*)?(\(|EMPTY)", re.IGNORECASE)


def is_joint_definition(node: Node) -> bool:
    """True if the file's object is a joint definition of either form."""
    if isinstance(node, MapNode):
        return node.tag.startswith("python/") and node.class_name == "DynamicsInfo"
    return isinstance(node, ListNode) and node.tag == "python/tuple"


def read_joints(node: Node) -> Mechanism:
    """The mechanism in `node`.

    Raises DesignError for a damaged file, TopologyError for an impossible mechanism.
    """
    try:
        definition = read_definition(node)
        return with_origin(assemble(definition), JointsAsSuch(definition))
    except DesignError as error:
        raise (type(error)(error.message, node.place) if error.place is None else error) from error


def read_definition(node: Node) -> JointDefinition:
    """What the file says, layers and lines included. Raises DesignError for a damaged file."""
    refuse_stored_code(node)
    return _read_current(node) if isinstance(node, MapNode) else _read_old(node)


def _name(node: Node) -> str:
    return PurePath(node.place.file).stem or "mechanism"


def _read_current(node: Node) -> JointDefinition:
    what = "the joint definition"
    materials = items(attribute(node, "material_properties", what), "the material properties")
    layers = tuple(_layer(m, str(i), 1.0) for i, m in enumerate(materials))
    bodies = items(attribute(node, "connected_items", what), "the connected items")
    joints = items(attribute(node, "connections", what), "the connections")
    fixed = items(attribute(node, "newtonian_ids", what), "the newtonian ids")
    return JointDefinition(
        _name(node),
        layers,
        tuple(_current_body(body, len(layers)) for body in bodies),
        tuple(_current_joint(joint) for joint in joints),
        frozenset(word(f, "a newtonian id") for f in fixed),
    )


def _layer(material: Node, key: str, unit: float) -> LayerSpec:
    made = read_material(material, {})
    thickness = number(
        attribute(material, "thickness", "a material"), f"the thickness of {made.name!r}", above=0.0
    )
    return LayerSpec(key, made.name, made, thickness / unit)


def _current_body(node: Node, count: int) -> DefinedBody:
    drawn = items(attribute(node, "layers", "a body"), "the layers of a body")
    if len(drawn) != count:
        raise node.error(
            f"a body has {len(drawn)} layers where the file has {count} materials; each needs one"
        )
    polygons = tuple(
        tuple(
            polygon
            for text in items(attribute(layer, "geoms", "a layer"), "the geometry of a layer")
            for polygon in wkt_polygons(text)
        )
        for layer in drawn
    )
    return DefinedBody(object_id(node), _given_name(node), polygons, node.place)


def _current_joint(node: Node) -> DefinedJoint:
    line, pair, properties = _parts(node, 3, "a connection (points, bodies, properties)")
    ends = _parts(line, 2, "the hinge line of a connection")
    start, end = (_point(point) for point in ends)
    ids = [word(item, "a body's id") for item in items(pair, "the bodies of a connection")]
    what = "the joint's properties"
    return DefinedJoint(
        _given_name(properties),
        _line(node, start, end),
        number(attribute(properties, "z_pos", what), "z_pos"),
        checked_pair(ids, node.place),
        number(attribute(properties, "stiffness", what), "the stiffness", minimum=0.0),
        number(attribute(properties, "damping", what), "the damping", minimum=0.0),
        degrees(optional(properties, "preload", what), "the preload", 0.0),
        (
            degrees(optional(properties, "limit_neg", what), "limit_neg", -180.0),
            degrees(optional(properties, "limit_pos", what), "limit_pos", 180.0),
        ),
        node.place,
    )


def _read_old(node: Node) -> JointDefinition:
    bodies, connections, fixed, properties = _parts(
        node, 4, "a joint definition (bodies, joints, fixed, properties)"
    )
    body_nodes = items(bodies, "the bodies")
    if not body_nodes:
        raise bodies.error("the joint definition has no bodies")
    definition = attribute(body_nodes[0], "layerdef", "a body")
    materials = items(attribute(definition, "layers", "the layer definition"), "the layers")
    layers = tuple(_layer(m, object_id(m), MM) for m in materials)
    joints, values = items(connections, "the connections"), items(properties, "the joints' properties")
    if len(joints) != len(values):
        raise properties.error(f"there are {len(joints)} connections and properties for {len(values)}")
    return JointDefinition(
        _name(node),
        layers,
        tuple(_old_body(body, layers) for body in body_nodes),
        tuple(_old_joint(joint, value) for joint, value in zip(joints, values, strict=True)),
        frozenset(object_id(body) for body in items(fixed, "the fixed bodies")),
    )


def _old_body(node: Node, layers: tuple[LayerSpec, ...]) -> DefinedBody:
    geoms = attribute(node, "geoms", "a body")
    if not isinstance(geoms, MapNode):
        raise geoms.error("the shapes of a body are not a map from material to shapes")
    by_layer: dict[str, tuple[Polygon, ...]] = {}
    for material, drawn in geoms.pairs:
        key = object_id(material)
        if key not in {layer.id for layer in layers}:
            raise material.error(f"the body has shapes in material {key[:40]!r}, which is no layer")
        found = [
            shape(item)
            for item in items(drawn, "the shapes of a layer")
            if not (is_text(item) or is_construction(item))
        ]
        by_layer[key] = by_layer.get(key, ()) + tuple(p for p in found if isinstance(p, Polygon))
    return DefinedBody(
        object_id(node), None, tuple(by_layer.get(layer.id, ()) for layer in layers), node.place
    )


def _old_joint(node: Node, values: Node) -> DefinedJoint:
    drawn, pair = _parts(node, 2, "a connection (line, bodies)")
    points = items(attribute(drawn, "exterior", "a hinge line"), "the points of a hinge line")
    if len(points) < 2:
        raise drawn.error("a hinge line has fewer than two points")
    ids = [object_id(body) for body in items(pair, "the bodies of a connection")]
    stiffness, damping, preload, lower, upper, z = _parts(values, OLD_PROPERTIES, "the properties of a joint")
    return DefinedJoint(
        None,
        _line(drawn, vertex(points[0]), vertex(points[-1])),
        number(z, "the height of a joint") / MM,
        checked_pair(ids, node.place),
        number(stiffness, "the stiffness", minimum=0.0),
        number(damping, "the damping", minimum=0.0),
        degrees(preload, "the preload", 0.0),
        (degrees(lower, "the lower limit", -180.0), degrees(upper, "the upper limit", 180.0)),
        node.place,
    )


def wkt_polygons(node: Node) -> list[Polygon]:
    """The polygons of a WKT text, m, checked. Raises DesignError for anything else."""
    text = word(node, "a shape")
    if not _WKT.match(text):
        raise node.error(f"{text[:40]!r} is not a POLYGON or MULTIPOLYGON in well-known text")
    try:
        with np.errstate(over="ignore"):  # what overflows to infinity is refused below
            geometry: BaseGeometry = shapely.force_2d(shapely.from_wkt(text))
    except (shapely.errors.ShapelyError, ValueError) as error:
        raise node.error(f"{text[:40]!r} is not well-known text: {str(error)[:120]}") from error
    try:
        return [
            shapes.polygon(list(p.exterior.coords), [list(ring.coords) for ring in p.interiors])
            for p in shapely.get_parts(geometry)
            if not p.is_empty
        ]
    except DesignError as error:
        raise node.error(error.message) from error


def _line(node: Node, start: tuple[float, float], end: tuple[float, float]) -> Line:
    try:
        return shapes.line(start, end)
    except DesignError as error:
        raise node.error(error.message) from error


def _point(node: Node) -> tuple[float, float]:
    x, y = _parts(node, 2, "a point")
    return number(x, "x"), number(y, "y")


def _parts(node: Node, count: int, what: str) -> tuple[Node, ...]:
    found = items(node, what)
    if len(found) != count:
        raise node.error(f"{what} has {len(found)} parts; it needs {count}")
    return found


def _given_name(node: Node) -> str | None:
    """The name that lamc's own writer adds; popupCAD has none."""
    found = optional(node, "name", "an entry")
    return found.text if isinstance(found, ScalarNode) else None
