"""What of a motion matters to a scene: its `outputs`.

In: names and points, and a mechanism or a result. Out: an error for what means nothing, or values. A name is a joint's
(its angle, rad), a coordinate's that an effect adds, or a body's with .x, .y or .z (its centre of mass, m, world); an
`OutputPoint` is any point of a rigid body, and three outputs.
"""

from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import dataclass

from lamc.basics.checks import did_you_mean
from lamc.basics.errors import DesignError, about, warn
from lamc.records.mechanism import FAR
from lamc.records.scene import OutputPoint, Scene
from lamc.run.request import Array
from lamc.run.result import Result

_AXES = ("x", "y", "z")


@dataclass(frozen=True, eq=False)
class Output:
    """A quantity over a run. values: shape (m,), in `unit`. point: whose component it is; empty: it stands alone."""

    name: str
    unit: str
    values: Array
    point: str = ""


def check_outputs(
    scene: Scene,
    coordinates: Sequence[str],
    bodies: Sequence[str],
    bending: Callable[[], Collection[str]],
    apart: Callable[[str, Sequence[float]], float],
) -> None:
    """Raises DesignError for an output of the scene that is neither one of the coordinates, among which the joints that
    close loops count here, nor a body's position, nor a point of a rigid body. bending: gives the names of bodies that
    bend; called only if there are points. apart: `Mechanism.apart`; warns of points that lie far aside."""
    for output in scene.outputs or ():
        with about(("outputs", output.name if isinstance(output, OutputPoint) else output)):
            if isinstance(output, OutputPoint):
                _check_point(output, coordinates, bodies, bending, apart)
            elif output not in coordinates and _centre(output, bodies) is None:
                known = [*coordinates, *(f"{body}.{axis}" for body in bodies for axis in _AXES)]
                raise DesignError(
                    f"the scene's output {output[:40]!r} is no coordinate and no body's position; "
                    f"{did_you_mean(output, known)}"
                )


def _check_point(
    output: OutputPoint,
    coordinates: Sequence[str],
    bodies: Sequence[str],
    bending: Callable[[], Collection[str]],
    apart: Callable[[str, Sequence[float]], float],
) -> None:
    what = f"the scene's output point {output.name[:40]!r}"
    if output.body not in bodies:
        hint = did_you_mean(output.body, bodies)
        raise DesignError(f"{what} is of body {output.body[:40]!r}, which is not there; {hint}")
    if output.name in bodies or any(f"{output.name}.{axis}" in coordinates for axis in _AXES):
        raise DesignError(
            f"{what} has the name of something else, so that {output.name[:40]}.x is two things; rename it"
        )
    if output.body in bending():
        raise DesignError(
            f"{what} is of body {output.body!r}, which bends, and only rigid bodies carry their points along exactly; "
            f"take {output.body}.x, .y, .z (its frame), or leave the body out of what bends"
        )
    sizes = apart(output.body, output.point)
    if sizes > FAR:
        warn(
            f"{what} lies {sizes:.3g} times the device's size from the middle of {output.body!r}; are these mm? "
            "numbers without a unit are metres: [30 mm, 0, 0]"
        )


def outputs_of(result: Result, scene: Scene) -> tuple[Output, ...]:
    """The outputs of the scene over the run; all joints where it names none. The scene has passed `check_outputs`."""
    return tuple(
        found for each in scene.outputs or result.joints for found in _of(result, each, result.joints)
    )


def shared_ranges(outputs: Sequence[Output], ranges: Sequence[float], *, chosen: bool) -> list[float]:
    """The range that errors of each output are relative to, in its unit, of their own ranges; 1 for what does not move.

    A chosen output has its own, and the components of a point the largest of them: a tip that moves in a plane has none
    across it. Outputs that nobody chose share the largest of their unit: a hinge that hardly moves need not be known to
    a thousandth of that little.
    """
    keys = [(each.point or each.name) if chosen else each.unit for each in outputs]
    pairs = list(zip(keys, ranges, strict=True))
    return [max(span for other, span in pairs if other == key) or 1.0 for key in keys]


def _of(result: Result, output: str | OutputPoint, joints: Sequence[str]) -> Iterator[Output]:
    if isinstance(output, OutputPoint):
        path = result.point(output.name)
        yield from (Output(f"{output.name}.{a}", "m", path[:, k], output.name) for k, a in enumerate(_AXES))
        return
    yield _output(result, output, joints)


def _output(result: Result, name: str, joints: Sequence[str]) -> Output:
    if name in joints:
        return Output(name, "rad", result.angle(name))
    for coordinate in result.coordinates:
        if coordinate.name == name:
            return Output(name, coordinate.unit, result.coordinate(name))
    point = _centre(name, result.bodies)
    assert point is not None
    body, axis = point
    return Output(name, "m", result.pose(body)[0][:, axis])


def _centre(name: str, bodies: Sequence[str]) -> tuple[str, int] | None:
    """Body and world axis of "BODY.x"; names of bodies may hold dots."""
    body, _, axis = name.rpartition(".")
    return (body, _AXES.index(axis)) if body in bodies and axis in _AXES else None
