"""Derivatives of a run: closed forms, differences of runs, and the motion itself, which they leave as it is."""

import pickle
import platform
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest

import lamc
from lamc.codegen.cache import Cache
from lamc.mechanics import tangents
from lamc.mechanics.lower import lower
from lamc.mechanics.tangents import Columns
from lamc.records.mechanism import Body, Joint, Mechanism
from tests.support.ctools import needs_cc
from tests.support.every_effect import SAMPLES
from tests.support.every_effect import mechanism as two_links
from tests.support.mechanisms import chain, two_flaps

Array = npt.NDArray[np.float64]
PLACES, WEIGHTS = (-3, -2, -1, 1, 2, 3), (-1 / 60, 9 / 60, -45 / 60, 45 / 60, -9 / 60, 1 / 60)
EXACT = {"rtol": 1e-12, "atol": 1e-14}
# Runs at 1e-13 differ from the truth by some 1e-12 of a state; differences of order 6 over 1e-3 of a number make 1e-9.
CLOSE = 1e-8
EXAMPLES = Path(lamc.__file__).parent / "examples"


def example(name: str) -> lamc.Design:
    return lamc.load(EXAMPLES / f"{name}.yaml")


def states(result: lamc.Result) -> Array:
    assert result.success, result.message
    return np.hstack([result.q, result.u])


def changed(sim: lamc.Simulator, design: lamc.Design | Mechanism, name: str, value: float) -> lamc.Simulator:
    """The simulator with another value of what is no parameter."""
    what, _, joint = name.partition(".")
    if what in ("angles", "rates"):
        given = {**getattr(sim.scene, what), joint: value}
        return lamc.compile(design, replace(sim.scene, **{what: given}))
    return lamc.compile(design.with_parameters({name: value}), sim.scene)


def by_differences(
    sim: lamc.Simulator, design: lamc.Design | Mechanism, name: str, value: float, reach: float, times: Array
) -> Array:
    """(m, nq + nu), of order 6 in `reach`."""
    total = np.zeros((len(times), len(sim.coordinates) + len(sim.rates)))
    for place, weight in zip(PLACES, WEIGHTS, strict=True):
        at = value + place * reach
        asked = {"t_end": float(times[-1]), "rtol": 1e-13, "atol": 1e-15, "t_eval": times}
        if name in sim.parameters:
            run = sim.run(**asked, parameters={name: at})
        else:
            run = changed(sim, design, name, at).run(**asked)
        total += weight / reach * states(run)
    return total


def check(
    design: lamc.Design | Mechanism,
    names: Sequence[str],
    t_end: float,
    reach: float = 1e-3,
    integrator: str = "auto",
    close: float = CLOSE,
) -> lamc.Result:
    """Derivatives by differences; reach: of a value."""
    sim = lamc.compile(design)
    times = np.linspace(0.0, t_end, 23)
    asked = {"t_end": t_end, "t_eval": times, "integrator": integrator, **EXACT}
    plain, found = sim.run(**asked), sim.run(**asked, sensitivities=names)
    assert np.array_equal(states(plain), states(found))  # the motion is the same to the last bit
    assert plain.stats.steps == found.stats.steps
    assert found.sensitivities is not None
    assert found.sensitivities.lost is None
    for k, name in enumerate(names):
        index = [f"angles.{joint}" for joint in sim.joints]
        if name in sim.parameters:
            value = sim.parameters[name]
        elif name in index:
            value = float(sim.start[index.index(name)])
        else:
            value = design.parameters[name].default
        width = reach * (abs(value) or 1.0)
        expected = by_differences(sim, design, name, value, width, times)
        error = np.abs(found.sensitivities.values[:, :, k] - expected).max()
        noise = (
            1e-12 * np.abs(states(plain)).max() / width
        )  # of the differences: runs repeat to 1e-12 of a state
        assert error <= close * np.abs(expected).max() + noise, name
    return found


def oscillator() -> Mechanism:
    """One link of 2 g·m² about its hinge, on a spring of 0.5 N·m/rad."""
    link = Body("link", 0.1, np.array([0.1, 0.0, 0.0]), np.diag([1e-3, 1e-3, 1e-3]))
    hinge = Joint(
        "h",
        "ground",
        "link",
        point=np.zeros(3),
        axis=np.array([0.0, 0.0, 1.0]),
        stiffness=0.5,
    )
    return Mechanism((Body("ground", fixed=True), link), (hinge,), name="oscillator")


