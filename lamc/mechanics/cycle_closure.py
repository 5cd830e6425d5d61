"""Closure of short cycles, staged: what holds a way over hinges together with itself.

Goes in: a `Cycle`, angles and rates of all joints. Comes out: equations that know the cycle's own joints only.

A cycle is followed from its first body both ways to a middle one, by products of exponentials of the joints' screws as
drawn, in the cycle's frame (R. W. Brockett, 1984; A. Müller, "Screw and Lie group theory in multibody kinematics",
2018). Both ways must come to the same place. No frame of the tree takes part, so that nothing depends on which hinges
are cut, and angles that are small keep their digits: components that vanish where the cycle lies flat are sums of
products of sines, never differences of numbers near one.

Rotations are in rad; displacements are those of what is at the cycle's centre, in units of the mechanism's size.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import islice

import numpy as np

from lamc.loops.cycles import Cycle
from lamc.mechanics.drawn import keyed
from lamc.mechanism.rotations import snap
from lamc.records.mechanism import Array, Joint
from lamc.symbolic.algebra import ZERO, Vector3, add, cross, scale
from lamc.symbolic.scalars import Scalar, Value, cos, reciprocal, sin
from lamc.symbolic.staging import DrawnKey, Store

Quaternion = tuple[Scalar, Scalar, Scalar, Scalar]
Rows = tuple[Vector3, Vector3, Vector3]
Screw = tuple[Vector3, Vector3]

UNIT: Rows = ((1, 0, 0), (0, 1, 0), (0, 0, 1))


ROUND_OFF = 1e-14  # of a direction, or of an arm in sizes: cycles that are nearer are drawn alike


@dataclass(frozen=True)
class Line:
    """A joint as it is passed: its screw as drawn, in the cycle's frame.

    joint    index as `Cycle.joints` counts them
    key      what it is of the drawing: the cycle whose numbers are taken, and the place in its ring
    numbers  by their kinds, of which equations are written: "axis" (3,), unit; "arm" (3,), from the cycle's centre,
             across the axis, in sizes; "moment" and "across", (3,), arm × axis and axis × arm; "skew" (9,) and "square"
             (9,), by rows: the matrix that multiplies crosswise by the axis, and its square
    """

    joint: int
    key: DrawnKey
    numbers: Mapping[str, Sequence[float]]


def _line_numbers(axes: Array, arms: Array) -> list[Mapping[str, Sequence[float]]]:
    """`Line.numbers` of lines (k, 3) and (k, 3); round-off of a turn into the cycle's frame is none of it, be they
    nought or one."""
    x, y, z = axes.T
    nought = np.zeros(len(axes))
    skew = np.stack([nought, -z, y, z, nought, -x, -y, x, nought], axis=1).reshape(-1, 3, 3)
    square = skew @ skew
    moment, across = _crossed(arms, axes), _crossed(axes, arms)
    values = np.hstack([axes, arms, moment, across, skew.reshape(-1, 9), square.reshape(-1, 9)])
    values = snap(values, 1.0)
    one = np.abs(np.abs(values) - 1.0) <= ROUND_OFF
    rows = np.where(one, np.sign(values), values).tolist()
    return [{kind: row[part] for kind, part in _PARTS.items()} for row in rows]


_PARTS = {
    "axis": slice(0, 3),
    "arm": slice(3, 6),
    "moment": slice(6, 9),
    "across": slice(9, 12),
    "skew": slice(12, 21),
    "square": slice(21, 30),
}


def _crossed(a: Array, b: Array) -> Array:
    """a × b of rows (k, 3)."""
    return a[:, [1, 2, 0]] * b[:, [2, 0, 1]] - a[:, [2, 0, 1]] * b[:, [1, 2, 0]]


class Shapes:
    """Numbers of cycles as scalars of a store. A cycle that is drawn as an earlier one but for round-off takes all its
    numbers, so that they are equal as far as they go: sheets have thousands of vertices and few shapes."""

    def __init__(self, store: Store) -> None:
        self._store = store

    def __call__(self, kind: str, line: Line) -> Vector3:
        """Three of them; see `Line`."""
        x, y, z = self.all(kind, line)
        return (x, y, z)

    def step(self) -> None:
        """What follows is done for another line."""
        self._store.step += 1

    def all(self, kind: str, line: Line) -> tuple[Scalar, ...]:
        return keyed(self._store, (kind, *line.key), line.numbers[kind])


def lines_of(cycles: Sequence[Cycle], joints: Sequence[Joint], size: float) -> list[list[Line]]:
    """The lines of each cycle in the order of its ring, those of its second half as they are passed backwards."""
    known: dict[bytes, tuple[int, Array]] = {}
    passed: list[tuple[int, DrawnKey]] = []
    rows: list[Array] = []
    for number, cycle in enumerate(cycles):
        numbers = _drawn(cycle, joints, size)
        coarse = np.round(numbers / (1e5 * ROUND_OFF)) + 0.0
        first, usual = known.setdefault(coarse.tobytes(), (number, numbers))
        if np.abs(usual - numbers).max() <= ROUND_OFF:
            number, numbers = first, usual
        numbers = numbers.copy()
        numbers[len(cycle.joints) // 2 :, :3] *= -1.0
        passed += [(joint, (number, place)) for place, joint in enumerate(cycle.joints)]
        rows.append(numbers)
    drawn = np.concatenate([np.zeros((0, 6)), *rows])
    each = zip(passed, _line_numbers(drawn[:, :3], drawn[:, 3:]), strict=True)
    lines = iter([Line(joint, key, numbers) for (joint, key), numbers in each])
    return [list(islice(lines, len(cycle.joints))) for cycle in cycles]


def _drawn(cycle: Cycle, joints: Sequence[Joint], size: float) -> Array:
    """Axes and arms (k, 6) of a cycle's joints."""
    frame, of = cycle.frame.T, [joints[index] for index in cycle.joints]
    drawn = np.empty((2, len(of), 3))
    for k, (joint, sign) in enumerate(zip(of, cycle.signs, strict=True)):
        drawn[0, k] = frame @ (sign * joint.axis)
        drawn[1, k] = frame @ (joint.point - cycle.centre) / size
    axes, arms = snap(drawn, 1.0)
    along = np.array([arm @ axis for arm, axis in zip(arms, axes, strict=True)])
    return np.concatenate([axes, snap(arms - along[:, None] * axes, 1.0)], axis=1)


