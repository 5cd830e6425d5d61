"""The energy balance of a run: power and work of every effect, their balance, and that keeping them changes nothing."""

import contextlib
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cache
from typing import ClassVar

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import lamc
from lamc.basics.errors import DesignError, RequestError
from lamc.effects.registry import EFFECTS
from lamc.mechanics.arranging import Arranging
from lamc.mechanics.loads import Loads
from lamc.mechanics.lower import lower
from lamc.records.effect import Effect, conserves
from lamc.reference.interpreter import Interpreter
from lamc.run.simulator import Simulator
from tests.support.closed_mechanisms import closed_mechanism
from tests.support.every_effect import SAMPLES, mechanism
from tests.support.quick import tries

Array = npt.NDArray[np.float64]

# These may bring energy in; no other may.
DRIVEN = (
    "torque",
    "external_torque",
    "linear_motor",
    "servo",
    "cable",
    "pouch",
    "piezo_bender",
    "base_motion",
)
METHODS = ("rk45", "dop853", "rodas5p", "radau5", "auto")
START = {"h1": 0.3, "h2": -0.4}  # rad
PATIENT = settings(
    max_examples=tries(30),
    deadline=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)


@cache
def simulator(name: str) -> Simulator:
    """The sample of one effect on two links in space, with gravity and damped hinges."""
    others = [e for e in (lamc.Gravity(), lamc.HingeDamping()) if e.name != name]
    scene = lamc.Scene(effects=(SAMPLES[name], *others), angles=START, rates={"h1": 0.5, "h2": 1.0})
    return lamc.compile(mechanism(), scene)


def names() -> list[str]:
    return sorted(kind.name for kind in EFFECTS)


@pytest.mark.parametrize("name", names())
@pytest.mark.quick(
    "flexible_links", "free_base", "ground_contact", "hinge_damping", "piezo_bender", "twist_compliance"
)
def test_the_rate_of_the_kinetic_energy_is_the_sum_of_all_powers(name: str) -> None:
    """Along the motion at random states; the rate by central differences of the energy along (1, dy/dt)."""
    sim = simulator(name)
    rng = np.random.default_rng(5)
    for _ in range(5):
        state = sim.start + 0.4 * rng.standard_normal(len(sim.start))
        powers, changes = powers_and_changes(sim, state, t=0.7)
        total = sum(powers.values())
        size = 1.0 + max(abs(v) for v in (*powers.values(), *changes.values()))
        # differences of the fourth order, and round-off over 1e-5 s: the worst of 1500 draws is 1e-9
        assert total == pytest.approx(changes["kinetic"], abs=1e-7 * size)


@pytest.mark.parametrize("name", names())
@pytest.mark.quick(
    "flexible_links", "free_base", "ground_contact", "hinge_damping", "piezo_bender", "twist_compliance"
)
def test_two_cross_checks_tell_the_same_powers(name: str) -> None:
    """The C, and the same program interpreted in Python."""
    sim = simulator(name)
    program = lower(sim.equations, energy_balance=True)
    cross_check = Interpreter(program)
    state = sim.start + 0.3 * np.random.default_rng(2).standard_normal(len(sim.start))
    nq = len(sim.coordinates)
    q, u = state[:nq], state[nq:]
    constants = cross_check.constants()
    theirs = cross_check.powers(0.7, q, u, sim.acceleration(q, u, t=0.7), constants)
    mine = sim.telling.motion({}).powers(np.array([0.7]), state.reshape(1, -1))[0]
    size = max(1.0, float(np.abs(mine).max(initial=0.0)))
    assert mine == pytest.approx(theirs, rel=1e-12, abs=1e-12 * size)  # round-off of sums of some hundred


