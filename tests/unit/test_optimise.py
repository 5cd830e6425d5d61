"""`lamc.optimise` against optima that are known: in closed form, or because a mechanism is to find its own lengths."""

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.special import ellipk

import lamc
from lamc import (
    Body,
    DesignError,
    Gravity,
    HingeDamping,
    HingeStiffness,
    Input,
    Joint,
    Mechanism,
    Scene,
    Torque,
)
from lamc.run.result import Result
from lamc.studies.optimum import Best
from tests.support.ctools import needs_cc

pytestmark = needs_cc

ACCURATE = 1e-6  # of the parameter: what issue and docstring promise
INERTIA = 2e-3  # kg·m²
START = 0.5  # rad


def pendulum(length: float = 0.3) -> Mechanism:
    """A point mass on a rod without mass, which swings about y."""
    bodies = (
        Body("ground", fixed=True),
        Body("bob", 0.1, np.array([0.0, 0.0, -length]), np.eye(3) * 1e-15),
    )
    hip = Joint("hip", "ground", "bob", point=np.zeros(3), axis=np.array([0.0, 1.0, 0.0]))
    scene = Scene(effects=(Gravity((0.0, 0.0, -9.81)),), duration=0.6)
    return Mechanism(bodies, (hip,), name="pendulum", scene=scene)


def rotor() -> Mechanism:
    """A wheel on a spring: its angle is 0.5 cos(√(k/I) t), all in closed form."""
    bodies = (Body("ground", fixed=True), Body("wheel", 0.1, np.zeros(3), np.eye(3) * INERTIA))
    axis = np.array([0.0, 1.0, 0.0])
    h = Joint("h", "ground", "wheel", point=np.zeros(3), axis=axis, stiffness=0.5, damping=0.0)
    effects = (HingeStiffness(), HingeDamping(), Torque({"h": "drive"}))
    scene = Scene(effects=effects, angles={"h": START}, duration=1.0, inputs={"drive": Input(0.0, "N*m")})
    return Mechanism(bodies, (h,), name="rotor", scene=scene)


def found(best: Best, name: str) -> float:
    value = best.parameters[name]
    assert isinstance(value, float)
    return value


@pytest.mark.parametrize("amplitude", [1e-3, 1.2, 3.0])
def test_length_of_a_pendulum_for_a_period(amplitude: float) -> None:
    """T = 4 √(l/g) K(sin(θ/2)²); for small swings 2π √(l/g), which 1e-3 rad misses by 6e-8 of T."""

    def swinging(length: float = 0.3) -> Mechanism:
        made = pendulum(length)
        assert made.scene is not None
        scene = Scene(made.scene.effects, angles={"hip": amplitude}, duration=0.6)
        return Mechanism(made.bodies, made.joints, name="pendulum", scene=scene)

    period = 1.0
    length = 9.81 * (period / 4.0 / ellipk(math.sin(amplitude / 2.0) ** 2)) ** 2
    best = lamc.optimise(
        swinging,
        {"length": (0.5 * length, 1.7 * length)},
        "(time_of(hip < 0) - 0.25)**2",
        starts=1,
    )
    assert best.converged
    assert best.method == "least-squares"
    assert found(best, "length") == pytest.approx(length, rel=ACCURATE)


METHODS = ["auto", "slsqp", "trust-constr", "nelder-mead", "evolution"]


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.quick("auto", "slsqp", "nelder-mead", "trust-constr", others="campaign")
def test_spring_at_an_active_constraint(method: str) -> None:
    """The quarter period π/2 √(I/k) falls with k, the largest rate θ √(k/I) rises: at its bound ω, k is I (ω/θ)², and
    the quarter period, π θ / (2 ω), falls by π θ / (2 ω²) for each unit that the bound gives way."""
    best = lamc.optimise(
        rotor(),
        {"h.stiffness": "log:0.02:2"},
        "time_of(h < 0)",
        "max(abs(h.rate)) < 5 rad/s",
        method=method,
        starts=2,
    )
    assert best.converged, best.message
    assert found(best, "h.stiffness") == pytest.approx(INERTIA * (5.0 / START) ** 2, rel=ACCURATE)
    assert best.value == pytest.approx(math.pi * START / 10.0, rel=ACCURATE)
    assert best.active == ("max(abs(h.rate)) < 5 rad/s",)
    force = math.pi * START / 50.0
    assert best.multipliers[best.active[0]] == pytest.approx(force, rel=1e-4)  # by differences of runs


def resonance(result: Result) -> float:
    """Minus the amplitude at 20 rad/s over the last period, by the rows' Fourier sum, in rad."""
    last = result.t > result.t[-1] - 2.0 * math.pi / 20.0 * (1.0 + 1e-12)
    t, h = result.t[last][1:], result.angle("h")[last][1:]
    return -2.0 * abs(complex(np.mean(h * np.exp(-20j * t))))


