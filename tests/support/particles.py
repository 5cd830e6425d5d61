"""Mechanisms as clouds of particles: accelerations from positions alone, for tests of the general form.

Every body becomes a few particles of the same mass, centre and second moments. Where they are follows from the
coordinates by rotations about drawn axes (Rodrigues), written here anew; velocities are complex steps of positions,
accelerations differences of those. M u̇ = f is then Σ m JᵀJ u̇ = Σ Jᵀ(F - m J̇u): no frame of a link, no inertia tensor
and no recursion of the derivation comes into it.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from lamc.mechanics.arrangement import CROSS_FREEDOMS, Arrangement, CompliantHinge, FloatingBase
from lamc.mechanics.flexible import FlexibleBody
from lamc.mechanism.tree import Link
from lamc.records.mechanism import Body

Array = npt.NDArray[np.float64]
Place = tuple[npt.NDArray[np.complex128], npt.NDArray[np.complex128]]  # drawn point d is at R d + x

STEP = 1e-30  # of complex steps: no difference is formed
STRIDE = 2e-3  # s, of differences of velocities, order 8: errors some 1e-12 of the motion's jerk


def rodrigues(axis: Array, angle: complex) -> npt.NDArray[np.complex128]:
    """Rotation about a unit vector, for complex angles too."""
    k = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]], dtype=complex)
    return np.eye(3) + np.sin(angle) * k + (1.0 - np.cos(angle)) * (k @ k)


def about(axis: Array, point: Array, angle: complex, slide: npt.ArrayLike = (0.0, 0.0, 0.0)) -> Place:
    """A turn about a drawn line, then a slide."""
    rotation = rodrigues(axis, angle)
    return rotation, point - rotation @ point + np.asarray(slide)


def after(outer: Place, inner: Place) -> Place:
    """First `inner`, then `outer`."""
    return outer[0] @ inner[0], outer[0] @ inner[1] + outer[1]


def cloud(body: Body) -> tuple[Array, Array]:
    """Masses (6,) and drawn places (6, 3) with the body's mass, centre and second moments."""
    moments = 0.5 * np.trace(body.inertia) * np.eye(3) - body.inertia
    squares, axes = np.linalg.eigh(moments)
    arms = axes * np.sqrt(3.0 * np.maximum(squares, 0.0) / body.mass)
    return np.full(6, body.mass / 6.0), body.com + np.vstack([arms.T, -arms.T])


@dataclass(frozen=True)
class Plate:
    """A flexible body of particles with masses (m,) at drawn places (m, 3), bending by phi (m, k) along its normal."""

    masses: Array
    places: Array
    phi: Array