@pytest.mark.parametrize("name", names())
@PATIENT
@given(seed=st.integers(0, 10**6))
@pytest.mark.quick("cable", "spring", "pouch", "joint_limits")
def test_only_what_is_driven_brings_energy_in(name: str, seed: int) -> None:
    """Power plus the change of what an effect stores: nothing if it is conservative, never positive if passive."""
    sim = simulator(name)
    rng = np.random.default_rng(seed)
    state = sim.start + 0.5 * rng.standard_normal(len(sim.start))
    powers, changes = powers_and_changes(sim, state, t=0.7)
    size = 1.0 + max(abs(v) for v in (*powers.values(), *changes.values()))
    for effect, power in powers.items():
        supplied = power + changes.get(effect, 0.0)
        if effect in keeping(sim):
            assert supplied == pytest.approx(0.0, abs=1e-7 * size)  # differences, as above
        elif effect not in DRIVEN:
            assert supplied <= 1e-7 * size


@pytest.mark.parametrize("name", names())
def test_no_swept_parameter_makes_a_passive_effect_feed_energy(name: str) -> None:
    """With any one of its parameters turned round, an effect takes energy as before, or the run is refused."""
    sim = simulator(name)
    bare = simulator("gravity" if name != "gravity" else "hinge_damping")
    for parameter in sorted(set(sim.parameters) - set(bare.parameters)):
        rotated = {parameter: -sim.parameters[parameter]}
        with contextlib.suppress(RequestError, DesignError):
            energy_balance = sim.run(
                t_end=0.05, rtol=1e-9, parameters=rotated, energy_balance=True, max_steps=5000
            ).energy_balance
            gained = energy_balance.supplied.get(name, np.zeros(1)).max()
            assert name in DRIVEN or gained < 1e-8 * energy_balance.scale, (
                parameter
            )  # at the tolerance of the run


def test_a_motor_of_impossible_data_is_refused_in_sweeps() -> None:
    sim = simulator("linear_motor")
    for field in ("resistance", "torque_constant"):
        for value in (0.0, -1.0):
            with pytest.raises(RequestError, match=rf"'h1\.motor\.{field}' is .* must be above zero"):
                sim.run(t_end=0.1, parameters={f"h1.motor.{field}": value})


@pytest.mark.parametrize("name", names())
def test_energy_balance_balance(name: str) -> None:
    """At a tolerance of 1e-10 to 1e-8 of the energies in play; what conservative effects give they had stored."""
    sim = simulator(name)
    energy_balance = sim.run(t_end=1.5, rtol=1e-10, atol=1e-12, energy_balance=True).energy_balance
    assert energy_balance.balance < 1e-8
    for effect in set(energy_balance.work) & keeping(sim):
        assert np.abs(energy_balance.supplied[effect]).max() < 1e-8 * energy_balance.scale
    for effect in set(energy_balance.work) - set(DRIVEN):
        assert energy_balance.supplied[effect][-1] < 1e-8 * energy_balance.scale


@pytest.mark.parametrize("method", METHODS)
def test_every_method_keeps_energy_balance_that_balance(method: str) -> None:
    """Rows between steps too, in the middle of switches of limits that give way."""
    limits = lamc.JointLimits(stiffness=30.0, damping=0.2)
    scene = lamc.Scene(effects=(lamc.Gravity(), limits, lamc.HingeDamping()), angles=START)
    sim = lamc.compile(mechanism(), scene)
    times = np.linspace(0.1, 2.0, 77)
    energy_balance = sim.run(
        t_end=2.0, rtol=1e-10, atol=1e-12, t_eval=times, integrator=method, energy_balance=True
    ).energy_balance
    assert energy_balance.balance < 1e-8
    assert energy_balance.supplied["joint_limits"][-1] < 0.0


@pytest.mark.parametrize("method", METHODS)
def test_keeping_energy_balance_changes_no_bit_of_the_motion(method: str) -> None:
    joints = tuple(replace(j, stiffness=1e5 * j.stiffness) for j in mechanism().joints)
    stiff = replace(mechanism(), joints=joints)
    limits = lamc.JointLimits(restitution=0.7)
    scene = lamc.Scene(effects=(lamc.HingeStiffness(), lamc.HingeDamping(), limits), rates={"h1": 300.0})
    sim = lamc.compile(stiff, scene)
    arguments = {"t_end": 0.2, "rtol": 1e-6, "atol": 1e-8, "integrator": method}
    with_balance, without = sim.run(**arguments, energy_balance=True), sim.run(**arguments)
    assert with_balance.events == without.events
    assert with_balance.events
    assert np.array_equal(with_balance.t, without.t)
    assert np.array_equal(with_balance.y, without.y)
    assert with_balance.stats.steps == without.stats.steps


