"""Frames, vectors and Kane's method as the paper writes them, against scipy, closed forms and the simulator.

Also loads of a user's own, written in sympy, through both doors: `System.stage` and an `Effect`.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import pytest
import sympy as sp
from scipy.spatial.transform import Rotation

import lamc
from lamc.basics.errors import DesignError, ExpressionError
from lamc.effects import Gravity
from lamc.mechanics.frames import Frame, System, Vector
from lamc.mechanics.kane import Kane
from lamc.mechanics.loads import Loads
from lamc.records.mechanism import Mechanism
from lamc.records.scene import Scene
from lamc.reference.interpreter import Interpreter
from lamc.reference.newton_euler import NewtonEuler
from lamc.reference.sympy_kane import kane as sympy_kane
from lamc.symbolic.scalars import Scalar
from tests.support.ctools import needs_cc, program_of
from tests.support.mechanisms import ALL_PASSIVE, Array, chain, random_state, random_tree
from tests.support.symbolic import evaluator


def numbers(system: System, values: list[Scalar]) -> Callable[..., Array]:
    """A function of (q, u) with the numeric values of some staged ones, by the interpreter."""
    count, size = len(values), max(len(values), len(system.angles))
    interpreter = Interpreter(program_of(system.store, [*values, *[0] * (size - count)]))
    constants = interpreter.constants()

    def evaluate(q: Array, u: Array) -> Array:
        padding = np.zeros(size - len(q))
        return interpreter.acceleration(
            0.0, np.concatenate([q, padding]), np.concatenate([u, padding]), constants
        )[:count]

    return evaluate


# ---- frames and vectors (eq. 1-14) ----------------------------------------------------------------------------


@pytest.mark.parametrize(
    "axis", [(1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 2, -2), (-0.3, 0.4, 1.2), (1e-3, 0, 1e3)]
)
@pytest.mark.parametrize("angle", [0.0, 0.4, -2.9, math.pi, 7.0])
def test_a_turn_is_the_rotation_about_its_axis(axis: tuple[float, float, float], angle: float) -> None:
    system = System()
    q, _, _ = system.coordinate("q")
    frame = Frame.turned("A", system.world, axis, q)
    found = numbers(system, [e for row in frame.rotation for e in row])([angle], [0.0]).reshape(3, 3)
    unit = np.array(axis) / np.linalg.norm(axis)
    assert np.abs(found - Rotation.from_rotvec(angle * unit).as_matrix()).max() < 1e-15 * 4  # four roundings


def test_turns_follow_one_another() -> None:
    system = System()
    (a, _, _), (b, _, _) = system.coordinate("a"), system.coordinate("b")
    first = Frame.turned("A", system.world, (1, 1, 0), a)
    second = Frame.turned("B", first, (0, 0.6, 0.8), b)
    columns = [second.vector(*e).express(system.world) for e in np.eye(3).tolist()]
    found = numbers(system, [x for column in columns for x in column])([0.7, -1.2], [0, 0]).reshape(3, 3).T
    expected = (
        Rotation.from_rotvec(0.7 * np.array([1, 1, 0]) / math.sqrt(2))
        * Rotation.from_rotvec(-1.2 * np.array([0, 0.6, 0.8]))
    ).as_matrix()
    assert np.abs(found - expected).max() < 1e-14
    back = second.vector(1, 2, 3).express(system.world)
    there_and_back = system.world.vector(*back).express(second)
    assert numbers(system, list(there_and_back))([0.7, -1.2], [0, 0]) == pytest.approx([1, 2, 3], abs=1e-14)


def test_an_axis_without_direction_is_refused() -> None:
    system = System()
    for axis in ((0, 0, 0), (math.nan, 0, 1)):
        with pytest.raises(DesignError, match="must have a direction"):
            Frame.turned("A", system.world, axis, 0.1)


def moving_point(system: System) -> tuple[Frame, Frame, Vector]:
    (a, _, _), (b, _, _) = system.coordinate("a"), system.coordinate("b")
    first = Frame.turned("A", system.world, (0.48, 0.6, 0.64), a)
    second = Frame.turned("B", first, (1, 0, 0), b)
    return first, second, first.vector(1.0, 0.2, 0) + second.vector(a * b, 0.5, 0.1)


@pytest.mark.parametrize("seen_from", [0, 1, 2])
def test_derivatives_in_frames_are_those_of_differences(seen_from: int) -> None:
    system = System()
    first, second, point = moving_point(system)
    frame = (system.world, first, second)[seen_from]
    place = numbers(system, list(point.express(frame)))
    velocity = numbers(system, list(point.derivative(frame).express(frame)))
    q, u, step = np.array([0.8, -0.5]), np.array([1.3, -0.9]), 1e-5
    difference = (place(q + step * u, u) - place(q - step * u, u)) / (2 * step)
    # central differences: step² times a third derivative of some 10, and round-off / step
    assert velocity(q, u) == pytest.approx(difference, abs=1e-8)


def test_algebra_of_vectors_is_that_of_components() -> None:
    system = System()
    first, second, _ = moving_point(system)
    v, w = first.vector(1, -2, 3), second.vector(0.5, 1.5, -1)
    at = numbers(system, [*v.express(system.world), *w.express(system.world)])([0.3, 1.1], [0, 0])
    a, b = at[:3], at[3:]
    values = [v.dot(w), *(v.cross(w)).express(system.world), *(v - 2 * w).express(system.world)]
    found = numbers(system, values)([0.3, 1.1], [0, 0])
    assert found == pytest.approx([a @ b, *np.cross(a, b), *(a - 2 * b)], abs=1e-14)


def test_angular_velocity_is_the_axial_vector_of_the_rotation_rate() -> None:
    system = System()
    _, second, _ = moving_point(system)
    columns = [second.vector(*e).express(system.world) for e in np.eye(3).tolist()]
    rotation = numbers(system, [x for column in columns for x in column])
    omega = numbers(system, list(second.angular_velocity_in(system.world).express(system.world)))
    q, u, step = np.array([0.8, -0.5]), np.array([1.3, -0.9]), 1e-5
    matrix = rotation(q, u).reshape(3, 3).T
    rate = (rotation(q + step * u, u) - rotation(q - step * u, u)).reshape(3, 3).T / (2 * step)
    spin = rate @ matrix.T
    assert omega(q, u) == pytest.approx([spin[2, 1], spin[0, 2], spin[1, 0]], abs=1e-8)  # as above


# ---- Kane (eq. 15-19) -----------------------------------------------------------------------------------------


def test_double_pendulum_has_the_mass_matrix_of_the_textbook() -> None:
    system = System()
    (a, ua, _), (b, ub, _) = system.coordinate("a"), system.coordinate("b")
    m1, m2, l1, l2, g = (system.constant(name) for name in ("m1", "m2", "l1", "l2", "g"))
    upper = Frame.turned("A", system.world, (0, 0, 1), a)
    lower = Frame.turned("B", system.world, (0, 0, 1), b)  # absolute angles, x downwards
    knee = upper.vector(l1, 0, 0)
    tip = knee + lower.vector(l2, 0, 0)
    kane = Kane(system)
    for mass, point, frame in ((m1, knee, upper), (m2, tip, lower)):
        velocity = point.derivative(system.world)
        kane.body(frame, mass, ((0, 0, 0), (0, 0, 0), (0, 0, 0)), velocity)
        kane.force(system.world.vector(mass * g, 0, 0), velocity)
    matrix, forces = kane.equations()
    m1, m2, l1, l2, g, a, b, ua, ub = sp.symbols("m1 m2 l1 l2 g a b a_d b_d")
    expected = sp.Matrix(
        [[(m1 + m2) * l1**2, m2 * l1 * l2 * sp.cos(a - b)], [m2 * l1 * l2 * sp.cos(a - b), m2 * l2**2]]
    )
    right = sp.Matrix(
        [
            -m2 * l1 * l2 * sp.sin(a - b) * ub**2 - (m1 + m2) * g * l1 * sp.sin(a),
            m2 * l1 * l2 * sp.sin(a - b) * ua**2 - m2 * g * l2 * sp.sin(b),
        ]
    )
    point = dict(
        zip((m1, m2, l1, l2, g, a, b, ua, ub), (1.3, 0.7, 0.9, 1.1, 9.81, 0.4, -1.2, 2.1, -0.6), strict=True)
    )
    for i in range(2):
        for j in range(2):
            found = system.show(matrix[i][j]).subs(point)
            assert float(found) == pytest.approx(float(expected[i, j].subs(point)), rel=1e-14)
        assert float(system.show(forces[i]).subs(point)) == pytest.approx(
            float(right[i].subs(point)), rel=1e-14
        )


def textbook(mechanism: Mechanism, gravity: Array) -> tuple[System, Kane]:
    """A chain of hinges by frames and vectors, each joint's parent before its child."""
    system = System()
    kane = Kane(system)
    frames = {b.name: system.world for b in mechanism.bodies if b.fixed}
    places = {name: system.world.vector(0, 0, 0) for name in frames}  # of what is at the origin as drawn
    for joint in mechanism.joints:
        q, u, _ = system.coordinate(joint.name)
        parent = frames[joint.parent]
        frame = Frame.turned(joint.child, parent, joint.axis.tolist(), q)
        hinge = places[joint.parent] + parent.vector(*joint.point.tolist())
        place = hinge - frame.vector(*joint.point.tolist())
        frames[joint.child], places[joint.child] = frame, place
        body = mechanism.body(joint.child)
        velocity = (place + frame.vector(*body.com.tolist())).derivative(system.world)
        x, y, z = (tuple(row) for row in body.inertia.tolist())
        kane.body(frame, body.mass, (x, y, z), velocity)
        kane.force(system.world.vector(*(body.mass * gravity).tolist()), velocity)
        kane.hinge_torque(q, u, joint.stiffness, joint.damping, joint.rest_angle)
    return system, kane


