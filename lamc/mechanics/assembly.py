"""What both forms of the equations share: the symbols, the loads of the effects, and the finished record.

Goes in: an `Arrangement`, effects, and what a form makes of them (`derive`, `general`). Comes out: `Loads`, in which
every effect has had its turn, and `Equations`. It knows no effect by name, and solves nothing.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING

from lamc.loops.rank import LoopCount
from lamc.mechanics.arrangement import Arrangement, PrescribedBase
from lamc.mechanics.closure import Closure
from lamc.mechanics.closure_plan import pattern_of
from lamc.mechanics.equations import Equations
from lamc.mechanics.guards import check_guards, guard_terms
from lamc.mechanics.inverse_dynamics import InverseDynamics, Masses
from lamc.mechanics.loads import Loads, SeenHinge
from lamc.mechanics.moving_base import StagedFloat
from lamc.mechanics.outputs import energies_of, poses_of
from lamc.mechanics.parameters import Parameters
from lamc.mechanics.placement import Placement
from lamc.mechanics.powers import Mass, Moving, powers_of
from lamc.records.effect import asked, claims_of, hooked
from lamc.records.inputs import Input
from lamc.symbolic.algebra import ZERO, add, dot, scale
from lamc.symbolic.pattern import Pattern
from lamc.symbolic.program import Space
from lamc.symbolic.scalars import Scalar, Value
from lamc.symbolic.staging import LATER, Store

if TYPE_CHECKING:
    from lamc.mechanics.derive import Problem
    from lamc.records.effect import Effect


@dataclass(frozen=True)
class Symbols:
    """What all is written in: t, q (nq,), u (nu,), inputs of the scene by name, and parameters as they come."""

    parameters: Parameters
    time: Value
    q: tuple[Value, ...]
    u: tuple[Value, ...]
    inputs: Mapping[str, Scalar]

    @property
    def store(self) -> Store:
        return self.parameters.store


@dataclass(frozen=True)
class Solved:
    """M u̇ = f of one form, and how u̇ comes of it: by `acceleration` (nu,), or, where that is empty, at run time."""

    problem: "Problem | InverseDynamics"
    closure: Closure | None
    solver: str
    acceleration: tuple[Scalar, ...] = ()
    flops: Mapping[str, int] | None = None


def symbols_of(arrangement: Arrangement, inputs: Mapping[str, Input]) -> Symbols:
    """The symbols of a new store. Raises DesignError for an input named as the equations name something else."""
    store = Store()
    time = store.symbol("t", Space.TIME, 0)
    coordinates, rates = arrangement.coordinates, arrangement.rates
    q = tuple(store.symbol(f"q_{c.name}", Space.ANGLE, i) for i, c in enumerate(coordinates))
    u = tuple(store.symbol(f"u_{c.name}", Space.RATE, i) for i, c in enumerate(rates))
    parameters = Parameters(store)
    given = parameters.declare(inputs, [c.name for c in (*coordinates, *rates)])
    return Symbols(parameters, time, q, u, given)


def collect(
    symbols: Symbols,
    placement: Placement,
    bushings: Sequence[SeenHinge],
    effects: "Sequence[Effect]",
    hold: Callable[[Loads], None] = lambda loads: None,
) -> Loads:
    """The loads of all effects, in their order.

    hold: adds what belongs to the effect whose turn it is beside its own loads, before them. What an effect raises is
    about that effect, so that whoever read it from a file can tell its place.
    """
    loads = Loads(placement, symbols.parameters, symbols.time, symbols.q, symbols.u, bushings, symbols.inputs)
    loads.claims = {claim: effect.name for effect in effects for claim in claims_of(effect)}
    for effect in effects:
        with asked(effect), loads.effect(effect.name, effect.summary, hooked(effect).source):
            hold(loads)
            effect.contribute(loads)
    symbols.parameters.check_asked()
    check_guards(loads.guards)
    symbols.store.scope = LATER
    return loads


def assemble(
    symbols: Symbols,
    arrangement: Arrangement,
    loads: Loads,
    masses: Masses,
    solved: Solved,
    loops: LoopCount,
    effects: "Sequence[Effect]",
    inputs: Mapping[str, Input],
) -> Equations:
    """The record: what was solved, with energies, poses and guards."""
    placement, base = loads.placement, loads.placement.base
    rates = (
        *symbols.u[: len(arrangement.plain_coordinates)],
        *(each.rate for each in loads.bushings.values()),
    )
    rates = (*rates, *base.coordinate_rates) if isinstance(base, StagedFloat) else rates
    speeds: dict[Value, Scalar] = dict(zip(symbols.q, rates, strict=True)) | {symbols.time: 1}
    udot = partial(_accelerations, symbols.store, arrangement)
    find_pattern = partial(_pattern, symbols, solved.closure)
    return Equations(
        tree=arrangement.tree,
        effects=tuple(effects),
        store=symbols.store,
        parameters=tuple(symbols.parameters.records),
        acceleration=solved.acceleration,
        problem=solved.problem,
        closure=solved.closure,
        pattern=find_pattern(loops),
        find_pattern=find_pattern,
        energies=energies_of(placement, masses, symbols.u, loads),
        poses=tuple(poses_of(placement, masses.coms, arrangement)),
        loops=loops,
        guards=tuple(guard_terms(guard, speeds, symbols.u, udot) for guard in loads.guards),
        solver=solved.solver,
        solver_flops=solved.flops or {},
        arrangement=arrangement,
        inputs=inputs,
        coordinate_rates=rates if loads.bushings or isinstance(base, StagedFloat) else None,
        account_for_powers=partial(_powers, solved.problem, arrangement, masses, loads, speeds),
    )


def _accelerations(store: Store, arrangement: Arrangement) -> list[Value]:
    """The symbols of u̇, (nu,)."""
    return [store.symbol(f"udot_{c.name}", Space.ACCELERATION, i) for i, c in enumerate(arrangement.rates)]


def _pattern(symbols: Symbols, closure: Closure | None, loops: LoopCount) -> Pattern | None:
    return None if closure is None else pattern_of(closure, symbols.q, loops)


def _powers(
    problem: "Problem | InverseDynamics",
    arrangement: Arrangement,
    masses: Masses,
    loads: Loads,
    speeds: Mapping[Value, Scalar],
) -> dict[str, Scalar]:
    """Of the effects' loads, and of what moves a base as prescribed."""
    placement, rates = loads.placement, arrangement.rates
    kinematics, base = placement.kinematics, placement.base
    store = kinematics.store
    u = [store.symbol(f"u_{c.name}", Space.RATE, i) for i, c in enumerate(rates)]
    pulled = []
    for i, (inertia, com) in enumerate(zip(masses.inertias, masses.coms, strict=True)):
        store.link, modal = i, masses.modal.get(i)
        first, change = scale(inertia.mass, kinematics.in_carrier(i, com)), ZERO
        if modal is not None:
            first = add(first, modal.rise())
            change = scale(dot(modal.moment, modal.modes.rates(u)), modal.normal)
        pulled.append(Mass(inertia.mass, first, change))
    udot = _accelerations(store, arrangement)
    weight = base.mass if isinstance(base, StagedFloat) else 0
    moving = Moving(placement, pulled, weight, u, {**speeds, **dict(zip(u, udot, strict=True))})
    powers = powers_of(loads, moving)
    if isinstance(arrangement.base, PrescribedBase):
        assert isinstance(problem, InverseDynamics)
        effect = arrangement.base.effect
        with store.section("Power of the base", effect=effect, source="its wrench on the links · its twist"):
            powers[effect] = powers.get(effect, 0) + problem.base_power(udot)
    return powers
