"""`InverseDynamics`: the equations of what moves by more than hinges on a fixed world, as residuals.

Goes in: kinematics in the general form, masses, loads. Comes out: M u̇ - f for given u̇ by one pass outwards and one
inwards; f from nought for u̇; M, which is their derivative by u̇, from composite bodies. It solves nothing.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from lamc.mechanics.added_inertia import AddedInertia
from lamc.mechanics.chain_kinematics import ChainKinematics
from lamc.mechanics.chains import LinkState, Wrench, together
from lamc.mechanics.composite import composite_mass_matrix
from lamc.mechanics.elimination import inertia_wrench
from lamc.mechanics.inertia import Inertia
from lamc.mechanics.kinematics import Bias, acceleration_gradient
from lamc.mechanics.loads import Loads
from lamc.mechanics.modal import ModalInertia
from lamc.mechanics.moving_base import StagedFloat
from lamc.mechanics.placement import rotate, rotate_back
from lamc.mechanics.powers import point_motion
from lamc.mechanism.tree import WORLD
from lamc.symbolic.algebra import ZERO, Matrix3, Vector3, add, cross, dot
from lamc.symbolic.derivative import derivatives
from lamc.symbolic.scalars import Scalar, Value

_DRAWN: Matrix3 = ((1, 0, 0), (0, 1, 0), (0, 0, 1))


@dataclass(frozen=True)
class Masses:
    """Inertia of the links about their origins, own frames; centres of mass; what bending adds, by link."""

    inertias: tuple[Inertia, ...]
    coms: tuple[Vector3, ...]
    modal: Mapping[int, ModalInertia]


class InverseDynamics:
    """M u̇ = f by inverse dynamics. Rates in the order of the arrangement's."""

    def __init__(self, kinematics: ChainKinematics, masses: Masses, u: Sequence[Value], loads: Loads) -> None:
        self.kinematics, self._masses, self._u, self._loads = kinematics, masses, u, loads
        self._count = len(kinematics.arrangement.plain_coordinates)

    def residual(self, accelerations: Sequence[Scalar] | None) -> list[Scalar]:
        """M u̇ - f, (nu,): N·m, or N, by rate; None: -f."""
        work, at_base = self._passed(accelerations)
        loads = self._loads
        result: list[Scalar] = [work.get(k, 0) - loads.generalised.get(k, 0) for k in range(self._count)]
        for i, torque in enumerate(loads.hinge_torques):
            result[i] = result[i] - torque
        for i, reflected in sorted(loads.reflected.items()):
            for _, inertia in reflected:
                result[i] = result[i] + inertia * (accelerations[i] if accelerations is not None else 0)
        base = self.kinematics.base
        if isinstance(base, StagedFloat):
            with self.kinematics.store.section("Balance of the base", source="Newton, Euler"):
                result += self._base_balance(base, at_base, accelerations)
        return result

    def base_power(self, accelerations: Sequence[Scalar]) -> Scalar:
        """Power, W, of what moves the base as prescribed."""
        base = self.kinematics.base
        assert base is not None
        _, (force, moment) = self._passed(accelerations)
        return dot(force, base.velocity.linear) + dot(moment, base.velocity.angular)

    def forces(self) -> list[Scalar]:
        """f."""
        return [-value for value in self.residual(None)]

    def mass_matrix(self) -> Mapping[tuple[int, int], Scalar]:
        """Lower triangle of M: composite bodies, and what a fluid adds."""
        kinematics, masses, loads = self.kinematics, self._masses, self._loads
        store = kinematics.store
        with store.section("Mass matrix", source="composite bodies; Walker & Orin 1982"):
            entries = composite_mass_matrix(kinematics, masses.inertias, masses.modal)
        motions = kinematics.motions(self._u)
        for added in loads.added:
            with store.section("Added inertia", effect=added.effect, source="JᵀAJ"):
                velocity, omega = point_motion(loads.placement, added, motions)
                columns = [derivatives([*velocity, *omega], {u: 1}) for u in self._u]
                for (i, j), value in added.projected(columns).items():
                    entries[i, j] = entries.get((i, j), 0) + value
        for i, reflected in sorted(loads.reflected.items()):
            for _, inertia in reflected:
                entries[i, i] = entries.get((i, i), 0) + inertia
        return {key: v for key, v in sorted(entries.items()) if isinstance(v, Value) or v != 0}

    def _passed(self, accelerations: Sequence[Scalar] | None) -> tuple[dict[int, Scalar], Wrench]:
        """Generalised inertia forces less those of wrenches, by coordinate; the wrench that reaches the base."""
        kinematics, loads = self.kinematics, self._loads
        link_states = kinematics.link_states(self._u, accelerations, loads.field)
        own: dict[int, Scalar] = {}
        wrenches: list[Wrench] = []
        with kinematics.store.section("Inertia forces and applied loads", source="eq. 18"):
            for i, link_state in enumerate(link_states):
                kinematics.store.link = i
                wrench = self._inertia_wrench(i, link_state, accelerations, own)
                wrenches.append(_less(wrench, loads.wrenches.get(i)))
            at_base: Wrench = _less((ZERO, ZERO), loads.wrenches.get(WORLD))
            for added in loads.added:
                with kinematics.store.section("Added inertia", effect=added.effect, source="Kirchhoff"):
                    if added.link == WORLD:
                        at_base = together(at_base, self._added_on_base(added, accelerations))
                    else:
                        wrench = self._added_on_link(added, link_states[added.link])
                        wrenches[added.link] = together(wrenches[added.link], wrench)
        work, carried = kinematics.inwards(wrenches)
        for k, value in own.items():
            work[k] = work.get(k, 0) + value
        return work, together(at_base, carried)

    def _inertia_wrench(
        self, i: int, link_state: LinkState, accelerations: Sequence[Scalar] | None, own: dict[int, Scalar]
    ) -> Wrench:
        """Of one link about its origin; `own` gains the inertia forces of its modes."""
        gradient = acceleration_gradient(link_state.omega, link_state.alpha)
        modal, inertia = self._masses.modal.get(i), self._masses.inertias[i]
        if modal is None:
            return inertia_wrench(inertia, Bias(link_state.acceleration, gradient))
        rates = modal.modes.rates(self._u)
        changes = modal.modes.rates(accelerations) if accelerations is not None else None
        own |= modal.equations(link_state, gradient, changes)
        rigid = inertia_wrench(modal.of(inertia), Bias(link_state.acceleration, gradient))
        return together(rigid, modal.wrench(link_state, rates, changes))

    def _added_on_link(self, added: AddedInertia, link_state: LinkState) -> Wrench:
        arm = added.arm
        field = rotate_back(self._loads.placement.carrier(added.link), self._loads.field)
        axes = self.kinematics.drawn_frame(added.link)
        force, moment = _added_wrench(added, link_state, arm, field, axes)
        return force, add(moment, cross(arm, force))

    def _added_on_base(self, added: AddedInertia, accelerations: Sequence[Scalar] | None) -> Wrench:
        base = self.kinematics.base
        assert base is not None
        arm, prescribed = added.arm, base.acceleration(accelerations)
        link_state = LinkState(
            base.velocity.angular, base.velocity.linear, prescribed.angular, prescribed.linear
        )
        force, moment = _added_wrench(added, link_state, arm, ZERO, _DRAWN)
        return force, add(moment, cross(arm, force))

    def _base_balance(
        self, base: StagedFloat, at_base: Wrench, accelerations: Sequence[Scalar] | None
    ) -> list[Scalar]:
        """Of forces in world axes, then of moments about the centre of mass in axes of the base."""
        field, w = self._loads.field, base.velocity.angular
        acceleration = accelerations[-6:-3] if accelerations is not None else ZERO
        force = rotate(base.rotation, at_base[0])
        linear = [base.mass * (a - g) + f for a, g, f in zip(acceleration, field, force, strict=True)]
        rows = base.inertia.rows()
        spin = (dot(rows[0], w), dot(rows[1], w), dot(rows[2], w))
        alpha = accelerations[-3:] if accelerations is not None else ZERO
        turning = [dot(row, alpha) for row in rows]
        gyration = cross(w, spin)
        angular = [t + g + m for t, g, m in zip(turning, gyration, at_base[1], strict=True)]
        return [*linear, *angular]


def _added_wrench(
    added: AddedInertia, link_state: LinkState, arm: Vector3, field: Vector3, axes: Matrix3
) -> Wrench:
    """About the point at `arm`. going: of the origin, less the field; axes: drawn from those of going."""
    velocity = add(link_state.velocity, cross(link_state.omega, arm))
    rows = acceleration_gradient(link_state.omega, link_state.alpha)
    moved = (dot(rows[0], arm), dot(rows[1], arm), dot(rows[2], arm))
    acceleration = add(add(link_state.acceleration, field), moved)
    parts = (velocity, link_state.omega, acceleration, link_state.alpha)
    force, moment = added.wrench(*(rotate(axes, part) for part in parts))
    return rotate_back(axes, force), rotate_back(axes, moment)


def _less(wrench: Wrench, applied: Wrench | None) -> Wrench:
    if applied is None:
        return wrench
    minus = [(-v[0], -v[1], -v[2]) for v in applied]
    return add(wrench[0], minus[0]), add(wrench[1], minus[1])