def test_a_constant_torque_does_torque_times_angle() -> None:
    scene = lamc.Scene(effects=(lamc.Torque({"h1": 0.02}), lamc.Gravity()), angles=START)
    result = lamc.compile(mechanism(), scene).run(t_end=1.0, rtol=1e-10, energy_balance=True)
    # the integral to the tolerance of the states, some hundred steps
    assert result.work["torque"] == pytest.approx(0.02 * (result.angle("h1") - 0.3), abs=1e-10)


def test_impacts_are_booked() -> None:
    """A restitution of one keeps the kinetic energy, one below takes some; the whole balances."""
    for restitution, takes in ((1.0, False), (0.5, True)):
        effects = (lamc.Gravity(), lamc.JointLimits(restitution=restitution))
        sim = lamc.compile(mechanism(), lamc.Scene(effects=effects, angles=START, rates={"h1": 2.0}))
        result = sim.run(t_end=1.5, rtol=1e-10, atol=1e-12, energy_balance=True)
        assert len(result.events) > 0
        energy_balance = result.energy_balance
        assert energy_balance.balance < 1e-8
        assert (energy_balance.work["impacts"][-1] < -1e-3) == takes
        assert takes or abs(energy_balance.work["impacts"][-1]) < 1e-12 * energy_balance.scale * len(
            result.events
        )


@pytest.mark.parametrize("family", ["planar", "spherical", "bennett"])
@pytest.mark.quick("planar")
def test_energy_balance_of_loops_balance(family: str) -> None:
    """Springs and dampers on hinges that close loops do work as on others; the closure itself does none."""
    closed = closed_mechanism(family, seed=3).mechanism
    effects = (lamc.Gravity(), lamc.HingeStiffness(), lamc.RestAngle(), lamc.HingeDamping())
    sim = lamc.compile(closed, lamc.Scene(effects=effects))
    assert sim.cut_joints
    assert sim.run(t_end=1.0, rtol=1e-10, atol=1e-12, energy_balance=True).energy_balance.balance < 1e-8


@dataclass(frozen=True)
class Fluid:
    """A fluid that moves with the second link and the ground: constant added inertia."""

    name: ClassVar[str] = "fluid"
    summary: ClassVar[str] = "Fluid around the second link"

    def arrange(self, arranging: Arranging) -> None:
        arranging.inverse_dynamics()

    def contribute(self, loads: Loads) -> None:
        matrix = np.diag([0.1, 0.4, 0.3, 0.02, 0.01, 0.03])
        matrix[0, 4] = matrix[4, 0] = 0.01
        for body, point in (("b", (1.6, 0.0, 0.1)), ("ground", (0.0, 0.1, 0.0))):
            loads.added_inertia(body, point, matrix.tolist())


@pytest.mark.parametrize("base", [None, lamc.FreeBase(spin=(0.3, 0.2, 0.1))])
@pytest.mark.quick("None")
def test_a_fluid_gives_back_what_it_took(base: Effect | None) -> None:
    """Its kinetic energy is what it stores, so that its work is minus the change of that."""
    effects: tuple[Effect, ...] = (lamc.Gravity(), Fluid(), *((base,) if base else ()))
    sim = lamc.compile(mechanism(), lamc.Scene(effects=effects, angles=START))
    energy_balance = sim.run(t_end=1.0, rtol=1e-10, atol=1e-12, energy_balance=True).energy_balance
    assert energy_balance.balance < 1e-8
    assert np.abs(energy_balance.work["fluid"]).max() > 1e-3
    assert np.abs(energy_balance.supplied["fluid"]).max() < 1e-8 * energy_balance.scale


