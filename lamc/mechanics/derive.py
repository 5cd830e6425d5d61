"""`derive`: from a Tree and effects to Equations. The only place where mechanism, loads and solution meet.

Goes in: the tree, the effects of the scene. Comes out: staged accelerations, M and f, energies and poses in one
store. It knows no effect by name, and makes no text.
"""

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

from lamc.basics.errors import about
from lamc.loops.rank import LoopCount, count_loops
from lamc.mechanics.arrangement import Arrangement, arrange
from lamc.mechanics.closure import close, cut_hinges
from lamc.mechanics.elimination import Wrench, inertia_wrench, solve_by_elimination
from lamc.mechanics.equations import Equations
from lamc.mechanics.general import derive_general
from lamc.mechanics.guards import guard_terms
from lamc.mechanics.inertia import Inertia, link_inertia, regrouped
from lamc.mechanics.kinematics import Kinematics
from lamc.mechanics.loads import Loads
from lamc.mechanics.mass_matrix import generalised_forces, mass_matrix, solve_by_mass_matrix, way_to_world
from lamc.mechanics.parameters import Parameters
from lamc.mechanics.placement import Placement, potential_of_field, rotate_back
from lamc.mechanics.powers import Mass, Moving, powers_of
from lamc.mechanism.tree import WORLD, Link, Tree
from lamc.records.effect import claims_of, hooked
from lamc.records.inputs import NO_INPUTS, Input
from lamc.symbolic.algebra import Symmetric, Vector3, add, cross, dot, scale
from lamc.symbolic.allocation import collector_paused
from lamc.symbolic.program import Space
from lamc.symbolic.staging import Level, Scalar, Store, Value
from lamc.symbolic.statements import count_operations
from lamc.symbolic.substitution import substitute

if TYPE_CHECKING:
    from lamc.records.effect import Effect

# The mass-matrix form grows with the square of the depth; with more pairs of hinges on common ways to the world
# than this it has lost in every mechanism measured (`python -m benchmarks.solver_crossover`), and is not tried.
MAX_PAIRS_FOR_MASS_MATRIX = 60

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
    equations = road(arrangement, effects, loops, inputs)
    equations.store.is_frozen = True
    return equations


def _derive_plain(
    arrangement: Arrangement,
    effects: "Sequence[Effect]",
    loops: LoopCount | None,
    inputs: Mapping[str, Input],
) -> Equations:
    """Hinges on a fixed world and nothing else."""
    tree, store = arrangement.tree, Store()
    count = len(tree.links)
    names = tree.joint_names
    parameters = Parameters(store)
    time = store.symbol("t", Space.TIME, 0)
    q = [store.symbol(f"q_{name}", Space.ANGLE, i) for i, name in enumerate(names)]
    u = [store.symbol(f"u_{name}", Space.RATE, i) for i, name in enumerate(names)]
    given = parameters.declare(inputs, names)
    with store.section(
        "Inertia about the hinges, base parameters", source="parallel axes; Gautier & Khalil 1990"
    ):
        pairs = [_tagged_inertia(store, i, link, parameters) for i, link in enumerate(tree.links)]
        inertias = [inertia for inertia, _ in pairs]
        base = regrouped(store, tree, inertias)
    placement = Placement(Kinematics(store, tree, q))
    hinges = cut_hinges(placement, u)
    loads = Loads(placement, parameters, time, q, u, hinges, given)
    loads.claims = {claim: effect.name for effect in effects for claim in claims_of(effect)}
    for effect in effects:
        with about(effect), loads.effect(effect.name, effect.summary, hooked(effect).source):
            effect.contribute(loads)
    problem = Problem(placement.kinematics, base, u, loads)
    solutions, flops = ({CONSTRAINED: ()}, {}) if hinges else _solutions(problem, count)
    solver = _cheapest(store, solutions, flops, parameters)
    coms = [com for _, com in pairs]
    return Equations(
        tree=tree,
        effects=tuple(effects),
        store=store,
        parameters=tuple(parameters.records),
        acceleration=tuple(solutions[solver]),
        problem=problem,
        closure=close(hinges, q, u) if hinges else None,
        energies=_energies(placement, inertias, coms, u, loads),
        poses=tuple(_poses(placement, coms)),
        loops=loops or count_loops(tree),
        guards=tuple(guard_terms(guard, q, u) for guard in loads.guards),
        solver=solver,
        solver_flops=flops,
        arrangement=arrangement,
        inputs=inputs,
        account_for_powers=partial(_powers, loads, placement, pairs, q, u, time),
    )


def _powers(
    loads: Loads,
    placement: Placement,
    pairs: Sequence[tuple[Inertia, Vector3]],
    q: Sequence[Value],
    u: Sequence[Value],
    time: Value,
) -> dict[str, Scalar]:
    return powers_of(loads, _moving(placement, pairs, q, u, time))


