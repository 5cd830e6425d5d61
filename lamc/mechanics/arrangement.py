"""`Arrangement`: which coordinates a scene has beyond the angles of the hinges, and how they start. Plain numbers only.

Goes in: what effects ask for (`arranging.py`). Comes out: names and units of coordinates and rates, and states. It is
cheap, holds no symbol, and is made for every simulator, whether its code is new or cached.

Coordinates, in this order: the hinges, those of the tree first; what compliant hinges add; modes of flexible bodies;
gears with play, all of which have q̇ = u; angles of hinges that close loops and yield, which have no rate of their own
but follow from the others, and count turns; a floating base. The base has seven coordinates, the world position of its
centre of mass and a quaternion of any norm (world from drawn axes), and six rates, the velocity of that point in world
axes and the angular velocity in axes of the body.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from lamc.basics.checks import Array
from lamc.loops.geometry import LoopGeometry
from lamc.mechanics.compliant_hinge import CROSS_FREEDOMS as CROSS_FREEDOMS
from lamc.mechanics.compliant_hinge import FREEDOMS as FREEDOMS
from lamc.mechanics.compliant_hinge import CompliantHinge as CompliantHinge
from lamc.mechanics.flexible import FlexibleBody
from lamc.mechanics.gears import gear_name
from lamc.mechanism.tree import Cut, Tree
from lamc.symbolic.program import Coordinate

if TYPE_CHECKING:
    from lamc.symbolic.scalars import Scalar

BASE_COORDINATES = (
    *((f"base.{axis}", "m") for axis in "xyz"),
    *((f"base.q{part}", "1") for part in "wxyz"),
)
BASE_RATES = (*((f"base.v{axis}", "m/s") for axis in "xyz"), *((f"base.w{axis}", "rad/s") for axis in "xyz"))


@dataclass(frozen=True, eq=False)
class FloatingBase:
    """The fixed bodies as one rigid body that moves freely.

    bodies    their names
    mass      kg; com (3,), m, and inertia (3, 3), kg·m², about it: of all together, as drawn, world axes
    position  of the centre of mass at the start, (3,), m, world
    rotation  world from drawn axes at the start: unit quaternion (w, x, y, z)
    velocity  of the centre of mass at the start, (3,), m/s, world axes
    spin      angular velocity at the start, (3,), rad/s, axes of the body
    """

    bodies: tuple[str, ...]
    mass: float
    com: Array
    inertia: Array
    position: Array
    rotation: Array
    velocity: Array
    spin: Array
    effect: str = ""  # who asked for it; `Arranging` fills it in


@dataclass(frozen=True, eq=False)
class PrescribedBase:
    """The fixed bodies, moved as prescribed: a drawn point d is at point + Rot(axis, angle) (d - point) + displacement.

    motion       stages the displacement (x, y, z), m, world, and the angle, rad, for a staged time, s, and the staged
                 inputs of the scene by name
    axis, point  unit vector and a point of the axis, m; both (3,), world, drawn
    """

    bodies: tuple[str, ...]
    motion: "Callable[[Scalar, Mapping[str, Scalar]], tuple[Scalar, Scalar, Scalar, Scalar]]"
    axis: Array
    point: Array
    effect: str = ""  # who asked for it; `Arranging` fills it in


@dataclass(frozen=True, eq=False)
class Bushing:
    """A compliant hinge that closes a loop: its two sides are held by its stiffness, and by no equation."""

    cut: Cut
    hinge: CompliantHinge


@dataclass(frozen=True, eq=False)
class Arrangement:
    """What a scene's equations are written in.

    tree              the mechanism's tree; its `cuts` without those that bushings hold
    base              None: fixed to the world
    compliant         compliant hinges of the tree, in its order
    bushings          compliant hinges of its cuts, in their order
    flexible          flexible bodies, in the tree's order
    gears             joints whose gears turn by themselves, in the order of the hinges
    inverse_dynamics  an effect asks for equations in the general form, M u̇ = f from inverse dynamics
    """

    tree: Tree
    base: FloatingBase | PrescribedBase | None = None
    compliant: tuple[CompliantHinge, ...] = ()
    bushings: tuple[Bushing, ...] = ()
    flexible: tuple[FlexibleBody, ...] = ()
    gears: tuple[str, ...] = ()
    inverse_dynamics: bool = False

    @property
    def is_plain(self) -> bool:
        """Hinges on a fixed world, nothing else: u̇ is solved for symbolically, and nothing here has a trace."""
        added = self.compliant or self.bushings or self.flexible or self.gears
        return self.base is None and not added and not self.inverse_dynamics

    @property
    def yields(self) -> bool:
        """Whether hinges or bodies yield, so that loops close by more than the angles of hinges."""
        return len(self.plain_coordinates) > len(self.tree.hinges) + len(self.gears)

    @property
    def held(self) -> tuple[str, ...]:
        """Names of the hinges that bushings hold."""
        return tuple(bushing.cut.joint.name for bushing in self.bushings)

    @property
    def coordinates(self) -> tuple[Coordinate, ...]:
        """Of q, shape (nq,)."""
        own = BASE_COORDINATES if isinstance(self.base, FloatingBase) else ()
        counted = (Coordinate(name, "rad") for name in self.held)
        return (*self.plain_coordinates, *counted, *(Coordinate(*entry) for entry in own))

    @property
    def rates(self) -> tuple[Coordinate, ...]:
        """Of u, shape (nu,)."""
        own = BASE_RATES if isinstance(self.base, FloatingBase) else ()
        plain = (Coordinate(c.name, f"{c.unit}/s") for c in self.plain_coordinates)
        return (*plain, *(Coordinate(*entry) for entry in own))

    @property
    def plain_coordinates(self) -> tuple[Coordinate, ...]:
        """Those with q̇ = u: the first ones."""
        hinges = (Coordinate(joint.name, "rad") for joint in self.tree.hinges)
        across = (
            Coordinate(f"{hinge.joint}.{freedom}", "rad" if freedom.startswith("twist") else "m")
            for hinge in self.compliant
            for freedom in CROSS_FREEDOMS
            if freedom in hinge.freedoms
        )
        modes = (
            Coordinate(f"{body.body}.mode_{k + 1}", body.unit)
            for body in self.flexible
            for k in range(body.count)
        )
        gears = (Coordinate(gear_name(joint), "rad") for joint in self.gears)
        return (*hinges, *across, *modes, *gears)

    @property
    def moving_bodies(self) -> tuple[str, ...]:
        """Names in the order of the poses: the tree's links, then the fixed bodies where the base moves."""
        links = tuple(link.body.name for link in self.tree.links)
        return (*links, *(self.base.bodies if self.base is not None else ()))

    @property
    def drawn(self) -> Array:
        """State (nq + nu,) at rest in the drawn configuration."""
        base = self.base
        if isinstance(base, FloatingBase):
            still = np.zeros(3)
            identity = np.array([1.0, 0.0, 0.0, 0.0])
            placed = replace(base, position=base.com, rotation=identity, velocity=still, spin=still)
            still_joints = [0.0] * len(self.tree.hinges)
            return np.concatenate(replace(self, base=placed).start(still_joints, still_joints))
        return np.zeros(len(self.coordinates) + len(self.rates))

    @property
    def displaced(self) -> tuple[float, ...]:
        """`drawn` as numbers; empty where all are zero, as they are without a base that floats."""
        state = tuple(self.drawn.tolist())
        return state if any(state) else ()

    def start(
        self, q_joints: Sequence[float], u_joints: Sequence[float], near: Mapping[str, float] | None = None
    ) -> tuple[Array, Array]:
        """q (nq,) and u (nu,) from the joints' angles, rad, and rates, rad/s; hinges and bodies start undeformed, gears
        in the middle of their play.

        near: angles of hinges that bushings hold, by name, rad, that theirs are within half a turn of; else nought
        """
        rest = len(self.plain_coordinates) - len(q_joints) - len(self.gears)
        geared = [index for index, joint in enumerate(self.tree.hinges) if joint.name in self.gears]
        q, u = (
            np.concatenate([own, np.zeros(rest), np.take(own, geared)])
            for own in (np.asarray(q_joints, dtype=np.float64), np.asarray(u_joints, dtype=np.float64))
        )
        q = np.append(q, self._held_angles(q_joints, near or {}))
        base = self.base
        if isinstance(base, FloatingBase):
            q = np.concatenate([q, base.position, base.rotation])
            u = np.concatenate([u, base.velocity, base.spin])
        return q, u

    def _held_angles(self, q_joints: Sequence[float], near: Mapping[str, float]) -> Array:
        """Of the hinges that bushings hold, rad, from where the joints' angles put their two sides."""
        if not self.bushings:
            return np.zeros(0)
        geometry, angles = LoopGeometry(self.tree), []
        rotation = geometry.poses(np.asarray(q_joints)).rotation
        for bushing in self.bushings:
            cut, axes = bushing.cut, bushing.hinge.axes
            r = (rotation[cut.parent.link] @ axes).T @ rotation[cut.child.link] @ axes
            close = near.get(cut.joint.name, 0.0)
            turn = math.atan2(-r[0, 1], r[0, 0])
            angles.append(close + math.remainder(turn - close, 2.0 * math.pi))
        return np.array(angles)
