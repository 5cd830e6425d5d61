"""Frames, vectors and differentiable variables, as the paper writes them (eq. 1-14), for systems made by hand.

    system = System()
    q, u, _ = system.coordinate("q")
    link = Frame.turned("link", system.world, axis=(0, 1, 0), angle=q)       # eq. 1-4
    tip = link.vector(1.0, 0, 0)                                             # eq. 7
    velocity = tip.derivative(system.world)                                  # eq. 13-14
    system.show(velocity.dot(system.world.vector(0, 0, 1)))                  # a sympy expression

Scalars are staged: a product of many rotations is a list of short assignments, and never one long expression.
"""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from lamc.basics.errors import DesignError
from lamc.mechanics.placement import rotate, rotate_back
from lamc.symbolic.algebra import ZERO, Matrix3, Vector3, add, cross, dot, scale
from lamc.symbolic.derivative import derivatives
from lamc.symbolic.program import Space
from lamc.symbolic.scalars import Scalar, Value, cos, sin
from lamc.symbolic.staging import Store

if TYPE_CHECKING:
    import sympy as sp

IDENTITY: Matrix3 = ((1, 0, 0), (0, 1, 0), (0, 0, 1))


class System:
    """A store, time, a world frame, and coordinates: chains q → u → u̇ of differentiable variables (eq. 12)."""

    def __init__(self) -> None:
        self.store = Store()
        self.time = self.store.symbol("t", Space.TIME, 0)
        self.angles: list[Value] = []
        self.rates: list[Value] = []
        self.accelerations: list[Value] = []
        self.constants: list[Value] = []
        self.world = Frame("world", self, None, IDENTITY, ZERO)

    def coordinate(self, name: str) -> tuple[Value, Value, Value]:
        """(q, u, u̇): a coordinate and its first two time derivatives."""
        index = len(self.angles)
        self.angles.append(self.store.symbol(name, Space.ANGLE, index))
        self.rates.append(self.store.symbol(f"{name}_d", Space.RATE, index))
        self.accelerations.append(self.store.symbol(f"{name}_dd", Space.RATE, -1 - index))
        return self.angles[-1], self.rates[-1], self.accelerations[-1]

    def constant(self, name: str) -> Value:
        """A symbol that does not change in time, such as a mass or a length."""
        self.constants.append(self.store.symbol(name, Space.PARAMETER, len(self.constants)))
        return self.constants[-1]

    def time_derivatives(self, values: Sequence[Scalar]) -> list[Scalar]:
        """d/dt by the chain rule: q̇ = u, u̇ = u̇, ṫ = 1."""
        speeds: dict[Value, Scalar] = {self.time: 1}
        speeds.update(zip(self.angles, self.rates, strict=True))
        speeds.update(zip(self.rates, self.accelerations, strict=True))
        return derivatives(values, speeds)

    def show(self, value: Scalar) -> "sp.Expr":
        """The value written out as one sympy expression."""
        from lamc.mechanics.sympy_view import expression

        return expression(value, {})

    def stage(self, value: "Scalar | sp.Expr", symbols: Mapping[str, Scalar] | None = None) -> Scalar:
        """A sympy expression in the system's symbols (by name), staged; a user's own force enters here."""
        from lamc.mechanics.sympy_view import from_sympy

        if isinstance(value, Value | int | float):
            return value
        own = [self.time, *self.angles, *self.rates, *self.accelerations, *self.constants]
        known: dict[str, Scalar] = {str(self.show(symbol)): symbol for symbol in own}
        return from_sympy(value, known | dict(symbols or {}), self.store)