def test_spring_for_a_resonance() -> None:
    """The steady amplitude τ / |k - I ω² + i c ω| is largest at k = I ω²; after 8 s the start is e⁻⁶⁰ of itself."""
    made = rotor()
    assert made.scene is not None
    joint = Joint(
        "h", "ground", "wheel", point=np.zeros(3), axis=np.array([0.0, 1.0, 0.0]), stiffness=0.5, damping=0.03
    )
    scene = Scene((HingeStiffness(), HingeDamping(), Torque({"h": "0.01 * sin(20 * t)"})))
    design = Mechanism(made.bodies, (joint,), name="rotor", scene=scene)
    periods = 25
    best = lamc.optimise(
        design,
        {"h.stiffness": (0.3, 1.3)},
        (resonance, "rad"),
        t_end=periods * 2.0 * math.pi / 20.0,
        rows=200 * periods + 1,
        starts=2,
    )
    assert best.converged, best.message
    assert found(best, "h.stiffness") == pytest.approx(INERTIA * 20.0**2, rel=ACCURATE)
    assert best.value == pytest.approx(-1e-2 / (0.03 * 20.0), rel=1e-6)


def test_an_optimum_at_a_bound_tells_what_holds_it() -> None:
    best = lamc.optimise(rotor(), {"h.stiffness": "0.05:2"}, "time_of(h < 0)", starts=2)
    assert best.converged
    assert best.parameters == {"h.stiffness": 2.0}
    (held,) = best.active
    assert held == "h.stiffness = 2 N·m/rad, its most"
    slope = math.pi / 4.0 * math.sqrt(INERTIA) * 2.0**-1.5  # of π/2 √(I/k)
    assert best.multipliers[held] == pytest.approx(slope, rel=1e-6)


def test_how_far_a_parameter_may_move_for_one_percent() -> None:
    """Near its least the value is v + v''/2 δ²; here v = 1 + (T(k)/T₀ - 1)² with T = π/2 √(I/k), T₀ = 0.1 s."""
    best = lamc.optimise(
        rotor(), {"h.stiffness": (0.2, 1.0)}, "1 + (time_of(h < 0) / 0.1 s - 1)**2", starts=2
    )
    stiffness = INERTIA * (math.pi / 2.0 / 0.1) ** 2
    assert best.converged
    assert found(best, "h.stiffness") == pytest.approx(stiffness, rel=ACCURATE)
    bend = 2.0 * (0.5 / stiffness) ** 2
    assert best.moves["h.stiffness"] == pytest.approx(math.sqrt(2.0 * 0.01 / bend), rel=1e-3)


def test_what_is_not_felt_is_told() -> None:
    """The period of a linear spring knows nothing of the amplitude."""
    best = lamc.optimise(
        rotor(),
        {"h.stiffness": (0.2, 1.0), "angles.h": (0.3, 1.0)},
        "(time_of(h < 0) - 0.1)**2",
        starts=1,
    )
    assert found(best, "h.stiffness") == pytest.approx(INERTIA * (math.pi / 0.2) ** 2, rel=ACCURATE)
    assert "does not feel angles.h" in best.message
    assert math.isinf(best.known_to["angles.h"])


def coupler(crank_angle: np.ndarray[Any, Any], crank: float, rod: float) -> np.ndarray[Any, Any]:
    """Point (m, 2) of a Hoeken linkage's coupler, twice as far from the crank as the pin of the rocker: the closed form
    of two circles that meet, independent of lamc. Ground 0.2, coupler to pin `rod`, rocker 0.25."""
    a = crank * np.stack([np.cos(crank_angle), np.sin(crank_angle)], axis=1)
    ground, rocker = np.array([0.2, 0.0]), 0.25
    way = ground - a
    d = np.linalg.norm(way, axis=1)
    along = (rod**2 - rocker**2 + d**2) / (2.0 * d)
    off = np.sqrt(rod**2 - along**2)
    unit = way / d[:, None]
    pin = a + along[:, None] * unit + off[:, None] * np.stack([-unit[:, 1], unit[:, 0]], axis=1)
    return np.asarray(2.0 * pin - a)


