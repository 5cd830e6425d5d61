"""`derive`: from a Tree and effects to Equations. The only place where mechanism, loads and solution meet.

Goes in: the tree, the effects of the scene. Comes out: staged accelerations, M and f, energies and poses in one
store. It knows no effect by name, and makes no text.
"""

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from typing import TYPE_CHECKING

from lamc.loops.rank import LoopCount, count_loops
from lamc.mechanics.arrangement import Arrangement
from lamc.mechanics.arranging import arrange
from lamc.mechanics.assembly import Solved, Symbols, assemble, collect, symbols_of
from lamc.mechanics.closure import Closure, close_cycles
from lamc.mechanics.elimination import Wrench, inertia_wrench, solve_by_elimination
from lamc.mechanics.equations import Equations
from lamc.mechanics.general import derive_general
from lamc.mechanics.inertia import Inertia, link_inertia, regrouped
from lamc.mechanics.inverse_dynamics import Masses
from lamc.mechanics.kinematics import Kinematics
from lamc.mechanics.loads import Loads
from lamc.mechanics.mass_matrix import generalised_forces, mass_matrix, solve_by_mass_matrix, way_to_world
from lamc.mechanics.parameters import Parameters
from lamc.mechanics.placement import Placement, rotate_back
from lamc.mechanism.tree import WORLD, Link, Tree
from lamc.records.inputs import NO_INPUTS, Input
from lamc.symbolic.algebra import ZERO, Vector3, add
from lamc.symbolic.allocation import collector_paused
from lamc.symbolic.scalars import Scalar, Value
from lamc.symbolic.staging import Level, Store
from lamc.symbolic.statements import count_operations
from lamc.symbolic.substitution import substitute

if TYPE_CHECKING:
    from lamc.records.effect import Effect

# The mass-matrix form grows with the square of the depth; with more pairs of hinges on common ways to the world
# than this it has lost in every mechanism measured (`python -m benchmarks.solver_crossover`), and is not tried.
MAX_PAIRS_FOR_MASS_MATRIX = 60

_INERTIA, _PARALLEL = "Inertia about the hinges, base parameters", "parallel axes; Gautier & Khalil 1990"
# With loops the runtime solves M u̇ = f together with the closure; the equations hold M, f and the closure.
CONSTRAINED = "constraints"


@collector_paused
def derive(
    tree: Tree,
    effects: "Sequence[Effect]",
    loops: LoopCount | None = None,
    inputs: Mapping[str, Input] = NO_INPUTS,
) -> Equations:
    """Equations of motion of `tree` under `effects`. `loops` is what `count_loops` gives; None: counted here.

    inputs: of the scene, by name; the effects' expressions may hold them.

    Raises DesignError where an effect does not fit.
    """
    arrangement = arrange(tree, effects)
    road = _derive_plain if arrangement.is_plain else derive_general
    made = road(symbols_of(arrangement, inputs), arrangement, effects, loops, inputs)
    equations = replace(made, derive=derive)
    equations.store.is_frozen = True
    return equations


def _derive_plain(
    symbols: Symbols,
    arrangement: Arrangement,
    effects: "Sequence[Effect]",
    loops: LoopCount | None,
    inputs: Mapping[str, Input],
) -> Equations:
    """Hinges on a fixed world and nothing else."""
    tree, q, u = arrangement.tree, symbols.q, symbols.u
    inertias, coms, loads = begin_plain(symbols, arrangement, effects)
    with symbols.store.section(_INERTIA, source=_PARALLEL):
        base = regrouped(symbols.store, tree, inertias)
    problem = Problem(loads.kinematics, base, u, loads)
    solved = _solved(problem, close_cycles(tree, q, u) if tree.cuts else None, symbols.parameters)
    masses = Masses(inertias, coms, {})
    return assemble(symbols, arrangement, loads, masses, solved, loops or count_loops(tree), effects, inputs)


def begin_plain(
    symbols: Symbols, arrangement: Arrangement, effects: "Sequence[Effect]"
) -> tuple[tuple[Inertia, ...], tuple[Vector3, ...], Loads]:
    """All that knows numbers of the design: inertias of the links, their centres of mass, and loads. In it every
    parameter is made, in order; what follows is written in them, and in numbers of the drawing by their keys."""
    store, tree = symbols.store, arrangement.tree
    with store.section(_INERTIA, source=_PARALLEL):
        pairs = [_tagged_inertia(store, i, link, symbols.parameters) for i, link in enumerate(tree.links)]
    inertias, coms = zip(*pairs, strict=True) if pairs else ((), ())
    placement = Placement(Kinematics(store, tree, symbols.q))
    return inertias, coms, collect(symbols, placement, (), effects)


def _tagged_inertia(store: Store, index: int, link: Link, parameters: Parameters) -> tuple[Inertia, Vector3]:
    store.link = index
    return link_inertia(link, parameters.add)


