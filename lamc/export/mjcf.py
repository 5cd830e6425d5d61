"""MJCF: the model in MuJoCo's XML, meshes beside it, and a README that says what is where.

In: a mechanism and a scene. Out: files by their relative path. Never: needs MuJoCo, or writes anything.

What MuJoCo's own quantities have to be so that they are lamc's is said where it is written; formulas are those of
"Computation" in MuJoCo's documentation.
"""

from collections.abc import Mapping
from xml.etree.ElementTree import Comment, Element, SubElement

import numpy as np

from lamc.basics._version import __version__
from lamc.basics.errors import UnsupportedError
from lamc.basics.places import located_at
from lamc.effects.engine_loads import Stop
from lamc.export.engine_inertia import freedoms, principal_inertia
from lamc.export.engine_losses import check_losses
from lamc.export.engine_model import EngineJoint, EngineModel, Piece, engine_model
from lamc.export.engine_names import engine_names
from lamc.export.engine_text import filled, names_json, number, rgba, row, xml_text
from lamc.export.folder import quoted
from lamc.export.markdown import markdown
from lamc.export.meshes import body_meshes
from lamc.export.mjcf_scene import add_ground, add_springs, add_start, add_torques, add_welds
from lamc.export.options import ExportOptions
from lamc.mechanism.tree import WORLD
from lamc.records.mechanism import Mechanism
from lamc.records.scene import Scene
from lamc.report.palette import body_colours
from lamc.symbolic.expression import in_python

LEAST = 1e-15  # kg and kg·m²: MuJoCo refuses moving bodies that have no more (mjMINVAL)
SOFTEST = 1e-4  # MuJoCo's smallest impedance (mjMINIMP): a constraint is then a spring and a damper
DRIVEN_BY = ("t", "angle", "rate")  # what a torque's expression may hold besides inputs


def next_step(folder: str, files: Mapping[str, bytes], options: ExportOptions) -> str:
    """Shows it in MuJoCo's viewer."""
    return f"python -m mujoco.viewer --mjcf={quoted(folder, files, '.xml')}"


def files(mechanism: Mechanism, scene: Scene, options: ExportOptions) -> dict[str, bytes]:
    """The model, its meshes, names.json and README.md by relative path.

    Raises UnsupportedError for what MJCF cannot hold (all of it, unless options.lossy) and for bodies too light for
    MuJoCo, and DesignError where the scene does not fit the mechanism.
    """
    with located_at(scene.places):
        model = engine_model(mechanism, scene, options.prefix)
        check_losses("MJCF", model.lost, options)
    _check_inertia(model)
    step = options.step or model.time_step
    origins = {name: model.origin(index) for name, index in model.places.items()}
    meshes = {model.body_names[name]: stl for name, stl in body_meshes(mechanism, origins).items()}
    written: dict[str, bytes] = {f"{model.name}.xml": xml_text(_document(model, step, meshes))}
    written |= {f"meshes/{name}.stl": stl for name, stl in sorted(meshes.items())}
    facts = _facts(model, step)
    if facts["drives"]:
        written["torques.py"] = filled("export/torques.py.j2", model, _torques(model))
    written["names.json"] = names_json(model)
    written["README.md"] = filled("export/mjcf.md.j2", model, facts)
    return written


def _document(model: EngineModel, step: float, meshes: Mapping[str, bytes]) -> Element:
    root = Element("mujoco", model=model.name)
    root.append(Comment(f" Made by lamc {__version__}. SI units, radians. README.md says what is where. "))
    SubElement(root, "compiler", angle="radian", autolimits="true", meshdir="meshes", inertiafromgeom="false")
    option = SubElement(
        root,
        "option",
        timestep=number(step),
        integrator="RK4",
        gravity=row(model.gravity),
        iterations="100",
        tolerance="1e-15",  # the solver then ends at round-off, not at 1e-8 of the scale
        cone="elliptic",
    )
    SubElement(option, "flag", energy="enable", contact="enable" if model.ground else "disable")
    if meshes:
        assets = SubElement(root, "asset")
        for name in sorted(meshes):
            # A sheet may have too little volume for the inertia that MuJoCo works out and does not use here.
            SubElement(assets, "mesh", name=name, file=f"{name}.stl", inertia="shell")
    world = SubElement(root, "worldbody")
    size = model.mechanism.size
    SubElement(
        world,
        "light",
        directional="true",
        pos=row((0.0, 0.0, 10.0 * size)),
        dir="0.2 0.3 -1",
        castshadow="false",
    )
    bodies = {WORLD: world}
    for index, piece in enumerate(model.pieces):
        bodies[index] = _body(bodies[piece.parent], model, index)
    _pictures(bodies, model, meshes)
    add_springs(root, bodies, model)
    if model.ground is not None:
        add_ground(bodies, model, model.ground)
    add_welds(root, model)
    add_torques(root, model)
    add_start(root, model)
    return root


