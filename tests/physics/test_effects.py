"""Each effect alone against a closed form, and the account of which effects act."""

import math
import pickle
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import pytest
import sympy
from scipy.special import ellipk

import lamc
from lamc.basics.errors import DesignError, ExpressionError
from lamc.effects import Effect, Gravity, HingeDamping, HingeStiffness, RestAngle, Torque
from lamc.effects.registry import EFFECTS, by_name, choose
from lamc.mechanics.loads import Loads
from lamc.records.mechanism import Body, Joint, Mechanism
from lamc.records.scene import Scene
from tests.support.ctools import needs_cc
from tests.support.every_effect import SAMPLES
from tests.support.mechanisms import chain

MASS, ARM, MOMENT, G = 0.8, 0.35, 0.02, 9.81  # kg, m, kg·m² about the centre of mass, m/s²
ABOUT_HINGE = MOMENT + MASS * ARM**2
K, C, REST = 1.9, 0.06, 0.7  # N·m/rad, N·m·s/rad, rad


def pendulum(**joint: float) -> Mechanism:
    """Hangs straight down as drawn; turns about y."""
    rod = Body("rod", MASS, np.array([0.0, 0.0, -ARM]), np.diag([MOMENT, MOMENT, 1e-4]))
    hip = Joint("hip", "ceiling", "rod", axis=np.array([0.0, 1.0, 0.0]), **joint)  # type: ignore[arg-type]
    return Mechanism((Body("ceiling", fixed=True), rod), (hip,), name="rod")


def simulator(
    mechanism: Mechanism, *effects: Effect, angle: float = 0.0, rate: float = 0.0
) -> lamc.Simulator:
    return lamc.compile(mechanism, Scene(effects=effects, angles={"hip": angle}, rates={"hip": rate}))


pytestmark = needs_cc


# ---- closed forms ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize("amplitude", [0.1, 1.0, 2.5, 3.1])
def test_gravity_alone_gives_the_period_of_the_elliptic_integral(amplitude: float) -> None:
    sim = simulator(pendulum(), Gravity((0.0, 0.0, -G)), angle=amplitude)
    period = 4 * math.sqrt(ABOUT_HINGE / (MASS * G * ARM)) * ellipk(math.sin(amplitude / 2) ** 2)
    result = sim.run(t_end=2 * period, t_eval=[period / 4, period / 2, 2 * period], rtol=1e-12, atol=1e-13)
    # rtol 1e-12 over some hundred steps; near the top errors grow by a factor of some hundreds
    assert result.angle("hip") == pytest.approx([0.0, -amplitude, amplitude], abs=3e-8)
    assert result.energy == pytest.approx(result.energy[0], abs=1e-10)
    assert result.energies["gravity"][2] == pytest.approx(-MASS * G * ARM * math.cos(amplitude), abs=1e-8)


def test_gravity_pulls_along_its_vector() -> None:
    sideways = simulator(pendulum(), Gravity((3.0, 5.0, 0.0)))
    # F = m g along +x on an arm along -z: moment about y is (r × F)_y = z F_x
    assert sideways.acceleration([0.0], [0.0])[0] == pytest.approx(-ARM * MASS * 3.0 / ABOUT_HINGE, rel=1e-14)
    assert simulator(pendulum(), Gravity((0.0, 5.0, 0.0))).acceleration([0.4], [0.0])[0] == 0.0


def test_stiffness_alone_is_a_harmonic_oscillator() -> None:
    sim = simulator(pendulum(stiffness=K), HingeStiffness(), angle=0.4, rate=-1.0)
    omega = math.sqrt(K / ABOUT_HINGE)
    t = np.linspace(0.0, 5.0, 21)
    result = sim.run(t_end=5.0, t_eval=t, rtol=1e-12, atol=1e-13)
    expected = 0.4 * np.cos(omega * t) - 1.0 / omega * np.sin(omega * t)
    assert result.angle("hip") == pytest.approx(expected, abs=1e-9)  # rtol times some hundred steps
    assert result.energies["hinge_stiffness"] == pytest.approx(0.5 * K * expected**2, abs=1e-9)


