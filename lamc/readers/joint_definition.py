"""What a popupCAD joint definition says, in SI, and the Mechanism that it makes.

In: bodies as polygons per layer, hinge lines with the bodies they join, the fixed ones. Out: a Mechanism
whose masses come from the polygons and whose names come from geometry, so that ids and order in the file do
not matter.
"""

from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from shapely.geometry import MultiPolygon, Polygon

from lamc.basics.errors import DesignError, Place, TopologyError
from lamc.design.mass import body_properties
from lamc.design.naming import BodyMark, JointMark, body_order, joint_order, name_bodies, name_joints
from lamc.readers.popupcad_layers import LayerSpec
from lamc.records.design import Layer, Line
from lamc.records.mechanism import Body, Joint, Mechanism, Slab
from lamc.records.network import faults, listed_names, loose_ends


@dataclass(frozen=True, eq=False)
class DefinedBody:
    """A body: its polygons (m) in each layer."""

    id: str
    name: str | None
    polygons: tuple[tuple[Polygon, ...], ...]  # per layer, bottom to top
    place: Place


@dataclass(frozen=True)
class DefinedJoint:
    """A hinge line, the two bodies at it, and its properties."""

    name: str | None
    line: Line  # m
    z: float  # m
    bodies: tuple[str, str]  # ids
    stiffness: float  # N·m/rad
    damping: float  # N·m·s/rad
    rest_angle: float  # rad
    limits: tuple[float, float]  # rad
    place: Place


@dataclass(frozen=True, eq=False)
class JointDefinition:
    """The whole file. Layers run from bottom to top, z = 0 at the bottom."""

    name: str
    layers: tuple[LayerSpec, ...]
    bodies: tuple[DefinedBody, ...]
    joints: tuple[DefinedJoint, ...]
    fixed: frozenset[str]  # ids of bodies


def assemble(definition: JointDefinition) -> Mechanism:
    """The mechanism of a joint definition.

    The parent of a joint is the body nearer to the world, and its axis runs along the drawn line. Raises
    DesignError and TopologyError with the place in the file.
    """
    _check_ids(definition)
    bodies = _bodies(definition)
    names = {item.id: body.name for item, body in zip(definition.bodies, bodies, strict=True)}
    joints = _joints(definition, names)
    _check_network(definition, bodies, joints)
    marks = [BodyMark(b.fixed, b.com, b.mass, b.inertia) for b in bodies]
    ordered = tuple(bodies[i] for i in body_order(marks))
    return Mechanism(ordered, joints, definition.name)


def _check_network(definition: JointDefinition, bodies: tuple[Body, ...], joints: tuple[Joint, ...]) -> None:
    """Raises the first fault with its place: that of the body, which is in the file's order, or of the joint."""
    fault = next(faults(bodies, joints), None) or next(loose_ends(bodies, joints), None)
    if fault is None:
        return
    kind, *index = fault.path
    place = None
    if index:
        at = int(index[0])
        items = (
            definition.bodies
            if kind == "bodies"
            else [definition.joints[i] for i in joint_order(_marks(definition))]
        )
        place = items[at].place
    raise type(fault.error)(fault.error.message, place) from fault.error


def drawn_lines(definition: JointDefinition) -> dict[str, Line]:
    """The drawn line, m, of each joint by the name that `assemble` gives it."""
    names = name_joints(_marks(definition), [joint.name for joint in definition.joints])
    return {name: joint.line for name, joint in zip(names, definition.joints, strict=True)}


def drawn_layers(definition: JointDefinition) -> tuple[Layer, ...]:
    """The layers as `write_joints` takes them: bottom to top, with nothing drawn in them."""
    return tuple(
        Layer(spec.name, spec.material, spec.thickness, MultiPolygon()) for spec in definition.layers
    )