def _body(parent: Element, model: EngineModel, index: int) -> Element:
    piece = model.pieces[index]
    body = SubElement(parent, "body", name=piece.name, pos=row(piece.origin - model.origin(piece.parent)))
    # Not `fullinertia`, which MuJoCo itself turns to principal axes: in 3.3 only to 1e-8.
    moments, rotation = principal_inertia(piece.inertia)
    inertial = SubElement(
        body, "inertial", pos=row(piece.com), mass=number(piece.mass), diaginertia=row(moments)
    )
    if np.any(rotation[1:]):
        inertial.set("quat", row(rotation))
    if piece.joint is None:
        (name,) = engine_names([f"{piece.name}_free"], reserved=model.joint_names.values())
        SubElement(body, "freejoint", name=name)
    else:
        _hinge(body, piece.joint, _inverse_inertia(model, index))
    return body


def _hinge(body: Element, hinge: EngineJoint, inverse_inertia: float) -> None:
    loads = hinge.loads
    joint = SubElement(body, "joint", name=hinge.name, type="hinge", axis=row(hinge.axis))
    if loads.stiffness:
        joint.set("stiffness", number(loads.stiffness))
        joint.set("springref", number(loads.rest_angle))
    if loads.damping:
        joint.set("damping", number(loads.damping))
    if loads.stop is not None:
        _stop(joint, loads.stop, inverse_inertia)


def _stop(joint: Element, stop: Stop, inverse_inertia: float) -> None:
    """A stop as a spring and damper. With impedance d the constraint's force at depth r and speed v is
    ((K r + B v) - d a) / (d A + (1 - d) A₀), where solref = (-K, -B), a is the acceleration without it, A = J M⁻¹ Jᵀ
    and A₀ is A as drawn; d → 0 leaves (K r + B v) / A₀."""
    joint.set("range", row(stop.range))
    joint.set("solreflimit", row((-stop.stiffness * inverse_inertia, -stop.damping * inverse_inertia)))
    joint.set("solimplimit", row((SOFTEST, SOFTEST, 1.0)))


def _inverse_inertia(model: EngineModel, index: int) -> float:
    """(M⁻¹)ᵢᵢ of a hinge as drawn, 1/(kg·m²); MuJoCo's dof_invweight0."""
    column = freedoms(model.pieces)[index][0]
    return float(np.linalg.inv(model.mass_matrix)[column, column])


def _pictures(bodies: Mapping[int, Element], model: EngineModel, meshes: Mapping[str, bytes]) -> None:
    """The bodies' shapes, which touch nothing."""
    colours = body_colours(model.mechanism)
    for name, index in model.places.items():
        made = model.body_names[name]
        if made in meshes:
            SubElement(
                bodies[index],
                "geom",
                name=made,
                type="mesh",
                mesh=made,
                rgba=rgba(colours[name]),
                contype="0",
                conaffinity="0",
                group="1",
            )


def _check_inertia(model: EngineModel) -> None:
    for piece in model.pieces:
        least = min(piece.mass, float(np.linalg.eigvalsh(piece.inertia)[0]))
        if least <= LEAST:
            raise UnsupportedError(
                f"body {piece.body!r} has {_part(piece)}a mass of {piece.mass:.3g} kg and a principal moment of "
                f"{np.linalg.eigvalsh(piece.inertia)[0]:.3g} kg·m², and MuJoCo takes moving bodies above {LEAST:g} of "
                "either only: make it heavier, or fix it"
            )


def _part(piece: Piece) -> str:
    return "in a part that is cut off for a loop " if piece.welded is not None else ""


def _torques(model: EngineModel) -> dict[str, object]:
    """Torques that are expressions: place in ctrl, of the angle in qpos and of the rate in qvel, and Python's text; and
    the inputs that they hold."""
    floats = model.base is not None
    actuators = [hinge for hinge in model.hinges if hinge.loads.has_torque]
    drives = [
        (
            actuators.index(hinge),
            place + 7 * floats,
            place + 6 * floats,
            in_python(hinge.loads.drive, DRIVEN_BY),
        )
        for place, hinge in enumerate(model.hinges)
        if hinge.loads.drive is not None
    ]
    inputs = [(name, number(value)) for name, value in model.inputs.items()]
    return {
        "drives": drives,
        "inputs": [each for each in inputs if any(f'"{each[0]}"' in d[-1] for d in drives)],
    }


def _facts(model: EngineModel, step: float) -> dict[str, object]:
    """What the README says of this model."""
    floats = model.base is not None
    joints = [
        (h.name, markdown(h.joint.name), k + 7 * floats, k + 6 * floats) for k, h in enumerate(model.hinges)
    ]
    return {
        "floats": floats,
        "joints": joints,
        "cuts": [markdown(name) for name in model.cuts],
        "drives": [(h.name, markdown(h.loads.drive)) for h in model.hinges if h.loads.drive is not None],
        "outside": [h.name for h in model.hinges if h.loads.outside],
        "torques": [h.name for h in model.hinges if h.loads.has_torque],
        "stops": any(h.loads.stop is not None for h in model.hinges),
        "ground": model.ground is not None,
        "lost": [markdown(loss.what) for loss in model.lost],
        "step": number(step),
    }
