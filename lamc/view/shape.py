"""The shape of a mechanism as triangles and lines, for the page's drawing and its kinematics.

In: a `Mechanism`. Out: plain data with arrays, m, as drawn. Never: poses anything.
"""

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
import shapely
from shapely.geometry import Polygon

from lamc.mechanism.plan import plan
from lamc.records.effect import PlaneMark
from lamc.records.mechanism import Array, Mechanism
from lamc.report.palette import body_colours
from lamc.report.solid import Face, Lines, Solid, solid_of


def shape_data(mechanism: Mechanism, marks: Sequence[PlaneMark] = ()) -> dict[str, Any]:
    """Bodies, triangles (n, 3) of points (k, 3) with the body of each triangle (n,), lines, hinges, planes."""
    solid = solid_of(mechanism)
    colours = body_colours(mechanism)
    return {
        "size": solid.size,
        "bodies": [
            {"name": b.name, "fixed": b.fixed, "com": _floats(b.com), "colour": colours[b.name]}
            for b in mechanism.bodies
        ],
        "mesh": _mesh(solid),
        "edges": _lines(solid.edges),
        "sticks": _lines(solid.sticks),
        "hinges": _hinges(solid),
        "planes": [{"point": _floats(m.point), "normal": _floats(m.normal)} for m in marks],
        "tree": _tree(mechanism),
    }


def _floats(values: object) -> list[float]:
    return [float(x) for x in np.asarray(values, dtype=float).ravel()]


def _mesh(solid: Solid) -> dict[str, Any]:
    points: list[Array] = []
    triangles: list[npt.NDArray[np.int64]] = []
    owners: list[int] = []
    count = 0
    for face in solid.faces:
        for corners in _triangulated(face):
            points.append(corners)
            triangles.append(np.arange(count, count + len(corners)).reshape(-1, 3))
            owners += [face.body] * (len(corners) // 3)
            count += len(corners)
    flat = np.concatenate([np.zeros((0, 3)), *points]).astype("f4")
    unique, index = np.unique(flat, axis=0, return_inverse=True)
    order = np.concatenate([np.zeros((0, 3), dtype=int), *triangles]).ravel()
    return {
        "points": unique.ravel(),
        "triangles": index.ravel()[order].astype("u4"),
        "bodies": np.array(owners, dtype="u2"),
    }


def _triangulated(face: Face) -> Iterator[Array]:
    """Corners of triangles (3 k, 3), anticlockwise seen from outside."""
    if len(face.rings) == 1 and len(face.rings[0]) == 4 and face.normal[2] == 0.0:
        a, b, c, d = face.rings[0]
        yield _turned(np.array([a, b, c, a, c, d]), face.normal)
        return
    height = face.rings[0][0][2]
    outer, *inner = ([tuple(p[:2]) for p in ring] for ring in face.rings)
    for triangle in shapely.get_parts(shapely.constrained_delaunay_triangles(Polygon(outer, inner))):
        flat = shapely.get_coordinates(triangle)[:3]
        yield _turned(np.column_stack([flat, np.full(3, height)]), face.normal)


def _turned(corners: Array, normal: Array) -> Array:
    a, b, c = corners[:3]
    if np.cross(b - a, c - a) @ normal >= 0.0:
        return corners
    return corners.reshape(-1, 3, 3)[:, ::-1].reshape(-1, 3)


def _lines(lines: Lines) -> dict[str, Any]:
    return {"points": lines.segments.astype("f4").ravel(), "bodies": lines.bodies.astype("u2")}


def _hinges(solid: Solid) -> list[dict[str, Any]]:
    mechanism = solid.mechanism
    places = {body.name: k for k, body in enumerate(mechanism.bodies)}
    return [
        {
            "name": joint.name,
            "parent": places[joint.parent],
            "child": places[joint.child],
            "ends": _floats(ends),
            "point": _floats(joint.point),
            "axis": _floats(joint.axis),
            "limits": [float(x) for x in joint.limits] if joint.is_limited else None,
            "reach": _reach(mechanism, joint.parent, joint.child, ends),
        }
        for joint, ends in zip(mechanism.joints, solid.hinges.segments, strict=True)
    ]


def _reach(mechanism: Mechanism, parent: str, child: str, ends: Array) -> float:
    """m: how far above the hinge's line the material beside it goes; lines are drawn that much nearer to the eye."""
    heights = [
        max(abs(plate.z_top - z), abs(plate.z_bottom - z))
        for name in (parent, child)
        for plate in mechanism.body(name).outline
        for z in (float(ends[0][2]),)
    ]
    return max(heights, default=0.0)


def _tree(mechanism: Mechanism) -> dict[str, Any]:
    """Joints of the tree, parents first, and those that close loops; indices of joints and bodies of the mechanism.

    sign  +1 where the body farther from the world is the joint's child
    """
    tree = plan(mechanism)
    joints = {joint.name: k for k, joint in enumerate(mechanism.joints)}
    bodies = {body.name: k for k, body in enumerate(mechanism.bodies)}
    return {
        "links": [
            {
                "joint": joints[link.joint.name],
                "body": bodies[link.body.name],
                "inner": bodies[
                    link.joint.parent if link.joint.child == link.body.name else link.joint.child
                ],
                "sign": 1 if link.joint.child == link.body.name else -1,
            }
            for link in tree.links
        ],
        "cuts": [joints[cut.joint.name] for cut in tree.cuts],
    }
