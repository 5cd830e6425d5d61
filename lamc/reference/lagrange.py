"""The principle of virtual power on poses as 4 by 4 matrices, for hinges that yield, bodies that bend and air's mass.

A state goes in, accelerations, energies and poses come out; numbers only. A body is P b, a matrix P that moves times
functions b of its material points: coordinates, 1, and the shapes in which it bends. With J = ∫ρ b bᵀ the inertia
forces are tr(∂P/∂u_k J P̈ᵀ), for rigid bodies and for those that bend alike (J. J. Uicker 1965; A. A. Shabana, Dynamics
of Multibody Systems, ch. 5). There is no recursion of velocities, no angular velocity and no frame of a link here.

From the effects' `arrange` come numbers: stiffness matrices, axes and freedoms of hinges; mass and stiffness of modes
and their shapes at points.
"""

import math
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from lamc.mechanics.arranging import arrange
from lamc.mechanics.flexible import FlexibleBody
from lamc.mechanism.plan import plan
from lamc.records.mechanism import Body, Mechanism
from lamc.reference.chain_poses import Chain, Placed
from lamc.reference.closure import perpendicular
from lamc.reference.constrained import constrained, split
from lamc.reference.curves import Curve, still
from lamc.reference.elastic import Elastic
from lamc.reference.hinge_sides import Sides, apart
from lamc.reference.kinematics import Array, walk
from lamc.reference.loads import numeric_loads
from lamc.reference.moving_base import MOVING

_DIGIT, _TRIES = 2.2e-16, 3
ARRANGED = (*MOVING, "flexible_links", "twist_compliance")  # effects that act by coordinates alone


