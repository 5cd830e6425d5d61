"""Kane's equations of a tree as M u̇ = f, and their solution by a factorisation that keeps the tree's zeros.

M from composite bodies: what a hinge moves, seen from every hinge on its way to the world. M = LᵀDL, tips first,
has no fill-in, since M[i, j] is zero unless one hinge carries the other (Featherstone 2005). Cheaper than the
elimination for short trees.
"""

from collections.abc import Mapping

from lamc.mechanics.elimination import Wrench
from lamc.mechanics.inertia import Inertia
from lamc.mechanics.kinematics import Kinematics
from lamc.mechanism.tree import WORLD, Tree
from lamc.symbolic.algebra import Symmetric, Vector3, add, cross
from lamc.symbolic.scalars import Scalar, reciprocal

Entries = dict[tuple[int, int], Scalar]  # lower triangle, entries on a common way to the world only


def mass_matrix(kinematics: Kinematics, inertias: list[Inertia]) -> Entries:
    """M[i, j] for j on the way from i to the world, kg·m², internal axes."""
    tree = kinematics.tree
    composite = list(inertias)
    entries: Entries = {}
    with kinematics.store.section("Mass matrix", source="Kane, eq. 19"):
        for i in reversed(range(len(tree.links))):
            kinematics.store.link = i
            body = composite[i]
            force: Vector3 = (-body.first[1], body.first[0], 0)
            moment: Vector3 = (-body.second.xz, -body.second.yz, body.axial)
            entries[i, i] = moment[2]
            j = i
            while tree.links[j].parent != WORLD:
                force, moment = kinematics.to_parent(j, force), kinematics.to_parent(j, moment)
                moment = add(moment, cross(kinematics.offset[j], force))
                j = tree.links[j].parent
                entries[i, j] = moment[2]
            parent = tree.links[i].parent
            if parent != WORLD:
                composite[parent] = _joined(composite[parent], _moved(kinematics, i, body))
    return entries


def _moved(kinematics: Kinematics, index: int, body: Inertia) -> Inertia:
    """About the parent's origin, in the parent's carrier: J + r hₙᵀ + h rᵀ with hₙ = h + m r."""
    h = kinematics.to_parent(index, body.first)
    j = kinematics.symmetric_to_parent(index, body.second)
    r = kinematics.offset[index]
    hn = (h[0] + body.mass * r[0], h[1] + body.mass * r[1], h[2] + body.mass * r[2])
    pairs = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
    second = Symmetric(*(j.entry(a, b) + (r[a] * hn[b] + h[a] * r[b]) for a, b in pairs))
    if any(rotation.axis == "x" for rotation in kinematics.rotations[index]):
        axial = second.xx + second.yy
    else:
        axial = body.axial + (r[0] * hn[0] + h[0] * r[0]) + (r[1] * hn[1] + h[1] * r[1])
    return Inertia(body.mass, hn, second, axial)


def _joined(first: Inertia, second: Inertia) -> Inertia:
    return Inertia(
        first.mass + second.mass,
        add(first.first, second.first),
        Symmetric(*(x + y for x, y in zip(first.second, second.second, strict=True))),
        first.axial + second.axial,
    )


def generalised_forces(kinematics: Kinematics, wrenches: list[Wrench], torques: list[Scalar]) -> list[Scalar]:
    """f of M u̇ = f: applied less inertia forces, projected on the hinges (eq. 18), N·m, internal axes."""
    tree = kinematics.tree
    forces = [w[0] for w in wrenches]
    moments = [w[1] for w in wrenches]
    result: list[Scalar] = [0] * len(tree.links)
    with kinematics.store.section("Generalised forces", source="eq. 18"):
        for i in reversed(range(len(tree.links))):
            kinematics.store.link = i
            result[i] = torques[i] - moments[i][2]
            parent = tree.links[i].parent
            if parent != WORLD:
                force, moment = kinematics.to_parent(i, forces[i]), kinematics.to_parent(i, moments[i])
                forces[parent] = add(forces[parent], force)
                moments[parent] = add(moments[parent], add(moment, cross(kinematics.offset[i], force)))
    return result


def solve_by_mass_matrix(
    kinematics: Kinematics, inertias: list[Inertia], wrenches: list[Wrench], torques: list[Scalar]
) -> list[Scalar]:
    """Hinge accelerations about the internal axes, rad/s²; arguments as in `solve_by_elimination`."""
    forces = generalised_forces(kinematics, wrenches, torques)
    entries = mass_matrix(kinematics, inertias)
    with kinematics.store.section("Solution of M u̇ = f by LᵀDL", source="Kane, eq. 19"):
        return _solve(kinematics.tree, entries, forces)


def _solve(tree: Tree, entries: Entries, forces: list[Scalar]) -> list[Scalar]:
    count = len(tree.links)
    lower, inverse = factors(count, entries)
    x = list(forces)
    for k in reversed(range(count)):
        for i in way_to_world(tree, k):
            x[i] = x[i] - lower[k, i] * x[k]
    x = [value * factor for value, factor in zip(x, inverse, strict=True)]
    for k in range(count):
        for i in way_to_world(tree, k):
            x[k] = x[k] - lower[k, i] * x[i]
    return x


def factors(count: int, entries: Mapping[tuple[int, int], Scalar]) -> tuple[Entries, list[Scalar]]:
    """L below its diagonal of ones, and the diagonal of 1 / D, of M = LᵀDL; entries: what is not zero of the lower
    triangle of M. Where links stand behind those that carry them, L has no entries but those of M."""
    m = dict(entries)
    lower: Entries = {}
    inverse: list[Scalar] = [0] * count
    for k in reversed(range(count)):
        inverse[k] = reciprocal(m[k, k])
        known = [i for i in reversed(range(k)) if (k, i) in m]
        for place, i in enumerate(known):
            lower[k, i] = m[k, i] * inverse[k]
            for j in known[place:]:
                m[i, j] = m.get((i, j), 0) - lower[k, i] * m[k, j]
    return lower, inverse


def way_to_world(tree: Tree, index: int) -> list[int]:
    """The links that carry this one, nearest first."""
    way: list[int] = []
    index = tree.links[index].parent
    while index != WORLD:
        way.append(index)
        index = tree.links[index].parent
    return way