def line_numbers(lines: Sequence[Sequence[Line]]) -> Iterator[tuple[DrawnKey, float]]:
    """All that equations may hold of the lines of cycles, keys with values."""
    told: set[DrawnKey] = set()
    for line in (line for ring in lines for line in ring):
        if line.key not in told:
            told.add(line.key)
            for kind, values in line.numbers.items():
                for place, value in enumerate(values):
                    yield (kind, *line.key, place), value


@dataclass(frozen=True)
class CycleClosure:
    """Equations of one cycle, d(residual)/dt = J u and its rate J u̇ + bias where it closes; at most six.

    jacobian  row by row: (joint, ∂/∂q) of the joints whose entry is not zero
    """

    residual: tuple[Scalar, ...]
    jacobian: tuple[tuple[tuple[int, Scalar], ...], ...]
    bias: tuple[Scalar, ...]


def close_cycle(shapes: Shapes, ring: Sequence[Line], q: Sequence[Value], u: Sequence[Value]) -> CycleClosure:
    """Equations of a cycle of these lines that depend on its angles. q, u: of all joints, as `Line.joint` counts."""
    half = len(ring) // 2
    forth, back = ring[:half], ring[half:][::-1]
    ahead, behind = _screws(shapes, forth, q), _screws(shapes, back, q)
    entries = {line.joint: screw for line, screw in zip(forth, ahead, strict=True)}
    entries |= {line.joint: (_minus(a), _minus(v)) for line, (a, v) in zip(back, behind, strict=True)}
    rates = [u[line.joint] for line in forth], [u[line.joint] for line in back]
    bias = _difference(_bias(shapes, ahead, rates[0]), _bias(shapes, behind, rates[1]))
    gap = _gap(shapes, _place(shapes, forth, q), _place(shapes, back, q))
    rows = [
        (gap[half][k], row, bias[half][k])
        for half in (0, 1)
        for k in range(3)
        if (row := tuple((joint, s[half][k]) for joint, s in entries.items() if _is_there(s[half][k])))
    ]
    return CycleClosure(tuple(r[0] for r in rows), tuple(r[1] for r in rows), tuple(r[2] for r in rows))


