"""popupCAD designs (`.cad`): from inert nodes to the `Design` record.

In: nodes of a design file, lengths in mm, angles in degrees. Out: the Design that its joint operation
describes: the laminate before splitting, the fixed region, hinge sets, contact points. Stored code is refused wherever
it stands.
"""

from collections.abc import Mapping
from functools import partial, reduce
from pathlib import PurePath

import shapely

from lamc.basics.errors import DesignError
from lamc.readers.inert import MapNode, Node
from lamc.readers.objects import MM, attribute, items, number, optional, refuse_stored_code
from lamc.readers.popupcad_beside import Beside
from lamc.readers.popupcad_layers import degrees
from lamc.readers.popupcad_operations import Operations
from lamc.readers.popupcad_sheets import Sheet, combined
from lamc.readers.popupcad_sketch import hinge_lines, sketch_shapes
from lamc.readers.popupcad_transforms import Laminate, each_sheet
from lamc.records.design import Design, HingeSet, Layer, Material, Places

JOINT_OPERATIONS = ("JointOperation3", "JointOperation2")


def is_design(node: Node) -> bool:
    """True if the file's object is a popupCAD design."""
    return isinstance(node, MapNode) and node.tag.startswith("python/") and node.class_name == "Design"


def read_design(node: Node, materials: Mapping[str, Material], beside: Beside | None = None) -> Design:
    """The design in `node`; `materials` replace the file's own of the same name.

    beside  the folder in which designs that the file only names are looked for; None: there is none

    Raises DesignError where the file is damaged or impossible, UnsupportedError for stored code and for
    operations that lamc does not know.
    """
    refuse_stored_code(node)
    return _Reader(node, materials, Beside() if beside is None else beside).design()


class _Reader(Operations):
    """One popupCAD file: its layers, sketches and operations by id."""

    def design(self) -> Design:
        joint = self._joint_operation()
        parents = self.linked(joint, "parent")
        if len(parents) != 1:
            raise joint.error(f"the joint operation has {len(parents)} parent laminates; it needs one")
        held = self.linked(joint, "fixed")
        results = self.carry_out([*parents, *held])
        parent = results[parents[0]]
        empty: Laminate = (Sheet(),) * len(self.layers)
        fixed = reduce(partial(self._joined, joint), (results[index] for index in held), empty)
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
            beside=tuple(sorted(self.beside.digests.items())),
        )

    def _joined(self, joint: Node, a: Laminate, b: Laminate) -> Laminate:
        try:
            return each_sheet(lambda x, y: combined("union", x, y, self.account), a, b)
        except DesignError as error:
            raise joint.error(f"the fixed region: {error.message}") from error

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
            for _, geometry in sketch_shapes(self.sketch_of(link)):
                found |= dict.fromkeys((float(x), float(y)) for x, y in shapely.get_coordinates(geometry))
        return tuple(found)

    def _hinge_set(self, node: Node) -> HingeSet:
        what = "the joint definition"
        layer = self.layer_index(attribute(node, "joint_layer", what))
        through = self.layer_indices(attribute(node, "sublaminate_layers", what))
        limits = tuple(
            degrees(optional(node, name, what), f"the {name} of a joint", default)
            for name, default in (("limit_negative", -180.0), ("limit_positive", 180.0))
        )
        if not limits[0] < limits[1]:
            raise node.error(
                f"the joint's limits run from {limits[0]:g} to {limits[1]:g} rad; the lower comes first"
            )
        return HingeSet(
            lines=hinge_lines(self.sketch_of(attribute(node, "sketch", what)), self.account),
            width=number(attribute(node, "width", what), "the hinge width", above=0.0) / MM,
            layer=layer,
            sublaminate=tuple(sorted(through)),
            stiffness=number(attribute(node, "stiffness", what), "the stiffness", minimum=0.0),
            damping=number(attribute(node, "damping", what), "the damping", minimum=0.0),
            rest_angle=degrees(optional(node, "preload_angle", what), "the preload angle", 0.0),
            limits=(limits[0], limits[1]),
        )