class Lagrange:
    """Equations of motion as numbers, of all that a scene may arrange. States as the compiler has them.

    joints  all but those that close a loop and are held there by their stiffness, in the order of q
    rates   names of u
    acting  effects among these whose loads are known here; None: all, and another one is refused

    `bodies` names the moving bodies in the order of `poses`; `cuts` the joints that close loops rigidly, `held` those
    that do so by stiffness: their coordinates, after the first `own`, tell how often they have turned. Raises
    UnsupportedError for an effect that this cross-check does not know.
    """

    def __init__(
        self,
        mechanism: Mechanism,
        effects: Iterable[Any],
        joints: Sequence[str],
        rates: Sequence[str],
        acting: Iterable[Any] | None = None,
    ) -> None:
        effects = tuple(effects)
        found = arrange(plan(mechanism), effects)
        self.joints, self.size = tuple(joints), mechanism.size
        yielding = {hinge.joint: hinge for hinge in found.compliant}
        # What yields does so against the hinge through which the compiler enters it.
        yields = found.compliant or found.flexible
        links = walk(mechanism, joints, [link.joint.name for link in found.tree.links if yields])
        fixed = [body for body in mechanism.bodies if body.fixed]
        mover = next((effect for effect in effects if effect.name in MOVING), None)
        self._bushings = {bushing.hinge.joint: bushing.hinge for bushing in found.bushings}
        self._bending = {record.body: record for record in found.flexible}
        self._chain = Chain(links, fixed, mover, yielding, self._bending, tuple(rates))
        walked = {link.joint.name for link in links}
        self.cuts = tuple(name for name in self.joints if name not in walked)
        self.held = tuple(self._bushings)
        self._closing = [mechanism.joint(name) for name in (*self.cuts, *self.held)]
        moving = [link.body for link in links]
        self.bodies = tuple(body.name for body in (*moving, *(fixed if mover is not None else ())))
        # What moves as prescribed needs no force for itself.
        self.floats = mover is not None and mover.name == "free_base"
        self.own = len(self._chain.rates) - 6 * self.floats
        self._inertias = [
            (body, _inertia(body, self._bending.get(body.name)))
            for body in (*moving, *(fixed if self.floats else ()))
        ]
        self._centres = {body.name: body.com for body in mechanism.bodies}
        others = [effect for effect in (effects if acting is None else acting) if effect.name not in ARRANGED]
        names = (*self.joints, *self.held)
        self._loads = numeric_loads(mechanism, others, names, self.bodies if mover is not None else None)
        self._slots = [self._chain.index[name] for name in self.joints]
        self._elastic = Elastic(self._chain, self._bushings, self.size)

    def acceleration(self, q: Array, u: Array, t: float = 0.0) -> Array:
        """du/dt, (nu,)."""
        return _solved(*self._system(q, u, t))

    def _system(self, q: Array, u: Array, t: float) -> tuple[Array, Array, Array, Array]:
        """M (nu, nu), f (nu,), and J (6 c, nu) and γ (6 c,) of the joints that close loops rigidly."""
        placed, sides = self._state(q, u, t)
        mass, force = self._inertia_forces(placed)
        angles, rates = self._angles(q, u, sides)
        torque = self._loads.hinge_torques(t, angles, rates)
        n, held = len(self.joints), sides[len(self.cuts) :]
        force[self._slots] += torque[:n]
        for side, value in zip(held, torque[n:], strict=True):
            force += value * side.partials[:, 2]
        for push in self._loads.pushes(t, placed):
            force += placed.particle(push.body, push.point).partials @ push.force
            if push.moment is not None:
                force += _turns(placed.poses[push.body]) @ push.moment
        self._add_fluid(placed, mass, force)
        self._push_by_gears(q, u, t, force)
        for spring in self._elastic.at(q, u, held):
            force -= spring.force()
        seconds = [
            np.append(side.gap.second, self.size * side.angle_second) for side in sides[: len(self.cuts)]
        ]
        return mass, force, self._jacobian(sides), np.concatenate([np.zeros(0), *seconds])

    def energy(self, q: Array, u: Array, t: float = 0.0) -> dict[str, float]:
        """Energy by name, J, in the world's frame: "kinetic" first, then what each effect stores."""
        placed, sides = self._state(q, u, t)
        values, moment = {"kinetic": 0.0}, np.zeros(3)
        for body, J in self._inertias:
            P = self._matrix(placed, body)
            values["kinetic"] += 0.5 * float(np.einsum("ij,jm,im->", P.first, J, P.first))
            moment += (P.value @ J)[:, 3]
        values |= self._loads.stored(t, self._angles(q, u, sides)[0], moment, placed)
        for fluid in self._loads.fluid:
            moved, normal = _pair(placed, fluid.body, fluid.moving, fluid.normal)
            speed = float(normal.value @ moved.first)
            values[fluid.effect] += 0.5 * fluid.mass * speed**2
        for effect, k, inertia in self._loads.reflected:
            values[effect] += 0.5 * inertia * float(u[self._slots[k]]) ** 2
        for gear in self._loads.gears:
            i, k = self._chain.index[f"{gear.joint}.gear"], self._slots[gear.place]
            values["servo"] += gear.energy(q[i] - q[k], u[i])
        for spring in self._elastic.at(q, u, sides[len(self.cuts) :]):
            values[spring.effect] = values.get(spring.effect, 0.0) + spring.energy()
        return values

    def gaps(self, q: Array) -> tuple[Array, Array]:
        """Residuals (6 c,), m, of the joints that close loops rigidly, and their Jacobian (6 c, nu)."""
        _, sides = self._state(q, np.zeros(len(self._chain.rates)), 0.0)
        found = [np.zeros(0)]
        for name, side in zip(self.cuts, sides, strict=False):
            beyond = math.remainder(side.amounts[2] - q[self._chain.index[name]], 2.0 * math.pi)
            found.append(np.append(side.gap.value, self.size * beyond))
        return np.concatenate(found), self._jacobian(sides)

    def _jacobian(self, sides: Sequence[Sides]) -> Array:
        """Five rows of position and direction, then that of the angle beyond the joint's coordinate, m."""
        rows = [np.zeros((0, len(self._chain.rates)))]
        for name, side in zip(self.cuts, sides, strict=False):
            beyond = side.partials[:, 2].copy()
            beyond[self._chain.index[name]] -= 1.0
            rows += [side.gap.partials.T, self.size * beyond[None]]
        return np.concatenate(rows)

    def poses(self, q: Array, t: float = 0.0) -> tuple[Array, Array]:
        """Centres of mass as drawn (m, 3), m, and rotations (m, 3, 3), drawn axes to world, by `bodies`."""
        placed = self._chain.at(q, np.zeros(len(self._chain.rates)), t)
        matrices = [placed.poses[name].value for name in self.bodies]
        centres = [m @ np.append(self._centres[b], 1.0) for b, m in zip(self.bodies, matrices, strict=True)]
        return np.array(centres)[:, :3], np.array(matrices)[:, :3, :3]

    def typical(self) -> tuple[Array, Array]:
        """Deflections and their rates, both (nu,), at which elastic forces are as large as the weight; 0 elsewhere."""
        return self._elastic.typical(9.81 * sum(body.mass for body, _ in self._inertias))

    def elastic_acceleration(self, q: Array, gap: float) -> float:
        """The largest acceleration that one entry of the elastic forces alone would make: where strips and plates
        nearly balance their loads, accelerations are left-overs of such. 0 where nothing yields.

        gap  rad and sizes, by which deflections of hinges count as larger that follow from positions, not coordinates
        """
        nothing = np.zeros(len(self._chain.rates))
        placed, sides = self._state(q, nothing, 0.0)
        springs = self._elastic.at(q, nothing, sides[len(self.cuts) :])
        free = split(self._jacobian(sides)).free
        return self._elastic.largest_acceleration(self._inertia_forces(placed)[0], free, springs, gap)

    def rounded(self, q: Array, u: Array, t: float) -> float:
        """The most that accelerations change where coordinates, rates and forces are other in the last digit, angles by
        that of 1 rad: what no solver of these equations can know better."""
        rng, n = np.random.default_rng(0), len(self.joints)
        found, most = self.acceleration(q, u, t), 0.0
        for _ in range(_TRIES):
            signs = [rng.choice([-1.0, 1.0], len(x)) for x in (q, u, u)]
            sizes = np.concatenate([np.maximum(np.abs(q[:n]), 1.0), np.abs(q[n:])]), np.abs(u)
            near = [x + _DIGIT * s * size for x, s, size in zip((q, u), signs[:2], sizes, strict=True)]
            mass, force, jacobian, bias = self._system(near[0], near[1], t)
            moved = _solved(mass, force * (1.0 + _DIGIT * signs[2]), jacobian, bias)
            most = max(most, float(np.abs(moved - found).max()))
        return most

    def _state(self, q: Array, u: Array, t: float) -> tuple[Placed, list[Sides]]:
        placed = self._chain.at(q, u, t)
        sides = []
        for joint in self._closing:
            hinge = self._bushings.get(joint.name)
            axes = np.vstack([perpendicular(joint.axis), joint.axis]).T if hinge is None else hinge.axes
            point = joint.point if hinge is None else hinge.point
            parent, child = (placed.surface(body, point) for body in (joint.parent, joint.child))
            sides.append(apart(parent, child, axes, point, self.size))
        counted = q[self.own : self.own + len(self.held)]
        for side, near in zip(sides[len(self.cuts) :], counted, strict=True):
            side.amounts[2] = near + math.remainder(side.amounts[2] - near, 2.0 * math.pi)
        return placed, sides

    def _angles(self, q: Array, u: Array, sides: Sequence[Sides]) -> tuple[Array, Array]:
        """Of `joints`, then of those that stiffness holds, rad and rad/s."""
        held = sides[len(self.cuts) :]
        angles = np.append(q[self._slots], [side.amounts[2] for side in held])
        return angles, np.append(u[self._slots], [side.rates[2] for side in held])

    def _matrix(self, placed: Placed, body: Body) -> Curve:
        """P, (3, 4 + modes): world positions are P (r, 1, φ), r from the drawn centre of mass."""
        columns = np.eye(4)
        columns[:3, 3] = body.com
        record = self._bending.get(body.name)
        if record is None:
            local = still(columns, len(self._chain.rates))
        else:
            shapes = np.hstack([np.zeros((record.count, 4)), np.eye(record.count)])
            columns = np.hstack([columns, np.zeros((4, record.count))])
            local = placed.bent(body.name, columns, shapes)
        return (placed.poses[body.name] @ local).block(0, local.value.shape[1])

    def _inertia_forces(self, placed: Placed) -> tuple[Array, Array]:
        """M (nu, nu), and what unchanging rates and gravity ask for, (nu,)."""
        count = len(self._chain.rates)
        mass, force = np.zeros((count, count)), np.zeros(count)
        for body, J in self._inertias:
            P = self._matrix(placed, body)
            momenta = P.partials @ J
            mass += np.tensordot(momenta, P.partials, axes=([1, 2], [1, 2]))
            force -= np.tensordot(momenta, P.second, axes=([1, 2], [0, 1]))
            force += momenta[:, :, 3] @ self._loads.gravity
        turning = [(self._slots[k], inertia) for _, k, inertia in self._loads.reflected]
        turning += [(self._chain.index[f"{gear.joint}.gear"], gear.inertia) for gear in self._loads.gears]
        for i, inertia in turning:
            mass[i, i] += inertia
        return mass, force

    def _push_by_gears(self, q: Array, u: Array, t: float, force: Array) -> None:
        """Gears with play: a turning mass beside the bodies, that its motor drives and whose flanks push the joint."""
        for gear in self._loads.gears:
            i, k = self._chain.index[f"{gear.joint}.gear"], self._slots[gear.place]
            push = gear.push(q[i] - q[k], u[i] - u[k])
            force[i] += gear.motor({"t": t, "angle": float(q[i]), "rate": float(u[i])}) - push
            force[k] += push

    def _add_fluid(self, placed: Placed, mass: Array, force: Array) -> None:
        """Lagrange's equations of ½ m s², s = n · v: m (ṡ n + s ṅ) · δx - m s δn · v."""
        for fluid in self._loads.fluid:
            moved, normal = _pair(placed, fluid.body, fluid.moving, fluid.normal)
            velocity = moved.first - fluid.wind
            speed = float(normal.value @ velocity)
            change = float(normal.first @ velocity + normal.value @ moved.second)
            along = moved.partials @ normal.value
            mass += fluid.mass * np.outer(along, along)
            rotated = moved.partials @ normal.first - normal.partials @ velocity
            force -= fluid.mass * (change * along + speed * rotated)


