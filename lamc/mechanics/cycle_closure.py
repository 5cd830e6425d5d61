"""Closure of short cycles, staged: what holds a way over hinges together with itself.

Goes in: a `Cycle`, angles and rates of all joints. Comes out: equations that know the cycle's own joints only.

A cycle is followed from its first body both ways to a middle one, by products of exponentials of the joints' screws as
drawn, in the cycle's frame (R. W. Brockett, 1984; A. Müller, "Screw and Lie group theory in multibody kinematics",
2018). Both ways must come to the same place. No frame of the tree takes part, so that nothing depends on which hinges
are cut, and angles that are small keep their digits: components that vanish where the cycle lies flat are sums of
products of sines, never differences of numbers near one.

Rotations are in rad; displacements are those of what is at the cycle's centre, in units of the mechanism's size.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from lamc.loops.cycles import Cycle
from lamc.mechanism.rotations import snap
from lamc.records.mechanism import Array, Joint
from lamc.symbolic.algebra import ZERO, Vector3, add, cross, scale
from lamc.symbolic.scalars import Scalar, Value, cos, reciprocal, sin
from lamc.symbolic.staging import Store

Quaternion = tuple[Scalar, Scalar, Scalar, Scalar]
Rows = tuple[Vector3, Vector3, Vector3]
Screw = tuple[Vector3, Vector3]

UNIT: Rows = ((1, 0, 0), (0, 1, 0), (0, 0, 1))


ROUND_OFF = 1e-14  # of a direction, or of an arm in sizes: cycles that are nearer are drawn alike


class Shapes:
    """Numbers of cycles as scalars of a store. A cycle that is drawn as an earlier one but for round-off takes all its
    numbers: vertices alike have equations alike, and code that repeats is one kernel."""

    def __init__(self, store: Store) -> None:
        self._store = store
        self._known: dict[bytes, Array] = {}

    def taken(self, lines: Array) -> Array:
        """Axes and arms (k, 6) of a cycle, or those of an earlier one that is alike."""
        coarse = np.round(lines / (1e5 * ROUND_OFF)) + 0.0
        known = self._known.setdefault(coarse.tobytes(), lines)
        return known if np.abs(known - lines).max() <= ROUND_OFF else lines

    def __call__(self, values: Array) -> Vector3:
        """Three of them; round-off of a turn into the cycle's frame is none of it."""
        x, y, z = (self._store.constant(float(v)) for v in snap(np.asarray(values), 1.0))
        return (x, y, z)


@dataclass(frozen=True)
class CycleClosure:
    """Equations of one cycle, d(residual)/dt = J u and its rate J u̇ + bias where it closes; at most six.

    jacobian  row by row: (joint, ∂/∂q) of the joints whose entry is not zero
    """

    residual: tuple[Scalar, ...]
    jacobian: tuple[tuple[tuple[int, Scalar], ...], ...]
    bias: tuple[Scalar, ...]


@dataclass(frozen=True)
class _Line:
    """A joint as it is passed: numbers of its screw as drawn, in the cycle's frame. axis unit; arm in sizes."""

    joint: int
    axis: Array
    arm: Array


def close_cycle(
    shapes: Shapes,
    cycle: Cycle,
    joints: Sequence[Joint],
    size: float,
    q: Sequence[Value],
    u: Sequence[Value],
) -> CycleClosure:
    """Equations of `cycle` that depend on its angles. joints, q, u: of all joints, as `Cycle.joints` counts them."""
    forth, back = _both_ways(shapes, cycle, joints, size)
    ahead, behind = _screws(shapes, forth, q), _screws(shapes, back, q)
    entries = {line.joint: screw for line, screw in zip(forth, ahead, strict=True)}
    entries |= {line.joint: (_minus(a), _minus(v)) for line, (a, v) in zip(back, behind, strict=True)}
    rates = [u[line.joint] for line in forth], [u[line.joint] for line in back]
    bias = _difference(_bias(ahead, rates[0]), _bias(behind, rates[1]))
    gap = _gap(_place(shapes, forth, q), _place(shapes, back, q))
    rows = [
        (gap[half][k], row, bias[half][k])
        for half in (0, 1)
        for k in range(3)
        if (row := tuple((joint, s[half][k]) for joint, s in entries.items() if _is_there(s[half][k])))
    ]
    return CycleClosure(tuple(r[0] for r in rows), tuple(r[1] for r in rows), tuple(r[2] for r in rows))


def _both_ways(
    shapes: Shapes, cycle: Cycle, joints: Sequence[Joint], size: float
) -> tuple[list[_Line], list[_Line]]:
    """The lines of the cycle from its first body to a middle one: forwards, and the other way round."""
    drawn = np.empty((len(cycle.joints), 6))
    for row, index, sign in zip(drawn, cycle.joints, cycle.signs, strict=True):
        row[:3] = snap(cycle.frame.T @ (sign * joints[index].axis), 1.0)
        arm = snap(cycle.frame.T @ (joints[index].point - cycle.centre) / size, 1.0)
        row[3:] = snap(arm - (arm @ row[:3]) * row[:3], 1.0)
    numbers = shapes.taken(drawn)
    lines = [_Line(index, row[:3], row[3:]) for index, row in zip(cycle.joints, numbers, strict=True)]
    half = len(lines) // 2
    return lines[:half], [_Line(line.joint, -line.axis, line.arm) for line in reversed(lines[half:])]


