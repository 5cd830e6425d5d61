"""popupCAD materials and layer definitions.

In: nodes of materials (thickness in mm). Out: layers from bottom to top, and materials whose placeholder
moduli are None. Used for designs and for joint definitions.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass

from lamc.readers.inert import Node
from lamc.readers.objects import MM, attribute, flag, number, object_id, optional, word
from lamc.records.design import Material

PLACEHOLDERS = [1.0, 1.0, 0.5]  # E1, E2 and poisson of a material that nobody measured


@dataclass(frozen=True)
class LayerSpec:
    """A layer before anything is drawn in it."""

    id: str
    name: str
    material: Material
    thickness: float  # m


def degrees(node: Node | None, what: str, default: float) -> float:
    """An angle in degrees as radians, ±180° as exactly ±π; `default` (degrees) where there is none."""
    return math.radians(default if node is None else number(node, what))


def read_material(node: Node, materials: Mapping[str, Material]) -> Material:
    """A popupCAD material, or the one that replaces it. Raises DesignError for values no material has."""
    name = word(attribute(node, "name", "a material"), "a material's name")
    if name in materials:
        return materials[name]
    what = f"material {name[:40]!r}"
    rigid, adhesive, conductive = (
        flag(optional(node, f"is_{kind}", what), f"is_{kind} of {what}", default=False)
        for kind in ("rigid", "adhesive", "conductive")
    )
    flexible = flag(
        optional(node, "is_flexible", what),
        f"is_flexible of {what}",
        default=not (rigid or adhesive or conductive),
    )
    moduli = [number(attribute(node, key, what), f"{key} of {what}") for key in ("E1", "E2", "poisson")]
    E1, E2, poisson = (None, None, None) if moduli == PLACEHOLDERS else moduli
    density = number(attribute(node, "density", what), f"the density of {what}", minimum=0.0)
    return Material(name, density, E1, E2, poisson, rigid, flexible, adhesive, conductive)


def read_layers(nodes: tuple[Node, ...], materials: Mapping[str, Material]) -> tuple[LayerSpec, ...]:
    """Layers from bottom to top, named after their materials; later ones of one name are numbered."""
    specs: list[LayerSpec] = []
    for node in nodes:
        material = read_material(node, materials)
        own = word(attribute(node, "name", "a material"), "a material's name")
        taken = {spec.name for spec in specs}
        name, count = own, 1
        while name in taken:
            count += 1
            name = f"{own}_{count}"
        thickness = number(
            attribute(node, "thickness", "a layer"), f"the thickness of layer {name[:40]!r}", above=0.0
        )
        specs.append(LayerSpec(object_id(node), name, material, thickness / MM))
    return tuple(specs)
