"""Inertial parameters of the links as symbols, and their regrouping into base parameters.

Second moments. Beside the mass m and the first moment h = m·com a link carries J = ∫ r rᵀ dm about its origin,
in its own frame; the inertia tensor about the origin is tr(J)·1 - J. A thin plate has J_xx = 0 along its normal,
so zeros that are exact in the drawing are exact in the equations.

Regrouping. Mass on the hinge line moves with the parent too, so m, h_z and J_zz of a link can be carried by its
parent (and by the world in the end) without changing any acceleration; base parameters in the sense of Gautier
& Khalil (1990). All of it happens in `setup`, once per parameter change.
"""

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass

from lamc.mechanics.drawn import of_link
from lamc.mechanism.rotations import ROUND_OFF
from lamc.mechanism.tree import WORLD, Link, Tree
from lamc.symbolic.algebra import Symmetric, Vector3
from lamc.symbolic.scalars import Scalar
from lamc.symbolic.staging import Store

ParameterMaker = Callable[[str, float, str, str], Scalar]  # name, default, unit, meaning
AXES = "xyz"


@dataclass(frozen=True)
class Inertia:
    """m [kg], h = ∫ r dm [kg·m] and J = ∫ r rᵀ dm [kg·m²] about a link's origin.

    axial = J_xx + J_yy, the moment of inertia about z: a turn about z leaves it alone, and a link that moves in a
    plane needs nothing else of J.
    """

    mass: Scalar
    first: Vector3
    second: Symmetric
    axial: Scalar

    def rotational(self) -> Symmetric:
        """Inertia tensor about the origin."""
        j = self.second
        return Symmetric(j.yy + j.zz, j.xx + j.zz, self.axial, -j.xy, -j.xz, -j.yz)


def link_inertia(link: Link, parameter: ParameterMaker) -> tuple[Inertia, Vector3]:
    """The link's inertia about its origin, and its centre of mass in its frame (m), from new parameters.

    Moments of inertia about the centre of mass become parameters, except those that follow from the others: where
    a body has no extent along an axis, its moment about that axis is the sum of the other two.
    """
    name = link.body.name
    mass = parameter(f"{name}.mass", link.body.mass, "kg", "mass")
    com = _triple(
        [
            parameter(
                f"{name}.com_{a}",
                float(v),
                "m",
                f"centre of mass from the hinge, along {a} of the link's frame",
            )
            if v
            else 0
            for a, v in zip(AXES, link.com, strict=True)
        ]
    )
    central = _central_second_moments(link, parameter)
    first = _triple([mass * c for c in com])
    second = Symmetric(*(central[k] + first[i] * com[j] for k, (i, j) in enumerate(_PAIRS)))
    return Inertia(mass, first, second, second.xx + second.yy), com


_PAIRS = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))


def _central_second_moments(link: Link, parameter: ParameterMaker) -> list[Scalar]:
    """J about the centre of mass: xx, yy, zz, xy, xz, yz; exact zeros where the body has no extent."""
    tensor = link.inertia
    half_trace = 0.5 * float(tensor.trace())
    extent = [half_trace - float(tensor[i, i]) for i in range(3)]
    flat = [e <= 10 * ROUND_OFF * half_trace for e in extent]
    moments: list[Scalar | None] = []
    for i, axis in enumerate(AXES):
        follows = flat[i] and sum(flat) == 1
        what = f"moment of inertia about {axis} through the centre of mass, link's frame"
        value = float(tensor[i, i])
        moments.append(
            None
            if follows or value == 0.0
            else parameter(f"{link.body.name}.inertia_{axis * 2}", value, "kg·m²", what)
        )
    diagonal = _extents(moments, flat)
    products: list[Scalar] = []
    for i, j in _PAIRS[3:]:
        value = float(tensor[i, j])
        label = f"{link.body.name}.inertia_{AXES[i]}{AXES[j]}"
        what = f"product of inertia (off-diagonal entry) {AXES[i]}{AXES[j]} about the centre of mass, link's frame"
        products.append(-parameter(label, value, "kg·m²", what) if value and not (flat[i] or flat[j]) else 0)
    return [*diagonal, *products]


def _extents(moments: list[Scalar | None], flat: list[bool]) -> list[Scalar]:
    """Diagonal of J from the diagonal of the inertia tensor; a missing moment is the sum of the other two."""
    if None in moments:
        known = [m if m is not None else 0 for m in moments]
        missing = moments.index(None)
        if sum(flat) == 1:
            first, second = (k for k in range(3) if k != missing)
            extents: list[Scalar] = [0, 0, 0]
            extents[first], extents[second] = known[second], known[first]
            return extents
        moments = list(known)
    full = [m if m is not None else 0 for m in moments]
    sums = [0 if flat[i] else 0.5 * (full[(i + 1) % 3] + full[(i + 2) % 3] - full[i]) for i in range(3)]
    return list(sums)


def regrouped(
    store: Store, tree: Tree, inertias: Sequence[Inertia], kept: Collection[int] = ()
) -> list[Inertia]:
    """Base parameters: m, h_z and J_zz of every link handed to its parent. Accelerations do not change.

    kept: links that keep theirs, as their hinge lines are not fixed to a rigid parent, or to a world that stands still.
    """
    mass = [i.mass for i in inertias]
    first = [i.first for i in inertias]
    second = [i.second for i in inertias]
    for index in reversed(range(len(tree.links))):
        link = tree.links[index]
        if index in kept:
            continue
        store.link = index
        m, h, j = mass[index], first[index], second[index]
        if link.parent != WORLD:
            p = link.parent
            offset = _triple(of_link(store, "offset", index, link))
            axis = _triple(of_link(store, "axis", index, link))
            line = _triple(
                [a * h[2] for a in axis]
            )  # first moment of the mass moved, about the child's origin
            moved = _triple([line[k] + m * offset[k] for k in range(3)])
            second[p] = Symmetric(
                *(
                    second[p][k] + (axis[a] * axis[b] * j.zz + (offset[a] * moved[b] + line[a] * offset[b]))
                    for k, (a, b) in enumerate(_PAIRS)
                )
            )
            first[p] = _triple([first[p][k] + moved[k] for k in range(3)])
            mass[p] = mass[p] + m
        mass[index] = 0
        first[index] = (h[0], h[1], 0)
        second[index] = j._replace(zz=0)
    return [Inertia(m, h, j, j.xx + j.yy) for m, h, j in zip(mass, first, second, strict=True)]


def _triple(values: Sequence[Scalar]) -> Vector3:
    x, y, z = values
    return (x, y, z)
