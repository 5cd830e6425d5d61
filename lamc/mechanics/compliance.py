"""What holds compliant hinges and flexible bodies: potentials and dissipation as forces on the coordinates.

Goes in: stiffness and damping matrices of an `Arrangement`, and `Loads`. Comes out: forces that follow from the energy
that is stored, exactly, booked under the effect that asked for them.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from lamc.basics.checks import Array
from lamc.mechanics.arrangement import FREEDOMS, Bushing, CompliantHinge
from lamc.mechanics.closure import constants
from lamc.mechanics.flexible import FlexibleBody
from lamc.mechanics.loads import Loads, SeenHinge
from lamc.mechanics.placement import Placement, rotate
from lamc.mechanism.rotations import snap
from lamc.mechanism.tree import WORLD, Side
from lamc.symbolic.algebra import Vector3, add, dot, total
from lamc.symbolic.derivative import derivatives
from lamc.symbolic.scalars import Scalar, Value, call

_PER = {("rad", "rad"): "N·m/rad", ("m", "rad"): "N/rad", ("m", "m"): "N/m"}
_UNITS = {"twist": "rad", "angle": "rad", "slide": "m"}


@dataclass(frozen=True)
class Held:
    """Amounts p with their rates, and ∂p/∂q by coordinate, that a stiffness and a damping matrix hold."""

    amounts: tuple[Scalar, ...]
    rates: tuple[Scalar, ...]
    partials: tuple[tuple[tuple[int, Scalar], ...], ...]  # of each amount: (coordinate, ∂p/∂q)


def hinge_amounts(
    hinge: CompliantHinge, index: Mapping[str, int], joint: int, q: Sequence[Scalar], u: Sequence[Scalar]
) -> Held:
    """p of a compliant hinge of the tree: coordinates, and nought for rigid freedoms."""
    places = [
        joint if f == "angle" else index[f"{hinge.joint}.{f}"] if f in hinge.freedoms else None
        for f in FREEDOMS
    ]
    return Held(
        tuple(0 if k is None else q[k] for k in places),
        tuple(0 if k is None else u[k] for k in places),
        tuple(() if k is None else ((k, 1),) for k in places),
    )


def bushing_amounts(
    placement: Placement, bushing: Bushing, q: Sequence[Value], u: Sequence[Value], counted: Value
) -> tuple[Held, SeenHinge]:
    """p of a compliant hinge that closes a loop, from where its two sides are; and the hinge as effects see it.

    placement: seen from the base. q, u: those with q̇ = u. counted: the hinge's coordinate, which tells its turns; the
    rest of its angle is that of the two sides, whatever the coordinate is off by.
    """
    store, hinge = placement.kinematics.store, bushing.hinge
    with store.section(
        f"Sides of {hinge.joint}", effect=hinge.effect, source="child's frame in the parent's"
    ):
        point_a, axes_a = _side(placement, bushing.cut.parent, hinge)
        point_b, axes_b = _side(placement, bushing.cut.child, hinge)
        apart = tuple(b - a for a, b in zip(point_a, point_b, strict=True))
        slides = [dot(axis, apart) for axis in axes_a]
        r = [[dot(a, b) for b in axes_b] for a in axes_a]  # = Rx(twist_x) Ry(twist_y) Rz(angle)
        across = call("sqrt", r[1][2] * r[1][2] + r[2][2] * r[2][2])
        twist_x, twist_y = call("atan2", -r[1][2], r[2][2]), call("atan2", r[0][2], across)
        angle = call("atan2", -r[0][1], r[0][0])
        amounts = [twist_x, twist_y, angle, *slides]
        rates = derivatives(amounts, dict(zip(q, u, strict=True)))
        columns = [derivatives(amounts, {x: 1}) for x in q]
        beyond = angle - counted
        amounts[2] = angle = counted + call("atan2", call("sin", beyond), call("cos", beyond))
    partials = [
        tuple((k, c[row]) for k, c in enumerate(columns) if isinstance(c[row], Value) or c[row] != 0)
        for row in range(6)
    ]
    gradient = tuple(column[2] for column in columns)
    seen = SeenHinge(bushing.cut.joint, angle, rates[2], gradient)
    return Held(tuple(amounts), tuple(rates), tuple(partials)), seen


def hold_hinge(loads: Loads, hinge: CompliantHinge, held: Held) -> None:
    """-∂/∂q of ½ pᵀKp, and -C ṗ through the same partials; entries of K and C become parameters."""
    names = [
        [a if a == b else "_".join(f for f in FREEDOMS if f in (a, b)) for b in FREEDOMS] for a in FREEDOMS
    ]
    units = [_UNITS[f.split("_")[0]] for f in FREEDOMS]
    _hold(loads, held, (hinge.stiffness, hinge.damping), f"{hinge.joint}.cross", names, units)


def hold_modes(
    loads: Loads, body: FlexibleBody, first: int, q: Sequence[Scalar], u: Sequence[Scalar]
) -> None:
    """-K η - C η̇ on the modes."""
    places = range(first, first + body.count)
    held = Held(tuple(q[k] for k in places), tuple(u[k] for k in places), tuple(((k, 1),) for k in places))
    names = [[f"{min(i, j) + 1}_{max(i, j) + 1}" for j in range(body.count)] for i in range(body.count)]
    _hold(loads, held, (body.stiffness, body.damping), f"{body.body}.modal", names, [body.unit] * body.count)


def _hold(
    loads: Loads,
    held: Held,
    matrices: tuple[Array, Array],
    label: str,
    names: list[list[str]],
    units: list[str],
) -> None:
    sums: list[list[Scalar]] = []
    for matrix, kind, per in zip(matrices, ("stiffness", "damping"), ("", "·s"), strict=True):
        size = float(abs(matrix).max(initial=0.0))
        amounts = held.amounts if kind == "stiffness" else held.rates
        rows: list[Scalar] = []
        for i in range(len(amounts)):
            terms: list[Scalar] = []
            for j, amount in enumerate(amounts):
                plain = not isinstance(held.amounts[j], Value) or not isinstance(held.amounts[i], Value)
                if plain or abs(matrix[i, j]) <= 1e-15 * size:
                    continue
                low, high = sorted((units[i], units[j]))
                unit = _PER.get((low, high), f"J/({low}·{high})").replace("/", f"{per}/", 1)
                lower = float(matrix[max(i, j), min(i, j)])
                name = f"{label}_{kind}.{names[i][j]}"
                terms.append(loads.parameter(name, lower, unit, f"entry of the {kind} matrix") * amount)
            rows.append(total(terms))
        sums.append(rows)
    loads.stored_energy(0.5 * dot(held.amounts, sums[0]))
    for row, partials in enumerate(held.partials):
        for k, partial in partials:
            loads.generalised_force(k, -(partial * (sums[0][row] + sums[1][row])))


def _side(
    placement: Placement, side: Side, hinge: CompliantHinge
) -> tuple[Vector3, tuple[Vector3, Vector3, Vector3]]:
    """Point and axes of one side, seen from the base."""
    kinematics = placement.kinematics
    store = kinematics.store

    if side.link == WORLD:
        x, y, z = (constants(store, hinge.axes[:, k]) for k in range(3))
        return constants(store, hinge.point), (x, y, z)
    link, size = kinematics.tree.links[side.link], kinematics.tree.mechanism.size
    place = snap(link.frame.T @ (hinge.point - link.origin), size)
    carrier, axes = placement.carrier(side.link), snap(link.frame.T @ hinge.axes, 1.0)
    arm = kinematics.attached(side.link, constants(store, place), place)
    x, y, z = (
        rotate(carrier, kinematics.directed(side.link, constants(store, axes[:, k]), place)) for k in range(3)
    )
    return add(placement.origin(side.link), rotate(carrier, arm)), (x, y, z)
