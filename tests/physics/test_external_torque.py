"""Torques from outside: inputs of the model, which do work, and change nothing while they are zero."""

from pathlib import Path

import numpy as np
import pytest

import lamc
from lamc.basics.errors import DesignError
from lamc.effects import ExternalTorque, Gravity, HingeDamping, HingeStiffness, Torque
from lamc.effects.engine_loads import carried
from lamc.examples import __file__ as examples
from lamc.mechanics.lower import lower
from lamc.pipeline import effects_of, equations_of
from lamc.records.effect import Effect
from lamc.records.mechanism import Body, Joint, Mechanism
from lamc.records.scene import Scene
from lamc.reference.check import check
from lamc.reference.inputs import with_inputs
from lamc.reference.interpreter import Interpreter
from lamc.reference.maximal import MaximalCoordinates
from lamc.reference.moving_base import MovingNewtonEuler
from lamc.reference.newton_euler import NewtonEuler
from tests.support.ctools import needs_cc
from tests.support.every_effect import SAMPLES, mechanism
from tests.support.mechanisms import KINDS, chain

EXAMPLES = sorted(Path(examples).parent.glob("*.yaml"))
INERTIA = 0.02  # kg·m² about the hinge


def flap() -> Mechanism:
    """A body on a vertical hinge through its centre of mass: nothing but inertia."""
    bodies = (Body("ground", fixed=True), Body("flap", 1.0, (0.0, 0.0, 0.0), np.diag([0.01, 0.01, INERTIA])))
    return Mechanism(bodies, (Joint("h", "ground", "flap", (0.0, 0.0, 0.0), (0.0, 0.0, 1.0)),))


def load(path: Path) -> Mechanism:
    record = lamc.load(path)
    return record if isinstance(record, Mechanism) else lamc.split(record)


@needs_cc
def test_a_constant_torque_turns_a_free_body_by_half_its_acceleration_times_the_time_squared() -> None:
    sim = lamc.compile(flap(), Scene(effects=(ExternalTorque(),)))
    t = np.linspace(0.0, 2.0, 11)
    result = sim.run(t_end=2.0, t_eval=t, parameters={"h.torque": 3e-3})
    # a method of fifth order has no error on a parabola, and round-off stays
    assert result.angle("h") == pytest.approx(0.5 * 3e-3 / INERTIA * t**2, abs=1e-13)
    assert sim.inputs == ("h.torque",)
    assert sim.parameter_units["h.torque"] == "N·m"
    assert sim.run(t_end=2.0).angle("h")[-1] == 0.0


@needs_cc
def test_its_power_is_in_the_energy_balance_and_is_torque_times_turn() -> None:
    scene = Scene(effects=(Gravity(), HingeDamping(), HingeStiffness(), ExternalTorque()), angles={"h1": 0.3})
    given = {"h1.torque": 0.4, "h2.torque": -0.7}
    result = lamc.compile(mechanism(), scene).run(
        1.0, rtol=1e-10, atol=1e-12, parameters=given, energy_balance=True
    )
    rotations = {name: result.angle(name)[-1] - result.angle(name)[0] for name in ("h1", "h2")}
    work = sum(given[f"{name}.torque"] * rotations[name] for name in rotations)
    assert abs(work) > 0.01
    # rtol times some hundred steps, of about 1 J
    assert result.work["external_torque"][-1] == pytest.approx(work, abs=1e-8)
    assert result.energy_balance.balance < 1e-8


@pytest.mark.parametrize("kind", KINDS)
def test_it_is_the_torque_that_a_scene_calls_for_to_the_last_bit(kind: str) -> None:
    """The same number at the same place of the equations, whether the scene gives it or who runs them."""
    made = chain(3, kind, seed=5)
    with_inputs = {"h0": 0.3, "h1": -1.2, "h2": 0.05}
    passive = (Gravity(), HingeStiffness(), HingeDamping())
    inside, outside = (
        Interpreter(lower(equations_of(made, (*passive, effect))))
        for effect in (Torque(with_inputs), ExternalTorque())
    )
    given = outside.constants({f"{name}.torque": value for name, value in with_inputs.items()})
    rng = np.random.default_rng(1)
    for _ in range(5):
        q, u = rng.uniform(-1.0, 1.0, 3), rng.uniform(-3.0, 3.0, 3)
        found = outside.acceleration(0.0, q, u, given)
        assert np.array_equal(found, inside.acceleration(0.0, q, u, inside.constants()))


def accelerations(made: Mechanism, effects: tuple[Effect, ...], scene: Scene) -> np.ndarray:
    """At random states; what multipliers or round-off of zero sign may do is no difference."""
    program = lower(equations_of(made, effects, inputs=scene.inputs))
    cross_check, rng = Interpreter(program), np.random.default_rng(3)
    constants = cross_check.constants()
    nq, nu = len(program.coordinates), len(program.rates)
    states = [(rng.uniform(-1.0, 1.0, nq), rng.uniform(-3.0, 3.0, nu)) for _ in range(3)]
    return np.array([cross_check.acceleration(0.1, q, u, constants) for q, u in states])


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
@pytest.mark.quick(
    "five_bar", "flaps", "four_bar", "limit_stop", "pendulum", "shutter", "stiff_triple", "vertex"
)
@pytest.mark.ci("[!68]*")
def test_with_zero_torques_every_example_moves_as_without_them_to_the_last_bit(path: Path) -> None:
    made = load(path)
    for scene in (made.scene or Scene(), *made.scenes.values()):
        effects = effects_of(made, scene)
        bare, with_it = (accelerations(made, each, scene) for each in (effects, (ExternalTorque(), *effects)))
        assert np.array_equal(bare, with_it, equal_nan=True)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("n", [2, 6, 8])