def _solved(mass: Array, force: Array, jacobian: Array, bias: Array) -> Array:
    if not len(jacobian):
        return np.asarray(np.linalg.solve(mass, force), dtype=np.float64)
    return constrained(mass, force, jacobian, bias)


def _inertia(body: Body, record: FlexibleBody | None) -> Array:
    """∫ρ b bᵀ, b = (r, 1, φ), r from the drawn centre of mass."""
    count = 0 if record is None else record.count
    J = np.zeros((4 + count, 4 + count))
    J[:3, :3] = 0.5 * np.trace(body.inertia) * np.eye(3) - body.inertia
    J[3, 3] = body.mass
    if record is not None:
        J[:3, 4:], J[3, 4:], J[4:, 4:] = record.first_moment.T, record.moment, record.mass
        J[4:, :4] = J[:4, 4:].T
    return J


def _pair(placed: Placed, body: str, moving: Array, normal: Array) -> tuple[Curve, Curve]:
    pose = placed.poses[body]
    columns = np.column_stack([moving, np.append(normal, 0.0)])
    both = pose.times(columns)
    return both.block(0, 1).flat(), both.block(1, 2).flat()


def _turns(pose: Curve) -> Array:
    """Angular velocity by each rate, (n, 3), world: from dR Rᵀ."""
    spin = pose.partials[:, :3, :3] @ pose.value[:3, :3].T
    return np.stack([spin[:, 2, 1], spin[:, 0, 2], spin[:, 1, 0]], axis=1)