class Cloud:
    """The particles of an arrangement. plates: those of its flexible bodies, by name."""

    def __init__(self, arrangement: Arrangement, plates: dict[str, Plate] | None = None) -> None:
        self.arrangement, self.plates = arrangement, plates or {}
        self.index = {c.name: i for i, c in enumerate(arrangement.coordinates)}
        self.compliant = {hinge.joint: hinge for hinge in arrangement.compliant}
        self.flexible = {body.body: body for body in arrangement.flexible}
        self.floats = isinstance(arrangement.base, FloatingBase)
        masses = [self._particles(link.body)[0] for link in arrangement.tree.links]
        if isinstance(arrangement.base, FloatingBase):
            base = arrangement.base
            self.base = cloud(Body("base", base.mass, base.com, base.inertia))
            masses.append(self.base[0])
        self.masses = np.concatenate(masses)

    def _particles(self, body: Body) -> tuple[Array, Array]:
        plate = self.plates.get(body.name)
        return (plate.masses, plate.places) if plate else cloud(body)

    def places(self, base: Place, q: npt.NDArray[np.complex128]) -> npt.NDArray[np.complex128]:
        """World places of all particles, (m, 3), with coordinates q; `base` is where the drawn world has gone."""
        placed: list[Place] = []
        rows = []
        for i, link in enumerate(self.arrangement.tree.links):
            inner = base if link.parent < 0 else after(placed[link.parent], self._surface(link, q))
            placed.append(after(inner, self._hinge(i, link, q)))
            _, drawn = self._particles(link.body)
            local = drawn.astype(complex)
            if link.body.name in self.plates:
                local = local + np.outer(self._bent(link.body.name, q), self.flexible[link.body.name].normal)
            rows.append(local @ placed[i][0].T + placed[i][1])
        if self.floats:
            rows.append(self.base[1] @ base[0].T + base[1])
        return np.vstack(rows)

    def _bent(self, name: str, q: npt.NDArray[np.complex128]) -> npt.NDArray[np.complex128]:
        return np.asarray(self.plates[name].phi @ self._eta(name, q))

    def _eta(self, name: str, q: npt.NDArray[np.complex128]) -> npt.NDArray[np.complex128]:
        first = self.index[f"{name}.mode_1"]
        return q[first : first + self.flexible[name].count]

    def _surface(self, link: Link, q: npt.NDArray[np.complex128]) -> Place:
        """What bending does to a hinge on a flexible parent, as drawn: lift, after turns by the slopes."""
        name = self.arrangement.tree.links[link.parent].body.name
        body = self.flexible.get(name)
        if body is None:
            return np.eye(3, dtype=complex), np.zeros(3, dtype=complex)
        point, eta = link.joint.point, self._eta(name, q)
        phi, slopes = body.shape_at(point)
        helper = np.eye(3)[int(np.argmin(np.abs(body.normal)))]
        first = np.cross(helper, body.normal)
        first /= np.linalg.norm(first)
        second = np.cross(body.normal, first)
        rotated = after(
            about(first, point, second @ slopes.T @ eta), about(second, point, -(first @ slopes.T @ eta))
        )
        return rotated[0], rotated[1] + body.normal * (phi @ eta)

    def _hinge(self, i: int, link: Link, q: npt.NDArray[np.complex128]) -> Place:
        """What the joint does to the outer body, as drawn."""
        joint = link.joint
        sense = 1.0 if joint.child == link.body.name else -1.0
        place = about(joint.axis, joint.point, sense * q[i])
        hinge: CompliantHinge | None = self.compliant.get(joint.name)
        if hinge is None:
            return place
        p = {f: q[self.index[f"{joint.name}.{f}"]] if f in hinge.freedoms else 0.0 for f in CROSS_FREEDOMS}
        x, y, _ = hinge.axes.T
        slide = hinge.axes @ np.array([p["slide_x"], p["slide_y"], p["slide_z"]])
        twists = about(x, hinge.point, sense * p["twist_x"]), about(y, hinge.point, sense * p["twist_y"])
        moved: Place = (np.eye(3), sense * slide)
        if sense > 0:  # what yields rides on the parent: the turn of the child comes first
            return after(moved, after(after(*twists), place))
        return after(place, after(after(twists[1], twists[0]), moved))

    def path(
        self, q: Array, u: Array, reported: Callable[[complex], Place] | None = None
    ) -> Callable[[complex], Array]:
        """World places of all particles after a time s in which the rates u do not change.

        told: where the drawn world is after s; None: still, or floating with the state's rates.
        """
        n = len(self.arrangement.plain_coordinates)
        spin = float(np.linalg.norm(u[-3:])) if self.floats else 0.0

        def base(s: complex) -> Place:
            if reported is not None:
                return reported(s)
            if not isinstance(self.arrangement.base, FloatingBase):
                return np.eye(3, dtype=complex), np.zeros(3, dtype=complex)
            w, *r = q[-4:] / np.linalg.norm(q[-4:])
            columns = [v + 2 * w * np.cross(r, v) + 2 * np.cross(r, np.cross(r, v)) for v in np.eye(3)]
            rotation = np.column_stack(columns).astype(complex)
            if spin:
                rotation = rotation @ rodrigues(u[-3:] / spin, spin * s)
            return rotation, q[-7:-4] + s * u[-6:-3] - rotation @ self.arrangement.base.com

        return lambda s: self.places(base(s), q[:n] + s * u[:n])

    def acceleration(
        self,
        q: Array,
        u: Array,
        forces: Array,
        gravity: Sequence[float],
        reported: Callable[[complex], Place] | None = None,
    ) -> Array:
        """u̇ under generalised forces (nu,) and gravity. told: a function of the time from now, for a moved base."""
        count = len(u)
        columns = []
        for j in range(count):
            still = None if reported is None else (lambda s: reported(0.0))
            moved = self.path(q, np.eye(count)[j], still)
            columns.append(np.imag(moved(1j * STEP)) / STEP)
        jacobian = np.stack(columns, axis=-1)  # (particles, 3, nu)
        path = self.path(q, u, reported)
        weights = np.array([4 / 5, -1 / 5, 4 / 105, -1 / 280])
        bias = np.zeros_like(jacobian[..., 0])
        for k, weight in enumerate(weights, 1):
            ahead, behind = (np.imag(path(s * k * STRIDE + 1j * STEP)) / STEP for s in (1.0, -1.0))
            bias = bias + weight * (ahead - behind) / STRIDE
        mass = np.einsum("p,pij,pik->jk", self.masses, jacobian, jacobian)
        pull = np.einsum("p,pij,pi->j", self.masses, jacobian, np.asarray(gravity) - bias)
        return np.linalg.solve(mass, forces + pull)


def plate_of(body: FlexibleBody, masses: Array, places: Array) -> Plate:
    """The particles of a flexible body whose integrals are sums over them."""
    return Plate(masses, places, np.array([body.shape_at(p)[0] for p in places]))
