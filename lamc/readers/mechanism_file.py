"""Mechanism files: the `Mechanism` record as YAML, both ways.

In: nodes of a mechanism file, or a Mechanism. Out: a Mechanism, or a file that reads back to an equal one, to
the last bit. Units are SI unless a number carries its own.
"""

from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path as FilePath
from pathlib import PurePath
from typing import Any

from lamc.basics.errors import DesignError
from lamc.basics.files import checked_path, write_text
from lamc.basics.yaml_text import dump
from lamc.design import shapes
from lamc.readers.checking import Path, Problems, did_you_mean, validate
from lamc.readers.fields import LENGTH_UNIT
from lamc.readers.inert import Node
from lamc.readers.mechanism_as_such import MechanismAsSuch
from lamc.readers.mechanism_schema import BodyModel, JointModel, MechanismModel, PlateModel
from lamc.readers.native import length_unit_of
from lamc.readers.scene_file import read_scenes
from lamc.readers.scene_schema import SceneModel
from lamc.readers.scene_writer import scenes_data
from lamc.records.mechanism import FREE_LIMITS, Body, Joint, Mechanism, Slab
from lamc.records.network import faults, loose_ends
from lamc.records.parameters import with_origin


def read_mechanism(node: Node) -> Mechanism:
    """The mechanism in `node`. Raises DesignErrors with every problem of the file."""
    unit = length_unit_of(node)
    model = validate(MechanismModel, node, {LENGTH_UNIT: unit})
    problems = Problems(node)
    bodies: list[Body] = []
    for index, entry in enumerate(model.bodies):
        body = problems.attempt(("bodies", index), partial(_body, entry))
        bodies += [body] if body is not None else []
    joints: list[Joint] = []
    for index, item in enumerate(model.joints):
        joint = problems.attempt(("joints", index), partial(_joint, item))
        joints += [joint] if joint is not None else []
    scene, scenes = read_scenes(model.scene, model.scenes, problems, unit)
    problems.raise_if_any()
    for fault in tuple(faults(bodies, joints)) or loose_ends(bodies, joints):
        problems.add(fault.path, fault.error.message)
    _check_joints(model.scene, model.scenes, [joint.name for joint in joints], problems)
    problems.raise_if_any()
    name = model.name or PurePath(node.place.file).stem or "mechanism"
    mechanism = problems.attempt(
        (),
        lambda: Mechanism(
            tuple(bodies), tuple(joints), name, scene, model.story, scenes, tuple(model.contact_points)
        ),
    )
    problems.raise_if_any()
    assert mechanism is not None
    return with_origin(mechanism, MechanismAsSuch(mechanism))


def _check_joints(
    scene: SceneModel | None, scenes: Mapping[str, SceneModel], joints: Sequence[str], problems: Problems
) -> None:
    """Notes joints that scenes start and that are not there."""
    models: list[tuple[Path, SceneModel]] = [(("scenes", name), model) for name, model in scenes.items()]
    models += [(("scene",), scene)] if scene is not None else []
    for path, model in models:
        for section in ("angles", "rates"):
            for name in getattr(model, section):
                if name not in joints:
                    text = f"no joint is named {name[:40]!r}; {did_you_mean(name, joints)}"
                    problems.add((*path, section, name), text)


def write_mechanism(mechanism: Mechanism, path: FilePath | str) -> None:
    """Writes a file that `load` turns into an equal mechanism, in one step.

    Raises DesignError for a scene that a file cannot hold, LamcError where the file cannot be written.
    """
    write_text(checked_path(path), mechanism_text(mechanism))


def mechanism_text(mechanism: Mechanism) -> str:
    """The mechanism as the text of a file. Raises DesignError for a scene that a file cannot hold."""
    data: dict[str, Any] = {"kind": "mechanism", "name": mechanism.name}
    if mechanism.story:
        data["story"] = mechanism.story
    data["bodies"] = [_body_data(body) for body in mechanism.bodies]
    data["joints"] = [_joint_data(joint) for joint in mechanism.joints]
    if mechanism.contact_points:
        data["contact_points"] = [list(point) for point in mechanism.contact_points]
    return dump(data | scenes_data(mechanism.scene, mechanism.scenes))


def _body(model: BodyModel) -> Body:
    return Body(
        name=model.name,
        mass=model.mass,
        com=model.com,  # type: ignore[arg-type]  # Body makes arrays of what it is given
        inertia=model.inertia,  # type: ignore[arg-type]
        fixed=model.fixed,
        outline=tuple(_plate(plate) for plate in model.outline),
    )


def _plate(model: PlateModel) -> Slab:
    bottom, top = model.z
    if not bottom < top:
        raise DesignError(
            f"a plate runs from z = {bottom:g} m to {top:g} m; its top must lie above its bottom"
        )
    return Slab(shapes.polygon(model.polygon, model.holes), bottom, top)


def _joint(model: JointModel) -> Joint:
    return Joint(
        name=model.name,
        parent=model.parent,
        child=model.child,
        point=model.point,  # type: ignore[arg-type]  # Joint makes arrays of what it is given
        axis=model.axis,  # type: ignore[arg-type]
        stiffness=model.stiffness,
        damping=model.damping,
        rest_angle=model.rest_angle,
        limits=model.limits or FREE_LIMITS,
    )


def _body_data(body: Body) -> dict[str, Any]:
    data: dict[str, Any] = {"name": body.name, "mass": body.mass, "com": body.com.tolist()}
    data["inertia"] = body.inertia.tolist()
    data["fixed"] = body.fixed
    if body.outline:
        data["outline"] = [_plate_data(plate) for plate in body.outline]
    return data


def _plate_data(plate: Slab) -> dict[str, Any]:
    data: dict[str, Any] = {"z": [plate.z_bottom, plate.z_top]}
    data["polygon"] = [[x, y] for x, y, *_ in plate.polygon.exterior.coords[:-1]]
    if plate.polygon.interiors:
        data["holes"] = [[[x, y] for x, y, *_ in ring.coords[:-1]] for ring in plate.polygon.interiors]
    return data


def _joint_data(joint: Joint) -> dict[str, Any]:
    return {
        "name": joint.name,
        "parent": joint.parent,
        "child": joint.child,
        "point": joint.point.tolist(),
        "axis": joint.axis.tolist(),
        "stiffness": joint.stiffness,
        "damping": joint.damping,
        "rest_angle": joint.rest_angle,
        "limits": list(joint.limits),
    }