class Problem:
    """M u̇ = f in carrier components; internal axes inside, joint angles outside."""

    def __init__(
        self, kinematics: Kinematics, base: list[Inertia], u: Sequence[Scalar], loads: Loads
    ) -> None:
        self.kinematics = kinematics
        self._u, self._loads = u, loads
        self.signs = [link.angle_sign for link in kinematics.tree.links]
        with kinematics.store.section("Inertia in carrier frames", source="eq. 7-11"):
            self.inertias = [self._in_carrier(i, inertia) for i, inertia in enumerate(base)]
        self.wrenches = self._wrenches(None)
        count = len(self.signs)
        self.torques = [s * t for s, t in zip(self.signs, loads.hinge_torques[:count], strict=True)]
        self._at_cuts = loads.hinge_torques[count:]

    def _wrenches(self, accelerations: Sequence[Scalar] | None) -> list[Wrench]:
        """Inertia forces less applied ones, for hinge accelerations given or zero."""
        kinematics, loads = self.kinematics, self._loads
        biases = kinematics.biases(self._u, self._world_accelerations(loads.field), accelerations)
        wrenches: list[Wrench] = []
        with kinematics.store.section("Inertia forces and applied loads", source="eq. 18"):
            for i, (inertia, bias) in enumerate(zip(self.inertias, biases, strict=True)):
                kinematics.store.link = i
                wrenches.append(_less(inertia_wrench(inertia, bias), loads.wrenches.get(i)))
        return wrenches

    def _in_carrier(self, index: int, inertia: Inertia) -> Inertia:
        kinematics = self.kinematics
        kinematics.store.link = index
        return Inertia(
            inertia.mass,
            kinematics.in_carrier(index, inertia.first),
            kinematics.symmetric_in_carrier(index, inertia.second),
            inertia.axial,
        )

    def _world_accelerations(self, field: Vector3) -> list[Vector3]:
        """A uniform field is an acceleration of the world the other way."""
        links = self.kinematics.tree.links
        return [
            rotate_back(self.kinematics.drawn_frame(i), (-field[0], -field[1], -field[2]))
            if link.parent == WORLD
            else (0, 0, 0)
            for i, link in enumerate(links)
        ]

    def solve(self, how: str) -> list[Scalar]:
        solve = {"elimination": solve_by_elimination, "mass matrix": solve_by_mass_matrix}[how]
        result = solve(self.kinematics, self.inertias, self.wrenches, self.torques)
        return [s * value for s, value in zip(self.signs, result, strict=True)]

    def forces(self) -> list[Scalar]:
        values = generalised_forces(self.kinematics, self.wrenches, self.torques)
        return [*(s * value for s, value in zip(self.signs, values, strict=True)), *self._at_cuts]

    def residual(self, accelerations: Sequence[Scalar]) -> list[Scalar]:
        """M u̇ - f, N·m, by inverse dynamics: no mass matrix is formed."""
        values = generalised_forces(self.kinematics, self._wrenches(accelerations), self.torques)
        at_cuts = (-torque for torque in self._at_cuts)
        return [*(-(s * value) for s, value in zip(self.signs, values, strict=True)), *at_cuts]

    def momenta(self, accelerations: Sequence[Scalar]) -> list[Scalar]:
        """M u̇, N·m, by inverse dynamics at rest and without loads."""
        kinematics, count = self.kinematics, len(self.signs)
        biases = kinematics.biases([0] * count, [ZERO] * count, accelerations)
        wrenches: list[Wrench] = []
        with kinematics.store.section("Momenta", source="eq. 18 at rest"):
            for i, (inertia, bias) in enumerate(zip(self.inertias, biases, strict=True)):
                kinematics.store.link = i
                wrenches.append(inertia_wrench(inertia, bias))
        values = generalised_forces(kinematics, wrenches, [0] * count)
        return [
            *(-(s * value) for s, value in zip(self.signs, values, strict=True)),
            *(0 for _ in self._at_cuts),
        ]

    def mass_matrix(self) -> Mapping[tuple[int, int], Scalar]:
        entries = mass_matrix(self.kinematics, self.inertias)
        return {(i, j): self.signs[i] * self.signs[j] * value for (i, j), value in sorted(entries.items())}


def _less(wrench: Wrench, applied: Wrench | None) -> Wrench:
    if applied is None:
        return wrench
    minus = [(-v[0], -v[1], -v[2]) for v in applied]
    return add(wrench[0], minus[0]), add(wrench[1], minus[1])


def _solved(problem: Problem, closure: Closure | None, parameters: Parameters) -> Solved:
    """u̇ by the cheaper of both ways where both can be that."""
    if closure is not None:
        return Solved(problem, closure, CONSTRAINED)
    tree, store = problem.kinematics.tree, problem.kinematics.store
    ways = ["elimination"]
    if sum(len(way_to_world(tree, i)) for i in range(len(tree.links))) <= MAX_PAIRS_FOR_MASS_MATRIX:
        ways.append("mass matrix")
    solutions: dict[str, Sequence[Scalar]] = {way: problem.solve(way) for way in ways}
    flops = {way: count_operations(store, values, Level.PARAMETER).flops for way, values in solutions.items()}
    solver = _cheapest(store, solutions, flops, parameters)
    return Solved(problem, None, solver, tuple(solutions[solver]), flops)


def _cheapest(
    store: Store,
    solutions: Mapping[str, Sequence[Scalar]],
    flops: Mapping[str, int],
    parameters: Parameters,
) -> str:
    """The solution of least operations when nothing comes from outside: torques that are zero then leave every bit as
    it is without them, and another way to solve would not."""
    outside: dict[Value, Scalar] = dict.fromkeys(parameters.from_outside(), 0)
    if len(solutions) > 1 and outside:
        with suppress(ArithmeticError):  # an effect that divides by what is zero has no motion without it
            without = {way: substitute(values, outside) for way, values in solutions.items()}
            flops = {way: count_operations(store, v, Level.PARAMETER).flops for way, v in without.items()}
    return min(solutions, key=lambda way: flops.get(way, 0))
