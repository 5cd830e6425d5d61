"""URDF: links, hinges and inertia of a mechanism without loops, as ROS and many engines read it.

In: a mechanism and a scene. Out: files by their relative path; the folder is a ROS package. Never: closes a loop, or
leaves out a force without being asked.

URDF knows bodies, hinges, viscous damping and limits. It has no springs, torques, gravity, ground or start.
"""

import shlex
from collections.abc import Mapping
from xml.etree.ElementTree import Comment, Element, SubElement

from lamc.basics._version import __version__
from lamc.basics.errors import TopologyError
from lamc.basics.places import located_at
from lamc.effects.engine_loads import Loss
from lamc.export.engine_losses import check_losses
from lamc.export.engine_model import EngineJoint, EngineModel, Piece, engine_model
from lamc.export.engine_names import engine_names
from lamc.export.engine_text import filled, names_json, number, rgba, row, xml_text
from lamc.export.markdown import markdown
from lamc.export.meshes import body_meshes
from lamc.export.options import ExportOptions
from lamc.mechanism.tree import WORLD
from lamc.records.mechanism import Array, Mechanism
from lamc.records.network import listed_names
from lamc.records.scene import Scene
from lamc.report.palette import body_colours

EFFORT, VELOCITY = 1e6, 1e6  # N·m and rad/s: URDF asks for a bound of either, and a mechanism has none


def next_step(folder: str, files: Mapping[str, bytes], options: ExportOptions) -> str:
    """Builds the ROS package."""
    return f"colcon build --paths {shlex.quote(folder)}"


def files(mechanism: Mechanism, scene: Scene, options: ExportOptions) -> dict[str, bytes]:
    """The model, its meshes, package.xml, CMakeLists.txt, names.json and README.md by relative path.

    Raises TopologyError for loops, UnsupportedError for what URDF cannot hold (all of it, unless options.lossy), and
    DesignError where the scene does not fit the mechanism.
    """
    with located_at(scene.places):
        model = engine_model(mechanism, scene, options.prefix)
        _check_tree(model)
        lost = (*model.lost, *_own_losses(model))
        check_losses("URDF", lost, options, "; MJCF holds springs, torques and the ground: --to mjcf")
    origins = {name: model.origin(index) for name, index in model.places.items()}
    meshes = {model.body_names[name]: stl for name, stl in body_meshes(mechanism, origins).items()}
    package = model.name.lower().replace("-", "_")
    package = package if package[0].isalpha() else f"lamc_{package}"
    written: dict[str, bytes] = {f"{model.name}.urdf": xml_text(_robot(model, meshes, package))}
    written |= {f"meshes/{name}.stl": stl for name, stl in sorted(meshes.items())}
    written["package.xml"] = xml_text(_package(package, model))
    written["CMakeLists.txt"] = filled("export/urdf_cmake.txt.j2", model, {"package": package})
    written["names.json"] = names_json(model)
    written["README.md"] = filled("export/urdf.md.j2", model, _facts(model, package, lost))
    return written


def _check_tree(model: EngineModel) -> None:
    if model.cuts:
        names, count = listed_names([repr(name) for name in model.cuts]), len(model.cuts)
        closing = f"joint {names} closes a loop" if count == 1 else f"joints {names} close {count} loops"
        raise TopologyError(
            f"URDF holds trees only, and {closing}: export to MJCF, which closes loops by welds (--to mjcf), or leave "
            f"{'this joint' if count == 1 else 'these joints'} out of the mechanism"
        )


def _own_losses(model: EngineModel) -> list[Loss]:
    """What acts in the scene and has no place in URDF."""
    lost = []
    for what, among in (
        ("stiffness", [h for h in model.hinges if h.loads.stiffness]),
        ("torque", [h for h in model.hinges if h.loads.has_torque]),
    ):
        if among:
            names = listed_names([repr(h.joint.name) for h in among])
            lost.append(Loss(f"the {what} of hinge{'s' if len(among) > 1 else ''} {names}"))
    lost += [Loss(f"the spring between {s.body_a!r} and {s.body_b!r}") for s in model.springs]
    if model.ground is not None:
        lost.append(Loss("contact with the ground"))
    return lost


