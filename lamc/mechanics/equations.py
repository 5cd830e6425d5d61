"""The `Equations` record: what `derive` gives. Every part of it is, on request, a sympy object.

Nothing is written out until it is asked for: `assignments` shows the staged equations, one named quantity each;
`mass_matrix` and `generalised_forces` give M and f of M u̇ = f.
"""

from collections.abc import Callable, Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass, field, fields, replace
from types import MappingProxyType
from typing import TYPE_CHECKING, Protocol, cast

from lamc.basics.once import lazy
from lamc.loops.rank import NO_LOOPS, LoopCount
from lamc.mechanics.operation_account import operations_by_effect
from lamc.mechanism.tree import Tree
from lamc.records.inputs import Input
from lamc.symbolic.pattern import Pattern
from lamc.symbolic.program import Coordinate, Operations, Parameter, Space
from lamc.symbolic.scalars import Scalar, Value
from lamc.symbolic.staging import Level, Store
from lamc.symbolic.statements import count_operations, group

if TYPE_CHECKING:
    import sympy as sp

    from lamc.mechanics.arrangement import Arrangement
    from lamc.mechanics.closure import Closure
    from lamc.mechanics.derive import Problem
    from lamc.mechanics.guards import GuardTerms
    from lamc.mechanics.inverse_dynamics import InverseDynamics
    from lamc.records.effect import Effect


@dataclass(frozen=True)
class Assignment:
    """symbol = expression, with where it comes from."""

    symbol: "sp.Symbol"
    expression: "sp.Expr"
    section: str
    effect: str
    source: str

    def __str__(self) -> str:
        return f"{self.symbol} = {self.expression}"


class Derivation(Protocol):
    """Equations of a tree under effects: what `derive` is."""

    def __call__(
        self, tree: Tree, effects: "Sequence[Effect]", loops: LoopCount | None, inputs: Mapping[str, Input]
    ) -> "Equations": ...


def _by_hand(
    tree: Tree, effects: "Sequence[Effect]", loops: LoopCount | None, inputs: Mapping[str, Input]
) -> "Equations":
    """Of a record that `derive` has not made."""
    raise TypeError("these equations were put together by hand: none can be derived for other effects")


def _no_pattern(loops: LoopCount) -> None:
    """Of a tree."""