def test_stiffness_and_damping_are_a_damped_oscillator() -> None:
    sim = simulator(pendulum(stiffness=K, damping=C), HingeStiffness(), HingeDamping(), angle=0.6)
    decay, natural = C / (2 * ABOUT_HINGE), math.sqrt(K / ABOUT_HINGE)
    omega = math.sqrt(natural**2 - decay**2)
    t = np.linspace(0.0, 5.0, 21)
    expected = 0.6 * np.exp(-decay * t) * (np.cos(omega * t) + decay / omega * np.sin(omega * t))
    found = sim.run(t_end=5.0, t_eval=t, rtol=1e-12, atol=1e-13).angle("hip")
    assert found == pytest.approx(expected, abs=1e-9)


def test_damping_alone_stops_the_rod_after_the_angle_of_its_momentum() -> None:
    sim = simulator(pendulum(damping=0.5), HingeDamping(), rate=2.0)
    result = sim.run(t_end=10.0, t_eval=[1.0, 10.0], rtol=1e-12, atol=1e-14)
    assert result.rate("hip")[0] == pytest.approx(2.0 * math.exp(-0.5 / ABOUT_HINGE), rel=1e-8)
    assert result.angle("hip")[1] == pytest.approx(2.0 * ABOUT_HINGE / 0.5, rel=1e-9)  # ∫ c u dt = I u0
    assert set(result.energies) == {"kinetic"}


def test_a_rest_angle_is_where_the_hinge_rests() -> None:
    mechanism = pendulum(stiffness=K, damping=1.5, rest_angle=REST)
    effects = (HingeStiffness(), RestAngle(), HingeDamping())
    assert simulator(mechanism, *effects).acceleration([REST], [0.0])[0] == pytest.approx(0.0, abs=1e-14)
    result = simulator(mechanism, *effects).run(t_end=60.0, t_eval=[0.0, 60.0])
    assert result.angle("hip")[1] == pytest.approx(REST, abs=1e-7)  # the integrator's tolerance at rest
    assert result.energies["hinge_stiffness"] + result.energies["rest_angle"] == pytest.approx(
        [0.5 * K * REST**2, 0.0], abs=1e-12
    )


def test_without_the_rest_angle_the_drawn_one_is_the_rest() -> None:
    mechanism = pendulum(stiffness=K, rest_angle=REST)
    assert simulator(mechanism, HingeStiffness()).acceleration([0.0], [0.0])[0] == 0.0


def test_gravity_and_spring_balance_where_statics_says() -> None:
    mechanism = pendulum(stiffness=K, damping=1.0, rest_angle=REST)
    sim = simulator(mechanism, Gravity((0, 0, -G)), HingeStiffness(), RestAngle(), HingeDamping())
    angle = float(sim.run(t_end=40.0, t_eval=[40.0]).angle("hip")[0])
    assert K * (REST - angle) == pytest.approx(MASS * G * ARM * math.sin(angle), abs=1e-6)
    assert angle > 0.1


def test_a_constant_torque_accelerates_evenly_and_is_a_parameter() -> None:
    sim = simulator(pendulum(), Torque({"hip": 0.3}))
    result = sim.run(t_end=2.0, t_eval=[2.0])
    assert result.angle("hip")[0] == pytest.approx(0.5 * 0.3 / ABOUT_HINGE * 4.0, rel=1e-12)
    assert sim.parameters["hip.torque"] == 0.3
    assert sim.parameter_units["hip.torque"] == "N·m"
    twice = sim.run(t_end=2.0, t_eval=[2.0], parameters={"hip.torque": 0.6})
    assert twice.angle("hip")[0] == pytest.approx(2 * result.angle("hip")[0], rel=1e-12)


