"""Closure of loops, staged: equations between the angles of all hinges, cut ones too.

Goes in: a tree with cuts, coordinates, rates. Comes out: residuals, Jacobian and acceleration bias. Where bodies and
hinges are rigid they are those of short cycles, each of which knows its own few hinges (`cycle_closure`). Where
something yields, both sides of each cut hinge are followed through the tree, and meet at the hinge's angle.

Residuals are rad, or displacements in parts of the mechanism's size.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from operator import itemgetter

from lamc.loops.cycles import short_cycles
from lamc.mechanics.cycle_closure import Shapes, close_cycle, lines_of
from lamc.mechanics.kinematics import Kinematics
from lamc.mechanics.placement import Placement, rotate
from lamc.mechanism.tree import WORLD, Cut, Side, Tree
from lamc.records.mechanism import Array
from lamc.symbolic.algebra import Vector3, add, dot, scale
from lamc.symbolic.derivative import derivatives
from lamc.symbolic.scalars import Scalar, Value, cos, sin
from lamc.symbolic.staging import Store


@dataclass(frozen=True)
class Closure:
    """Residuals φ (m,) of all loops with dφ/dt = J u and d²φ/dt² = J u̇ + γ where they close.

    jacobian[i] holds (coordinate, entry) of the coordinates that equation i knows, and no others.
    """

    residual: tuple[Scalar, ...]  # φ
    jacobian: tuple[tuple[tuple[int, Scalar], ...], ...]  # J, (m, n)
    bias: tuple[Scalar, ...]  # γ, (m,), 1/s²


def close_cycles(tree: Tree, q: Sequence[Value], u: Sequence[Value]) -> Closure:
    """Of rigid bodies on hinges. q, u: of the joints in the order of `tree.hinges`, and others that close no loop."""
    store = q[0].store
    residual: list[Scalar] = []
    rows: list[tuple[tuple[int, Scalar], ...]] = []
    bias: list[Scalar] = []
    shapes = Shapes(store)
    rings = lines_of(short_cycles(tree), tree.hinges, tree.mechanism.size)
    with store.section("Sines and cosines of hinges in loops"):
        for joint in sorted({line.joint for ring in rings for line in ring}):
            store.link = joint
            for angle in (q[joint], 0.5 * q[joint]):
                sin(angle), cos(angle)
    with store.section("Closure of the loops", source="products of exponentials along short cycles"):
        for number, ring in enumerate(rings):
            store.link = number
            closed = close_cycle(shapes, ring, q, u)
            residual += closed.residual
            bias += closed.bias
            rows += (tuple(sorted(row, key=itemgetter(0))) for row in closed.jacobian)
    return Closure(tuple(residual), tuple(rows), tuple(bias))


def close_cuts(placement: Placement, q: Sequence[Value], u: Sequence[Value]) -> Closure:
    """Of what yields. placement: seen from the base. Equations that depend on q only."""
    kinematics = placement.kinematics
    store, tree = kinematics.store, kinematics.tree
    speeds: dict[Value, Scalar] = dict(zip(q, u, strict=True))
    first = len(tree.links)
    with store.section("Closure of the loops", source="both sides of a cut hinge meet"):
        every = [r for k, cut in enumerate(tree.cuts) for r in _meeting(placement, cut, q[first + k])]
    with store.section("Jacobian of the closure", source="dφ/dq"):
        columns = [derivatives(every, {x: 1}) for x in q]
    rows = [
        tuple((j, column[i]) for j, column in enumerate(columns) if isinstance(column[i], Value) or column[i])
        for i in range(len(every))
    ]
    residual = [value for value, row in zip(every, rows, strict=True) if row]
    with store.section("Acceleration bias of the closure", source="d²φ/dt² for u̇ = 0"):
        bias = derivatives(derivatives(residual, speeds), speeds)
    return Closure(tuple(residual), tuple(row for row in rows if row), tuple(bias))


def _meeting(placement: Placement, cut: Cut, angle: Value) -> tuple[Scalar, ...]:
    """Where the child's side is away from the parent's, turned by the hinge's angle."""
    kinematics = placement.kinematics
    common = _last_common(kinematics, cut.parent.link, cut.child.link)
    point_a, (xa, ya, _) = _seen(placement, cut.parent, common)
    point_b, (xb, _, zb) = _seen(placement, cut.child, common)
    per_size = kinematics.store.constant(1.0 / kinematics.tree.mechanism.size)
    apart = tuple(per_size * (b - a) for a, b in zip(point_a, point_b, strict=True))
    across = add(scale(cos(angle), ya), scale(-sin(angle), xa))
    return (*apart, dot(xa, zb), dot(ya, zb), dot(across, xb))


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


def constants(store: Store, values: Array) -> Vector3:
    """Three numbers of the design as scalars of the store."""
    x, y, z = (store.constant(float(v)) for v in values)
    return (x, y, z)