def four_bar(crank: float = 0.1, rod: float = 0.25) -> Mechanism:
    """Hoeken's linkage, 1 : 2 : 2.5 : 2.5 and a coupler of 5 as it is first; drawn with the crank at 90°."""
    a = np.array([0.0, crank])
    tip = coupler(np.array([math.pi / 2.0]), crank, rod)[0]
    pin = 0.5 * (a + tip)

    def flat(point: Any) -> Any:
        return np.array([point[0], point[1], 0.0])

    def bar(name: str, middle: Any, mass: float) -> Body:
        return Body(name, mass, flat(middle), np.eye(3) * 1e-4)

    ground = np.array([0.2, 0.0])
    axis = np.array([0.0, 0.0, 1.0])
    bodies = (
        Body("ground", fixed=True),
        bar("crank", 0.5 * a, 1.0),
        bar("coupler", pin, 0.01),
        bar("rocker", 0.5 * (pin + ground), 0.01),
    )
    joints = (
        Joint("drive", "ground", "crank", point=np.zeros(3), axis=axis),
        Joint("elbow", "crank", "coupler", point=flat(a), axis=axis),
        Joint("knee", "coupler", "rocker", point=flat(pin), axis=axis),
        Joint("hip", "rocker", "ground", point=flat(ground), axis=axis),
    )
    points = (lamc.OutputPoint("tip", "coupler", flat(tip)),)
    scene = Scene(effects=(), rates={"drive": 6.0}, outputs=points, duration=0.5)
    return Mechanism(bodies, joints, name="hoeken", scene=scene)


def path_error(result: Result) -> np.ndarray[Any, Any]:
    """From where the coupler of Hoeken's proportions is at the crank's angle, at every tenth row, m."""
    angle = result.angle("drive")[::10] + math.pi / 2.0
    there = np.stack([result.quantity(f"tip.{c}").values[::10] for c in "xy"], axis=1)
    return there - coupler(angle, 0.1, 0.25)


@pytest.mark.slow
def test_four_bar_finds_the_lengths_of_a_published_straight_line() -> None:
    """Hoeken's linkage (Norton, Design of Machinery, table 3-1: ground 2, coupler and rocker 2.5 times the crank): from
    its coupler's path lengths of crank and coupler come out."""
    best = lamc.optimise(
        four_bar,
        {"crank": (0.07, 0.12), "rod": (0.22, 0.28)},
        (path_error, "m"),
        start={"crank": 0.08, "rod": 0.27},
        starts=1,
    )
    assert best.converged, best.message
    assert found(best, "crank") == pytest.approx(0.1, rel=ACCURATE)
    assert found(best, "rod") == pytest.approx(0.25, rel=ACCURATE)


def brittle(length: float = 0.3) -> Mechanism:
    if length > 0.32:
        raise DesignError(f"a rod of {length:g} m does not fit")
    return pendulum(length)


def test_runs_that_fail_are_told_and_go_round() -> None:
    """Half of the range cannot be built; of the other half a part has no zero crossing within the run."""
    best = lamc.optimise(
        brittle,
        {"length": (0.1, 0.5)},
        "(time_of(hip < 0) - 0.25)**2",
        parameters={},
        t_end=0.28,
        starts=2,
        scene=Scene(effects=(Gravity((0.0, 0.0, -9.81)),), angles={"hip": 0.5}),
    )
    length = 9.81 * (0.25 / ellipk(math.sin(0.25) ** 2)) ** 2
    assert best.converged
    assert found(best, "length") == pytest.approx(length, rel=ACCURATE)
    pytest.importorskip("xarray")
    history = best.history
    assert set(history["status"].values.tolist()) >= {"ok", "refused"}
    assert "does not fit" in " ".join(history["reason"].values.tolist())


def test_no_run_goes_well() -> None:
    with pytest.raises(lamc.SimulationError, match=r"no run went well, of .*does not fit"):
        lamc.optimise(brittle, {"length": (0.33, 0.5)}, "last(hip)", starts=1)


def test_what_cannot_be_kept_is_not_converged() -> None:
    best = lamc.optimise(
        rotor(), {"h.stiffness": (0.2, 1.0)}, "time_of(h < 0)", "max(abs(h.rate)) < 0.1 rad/s", starts=2
    )
    assert not best.converged
    assert "'max(abs(h.rate)) < 0.1 rad/s' is farthest from holding" in best.message


def test_runs_that_are_spent_are_not_converged() -> None:
    best = lamc.optimise(rotor(), {"h.stiffness": (0.2, 1.0)}, "time_of(h < 0)", max_runs=9)
    assert not best.converged
    assert best.runs == 9
    assert "ended after 9 runs" in best.message


def test_a_kink_is_found_to_the_same_digits() -> None:
    """|T/4 - 0.1 s| has a kink where it is least."""
    best = lamc.optimise(rotor(), {"h.stiffness": (0.2, 1.0)}, "abs(time_of(h < 0) - 0.1)", starts=2)
    assert best.converged, best.message
    assert found(best, "h.stiffness") == pytest.approx(INERTIA * (math.pi / 0.2) ** 2, rel=ACCURATE)


