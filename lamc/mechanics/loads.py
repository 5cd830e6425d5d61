"""`Loads`: what effects contribute to, and all that the derivation knows of them.

Goes in: symbolic loads, stored energies and parameters, from `Effect.contribute`. Comes out: hinge torques, a
uniform field, wrenches on links and energies, in the order in which they came. A user's own effect does the same
as lamc's: see `Effect` in `lamc/records/effect.py`.
"""

import numbers
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeVar

from lamc.basics.errors import DesignError
from lamc.mechanics.added_inertia import AddedInertia
from lamc.mechanics.body_points import BodyPoints, drawn_point
from lamc.mechanics.drawn import keyed
from lamc.mechanics.guards import Clock, Guard, held_index
from lamc.mechanics.parameters import Parameters
from lamc.mechanics.placement import Placement, local_point, rotate_back
from lamc.mechanics.powers import Account
from lamc.mechanism.tree import WORLD
from lamc.records.mechanism import Array, Joint, checked_number
from lamc.symbolic.algebra import ZERO, Vector3, add, cross
from lamc.symbolic.program import Space
from lamc.symbolic.scalars import Scalar, Value
from lamc.symbolic.staging import NO_LINK

if TYPE_CHECKING:
    import sympy as sp

Item = TypeVar("Item")


@dataclass(frozen=True)
class Hinge:
    """One hinge as effects see it."""

    joint: Joint
    angle: Scalar  # rad, child relative to parent, zero as drawn
    rate: Scalar  # rad/s


@dataclass(frozen=True)
class SeenHinge:
    """A hinge whose coordinate has no rate of its own. angle rad; rate rad/s; both child relative to parent.

    gradient  ∂angle/∂q, by which its torque does work
    """

    joint: Joint
    angle: Scalar
    rate: Scalar
    gradient: tuple[Scalar, ...]