@dataclass(frozen=True, eq=False, repr=False)
class Equations:
    """Equations of motion of one scene.

    acceleration  u̇, rad/s², in the order of `joints`
    energies      stored and kinetic energy by effect, J; "kinetic" first
    poses         per link: centre of mass (3) and rotation (9, by rows), world
    problem       M u̇ = f before it was solved
    closure       residuals, Jacobian and bias of the loops; None for a tree. `acceleration` is then empty: the
                  runtime solves M u̇ = f together with the closure
    loops         how many of the closure's equations are independent
    pattern       which entries the closure's Jacobian has, and how it is eliminated; None for a tree
    find_pattern  the pattern with another count of loops
    guards        conditions whose passing of zero is an event
    solver        how u̇ was solved for; `solver_flops` what each way costs
    arrangement   coordinates beyond the hinges; with any, M u̇ = f comes from inverse dynamics, `acceleration` is
                  empty, and the runtime solves
    coordinate_rates  q̇ (nq,) by q and u; None where q̇ = u
    inputs        numbers from outside that the scene declares, by name
    derive        makes those of other effects
    account_for_powers  makes `powers`, which take time and memory that few ask for

    The store is frozen once `derive` is done. What is worked out later (`inertia`, `forces`, `powers`, the program)
    is written into a fork of it, so that nothing depends on what was read before.
    """

    tree: Tree
    effects: "tuple[Effect, ...]"
    store: Store
    parameters: tuple[Parameter, ...]
    acceleration: tuple[Scalar, ...]
    problem: "Problem | InverseDynamics"
    energies: Mapping[str, Scalar]
    poses: tuple[Scalar, ...]
    solver: str
    solver_flops: Mapping[str, int]
    closure: "Closure | None" = None
    pattern: Pattern | None = None
    guards: "tuple[GuardTerms, ...]" = ()
    loops: LoopCount = NO_LOOPS
    arrangement: "Arrangement | None" = None
    coordinate_rates: tuple[Scalar, ...] | None = None
    inputs: Mapping[str, Input] = field(default_factory=dict)
    account_for_powers: "Callable[[], Mapping[str, Scalar]]" = dict
    find_pattern: "Callable[[LoopCount], Pattern | None]" = _no_pattern
    derive: Derivation = _by_hand

    def __repr__(self) -> str:
        return (
            f"<Equations of {self.tree.mechanism.name!r}: {len(self.joints)} joints, solved by {self.solver}>"
        )

    def forked(self) -> "Equations":
        """The same equations over a copy of the store, in which one may go on writing."""
        mechanism = self.tree.mechanism
        kept = (self.tree, *self.tree.links, mechanism, *mechanism.bodies, *mechanism.joints)
        kept += (self.effects, *self.effects, self.parameters, self.arrangement, self.inputs)
        memo: dict[int, object] = {id(record): record for record in kept}
        return replace(self, **{each.name: deepcopy(getattr(self, each.name), memo) for each in fields(self)})

    def on_branch(self, loops: LoopCount) -> "Equations":
        """The same equations where loops have the rank of a branch; they are counted at one position."""
        return replace(self, loops=loops, pattern=self.find_pattern(loops))

    @lazy
    def powers(self) -> Mapping[str, Scalar]:
        """Power of all loads of an effect, W, by its name, in terms of t, q, u and u̇; of what moves a base as
        prescribed too. Their sum is the rate of the kinetic energy. Scalars of a fork, unless these equations are
        one."""
        return self.forked().powers if self.store.is_frozen else self.account_for_powers()

    @property
    def inertia(self) -> Mapping[tuple[int, int], Scalar]:
        """M by rates, kg·m² between joints: entries (i, j), i >= j; a plain tree's have j on the way from i to the
        world. Scalars of the same fork as `forces`, unless these equations are one."""
        return MappingProxyType(self._system[0])

    @property
    def forces(self) -> tuple[Scalar, ...]:
        """f of M u̇ = f, N·m of joints, by rates."""
        return self._system[1]

    @lazy
    def _system(self) -> tuple[Mapping[tuple[int, int], Scalar], tuple[Scalar, ...]]:
        if self.store.is_frozen:
            return self.forked()._system
        return self.problem.mass_matrix(), tuple(self.problem.forces())

    @property
    def joints(self) -> tuple[str, ...]:
        """Names in the order of q and u: the tree's, then those that close loops."""
        return tuple(joint.name for joint in self.tree.hinges)

    @property
    def coordinates(self) -> tuple[Coordinate, ...]:
        """Names and units of q, (nq,): the joints first."""
        if self.arrangement is not None:
            return self.arrangement.coordinates
        return tuple(Coordinate(name, "rad") for name in self.joints)

    @property
    def rates(self) -> tuple[Coordinate, ...]:
        """Names and units of u, (nu,)."""
        if self.arrangement is not None:
            return self.arrangement.rates
        return tuple(Coordinate(name, "rad/s") for name in self.joints)

    @property
    def is_plain(self) -> bool:
        """Hinges on a fixed world and nothing else."""
        return self.arrangement is None or self.arrangement.is_plain

    @property
    def bodies(self) -> tuple[str, ...]:
        """Names in the order of `poses`: moving bodies, then fixed ones where the base moves."""
        if self.arrangement is not None:
            return self.arrangement.moving_bodies
        return tuple(link.body.name for link in self.tree.links)

    @property
    def cut_joints(self) -> tuple[str, ...]:
        """Names of the joints that close loops."""
        return tuple(cut.joint.name for cut in self.tree.cuts)

    @lazy
    def operations(self) -> Operations:
        """Of one evaluation of u̇ (where the runtime solves: of M, f, J and γ), and of q̇ where that is not u;
        parameter-only work excluded."""
        if self.is_recursive:
            return self._operations_of_passes
        values = [value for name, value in self._results.items() if not name.startswith("phi_")]
        values += self.coordinate_rates or ()
        return count_operations(_store_of(values, self.store), values, Level.PARAMETER)

    @property
    def is_recursive(self) -> bool:
        """Whether M is not written down: in large loops passes over the bodies apply it to what moves freely."""
        return self.is_plain and self.pattern is not None and bool(self.pattern.plan)

    @property
    def passes(self) -> tuple[list[Scalar], list[Scalar]]:
        """M u̇ - f (nu,), and M u̇ (nu,), at the symbols of u̇; of plain equations alone. Scalars of a fork, unless these
        equations are one."""
        if self.store.is_frozen:
            return self.forked().passes
        udot = [self.store.symbol(f"udot_{c.name}", Space.ACCELERATION, i) for i, c in enumerate(self.rates)]
        problem = cast("Problem", self.problem)
        return problem.residual(udot), problem.momenta(udot)

    @lazy
    def _operations_of_passes(self) -> Operations:
        if self.store.is_frozen:
            return self.forked()._operations_of_passes
        assert self.closure is not None
        residual, momenta = self.passes
        rows = [value for row in self.closure.jacobian for _, value in row]
        once, solved, again = (
            count_operations(self.store, values, Level.PARAMETER)
            for values in ([*rows, *self.closure.bias], residual, momenta)
        )
        return once + solved + again.times(self.loops.freedoms)

    @lazy
    def operations_by_effect(self) -> Mapping[str, Operations]:
        """`operations` by what they are for: "" is the mechanism alone, then what each effect adds to those before
        it; effects that bring coordinates come first. Takes a derivation for each effect."""
        return operations_by_effect(self)

    @lazy
    def assignments(self) -> "tuple[Assignment, ...]":
        """The equations, staged: every right-hand side holds symbols defined before it.

        Ends with udot_<joint>; with loops, with the entries of M, f, and of φ, J and γ of the closure.
        """
        return self.staged(self._results)

    @lazy
    def _results(self) -> Mapping[str, Scalar]:
        if self.closure is None and self.is_plain:
            return {f"udot_{name}": value for name, value in zip(self.joints, self.acceleration, strict=True)}
        results = {f"M_{i}_{j}": value for (i, j), value in sorted(self.inertia.items())}
        results |= {f"f_{i}": value for i, value in enumerate(self.forces)}
        closure = self.closure
        for row in range(len(closure.residual) if closure is not None else 0):
            assert closure is not None
            results |= {f"phi_{row}": closure.residual[row], f"gamma_{row}": closure.bias[row]}
            results |= {f"J_{row}_{j}": value for j, value in closure.jacobian[row]}
        return results

    @lazy
    def mass_matrix(self) -> "sp.Matrix":
        """M, shape (nu, nu), entries in terms of the symbols of `mass_assignments`."""
        return self._mass[0]

    @lazy
    def generalised_forces(self) -> "sp.Matrix":
        """f of M u̇ = f, shape (nu, 1), entries in terms of the symbols of `mass_assignments`."""
        return self._mass[1]

    @lazy
    def mass_assignments(self) -> "tuple[Assignment, ...]":
        """The staged quantities that `mass_matrix` and `generalised_forces` are written in."""
        return self._mass[2]

    @lazy
    def _mass(self) -> "tuple[sp.Matrix, sp.Matrix, tuple[Assignment, ...]]":
        import sympy as sp

        count = len(self.rates)
        entries = {f"M_{i}_{j}": v for (i, j), v in sorted(self.inertia.items())}
        forces = {f"f_{i}": v for i, v in enumerate(self.forces)}
        assignments = self.staged(entries | forces)

        def entry(i: int, j: int) -> sp.Expr:
            key = (max(i, j), min(i, j))
            return sp.Symbol(f"M_{key[0]}_{key[1]}") if key in self.inertia else sp.Integer(0)

        matrix = sp.Matrix(count, count, entry)
        return matrix, sp.Matrix(count, 1, lambda i, _: sp.Symbol(f"f_{i}")), assignments

    def staged(self, outputs: Mapping[str, Scalar]) -> "tuple[Assignment, ...]":
        """`outputs` by name as staged assignments in sympy; intermediate quantities are z0, z1, …"""
        import sympy as sp

        from lamc.mechanics.sympy_view import expression, node_expression

        values = list(outputs.values())
        store = _store_of(values, self.store)
        grouping = group(store, values, Level.NUMBER)
        named: dict[int, sp.Symbol] = {}
        result: list[Assignment] = []
        for index in grouping.named:
            arguments = [expression(Value(store, i, 1), named) for i in store.arguments[index]]
            named[index] = sp.Symbol(f"z{len(named)}")
            section = store.sections[store.section_of[index]]
            result.append(
                Assignment(
                    named[index],
                    node_expression(store, index, arguments),
                    section.title,
                    section.effect,
                    section.source,
                )
            )
        for name, value in outputs.items():
            result.append(Assignment(sp.Symbol(name), expression(value, named), "Results", "", ""))
        return tuple(result)

    def written_out(self, value: Scalar) -> "sp.Expr":
        """One value as a single sympy expression in q, u, t and the parameters. Large for long chains."""
        from lamc.mechanics.sympy_view import expression

        return expression(value, {})


def _store_of(values: Sequence[Scalar], own: Store) -> Store:
    """The store of all values: forks know the nodes of what they were forked from, by the same numbers."""
    return max((value.store for value in values if isinstance(value, Value)), key=len, default=own)