def wheel(spokes: float = 3.0, material: str = "wood", radius: float = 0.1) -> Mechanism:
    """A wheel on a spring of 0.01 N·m/rad, all of its mass at its rim."""
    inertia = spokes * {"wood": 1.0, "steel": 8.0}[material] * 1e-3 * radius**2
    bodies = (Body("ground", fixed=True), Body("wheel", 0.1, np.zeros(3), np.eye(3) * inertia))
    h = Joint("h", "ground", "wheel", point=np.zeros(3), axis=np.array([0.0, 1.0, 0.0]), stiffness=0.01)
    scene = Scene((HingeStiffness(),), angles={"h": 0.1}, duration=0.5)
    return Mechanism(bodies, (h,), name="wheel", scene=scene)


@pytest.mark.slow
def test_whole_numbers_and_words() -> None:
    """Of 3 to 6 spokes, of wood or steel, 95 to 110 mm long, 5 of wood of 100 mm alone have the period: 4 would have to
    be 112 mm long, 6 91 mm."""
    quarter = math.pi / 2.0 * math.sqrt(5e-5 / 0.01)
    best = lamc.optimise(
        wheel,
        {"spokes": "3..6", "material": "wood|steel", "radius": (0.095, 0.11)},
        f"(time_of(h < 0) - {quarter!r})**2",
    )
    assert best.converged, best.message
    assert best.method == "evolution"
    assert (best.parameters["spokes"], best.parameters["material"]) == (5.0, "wood")
    assert found(best, "radius") == pytest.approx(0.1, rel=ACCURATE)


def test_the_same_seed_gives_the_same_runs_and_a_folder_goes_on(tmp_path: Path) -> None:
    words: Any = (rotor(), {"h.stiffness": "log:0.02:2"}, "time_of(h < 0)", "max(abs(h.rate)) < 5 rad/s")
    whole = lamc.optimise(*words, starts=2, out=tmp_path / "a")
    rows = (tmp_path / "a/rows.jsonl").read_bytes()
    (tmp_path / "a/rows.jsonl").write_bytes(rows[: len(rows) // 2])  # killed while it wrote a line
    again = lamc.optimise(*words, starts=2, resume=tmp_path / "a")
    assert again.parameters == whole.parameters
    assert (tmp_path / "a/rows.jsonl").read_bytes() == rows
    with pytest.raises(lamc.RequestError, match="holds a study of another"):
        lamc.optimise(*words[:2], "last(h)", resume=tmp_path / "a")


def test_the_best_can_be_run_and_made_again() -> None:
    best = lamc.optimise(pendulum, {"length": (0.1, 0.5)}, "last(hip)**2", max_runs=1, starts=1)
    assert best.design.parameters["length"].default == best.parameters["length"] == 0.3
    assert best.result.success


@pytest.mark.slow
def test_a_kink_of_two_parameters_is_not_called_an_optimum() -> None:
    """The larger of two slopes: in a crease of the value no look along each parameter tells its floor."""
    quarter = "(time_of(h < 0) / 0.1 s)"
    goal = f"max(abs({quarter} - 1), abs({quarter} - 3 + 4 * first(h) / 1 rad))"
    vary: Any = {"h.stiffness": (0.2, 1.0), "angles.h": (0.3, 1.0)}
    best = lamc.optimise(rotor(), vary, goal, starts=1, max_runs=1500)
    assert best.value < 1e-6 or not best.converged  # both are zero at T/4 = 0.1 s and 0.5 rad


def test_an_interrupted_search_keeps_what_it_has() -> None:
    runs = 0

    def stopped(result: Result) -> float:
        nonlocal runs
        runs += 1
        if runs == 7:
            raise KeyboardInterrupt
        return float(result.angle("h")[-1]) ** 2

    best = lamc.optimise(rotor(), {"h.stiffness": (0.2, 1.0)}, stopped, starts=1)
    assert best.interrupted
    assert not best.converged
    assert best.runs == 6


def test_a_least_value_beside_points_without_a_number() -> None:
    """The start has no crossing within the run, so no number: least squares begins elsewhere."""
    best = lamc.optimise(
        rotor(),
        {"h.stiffness": (0.01, 1.0)},
        "(time_of(h < 0) - 0.1)**2",
        start={"h.stiffness": 0.01},
        t_end=0.5,
        starts=2,
    )
    assert best.problem.trials[0].status == "undefined"
    assert best.converged
    assert found(best, "h.stiffness") == pytest.approx(INERTIA * (math.pi / 0.2) ** 2, rel=ACCURATE)


@pytest.mark.parametrize("method", ["cma-es"])
@pytest.mark.campaign
def test_cma_es_finds_the_spring(method: str) -> None:
    pytest.importorskip("cma")
    best = lamc.optimise(
        rotor(), {"h.stiffness": "log:0.02:2"}, "time_of(h < 0)", "max(abs(h.rate)) < 5 rad/s", method=method
    )
    assert best.converged
    assert found(best, "h.stiffness") == pytest.approx(INERTIA * (5.0 / START) ** 2, rel=ACCURATE)
