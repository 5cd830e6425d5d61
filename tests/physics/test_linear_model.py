"""Linear models against central differences, closed forms and scipy's integrators."""

from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import least_squares

import lamc
from lamc import FreeBase, Gravity, HingeDamping, HingeStiffness, Input, OutputPoint, RestAngle, Scene, Torque
from lamc.commands.examples import mechanism_of_example
from lamc.examples import find
from tests.support.ctools import needs_cc
from tests.support.engines import InMujoco, mujoco
from tests.support.floating import with_base
from tests.support.mechanisms import chain, random_tree, unit_plate_pendulum

pytestmark = needs_cc

BETWEEN = 1e-7  # of the largest entry: what central differences of 1e-4 rad, extrapolated once, are good for
SAGGING = (Gravity((0.3, -0.7, -9.81)), HingeStiffness(), HingeDamping(), RestAngle())


def of_joints(sim: lamc.Simulator, h: float, q: np.ndarray) -> np.ndarray:
    """The lower half of A of a tree, by central differences of width h."""
    n = len(q)
    found = np.zeros((n, 2 * n))
    for k in range(n):
        step = np.zeros(n)
        step[k] = h
        still = np.zeros(n)
        found[:, k] = (sim.acceleration(q + step, still) - sim.acceleration(q - step, still)) / (2.0 * h)
        found[:, n + k] = (sim.acceleration(q, step) - sim.acceleration(q, -step)) / (2.0 * h)
    return found


@pytest.mark.quick("4")
@pytest.mark.parametrize("count", [4, 14])  # with exact derivatives, and with differences
def test_a_tree_is_linearised_as_central_differences_say(count: int) -> None:
    mechanism = random_tree(count, seed=count, kind="space")
    sim = lamc.compile(mechanism, Scene(effects=SAGGING))
    point = sim.equilibrium(stable=True)
    model = sim.linearise(point)
    assert model.states == (*sim.joints, *(f"{name}.rate" for name in sim.joints))
    coarse, fine = (of_joints(sim, h, point.q) for h in (2e-4, 1e-4))
    expected = (4.0 * fine - coarse) / 3.0
    assert model.A[count:] == pytest.approx(expected, abs=BETWEEN * np.abs(expected).max())
    assert np.array_equal(model.A[:count], np.eye(2 * count)[count:])


def closed(sim: lamc.Simulator, q: np.ndarray, held: int, value: float) -> np.ndarray:
    """The closed position next to q with one joint at a value, by scipy's least squares."""

    def open_by(x: np.ndarray) -> np.ndarray:
        return np.append(sim.closure(x)[0], x[held] - value)

    return np.asarray(least_squares(open_by, q, xtol=1e-15, ftol=1e-15, gtol=1e-15).x)


@pytest.mark.parametrize("name", ["four_bar", "vertex", "sarrus", "six_bar", "miura:2x2"])
def test_a_loop_is_linearised_as_differences_along_the_closed_positions_say(name: str) -> None:
    sim = lamc.compile(mechanism_of_example(find(name)))
    point = sim.equilibrium()
    model = sim.linearise(point)
    (joint, rate) = model.states
    k, still = sim.joints.index(joint), np.zeros(len(sim.joints))
    slopes = []
    for h in (2e-3, 1e-3):
        sides = [closed(sim, point.q, k, point.q[k] + s) for s in (h, -h)]
        ahead, behind = (sim.acceleration(q, still)[k] for q in sides)
        slopes.append((ahead - behind) / (2.0 * h))
    assert model.A[1, 0] == pytest.approx((4.0 * slopes[1] - slopes[0]) / 3.0, rel=BETWEEN)
    tangent = np.linalg.svd(sim.closure(point.q)[1])[2][-1]
    damped = sim.acceleration(point.q, 1e-4 * tangent) - sim.acceleration(point.q, -1e-4 * tangent)
    assert model.A[1, 1] == pytest.approx(damped[k] / (2e-4 * tangent[k]), rel=BETWEEN, abs=1e-9)
    assert rate == f"{joint}.rate"


