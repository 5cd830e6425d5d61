"""Kane's equations of a tree, solved by eliminating hinge after hinge from the tips to the world: O(n).

For each link the generalised inertia force of everything it carries is linear in the link's own acceleration;
Kane's equation of its hinge (eq. 19) then gives the hinge's acceleration in terms of the parent's, and what
remains is handed to the parent. Featherstone's articulated bodies are the same elimination. Accelerations are
counted from the bias (all hinge accelerations zero, gravity included), so no velocity term appears twice.
"""

from collections.abc import Callable
from dataclasses import dataclass

from lamc.basics.errors import TopologyError
from lamc.mechanics.inertia import Inertia
from lamc.mechanics.kinematics import Bias, Kinematics
from lamc.mechanism.tree import WORLD
from lamc.symbolic.algebra import ZERO, Matrix3, Symmetric, Vector3, add, cross, dot, skew, total
from lamc.symbolic.scalars import Scalar, Value, reciprocal

Wrench = tuple[Vector3, Vector3]  # force N, moment about the origin N·m; carrier components


@dataclass(frozen=True)
class Carried:
    """Everything a link carries: moment = rotational α + coupling a + moment₀, force = couplingᵀ α + mass a + force₀.

    α and a are the link's angular acceleration and its origin's acceleration beyond the bias.
    """

    rotational: Symmetric  # kg·m²
    coupling: Matrix3  # kg·m
    mass: Symmetric  # kg
    moment: Vector3  # N·m
    force: Vector3  # N


@dataclass(frozen=True)
class Solved:
    """One hinge, eliminated: q̈ = free - (α_z + ratio·(α_x, α_y, a)) with the parent's motion in the link's frame."""

    free: Scalar
    ratio: tuple[Scalar, Scalar, Scalar, Scalar, Scalar]


def inertia_wrench(inertia: Inertia, bias: Bias) -> Wrench:
    """Inertia force and moment about the origin (their negatives are Kane's), for the bias accelerations."""
    gradient, a = bias.gradient, bias.acceleration
    force = (
        inertia.mass * a[0] + dot(gradient[0], inertia.first),
        inertia.mass * a[1] + dot(gradient[1], inertia.first),
        inertia.mass * a[2] + dot(gradient[2], inertia.first),
    )
    columns = inertia.second.rows()

    def moved(i: int, j: int) -> Scalar:
        return dot(gradient[i], columns[j])

    turning = (moved(2, 1) - moved(1, 2), moved(0, 2) - moved(2, 0), moved(1, 0) - moved(0, 1))
    return force, add(turning, cross(inertia.first, a))


def rigid(inertia: Inertia, wrench: Wrench) -> Carried:
    """A link alone."""
    m = inertia.mass
    return Carried(
        rotational=inertia.rotational(),
        coupling=skew(inertia.first),
        mass=Symmetric(m, m, m, 0, 0, 0),
        force=wrench[0],
        moment=wrench[1],
    )


def solve_by_elimination(
    kinematics: Kinematics, inertias: list[Inertia], wrenches: list[Wrench], torques: list[Scalar]
) -> list[Scalar]:
    """Hinge accelerations about the internal axes, rad/s².

    inertias and wrenches (inertia forces less applied ones) in carrier components; torques about internal axes.
    """
    tree, store = kinematics.tree, kinematics.store
    carried = [rigid(i, w) for i, w in zip(inertias, wrenches, strict=True)]
    solved: list[Solved] = []
    with store.section("Elimination of the hinges, tips first", source="Kane, eq. 19"):
        for index in reversed(range(len(tree.links))):
            store.link = index
            _check_inertia(kinematics, index, carried[index])
            hinge, remainder = eliminate(carried[index], torques[index])
            solved.append(hinge)
            parent = tree.links[index].parent
            if parent != WORLD:
                carried[parent] = joined(carried[parent], _to_parent(kinematics, index, remainder))
    solved.reverse()
    with store.section("Hinge accelerations, world first", source="Kane, eq. 19"):
        return _substitute_back(kinematics, solved)


def _check_inertia(kinematics: Kinematics, index: int, link: Carried) -> None:
    """Raises TopologyError if nothing that the hinge moves has inertia about it: no torque could then be too small."""
    if not isinstance(link.rotational.zz, Value) and link.rotational.zz == 0:
        joint, body = kinematics.tree.links[index].joint.name, kinematics.tree.links[index].body.name
        raise TopologyError(
            f"joint {joint!r} moves nothing that has inertia about its hinge line (body {body!r} lies on it); give "
            "the body inertia about that line, or move its centre of mass off it"
        )


