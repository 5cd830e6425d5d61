"""`EngineModel`: what a mechanism and its scene are to other engines, before any of it is text.

In: a mechanism and a scene. Out: one frozen record: rigid pieces in a tree, welds that close its loops, what acts,
where it starts, what is lost. Never: knows an effect by name, or a file format.

All frames are parallel to the world's in the drawn configuration, so that the numbers of the mechanism are used as they
are. A joint's axis points so that the engine's angle is lamc's: child relative to parent, zero as drawn.

A cut hinge becomes a hinge of the tree as well. The body beyond it is shared out: one part stays where it was, another
with the same shape hangs on the cut hinge, and a weld holds the two together. Inertia, springs, stops and torques of
all hinges then stand as in any tree, and only the weld is an equation.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from lamc.basics.errors import DesignError, UnsupportedError
from lamc.basics.readonly import ReadOnlyDict
from lamc.effects.engine_loads import EngineLoads, GroundPlane, HingeLoads, Loss, PointSpring, carried
from lamc.effects.registry import choose
from lamc.export.engine_inertia import drawn_jacobian, drawn_mass_matrix, freedoms, robust_inertia, time_step
from lamc.export.engine_names import engine_names
from lamc.export.engine_start import joint_start
from lamc.mechanics.arrangement import FloatingBase
from lamc.mechanics.arranging import arrange
from lamc.mechanism.plan import plan
from lamc.mechanism.tree import WORLD, Cut, Tree
from lamc.records.effect import Effect, overrides
from lamc.records.mechanism import Array, Body, Joint, Mechanism
from lamc.records.scene import Scene
from lamc.records.scene_values import left_to_model, with_values
from lamc.run.following import series_of
from lamc.run.start_checks import check_angles


@dataclass(frozen=True, eq=False)
class EngineJoint:
    """The hinge that carries a piece."""

    name: str  # the engine's
    joint: Joint
    axis: Array  # (3,), world, drawn: the piece turns about it by the joint's angle
    loads: HingeLoads


@dataclass(frozen=True, eq=False)
class Piece:
    """A rigid body of the engine's tree.

    joint    None: it floats
    parent   index of the piece that carries it, or WORLD
    origin   (3,), m, world, drawn: of its frame, on its hinge or at the floating base's centre of mass
    com      (3,), m, from the origin; inertia (3, 3), kg·m², about it; both in axes that are the world's as drawn
    welded   index of the piece that it is held together with, both being parts of one body; None: it is whole, or the
             part that others are held to
    """

    name: str  # the engine's
    body: str  # of the mechanism
    joint: EngineJoint | None
    parent: int
    origin: Array
    mass: float  # kg
    com: Array
    inertia: Array
    welded: int | None = None


@dataclass(frozen=True, eq=False)
class EngineModel:
    """A mechanism in its scene.

    pieces       parents before children, limb after limb
    places       body → index of its piece, WORLD for what is fixed; parts that hang on cut hinges have none
    body_names, joint_names  name in the design → the engine's; floating bases of several bodies are one piece
    angles, rates  at the start, by joint of the design, rad and rad/s
    base         pose and rates at the start of what floats; None: nothing does
    time_step    s, that suits RK4; mass_matrix (nv, nv): as drawn
    inputs       of the scene with their defaults, SI
    """

    name: str
    mechanism: Mechanism
    pieces: tuple[Piece, ...]
    places: Mapping[str, int]
    body_names: Mapping[str, str]
    joint_names: Mapping[str, str]
    cuts: tuple[str, ...]
    gravity: tuple[float, float, float]  # m/s²
    springs: tuple[PointSpring, ...]
    ground: GroundPlane | None
    angles: Mapping[str, float]
    rates: Mapping[str, float]
    base: FloatingBase | None
    mass_matrix: Array
    time_step: float
    inputs: Mapping[str, float]
    lost: tuple[Loss, ...]

    @property
    def hinges(self) -> list[EngineJoint]:
        """In the order of their pieces."""
        return [piece.joint for piece in self.pieces if piece.joint is not None]

    def origin(self, index: int) -> Array:
        """(3,), m, world, of a piece's frame as drawn; zero for the world's."""
        return np.zeros(3) if index == WORLD else self.pieces[index].origin


def engine_model(mechanism: Mechanism, scene: Scene, name: str | None = None) -> EngineModel:
    """What other engines make of `mechanism` in `scene`, named `name` or, by default, as it is itself.

    Raises DesignError where the scene does not fit, or where an effect refuses its start.
    """
    mechanism = with_values(mechanism, scene)
    others = left_to_model(mechanism, scene)
    if others:
        raise UnsupportedError(
            f"the scene gives {', '.join(others[:4])} values of their own, which other engines are not told; "
            "change the "
            "effects themselves"
        )
    effects = [choice.effect for choice in choose(mechanism, scene) if choice.effect is not None]
    tree = plan(mechanism)
    base = _floating(tree, effects)
    fixed = tuple(body.name for body in mechanism.bodies if body.fixed)
    moving = (*(link.body.name for link in tree.links), *(fixed if base is not None else ()))
    loads = carried(mechanism, effects, moving)
    builder = _Builder(tree, base, loads)
    pieces = builder.pieces()
    if not pieces:
        raise DesignError(
            f"nothing moves in {mechanism.name!r}, so there is nothing for another engine to simulate"
        )
    names = builder.names
    angles, rates = joint_start(tree, scene)
    check_angles(effects, mechanism, angles)
    mass_matrix = drawn_mass_matrix(pieces)
    return EngineModel(
        name=engine_names([name or mechanism.name])[0],
        mechanism=mechanism,
        pieces=pieces,
        places=ReadOnlyDict(builder.places),
        body_names=names.bodies,
        joint_names=names.joints,
        cuts=tuple(cut.joint.name for cut in tree.cuts),
        gravity=loads.gravity,
        springs=tuple(loads.springs),
        ground=loads.ground,
        angles=angles,
        rates=rates,
        base=base,
        mass_matrix=mass_matrix,
        time_step=_step(pieces, builder.places, mass_matrix, loads, mechanism.size),
        inputs=ReadOnlyDict({name: each.default for name, each in scene.inputs.items()}),
        lost=(*loads.lost, *_lost_series(scene)),
    )


def _lost_series(scene: Scene) -> list[Loss]:
    """What inputs follow over time: engines take numbers."""
    return [Loss(f"the series that the input {name!r} follows") for name in series_of(scene)]


def _floating(tree: Tree, effects: Sequence[Effect]) -> FloatingBase | None:
    """The floating base, if an effect lets the fixed bodies go. What else effects arrange is lost with them."""
    base = arrange(tree, [effect for effect in effects if overrides(effect, "carry_over")]).base
    return base if isinstance(base, FloatingBase) else None


@dataclass(frozen=True)
class _Names:
    """The engine's names."""

    bodies: Mapping[str, str]
    joints: Mapping[str, str]
    parts: Mapping[str, str]  # by cut joint: of the part that hangs on it