def test_a_fluid_gives_back_what_it_took_at_impacts_too() -> None:
    """An elastic impact keeps the energy of links and fluid together, and moves some from one to the other."""
    effects = (lamc.Gravity(), Fluid(), lamc.JointLimits(restitution=1.0))
    sim = lamc.compile(mechanism(), lamc.Scene(effects=effects, angles=START, rates={"h1": 3.0}))
    result = sim.run(t_end=1.0, rtol=1e-10, atol=1e-12, energy_balance=True)
    energy_balance = result.energy_balance
    assert len(result.events) > 1
    assert energy_balance.balance < 1e-8
    assert np.abs(energy_balance.supplied["fluid"]).max() < 1e-8 * energy_balance.scale
    assert abs(energy_balance.work["impacts"][-1]) < 1e-12 * energy_balance.scale * len(result.events)


def test_a_run_that_ends_early_has_energy_balance_up_to_there() -> None:
    sim = simulator("gravity")
    result = sim.run(t_end=5.0, max_steps=20, t_eval=np.linspace(0.0, 5.0, 11), energy_balance=True)
    assert not result.success
    assert result.work["gravity"].shape == result.t.shape
    assert result.energy_balance.balance < 1e-6  # at the default tolerance of 1e-9


def test_powers_can_be_had_of_any_result_and_are_no_part_of_the_usual_module() -> None:
    sim = simulator("torque")
    result = sim.run(t_end=0.5)
    assert "power" not in sim.program.functions
    assert result.motion.model.powers == ()
    assert set(result.powers) == {"gravity", "hinge_damping", "torque"}
    own = sim.run(t_end=0.5, energy_balance=True)
    for name, values in result.powers.items():
        assert np.array_equal(values, own.powers[name])
    damping = mechanism().joint("h1").damping
    expected = -damping * (result.u**2).sum(axis=1)  # both hinges have the same
    assert result.powers["hinge_damping"] == pytest.approx(expected, rel=1e-12, abs=1e-15)  # round-off


def test_an_energy_balance_is_refused_where_there_is_none() -> None:
    sim = simulator("gravity")
    with pytest.raises(RequestError, match="energy_balance=True"):
        _ = sim.run(t_end=0.1).work
    with pytest.raises(RequestError, match="energy_balance=True"):
        _ = sim.run(t_end=0.1).energy_balance
    with pytest.raises(RequestError, match=r"scipy:RK45.*keeps no energy balance"):
        sim.run(t_end=0.1, integrator="scipy:RK45", energy_balance=True)
    with pytest.raises(RequestError, match="energy_balance is 'yes'"):
        sim.run(t_end=0.1, energy_balance="yes")  # type: ignore[arg-type]


def keeping(sim: Simulator) -> set[str]:
    """Names of the effects that say that they keep the energy."""
    return {effect.name for effect in sim.effects if conserves(effect, sim._model.energies)}


def powers_and_changes(
    sim: Simulator, state: Array, t: float
) -> tuple[Mapping[str, float], Mapping[str, float]]:
    """Power of each effect, W, and rates of the energies by name, W, at one state."""
    telling = sim.telling.motion({})
    rows, times = state.reshape(1, -1), np.array([t])
    powers = dict(zip(telling.model.powers, telling.powers(times, rows)[0].tolist(), strict=True))
    ahead = telling.rhs(t, state)
    # s. Energies are quadratic in rates, which the formula holds exactly; angles move by 1e-5 at most. A shorter step
    # loses digits: a twist drawn at random stores a million joules.
    step = 1e-5 / max(1.0, float(np.abs(ahead).max()) / 1e7)
    places = step * np.array([-2.0, -1.0, 1.0, 2.0])
    energies = telling.energies(t + places, state + places[:, None] * ahead)
    rates = np.array([1.0, -8.0, 8.0, -1.0]) @ energies / (12.0 * step)
    changes = dict(zip(telling.model.energies, rates.tolist(), strict=True))
    return powers, changes
