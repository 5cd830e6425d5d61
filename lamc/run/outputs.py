"""What of a motion matters to a scene: its `outputs`, by name.

In: names, and a mechanism or a result. Out: an error for a name that means nothing, or values. A name is a joint's (its
angle, rad), a coordinate's that an effect adds, or a body's with .x, .y or .z (its centre of mass, m, world).
"""

from collections.abc import Sequence
from dataclasses import dataclass

from lamc.errors import DesignError, about
from lamc.mechanism.checks import did_you_mean
from lamc.run.request import Array
from lamc.run.result import Result
from lamc.scene import Scene

_AXES = ("x", "y", "z")


@dataclass(frozen=True, eq=False)
class Output:
    """A quantity over a run. values: shape (m,), in `unit`."""

    name: str
    unit: str
    values: Array


def check_outputs(scene: Scene, coordinates: Sequence[str], bodies: Sequence[str]) -> None:
    """Raises DesignError for an output of the scene that is neither one of the coordinates, among which the joints that
    close loops count here, nor a body's position."""
    for name in scene.outputs or ():
        if name not in coordinates and _point(name, bodies) is None:
            known = [*coordinates, *(f"{body}.{axis}" for body in bodies for axis in _AXES)]
            with about(("outputs", name)):
                raise DesignError(
                    f"the scene's output {name[:40]!r} is no coordinate and no body's position; "
                    f"{did_you_mean(name, known)}"
                )


def outputs_of(result: Result, scene: Scene) -> tuple[Output, ...]:
    """The outputs of the scene over the run; all joints where it names none. The scene has passed `check_outputs`."""
    joints = (*result.joints, *result.motion.model.cuts)
    return tuple(_output(result, name, joints) for name in scene.outputs or joints)


def _output(result: Result, name: str, joints: Sequence[str]) -> Output:
    if name in joints:
        return Output(name, "rad", result.angle(name))
    for coordinate in result.coordinates:
        if coordinate.name == name:
            return Output(name, coordinate.unit, result.coordinate(name))
    point = _point(name, result.bodies)
    assert point is not None
    body, axis = point
    return Output(name, "m", result.pose(body)[0][:, axis])


def _point(name: str, bodies: Sequence[str]) -> tuple[str, int] | None:
    """Body and world axis of "BODY.x"; names of bodies may hold dots."""
    body, _, axis = name.rpartition(".")
    return (body, _AXES.index(axis)) if body in bodies and axis in _AXES else None