class Frame:
    """A frame that turns relative to its parent; made by `Frame.turned`.

    rotation          parent from this frame, (3, 3)
    angular_velocity  relative to the parent, in this frame, rad/s
    """

    def __init__(
        self, name: str, system: System, parent: "Frame | None", rotation: Matrix3, angular_velocity: Vector3
    ) -> None:
        self.name = name
        self.system = system
        self.parent = parent
        self.rotation = rotation
        self.angular_velocity = angular_velocity

    @classmethod
    def turned(cls, name: str, parent: "Frame", axis: Sequence[float], angle: Scalar) -> "Frame":
        """A frame turned by `angle` (rad) about an axis fixed in parent and child (eq. 1-4, Rodrigues).

        Raises DesignError if the axis has no direction.
        """
        length = sum(float(a) ** 2 for a in axis) ** 0.5
        if len(axis) != 3 or not length > 0:
            raise DesignError(f"the axis of frame {name!r} is {list(axis)}; it must have a direction")
        n: Vector3 = (float(axis[0]) / length, float(axis[1]) / length, float(axis[2]) / length)
        c, s = cos(angle), sin(angle)
        versine = 1 - c

        def entry(i: int, j: int) -> Scalar:
            even = n[i] * n[j] * versine + (c if i == j else 0)
            k = 3 - i - j
            return even if i == j else even - _LEVI_CIVITA[i, j] * n[k] * s

        rows = [(entry(i, 0), entry(i, 1), entry(i, 2)) for i in range(3)]
        rate = parent.system.time_derivatives([angle])[0]
        return cls(name, parent.system, parent, (rows[0], rows[1], rows[2]), scale(rate, n))

    def vector(self, x: Scalar, y: Scalar, z: Scalar) -> "Vector":
        """A vector with these components in this frame."""
        return Vector({self: (x, y, z)})

    def ancestors(self) -> list["Frame"]:
        """This frame, its parent, … up to the world."""
        frames = [self]
        while frames[-1].parent is not None:
            frames.append(frames[-1].parent)
        return frames

    def path(self, other: "Frame") -> tuple[list["Frame"], list["Frame"]]:
        """The shortest way through the tree (eq. 5-6): frames to climb from here, frames to descend to `other`."""
        mine, theirs = self.ancestors(), other.ancestors()
        while mine and theirs and mine[-1] is theirs[-1]:
            mine.pop()
            theirs.pop()
        return mine, theirs[::-1]

    def components_in(self, other: "Frame", v: Vector3) -> Vector3:
        """Components in `other` of a vector with components `v` here."""
        up, down = self.path(other)
        for frame in up:
            v = rotate(frame.rotation, v)
        for frame in down:
            v = rotate_back(frame.rotation, v)
        return v

    def angular_velocity_in(self, other: "Frame") -> "Vector":
        """Angular velocity of this frame relative to `other`, rad/s."""
        up, down = self.path(other)
        result = Vector({})
        for frame in up:
            result = result + Vector({frame: frame.angular_velocity})
        for frame in down:
            result = result - Vector({frame: frame.angular_velocity})
        return result

    def __repr__(self) -> str:
        return f"Frame({self.name!r})"


_LEVI_CIVITA = {(0, 1): 1, (1, 2): 1, (2, 0): 1, (1, 0): -1, (2, 1): -1, (0, 2): -1}


class Vector:
    """A sum of parts, each with its components in one frame (eq. 7); rotated only when an operation needs it."""

    def __init__(self, parts: Mapping[Frame, Vector3]) -> None:
        self.parts = dict(parts)

    def __add__(self, other: "Vector") -> "Vector":
        parts = dict(self.parts)
        for frame, components in other.parts.items():
            parts[frame] = add(parts[frame], components) if frame in parts else components
        return Vector(parts)

    def __neg__(self) -> "Vector":
        return -1 * self

    def __sub__(self, other: "Vector") -> "Vector":
        return self + (-other)

    def __mul__(self, factor: Scalar) -> "Vector":
        return Vector({frame: scale(factor, v) for frame, v in self.parts.items()})

    __rmul__ = __mul__

    def express(self, frame: Frame) -> Vector3:
        """All components in one frame (eq. 8)."""
        total = ZERO
        for own, components in self.parts.items():
            total = add(total, own.components_in(frame, components))
        return total

    def dot(self, other: "Vector") -> Scalar:
        """Scalar product (eq. 9)."""
        result: Scalar = 0
        for frame, components in self.parts.items():
            result = result + dot(components, other.express(frame))
        return result

    def cross(self, other: "Vector") -> "Vector":
        """Vector product (eq. 10-11)."""
        result = Vector({})
        for frame, components in self.parts.items():
            result = result + Vector({frame: cross(components, other.express(frame))})
        return result

    def derivative(self, frame: Frame) -> "Vector":
        """Time derivative as seen in `frame` (eq. 13-14): components' rates plus ω × each part."""
        result = Vector({})
        for own, components in self.parts.items():
            x, y, z = own.system.time_derivatives(list(components))
            part = Vector({own: components})
            result = result + Vector({own: (x, y, z)}) + own.angular_velocity_in(frame).cross(part)
        return result

    def partial(self, rate: Value) -> "Vector":
        """∂/∂u: the partial velocity, when this is a velocity."""
        parts: dict[Frame, Vector3] = {}
        for frame, components in self.parts.items():
            x, y, z = derivatives(list(components), {rate: 1})
            parts[frame] = (x, y, z)
        return Vector(parts)
