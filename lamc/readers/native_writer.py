"""Native designs as text: a `Design` of any origin as YAML that reads back equal.

In: a Design. Out: text; every number is SI and reads back to the last bit. Of parameters the values are written, not
expressions. Shapes are what is left of them: a rectangle with a hole cut from it is a polygon with a hole. Never: says
a layer's shape twice where layers are drawn alike.
"""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import shapely
from shapely.geometry import MultiPolygon, Polygon

from lamc.basics.errors import DesignError
from lamc.basics.files import checked_path, write_text
from lamc.basics.yaml_text import dump
from lamc.readers.fields import ALL_LAYERS, FROM_MATERIAL
from lamc.readers.scene_writer import scenes_data
from lamc.records.design import BodyName, Design, FacetCreases, HingeLine, HingeSet, Layer, Material
from lamc.records.mechanism import FREE_LIMITS
from lamc.records.scene import TURN

_FLAGS = {
    "rigid": "is_rigid",
    "flexible": "is_flexible",
    "adhesive": "is_adhesive",
    "conductive": "is_conductive",
}


def write_design(design: Design, path: Path | str) -> None:
    """Writes a file that `load` turns into an equal design, in one step. Raises as `design_text` does, and LamcError
    where the file cannot be written."""
    write_text(checked_path(path), design_text(design))


def design_text(design: Design) -> str:
    """The design as the text of a file. Raises as `design_data` does."""
    return dump(design_data(design))


def design_data(design: Design) -> dict[str, Any]:
    """The design as plain data, in the order of a file. Raises DesignError for names that a file cannot hold, and for a
    scene that it cannot."""
    names = [layer.name for layer in design.layers]
    wrong = next((name for k, name in enumerate(names) if name == ALL_LAYERS or name in names[:k]), None)
    if wrong is not None:
        raise DesignError(f"a layer is named {wrong!r}, as another is, or as all are together; rename it")
    materials = _materials(design.layers)
    data: dict[str, Any] = {"kind": "design", "name": design.name}
    if design.story:
        data["story"] = design.story
    data["units"] = "m"
    data["materials"] = {name: _material(material) for name, material in materials.items()}
    data["layers"] = [_layer(layer, materials) for layer in design.layers]
    data["shapes"] = _regions([layer.geometry for layer in design.layers], names)
    if design.hinges:
        data["hinges"] = [entry for hinges in design.hinges for entry in _hinges(hinges, names)]
    if any(not region.is_empty for region in design.fixed):
        data["fixed"] = _regions(design.fixed, names)
    if design.body_names:
        data["bodies"] = {body.name: _body(body, names) for body in design.body_names}
    if design.contact_points:
        data["contact_points"] = [list(point) for point in design.contact_points]
    if design.facet_creases is not None:
        data["facet_creases"] = _facet_creases(design.facet_creases)
    return data | scenes_data(design.scene, design.scenes)


def _materials(layers: Sequence[Layer]) -> dict[str, Material]:
    """Materials by name in the file: their own, numbered where two that differ share one."""
    named: dict[str, Material] = {}
    for layer in layers:
        name, count = layer.material.name, 1
        while named.setdefault(name, layer.material) != layer.material:
            count += 1
            name = f"{layer.material.name}_{count}"
    return named


def _material(material: Material) -> dict[str, Any]:
    data: dict[str, Any] = {"density": material.density}
    for name in ("E1", "E2", "poisson", "G12"):
        if getattr(material, name) is not None:
            data[name] = getattr(material, name)
    return data | {said: True for said, name in _FLAGS.items() if getattr(material, name)}


def _layer(layer: Layer, materials: dict[str, Material]) -> dict[str, Any]:
    name = next(name for name, material in materials.items() if material == layer.material)
    data: dict[str, Any] = {"name": layer.name, "material": name, "thickness": layer.thickness}
    return data | ({"angle": _angle(layer.angle)} if layer.angle else {})


def _regions(sheets: Sequence[MultiPolygon], names: Sequence[str]) -> list[dict[str, Any]]:
    """Polygons with the layers that have them; those of layers that are drawn alike stand once.

    In shapely's normal form: unions order corners and polygons anew, and what was read is written alike."""
    sheets = [shapely.normalize(sheet) for sheet in sheets]
    alike: dict[bytes, list[int]] = {}
    for k, sheet in enumerate(sheets):
        alike.setdefault(sheet.wkb, []).append(k)
    return [
        _polygon(polygon) | {"layers": _named(indices, names)}
        for indices in alike.values()
        for polygon in sheets[indices[0]].geoms
    ]


def _polygon(polygon: Polygon) -> dict[str, Any]:
    data: dict[str, Any] = {"polygon": _ring(polygon.exterior.coords)}
    if polygon.interiors:
        data["holes"] = [_ring(ring.coords) for ring in polygon.interiors]
    return data


def _ring(coords: Sequence[Sequence[float]]) -> list[list[float]]:
    return [[float(x), float(y)] for x, y, *_ in coords[:-1]]


def _named(indices: Sequence[int], names: Sequence[str]) -> str | list[str]:
    return ALL_LAYERS if len(indices) == len(names) else [names[k] for k in indices]


def _hinges(hinges: HingeSet, names: Sequence[str]) -> list[dict[str, Any]]:
    """One entry, or one for each line where their names do not count on from one."""
    own = [line.name for line in hinges.lines]
    first = own[0] or ""
    shared = first.removesuffix("_1")
    if len(own) == 1:
        entries: list[dict[str, Any]] = [_named_line(hinges.lines[0])]
    elif not any(own) or own == [f"{shared}_{k}" for k in range(1, len(own) + 1)]:
        name = {"name": shared} if first else {}
        entries = [name | {"lines": [[list(end) for end in line.line] for line in hinges.lines]}]
    else:
        entries = [_named_line(line) for line in hinges.lines]
    data: dict[str, Any] = {"layer": names[hinges.layer], "layers": _named(hinges.sublaminate, names)}
    data["gap"] = hinges.gap
    if hinges.stiffness or hinges.from_material:
        data["stiffness"] = FROM_MATERIAL if hinges.from_material else hinges.stiffness
    if hinges.damping:
        data["damping"] = hinges.damping
    if hinges.rest_angle:
        data["rest_angle"] = _angle(hinges.rest_angle)
    if hinges.limits != FREE_LIMITS:
        data["limits"] = [_angle(limit) for limit in hinges.limits]
    return [entry | data for entry in entries]


def _named_line(line: HingeLine) -> dict[str, Any]:
    name = {"name": line.name} if line.name else {}
    return name | {"line": [list(end) for end in line.line]}


def _angle(angle: float) -> float | str:
    """Bare ones of more than a turn would be taken for degrees."""
    return f"{angle!r} rad" if abs(angle) > TURN else angle


def _body(body: BodyName, names: Sequence[str]) -> Any:
    at = [body.point.x, body.point.y]
    return at if body.layer is None else {"at": at, "layer": names[body.layer]}


def _facet_creases(creases: FacetCreases) -> dict[str, Any]:
    stiffness = FROM_MATERIAL if creases.stiffness is None else creases.stiffness
    return {"stiffness": stiffness} | ({"damping": creases.damping} if creases.damping else {})