@needs_cc
@pytest.mark.parametrize(("kind", "n"), [("space", 2), ("parallel", 3), ("mixed", 3)])
@pytest.mark.quick("parallel-3", "mixed-3")
@pytest.mark.ci("parallel-3", "mixed-3")
def test_textbook_simulator_and_sympy_find_the_same_accelerations(kind: str, n: int) -> None:
    mechanism = chain(n, kind, seed=8)
    system, kane = textbook(mechanism, np.array(ALL_PASSIVE[0].acceleration))
    matrix, forces = kane.equations()
    names = tuple(j.name for j in mechanism.joints)
    by_hand = numbers(system, [*(e for row in matrix for e in row), *forces])
    sim = lamc.compile(mechanism, Scene(effects=ALL_PASSIVE))
    assert sim.joints == names
    oracle = sympy_kane(mechanism, ALL_PASSIVE, names).lambdified() if kind == "space" else sim.acceleration
    for seed in range(4):
        q, u = random_state(n, seed)
        values = by_hand(q, u)
        found = np.linalg.solve(values[: n * n].reshape(n, n), values[n * n :])
        size = np.abs(found).max()
        assert np.abs(found - sim.acceleration(q, u)).max() < 1e-12 * size  # the limit
        assert np.abs(found - oracle(q, u, 0.0)).max() < 1e-12 * size


