"""What lamc reads in a drawing that it wrote, beside the sheet that was drawn.

In: the sheet's mechanism, the drawing, options that say what it does not. Out: what differs, in words; nothing where it
is the same device. Never: compares names, or how high a sheet lies.
"""

import warnings
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import shapely
from scipy.spatial import cKDTree

from lamc.basics.errors import DesignError, DesignWarning
from lamc.readers.drawings.reading import drawing_in
from lamc.readers.drawings.sheet import sheet_of
from lamc.readers.fold import read_fold
from lamc.readers.inert import DEFAULT_LIMITS
from lamc.records.card import SheetOptions
from lamc.records.mechanism import Array, Joint, Mechanism
from lamc.records.network import listed_names
from lamc.records.scene import Scene

_NEAR = 1e-7  # of the size: places of one body; a drawing has ten digits
_SAME = 1e-8  # of masses, stiffnesses and angles, likewise


def differences(
    drawn: Mechanism, content: bytes, suffix: str, options: SheetOptions, corner: Array
) -> list[str]:
    """corner: (2,), m, from which places of the drawing count."""
    file = f"drawing{suffix}"
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DesignWarning)
        try:
            drawing = drawing_in(content, file, options, DEFAULT_LIMITS)
            assert drawing is not None  # it was written as one
            found = sheet_of(drawing, replace(options, large=True))
        except DesignError as error:
            return [f"the device: lamc does not read the drawing: {error.message}"]
    return [*_unlike(drawn, found, corner), *_of_scene(drawn.scene or Scene(), found.scene or Scene())]


def reversed_hinges(drawn: Mechanism, content: bytes) -> list[str]:
    """That hinges' angles have the other sign where lamc reads a FOLD file, or that it does not read it, in words."""
    options = SheetOptions(large=True, facets="rigid")  # names and axes are the same, and found soon
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DesignWarning)
        try:
            found = read_fold(content.decode(), "sheet.fold", options, DEFAULT_LIMITS)
        except DesignError as error:
            return [f"the device: lamc does not read the file: {error.message}"]
    of = {body.name: body.name for body in drawn.bodies}
    twins = {joint.name: joint for joint in found.joints}
    turned = [j.name for j in drawn.joints if j.name in twins and _sense(j, twins[j.name], of) < 0.0]
    return [f"which way hinges turn that turn the other way there: {listed_names(turned)}"] if turned else []


def _of_scene(drawn: Scene, found: Scene) -> list[str]:
    one, other = drawn.closure_tolerance, found.closure_tolerance
    # Readers set it by the sheet's size where nobody says another.
    if one is None or (other is not None and not _differ(one, other)):
        drawn = replace(drawn, closure_tolerance=other)
    if drawn == found:
        return []
    starts = any(drawn.angles.values())
    return [f"its scene{', and with it the angles at which it starts: it lies flat' if starts else ''}"]


def _unlike(drawn: Mechanism, found: Mechanism, corner: Array) -> list[str]:
    counts = [
        f"{what}: {len(one)} were drawn, and {len(other)} are read"
        for what, one, other in (
            ("bodies", drawn.bodies, found.bodies),
            ("hinges", drawn.joints, found.joints),
        )
        if len(one) != len(other)
    ]
    if counts:
        return counts
    ours, theirs = _places(drawn, np.zeros(2)), _places(found, corner)
    _, nearest = cKDTree(theirs).query(ours)
    apart = np.abs(theirs[nearest] - ours).max()
    if apart > _NEAR * drawn.size or len(set(nearest.tolist())) < len(theirs):
        return ["where its bodies are"]
    twins = [found.bodies[k] for k in nearest.tolist()]
    of = {body.name: twin.name for body, twin in zip(drawn.bodies, twins, strict=True)}
    moving = [(body, twin) for body, twin in zip(drawn.bodies, twins, strict=True) if not body.fixed]
    unlike = [body.name for body, twin in moving if _differ(body.mass, twin.mass)]
    lost = [f"masses of {listed_names(unlike)}"] if unlike else []
    held = [b.name for b, twin in zip(drawn.bodies, twins, strict=True) if b.fixed and not twin.fixed]
    if held:
        lost.append(f"that the world holds {listed_names(held)}: --fixed holds one body")
    between: dict[frozenset[str], list[Joint]] = {}
    for joint in found.joints:
        between.setdefault(frozenset((joint.parent, joint.child)), []).append(joint)
    pairs = [(joint, _twin(joint, of, between, corner)) for joint in drawn.joints]
    astray = [joint.name for joint, twin in pairs if twin is None or _is_off(joint, twin, corner, drawn.size)]
    if astray:
        return [*lost, f"where hinges are ({listed_names(astray)})"]
    checks: tuple[tuple[str, Callable[[Joint, Joint], bool]], ...] = (
        ("stiffnesses", lambda one, other: _differ(one.stiffness, other.stiffness)),
        ("damping", lambda one, other: _differ(one.damping, other.damping)),
        (
            "rest angles",
            lambda one, other: _differ(one.rest_angle, _sense(one, other, of) * other.rest_angle, 1.0),
        ),
    )
    for what, is_other in checks:
        names = [joint.name for joint, twin in pairs if twin is not None and is_other(joint, twin)]
        if names:
            lost.append(f"{what} of hinges ({listed_names(names)})")
    return lost


def _places(mechanism: Mechanism, corner: Array) -> Array:
    """Of bodies (n, 6), m: the centre of what is drawn of each, and the box around it; rings about one another share a
    centre, halves of a square a box."""
    found = []
    for body in mechanism.bodies:
        shapes = [slab.polygon for slab in body.outline] or [shapely.Point(body.com[:2])]
        whole = shapely.GeometryCollection(shapes)
        found.append([*whole.centroid.coords[0], *whole.bounds])
    return np.array(found) + np.tile(corner, 3)


def _twin(
    joint: Joint, of: dict[str, str], between: dict[frozenset[str], list[Joint]], corner: Array
) -> Joint | None:
    """The hinge of the same two bodies whose line is nearest."""
    found = between.get(frozenset((of[joint.parent], of[joint.child])), [])
    return min(found, key=lambda other: _gap(joint, other, corner), default=None)


def _gap(one: Joint, other: Joint, corner: Array) -> float:
    """From a point of a hinge's line to another's, m, as seen from above."""
    x, y = other.point[:2] + corner - one.point[:2]
    return float(abs(x * one.axis[1] - y * one.axis[0]))


def _is_off(one: Joint, other: Joint, corner: Array, size: float) -> bool:
    turned = one.axis[0] * other.axis[1] - one.axis[1] * other.axis[0]
    return bool(abs(turned) > _NEAR or _gap(one, other, corner) > _NEAR * size)


def _sense(one: Joint, other: Joint, of: dict[str, str]) -> float:
    """1 where the same fold has the same sign in both, else -1."""
    is_along = float(one.axis @ other.axis) > 0.0
    return 1.0 if is_along == (of[one.parent] == other.parent) else -1.0


def _differ(one: float, other: float, scale: float = 0.0) -> bool:
    return abs(one - other) > _SAME * max(abs(one), abs(other), scale)