@pytest.mark.parametrize("integrator", ["rk45", "dop853", "rodas5p", "radau5", "auto"])
def test_an_oscillator_follows_the_closed_form(integrator: str) -> None:
    """θ = θ0 cos ωt with ω² = k / I: dθ/dk = -θ0 t sin(ωt) / (2 ω I), dθ/dθ0 = cos ωt."""
    sim = lamc.compile(oscillator(), lamc.Scene(effects=(lamc.HingeStiffness(),), angles={"h": 0.3}))
    names = ["h.stiffness", "angles.h", "rates.h"]
    result = sim.run(t_end=1.0, integrator=integrator, rtol=1e-11, atol=1e-13, sensitivities=names)
    t, inertia = result.t, 1e-3 + 0.1 * 0.1**2
    omega = np.sqrt(0.5 / inertia)
    wanted = {
        "h.stiffness": -0.3 * t * np.sin(omega * t) / (2.0 * omega * inertia),
        "angles.h": np.cos(omega * t),
        "rates.h": np.sin(omega * t) / omega,
    }
    for name, expected in wanted.items():
        found = result.sensitivity("h", name)
        # 8 periods at 1e-11 a step; Rodas5P's states between its steps are of order 4, and so are derivatives then
        assert (
            np.abs(found - expected).max()
            <= (1e-6 if integrator == "rodas5p" else 1e-8) * np.abs(expected).max()
        )


def test_a_tree_against_differences() -> None:
    tree = chain(3)
    sim = lamc.compile(tree)
    some = [name for name in sim.parameters if name.endswith((".mass", ".stiffness", ".damping"))][::2]
    check(tree, [*some, f"angles.{sim.joints[0]}"], 0.4)


@pytest.mark.slow
def test_a_loop_by_a_load_an_angle_and_a_length() -> None:
    check(example("four_bar"), ["link.stiffness", "angles.arm", "arm_length"], 0.5)


@pytest.mark.slow
def test_two_angles_chosen_and_the_scale_of_a_drawing() -> None:
    # Of what follows from scale, cubes and fifth powers: over 1e-4 of it differences of order 6 know them to 1e-10.
    check(example("five_bar"), ["ankle_a.stiffness", "angles.hip_b", "scale"], 0.3, reach=1e-4)


def test_through_impacts_at_limits() -> None:
    # Other steps between impacts: 9 of them make what a step of 1e-3 does too large for order 6.
    found = check(example("limit_stop"), ["angles.flap", "tongue.mass", "scale"], 1.0, reach=1e-4)
    assert len(found.events) == 9


@pytest.mark.slow
def test_through_touch_downs_on_a_floating_base() -> None:
    # A contact's force begins with the power 1.5 of depth, whose derivatives differences of runs know to 1e-6.
    found = check(example("crawler"), ["body.mass", "gravity.z"], 0.03, reach=3e-6, close=1e-6)
    assert len(found.events) >= 8


@pytest.mark.parametrize("integrator", ["radau5", "rodas5p"])
@pytest.mark.quick("rodas5p", others="campaign")
def test_stiff_hinges(integrator: str) -> None:
    check(example("stiff_triple"), ["thigh.mass", "gravity.y"], 0.1, integrator=integrator, close=1e-7)


@pytest.mark.slow
def test_air_on_a_wing() -> None:
    check(example("flapping_wing"), ["wing.air.drag_edge_on", "angles.stroke"], 0.05)


def test_points_and_energies_follow_by_the_chain_rule() -> None:
    """A link's centre moves by the angle's derivative, the energy of the start by the stiffness of its spring."""
    scene = lamc.Scene(effects=(lamc.HingeStiffness(),), angles={"h": 0.3})
    result = lamc.compile(oscillator(), scene).run(t_end=0.2, **EXACT, sensitivities=["h.stiffness"])
    theta, slope = result.angle("h"), result.sensitivity("h", "h.stiffness")
    # Differences of order 6 over a hundredth of a radian know a point to 1e-12 of its size, 0.1 m; runs are at 1e-12
    assert np.allclose(result.sensitivity("link.x", "h.stiffness"), -0.1 * np.sin(theta) * slope, atol=1e-11)
    assert np.allclose(result.sensitivity("energy", "h.stiffness"), 0.3**2 / 2.0, atol=1e-9)
    assert np.array_equal(result.sensitivity("h.rate", "h.stiffness"), _rates(result))