# ---- loads of a user's own ------------------------------------------------------------------------------------

DRAG = 0.37  # N·m·s²/rad²


@dataclass(frozen=True)
class QuadraticDrag:
    """-c u |u| on one hinge, in sympy."""

    joint: str
    name: ClassVar[str] = "quadratic_drag"
    summary: ClassVar[str] = "Quadratic drag"

    def contribute(self, loads: Loads) -> None:
        u = sp.Symbol(f"u_{self.joint}")
        loads.hinge_torque(self.joint, -DRAG * u * sp.Abs(u))

    @classmethod
    def default_for(cls, mechanism: Mechanism) -> tuple[None, str]:
        return None, "a test asks for it"


@dataclass(frozen=True)
class Pull:
    """A force and a moment that depend on time and on a hinge, at a point of a body."""

    body: str
    joint: str
    point: tuple[float, float, float]
    name: ClassVar[str] = "pull"
    summary: ClassVar[str] = "Pull"

    def contribute(self, loads: Loads) -> None:
        t, q = sp.Symbol("t"), sp.Symbol(f"q_{self.joint}")
        loads.force(self.body, self.point, [2 * sp.sin(3 * t), sp.cos(q), sp.Rational(1, 3)])
        loads.moment(self.body, [0, 0.2 * q**2, sp.exp(-t)])

    @classmethod
    def default_for(cls, mechanism: Mechanism) -> tuple[None, str]:
        return None, "a test asks for it"


