"""The parts of lamc's files by the names that people call them: what `lamc schema NAME` can be asked for.

In: nothing. Out: definitions of the JSON Schema, each with its name, what it is and an example. A test reads every
example with the model that it is of.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from lamc.basics.fields import StrictModel
from lamc.effects.registry import by_name
from lamc.readers.plates.problem_schema import PlateFileModel
from lamc.readers.schema import FILES, json_schema
from lamc.readers.study_file import StudyModel

WHOLE: Mapping[str, type[StrictModel]] = {**FILES, "PlateProblem": PlateFileModel, "Study": StudyModel}

# Name for people: (definition, an example in YAML)
_PARTS: Mapping[str, tuple[str, str]] = {
    "design": (
        "Design",
        "units: mm\n"
        "parameters: {length: {default: 40 mm, min: 25 mm}, width: length/2}\n"
        "materials: {card: {density: 700, rigid: true}, film: {density: 1390, flexible: true}}\n"
        "layers:\n"
        "  - {name: film, material: film, thickness: 25 um}\n"
        "  - {name: card, material: card, thickness: 0.3 mm}\n"
        "shapes: [{rect: [0, 0, length, width]}]\n"
        "hinges: [{name: fold, line: [[15, 0], [15, width]], gap: 0.4, stiffness: 0.5 N*mm/rad}]\n"
        "fixed: [{rect: [0, 0, 5, width]}]",
    ),
    "material": ("MaterialModel", "{density: 1390, E1: 4.9 GPa, poisson: 0.38, flexible: true}"),
    "layer": ("LayerModel", "{name: film, material: film, thickness: 25 um}"),
    "shape": ("ShapeModel", "{rect: [0, 0, 0.04, 0.02], layers: [card]}"),
    "region": ("RegionModel", "{circle: {center: [0, 0], radius: 5 mm}}"),
    "outline": (
        "OutlineModel",
        "{polygon: [[0, 0], [1, 0], [0, 1]], holes: [[[0.2, 0.2], [0.3, 0.2], [0.2, 0.3]]]}",
    ),
    "circle": ("CircleModel", "{center: [0, 0], radius: 5 mm}"),
    "drawn": (
        "DrawnModel",
        "{file: top.dxf, layer: body, units: mm, roles: {red: cut}, heal: 50 um, at: [5, 0]}",
    ),
    "hinge": (
        "HingeModel",
        "{name: knee, line: [[0, 0], [0, 20 mm]], gap: 0.4 mm, stiffness: 0.5 N*mm/rad, damping: 1e-6,\n"
        " rest_angle: 30 deg, limits: [-90 deg, 90 deg]}",
    ),
    "body_name": ("NamedBodyModel", "{at: [20 mm, 5 mm], layer: card}"),
    "facet_creases": ("FacetCreasesModel", "{stiffness: from-material, damping: 1e-6}"),
    "mechanism": (
        "Mechanism",
        "bodies:\n"
        "  - {name: frame, fixed: true}\n"
        "  - {name: arm, mass: 2 g, com: [20 mm, 0, 0], inertia: [[1e-8, 0, 0], [0, 3e-7, 0], [0, 0, 3e-7]]}\n"
        "joints:\n"
        "  - {name: hip, parent: frame, child: arm, point: [0, 0, 0], axis: [0, 1, 0], stiffness: 2e-3}",
    ),
    "body": (
        "BodyModel",
        "{name: arm, mass: 2 g, com: [20 mm, 0, 0], inertia: [[1e-8, 0, 0], [0, 3e-7, 0], [0, 0, 3e-7]]}",
    ),
    "joint": (
        "JointModel",
        "{name: hip, parent: frame, child: arm, point: [0, 0, 0], axis: [0, 1, 0], stiffness: 2e-3}",
    ),
    "slab": ("PlateModel", "{polygon: [[0, 0], [1, 0], [0, 1]], z: [0, 0.3 mm]}"),
    "scene": (
        "Scene",
        "with: {gravity: [0, 0, -1.62]}\n"
        "angles: {knee: 30 deg}\n"
        "duration: 2 s\n"
        "outputs: [knee, {name: tip, body: foot, point: [90 mm, 0, 0]}]",
    ),
    "scenes": (
        "Scenes",
        "scenes:\n  slow: {rates: {knee: 5 deg/s}}\n  fast: {like: slow, rates: {knee: 90 deg/s}}",
    ),
    "output_point": ("OutputPointModel", "{name: tip, body: foot, point: [90 mm, 0, 0]}"),
    "plate": (
        "PlateProblem",
        "kind: plate\n"
        "units: mm\n"
        "laminate: {material: steel, thickness: 1 mm}\n"
        "geometry: {rect: [0, 0, 100, 20], size: 5}\n"
        "supports: [{clamped: left}]\n"
        "loads: [{edge: right, total: -0.1 N}]",
    ),
    "study": (
        "Study",
        "kind: study\n"
        "example: flaps\n"
        "vary: {left.stiffness: log:1e-4:1e-2:7, angles.left: [10 deg, 20 deg]}\n"
        "measure: {swing: max(abs(left)), back: time_of(left < 0)}\n"
        "run: {t_end: 2 s}",
    ),
    "study_run": ("StudyRunModel", "{t_end: 500 ms, rtol: 1e-6}"),
    "plate_material": ("PlateMaterialModel", "{E: 4.9 GPa, nu: 0.38, density: 1390}"),
    "laminate": ("LaminateModel", "{material: T300/5208, layup: '[0/90/±45]s', ply: 125 um}"),
    "ply": ("PlyModel", "{material: Kapton HN, thickness: 25 um, angle: 0 deg}"),
    "geometry": (
        "GeometryModel",
        "{rect: [0, 0, 0.1, 0.02], holes: [{circle: {center: [50 mm, 10 mm], radius: 4 mm}}], size: 2 mm}",
    ),
    "plate_outline": ("PlateOutlineModel", "{rect: [0, 0, 0.1, 0.02]}"),
    "plate_region": (
        "PlateRegionModel",
        "{rect: [0, 0, 0.05, 0.02], laminate: {material: steel, thickness: 2 mm}}",
    ),
    "follow": ("FollowModel", "{line: [[0, 0], [0.1, 0.02]]}"),
    "place": ("WhereModel", "{line: [[0, 0], [0, 0.02]]}"),
    "support": ("SupportModel", "{fixed: [w, w_x], where: left, value: 1 mm}"),
    "foundation": ("FoundationModel", "{stiffness: 2 MPa/mm, where: {rect: [0, 0, 0.05, 0.02]}}"),
    "hinge_line": ("HingeLineModel", "{along: {line: [[0.05, 0], [0.05, 0.02]]}, stiffness: 3 N/rad}"),
    "load": ("LoadModel", "{point: [0.1, 0.01], force: -0.1 N}"),
    "output": ("OutputModel", "{name: tip, at: [0.1, 0.01], value: w}"),
}


@dataclass(frozen=True)
class Part:
    """A part of lamc's files. definition: its JSON Schema; example: YAML; said: what it is; summary: in a line."""

    name: str
    definition: Mapping[str, Any]
    example: str
    said: str
    summary: str
    is_effect: bool = False


def definitions() -> Mapping[str, Any]:
    """Those of the whole JSON Schema, by their names there."""
    return dict(json_schema(WHOLE)["$defs"])


def parts() -> dict[str, Part]:
    """All parts by name: those of files in the order in which one meets them, then effects."""
    known = definitions()
    found = {}
    for name, (of, example) in _PARTS.items():
        said = " ".join(known[of]["description"].split())
        found[name] = Part(name, known[of], example, said, said.split(": ")[0].split(". ")[0].rstrip("."))
    for name, kind in sorted(by_name().items()):
        found[name] = Part(
            name, known[f"effect_{name}"], kind.example, kind.said, kind.summary, is_effect=True
        )
    return found


def called(reference: str) -> str:
    """What people call the definition of a `$ref`."""
    of = reference.rsplit("/", 1)[-1]
    of = {"SceneModel": "Scene"}.get(of, of)
    return next(
        (name for name, (each, _) in _PARTS.items() if each == of), of.removeprefix("effect_").lower()
    )