def _rates(result: lamc.Result) -> Array:
    assert result.sensitivities is not None
    return result.sensitivities.values[:, 1, 0]


def test_points_follow_from_lengths() -> None:
    """A length moves a point by the motion, and by where it lies on its body."""
    design = example("four_bar")
    sim, times = lamc.compile(design), np.linspace(0.0, 0.3, 7)
    found = sim.run(t_end=0.3, t_eval=times, **EXACT, sensitivities=["arm_length"])
    value, reach = design.parameters["arm_length"].default, 1e-4
    expected = np.zeros(len(times))
    for place, weight in zip(PLACES, WEIGHTS, strict=True):
        other = changed(sim, design, "arm_length", value + place * reach * value)
        run = other.run(t_end=0.3, t_eval=times, rtol=1e-13, atol=1e-15)
        expected += weight / (reach * value) * run.quantity("shelf.x").values
    error = np.abs(found.sensitivity("shelf.x", "arm_length") - expected).max()
    assert error <= CLOSE * np.abs(expected).max()


def test_rows_and_slices_do_not_matter() -> None:
    sim = lamc.compile(example("four_bar"))
    many = sim.run(t_end=0.4, t_eval=np.linspace(0.0, 0.4, 4001), sensitivities=["link.stiffness"])
    few = sim.run(t_end=0.4, t_eval=[0.1, 0.4], sensitivities=["link.stiffness"])
    assert many.sensitivities is not None
    assert few.sensitivities is not None
    assert np.array_equal(many.sensitivities.values[[1000, 4000]], few.sensitivities.values)


def test_two_impacts_at_one_instant_have_no_derivative() -> None:
    """Two flaps alike, side by side, fall on their stops at once: which is first is another motion."""
    scene = lamc.Scene(effects=(lamc.Gravity(), lamc.JointLimits(restitution=0.5)))
    result = lamc.compile(two_flaps(), scene).run(t_end=0.5, sensitivities=["a.mass"])
    assert result.sensitivities is not None
    lost = result.sensitivities.lost
    assert lost is not None
    first = result.events[0].t
    assert lost.t == pytest.approx(first, abs=1e-12)
    before = result.t < first
    assert np.isfinite(result.sensitivities.values[before]).all()
    assert np.isnan(result.sensitivity("h_a", "a.mass")[~before]).all()
    assert any("no derivative" in note and "one instant" in note for note in result.notes)


def test_a_result_with_derivatives_can_be_pickled() -> None:
    sim = lamc.compile(oscillator(), lamc.Scene(effects=(lamc.HingeStiffness(),), angles={"h": 0.3}))
    result = sim.run(t_end=0.1, sensitivities=["h.stiffness"])
    again = pickle.loads(pickle.dumps(result))
    for output in ("h", "link.x"):
        wanted = result.sensitivity(output, "h.stiffness")
        assert np.array_equal(again.sensitivity(output, "h.stiffness"), wanted)


def test_what_cannot_be_differentiated_is_refused() -> None:
    sim = lamc.compile(oscillator(), lamc.Scene(effects=(lamc.HingeStiffness(),)))
    for names, words in (
        (["h.stifness"], r"did you mean 'h\.stiffness'"),
        ("h.stiffness", "must be a list of names"),
        (["h.stiffness", "h.stiffness"], "may stand there once"),
        ([3], "must be a list of names"),
        ("", "must be a list of names"),
        (None, "sensitivities is None; it must be a list of names"),
        (7, "must be a list of names"),
    ):
        with pytest.raises(lamc.RequestError, match=words):
            sim.run(t_end=0.1, sensitivities=names)
    plain = sim.run(t_end=0.1)
    with pytest.raises(lamc.RequestError, match="was not differentiated"):
        plain.sensitivity("h", "h.stiffness")


def test_nothing_of_it_stands_in_the_c_of_others() -> None:
    sim = lamc.compile(oscillator(), lamc.Scene(effects=(lamc.HingeStiffness(),)))
    before = sim.program.digest
    sim.run(t_end=0.1, sensitivities=["h.stiffness"])
    assert "tangents" not in sim.program.functions
    assert sim.program.digest == before
    text = "".join(path.read_text() for path in sim.source_dir.glob("*.[ch]"))
    assert "tangents" not in text


