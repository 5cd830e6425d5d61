"""The mass matrix in the general form by composite bodies: what a coordinate moves, seen from all that carry it.

Goes in: kinematics by chains, inertias, the base. Comes out: the lower triangle of M. Walker & Orin (1982), step by
step of a chain, so that a slide or a twist of a hinge that yields is one more joint; the modes of a body that bends
push at its own inertia and at every hinge that rides on it.
"""

from collections.abc import Mapping, Sequence

from lamc.mechanics import chains
from lamc.mechanics.chain_kinematics import ChainKinematics
from lamc.mechanics.chains import Shift, Step, Wrench, together
from lamc.mechanics.inertia import Inertia
from lamc.mechanics.modal import ModalInertia
from lamc.mechanics.moving_base import StagedFloat
from lamc.mechanics.placement import rotate
from lamc.mechanism.tree import WORLD
from lamc.symbolic.algebra import (
    Matrix3,
    Symmetric,
    Vector3,
    add,
    cross,
    dot,
    inward,
    inward_symmetric,
    scale,
)
from lamc.symbolic.scalars import Scalar

Entries = dict[tuple[int, int], Scalar]

_NOTHING = Inertia(0, (0, 0, 0), Symmetric(0, 0, 0, 0, 0, 0), 0)
_PAIRS = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))


def composite_mass_matrix(
    kinematics: ChainKinematics, inertias: Sequence[Inertia], modal: Mapping[int, ModalInertia]
) -> Entries:
    """Entries (i, j), i >= j, by rates; those left out are nought.

    inertias  of the links about their origins, own frames, undeformed; modal: what bending adds, by link
    """
    links, base = kinematics.tree.links, kinematics.base
    entries: Entries = {}
    carried = [modal[i].of(inertia) if i in modal else inertia for i, inertia in enumerate(inertias)]
    pushing: list[dict[int, Wrench]] = [{} for _ in links]  # by link, then by coordinate farther out
    whole = _NOTHING
    for i in reversed(range(len(links))):
        kinematics.store.link = i
        body, pushes = carried[i], pushing[i]
        if i in modal:
            for (k, j), value in modal[i].block().items():
                _add(entries, k, j, value)
            for k, push in modal[i].pushes():
                pushes[k] = together(pushes[k], push) if k in pushes else push
        for step in reversed(kinematics.chains[i]):
            pushes = _passed(step, body, pushes, entries)
            body = _before(step, body)
        parent = links[i].parent
        if parent != WORLD:
            carried[parent] = _joined(carried[parent], body)
            for k, push in pushes.items():
                before = pushing[parent].get(k)
                pushing[parent][k] = push if before is None else together(before, push)
        elif isinstance(base, StagedFloat):
            whole = _joined(whole, _on_base(kinematics, base, i, body))
            _with_base(kinematics, base, i, pushes, entries)
    if isinstance(base, StagedFloat):
        _base_block(entries, base, whole, len(kinematics.arrangement.rates) - 6)
    return entries


def _passed(step: Step, body: Inertia, pushes: Mapping[int, Wrench], entries: Entries) -> dict[int, Wrench]:
    """Pushes of coordinates, by coordinate, in the frame before a step, the step's own among them; with their entries.

    A mode moves several steps: what it does to itself farther in counts twice, and two modes that move one step meet
    there once.
    """
    result: dict[int, Wrench] = {}
    for k, push in pushes.items():
        work: dict[int, Scalar] = {}
        result[k] = chains.back(push, step, work)
        for other, value in work.items():
            _add(entries, k, other, 2 * value if other == k else value)
    for k, push in _pushes(step, body):
        own: dict[int, Scalar] = {}
        moved = chains.back(push, step, own)
        for other, value in own.items():
            if other <= k:
                _add(entries, k, other, value)
        result[k] = together(result[k], moved) if k in result else moved
    return result


