"""Writes popupCAD's current joint definition, so that a split design can go where popupCAD's own files go.

In: a mechanism whose bodies have outlines, and the layers that these lie in. Out: a file that `load` turns
back into the same mechanism. popupCAD's format has no names for bodies and hinges: they are added as
attributes that its readers ignore.
"""

import math
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from shapely.geometry import Polygon

from lamc.basics.errors import DesignError
from lamc.basics.files import checked_path, write_text
from lamc.basics.yaml_text import scalar
from lamc.design.mass import body_properties
from lamc.design.steps import SplitSteps
from lamc.records.design import Layer, Line, Material
from lamc.records.mechanism import Body, Joint, Mechanism

_PACKAGE = "!!python/object:foldable_robotics.dynamics_info"
_FIRST_BODY, _FIRST_LAYER = 1001, 5001
# Relative: masses from the same polygons agree to round-off; a mass that somebody set by hand does not.
_SAME = 1e-9


def write_split(steps: SplitSteps, path: Path | str) -> None:
    """Writes the joint definition of a split design. Raises LamcError where the file cannot be written."""
    lines = {c.hinge.name: ends(c.hinge.line.coords) for c in steps.connections}
    write_joints(steps.mechanism, steps.design.layers, path, lines=lines)


def write_joints(
    mechanism: Mechanism,
    layers: Sequence[Layer],
    path: Path | str,
    *,
    lines: Mapping[str, Line] | None = None,
) -> None:
    """Writes a mechanism as a joint definition, in one step.

    layers  bottom to top, z = 0 at the bottom; every plate of every outline fills one of them
    lines   the drawn line of each joint by name, m; a joint left out gets a line of the mechanism's size

    Raises DesignError where the format cannot say it (a body without outline, a mass that its plates do not
    have, a hinge that is not parallel to the layers), LamcError where the file cannot be written.
    """
    write_text(checked_path(path), joints_text(mechanism, layers, lines or {}))


def joints_text(mechanism: Mechanism, layers: Sequence[Layer], lines: Mapping[str, Line]) -> str:
    """The joint definition as text. Raises DesignError as `write_joints` does."""
    ids = {body.name: _FIRST_BODY + i for i, body in enumerate(mechanism.bodies)}
    text = [f"{_PACKAGE}.DynamicsInfo", "connected_items:"]
    layer_id = _FIRST_LAYER
    for body in mechanism.bodies:
        text += [f"- id: {ids[body.name]}", f"  name: {scalar(body.name)}", "  layers:"]
        for polygons in _by_layer(body, layers):
            text += [f"  - id: {layer_id}", f"    geoms: [{', '.join(scalar(wkt(p)) for p in polygons)}]"]
            layer_id += 1
    text.append("connections:" if mechanism.joints else "connections: []")
    for joint in mechanism.joints:
        text += _joint_lines(joint, ids, lines.get(joint.name) or _line_of(joint, mechanism.size))
    text.append("material_properties:")
    for layer in layers:
        text += _material_lines(layer)
    text.append("newtonian_ids:")
    text += [f"- {ids[body.name]}" for body in mechanism.bodies if body.fixed]
    return "\n".join(text) + "\n"


def wkt(polygon: Polygon) -> str:
    """The polygon as well-known text that reads back exactly."""
    rings = [polygon.exterior, *polygon.interiors]
    return f"POLYGON ({', '.join(_ring(ring.coords) for ring in rings)})"


def _ring(points: Sequence[Sequence[float]]) -> str:
    return f"({', '.join(f'{float(p[0])!r} {float(p[1])!r}' for p in points)})"