def test_a_torque_given_by_an_expression_drives_the_oscillator_of_the_textbook() -> None:
    # I q̈ = τ sin(w t) - k q - c q̇ by the expression itself: its forced vibration
    w, tau = 7.0, 0.4
    text = f"{tau}*sin({w}*t) - {K}*angle - {C}*rate"
    stiff, drag = K - ABOUT_HINGE * w * w, C * w
    a, b = tau * stiff / (stiff**2 + drag**2), -tau * drag / (stiff**2 + drag**2)  # a sin + b cos
    sim = simulator(pendulum(), Torque({"hip": text}), angle=b, rate=a * w)
    t = np.linspace(0.0, 6.0, 25)
    result = sim.run(t_end=6.0, t_eval=t, rtol=1e-12, atol=1e-13)
    assert result.angle("hip") == pytest.approx(a * np.sin(w * t) + b * np.cos(w * t), abs=1e-9)


def test_a_torque_between_two_bodies_acts_on_both() -> None:
    """Free of gravity, two equal flaps on a common axis pushed apart by the hinge between them turn oppositely."""
    tensor = np.diag([0.15, 0.15, 0.3])
    bodies = (
        Body("world", fixed=True),
        Body("a", 1.0, np.zeros(3), tensor),
        Body("b", 1.0, np.zeros(3), tensor),
    )
    joints = (Joint("base", "world", "a"), Joint("between", "a", "b"))
    sim = lamc.compile(Mechanism(bodies, joints), Scene(effects=(Torque({"between": 0.6}),)))
    found = dict(zip(sim.joints, sim.acceleration([0.3, -0.8], [0.0, 0.0]), strict=True))
    assert found["base"] == pytest.approx(-0.6 / 0.3, rel=1e-14)
    assert found["between"] == pytest.approx(2 * 0.6 / 0.3, rel=1e-14)


def test_an_inertia_that_no_body_can_have_is_refused() -> None:
    """A larger moment than the other two together would mean negative mass somewhere."""
    Body("plate", 1.0, np.zeros(3), np.diag([0.1, 0.2, 0.3]))
    with pytest.raises(DesignError, match=r"body 'odd' has a principal moment of 0\.31 kg"):
        Body("odd", 1.0, np.zeros(3), np.diag([0.1, 0.31, 0.2]))


def test_parameters_change_without_compiling() -> None:
    sim = simulator(pendulum(stiffness=K), Gravity((0, 0, -G)), HingeStiffness())
    found = sim.acceleration([0.3], [0.0], 0.0, {"hip.stiffness": 5.0, "gravity.z": -1.62})[0]
    expected = -(5.0 * 0.3 + MASS * 1.62 * ARM * math.sin(0.3)) / ABOUT_HINGE
    assert found == pytest.approx(expected, rel=1e-14)
    heavier = sim.acceleration([0.3], [0.0], 0.0, {"rod.mass": 2 * MASS})[0]
    inertia = MOMENT + 2 * MASS * ARM**2
    assert heavier == pytest.approx(-(K * 0.3 + 2 * MASS * G * ARM * math.sin(0.3)) / inertia, rel=1e-14)


# ---- the account ----------------------------------------------------------------------------------------------


def account(mechanism: Mechanism, scene: Scene) -> dict[str, tuple[bool, str]]:
    return {c.name: (c.effect is not None, c.reason) for c in choose(mechanism, scene)}


def test_a_design_calls_for_what_is_not_zero() -> None:
    bare = account(pendulum(), Scene())
    assert {name for name, (acts, _) in bare.items() if acts} == {"gravity"}
    of_its_own = {  # what a design may have, and this one has not
        "gravity": "-9.81 m/s² along z unless a scene says otherwise",
        "hinge_damping": "no hinge is damped",
        "hinge_stiffness": "no hinge has a stiffness",
        "joint_limits": "no joint has limits narrower than ±180°",
        "rest_angle": "every hinge rests as drawn",
    }
    assert {name: why for name, (_, why) in bare.items()} == {
        kind.name: of_its_own.get(kind.name, kind.absent) for kind in EFFECTS
    }
    full = account(pendulum(stiffness=K, damping=C, rest_angle=REST), Scene())
    assert [name for name, (acts, _) in full.items() if acts] == [
        "gravity",
        "hinge_damping",
        "hinge_stiffness",
        "rest_angle",
    ]
    assert full["hinge_stiffness"][1] == "1 hinge has a stiffness"
    # a rest angle without a spring does nothing
    assert not account(pendulum(rest_angle=REST), Scene())["rest_angle"][0]