def force_and_moment(t: float, q: float) -> tuple[Array, Array]:
    return np.array([2 * math.sin(3 * t), math.cos(q), 1 / 3]), np.array([0, 0.2 * q**2, math.exp(-t)])


@needs_cc
def test_drag_written_in_sympy_enters_by_an_effect_and_by_the_textbook() -> None:
    mechanism = chain(2, "space", seed=3)
    gravity = Gravity((0.0, 0.0, -9.81))
    sim = lamc.compile(mechanism, Scene(effects=(gravity, QuadraticDrag("h1"))))
    system, kane = textbook(mechanism, np.array(gravity.acceleration))
    rate = sp.Symbol("h1_d")
    kane.hinge_torque(
        system.angles[1], system.rates[1], applied=system.stage(-DRAG * rate * sp.Abs(rate)), stiffness=0
    )
    # `textbook` adds the hinges' own springs and dampers, which this scene leaves out.
    for q, u, joint in zip(system.angles, system.rates, mechanism.joints, strict=True):
        kane.hinge_torque(q, u, -joint.stiffness, -joint.damping, joint.rest_angle)
    matrix, forces = kane.equations()
    by_hand = numbers(system, [*(e for row in matrix for e in row), *forces])
    newton = NewtonEuler(mechanism, (gravity,), sim.joints)
    for seed in range(4):
        q, u = random_state(2, seed)
        values = by_hand(q, u)
        m = values[:4].reshape(2, 2)
        expected = newton.acceleration(q, u, 0.0) + np.linalg.solve(m, [0.0, -DRAG * u[1] * abs(u[1])])
        size = np.abs(expected).max()
        assert np.abs(sim.acceleration(q, u) - expected).max() < 1e-11 * size  # two solutions of M x = f
        assert np.abs(np.linalg.solve(m, values[4:]) - expected).max() < 1e-11 * size


@needs_cc
@pytest.mark.parametrize("kind", ["space", "parallel", "mixed"])
@pytest.mark.quick("parallel")
def test_a_force_at_a_point_does_virtual_work_through_its_jacobian(kind: str) -> None:
    mechanism = random_tree(5, seed=21, kind=kind)
    body, joint, n = "body4", "h4", 5
    point = mechanism.body(body).com + np.array([0.2, -0.1, 0.3])
    base = lamc.compile(mechanism, Scene(effects=ALL_PASSIVE))
    sim = lamc.compile(mechanism, Scene(effects=(*ALL_PASSIVE, Pull(body, joint, tuple(point.tolist())))))
    newton = NewtonEuler(mechanism, ALL_PASSIVE, sim.joints)
    index, coordinate, t = newton.bodies.index(body), sim.joints.index(joint), 0.4

    equations = base.equations
    inertia = evaluator(equations, equations.mass_assignments, list(equations.mass_matrix))

    def pose(q: Array) -> tuple[Array, Array]:
        coms, rotations = newton.poses(q)
        arm = rotations[index] @ (point - mechanism.body(body).com)
        return coms[index] + arm, rotations[index]

    for seed in range(3):
        q, u = random_state(n, seed)
        force, moment = force_and_moment(t, q[coordinate])
        work = np.zeros(n)
        step = 1e-5
        _, middle = pose(q)
        for k, e in enumerate(np.eye(n)):
            (high, rotated), (low, back) = pose(q + step * e), pose(q - step * e)
            spin = (rotated - back) @ middle.T / (2 * step)
            work[k] = force @ (high - low) / (2 * step) + moment @ [spin[2, 1], spin[0, 2], spin[1, 0]]
        # M (a' - a) = Jᵀ F, with M by the staged equations
        matrix = inertia(t, q, u, {}).reshape(n, n)
        difference = matrix @ (sim.acceleration(q, u, t) - base.acceleration(q, u, t))
        # differences of step 1e-5: 1e-10 of truncation, 1e-11 of round-off; forces and lengths below 5
        assert np.abs(difference - work).max() < 1e-8


