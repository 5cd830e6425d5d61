"""Hinge stiffness of a design from what it is made of.

In: a design. Out: the same with the stiffness of every hinge computed from its flexible layer, and an account of each.
Never: changes anything else; a stiffness in the file is replaced, not mixed.

The strip that bends is the hinge line grown to either side by half the gap; it is as long as the line is within the
flexible layer and outside the holes that are cut where lines meet.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
import shapely
from shapely.geometry import LineString

from lamc.basics.errors import DesignError
from lamc.design.contact import free_parts
from lamc.design.cutting import holes_per_layer
from lamc.design.split import named_hinges
from lamc.design.steps import Hinge
from lamc.plates.answers.hinge_stiffness import FilmStiffness, hinge_stiffness
from lamc.plates.designs.materials import plate_materials, ply_angle
from lamc.plates.laminates.laminate import Laminate
from lamc.plates.laminates.materials import Material
from lamc.plates.laminates.plies import Ply
from lamc.records.design import Design, HingeLine, HingeSet

_REACH = 10.0  # hinge widths to either side within which stiff layers are looked for
_SLENDER = 5.0  # widths over thickness from which a strip is a plate
_SAME = 0.1  # part of the strip's width by which the drawn opening may differ without a note


@dataclass(frozen=True)
class MaterialHinge:
    """Where the stiffness of a joint comes from.

    note  what the drawing has that this leaves out; "" for nothing
    """

    joint: str
    layer: str
    material: Material
    angle: float | None  # degrees, from the direction across the hinge line to the fibres; None: isotropic
    thickness: float  # m
    stiffness: FilmStiffness
    note: str


@dataclass(frozen=True, eq=False)
class FlexibleStrip:
    """What bends at a hinge line: its flexible layer, as far as it is there.

    laminate  axis x across the line; a single ply
    angle     degrees, from x to the fibres
    width     m, from link to link
    parts     stretches of the line, m, world x and y
    """

    material: Material
    laminate: Laminate
    angle: float
    width: float
    parts: tuple[LineString, ...]

    @property
    def length(self) -> float:
        """m, of all parts."""
        return float(sum(part.length for part in self.parts))


def with_material_stiffness(
    design: Design,
    materials: Mapping[str, Material] | None = None,
    *,
    cells: int = 0,
    only_asked: bool = False,
) -> tuple[Design, tuple[MaterialHinge, ...]]:
    """The design with every hinge's stiffness from its material, and the account, in the order of the joints.

    materials  replace the design's own of the same name
    cells      across each strip for finite elements, which stand beside the formulas; 0: none
    only_asked of hinges that are `from_material`; others keep their stiffness

    Raises DesignError for a flexible layer without moduli, or a hinge line with nothing of that layer on it; BuildError
    without a C compiler where there are cells.
    """
    hinges = named_hinges(design)
    taken = [hinge for hinge in hinges if hinge.properties.from_material or not only_asked]
    flexible = sorted({hinge.properties.layer for hinge in taken})
    known = plate_materials(design, flexible, materials)
    holes = holes_per_layer(hinges, len(design.layers))
    account = tuple(_account(design, hinge, holes[hinge.properties.layer], known, cells) for hinge in taken)
    values = {found.joint: found.stiffness.value for found in account}
    sets = tuple(
        replace(
            hinge.properties,
            lines=(_line_of(hinge),),
            stiffness=values.get(hinge.name, hinge.properties.stiffness),
        )
        for hinge in hinges
    )
    return replace(design, hinges=sets), account


def _line_of(hinge: Hinge) -> HingeLine:
    start, end = hinge.line.coords
    return HingeLine(((start[0], start[1]), (end[0], end[1])), hinge.name, hinge.place)


def _account(
    design: Design, hinge: Hinge, holes: shapely.MultiPolygon, known: Mapping[str, Material], cells: int
) -> MaterialHinge:
    properties: HingeSet = hinge.properties
    layer = design.layers[properties.layer]
    strip = flexible_strip(design, hinge, holes, known)
    angle, material = strip.angle, strip.material
    return MaterialHinge(
        joint=hinge.name,
        layer=layer.name,
        material=material,
        angle=None if material.is_isotropic else float(np.remainder(angle + 90.0, 180.0) - 90.0),
        thickness=layer.thickness,
        stiffness=hinge_stiffness(strip.laminate, strip.width, strip.length, cells=cells),
        note=_note(design, hinge, max(strip.parts, key=lambda part: part.length), strip.width),
    )


def flexible_strip(
    design: Design, hinge: Hinge, holes: shapely.MultiPolygon, known: Mapping[str, Material]
) -> FlexibleStrip:
    """The strip of a hinge. holes: of its flexible layer; known: plate materials by name.

    Raises DesignError where nothing of the layer is on the line.
    """
    properties: HingeSet = hinge.properties
    layer = design.layers[properties.layer]
    free = [shapely.intersection(part, layer.geometry) for part in free_parts(hinge, holes)]
    if sum(part.length for part in free) <= 0.0:
        raise DesignError(
            f"hinge {hinge.name!r} has nothing of its flexible layer {layer.name!r} along its line, so it has no "
            "stiffness of its own; move the line onto the layer, or give the hinge another layer",
            hinge.place if hinge.place.line else None,
        )
    (x0, y0), (x1, y1) = hinge.line.coords
    angle = ply_angle(layer, float(np.degrees(np.arctan2(y1 - y0, x1 - x0))) - 90.0)
    material = known[layer.material.name]
    return FlexibleStrip(
        material,
        Laminate([Ply(material, layer.thickness, angle)]),
        angle,
        properties.gap,
        tuple(free),
    )


def _note(design: Design, hinge: Hinge, free: LineString, width: float) -> str:
    """What the drawing shows where it is not a slender strip of that width between stiff layers."""
    thickness = design.layers[hinge.properties.layer].thickness
    if width < _SLENDER * thickness:
        return f"{width / thickness:.2g} times as wide as thick: too short for a plate, shear makes it softer"
    bonded = [
        k for k in (hinge.properties.layer - 1, hinge.properties.layer + 1) if 0 <= k < len(design.layers)
    ]
    stiff = shapely.union_all([design.layers[k].geometry for k in bonded])
    middle = np.array(free.interpolate(0.5, normalized=True).coords[0])
    along = np.subtract(*np.array(hinge.line.coords)[[1, 0]])
    across = _REACH * hinge.properties.width * np.array([-along[1], along[0]]) / np.linalg.norm(along)
    here = shapely.Point(middle)
    if stiff.intersects(here):
        names = [repr(design.layers[k].name) for k in bonded if design.layers[k].geometry.intersects(here)]
        return f"{' and '.join(names)} over the line: taken as cut open by {_millimetres(width)}"
    sides = [shapely.intersection(stiff, LineString([middle, middle + sign * across])) for sign in (1, -1)]
    if any(side.is_empty for side in sides):
        return ""
    opening = sum(here.distance(side) for side in sides)
    if abs(opening - width) <= _SAME * width:
        return ""
    return f"the stiff layers are drawn {_millimetres(opening)} apart, and the gap says {_millimetres(width)}"


def _millimetres(length: float) -> str:
    return f"{length * 1e3:.3g} mm"