def _moving(
    placement: Placement,
    pairs: Sequence[tuple[Inertia, Vector3]],
    q: Sequence[Value],
    u: Sequence[Value],
    time: Value,
) -> Moving:
    """What the loads of a tree of hinges on the world do work on."""
    kinematics = placement.kinematics
    masses = []
    for i, (inertia, com) in enumerate(pairs):
        kinematics.store.link = i
        masses.append(Mass(inertia.mass, scale(inertia.mass, kinematics.in_carrier(i, com))))
    udot = [
        kinematics.store.symbol(f"udot_{name}", Space.ACCELERATION, i)
        for i, name in enumerate(kinematics.tree.joint_names)
    ]
    speeds: dict[Value, Scalar] = {time: 1, **dict(zip((*q, *u), (*u, *udot), strict=True))}
    return Moving(placement, masses, 0, u, speeds)


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
        self.torques = [s * torque for s, torque in zip(self.signs, loads.hinge_torques, strict=True)]

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
        placement = Placement(self.kinematics)
        return [
            rotate_back(placement.drawn(link), (-field[0], -field[1], -field[2]))
            if link.parent == WORLD
            else (0, 0, 0)
            for link in links
        ]

    def solve(self, how: str) -> list[Scalar]:
        solve = {"elimination": solve_by_elimination, "mass matrix": solve_by_mass_matrix}[how]
        result = solve(self.kinematics, self.inertias, self.wrenches, self.torques)
        return [s * value for s, value in zip(self.signs, result, strict=True)]

    def forces(self) -> list[Scalar]:
        values = generalised_forces(self.kinematics, self.wrenches, self.torques)
        return [s * value for s, value in zip(self.signs, values, strict=True)]

    def residual(self, accelerations: Sequence[Scalar]) -> list[Scalar]:
        """M u̇ - f, N·m, by inverse dynamics: no mass matrix is formed."""
        values = generalised_forces(self.kinematics, self._wrenches(accelerations), self.torques)
        return [-(s * value) for s, value in zip(self.signs, values, strict=True)]

    def mass_matrix(self) -> Mapping[tuple[int, int], Scalar]:
        entries = mass_matrix(self.kinematics, self.inertias)
        return {(i, j): self.signs[i] * self.signs[j] * value for (i, j), value in sorted(entries.items())}


def _less(wrench: Wrench, applied: Wrench | None) -> Wrench:
    if applied is None:
        return wrench
    minus = [(-v[0], -v[1], -v[2]) for v in applied]
    return add(wrench[0], minus[0]), add(wrench[1], minus[1])


def _solutions(problem: Problem, count: int) -> tuple[dict[str, Sequence[Scalar]], dict[str, int]]:
    """Both ways to u̇ where both can be cheapest, with their operation counts."""
    tree, store = problem.kinematics.tree, problem.kinematics.store
    ways = ["elimination"]
    if sum(len(way_to_world(tree, i)) for i in range(count)) <= MAX_PAIRS_FOR_MASS_MATRIX:
        ways.append("mass matrix")
    solutions: dict[str, Sequence[Scalar]] = {way: problem.solve(way) for way in ways}
    flops = {way: count_operations(store, values, Level.PARAMETER).flops for way, values in solutions.items()}
    return solutions, flops


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


def _energies(
    placement: Placement, inertias: list[Inertia], coms: list[Vector3], u: Sequence[Scalar], loads: Loads
) -> dict[str, Scalar]:
    kinematics = placement.kinematics
    store = kinematics.store
    energies: dict[str, Scalar] = {"kinetic": 0}
    motions = kinematics.motions(u)
    with store.section("Kinetic energy", source="½ m v² + v·(ω × h) + ½ ω·I ω"):
        for i, (inertia, motion) in enumerate(zip(inertias, motions, strict=True)):
            w, v = motion.omega, motion.velocity
            store.link = i
            second = kinematics.symmetric_in_carrier(i, inertia.second)
            turned = replace(inertia, second=second).rotational()
            spinning = dot(w, _apply(turned, w))
            first = kinematics.in_carrier(i, inertia.first)
            energies["kinetic"] = energies["kinetic"] + (
                0.5 * (inertia.mass * dot(v, v)) + dot(v, cross(w, first)) + 0.5 * spinning
            )
    energies |= loads.energies
    masses = [inertia.mass for inertia in inertias]
    for effect, acceleration in loads.field_effects:
        with store.section("Potential energy", effect=effect, source="-Σ m a·r"):
            potential = potential_of_field(placement, masses, coms, acceleration)
            energies[effect] = energies.get(effect, 0) + potential
    return energies


def _apply(a: Symmetric, v: Vector3) -> Vector3:
    x, y, z = (dot(row, v) for row in a.rows())
    return (x, y, z)


def _poses(placement: Placement, coms: list[Vector3]) -> list[Scalar]:
    values: list[Scalar] = []
    with placement.kinematics.store.section("Positions and rotations of the links", source="eq. 1-4"):
        for i, com in enumerate(coms):
            placement.kinematics.store.link = i
            values.extend(placement.point(i, com))
            for row in placement.body_rotation(i):
                values.extend(row)
    return values