def _robot(model: EngineModel, meshes: Mapping[str, bytes], package: str) -> Element:
    robot = Element("robot", name=model.name)
    robot.append(Comment(f" Made by lamc {__version__}. SI units, radians. README.md says what is where. "))
    mechanism = model.mechanism
    links: dict[int, str] = {WORLD: "world"}
    if model.base is None:
        SubElement(robot, "link", name="world")
        fixed = [model.body_names[body.name] for body in mechanism.bodies if body.fixed]
        joints = engine_names([f"{name}_fixed" for name in fixed], reserved=model.joint_names.values())
        for name, joint in zip(fixed, joints, strict=True):
            _fixed(robot, name, joint, meshes, package)
    for index, piece in enumerate(model.pieces):
        links[index] = piece.name
        link = SubElement(robot, "link", name=piece.name)
        _inertial(link, piece)
        for name, place in model.places.items():
            if place == index:
                _visual(link, model.body_names[name], meshes, package)
        if piece.joint is not None:
            _hinge(
                robot, piece.joint, links[piece.parent], piece.name, piece.origin - model.origin(piece.parent)
            )
    colours = body_colours(mechanism)
    for body, made in model.body_names.items():
        if made in meshes:
            material = SubElement(robot, "material", name=f"{made}_colour")
            SubElement(material, "color", rgba=rgba(colours[body]))
    return robot


def _fixed(robot: Element, name: str, joint_name: str, meshes: Mapping[str, bytes], package: str) -> None:
    """A body of the world: a link without inertia, which nothing moves."""
    _visual(SubElement(robot, "link", name=name), name, meshes, package)
    joint = SubElement(robot, "joint", name=joint_name, type="fixed")
    SubElement(joint, "parent", link="world")
    SubElement(joint, "child", link=name)


def _inertial(link: Element, piece: Piece) -> None:
    inertial = SubElement(link, "inertial")
    SubElement(inertial, "origin", xyz=row(piece.com), rpy="0 0 0")
    SubElement(inertial, "mass", value=number(piece.mass))
    moments = {f"i{'xyz'[a]}{'xyz'[b]}": number(piece.inertia[a, b]) for a in range(3) for b in range(a, 3)}
    SubElement(inertial, "inertia", moments)


def _visual(link: Element, name: str, meshes: Mapping[str, bytes], package: str) -> None:
    if name in meshes:
        visual = SubElement(link, "visual")
        SubElement(SubElement(visual, "geometry"), "mesh", filename=f"package://{package}/meshes/{name}.stl")
        SubElement(visual, "material", name=f"{name}_colour")


def _hinge(robot: Element, hinge: EngineJoint, parent: str, child: str, place: Array) -> None:
    stop = hinge.loads.stop
    joint = SubElement(robot, "joint", name=hinge.name, type="continuous" if stop is None else "revolute")
    SubElement(joint, "origin", xyz=row(place), rpy="0 0 0")
    SubElement(joint, "parent", link=parent)
    SubElement(joint, "child", link=child)
    SubElement(joint, "axis", xyz=row(hinge.axis))
    bounds = {"effort": number(EFFORT), "velocity": number(VELOCITY)}
    if stop is not None:
        bounds["lower"], bounds["upper"] = map(number, stop.range)
        SubElement(joint, "limit", bounds)
    if hinge.loads.damping:
        SubElement(joint, "dynamics", damping=number(hinge.loads.damping))


def _package(package: str, model: EngineModel) -> Element:
    """package.xml, by which ROS and others find what package:// stands for."""
    root = Element("package", format="3")
    for tag, text in (
        ("name", package),
        ("version", "0.0.1"),
        ("description", f"{model.mechanism.name}, exported by lamc"),
    ):
        SubElement(root, tag).text = text
    SubElement(root, "maintainer", email="nobody@example.com").text = "nobody"
    SubElement(root, "license").text = "that of the design"
    SubElement(root, "buildtool_depend").text = "ament_cmake"
    SubElement(SubElement(root, "export"), "build_type").text = "ament_cmake"
    return root


def _facts(model: EngineModel, package: str, lost: tuple[Loss, ...]) -> dict[str, object]:
    """What the README says of this model."""
    rows = [
        (
            h.name,
            markdown(h.joint.name),
            number(model.angles[h.joint.name]),
            number(model.rates[h.joint.name]),
        )
        for h in model.hinges
    ]
    return {
        "package": package,
        "floats": model.base is not None,
        "base": model.pieces[0].name,
        "joints": rows,
        "gravity": row(model.gravity),
        "stops": any(h.loads.stop is not None for h in model.hinges),
        "lost": [markdown(loss.what) for loss in lost],
    }