def test_effects_of_lamcs_own_are_public() -> None:
    for kind in EFFECTS:
        assert getattr(lamc, kind.__name__) is kind
        assert kind.__name__ in lamc.__all__


def test_a_scene_calls_for_exactly_what_it_lists() -> None:
    mechanism = pendulum(stiffness=K, damping=C)
    assert not any(acts for acts, _ in account(mechanism, Scene(effects=())).values())
    listed = account(mechanism, Scene(effects=(Torque({"hip": 1.0}), HingeDamping())))
    assert {name for name, (acts, _) in listed.items() if acts} == {"torque", "hinge_damping"}
    assert listed["gravity"] == (False, "the scene does not call for it")
    assert list(listed) == sorted(listed)


def test_an_effect_acts_once() -> None:
    with pytest.raises(DesignError, match="the scene calls for Gravity twice; once is all it can act"):
        Scene(effects=(Gravity(), HingeDamping(), Gravity((0, 0, -1.62))))


def test_effects_have_names_of_their_own_and_say_what_they_are() -> None:
    assert len(by_name()) == len(EFFECTS)
    for name, kind in by_name().items():
        assert name == kind.name
        assert name.isidentifier()
        assert name == name.lower()
        assert kind.summary
        assert isinstance(SAMPLES[name], kind)
        assert isinstance(SAMPLES[name], Effect)


@pytest.mark.parametrize(
    ("make", "error", "words"),
    [
        (lambda: Gravity((0, 0)), DesignError, "must hold 3 numbers"),  # type: ignore[arg-type]
        (lambda: Gravity((0, 0, math.nan)), DesignError, "finite"),
        (lambda: Gravity("down"), DesignError, "gravity.acceleration: acceleration is 'down'"),  # type: ignore[arg-type]
        (lambda: Torque({"hip": math.inf}), DesignError, "torque of 'hip' is inf"),
        (lambda: Torque({"hip": None}), DesignError, "None is not a torque of 'hip'; write a number in N.m"),  # type: ignore[dict-item]
        (lambda: Torque(0.3), DesignError, "give a map from names to numbers"),  # type: ignore[arg-type]
        (lambda: Torque({"hip": "t.real"}), ExpressionError, "joint 'hip'.*column 2"),
        (
            lambda: Gravity.from_data("down", "a:1"),
            DesignError,
            "a:1: acceleration is 'down'; give a list of 3 numbers",
        ),
        (lambda: Torque.from_data([1], "a:1"), DesignError, "a:1: torques is"),
        (lambda: HingeStiffness.from_data(3, "a:1"), DesignError, "a:1: hinge_stiffness takes no value"),
        (lambda: HingeDamping.from_data([0], "a:1"), DesignError, "takes no value"),
        (lambda: RestAngle.from_data("x", "a:1"), DesignError, "takes no value"),
    ],
)
def test_effects_that_cannot_be_are_refused(make: object, error: type[Exception], words: str) -> None:
    with pytest.raises(error, match=words):
        make()  # type: ignore[operator]


def test_a_torque_on_a_joint_that_is_not_there_is_refused_by_name() -> None:
    for torque in (0.1, "t"):
        with pytest.raises(DesignError, match="no joint is named 'knee'; the joints are h0, h1"):
            lamc.compile(chain(2), Scene(effects=(Torque({"knee": torque}),)))


def test_scene_files_give_effects_by_name() -> None:
    assert Gravity.from_data(None, "") == Gravity.from_data(True, "") == Gravity()
    assert Gravity.from_data([0, 0, -1.62], "") == Gravity((0.0, 0.0, -1.62))
    assert Torque.from_data({"hip": 1, "knee": "t"}, "") == Torque({"hip": 1.0, "knee": "t"})
    assert HingeStiffness.from_data(True, "") == HingeStiffness()