class Loads(BodyPoints):
    """Collects the loads of one scene on one tree.

    Scalars are `Value`s, plain numbers, or sympy expressions in t, inputs of the scene by name and, by joint name,
    q_<joint> and u_<joint>, and in whatever this record gave: sympy.sqrt(loads.parameter(…)) is an expression like any
    other.
    Vectors are triples in world axes.
    """

    def __init__(
        self,
        placement: Placement,
        parameters: Parameters,
        time: Scalar,
        q: Sequence[Scalar],
        u: Sequence[Scalar],
        bushings: Sequence[SeenHinge] = (),
        inputs: Mapping[str, Scalar] | None = None,
    ) -> None:
        super().__init__(placement, u)
        tree = self.tree
        self.time = time
        self.inputs: Mapping[str, Scalar] = (
            inputs or {}
        )  # of the scene, by name; constant, or they follow a series
        self.hinge_torques: list[Scalar] = [0] * len(tree.hinges)
        self.field: Vector3 = ZERO
        self.wrenches: dict[
            int, tuple[Vector3, Vector3]
        ] = {}  # link → force, moment about its origin; carrier
        self.energies: dict[str, Scalar] = {}
        self.generalised: dict[
            int, Scalar
        ] = {}  # coordinate → force beyond the hinge torques, work per unit of it
        self.added: list[AddedInertia] = []
        self.reflected: dict[
            int, list[tuple[str, Scalar]]
        ] = {}  # joint → effects, and kg·m² that its rate feels
        self.guards: list[Guard] = []
        self.field_effects: list[tuple[str, Vector3]] = []
        self.accounts: dict[str, Account] = {}  # by effect: what it adds to all of the above
        self.claims: Mapping[
            str, str
        ] = {}  # what one effect of the scene has for itself → that effect's name
        self._q = list(q)
        self._parameters = parameters
        self._store = parameters.store
        self._index = {joint.name: i for i, joint in enumerate(tree.hinges)}
        self.bushings = {hinge.joint.name: hinge for hinge in bushings}
        self._effect = ""

    @property
    def joints(self) -> tuple[str, ...]:
        """Names of the joints: those of q in their order, then those that bushings hold."""
        return (*self._index, *self.bushings)

    def drawing(self) -> AbstractContextManager[None]:
        """Plain numbers that an effect works with inside are of the drawing: another drawing has others, and compiles
        nothing anew for them."""
        return self._store.drawing()

    @contextmanager
    def effect(self, name: str, title: str, source: str) -> Iterator[None]:
        """What is contributed inside belongs to this effect; the compiler opens one around each effect."""
        outer, self._effect = self._effect, name
        try:
            with self._store.section(title, effect=name, source=source), self._store.numbers_of(name):
                yield
        finally:
            self._effect = outer

    @property
    def effect_name(self) -> str:
        """Name of the effect whose turn it is."""
        return self._effect

    def parameter(
        self, name: str, default: float, unit: str, meaning: str, *, is_input: bool = False
    ) -> Scalar:
        """A number that can change without recompiling, e.g. parameter("h1.stiffness", 0.1, "N·m/rad", "…").

        is_input: it comes from outside while a model runs, as what a controller commands does.
        """
        return self._parameters.add(name, default, unit, meaning, self._effect, is_input=is_input)

    def switch(self, name: str, guard: "Scalar | sp.Expr") -> Scalar:
        """A number that is 1 while `guard`, a function of the angles, is positive, and 0 otherwise.

        Forces that begin and end are written with it. Integrators stop where the guard passes zero, and the number
        stands still in between, so that force times switch is smooth to them. `name` tells people which guard it is.
        """
        index = sum(1 for guard in self.guards if guard.mode is not None)
        slot = self._parameters.first_mode + index
        mode = self._store.symbol(f"mode_{index}", Space.CONSTANT, slot)
        self.guards.append(Guard(name, self._scalar(guard), mode=mode))
        return mode

    def clock(self, name: str, period: Scalar) -> Clock:
        """What samples at t = 0 and each multiple of the period, s, above 0: clock.hold(value) is `value` as it was at
        the last sample. Steps end at the samples. A state outside a run counts as sampled there."""
        number = sum(1 for guard in self.guards if guard.clock is not None)
        tick = self._store.symbol(f"tick_{number}", Space.CONSTANT, held_index(number, -1))
        clock = Clock(self._store, number, self._scalar(period), tick)
        self.guards.append(Guard(name, self.time - tick, clock=clock))
        return clock

    def impact(self, name: str, guard: "Scalar | sp.Expr", restitution: "Scalar | sp.Expr") -> None:
        """An impact where `guard`, a function of the angles, becomes positive: its rate is reversed and multiplied by
        the restitution, by an impulse along the guard; all loops hold (Newton's law of impact)."""
        self.guards.append(Guard(name, self._scalar(guard), restitution=self._scalar(restitution)))

    @property
    def parameter_names(self) -> tuple[str, ...]:
        """Names of the parameters that there are so far."""
        return tuple(record.name for record in self._parameters.records)

    def hinge(self, joint: str) -> Hinge:
        """The hinge of that name. Raises DesignError with the names there are."""
        if joint in self.bushings:
            seen = self.bushings[joint]
            return Hinge(seen.joint, seen.angle, seen.rate)
        index = self._index.get(joint)
        if index is None:
            raise DesignError(f"no joint is named {joint!r}; the joints are {', '.join(sorted(self.joints))}")
        return Hinge(self.tree.hinges[index], self._q[index], self._u[index])

    def coordinate(self, place: int) -> tuple[Scalar, Scalar]:
        """A coordinate with a rate of its own at the same place, by its place in q: its value and its rate."""
        return self._q[place], self._u[place]

    def hinges(self) -> Iterator[Hinge]:
        """All hinges in order. Use this to do the same for each: what repeats is then emitted once."""
        for name in self.joints:
            index = self._index.get(name, NO_LINK)
            self._store.link = index
            yield self.hinge(name)

    def each(self, items: Iterable[Item]) -> Iterator[Item]:
        """The items in order. Use this to do the same for each: what repeats is then emitted once."""
        for place, item in enumerate(items):
            self._store.link = place
            yield item

    def hinge_torque(self, joint: str, torque: "Scalar | sp.Expr") -> None:
        """Adds a torque about the joint's axis, N·m, on the child, and its opposite on the parent (eq. 15-17)."""
        name, value = self.hinge(joint).joint.name, self._scalar(torque)
        if name in self._index:
            index = self._index[name]
            self.hinge_torques[index] = self.hinge_torques[index] + value
            self._account.add_torque(index, value)
            return
        for k, partial in enumerate(self.bushings[name].gradient):
            self.generalised_force(k, value * partial)

    def generalised_force(self, coordinate: int, force: Scalar) -> None:
        """Adds a force that does work on a coordinate, by its place in q: N·m per rad, N per m."""
        if isinstance(force, Value) or force != 0:
            self.generalised[coordinate] = self.generalised.get(coordinate, 0) + force
            self._account.add_generalised(coordinate, force)

    def uniform_field(self, acceleration: Sequence["Scalar | sp.Expr"]) -> None:
        """Adds an acceleration, m/s², that acts on all mass alike; its potential energy is booked too."""
        vector = self._vector(acceleration)
        self.field = add(self.field, vector)
        self.field_effects.append((self._effect, vector))

    def stored_energy(self, energy: "Scalar | sp.Expr") -> None:
        """Adds potential energy, J, to the effect's account."""
        self.energies[self._effect] = self.energies.get(self._effect, 0) + self._scalar(energy)

    def force(self, body: str, point: Sequence[float], force: Sequence["Scalar | sp.Expr"]) -> None:
        """Adds a force, N, world axes, at a point of the body given in the drawn configuration, m, world.

        A force on a fixed body does nothing, unless that moves.
        """
        index, drawn = self.link_of(body), drawn_point(point)
        if index != WORLD or self.placement.base is not None:
            self._add_wrench(index, self._vector(force), ZERO, drawn)

    def moment(self, body: str, moment: Sequence["Scalar | sp.Expr"], *, on_frame: bool = False) -> None:
        """Adds a moment, N·m, world axes, on the body (eq. 17); on a flexible body at its centre of mass as drawn.

        on_frame: of a flexible body on its frame at the inboard hinge, of which `rotation` tells.
        """
        index = self.link_of(body)
        if index != WORLD or self.placement.base is not None:
            bent = index in self.kinematics.flexible and not on_frame
            drawn = self.tree.links[index].body.com if bent else None
            self._add_wrench(index, ZERO, self._vector(moment), drawn)

    def added_inertia(
        self, body: str, point: Sequence[float], matrix: "Sequence[Sequence[Scalar | sp.Expr]]"
    ) -> None:
        """Adds a fluid's mass: kinetic energy ½ wᵀ matrix w, w = (velocity of the point, angular velocity), m/s and
        rad/s, drawn axes of the body; matrix (6, 6), symmetric: kg, kg·m, kg·m² (Lamb 1932, ch. VI).

        The effect's `arrange` has to ask for `inverse_dynamics`. The energy is booked under the effect; its forces are
        Kirchhoff's. A fixed body that does not move has none.
        """
        index, drawn = self.link_of(body), drawn_point(point)
        if self.kinematics.arrangement is None:
            raise DesignError(
                f"effect {self._effect!r} adds inertia to body {body!r}, but its arrange(arranging) does not call "
                "arranging.inverse_dynamics(); let it do so"
            )
        if index in self.kinematics.flexible:
            raise DesignError(
                f"effect {self._effect!r} adds inertia to body {body!r}, which is flexible; added inertia acts on "
                "rigid bodies only: leave one of the two effects out"
            )
        rows = tuple(tuple(self._scalar(v) for v in row) for row in matrix)
        if len(rows) != 6 or any(len(row) != 6 for row in rows):
            raise DesignError(f"effect {self._effect!r} adds an inertia to body {body!r} that is not 6 by 6")
        base = self.placement.base
        if index != WORLD:
            x, y, z = keyed(self._store, (), local_point(self.tree.links[index], drawn))
            self.added.append(AddedInertia(self._effect, index, (x, y, z), rows))
        elif base is not None:
            self.added.append(AddedInertia(self._effect, index, base.arm(drawn), rows))

    def _scalar(self, value: "Scalar | sp.Expr") -> Scalar:
        """Sympy expressions are staged; their symbols are t, inputs, and q_<joint> and u_<joint> by joint name."""
        if isinstance(value, Value):
            return value
        if isinstance(value, numbers.Real):
            return checked_number(value, f"a number that effect {self._effect!r} gives")
        from lamc.mechanics.sympy_view import from_sympy

        inputs: dict[str, Scalar] = {"t": self.time, **self.inputs}
        for joint in self.joints:
            hinge = self.hinge(joint)
            inputs |= {f"q_{joint}": hinge.angle, f"u_{joint}": hinge.rate}
        return from_sympy(value, inputs, self._store)

    def _vector(self, values: Sequence["Scalar | sp.Expr"]) -> Vector3:
        if len(values) != 3:
            raise DesignError(
                f"effect {self._effect!r} gives a vector of {len(values)} components; it needs 3"
            )
        x, y, z = (self._scalar(v) for v in values)
        return (x, y, z)

    def _add_wrench(self, index: int, force: Vector3, moment: Vector3, drawn: Array | None) -> None:
        """World axes, at a drawn point; None: a moment alone, about any."""
        base = self.placement.base
        if index == WORLD:
            if base is not None:
                force, moment = rotate_back(base.rotation, force), rotate_back(base.rotation, moment)
                if drawn is not None:
                    moment = add(moment, cross(base.arm(drawn), force))
                self._add_at_origin(WORLD, force, moment)
            return
        carrier = self.placement.carrier(index)
        force, moment = rotate_back(carrier, force), rotate_back(carrier, moment)
        if drawn is not None:
            local = local_point(self.tree.links[index], drawn)
            bending: dict[int, Scalar] = {}
            with self._store.drawing():
                force, moment = self.kinematics.wrench_at_origin(index, force, moment, local, bending)
            for coordinate, value in bending.items():
                self.generalised_force(coordinate, value)
        self._add_at_origin(index, force, moment)

    def _add_at_origin(self, index: int, force: Vector3, moment: Vector3) -> None:
        """A wrench about the link's origin, carrier components."""
        before = self.wrenches.get(index, (ZERO, ZERO))
        self.wrenches[index] = (add(before[0], force), add(before[1], moment))
        self._account.add_wrench(index, force, moment)

    @property
    def _account(self) -> Account:
        return self.accounts.setdefault(self._effect, Account())