def test_a_driven_bar_has_the_transfer_function_of_its_equation() -> None:
    """I q'' = -k q - c q' + 2 w, and a tip that is r from the pin."""
    body = lamc.Body("bar", 2.0, (0.3, 0.0, 0.0), np.diag([1e-3, 1e-2, 1e-2]))
    pin = lamc.Joint("pin", "wall", "bar", axis=(0.0, 0.0, 1.0), stiffness=5.0, damping=0.4)
    scene = Scene(
        effects=(HingeStiffness(), HingeDamping(), Torque({"pin": "2*w"})),
        inputs={"w": Input(unit="N*m")},
        outputs=("pin", OutputPoint("tip", "bar", (0.5, 0.0, 0.0))),
    )
    sim = lamc.compile(lamc.Mechanism((lamc.Body("wall", fixed=True), body), (pin,)), scene)
    point = sim.equilibrium()
    inertia = 1e-2 + 2.0 * 0.3**2
    model = sim.linearise(point)
    assert model.inputs == ("w",)
    assert model.input_units == ("N·m",)
    assert model.outputs == ("pin", "tip.x", "tip.y", "tip.z")
    assert model.output_units == ("rad", "m", "m", "m")
    assert np.array([[0.0, 1.0], [-5.0 / inertia, -0.4 / inertia]]) == pytest.approx(model.A, rel=1e-13)
    assert pytest.approx(np.array([[0.0], [2.0 / inertia]]), rel=1e-12) == model.B
    assert pytest.approx(np.array([[1, 0], [0, 0], [0.5, 0], [0, 0]]), abs=1e-12) == model.C
    assert not np.any(model.D)
    assert model.offset == pytest.approx([0.0, 0.5, 0.0, 0.0], abs=1e-12)
    one = sim.linearise(point, outputs=["pin"])
    system = one.state_space()
    response = system.C @ np.linalg.solve(3.0j * np.eye(2) - system.A, system.B) + system.D
    assert response[0, 0] == pytest.approx(2.0 / (5.0 - inertia * 9.0 + 0.4j * 3.0), rel=1e-12)
    more = sim.linearise(point, inputs=["pin.stiffness"], outputs=["pin.rate", "energy", "bar.y"])
    assert (
        pytest.approx(np.zeros((2, 1)), abs=1e-12) == more.B
    )  # a stiffness does nothing where it is not strained
    assert pytest.approx(np.array([[0, 1], [0, 0], [0.3, 0]]), abs=1e-12) == more.C


def test_a_parameter_moves_the_equilibrium_as_a_and_b_say() -> None:
    """dq/dp = -A21⁻¹ B, against equilibria at other values."""
    mechanism = random_tree(4, seed=8, kind="space")
    sim = lamc.compile(mechanism, Scene(effects=SAGGING))
    point = sim.equilibrium(stable=True)
    joint = next(j.name for j in mechanism.joints if j.stiffness)
    name = f"{joint}.stiffness"
    model = sim.linearise(point, inputs=[name])
    moved = [
        sim.equilibrium(point, parameters={name: sim.parameters[name] * (1.0 + s)}).q for s in (1e-4, -1e-4)
    ]
    expected = (moved[0] - moved[1]) / (2e-4 * sim.parameters[name])
    found = -np.linalg.solve(model.A[4:, :4], model.B[4:, 0])
    assert found == pytest.approx(expected, rel=1e-6)  # the square of the step, 1e-8, times curvatures


def test_small_motions_of_a_loop_are_those_of_its_linear_model() -> None:
    """Of amplitudes a and a/2, differences from the exponential of A fall as a²."""
    sim = lamc.compile(mechanism_of_example(find("four_bar")))
    point = sim.equilibrium()
    model = sim.linearise(point, outputs=["arm", "link", "arm_shelf"])
    times = np.linspace(0.0, 0.3, 31)
    values, vectors = np.linalg.eig(model.A)
    errors = []
    for amplitude in (2e-2, 1e-2):
        start = {"arm": point.angles["arm"] + amplitude}
        near = lamc.compile(sim.mechanism, lamc.Scene(angles=start, effects=sim.effects))
        run = near.run(0.3, t_eval=times, rtol=1e-12, atol=1e-14)
        first = np.array([amplitude, 0.0])
        states = [(vectors @ (np.exp(values * t) * np.linalg.solve(vectors, first))).real for t in times]
        told = model.offset + np.array(states) @ model.C.T
        there = np.array([run.angle(name) for name in model.outputs]).T
        errors.append(float(np.abs(told - there).max()))
    assert errors[1] < 1e-4
    assert 3.5 < errors[0] / errors[1] < 4.5


