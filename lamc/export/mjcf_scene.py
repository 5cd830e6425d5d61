"""The parts of an MJCF model that are not its bodies: springs, ground, welds, torques and the start.

In: an `EngineModel` and the elements of its bodies. Out: elements added to the document. Never: makes a file.
"""

import math
from collections.abc import Mapping
from xml.etree.ElementTree import Element, SubElement

import numpy as np

from lamc.effects.engine_loads import GroundPlane
from lamc.export.engine_model import EngineModel
from lamc.export.engine_names import engine_names
from lamc.export.engine_text import number, row
from lamc.mechanism.tree import WORLD

STIFFEST = 0.9999  # MuJoCo's largest impedance (mjMAXIMP)
SHORTEST = (
    1e-9  # s, a time constant below two steps: MuJoCo takes two steps then, whatever the step (refsafe)
)
POINT = 0.01  # of the size: radius of the spheres around points that touch
PLANE = 5.0  # of the size: half the side of the ground in pictures
STANDARD_GRAVITY = 9.81  # m/s²
LEAST_BOUNCE = 0.01  # of critical damping, for a ground without damping


def add_springs(root: Element, bodies: Mapping[int, Element], model: EngineModel) -> None:
    if not model.springs:
        return
    tendons = SubElement(root, "tendon")
    for count, spring in enumerate(model.springs, start=1):
        tendon = SubElement(
            tendons,
            "spatial",
            name=f"spring_{count}",
            stiffness=number(spring.stiffness),
            springlength=number(spring.rest_length),
            damping=number(spring.damping),
            width=number(POINT * model.mechanism.size / 4.0),
        )
        ends = ((spring.body_a, spring.point_a), (spring.body_b, spring.point_b))
        for end, (body, point) in zip("ab", ends, strict=True):
            index = model.places[body]
            site = f"spring_{count}_{end}"
            place = row(np.array(point) - model.origin(index))
            SubElement(
                bodies[index], "site", name=site, pos=place, size=number(POINT * model.mechanism.size / 2.0)
            )
            SubElement(tendon, "site", site=site)


def add_ground(bodies: Mapping[int, Element], model: EngineModel, ground: GroundPlane) -> None:
    """A plane, lower by the radius of the spheres that touch it, so that a point touches at its own depth."""
    size = model.mechanism.size
    radius = POINT * size
    plane, *points = engine_names(
        ["ground_plane", *(f"touching_{k}" for k in range(1, len(ground.points) + 1))],
        reserved=model.body_names.values(),  # of the geoms that are their pictures
    )
    friction, solref = row((ground.friction, 0.0, 0.0)), row(_solref(ground))
    SubElement(
        bodies[WORLD],
        "geom",
        name=plane,
        type="plane",
        pos=row((ground.height - radius) * np.array(ground.normal)),
        zaxis=row(ground.normal),
        size=row((PLANE * size, PLANE * size, size)),
        rgba="0.8 0.8 0.78 1",
        contype="1",
        conaffinity="0",
        friction=friction,
        condim="3",
        solref=solref,
    )
    for name, each in zip(points, ground.points, strict=True):
        index = model.places[each.body]
        SubElement(
            bodies[index],
            "geom",
            name=name,
            type="sphere",
            pos=row(np.array(each.point) - model.origin(index)),
            size=number(radius),
            rgba="0.2 0.2 0.2 0.3",
            contype="0",
            conaffinity="1",
            group="3",
            friction=friction,
            condim="3",
            solref=solref,
        )


def _solref(ground: GroundPlane) -> tuple[float, float]:
    """Time constant, s, and damping ratio of the ground, linearised where all weight rests on one point."""
    depth = (ground.weight / ground.stiffness) ** (1.0 / ground.exponent)
    frequency = math.sqrt(ground.exponent * STANDARD_GRAVITY / depth)
    ratio = max(0.75 * ground.damping * STANDARD_GRAVITY / frequency, LEAST_BOUNCE)
    return 1.0 / (ratio * frequency), ratio


def add_welds(root: Element, model: EngineModel) -> None:
    """Parts of one body held together: as stiff as MuJoCo's soft constraints get, an angle times the size counting as a
    distance."""
    parts = [piece for piece in model.pieces if piece.welded is not None]
    if parts:
        equality = SubElement(root, "equality")
        for piece in parts:
            assert piece.welded is not None, "it was chosen for that"
            SubElement(
                equality,
                "weld",
                name=piece.name,
                body1=model.pieces[piece.welded].name,
                body2=piece.name,
                torquescale=number(model.mechanism.size),
                solref=row((SHORTEST, 1.0)),
                solimp=row((STIFFEST, STIFFEST, 1.0)),
            )


def add_torques(root: Element, model: EngineModel) -> None:
    """A motor on each hinge with a torque: force = control + constant + per_angle angle + per_rate rate."""
    driven = [hinge for hinge in model.hinges if hinge.loads.has_torque]
    if not driven:
        return
    actuators = SubElement(root, "actuator")
    for hinge in driven:
        loads = hinge.loads
        SubElement(
            actuators,
            "general",
            name=hinge.name,
            joint=hinge.name,
            gainprm="1",
            biastype="affine",
            biasprm=row((loads.constant, loads.per_angle, loads.per_rate)),
        )
    drives = [(hinge.name, hinge.loads.drive) for hinge in driven if hinge.loads.drive is not None]
    if drives:
        custom = SubElement(root, "custom")
        for name, text in drives:
            SubElement(custom, "text", name=f"torque_{name}", data=text)


def add_start(root: Element, model: EngineModel) -> None:
    """The scene's start as keyframe 0."""
    qpos: list[float] = []
    qvel: list[float] = []
    if model.base is not None:
        qpos += [*model.base.position, *model.base.rotation]
        qvel += [*model.base.velocity, *model.base.spin]
    for hinge in model.hinges:
        qpos.append(model.angles[hinge.joint.name])
        qvel.append(model.rates[hinge.joint.name])
    keyframe = SubElement(root, "keyframe")
    SubElement(keyframe, "key", name="start", qpos=row(qpos), qvel=row(qvel))
