"""The mechanism as drawn, with all that a reader of exported C needs to see: which hinge is which coordinate, and which
way it turns.

In: a `Mechanism` and the order of its coordinates. Out: a PNG. Each hinge has an arrow along its axis, and one around
it that shows how the child turns where the angle grows.
"""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import FancyArrowPatch
from matplotlib.patheffects import withStroke

from lamc.basics.numbers import shortened
from lamc.records.mechanism import Array, Joint, Mechanism
from lamc.report.folded import free_corners, scale_bar, triad
from lamc.report.stage import HINGE, Stage, as_drawn
from lamc.report.style import bytes_of

_LONGEST = 900  # pixels
_WIDTH = 7.0  # inches
_NAMED = 8  # hinges, bodies beyond this are not named
_ARC = np.radians(
    np.linspace(15.0, 130.0, 24)
)  # how far the arrow around a hinge goes, from the child's side on
_INK = f"#{HINGE[0]:02x}{HINGE[1]:02x}{HINGE[2]:02x}"
_HALO = [withStroke(linewidth=3.2, foreground="white")]  # a body may have the ink's colour
_BOX = {"boxstyle": "round,pad=0.15", "facecolor": "white", "alpha": 0.8, "linewidth": 0.0}


def picture_of(mechanism: Mechanism, joints: Sequence[str], moving: Sequence[str]) -> bytes:
    """A PNG of `mechanism` in the position where all angles are zero.

    joints  names in the order of the coordinates
    moving  names of the bodies that move
    """
    stage = Stage(mechanism, as_drawn(mechanism), _LONGEST)
    figure = Figure(figsize=(_WIDTH, _WIDTH * stage.height / stage.width + 0.4), layout="constrained")
    axis = figure.subplots()
    axis.set_axis_off()
    picture = stage.draw(0)
    axis.imshow(picture, interpolation="antialiased")
    corners = free_corners(picture)
    scale_bar(axis, stage, corners[0])
    triad(axis, stage, corners[1])
    labels = {name: f"q[{k}]" for k, name in enumerate(joints)}
    named = len(labels) <= _NAMED
    for joint, segment in zip(mechanism.joints, stage.solid.hinges.segments, strict=True):
        if joint.name in labels:
            label = labels[joint.name] + (f" {shortened(joint.name, 16)}" if named else "")
            _draw_hinge(axis, stage, joint, segment, label)
    if len(mechanism.bodies) <= _NAMED:
        _name_bodies(axis, stage, moving)
    figure.suptitle(
        f"{shortened(mechanism.name, 60)} as drawn: all angles zero", parse_math=False, fontsize=12
    )
    return bytes_of(figure)


def _draw_hinge(axis: Axes, stage: Stage, joint: Joint, segment: Array, label: str) -> None:
    """An arrow along the axis, one around it, and the label at the tip."""
    middle, size = segment.mean(axis=0), stage.solid.size
    half = max(float(np.linalg.norm(segment[1] - segment[0])) / 2, 0.05 * size)
    tip = middle + (half + 0.05 * size) * joint.axis
    _arrow(axis, _seen(stage, np.array([middle - half * joint.axis, tip])))
    out = towards_child(stage.solid.mechanism, joint, middle)
    across = np.cross(joint.axis, out)
    radius = 0.055 * size
    circle = radius * (np.outer(np.cos(_ARC), out) + np.outer(np.sin(_ARC), across))
    _arrow(axis, _seen(stage, middle + 0.4 * half * joint.axis + circle))
    place = _seen(stage, tip[None])[0]
    axis.annotate(
        label,
        (float(place[0]), float(place[1])),
        (4, 4),
        textcoords="offset points",
        fontsize=8.5,
        color="black",
        bbox=_BOX,
        annotation_clip=False,
        parse_math=False,
    )


def towards_child(mechanism: Mechanism, joint: Joint, middle: Array) -> Array:
    """The unit vector across the axis that points to the child's centre of mass; any across it if that lies on it."""
    (child,) = (body for body in mechanism.bodies if body.name == joint.child)
    for along in (child.com - middle, *np.eye(3)):
        across = along - (along @ joint.axis) * joint.axis
        length = float(np.linalg.norm(across))
        if length > 1e-6 * max(1e-300, float(np.linalg.norm(along))):
            return np.asarray(across / length)
    raise AssertionError("two of the three axes are across any line")


def _arrow(axis: Axes, points: Array) -> None:
    """A line through pixels (k, 2), with a head at its end."""
    axis.plot(points[:, 0], points[:, 1], color=_INK, linewidth=1.6, path_effects=_HALO)
    start, end = points[-2], points[-1]
    if np.hypot(*(end - start)) < 1e-6:  # seen from its end
        return
    far = end - start
    start = end - far / np.hypot(*far)
    axis.add_patch(
        FancyArrowPatch(
            (float(start[0]), float(start[1])),
            (float(end[0]), float(end[1])),
            arrowstyle="-|>",
            mutation_scale=11,
            color=_INK,
            path_effects=_HALO,
            zorder=3,
            shrinkA=0,
            shrinkB=0,
            clip_on=False,
        )
    )


def _name_bodies(axis: Axes, stage: Stage, moving: Sequence[str]) -> None:
    for body in stage.solid.mechanism.bodies:
        if body.fixed and not body.outline:
            continue
        points = [p.polygon.representative_point() for p in body.outline[:1]]
        centre = (
            np.array([points[0].x, points[0].y, body.outline[0].z_top]) if points and body.fixed else body.com
        )
        place = _seen(stage, centre[None])[0]
        axis.text(
            float(place[0]),
            float(place[1]),
            shortened(body.name, 16) + ("" if body.name in moving else " (fixed)"),
            fontsize=8,
            ha="center",
            va="center",
            color="#333333",
            bbox=_BOX,
            parse_math=False,
        )


def _seen(stage: Stage, points: Array) -> Array:
    """World points (k, 3), m, as columns and rows of the picture, (k, 2)."""
    x, y, _ = stage.camera.project(points).T
    return np.column_stack([stage.width / 2 + x, stage.height / 2 - y])