def test_a_free_body_on_springs_has_translations_and_turns() -> None:
    """A body that springs hold to the world through a fixed link: states have names for what quaternions turn."""
    inertia = np.diag([2e-3, 3e-3, 4e-3])
    mechanism = with_base(chain(1, seed=2), 0.7, (0.1, 0.0, 0.0), inertia)
    sim = lamc.compile(mechanism, Scene(effects=(FreeBase(), HingeStiffness(), HingeDamping())))
    point = sim.equilibrium()
    assert point.kind == "neutral"
    assert "6 of 7" in point.reason
    model = sim.linearise(point)
    assert model.states[1:7] == ("base.x", "base.y", "base.z", "base.rx", "base.ry", "base.rz")
    assert model.states[8:] == ("base.vx", "base.vy", "base.vz", "base.wx", "base.wy", "base.wz")
    assert model.state_units[4:7] == ("rad", "rad", "rad")
    assert model.A[7:, 1:7] == pytest.approx(np.zeros((7, 6)), abs=1e-9 * np.abs(model.A).max())


def test_independent_coordinates_may_be_named() -> None:
    sim = lamc.compile(mechanism_of_example(find("four_bar")))
    point = sim.equilibrium()
    usual, other = sim.linearise(point), sim.linearise(point, independent=["link_shelf"])
    assert other.states == ("link_shelf", "link_shelf.rate")
    assert np.linalg.eigvals(other.A) == pytest.approx(np.linalg.eigvals(usual.A), rel=1e-10)
    with pytest.raises(lamc.RequestError, match="must name 1 different"):
        sim.linearise(point, independent=["arm", "link"])


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ({"inputs": ["h0.stifness"]}, "h0.stiffness"),
        ({"inputs": "h0.stiffness"}, "must be a list"),
        ({"outputs": ["h9"]}, "outputs has 'h9'"),
        ({"independent": ["h9", "h1", "h2"]}, "independent has 'h9'"),
        ({"independent": 3}, "independent is 3"),
    ],
)
def test_names_that_are_not_there_are_refused(arguments: dict[str, object], said: str) -> None:
    mechanism, scene = unit_plate_pendulum()
    sim = lamc.compile(mechanism, scene)
    point = sim.equilibrium()
    with pytest.raises(lamc.RequestError, match=said):
        sim.linearise(point, **arguments)  # type: ignore[arg-type]


def test_only_equilibria_of_the_same_simulator_are_linearised() -> None:
    mechanism, scene = unit_plate_pendulum()
    sim = lamc.compile(mechanism, scene)
    with pytest.raises(lamc.RequestError, match="must be an equilibrium"):
        sim.linearise({"h0": 0.1})  # type: ignore[arg-type]
    other = lamc.compile(mechanism, Scene(effects=(HingeStiffness(),)))
    with pytest.raises(lamc.RequestError, match="another simulator"):
        sim.linearise(other.equilibrium())


@pytest.mark.skipif(mujoco is None, reason="MuJoCo is not installed: pip install lamc[bench]")
def test_mujoco_has_the_same_linear_model_of_a_tree(tmp_path: Path) -> None:
    """mjd_transitionFD differentiates a step of length h. One of Euler's with explicit damping has the rates u + h u',
    so that their part of (A_d - 1)/h is that of A, whatever the step."""
    mechanism = random_tree(4, seed=5, kind="space")
    scene = Scene(effects=(Gravity((0.0, 0.0, -9.81)), HingeStiffness(), HingeDamping(), RestAngle()))
    sim = lamc.compile(mechanism, scene)
    point = sim.equilibrium(stable=True)
    model = sim.linearise(point)
    engine = InMujoco(mechanism, scene, tmp_path)
    engine.model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_EULERDAMP)
    engine.model.opt.integrator = int(mujoco.mjtIntegrator.mjINT_EULER)
    places, n, h = [engine.place(name)[1] for name in sim.joints], len(sim.joints), 0.01
    engine.model.opt.timestep = h
    engine.put(sim, point.q, np.zeros(n))
    mujoco.mj_forward(engine.model, engine.data)
    found = np.zeros((2 * engine.model.nv, 2 * engine.model.nv))
    mujoco.mjd_transitionFD(engine.model, engine.data, 1e-5, 1, found, None, None, None)
    rows = [engine.model.nv + k for k in places]
    expected = (found[np.ix_(rows, [*places, *rows])] - np.hstack([np.zeros((n, n)), np.eye(n)])) / h
    assert model.A[n:] == pytest.approx(expected, abs=BETWEEN * np.abs(expected).max())


def test_python_control_takes_it_with_its_names() -> None:
    control = pytest.importorskip("control")
    mechanism, scene = unit_plate_pendulum()
    sim = lamc.compile(mechanism, scene)
    model = sim.linearise(sim.equilibrium(), inputs=["h0.stiffness"])
    system = model.to_control()
    assert isinstance(system, control.StateSpace)
    assert system.state_labels == [name.replace(".", "_") for name in model.states]
    assert np.array_equal(system.A, model.A)