def eliminate(link: Carried, torque: Scalar) -> tuple[Solved, Carried]:
    """Solves the link's own hinge equation for its acceleration about z and puts it in."""
    a, b = link.rotational, link.coupling
    inverse = reciprocal(a.zz)
    gx, gy = a.xz * inverse, a.yz * inverse
    g = (b[2][0] * inverse, b[2][1] * inverse, b[2][2] * inverse)
    drive = torque - link.moment[2]
    rotational = Symmetric(a.xx - gx * a.xz, a.yy - gy * a.yz, 0, a.xy - gx * a.yz, 0, 0)
    coupling: Matrix3 = (_less(b[0], gx, b[2]), _less(b[1], gy, b[2]), ZERO)
    mass = Symmetric(
        *(link.mass.entry(i, j) - g[i] * b[2][j] for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)))
    )
    moment = (link.moment[0] + gx * drive, link.moment[1] + gy * drive, torque)
    force = (link.force[0] + g[0] * drive, link.force[1] + g[1] * drive, link.force[2] + g[2] * drive)
    return Solved(drive * inverse, (gx, gy, *g)), Carried(rotational, coupling, mass, moment, force)


def _less(v: Vector3, k: Scalar, w: Vector3) -> Vector3:
    return (v[0] - k * w[0], v[1] - k * w[1], v[2] - k * w[2])


def _to_parent(kinematics: Kinematics, index: int, c: Carried) -> Carried:
    """The same, about the parent's origin and in the parent's carrier."""
    rotational = kinematics.symmetric_to_parent(index, c.rotational)
    coupling = kinematics.matrix_to_parent(index, c.coupling)
    mass = kinematics.symmetric_to_parent(index, c.mass)
    moment = kinematics.to_parent(index, c.moment)
    force = kinematics.to_parent(index, c.force)
    r = kinematics.offset[index]
    arm = skew(r)
    moved = _rows(lambda i, k: coupling[i][k] + total([arm[i][m] * mass.entry(m, k) for m in range(3)]))

    def turned(i: int, j: int) -> Scalar:
        inner = total([arm[i][m] * coupling[j][m] for m in range(3)])
        outer = total([moved[i][m] * arm[j][m] for m in range(3)])
        return rotational.entry(i, j) + (inner + outer)

    about_parent = Symmetric(
        turned(0, 0), turned(1, 1), turned(2, 2), turned(0, 1), turned(0, 2), turned(1, 2)
    )
    return Carried(about_parent, moved, mass, add(moment, cross(r, force)), force)


def joined(first: Carried, second: Carried) -> Carried:
    """Two things carried together."""
    return Carried(
        Symmetric(*(x + y for x, y in zip(first.rotational, second.rotational, strict=True))),
        _rows(lambda i, k: first.coupling[i][k] + second.coupling[i][k]),
        Symmetric(*(x + y for x, y in zip(first.mass, second.mass, strict=True))),
        add(first.moment, second.moment),
        add(first.force, second.force),
    )


def _rows(entry: Callable[[int, int], Scalar]) -> Matrix3:
    a, b, c = ((entry(i, 0), entry(i, 1), entry(i, 2)) for i in range(3))
    return (a, b, c)


def _substitute_back(kinematics: Kinematics, solved: list[Solved]) -> list[Scalar]:
    """From the world outwards: each hinge's acceleration from its parent's motion beyond the bias."""
    result: list[Scalar] = []
    angular: list[Vector3] = []
    linear: list[Vector3] = []
    for index, (link, hinge) in enumerate(zip(kinematics.tree.links, solved, strict=True)):
        kinematics.store.link = index
        alpha, a = ZERO, ZERO
        if link.parent != WORLD:
            p = link.parent
            alpha = kinematics.to_child(index, angular[p])
            a = kinematics.to_child(index, add(linear[p], cross(angular[p], kinematics.offset[index])))
        gx, gy, *g = hinge.ratio
        carried = total([gx * alpha[0], gy * alpha[1], *(x * y for x, y in zip(g, a, strict=True))])
        about_hinge = hinge.free - carried
        result.append(about_hinge - alpha[2])
        angular.append((alpha[0], alpha[1], about_hinge))
        linear.append(a)
    return result
