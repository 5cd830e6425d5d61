"""`sim.equations`: symbolic objects that evaluate to the simulator's numbers, and stay small however long the chain."""

import numpy as np
import pytest
import sympy as sp

import lamc
from lamc.effects import Gravity, HingeDamping, HingeStiffness, Torque
from lamc.mechanics.equations import Equations
from lamc.pipeline import equations_of
from lamc.records.mechanism import Mechanism
from lamc.records.scene import Scene
from lamc.symbolic.statements import MAX_OPERANDS
from tests.support.ctools import needs_cc
from tests.support.mechanisms import ALL_PASSIVE, chain, random_state, random_tree, unit_plate_pendulum
from tests.support.symbolic import evaluator, inputs_of

LOADED = (Gravity((0.0, 0.0, -9.81)), HingeStiffness(), HingeDamping())
MECHANISMS = [chain(2, "space", seed=1), random_tree(6, seed=9, kind="mixed"), chain(5, "parallel", seed=4)]


def defined_before_use(equations: Equations) -> None:
    known = set(inputs_of(equations))
    for assignment in equations.assignments:
        assert assignment.expression.free_symbols <= known, assignment
        assert assignment.symbol not in known, f"{assignment.symbol} is assigned twice"
        known.add(assignment.symbol)
    assert {sp.Symbol(f"udot_{j}") for j in equations.joints} <= known


@needs_cc
@pytest.mark.parametrize("mechanism", MECHANISMS, ids=lambda m: m.name)
@pytest.mark.quick("chain2", others="campaign")
def test_assignments_in_order_give_the_accelerations(mechanism: Mechanism) -> None:
    scene = Scene(effects=(*ALL_PASSIVE, Torque({"h0": "0.2*sin(3*t) - 0.1*rate*abs(rate) + max(angle, 0)"})))
    sim = lamc.compile(mechanism, scene)
    equations = sim.equations
    defined_before_use(equations)
    outputs = [sp.Symbol(f"udot_{j}") for j in sim.joints]
    evaluate = evaluator(equations, equations.assignments, outputs)
    parameters = {name: 1.25 * value for name, value in sim.parameters.items() if "stiffness" in name}
    for seed in range(3):
        q, u = random_state(len(sim.joints), seed)
        for changed in ({}, parameters):
            found, expected = evaluate(0.7, q, u, changed), sim.acceleration(q, u, 0.7, changed)
            # the same operations in the same order, but for sympy's own reordering of short sums
            assert np.abs(found - expected).max() <= 1e-12 * np.abs(expected).max()


@needs_cc
@pytest.mark.parametrize("mechanism", MECHANISMS, ids=lambda m: m.name)
@pytest.mark.quick("chain2", others="campaign")
def test_mass_matrix_and_forces_solve_to_the_accelerations(mechanism: Mechanism) -> None:
    sim = lamc.compile(mechanism, Scene(effects=ALL_PASSIVE))
    equations, n = sim.equations, len(sim.joints)
    outputs = [*equations.mass_matrix, *equations.generalised_forces]
    evaluate = evaluator(equations, equations.mass_assignments, outputs)
    assert equations.mass_matrix == equations.mass_matrix.T
    for seed in range(3):
        q, u = random_state(n, seed)
        values = evaluate(0.0, q, u, {})
        matrix, forces = values[: n * n].reshape(n, n), values[n * n :]
        assert np.linalg.eigvalsh(matrix).min() > 0  # a mass matrix
        expected = sim.acceleration(q, u)
        # two ways to solve a system whose condition is below 1e3
        assert np.abs(np.linalg.solve(matrix, forces) - expected).max() <= 1e-11 * np.abs(expected).max()
        kinetic = 0.5 * u @ matrix @ u
        stored = sim.energy(q, np.zeros(n))
        assert kinetic == pytest.approx(sim.energy(q, u) - stored, rel=1e-11)


