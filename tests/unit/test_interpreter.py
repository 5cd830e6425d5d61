"""The interpreter: operations by their definitions, whole programs against the numeric cross-check."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lamc.basics.errors import DesignError, EmitError
from lamc.effects import Torque
from lamc.mechanics.derive import derive
from lamc.mechanics.lower import lower
from lamc.mechanism.plan import plan
from lamc.records.mechanism import Mechanism
from lamc.reference.interpreter import Interpreter
from lamc.reference.newton_euler import NewtonEuler
from lamc.reference.sympy_kane import kane
from lamc.symbolic.functions import FUNCTIONS
from lamc.symbolic.operations import BATCHED, SCALAR
from lamc.symbolic.program import (
    Coordinate,
    Function,
    Operand,
    Operations,
    Parameter,
    Program,
    Section,
    Shape,
    Space,
    Statement,
)
from tests.support.mechanisms import ALL_PASSIVE, chain, random_state, random_tree, trees
from tests.support.quick import tries

NO_OPERATIONS = Operations()
SECTION = (Section("by hand", "", ""),)


def function(name: str, statements: list[Statement], outputs: list[tuple[int, Operand]]) -> Function:
    return Function(name, "", (), tuple(statements), tuple(outputs), SECTION, NO_OPERATIONS)


def one_shape(shape: Shape) -> Program:
    """Two joints; both accelerations are ± shape(q0, u1); the only constant is twice the only parameter."""
    doubled = Statement(
        Operand(Space.LOCAL, 0),
        ("*", 0, 1),
        (Operand(Space.NUMBER, value=2.0), Operand(Space.PARAMETER, 0)),
        0,
    )
    result = Statement(Operand(Space.LOCAL, 0), shape, (Operand(Space.ANGLE, 0), Operand(Space.RATE, 1)), 0)
    local = Operand(Space.LOCAL, 0)
    return Program(
        name="by hand",
        joints=("a", "b"),
        coordinates=(Coordinate("a", "rad"), Coordinate("b", "rad")),
        rates=(Coordinate("a", "rad/s"), Coordinate("b", "rad/s")),
        bodies=(),
        parameters=(Parameter("k", 1.5, "", "", ""),),
        constant_count=1,
        energies=("kinetic",),
        functions={
            "setup": function("setup", [doubled], [(1, local)]),
            "acceleration": function("acceleration", [result], [(1, local), (-1, local)]),
            "energy": function("energy", [], [(1, Operand(Space.CONSTANT, 0))]),
            "poses": function("poses", [], []),
        },
    )


def test_every_function_of_the_compiler_has_a_meaning_here() -> None:
    arithmetic = {"+", "-", "*", "neg", "reciprocal"}
    assert set(SCALAR) == set(BATCHED) == set(FUNCTIONS) | arithmetic


@pytest.mark.parametrize(
    ("shape", "expected"),
    [
        (("+", 0, 1), 0.7 - 1.3),
        (("-", 0, 1), 0.7 + 1.3),
        (("*", 0, ("neg", 1)), 0.7 * 1.3),
        (("reciprocal", 1), -1 / 1.3),
        (("sin", ("*", 0, 1)), math.sin(0.7 * -1.3)),
        (("atan2", 1, 0), math.atan2(-1.3, 0.7)),
        (("min", 0, 1), -1.3),
        (("max", 0, ("abs", 1)), 1.3),
        (("pow", 0, ("sign", 1)), 1 / 0.7),
        (("+", ("sqrt", 0), ("exp", ("log", 0))), math.sqrt(0.7) + 0.7),
    ],
)
def test_shapes_mean_what_they_say(shape: Shape, expected: float) -> None:
    interpreter = Interpreter(one_shape(shape))
    constants = interpreter.constants()
    q, u = np.array([0.7, 9.0]), np.array([9.0, -1.3])
    found = interpreter.acceleration(0.0, q, u, constants)
    # 1e-15: one rounding more or less than in the expression written here
    assert found == pytest.approx([expected, -expected], rel=1e-15)
    batch = interpreter.acceleration(0.0, np.array([q, q]), np.array([u, u]), constants)
    assert batch == pytest.approx(np.array([found, found]), rel=1e-15)


@pytest.mark.parametrize("name", sorted(SCALAR))
def test_numbers_and_arrays_agree_outside_the_domain_too(name: str) -> None:
    two = name in ("+", "-", "*", "atan2", "min", "max", "pow")
    numbers = [0.0, -0.0, 1.0, -2.0, 0.5, 800.0, -800.0, 3.0, math.inf, -math.inf, math.nan]
    for x in numbers:
        for y in numbers if two else [0.0]:
            arguments = (x, y) if two else (x,)
            with np.errstate(all="ignore"):
                expected = float(BATCHED[name](*(np.array([a]) for a in arguments))[0])
            found = SCALAR[name](*arguments)
            if name == "sign" and math.isnan(x):
                continue  # the C, like this cross-check, gives 0 there: (x > 0) - (x < 0)
            # two libraries' functions may differ by a few units in the last place
            assert found == pytest.approx(expected, rel=1e-14, nan_ok=True), (name, arguments)


def test_parameters_reach_the_constants_by_name() -> None:
    interpreter = Interpreter(one_shape(("+", 0, 1)))
    assert interpreter.constants().tolist() == [3.0]
    assert interpreter.constants({"k": 4.0}).tolist() == [8.0]
    assert interpreter.energy(0.0, np.zeros(2), np.zeros(2), interpreter.constants()).tolist() == [3.0]
    with pytest.raises(DesignError, match="no parameter is named 'stiff'"):
        interpreter.constants({"stiff": 1.0})


def test_an_unknown_operation_is_refused() -> None:
    with pytest.raises(EmitError, match="'system' has no meaning"):
        Interpreter(one_shape(("system", 0)))


def test_states_of_the_wrong_size_are_refused() -> None:
    interpreter = Interpreter(one_shape(("+", 0, 1)))
    with pytest.raises(DesignError, match=r"must be \(…, 2\)"):
        interpreter.acceleration(0.0, np.zeros(3), np.zeros(3), interpreter.constants())


@settings(max_examples=tries(20), deadline=None)
@given(mechanism=trees(30), seed=st.integers(0, 2**31))
def test_derived_equations_agree_with_newton_euler_on_random_trees(mechanism: Mechanism, seed: int) -> None:
    torque = Torque({"h0": "0.1*sin(2*pi*t) - 0.2*rate + angle^2*max(t, 0.1) + atan2(t, angle)"})
    effects = (*ALL_PASSIVE, torque)
    interpreter = Interpreter(lower(derive(plan(mechanism), effects)))
    newton = NewtonEuler(mechanism, effects, interpreter.joints)
    constants = interpreter.constants()
    q, u = random_state(len(mechanism.joints), seed)
    # 1e-10: the limit for an independent formulation (round-off times the mass matrix's condition)
    found, expected = interpreter.acceleration(0.3, q, u, constants), newton.acceleration(q, u, 0.3)
    assert np.abs(found - expected).max() < 1e-10 * np.abs(expected).max()
    energies = newton.energy(q, u)
    size = sum(abs(v) for v in energies.values())
    for name, value in zip(
        interpreter.program.energies, interpreter.energy(0.3, q, u, constants), strict=True
    ):
        assert abs(value - energies[name]) < 1e-12 * size  # sums of some 1e2 terms, nothing is solved
    order = [newton.bodies.index(name) for name in interpreter.bodies]
    for ours, theirs in zip(interpreter.poses(q, constants), newton.poses(q), strict=True):
        assert np.abs(ours - theirs[order]).max() < 1e-12  # m and 1; thirty rotations one after the other


@pytest.mark.parametrize(
    "mechanism",
    [
        chain(2, "space", seed=2),
        pytest.param(chain(3, "laminate", seed=3), marks=pytest.mark.campaign),
        pytest.param(chain(4, "mixed", seed=4), marks=pytest.mark.campaign),
        random_tree(3, seed=5, kind="mixed"),
    ],
    ids=lambda m: m.name,
)
@pytest.mark.slow
def test_derived_equations_equal_kanes_method_of_sympy(mechanism: Mechanism) -> None:
    interpreter = Interpreter(lower(derive(plan(mechanism), ALL_PASSIVE)))
    constants = interpreter.constants()
    oracle = kane(mechanism, ALL_PASSIVE, interpreter.joints).lambdified()
    for seed in range(5):
        q, u = random_state(len(mechanism.joints), seed)
        expected = oracle(q, u, 0.0)
        found = interpreter.acceleration(0.0, q, u, constants)
        assert np.abs(found - expected).max() < 1e-12 * np.abs(expected).max()  # the limit