@pytest.mark.quick("2-*", "6-space", "8-laminate")
def test_with_zero_torques_chains_are_solved_in_the_same_way(n: int, kind: str) -> None:
    """Also where the two ways to solve cost nearly the same, as eight mixed hinges do without any other load."""
    for seed in range(4):
        made = chain(n, kind, seed=seed)
        bare, with_it = equations_of(made, ()), equations_of(made, (ExternalTorque(),))
        assert with_it.solver == bare.solver
        if seed == 3:
            effects = ((), (ExternalTorque(),))
            alone, beside = (accelerations(made, each, Scene()) for each in effects)
            assert np.array_equal(alone, beside)


@needs_cc
def test_with_zero_torques_runs_are_the_same_to_the_last_bit() -> None:
    made, scene = load(Path(examples).parent / "four_bar.yaml"), None
    scene = made.scene or Scene()
    effects = effects_of(made, scene)
    bare = lamc.compile(made, Scene(effects=effects, angles=scene.angles, rates=scene.rates)).run(0.5)
    also = (*effects, ExternalTorque())
    with_it = lamc.compile(made, Scene(effects=also, angles=scene.angles, rates=scene.rates)).run(0.5)
    assert np.array_equal(bare.t, with_it.t)
    assert np.array_equal(bare.q, with_it.q)
    assert np.array_equal(bare.u, with_it.u)


@needs_cc
def test_a_torque_acts_on_a_hinge_that_closes_a_loop() -> None:
    """Against Newton and Euler, and maximal coordinates, who know nothing of the tree's equations."""
    made = load(Path(examples).parent / "four_bar.yaml")
    sim = lamc.compile(made, Scene(effects=(ExternalTorque(),), angles=(made.scene or Scene()).angles))
    (cut,) = sim.cut_joints
    given = {f"{cut}.torque": 2e-3, f"{sim.joints[0]}.torque": -1e-3}
    n = len(sim.joints)
    q, u = sim.start[:n], sim.start[n:]
    found = sim.acceleration(q, u, parameters=given)
    for cross_check in (NewtonEuler, MaximalCoordinates):
        expected = cross_check(made, with_inputs(made, sim.effects, given), sim.joints).acceleration(q, u)
        # other operations altogether; round-off times the condition of the mass matrix
        assert found == pytest.approx(expected, rel=1e-10, abs=1e-10 * float(np.abs(expected).max()))
    assert np.abs(found).max() > 1.0


@pytest.mark.parametrize("mover", ["base_motion", "free_base"])
def test_a_moving_base_feels_it(mover: str) -> None:
    made, effects = mechanism(), (SAMPLES[mover], ExternalTorque(), Gravity())
    program = lower(equations_of(made, effects))
    given = {"h1.torque": 0.8, "h2.torque": -0.3}
    cross_check = Interpreter(program)
    rng = np.random.default_rng(0)
    q, u = rng.normal(size=len(program.coordinates)), rng.normal(size=len(program.rates))
    found = cross_check.acceleration(0.3, q, u, cross_check.constants(given))
    expected = MovingNewtonEuler(made, with_inputs(made, effects, given), program.joints).acceleration(
        q, u, 0.3
    )
    # other operations altogether; round-off times the condition of the mass matrix
    assert found == pytest.approx(expected, rel=1e-10, abs=1e-10 * float(np.abs(expected).max()))


@needs_cc
def test_three_cross_checks_agree_with_it() -> None:
    assert check(lamc.compile(mechanism(), Scene(effects=(Gravity(), ExternalTorque())))).passed


def test_a_constant_torque_of_the_scene_is_then_the_input() -> None:
    effects = (Torque({"h1": 0.4, "h2": "0.1*sin(t)"}), ExternalTorque())
    found = {p.name: p for p in equations_of(mechanism(), effects).parameters}
    assert found["h1.torque"].is_input
    assert found["h1.torque"].default == 0.4
    assert found["h2.torque"].is_input
    assert found["h2.torque"].default == 0.0  # beside the expression
    alone = {p.name: p.is_input for p in equations_of(mechanism(), effects[:1]).parameters}
    assert alone["h1.torque"] is False
    both = equations_of(mechanism(), (effects[0], ExternalTorque(("h1",)))).parameters
    assert [p.name for p in both if p.is_input] == ["h1.torque"]


def test_what_is_an_input_is_a_part_of_the_digest() -> None:
    def program(*effects: Effect) -> str:
        return lower(equations_of(mechanism(), effects)).digest

    torque = Torque({"h1": 0.4})
    assert program(torque) != program(torque, ExternalTorque(("h1",)))


def test_other_engines_have_an_actuator_for_it() -> None:
    effects = (ExternalTorque(), Torque({"h2": "sin(t)"}))
    hinges = carried(mechanism(), effects, ("a", "b")).hinges
    assert {name: loads.drive for name, loads in hinges.items()} == {"h1": None, "h2": "sin(t)"}
    assert all(loads.outside for loads in hinges.values())
    assert all(loads.has_torque for loads in hinges.values())


def test_it_never_acts_by_itself() -> None:
    assert "external_torque" not in {effect.name for effect in effects_of(mechanism(), Scene())}


@pytest.mark.parametrize(
    ("joints", "words"),
    [
        (("hip",), "no joint is named 'hip'; the joints are h1, h2"),
        (("h1", "h1"), "'h1' twice"),
        ((), "give a list of names"),
        ("h1", "give a list of names"),
        ((3,), "an entry of joints has the name 3"),
    ],
)
def test_joints_that_cannot_be_are_refused(joints: object, words: str) -> None:
    with pytest.raises(DesignError, match=words) as caught:
        equations_of(mechanism(), (ExternalTorque(joints),))  # type: ignore[arg-type]
    assert "\n" not in str(caught.value)