@pytest.mark.parametrize("hold", ["previous", "linear", "cubic"])
def test_through_jumps_and_kinks_of_a_series(hold: str) -> None:
    command = lamc.Series(np.linspace(0.0, 1.0, 6), [0.0, 0.1, -0.1, 0.2, 0.05, 0.3], hold=hold)
    scene = lamc.Scene(
        effects=(lamc.HingeStiffness(), lamc.Torque({"h": "command"})),
        inputs={"command": lamc.Input(unit="N*m", series=command)},
        angles={"h": 0.1},
    )
    check(replace(oscillator(), scene=scene), ["h.stiffness", "angles.h"], 1.0)


def test_a_servo_that_saturates() -> None:
    scene = lamc.Scene(
        effects=(
            lamc.Servo(
                joint="h", command=1.0, stiffness=2.0, damping=0.02, stall_torque=0.3, no_load_speed=20.0
            ),
        ),
        angles={"h": 0.1},
    )
    sim = lamc.compile(replace(oscillator(), scene=scene))
    names = [name for name in sim.parameters if "servo" in name][:4]
    assert len(names) == 4
    found = check(replace(oscillator(), scene=scene), [*names, "link.mass"], 0.5, reach=1e-4)
    assert found.events


@pytest.mark.parametrize("name", sorted(SAMPLES))
@pytest.mark.quick(
    "base_motion", "blade_element_drag", "free_base", "ground_contact", "joint_limits", "nonlinear_stiffness"
)
def test_every_effect(name: str) -> None:
    """By a mass, an angle of the start, and the first number of the effect's own."""
    effects = tuple({"gravity": SAMPLES["gravity"], name: SAMPLES[name]}.values())
    device = replace(two_links(), scene=lamc.Scene(effects=effects))
    sim = lamc.compile(device)
    own = [
        each for each in sim.parameters if not each.startswith(("gravity", "a.", "b.", "ground_contact", "h"))
    ]
    check(device, ["b.mass", f"angles.{sim.joints[0]}", *own[:1]], 0.2)


def test_stiff_columns_over_steps_of_an_explicit_method() -> None:
    """The run's steps are near their stability limit, and too long for the derivative by a damping that hardly counts:
    it goes on by shorter ones, and the next step begins with the slope of what those left. It is some 1e-12, and known
    to a tenth: what steps at 1e-9 leave of the stiff mode falls with their tolerance."""
    scene = lamc.Scene(effects=(SAMPLES["gravity"], SAMPLES["twist_compliance"]))
    sim = lamc.compile(two_links(), scene)

    def values(integrator: str, rtol: float) -> Array:
        asked = {"t_end": 0.3, "t_eval": np.linspace(0.05, 0.3, 11), "rtol": rtol, "atol": 1e-2 * rtol}
        found = sim.run(**asked, integrator=integrator, sensitivities=["h2.cross_damping.slide_x"])
        assert found.sensitivities is not None
        return found.sensitivities.values

    exact = values("radau5", 1e-11)
    assert np.abs(values("dop853", 1e-9) - exact).max() <= 0.2 * np.abs(exact).max()


@pytest.mark.parametrize("integrator", ["dop853", "radau5"])
def test_a_servo_that_samples(integrator: str) -> None:
    """What is held between samples follows from the state at the last one, and so do its derivatives."""
    servo = lamc.Servo(joint="h", command=0.5, stiffness=2.0, damping=0.02, period=0.013)
    device = replace(
        oscillator(), scene=lamc.Scene(effects=(servo, lamc.HingeStiffness()), angles={"h": 0.1})
    )
    sim = lamc.compile(device)
    names = [
        name for name in sim.parameters if name.endswith(("servo.stiffness", "servo.damping", "link.mass"))
    ]
    assert len(names) == 3
    found = check(device, [*names, "angles.h"], 0.2, reach=1e-4, integrator=integrator)
    assert len(found.events) >= 15
    period = next(name for name in sim.parameters if name.endswith("period"))
    with pytest.raises(lamc.RequestError, match="the times at which a servo samples"):
        sim.run(t_end=0.1, sensitivities=[period])


def _two_links(*names: str) -> Mechanism:
    return replace(two_links(), scene=lamc.Scene(effects=tuple(SAMPLES[name] for name in names)))


def _sampled() -> Mechanism:
    servo = lamc.Servo(joint="h", command=0.5, stiffness=2.0, damping=0.02, period=0.013)
    return replace(oscillator(), scene=lamc.Scene(effects=(servo, lamc.HingeStiffness()), angles={"h": 0.1}))