def _named(mechanism: Mechanism, far: Mapping[str, Body]) -> _Names:
    bodies, joints = [b.name for b in mechanism.bodies], [j.name for j in mechanism.joints]
    parts = [f"{body.name}_{joint}" for joint, body in far.items()]
    made = engine_names([*bodies, *parts], reserved=("world",))
    return _Names(
        ReadOnlyDict(zip(bodies, made, strict=False)),
        ReadOnlyDict(zip(joints, engine_names(joints), strict=True)),
        ReadOnlyDict(zip(far, made[len(bodies) :], strict=True)),
    )


def _far_body(cut: Cut, mechanism: Mechanism) -> Body:
    """The body that is shared out where a loop is cut: the joint's child, or its parent where the child is fixed."""
    joint = cut.joint
    return mechanism.body(joint.child if cut.child.link != WORLD else joint.parent)


class _Builder:
    """Makes the pieces of one tree, in the order in which engines number them: limb after limb."""

    def __init__(self, tree: Tree, base: FloatingBase | None, loads: EngineLoads) -> None:
        self.tree, self.base, self.loads = tree, base, loads
        mechanism = tree.mechanism
        self.far = {cut.joint.name: _far_body(cut, mechanism) for cut in tree.cuts}
        self.names = _named(mechanism, self.far)
        root = WORLD if base is None else 0
        self.places = {body.name: root for body in mechanism.bodies if body.fixed}
        self.made: list[Piece] = []

    def pieces(self) -> tuple[Piece, ...]:
        """All of them; `places` is whole afterwards."""
        if self.base is not None:
            self.made.append(self._floating(self.base))
        waiting = self._hanging(WORLD)
        while waiting:
            index, cut = waiting.pop()
            if cut is None:
                link = self.tree.links[index]
                place = self._add(link.joint, link.body, None)
                self.places[link.body.name] = place
                waiting += self._hanging(index)
            else:
                self._add(cut.joint, self.far[cut.joint.name], cut)
        return tuple(self._held(piece) for piece in self.made)

    def _hanging(self, index: int) -> list[tuple[int, Cut | None]]:
        """What hangs on a link, or the world: links, then parts on cut joints, last one first."""
        parts: list[tuple[int, Cut | None]] = []
        for cut in self.tree.cuts:
            near = cut.parent.link if cut.child.link != WORLD else cut.child.link
            if near == index:
                parts.append((index, cut))
        return [*reversed(parts), *((child, None) for child in reversed(self.tree.children(index)))]

    def _add(self, joint: Joint, body: Body, cut: Cut | None) -> int:
        share = 1.0 / (1 + sum(far is body for far in self.far.values()))
        outward = joint.child == body.name
        names = self.names
        carried_by = EngineJoint(
            names.joints[joint.name],
            joint,
            joint.axis if outward else -joint.axis,
            self.loads.of(joint.name),
        )
        self.made.append(
            Piece(
                name=names.bodies[body.name] if cut is None else names.parts[joint.name],
                body=body.name,
                joint=carried_by,
                parent=self.places[joint.parent if outward else joint.child],
                origin=joint.point,
                mass=share * body.mass,
                com=body.com - joint.point,
                inertia=share * robust_inertia(body.inertia),
            )
        )
        return len(self.made) - 1

    def _held(self, piece: Piece) -> Piece:
        whole = self.places[piece.body]
        is_part = piece is not self.made[whole]
        return replace(piece, welded=whole) if is_part else piece

    def _floating(self, base: FloatingBase) -> Piece:
        return Piece(
            name=self.names.bodies[base.bodies[0]],
            body=base.bodies[0],
            joint=None,
            parent=WORLD,
            origin=base.com,
            mass=base.mass,
            com=np.zeros(3),
            inertia=robust_inertia(base.inertia),
        )


def _step(
    pieces: Sequence[Piece], places: Mapping[str, int], mass_matrix: Array, loads: EngineLoads, size: float
) -> float:
    """A time step, s, that suits all springs and dampers."""
    stiffness, damping = np.zeros((2, *mass_matrix.shape))
    for piece, where in zip(pieces, freedoms(pieces), strict=True):
        if piece.joint is not None:
            acting, at = piece.joint.loads, (where[0], where[0])
            stop = acting.stop
            stiffness[at] = abs(acting.stiffness - acting.per_angle) + (stop.stiffness if stop else 0.0)
            damping[at] = abs(acting.damping - acting.per_rate) + (stop.damping if stop else 0.0)
    for spring in loads.springs:
        ends = ((spring.body_b, spring.point_b), (spring.body_a, spring.point_a))
        apart, closer = (drawn_jacobian(pieces, places[b], np.array(p))[0] for b, p in ends)
        moved = apart - closer
        stiffness += spring.stiffness * moved.T @ moved
        damping += spring.damping * moved.T @ moved
    return time_step(mass_matrix, stiffness, damping, math.hypot(*loads.gravity), size)