@needs_cc
def test_positions_and_velocities_that_effects_see_are_those_of_the_motion() -> None:
    mechanism = chain(3, "space", seed=14)
    point = (0.4, -0.3, 0.8)

    @dataclass(frozen=True)
    class Watcher:
        name: ClassVar[str] = "watcher"
        summary: ClassVar[str] = "Watches a point"

        def contribute(self, loads: Loads) -> None:
            x, *_ = loads.position("body2", point)
            vx, *_ = loads.velocity("body2", point)
            loads.stored_energy(100.0 * x + vx)
            loads.force("ground", point, (1, 2, 3))  # on the world: does nothing
            assert loads.velocity("ground", point) == (0, 0, 0)
            assert loads.position("ground", point) == point

        @classmethod
        def default_for(cls, mechanism: Mechanism) -> tuple[None, str]:
            return None, ""

    sim = lamc.compile(
        mechanism, Scene(effects=(Watcher(),), angles={"h1": 0.5}, rates={"h0": 1.0, "h2": -2.0})
    )
    result = sim.run(t_end=0.2, t_eval=[0.0, 0.1, 0.2], rtol=1e-10)
    newton = NewtonEuler(mechanism, (), sim.joints)
    index = newton.bodies.index("body2")

    def along_x(q: Array) -> float:
        coms, rotations = newton.poses(q)
        return float((coms[index] + rotations[index] @ (np.array(point) - mechanism.body("body2").com))[0])

    step = 1e-5
    for q, u, found in zip(result.q, result.u, result.energies["watcher"], strict=True):
        speed = (along_x(q + step * u) - along_x(q - step * u)) / (2 * step)
        assert found == pytest.approx(100 * along_x(q) + speed, abs=1e-8)  # round-off / step


@pytest.mark.parametrize(
    ("contribute", "error", "words"),
    [
        (lambda x: x.hinge_torque("h9", 1.0), DesignError, "no joint is named 'h9'; the joints are h0, h1"),
        (lambda x: x.force("arm", (0, 0, 0), (0, 0, 1)), DesignError, "no body is named 'arm'"),
        (lambda x: x.force("body0", (0, 0), (0, 0, 1)), DesignError, "shape"),
        (lambda x: x.force("body0", (0, 0, math.nan), (0, 0, 1)), DesignError, "finite"),
        (lambda x: x.moment("body0", (0, 1)), DesignError, "2 components; it needs 3"),
        (lambda x: x.hinge_torque("h0", sp.Symbol("x")), ExpressionError, "'x'; known are q_h0"),
        (lambda x: x.hinge_torque("h0", sp.oo), ExpressionError, "not finite"),
        (lambda x: x.hinge_torque("h0", "q_h0"), ExpressionError, "str"),
    ],
)
def test_loads_that_cannot_be_are_refused_by_name(
    contribute: Callable[[Loads], None], error: type[Exception], words: str
) -> None:
    @dataclass(frozen=True)
    class Wrong:
        name: ClassVar[str] = "wrong"
        summary: ClassVar[str] = "Wrong"

        def contribute(self, loads: Loads) -> None:
            contribute(loads)

    with pytest.raises(error, match=words):
        lamc.pipeline.equations_of(chain(2), (Wrong(),))  # type: ignore[arg-type]
