"""The fixed bodies in motion, staged: freely, with a quaternion, or as prescribed by expressions in time.

Goes in: what `arrange` says of the base, and symbols. Comes out: where the base is, and its velocity and acceleration
as twists in its own (drawn) axes. It knows no link.
"""

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from lamc.basics.checks import Array
from lamc.mechanics.arrangement import FloatingBase, PrescribedBase
from lamc.mechanics.drawn import keyed
from lamc.mechanics.inertia import ParameterMaker
from lamc.mechanics.placement import rotate, rotate_back
from lamc.symbolic.algebra import ZERO, Matrix3, Symmetric, Vector3, add, total
from lamc.symbolic.derivative import derivatives
from lamc.symbolic.scalars import Scalar, Value, cos, reciprocal, sin
from lamc.symbolic.staging import DrawnKey, Store


@dataclass(frozen=True)
class Twist:
    """Motion of a frame, components in that frame: angular rad/s (or rad/s²), linear m/s (or m/s²) of its origin."""

    angular: Vector3
    linear: Vector3


STILL = Twist(ZERO, ZERO)


@dataclass(frozen=True)
class MovingBase(ABC):
    """A base at one place. `reference` (3,), m, is the drawn point that is at `position`, m.

    rotation  world from drawn axes
    velocity  of the reference, drawn axes of the base
    """

    store: Store
    reference: Array
    rotation: Matrix3
    position: Vector3
    velocity: Twist

    @abstractmethod
    def acceleration(self, accelerations: Sequence[Scalar] | None) -> Twist:
        """Of the reference, axes of the base; a floating base's for u̇ (nu,), None: nothing accelerates."""

    def point(self, drawn: Array, key: DrawnKey = ()) -> Vector3:
        """World position, m, of a drawn point (3,); key: what it is of the drawing."""
        return add(self.position, rotate(self.rotation, self.arm(drawn, key)))

    def arm(self, drawn: Array, key: DrawnKey = ()) -> Vector3:
        """From the reference to a drawn point (3,), m, axes of the base."""
        x, y, z = keyed(self.store, key, (drawn - self.reference).tolist())
        return (x, y, z)


@dataclass(frozen=True)
class StagedFloat(MovingBase):
    """A base that floats. mass kg, inertia kg·m² about the centre of mass, which is the reference; drawn axes."""

    mass: Scalar
    inertia: Symmetric
    coordinate_rates: tuple[Scalar, ...]  # of the position and the quaternion, (7,)

    def acceleration(self, accelerations: Sequence[Scalar] | None) -> Twist:
        if accelerations is None:
            return STILL
        *_, vx, vy, vz, wx, wy, wz = accelerations
        return Twist((wx, wy, wz), rotate_back(self.rotation, (vx, vy, vz)))


@dataclass(frozen=True)
class StagedMotion(MovingBase):
    """A base that moves as prescribed."""

    prescribed: Twist  # acceleration

    def acceleration(self, accelerations: Sequence[Scalar] | None) -> Twist:
        return self.prescribed


def float_base(
    store: Store, base: FloatingBase, parameter: ParameterMaker, q: Sequence[Scalar], u: Sequence[Scalar]
) -> StagedFloat:
    """The floating base at the last seven of q and the last six of u."""
    x, y, z, *quaternion = q[-7:]
    vx, vy, vz, wx, wy, wz = u[-6:]
    name = "+".join(base.bodies)
    with store.section("Rotation of the base", source="quaternion of any norm; Wittenburg 2008, 2.1.3"):
        rotation = quaternion_rotation(quaternion)
        velocity = Twist((wx, wy, wz), rotate_back(rotation, (vx, vy, vz)))
        rates = (vx, vy, vz, *quaternion_rates(quaternion, (wx, wy, wz)))
    mass = parameter(f"{name}.mass", base.mass, "kg", "mass of the floating base")
    inertia = [
        parameter(
            f"{name}.inertia_{'xyz'[i]}{'xyz'[j]}",
            float(base.inertia[i, j]),
            "kg·m²",
            f"entry {'xyz'[i]}{'xyz'[j]} of the inertia about the centre of mass, drawn axes",
        )
        if base.inertia[i, j]
        else 0
        for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
    ]
    return StagedFloat(store, base.com, rotation, (x, y, z), velocity, mass, Symmetric(*inertia), rates)


def prescribe_base(
    store: Store, base: PrescribedBase, time: Value, inputs: Mapping[str, Scalar]
) -> StagedMotion:
    """The base that moves as prescribed, with velocities and accelerations by differentiation in time; `inputs` of the
    scene stand still, but for those that follow a series."""
    with store.section(
        "Motion of the base", effect=base.effect, source="as told, and its derivatives in time"
    ):
        prescribed = list(base.motion(time, inputs))
        rates = derivatives(prescribed, {time: 1})
        seconds = derivatives(rates, {time: 1})
        axis, point = constant_vector(store, base.axis), constant_vector(store, base.point)
        rotation = rotation_about(store, base.axis, prescribed[3])
        position = add(point, (prescribed[0], prescribed[1], prescribed[2]))

        def twist(values: Sequence[Scalar]) -> Twist:
            x, y, z, turning = values
            return Twist(
                (axis[0] * turning, axis[1] * turning, axis[2] * turning), rotate_back(rotation, (x, y, z))
            )

        return StagedMotion(store, base.point, rotation, position, twist(rates), twist(seconds))


def quaternion_rotation(quaternion: Sequence[Scalar]) -> Matrix3:
    """World from body of (w, x, y, z), whatever its norm: one reciprocal."""
    w, x, y, z = quaternion
    k = 2 * reciprocal(total([c * c for c in quaternion]))
    kx, ky, kz = k * x, k * y, k * z
    xx, yy, zz, xy, xz, yz = kx * x, ky * y, kz * z, kx * y, kx * z, ky * z
    wx, wy, wz = kx * w, ky * w, kz * w
    return (
        (1 - (yy + zz), xy - wz, xz + wy),
        (xy + wz, 1 - (xx + zz), yz - wx),
        (xz - wy, yz + wx, 1 - (xx + yy)),
    )


def quaternion_rates(quaternion: Sequence[Scalar], omega: Vector3) -> tuple[Scalar, ...]:
    """½ q ⊗ (0, ω), ω in axes of the body; the norm stays."""
    w, x, y, z = quaternion
    a, b, c = (0.5 * component for component in omega)
    return (
        -(x * a + y * b + z * c),
        w * a + (y * c - z * b),
        w * b + (z * a - x * c),
        w * c + (x * b - y * a),
    )


def rotation_about(store: Store, axis: Array, angle: Scalar) -> Matrix3:
    """Rot(axis, angle) for a constant unit vector: A Rz(angle) Aᵀ with the axis as third column of A."""
    if not isinstance(angle, Value) and angle == 0:
        return ((1, 0, 0), (0, 1, 0), (0, 0, 1))
    c, s = cos(angle), sin(angle)
    n = constant_vector(store, axis)
    rest = 1 - c

    def entry(i: int, j: int) -> Scalar:
        value = rest * (n[i] * n[j])
        if i == j:
            return c + value if n[i] not in (1, -1) else 1
        k = 3 - i - j
        sign = 1 if (i, j) in ((1, 0), (2, 1), (0, 2)) else -1
        return value + sign * (s * n[k])

    return tuple((entry(i, 0), entry(i, 1), entry(i, 2)) for i in range(3))  # type: ignore[return-value]


def constant_vector(store: Store, values: Array) -> Vector3:
    """Three numbers of the design as scalars of the store."""
    x, y, z = (store.constant(float(v)) for v in values)
    return (x, y, z)