def _with_base(
    kinematics: ChainKinematics, base: StagedFloat, index: int, pushes: Mapping[int, Wrench], entries: Entries
) -> None:
    """Entries of the base's rows with the coordinates of a limb."""
    first = len(kinematics.arrangement.rates) - 6
    for k, push in pushes.items():
        force, moment = kinematics.on_base(index, push)
        for row, value in enumerate((*rotate(base.rotation, force), *moment), first):
            _add(entries, row, k, value)


def _add(entries: Entries, i: int, j: int, value: Scalar) -> None:
    key = (max(i, j), min(i, j))
    entries[key] = entries.get(key, 0) + value


def _pushes(step: Step, body: Inertia) -> list[tuple[int, Wrench]]:
    """Inertia wrench of what lies beyond a step, in the frame after it, for a unit acceleration of each coordinate."""
    h, j = body.first, body.second
    if isinstance(step, Shift):
        return [(k, (scale(body.mass, p), cross(h, p))) for k, p in step.partials.items()]
    force: Vector3 = (0, -h[2], h[1])
    moment: Vector3 = (j.yy + j.zz, -j.xy, -j.xz)
    if step.rotation.axis == "z":
        force, moment = (-h[1], h[0], 0), (-j.xz, -j.yz, body.axial)
    return [(k, (scale(p, force), scale(p, moment))) for k, p in step.partials.items()]


def _before(step: Step, body: Inertia) -> Inertia:
    """The same body in the frame before a step."""
    if isinstance(step, Shift):
        return _shifted(body, step.vector)
    second = inward_symmetric(step.rotation, body.second)
    axial = body.axial if step.rotation.axis == "z" else second.xx + second.yy
    return Inertia(body.mass, inward(step.rotation, body.first), second, axial)


def _shifted(body: Inertia, r: Vector3) -> Inertia:
    """About the origin before a shift: J + r hₙᵀ + h rᵀ with hₙ = h + m r."""
    h = body.first
    hn = add(h, scale(body.mass, r))
    second = Symmetric(*(body.second.entry(a, b) + (r[a] * hn[b] + h[a] * r[b]) for a, b in _PAIRS))
    axial = body.axial + (r[0] * hn[0] + h[0] * r[0]) + (r[1] * hn[1] + h[1] * r[1])
    return Inertia(body.mass, hn, second, axial)


def _on_base(kinematics: ChainKinematics, base: StagedFloat, index: int, body: Inertia) -> Inertia:
    """What a link on the base carries, about the base's reference, axes of the base."""
    axes = kinematics.drawn_frame(index)
    second = _rotated(axes, body.second)
    rotated = Inertia(body.mass, rotate(axes, body.first), second, second.xx + second.yy)
    return _shifted(rotated, base.arm(kinematics.tree.links[index].origin, ("arm", index)))


def _rotated(axes: Matrix3, a: Symmetric) -> Symmetric:
    """A a Aᵀ."""
    rows = a.rows()
    half = [[dot(axis, column) for column in rows] for axis in axes]
    return Symmetric(*(dot(half[i], axes[j]) for i, j in _PAIRS))


def _base_block(entries: Entries, base: StagedFloat, whole: Inertia, first: int) -> None:
    """The base's own six rows: velocities along world axes, then angular ones in axes of the body."""
    mass = base.mass + whole.mass
    spinning = [x + y for x, y in zip(base.inertia, whole.rotational(), strict=True)]
    for k in range(3):
        entries[first + k, first + k] = mass
        for row, value in enumerate(cross(whole.first, base.rotation[k])):
            entries[first + 3 + row, first + k] = value
    for (i, j), value in zip(_PAIRS, spinning, strict=True):
        entries[first + 3 + j, first + 3 + i] = value


def _joined(a: Inertia, b: Inertia) -> Inertia:
    second = Symmetric(*(x + y for x, y in zip(a.second, b.second, strict=True)))
    return Inertia(a.mass + b.mass, add(a.first, b.first), second, a.axial + b.axial)
