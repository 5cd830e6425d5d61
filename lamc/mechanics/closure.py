"""Closure of loops: what holds the two sides of each cut hinge together, staged.

Goes in: kinematics and the cuts of a tree. Comes out: per cut five residuals (three of distance, two of direction),
their Jacobian and their acceleration bias, and the cut hinge's own angle and rate. Both sides are expressed in the
carrier of the last link that they have in common, so that hinges before it drop out by themselves.

Residuals are in metres: those of direction are the sine of the angle between the axes times the mechanism's size.
"""

from collections.abc import Sequence
from dataclasses import dataclass

from lamc.mechanics.kinematics import Kinematics, LinkVelocity
from lamc.mechanics.placement import Placement, rotate
from lamc.mechanism.tree import WORLD, Cut, Side
from lamc.records.mechanism import Array
from lamc.symbolic.algebra import Vector3, add, dot
from lamc.symbolic.derivative import derivatives
from lamc.symbolic.scalars import Scalar, Value, call
from lamc.symbolic.staging import Store


@dataclass(frozen=True)
class CutHinge:
    """One cut hinge. angle rad, within ±π; rate rad/s; both child relative to parent.

    gradient  ∂angle/∂q, by which its torque does work in the general form; None: it acts on the two sides
    """

    cut: Cut
    residual: tuple[Scalar, ...]  # m, five for each cut; none where a bushing holds it
    angle: Scalar
    rate: Scalar
    gradient: tuple[Scalar, ...] | None = None


@dataclass(frozen=True)
class Closure:
    """Residuals φ (m,) of all cuts with dφ/dt = J u and d²φ/dt² = J u̇ + γ.

    jacobian[i][j] is a plain zero where hinge j is not in the loop of equation i.
    """

    hinges: tuple[CutHinge, ...]
    residual: tuple[Scalar, ...]  # φ, m
    jacobian: tuple[tuple[Scalar, ...], ...]  # J, (m, n), m/rad
    bias: tuple[Scalar, ...]  # γ, (m,), m/s²


def cut_hinges(placement: Placement, u: Sequence[Scalar]) -> tuple[CutHinge, ...]:
    """Residuals, angles and rates of all cuts of the tree."""
    kinematics = placement.kinematics
    store, tree = kinematics.store, kinematics.tree
    if not tree.cuts:
        return ()
    motions = kinematics.motions(u)
    with store.section("Closure of the loops", source="both sides of a cut hinge meet"):
        size = store.constant(tree.mechanism.size)
        return tuple(_cut_hinge(placement, cut, motions, size) for cut in tree.cuts)


def close(hinges: Sequence[CutHinge], q: Sequence[Value], u: Sequence[Value]) -> Closure:
    """Residuals that depend on q, with Jacobian and bias; in a plane loop only two of five per cut do."""
    store = q[0].store
    speeds: dict[Value, Scalar] = dict(zip(q, u, strict=True))
    every = [r for hinge in hinges for r in hinge.residual]
    with store.section("Jacobian of the closure", source="dφ/dq"):
        columns = [derivatives(every, {angle: 1}) for angle in q]
    rows = [
        i for i in range(len(every)) if any(isinstance(column[i], Value) or column[i] for column in columns)
    ]
    residual = [every[i] for i in rows]
    with store.section("Acceleration bias of the closure", source="d²φ/dt² for u̇ = 0"):
        bias = derivatives(derivatives(residual, speeds), speeds)
    jacobian = tuple(tuple(column[i] for column in columns) for i in rows)
    return Closure(tuple(hinges), tuple(residual), jacobian, tuple(bias))


def _cut_hinge(placement: Placement, cut: Cut, motions: list[LinkVelocity], size: Scalar) -> CutHinge:
    kinematics = placement.kinematics
    common = _last_common(kinematics, cut.parent.link, cut.child.link)
    point_a, (xa, ya, _) = _seen(placement, cut.parent, common)
    point_b, (xb, _, zb) = _seen(placement, cut.child, common)
    distance = (point_b[0] - point_a[0], point_b[1] - point_a[1], point_b[2] - point_a[2])
    residual = (*distance, size * dot(xa, zb), size * dot(ya, zb))
    angle = call("atan2", dot(ya, xb), dot(xa, xb))
    rate = _spin(kinematics, cut.child, motions) - _spin(kinematics, cut.parent, motions)
    return CutHinge(cut, residual, angle, rate)


def _last_common(kinematics: Kinematics, a: int, b: int) -> int:
    """The last link on both ways from the world, WORLD if there is none."""
    links = kinematics.tree.links
    way = {a}
    while a != WORLD:
        a = links[a].parent
        way.add(a)
    while b not in way:
        b = links[b].parent
    return b


def _seen(placement: Placement, side: Side, common: int) -> tuple[Vector3, tuple[Vector3, Vector3, Vector3]]:
    """A side's point and directions in the carrier of the common link (in the world, for WORLD)."""
    kinematics = placement.kinematics
    point = constants(kinematics.store, side.point)
    axes = [constants(kinematics.store, side.axes[:, k]) for k in range(3)]
    index = side.link
    if index != WORLD:
        point = kinematics.attached(index, point, side.point)
        axes = [kinematics.directed(index, a, side.point) for a in axes]
    while index != common:
        link = kinematics.tree.links[index]
        if link.parent == WORLD:
            base = placement.carrier(index)
            point = add(placement.origin(index), rotate(base, point))
            axes = [rotate(base, a) for a in axes]
        else:
            point = add(kinematics.to_parent(index, point), kinematics.offset[index])
            axes = [kinematics.to_parent(index, a) for a in axes]
        index = link.parent
    x, y, z = axes
    return point, (x, y, z)


def _spin(kinematics: Kinematics, side: Side, motions: list[LinkVelocity]) -> Scalar:
    """Angular velocity of a side about the hinge, rad/s."""
    if side.link == WORLD:
        return 0
    axis = kinematics.in_carrier(side.link, constants(kinematics.store, side.axes[:, 2]))
    return dot(axis, motions[side.link].omega)


def constants(store: Store, values: Array) -> Vector3:
    """Three numbers of the design as scalars of the store."""
    x, y, z = (store.constant(float(v)) for v in values)
    return (x, y, z)