@dataclass(frozen=True)
class DistanceSpring:
    """A user's own effect: a spring from a point of the last body to a point of the world, in sympy."""

    name: ClassVar[str] = "distance_spring"
    summary: ClassVar[str] = "Spring between two points"

    def contribute(self, loads: Loads) -> None:
        k = loads.parameter("spring.stiffness", 3.0, "N/m", "stiffness")
        tip = loads.position("body1", (2.0, 0.0, 0.0))
        stretch = [sympy.sympify(x) - end for x, end in zip(tip, (1.0, 0.5, -1.0), strict=True)]
        length = sympy.sqrt(sum(d**2 for d in stretch))
        loads.stored_energy(k * (length - 0.2) ** 2 / 2)
        loads.force("body1", (2.0, 0.0, 0.0), [-k * (length - 0.2) * d / length for d in stretch])


def test_a_force_in_sympy_may_use_parameters_positions_and_functions() -> None:
    """A conservative force keeps the energy that it records: sign, factor and point are right, or it drifts."""
    mechanism = chain(2, "space", seed=3)
    sim = lamc.compile(mechanism, lamc.Scene(effects=(DistanceSpring(),), rates={"h0": 1.0, "h1": -2.0}))
    assert sim.parameters["spring.stiffness"] == 3.0
    for parameters in ({}, {"spring.stiffness": 40.0}):
        result = sim.run(t_end=2.0, rtol=1e-11, atol=1e-13, parameters=parameters)
        drift = np.abs(result.energy - result.energy[0]).max()
        assert drift < 1e-8 * np.abs(result.energy).max()  # rtol times some hundred steps


@dataclass(frozen=True)
class Odd:
    """An effect that hands over what it was made with."""

    value: object
    name: ClassVar[str] = "odd"
    summary: ClassVar[str] = "Odd"

    def contribute(self, loads: Loads) -> None:
        loads.hinge_torque("h0", self.value)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    "value", [float("nan"), float("inf"), sympy.nan, "text", sympy.cot(sympy.Symbol("q_h0"))]
)
def test_what_is_no_load_is_refused_in_one_line(value: object) -> None:
    with pytest.raises(lamc.LamcError) as caught:
        lamc.compile(chain(1), lamc.Scene(effects=(Odd(value),)))
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("value", [np.float32(0.5), np.int64(2), 3, 0.25])
def test_numbers_of_every_kind_are_loads(value: object) -> None:
    sim = lamc.compile(chain(1), lamc.Scene(effects=(Odd(value),)))
    still = lamc.compile(chain(1), lamc.Scene(effects=()))
    assert sim.acceleration([0.0], [0.0])[0] != still.acceleration([0.0], [0.0])[0]


def test_a_parameter_name_that_is_taken_is_refused() -> None:
    @dataclass(frozen=True)
    class Thief:
        name: ClassVar[str] = "thief"
        summary: ClassVar[str] = "Thief"

        def contribute(self, loads: Loads) -> None:
            loads.parameter("body0.mass", 1.25e-3, "N", "not a mass")

    with pytest.raises(lamc.DesignError, match=r"'body0\.mass' is there already"):
        lamc.compile(chain(1), lamc.Scene(effects=(Thief(),)))


def test_a_hinge_that_moves_no_inertia_is_refused_by_name() -> None:
    rod = lamc.Body("rod", mass=1.0, inertia=np.diag([0.1, 0.1, 0.0]))
    mechanism = lamc.Mechanism(
        bodies=(lamc.Body("w", fixed=True), rod), joints=(lamc.Joint("h", "w", "rod"),)
    )
    with pytest.raises(lamc.TopologyError, match=r"joint 'h' moves nothing that has inertia .*'rod'"):
        lamc.compile(mechanism)


def test_scenes_and_torques_survive_pickling() -> None:
    torque = lamc.Torque({"h0": "0.1*t", "h1": 0.5})
    assert pickle.loads(pickle.dumps(torque)) == torque