def _following() -> Mechanism:
    command = lamc.Series(np.linspace(0.0, 1.0, 6), [0.0, 0.1, -0.1, 0.2, 0.05, 0.3], hold="linear")
    scene = lamc.Scene(
        effects=(lamc.HingeStiffness(), lamc.Torque({"h": "command"})),
        inputs={"command": lamc.Input(unit="N*m", series=command)},
        angles={"h": 0.1},
    )
    return replace(oscillator(), scene=scene)


DEVICES: dict[str, Callable[[], lamc.Design | Mechanism]] = {
    "a loop": lambda: example("four_bar"),
    "impacts": lambda: example("limit_stop"),
    "a base that moves": lambda: _two_links("gravity", "free_base"),
    "a table": lambda: _two_links("gravity", "nonlinear_stiffness"),
    "samples": _sampled,
    "a series": _following,
}


@pytest.mark.quick("samples-dop853-", others="campaign")
@pytest.mark.parametrize("flags", ["", " -mavx", " -DLAMC_ONE_LANE"])
@pytest.mark.parametrize("integrator", ["dop853", "radau5"])
@pytest.mark.parametrize("name", sorted(DEVICES))
@needs_cc
def test_along_directions_as_by_each_component_of_the_state(
    name: str, integrator: str, flags: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Both ways to write derivatives by the state, and both with numbers side by side or one after the other."""
    if " -mavx" in flags and platform.machine() not in ("x86_64", "AMD64"):
        pytest.skip("no such processor")
    device = DEVICES[name]()
    asked = {"t_end": 0.2, "t_eval": np.linspace(0.0, 0.2, 7), "integrator": integrator}

    def found() -> Array:
        sim = lamc.compile(device, options=lamc.CompileOptions(compiler=f"cc{flags}"))
        names = [each for each in sim.parameters if each.endswith((".mass", "stiffness", "_x"))][:2]
        program = lower(sim.equations, columns=Columns(tuple(names)))
        assert ("directional_tangents" in program.functions) == (tangents.MAX_MATRIX < 0)
        run = sim.run(**asked, sensitivities=[*names, f"angles.{sim.joints[0]}"])
        assert run.sensitivities is not None
        return run.sensitivities.values

    by_state = found()
    monkeypatch.setenv("LAMC_CACHE_DIR", str(tmp_path))  # the cache knows modules by their design
    monkeypatch.setattr(tangents, "MAX_MATRIX", -1)
    along = found()
    # The same sums in another order: some round-off of the largest, over some hundred steps.
    scale = np.abs(by_state).max(axis=(0, 1))
    assert np.abs(by_state - along).max(axis=(0, 1)) == pytest.approx(0.0, abs=1e-11 * scale.max())
    assert (scale > 0).all()


def test_derivatives_beyond_the_horizon_of_chaos_are_told() -> None:
    """A chain of two links that turns over: what a mass changes grows by e every third of a second or so."""
    bodies = [Body("ground", fixed=True)]
    for k in range(2):
        bodies.append(Body(f"link{k}", 1.0, np.array([k + 0.5, 0.0, 0.0]), np.eye(3) / 12.0))
    joints = [
        Joint(
            f"h{k}",
            bodies[k].name,
            bodies[k + 1].name,
            np.array([float(k), 0.0, 0.0]),
            np.array([0.0, 1.0, 0.0]),
        )
        for k in range(2)
    ]
    scene = lamc.Scene(effects=(lamc.Gravity((0.0, 0.0, -9.81)),), angles={"h0": -2.0, "h1": 1.0})
    sim = lamc.compile(Mechanism(tuple(bodies), tuple(joints), name="double"), scene)
    for t_end, is_told in ((1.0, False), (40.0, True)):
        notes = sim.run(t_end=t_end, sensitivities=["link1.mass"]).notes
        assert any("chaotic" in note for note in notes) == is_told, notes


@pytest.mark.slow
def test_a_module_with_derivatives_is_known_by_its_design(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Opened again without a survey of the design, and with the same numbers of the drawing."""
    cache = Cache(tmp_path)
    columns = Columns(("gravity.z",), ())
    first, keys = lamc.compile(example("pendulum"), cache=cache).with_columns(columns)
    again = lamc.compile(example("pendulum"), cache=cache)
    monkeypatch.setattr("lamc.pipeline.job.survey_design", None)  # whatever asks for it fails
    second, same = again.with_columns(columns)
    assert keys
    assert same == keys
    assert np.array_equal(second.motion({}).parameters, first.motion({}).parameters)