def test_mass_matrix_has_zeros_between_separate_branches() -> None:
    mechanism = random_tree(9, seed=12)
    equations = equations_of(mechanism, ())
    ways: list[set[int]] = []
    for i, link in enumerate(equations.tree.links):
        ways.append({i} | (ways[link.parent] if link.parent >= 0 else set()))
    for i in range(9):
        for j in range(9):
            assert (equations.mass_matrix[i, j] == 0) == (i not in ways[j] and j not in ways[i])


def test_equations_name_their_origin_and_print() -> None:
    mechanism, _ = unit_plate_pendulum()
    equations = equations_of(mechanism, (*LOADED, Torque({"h1": "0.1*sin(2*pi*t)"})))
    shown = {a.effect for a in equations.assignments} - {""}
    assert shown == {"torque", "hinge_stiffness", "hinge_damping"}
    assert any("eq. 19" in a.source for a in equations.assignments)
    first = equations.assignments[0]
    assert str(first) == f"{first.symbol} = {first.expression}"
    assert all(sp.latex(a.expression) for a in equations.assignments)


def test_one_pendulum_written_out_is_the_textbook_equation() -> None:
    rod = Mechanism(
        (
            lamc.Body("ground", fixed=True),
            lamc.Body("rod", 2.0, np.array([0.0, 0.0, -0.5]), np.diag([0.3, 0.3, 0.0])),
        ),
        (lamc.Joint("hip", "ground", "rod", axis=np.array([0.0, 1.0, 0.0])),),
    )
    equations = equations_of(rod, (Gravity(),))
    (udot,) = equations.acceleration
    written = equations.written_out(udot)
    q = sp.Symbol("q_hip")
    numbers = {sp.Symbol(p.name): sp.nsimplify(p.default) for p in equations.parameters}
    expected = -2 * sp.Rational(981, 100) * sp.Rational(1, 2) / (sp.Rational(3, 10) + 2 * sp.Rational(1, 4))
    for angle in (0.1, 1.0, -2.0):
        found = float(written.subs(numbers).subs(q, angle))
        assert found == pytest.approx(float(expected) * np.sin(angle), rel=1e-14)


# ---- no swell -------------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_expressions_do_not_swell() -> None:
    equations = equations_of(chain(30, "space", seed=2), ALL_PASSIVE)
    largest = max(sp.count_ops(a.expression) for a in equations.assignments)
    # MAX_OPERANDS in one sum of products, each with a sign at most
    assert largest <= 2 * MAX_OPERANDS


def flops(n: int, kind: str) -> int:
    return equations_of(chain(n, kind, seed=n), LOADED).operations.flops


@pytest.mark.parametrize(("kind", "per_body"), [("parallel", 67), ("laminate", 310)])
@pytest.mark.parametrize("n", [20, 40, 100])
def test_operations_per_body_stay_within_the_budget(kind: str, per_body: int, n: int) -> None:
    assert flops(n, kind) <= per_body * n


@pytest.mark.parametrize("kind", ["parallel", "laminate", "space"])
def test_operations_grow_linearly(kind: str) -> None:
    a, b, c = flops(20, kind), flops(40, kind), flops(60, kind)
    # one more body costs the same wherever it is added, but for zeros that a drawing happens to have
    assert c - b == pytest.approx(b - a, rel=0.03)


@pytest.mark.parametrize("n", [1, 3, 5])
def test_the_cheaper_solution_is_taken(n: int) -> None:
    equations = equations_of(chain(n, "space", seed=n), LOADED)
    assert set(equations.solver_flops) == {"elimination", "mass matrix"}
    assert equations.operations.flops == min(equations.solver_flops.values())


def test_energies_belong_to_their_effects() -> None:
    equations = equations_of(chain(3), ALL_PASSIVE)
    assert next(iter(equations.energies)) == "kinetic"
    assert set(equations.energies) == {"kinetic", "gravity", "hinge_stiffness", "rest_angle"}
