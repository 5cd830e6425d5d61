"""Whether the fold of a sheet is over: it lies folded flat, or its facets have gone through one another.

In: a mechanism, the hinges of each of its vertices, the names of its joints in the order of a state. Out: a question to
ask of states, one after the other. Never: knows of contact or of loads; goes by angles alone.
"""

from collections.abc import Callable, Sequence

import numpy as np

from lamc.records.mechanism import Array, Mechanism

NEAR = np.radians(1.0)  # of 0 or a half turn: nearer, loops that pass through it take steps without end
# Beyond a half turn. A facet on a crease of its own that rests at 180°, damped as sheets are, swings 16 % of it beyond,
# 29°, and comes back.
THROUGH = np.radians(30.0)
OPEN = np.radians(10.0)  # from 0 and a half turn: as far a sheet that folds has been, on its way between them
_PARALLEL = 1e-6  # sine of the angle between axes, as drawn


def fold_over(
    mechanism: Mechanism, vertices: Sequence[Sequence[str]], joints: Sequence[str]
) -> Callable[[Array], str] | None:
    """Tells of the states of a run, one after the other, why the fold of a sheet is over, empty where it is not: all
    hinges are within `NEAR` of 0, or of half turns and beyond, some of each vertex at half turns, and some state
    before was `OPEN`; or a hinge of a vertex has gone `THROUGH` beyond a half turn, and was not there at first. Flaps
    on hinges of their own swing as they like. None where that is no sheet's end: without plates at all hinges, or with
    axes that are all parallel, as of planar linkages, which pass such positions in the middle of their motion."""
    has_plates = {body.name: bool(body.outline) for body in mechanism.bodies}
    hinges = mechanism.joints
    if {joint.name for joint in hinges} != set(joints) or not vertices:
        return None
    if not all(has_plates[joint.parent] and has_plates[joint.child] for joint in hinges):
        return None
    axes = np.array([joint.axis for joint in hinges]).reshape(-1, 3)
    if not len(axes) or np.abs(np.cross(axes, axes[0])).max() <= _PARALLEL:
        return None
    return _Fold(vertices, tuple(joints))


class _Fold:
    """Asked of the states of one run. inner: the joints of vertices, without flaps. began: their angles, rad, without
    signs, when it was first asked."""

    def __init__(self, vertices: Sequence[Sequence[str]], joints: tuple[str, ...]) -> None:
        self.joints = joints
        place = {name: index for index, name in enumerate(joints)}
        self.vertices = [np.array([place[name] for name in vertex]) for vertex in vertices]
        self.inner = np.unique(np.concatenate(self.vertices))
        self.was_open = False
        self.began: Array | None = None

    def __call__(self, state: Array) -> str:
        angles = np.abs(state[: len(self.joints)])
        inner = angles[self.inner]
        if self.began is None:
            self.began = inner
        self.was_open = self.was_open or bool(((inner > OPEN) & (inner < np.pi - OPEN)).any())
        if self.was_open and self._is_folded(angles):
            return "it is folded flat: all hinges have come to 0° or ±180°"
        through = (inner > np.pi + THROUGH) & (self.began <= np.pi + THROUGH)
        if not through.any():
            return ""
        farthest = self.joints[self.inner[int(np.argmax(np.where(through, inner, 0.0)))]]
        return f"hinge {farthest!r} is 30° beyond ±180°: facets have gone through one another"

    def _is_folded(self, angles: Array) -> bool:
        is_folded = angles >= np.pi - NEAR
        return bool((is_folded | (angles <= NEAR)).all()) and all(is_folded[v].any() for v in self.vertices)