def _screws(shapes: Shapes, lines: Sequence[Line], q: Sequence[Value]) -> list[Screw]:
    """Where the lines are: direction, and velocity per rad/s of what is at the centre."""
    rotation, shift = UNIT, ZERO
    screws: list[Screw] = []
    for position, line in enumerate(lines):
        shapes.step()
        axis = _apply(rotation, shapes("axis", line))
        moment = _apply(rotation, shapes("moment", line))
        screws.append((axis, add(moment, cross(shift, axis))))
        if position + 1 < len(lines):
            sine, versine = sin(q[line.joint]), 1 - cos(q[line.joint])
            shift = add(shift, _apply(rotation, _displacement(shapes, line, sine, versine)))
            rotation = _times(rotation, _turn(shapes, line, sine, versine))
    return screws


def _bias(shapes: Shapes, screws: Sequence[Screw], rates: Sequence[Value]) -> Screw:
    """Acceleration of the end of a chain where its joints' rates are constant: Σ of the brackets of its screws."""
    spin, velocity = ZERO, ZERO
    turning, moving = ZERO, ZERO
    for (axis, moment), rate in zip(screws, rates, strict=True):
        shapes.step()
        w, v = scale(rate, axis), scale(rate, moment)
        turning = add(turning, cross(spin, w))
        moving = add(moving, add(cross(spin, v), cross(velocity, w)))
        spin, velocity = add(spin, w), add(velocity, v)
    return turning, moving


def _place(shapes: Shapes, lines: Sequence[Line], q: Sequence[Value]) -> tuple[Quaternion, Vector3]:
    """The end of a chain: its rotation, and where it carries what is drawn at the centre. By half angles: what is
    small of second order has all its digits."""
    rotated: Quaternion = (1, 0, 0, 0)
    shift = ZERO
    for line in lines:
        shapes.step()
        half = 0.5 * q[line.joint]
        sine, cosine = sin(half), cos(half)
        step = _displacement(shapes, line, 2 * (sine * cosine), 2 * (sine * sine))
        shift = add(shift, add(step, _moved(rotated, step)))
        x, y, z = shapes("axis", line)
        rotated = _product(rotated, (cosine, sine * x, sine * y, sine * z))
    return rotated, shift


def _gap(shapes: Shapes, ahead: tuple[Quaternion, Vector3], behind: tuple[Quaternion, Vector3]) -> Screw:
    """By how much the first place is away from the second, as a small screw; exact where they are one."""
    shapes.step()
    (w, x, y, z), other = ahead[0], behind[0]
    scalar, *vector = _product((w, x, y, z), (other[0], -other[1], -other[2], -other[3]))
    turn = scale(2 * reciprocal(scalar), (vector[0], vector[1], vector[2]))
    apart = add(ahead[1], _minus(behind[1]))
    return turn, add(apart, cross(behind[1], turn))


def _displacement(shapes: Shapes, line: Line, sine: Scalar, versine: Scalar) -> Vector3:
    """Where a turn about a line carries the centre: (I - E) arm, with the arm across the axis."""
    return add(scale(-sine, shapes("across", line)), scale(versine, shapes("arm", line)))


def _turn(shapes: Shapes, line: Line, sine: Scalar, versine: Scalar) -> Rows:
    """Rodrigues' rotation about an axis of the drawing."""
    both = zip(shapes.all("skew", line), shapes.all("square", line), strict=True)
    flat = [UNIT[n // 3][n % 3] + sine * k + versine * kk for n, (k, kk) in enumerate(both)]
    return _rows([flat[:3], flat[3:6], flat[6:]])


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
