"""`derive_general`: equations of what moves by more than hinges on a fixed world.

Goes in: an `Arrangement` and effects. Comes out: Equations whose M and f come from inverse dynamics, with closure,
energies, poses and guards by all coordinates. It knows no effect by name, and nothing of it runs for plain mechanisms.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from lamc.loops.rank import LoopCount, count_loops
from lamc.mechanics import compliance
from lamc.mechanics.arrangement import Arrangement, FloatingBase, PrescribedBase
from lamc.mechanics.assembly import Solved, Symbols, assemble, collect
from lamc.mechanics.chain_kinematics import ChainKinematics
from lamc.mechanics.closure import Closure, close_cuts, close_cycles
from lamc.mechanics.equations import Equations
from lamc.mechanics.inertia import link_inertia, regrouped
from lamc.mechanics.inverse_dynamics import InverseDynamics, Masses
from lamc.mechanics.loads import Loads
from lamc.mechanics.modal import modal_inertia
from lamc.mechanics.moving_base import MovingBase, float_base, prescribe_base
from lamc.mechanics.parameters import Parameters
from lamc.mechanics.placement import Placement
from lamc.mechanism.tree import WORLD
from lamc.records.inputs import Input
from lamc.records.mechanism import Array
from lamc.symbolic.evaluate import evaluate
from lamc.symbolic.scalars import Scalar, Value
from lamc.symbolic.staging import Store

if TYPE_CHECKING:
    from lamc.records.effect import Effect

INVERSE_DYNAMICS = "inverse dynamics"
# The rank of loops in which something yields: looked at that far from the drawn position, rad or parts of the size by
# which a coordinate opens a loop, at so many places, each closed by so many steps of Gauss and Newton.
SPREAD, PLACES, ROUNDS = 0.3, 4, 30
CLOSED = 1e-9  # rad, or of the size
DEPENDENT = (
    1e-7  # of what a coordinate does to the closure: below it an equation is told from others by round-off
)


def derive_general(
    symbols: Symbols,
    arrangement: Arrangement,
    effects: "Sequence[Effect]",
    loops: LoopCount | None,
    inputs: Mapping[str, Input],
) -> Equations:
    """Equations of motion of `arrangement` under `effects`; see `derive`."""
    store, q, u = symbols.store, symbols.q, symbols.u
    masses, seen, loads = begin_general(symbols, arrangement, effects)
    kinematics, plain = loads.kinematics, len(arrangement.plain_coordinates)
    assert isinstance(kinematics, ChainKinematics)
    problem = InverseDynamics(kinematics, _regrouped(kinematics, masses), u, loads)
    tree, closure = arrangement.tree, None
    yields = arrangement.yields
    if tree.cuts:
        close = partial(close_cuts, seen) if yields else partial(close_cycles, tree)
        closure = close(q[:plain], u[:plain])
    count = loops or count_loops(tree)
    if closure is not None and yields:
        count = _yielding(count, closure, store, q[:plain], arrangement)
    solved = Solved(problem, closure, INVERSE_DYNAMICS)
    return assemble(symbols, arrangement, loads, masses, solved, count, effects, inputs)


def begin_general(
    symbols: Symbols, arrangement: Arrangement, effects: "Sequence[Effect]"
) -> tuple[Masses, Placement, Loads]:
    """As `begin_plain`: masses, where links are as seen from the base, and loads."""
    store, q, u = symbols.store, symbols.q, symbols.u
    base = _staged_base(symbols, arrangement)
    kinematics = ChainKinematics(store, arrangement, q, base)
    masses = _masses(kinematics, symbols.parameters)
    plain = len(arrangement.plain_coordinates)
    seen = Placement(kinematics.on_still_base())
    held = [
        compliance.bushing_amounts(seen, b, q[:plain], u[:plain], q[plain + k])
        for k, b in enumerate(arrangement.bushings)
    ]
    hold = partial(_hold, arrangement=arrangement, bushings=[amounts for amounts, _ in held], q=q, u=u)
    bushings = [hinge for _, hinge in held]
    loads = collect(symbols, Placement(kinematics, base), bushings, effects, hold)
    return masses, seen, loads


def _staged_base(symbols: Symbols, arrangement: Arrangement) -> MovingBase | None:
    match arrangement.base:
        case FloatingBase() as base:
            return float_base(symbols.store, base, symbols.parameters.add, symbols.q, symbols.u)
        case PrescribedBase() as base:
            return prescribe_base(symbols.store, base, symbols.time, symbols.inputs)
        case _:
            return None


def _masses(kinematics: ChainKinematics, parameters: Parameters) -> Masses:
    store, links = kinematics.store, kinematics.tree.links
    with store.section("Inertia about the hinges", source="parallel axes"):
        pairs = []
        for i, link in enumerate(links):
            store.link = i
            pairs.append(link_inertia(link, parameters.add))
        modal = {
            i: modal_inertia(store, modes, links[i], pairs[i][1]) for i, modes in kinematics.modes.items()
        }
    return Masses(tuple(inertia for inertia, _ in pairs), tuple(com for _, com in pairs), modal)


def _regrouped(kinematics: ChainKinematics, masses: Masses) -> Masses:
    """The same with base parameters, where a link turns about a line of a rigid parent and nothing else."""
    yielding = {hinge.joint for hinge in kinematics.arrangement.compliant}
    kept = {
        i
        for i, link in enumerate(kinematics.tree.links)
        if link.joint.name in yielding
        or i in masses.modal
        or link.parent in masses.modal
        or (link.parent == WORLD and kinematics.base is not None)
    }
    with kinematics.store.section("Base parameters", source="Gautier & Khalil 1990"):
        inertias = regrouped(kinematics.store, kinematics.tree, masses.inertias, kept)
    return replace(masses, inertias=tuple(inertias))


def _hold(
    loads: Loads,
    arrangement: Arrangement,
    bushings: Sequence[compliance.Held],
    q: Sequence[Scalar],
    u: Sequence[Scalar],
) -> None:
    """Stiffness and damping that the effect whose turn it is asked for."""
    kinematics = loads.kinematics
    assert isinstance(kinematics, ChainKinematics)
    joints = {link.joint.name: i for i, link in enumerate(kinematics.tree.links)}
    for hinge in arrangement.compliant:
        if hinge.effect == loads.effect_name:
            held = compliance.hinge_amounts(hinge, kinematics.index, joints[hinge.joint], q, u)
            compliance.hold_hinge(loads, hinge, held)
    for bushing, held in zip(arrangement.bushings, bushings, strict=True):
        if bushing.hinge.effect == loads.effect_name:
            compliance.hold_hinge(loads, bushing.hinge, held)
    for modes in kinematics.modes.values():
        if modes.body.effect == loads.effect_name:
            compliance.hold_modes(loads, modes.body, modes.first, q, u)


def _yielding(
    count: LoopCount, closure: Closure, store: Store, q: Sequence[Value], arrangement: Arrangement
) -> LoopCount:
    """The count of loops some bodies or hinges of which yield: the rank by `q`, the coordinates without a base's, at
    closed positions near the drawn one. Deterministic.

    Coordinates are measured by what they do to the closure as drawn. Deflections as large as angles, or as the
    mechanism, turn hinges by many rad; where that closes, far from any motion, the rank may be a larger one.
    """
    size = arrangement.tree.mechanism.size
    least = np.array([1.0 if c.unit == "rad" else 1.0 / size for c in arrangement.coordinates[: len(q)]])
    rng = np.random.default_rng(0)
    flat = [*closure.residual, *(value for row in closure.jacobian for _, value in row)]
    places = [(i, j) for i, row in enumerate(closure.jacobian) for j, _ in row]
    m, rank = len(closure.residual), 0

    def at(x: Array) -> tuple[Array, Array]:
        values = np.array(evaluate(store, flat, dict(zip(q, x.tolist(), strict=True))))
        jacobian = np.zeros((m, len(q)))
        jacobian[tuple(np.array(places).T)] = values[m:]
        return values[:m], jacobian

    units = 1.0 / np.maximum(np.abs(at(np.zeros(len(q)))[1]).max(axis=0, initial=0.0), least)
    for _ in range(PLACES):
        x = rng.uniform(-SPREAD, SPREAD, len(q)) * units
        for _ in range(ROUNDS):
            residual, jacobian = at(x)
            x = x - units * (np.linalg.pinv(jacobian * units, rcond=1e-9) @ residual)
        if np.abs(residual).max() < CLOSED:
            rank = max(rank, int((np.linalg.svd(jacobian * units)[1] > DEPENDENT).sum()))
    rank = rank or min(m, len(q))
    return replace(count, rank=rank, freedoms=len(q) - rank, misfit=None)