def _screws(shapes: Shapes, lines: Sequence[_Line], q: Sequence[Value]) -> list[Screw]:
    """Where the lines are: direction, and velocity per rad/s of what is at the centre."""
    rotation, shift = UNIT, ZERO
    screws: list[Screw] = []
    for position, line in enumerate(lines):
        axis = _apply(rotation, shapes(line.axis))
        moment = _apply(rotation, shapes(np.cross(line.arm, line.axis)))
        screws.append((axis, add(moment, cross(shift, axis))))
        if position + 1 < len(lines):
            sine, versine = sin(q[line.joint]), 1 - cos(q[line.joint])
            shift = add(shift, _apply(rotation, _displacement(shapes, line, sine, versine)))
            rotation = _times(rotation, _turn(shapes, line, sine, versine))
    return screws


def _bias(screws: Sequence[Screw], rates: Sequence[Value]) -> Screw:
    """Acceleration of the end of a chain where its joints' rates are constant: Σ of the brackets of its screws."""
    spin, velocity = ZERO, ZERO
    turning, moving = ZERO, ZERO
    for (axis, moment), rate in zip(screws, rates, strict=True):
        w, v = scale(rate, axis), scale(rate, moment)
        turning = add(turning, cross(spin, w))
        moving = add(moving, add(cross(spin, v), cross(velocity, w)))
        spin, velocity = add(spin, w), add(velocity, v)
    return turning, moving


def _place(shapes: Shapes, lines: Sequence[_Line], q: Sequence[Value]) -> tuple[Quaternion, Vector3]:
    """The end of a chain: its rotation, and where it carries what is drawn at the centre. By half angles: what is
    small of second order has all its digits."""
    rotated: Quaternion = (1, 0, 0, 0)
    shift = ZERO
    for line in lines:
        half = 0.5 * q[line.joint]
        sine, cosine = sin(half), cos(half)
        step = _displacement(shapes, line, 2 * (sine * cosine), 2 * (sine * sine))
        shift = add(shift, add(step, _moved(rotated, step)))
        x, y, z = shapes(line.axis)
        rotated = _product(rotated, (cosine, sine * x, sine * y, sine * z))
    return rotated, shift


def _gap(ahead: tuple[Quaternion, Vector3], behind: tuple[Quaternion, Vector3]) -> Screw:
    """By how much the first place is away from the second, as a small screw; exact where they are one."""
    (w, x, y, z), other = ahead[0], behind[0]
    scalar, *vector = _product((w, x, y, z), (other[0], -other[1], -other[2], -other[3]))
    turn = scale(2 * reciprocal(scalar), (vector[0], vector[1], vector[2]))
    apart = add(ahead[1], _minus(behind[1]))
    return turn, add(apart, cross(behind[1], turn))


def _displacement(shapes: Shapes, line: _Line, sine: Scalar, versine: Scalar) -> Vector3:
    """Where a turn about a line carries the centre: (I - E) arm, with the arm across the axis."""
    across = np.cross(line.axis, line.arm)
    return add(scale(-sine, shapes(across)), scale(versine, shapes(line.arm)))


def _turn(shapes: Shapes, line: _Line, sine: Scalar, versine: Scalar) -> Rows:
    """Rodrigues' rotation about an axis of the drawing."""
    x, y, z = line.axis
    skew = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    square = skew @ skew
    rows = [
        [UNIT[a][b] + sine * k + versine * kk for b, (k, kk) in enumerate(zip(*pair, strict=True))]
        for a, pair in enumerate(zip((shapes(r) for r in skew), (shapes(r) for r in square), strict=True))
    ]
    return _rows(rows)


def _moved(rotated: Quaternion, v: Vector3) -> Vector3:
    """R v - v of a unit quaternion."""
    w, axis = rotated[0], (rotated[1], rotated[2], rotated[3])
    once = scale(2, cross(axis, v))
    return add(scale(w, once), cross(axis, once))


def _product(a: Quaternion, b: Quaternion) -> Quaternion:
    u, v = (a[1], a[2], a[3]), (b[1], b[2], b[3])
    x, y, z = add(add(scale(a[0], v), scale(b[0], u)), cross(u, v))
    return (a[0] * b[0] - (u[0] * v[0] + u[1] * v[1] + u[2] * v[2]), x, y, z)


def _apply(rows: Rows, v: Vector3) -> Vector3:
    x, y, z = (row[0] * v[0] + row[1] * v[1] + row[2] * v[2] for row in rows)
    return (x, y, z)


def _times(a: Rows, b: Rows) -> Rows:
    columns = [_apply(a, (b[0][k], b[1][k], b[2][k])) for k in range(3)]
    return _rows([[columns[k][row] for k in range(3)] for row in range(3)])


def _rows(rows: Sequence[Sequence[Scalar]]) -> Rows:
    a, b, c = ((row[0], row[1], row[2]) for row in rows)
    return (a, b, c)


def _difference(a: Screw, b: Screw) -> Screw:
    return add(a[0], _minus(b[0])), add(a[1], _minus(b[1]))


def _minus(v: Vector3) -> Vector3:
    return (-v[0], -v[1], -v[2])


def _is_there(entry: Scalar) -> bool:
    return isinstance(entry, Value) or entry != 0
