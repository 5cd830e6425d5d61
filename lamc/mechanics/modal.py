"""Inertia of a link that bends, staged: what its modes add to forces, energies and equations.

Goes in: the integrals of a `FlexibleBody`. Comes out: everything about the link's origin in the link's frame, for
points at r + n Σ φ_k η_k (Shabana, Dynamics of Multibody Systems, ch. 5; the integrals are named there as here).
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from lamc.mechanics.chain_kinematics import Modes
from lamc.mechanics.chains import LinkState, Wrench, total_vector
from lamc.mechanics.inertia import Inertia
from lamc.mechanics.kinematics import LinkVelocity
from lamc.mechanism.rotations import snap
from lamc.mechanism.tree import Link
from lamc.symbolic.algebra import Matrix3, Symmetric, Vector3, add, cross, dot, scale, total
from lamc.symbolic.scalars import Scalar
from lamc.symbolic.staging import Store

_PAIRS = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))


@dataclass(frozen=True)
class ModalInertia:
    """s_k = ∫ρφ_k, X_k = ∫ρ r φ_k and G_kl = ∫ρφ_kφ_l, about the link's origin; the deflections they go with."""

    modes: Modes
    moment: tuple[Scalar, ...]
    first: tuple[Vector3, ...]
    mass: tuple[tuple[Scalar, ...], ...]

    @property
    def normal(self) -> Vector3:
        return self.modes.normal

    def of(self, rigid: Inertia) -> Inertia:
        """The link's inertia as it is bent: first and second moments move with η."""
        n, eta = self.normal, self.modes.deflection
        bent = total_vector([scale(e, x) for e, x in zip(eta, self.first, strict=True)])
        square = dot(eta, self._times(eta))
        second = Symmetric(
            *(
                rigid.second.entry(i, j) + (bent[i] * n[j] + n[i] * bent[j]) + n[i] * n[j] * square
                for i, j in _PAIRS
            )
        )
        first = add(rigid.first, scale(dot(self.moment, eta), n))
        return replace(rigid, first=first, second=second, axial=second.xx + second.yy)

    def wrench(
        self, link_state: LinkState, rates: Sequence[Scalar], changes: Sequence[Scalar] | None
    ) -> Wrench:
        """Inertia force and moment about the origin that come with η̇ and η̈, beside those of `of`."""
        n, eta = self.normal, self.modes.deflection
        sweep = cross(link_state.omega, n)
        force = scale(2 * dot(self.moment, rates), sweep)
        carried = total_vector([scale(r, x) for r, x in zip(rates, self.first, strict=True)])
        carried = add(carried, scale(dot(eta, self._times(rates)), n))
        moment = scale(2, cross(carried, sweep))
        if changes is not None:
            force = add(force, scale(dot(self.moment, changes), n))
            pushed = total_vector([scale(c, x) for c, x in zip(changes, self.first, strict=True)])
            moment = add(moment, cross(pushed, n))
        return force, moment

    def equations(
        self, link_state: LinkState, gradient: Matrix3, changes: Sequence[Scalar] | None
    ) -> dict[int, Scalar]:
        """Generalised inertia forces of the modes, by coordinate."""
        n = self.normal
        bent = self._times(self.modes.deflection)
        inertia = self._times(changes) if changes is not None else (0,) * len(bent)
        result: dict[int, Scalar] = {}
        for k, (s, x, g, own) in enumerate(zip(self.moment, self.first, bent, inertia, strict=True)):
            place = add(x, scale(g, n))
            across = (dot(gradient[0], place), dot(gradient[1], place), dot(gradient[2], place))
            result[self.modes.first + k] = s * dot(n, link_state.acceleration) + dot(n, across) + own
        return result

    def kinetic(self, motion: LinkVelocity, rates: Sequence[Scalar]) -> Scalar:
        """What η̇ adds to the kinetic energy, J."""
        n = self.normal
        carried = total_vector([scale(r, x) for r, x in zip(rates, self.first, strict=True)])
        own = 0.5 * dot(rates, self._times(rates))
        return own + dot(self.moment, rates) * dot(n, motion.velocity) + dot(motion.omega, cross(carried, n))

    def pushes(self) -> list[tuple[int, Wrench]]:
        """Inertia wrench about the origin for a unit η̈ of each mode, by coordinate."""
        n, first = self.normal, self.modes.first
        rows = enumerate(zip(self.moment, self.first, strict=True), first)
        return [(k, (scale(s, n), cross(x, n))) for k, (s, x) in rows]

    def block(self) -> dict[tuple[int, int], Scalar]:
        """The mass matrix of the modes among themselves, lower triangle by coordinates."""
        first = self.modes.first
        return {(first + k, first + j): row[j] for k, row in enumerate(self.mass) for j in range(k + 1)}

    def rise(self) -> Vector3:
        """∫ρ times the deflection, kg·m, link's frame: what bending does to the first moment."""
        return scale(dot(self.moment, self.modes.deflection), self.normal)

    def _times(self, values: Sequence[Scalar]) -> tuple[Scalar, ...]:
        return tuple(total([g * v for g, v in zip(row, values, strict=True)]) for row in self.mass)


def modal_inertia(store: Store, modes: Modes, link: Link, com: Vector3) -> ModalInertia:
    """The integrals as constants; com: of the undeformed link in its frame, m."""
    constant, body = store.constant, modes.body
    moment = tuple(constant(float(s)) for s in body.moment)
    rotated = body.first_moment @ link.frame
    size = float(abs(rotated).max(initial=0.0))
    first: list[Vector3] = []
    for s, row in zip(moment, snap(rotated, size), strict=True):
        x, y, z = (constant(float(v)) for v in row)
        first.append(add((x, y, z), scale(s, com)))
    mass = tuple(tuple(constant(float(g)) for g in row) for row in body.mass)
    return ModalInertia(modes, moment, tuple(first), mass)