def _by_layer(body: Body, layers: Sequence[Layer]) -> list[list[Polygon]]:
    """The body's polygons in each layer, after a check that they make up its mass."""
    heights = np.concatenate([[0.0], np.cumsum([layer.thickness for layer in layers])])
    near = _SAME * float(heights[-1])
    found: list[list[Polygon]] = [[] for _ in layers]
    plates = []
    for plate in body.outline:
        index = int(np.argmin(np.abs(heights[:-1] - plate.z_bottom)))
        if abs(heights[index] - plate.z_bottom) > near or abs(heights[index + 1] - plate.z_top) > near:
            raise DesignError(
                f"a plate of {body.name!r} between z = {plate.z_bottom:g} and {plate.z_top:g} m fills no "
                "layer; a joint definition knows layers only"
            )
        found[index].append(plate.polygon)
        plates.append((plate, layers[index].material.density))
    if not plates:
        raise DesignError(
            f"body {body.name!r} has no outline; a joint definition describes bodies by polygons"
        )
    mass, com, _ = body_properties(plates)
    if abs(mass - body.mass) > _SAME * mass or float(np.abs(com - body.com).max()) > _SAME * _extent(body):
        raise DesignError(
            f"body {body.name!r} has mass {body.mass:g} kg and its plates have {mass:g} kg, or another "
            "centre; a joint definition cannot say so: write a mechanism file"
        )
    return found


def _extent(body: Body) -> float:
    corners = np.array([plate.polygon.bounds for plate in body.outline])
    return float(np.abs(corners).max())


def _joint_lines(joint: Joint, ids: Mapping[str, int], line: Line) -> list[str]:
    if abs(joint.axis[2]) > _SAME:
        raise DesignError(
            f"joint {joint.name!r} is not parallel to the layers; a joint definition cannot say so: write a "
            "mechanism file"
        )
    lower, upper = (math.degrees(limit) for limit in joint.limits)
    values = {
        "damping": joint.damping,
        "limit_neg": lower,
        "limit_pos": upper,
        "name": joint.name,
        "preload": math.degrees(joint.rest_angle),
        "stiffness": joint.stiffness,
        "z_pos": float(joint.point[2]),
    }
    said = ", ".join(f"{key}: {scalar(value)}" for key, value in values.items())
    return [
        "- !!python/tuple",
        "  - !!python/tuple",
        *(f"    - !!python/tuple [{scalar(float(x))}, {scalar(float(y))}]" for x, y in line),
        f"  - !!python/tuple [{ids[joint.parent]}, {ids[joint.child]}]",
        f"  - {_PACKAGE}.JointProps {{{said}}}",
    ]


def _line_of(joint: Joint, size: float) -> Line:
    """A line through the joint's point; its length is the mechanism's size."""
    half = joint.axis[:2] * (size / 2)
    start, end = joint.point[:2] - half, joint.point[:2] + half
    return (float(start[0]), float(start[1])), (float(end[0]), float(end[1]))


def moduli_of(material: Material) -> tuple[float, float, float] | None:
    """E1, E2, Pa, and Poisson's ratio, as a joint definition has them; None where one is not known."""
    across = material.E1 if material.E2 is None else material.E2
    if material.E1 is None or across is None or material.poisson is None:
        return None
    return material.E1, across, material.poisson


def _material_lines(layer: Layer) -> list[str]:
    """popupCAD's placeholders stand for moduli that are not known."""
    material = layer.material
    moduli = moduli_of(material) or (1.0, 1.0, 0.5)
    values = {
        "E1": moduli[0],
        "E2": moduli[1],
        "color": None,
        "density": material.density,
        "is_adhesive": material.is_adhesive,
        "is_conductive": material.is_conductive,
        "is_flexible": material.is_flexible,
        "is_rigid": material.is_rigid,
        "name": material.name,
        "poisson": moduli[2],
        "thickness": layer.thickness,
    }
    colour = "!!python/tuple [0.2, 0.2, 0.2, 0.5]"
    lines = [f"  {key}: {colour if key == 'color' else scalar(value)}" for key, value in values.items()]
    return [f"- {_PACKAGE}.MaterialProperty", *lines]


def ends(coords: Sequence[Sequence[float]]) -> Line:
    """The two ends of a line."""
    (x0, y0), (x1, y1) = coords
    return (float(x0), float(y0)), (float(x1), float(y1))