def _check_ids(definition: JointDefinition) -> None:
    seen: set[str] = set()
    for body in definition.bodies:
        if body.id in seen:
            raise DesignError(f"two bodies have the id {body.id[:40]!r}; ids must differ", body.place)
        seen.add(body.id)
    for joint in definition.joints:
        for end in joint.bodies:
            if end not in seen:
                raise TopologyError(
                    f"a joint joins body {end[:40]!r}, which the file does not have; "
                    f"its bodies are {listed_names(sorted(seen))}",
                    joint.place,
                )
        if joint.bodies[0] == joint.bodies[1]:
            raise TopologyError(
                f"a joint joins body {joint.bodies[0][:40]!r} to itself; a hinge needs two different bodies",
                joint.place,
            )
    for unknown in sorted(definition.fixed - seen):
        raise TopologyError(f"the fixed body {unknown[:40]!r} is not among the bodies of {definition.name!r}")


def _bodies(definition: JointDefinition) -> tuple[Body, ...]:
    """Bodies in the order of the file, with masses from their plates."""
    z = np.concatenate([[0.0], np.cumsum([layer.thickness for layer in definition.layers])])
    made: list[tuple[tuple[Slab, ...], BodyMark]] = []
    for item in definition.bodies:
        plates = [
            (Slab(polygon, float(z[i]), float(z[i + 1])), definition.layers[i].material.density)
            for i, polygons in enumerate(item.polygons)
            for polygon in polygons
        ]
        if not plates:
            raise DesignError(f"body {item.id[:40]!r} has no polygon in any layer", item.place)
        mass, com, inertia = body_properties(plates)
        mark = BodyMark(item.id in definition.fixed, com, mass, inertia)
        made.append((tuple(plate for plate, _ in plates), mark))
    names = name_bodies([mark for _, mark in made], [item.name for item in definition.bodies])
    bodies: list[Body] = []
    for name, (outline, mark), item in zip(names, made, definition.bodies, strict=True):
        try:
            bodies.append(Body(name, mark.mass, mark.com, mark.inertia, fixed=mark.fixed, outline=outline))
        except DesignError as error:
            raise type(error)(error.message, item.place) from error
    return tuple(bodies)


def _joints(definition: JointDefinition, names: Mapping[str, str]) -> tuple[Joint, ...]:
    depth = _depths(definition)

    def nearness(body: str) -> tuple[int, str]:
        return depth.get(body, len(depth)), names[body]

    marks = _marks(definition)
    given = name_joints(marks, [joint.name for joint in definition.joints])
    joints: list[Joint] = []
    for i in joint_order(marks):
        item, mark = definition.joints[i], marks[i]
        parent, child = sorted(item.bodies, key=nearness)
        try:
            joint = Joint(
                given[i],
                names[parent],
                names[child],
                point=(mark.start + mark.end) / 2,
                axis=mark.end - mark.start,
                stiffness=item.stiffness,
                damping=item.damping,
                rest_angle=item.rest_angle,
                limits=item.limits,
            )
        except DesignError as error:
            raise type(error)(error.message, item.place) from error
        joints.append(joint)
    return tuple(joints)


def _marks(definition: JointDefinition) -> list[JointMark]:
    return [JointMark(*(np.array([*end, joint.z]) for end in joint.line)) for joint in definition.joints]


def _depths(definition: JointDefinition) -> dict[str, int]:
    """Least number of hinges from the world to each body that can be reached."""
    neighbours: dict[str, list[str]] = {body.id: [] for body in definition.bodies}
    for joint in definition.joints:
        a, b = joint.bodies
        neighbours[a].append(b)
        neighbours[b].append(a)
    depth = {body.id: 0 for body in definition.bodies if body.id in definition.fixed}
    queue: deque[str] = deque(depth)
    while queue:
        body = queue.popleft()
        for other in neighbours[body]:
            if other not in depth:
                depth[other] = depth[body] + 1
                queue.append(other)
    return depth


def checked_pair(ids: Sequence[str], place: Place) -> tuple[str, str]:
    """The two bodies of a joint. Raises TopologyError for any other number."""
    if len(ids) != 2:
        raise TopologyError(f"a joint touches {len(ids)} bodies; a hinge needs exactly 2", place)
    return ids[0], ids[1]
