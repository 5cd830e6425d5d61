"""Gradients of runs by their own steps backwards: closed forms, sensitivities of the same runs, and what has none."""

import pickle
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest

import lamc
from lamc.mechanics import pullbacks
from lamc.mechanics.lower import lower
from lamc.records.mechanism import Body, Joint, Mechanism
from lamc.run import native, taping
from lamc.run.gradients import Weights, by_names, pulled_back
from tests.support.every_effect import SAMPLES
from tests.support.every_effect import mechanism as two_links
from tests.support.mechanisms import chain, two_flaps

Array = npt.NDArray[np.float64]
EXAMPLES = Path(lamc.__file__).parent / "examples"
# Forward and backwards the same products are added up in another order: round-off, of some thousand stages.
ROUND_OFF = 1e-10


def example(name: str) -> lamc.Design:
    return lamc.load(EXAMPLES / f"{name}.yaml")


def oscillator() -> Mechanism:
    """One link of 2 g·m² about its hinge, on a spring of 0.5 N·m/rad."""
    link = Body("link", 0.1, np.array([0.1, 0.0, 0.0]), np.diag([1e-3, 1e-3, 1e-3]))
    axis = np.array([0.0, 0.0, 1.0])
    hinge = Joint("h", "ground", "link", point=np.zeros(3), axis=axis, stiffness=0.5)
    return Mechanism((Body("ground", fixed=True), link), (hinge,), name="oscillator")


def check(
    sim: lamc.Simulator,
    names: Sequence[str],
    t_end: float,
    integrator: str = "auto",
    close: float = ROUND_OFF,
    rtol: float = 1e-9,
) -> lamc.Result:
    """Against sensitivities of the same run, with weights of all rows at random: of rows within steps, and of those
    at the ends of steps, an early one and the last. close: of the sum of the sizes of what is added up."""
    rng = np.random.default_rng(7)
    for times in (np.linspace(0.0, t_end, 23), None):
        asked = {"t_end": t_end, "t_eval": times, "integrator": integrator, "rtol": rtol, "atol": 1e-2 * rtol}
        plain, taped = sim.run(**asked), sim.run(**asked, taped=True)
        assert np.array_equal(plain.y, taped.y)  # the motion is the same to the last bit
        assert plain.stats.steps == taped.stats.steps
        assert taped.success, taped.message
        along = sim.run(**asked, sensitivities=names).sensitivities
        assert along is not None
        assert along.lost is None
        weights = rng.standard_normal(taped.y.T.shape)
        if times is None:
            weights[[k for k in range(len(weights)) if k not in (len(weights) // 3, len(weights) - 1)]] = 0.0
        found = by_names(taped, names, pulled_back(taped, Weights(weights)))
        terms = weights[:, :, None] * along.values
        for k, name in enumerate(names):
            size = float(np.abs(terms[:, :, k]).sum())
            assert abs(found[name] - terms[:, :, k].sum()) <= close * size, name
    return taped


@pytest.mark.parametrize("integrator", ["rk45", "dop853", "rodas5p", "radau5", "auto"])
def test_an_oscillator_follows_the_closed_form(integrator: str) -> None:
    """θ = θ0 cos ωt with ω² = k / I: dθ/dk = -θ0 t sin(ωt) / (2 ω I), dθ/dθ0 = cos ωt."""
    sim = lamc.compile(oscillator(), lamc.Scene(effects=(lamc.HingeStiffness(),), angles={"h": 0.3}))
    result = sim.run(t_end=1.0, integrator=integrator, rtol=1e-11, atol=1e-13, taped=True)
    found = result.gradient("last(h)", ["h.stiffness", "angles.h", "rates.h"])
    inertia = 1e-3 + 0.1 * 0.1**2
    omega = np.sqrt(0.5 / inertia)
    wanted = {
        "h.stiffness": -0.3 * np.sin(omega) / (2.0 * omega * inertia),
        "angles.h": np.cos(omega),
        "rates.h": np.sin(omega) / omega,
    }
    assert found.value == pytest.approx(0.3 * np.cos(omega), rel=1e-8)
    for name, expected in wanted.items():
        assert found[name] == pytest.approx(expected, rel=1e-8)  # 8 periods at 1e-11 a step


@pytest.mark.parametrize("integrator", ["rk45", "dop853", "rodas5p", "radau5", "auto"])
@pytest.mark.quick("dop853", "radau5", "auto")
def test_a_tree(integrator: str) -> None:
    sim = lamc.compile(chain(3))
    check(sim, [*sim.parameters, f"angles.{sim.joints[0]}", f"rates.{sim.joints[2]}"], 0.4, integrator)


@pytest.mark.parametrize("integrator", ["dop853", "radau5"])
@pytest.mark.quick("dop853")
def test_a_loop_by_loads_an_angle_and_a_length(integrator: str) -> None:
    sim = lamc.compile(example("four_bar"))
    check(sim, [*sim.parameters, "angles.arm", "arm_length"], 0.5, integrator)


@pytest.mark.parametrize("name", ["two_loops", "bricard"])
@pytest.mark.quick("bricard")
def test_several_loops(name: str) -> None:
    sim = lamc.compile(example(name))
    check(sim, list(sim.parameters)[:8], 0.3, "dop853")


@pytest.mark.slow
def test_stops_that_yield() -> None:
    """Behind an event both are as good as the tolerance: where a step is too long for derivatives, each goes over it in
    parts of its own."""
    sim = lamc.compile(example("limit_stop"))
    found = check(sim, ["tongue.mass", "gravity.z", "angles.flap", "scale"], 0.5, close=1e-7)
    assert len(found.events) == 9


@pytest.mark.parametrize("name", ["limit_stop", "four_bar"])
@pytest.mark.quick("limit_stop")
def test_impacts(name: str) -> None:
    """Sensitivities differentiate an impact by differences of order 6, which know it to some 1e-11."""
    design = example(name)
    limits = lamc.JointLimits(restitution=0.6)
    if name == "limit_stop":
        sim, t_end = (
            lamc.compile(
                design, replace(design.scene, effects=(lamc.Gravity(), lamc.HingeStiffness(), limits))
            ),
            0.15,
        )
    else:
        mechanism = lamc.split(design)
        arm = lamc.compile(design).joints[0]
        joints = tuple(
            replace(joint, limits=(-0.5, 0.2)) if joint.name == arm else joint for joint in mechanism.joints
        )
        limited = replace(mechanism, joints=joints, design=None)
        effects = (lamc.Gravity(), lamc.HingeStiffness(), limits)
        sim, t_end = lamc.compile(limited, lamc.Scene(effects=effects)), 0.12
    names = [name for name in sim.parameters if name.endswith((".mass", "stiffness", "restitution"))]
    starts = [
        f"angles.{sim.joints[0]}",
        f"rates.{sim.joints[0]}",
    ]  # behind parameters, whose values must not stay
    found = check(sim, [*names, "gravity.z", *starts], t_end, close=1e-9)
    assert found.events


@pytest.mark.slow
def test_touch_downs_on_a_floating_base() -> None:
    """A contact's force begins with the power 1.5 of depth: derivatives are known to some 1000 times the tolerance
    there, which eight of them make larger."""
    sim = lamc.compile(example("crawler"))
    found = check(sim, ["body.mass", "gravity.z"], 0.03, "dop853", close=1e-5, rtol=1e-11)
    assert len(found.events) >= 8


@pytest.mark.quick("cubic", "linear")
@pytest.mark.parametrize("hold", ["previous", "linear", "cubic"])
def test_jumps_and_kinks_of_a_series(hold: str) -> None:
    command = lamc.Series(np.linspace(0.0, 1.0, 6), [0.0, 0.1, -0.1, 0.2, 0.05, 0.3], hold=hold)
    scene = lamc.Scene(
        effects=(lamc.HingeStiffness(), lamc.Torque({"h": "command"})),
        inputs={"command": lamc.Input(unit="N*m", series=command)},
        angles={"h": 0.1},
    )
    check(lamc.compile(replace(oscillator(), scene=scene)), ["h.stiffness", "link.mass", "angles.h"], 1.0)


@pytest.mark.slow
def test_a_servo_that_saturates() -> None:
    servo = lamc.Servo(
        joint="h", command=1.0, stiffness=2.0, damping=0.02, stall_torque=0.3, no_load_speed=20.0
    )
    sim = lamc.compile(replace(oscillator(), scene=lamc.Scene(effects=(servo,), angles={"h": 0.1})))
    assert check(sim, [*sim.parameters, "angles.h"], 0.5, close=1e-8).events  # see stops


@pytest.mark.quick("radau5")
@pytest.mark.parametrize("integrator", ["dop853", "radau5"])
def test_a_servo_that_samples(integrator: str) -> None:
    servo = lamc.Servo(joint="h", command=0.5, stiffness=2.0, damping=0.02, period=0.013)
    scene = lamc.Scene(effects=(servo, lamc.HingeStiffness()), angles={"h": 0.1})
    sim = lamc.compile(replace(oscillator(), scene=scene))
    period = next(name for name in sim.parameters if name.endswith("period"))
    names = [name for name in sim.parameters if name != period]
    result = check(sim, [*names, "angles.h"], 0.2, integrator)
    assert len(result.events) >= 15
    assert set(result.gradient("last(h)")) == set(names)
    with pytest.raises(lamc.RequestError, match="the times at which a servo samples"):
        result.gradient("last(h)", [period])


@pytest.mark.parametrize("name", sorted(SAMPLES))
@pytest.mark.quick("joint_limits", "servo")
@pytest.mark.ci(
    "base_motion",
    "blade_element_drag",
    "flexible_links",
    "free_base",
    "ground_contact",
    "joint_limits",
    "servo",
    "spring",
    "twist_compliance",
)
def test_every_effect(name: str) -> None:
    """Radau's collocation is stepped alike by both, whatever the stiffness; see stops for events."""
    effects = tuple({"gravity": SAMPLES["gravity"], name: SAMPLES[name]}.values())
    sim = lamc.compile(replace(two_links(), scene=lamc.Scene(effects=effects)))
    own = [each for each in sim.parameters if not each.startswith(("gravity", "a.", "b."))]
    check(sim, ["b.mass", *own, f"angles.{sim.joints[0]}"], 0.2, "radau5", close=1e-8)


# ---- Measures ------------------------------------------------------------------------------------------------------

MEASURES = (
    "max(h1)",
    "min(h2)",
    "mean(sin(h1)^2)",
    "rms(h2.rate) / 1 s",
    "integral(abs(h1.rate))",
    "at(h1, 0.3711 s)",
    "h2[-3] * first(h1 + 1)",
    "time_of(max(h1))",
    "time_of(h1 > 20 deg)",
    "last(energy) * (1 - exp(-max(h1) / 1 rad))",
    "last(energy.kinetic)",
    "(max(link_3.x) / 1 mm)^2 * atan2(last(h1), last(h2) + 2)",
    "max(min(h1, h2))",
)


def test_measures_against_differences() -> None:
    """By a stiffness and a mass: differences of order 4 over 1e-3 of them know derivatives to 1e-9 or so."""
    sim = lamc.compile(lamc.load(EXAMPLES / "pendulum.cad"))
    asked = {"t_end": 1.0, "t_eval": np.linspace(0.0, 1.0, 101), "rtol": 1e-12, "atol": 1e-14}
    names = [next(n for n in sim.parameters if n.endswith(end)) for end in ("stiffness", ".mass")]
    result = sim.run(**asked, taped=True)
    runs = {
        (name, place): sim.run(**asked, parameters={name: sim.parameters[name] * (1.0 + 1e-3 * place)})
        for name in names
        for place in (-2, -1, 1, 2)
    }
    from lamc.studies.measures import Measure

    for text in MEASURES:
        measure, found = Measure.parse(text, sim), result.gradient(text, names)
        assert found.value == measure.value(result)
        for name in names:
            shares = zip((-2, -1, 1, 2), (1 / 12, -2 / 3, 2 / 3, -1 / 12), strict=True)
            total = sum(weight * measure.value(runs[name, place]) for place, weight in shares)
            assert found[name] == pytest.approx(total / (1e-3 * sim.parameters[name]), rel=1e-6), text


@pytest.mark.slow
def test_points_follow_from_lengths() -> None:
    """A length moves a point by the motion, and by where it lies on its body."""
    sim, times = lamc.compile(example("four_bar")), np.linspace(0.0, 0.3, 7)
    asked = {"t_end": 0.3, "t_eval": times, "rtol": 1e-11, "atol": 1e-13}
    names = ["arm_length", "link.stiffness", "angles.arm"]
    found = sim.run(**asked, taped=True).gradient("last(shelf.x)", names)
    along = sim.run(**asked, sensitivities=names)
    for name in names:  # positions follow from states by differences there, to 1e-10 of their size
        assert found[name] == pytest.approx(along.sensitivity("shelf.x", name)[-1], rel=1e-7)


def test_measures_name_dimensions_and_what_the_run_was_given() -> None:
    """Of a quotient: (x / l)' = x' / l - x / l², and by another name x' / l; x' as measured alone."""
    sim = lamc.compile(example("four_bar"))
    given = {"link.stiffness": 1e-5}
    names = ["arm_length", "link.stiffness"]
    result = sim.run(t_end=0.3, t_eval=[0.0, 0.3], parameters=given, taped=True)
    x, length, k = result.gradient("last(shelf.x)", names), 0.04, 1e-5
    by_length = result.gradient("last(shelf.x) / arm_length", names)
    assert by_length.value == pytest.approx(x.value / length, rel=1e-12)
    assert by_length["link.stiffness"] == pytest.approx(x["link.stiffness"] / length, rel=1e-9)
    assert by_length["arm_length"] == pytest.approx(x["arm_length"] / length - x.value / length**2, rel=1e-9)
    by_spring = result.gradient("last(shelf.x) * link.stiffness", names)
    assert by_spring["link.stiffness"] == pytest.approx(x["link.stiffness"] * k + x.value, rel=1e-9)
    assert by_spring["arm_length"] == pytest.approx(x["arm_length"] * k, rel=1e-9)
    with pytest.raises(
        lamc.RequestError, match=r"'arm\.stiffness' is a parameter .*where the run was given it"
    ):
        result.gradient("last(shelf.x) * arm.stiffness")
    with pytest.raises(lamc.LamcError, match="did you mean 'arm_length'"):
        result.gradient("last(shelf.x) / arm_lenght")


def test_more_parameters_cost_no_more_steps_backwards() -> None:
    """The way back is one for all names: what it evaluates does not depend on them."""
    sim = lamc.compile(chain(3))
    result = sim.run(t_end=0.2, taped=True)
    every = result.gradient("last(h1)" if "h1" in sim.joints else f"last({sim.joints[0]})")
    assert list(every) == list(sim.parameters)
    some = result.gradient(f"last({sim.joints[0]})", list(sim.parameters)[:2])
    for name, value in some.items():
        assert isinstance(value, float)
        assert name in every


# ---- What there is none of -----------------------------------------------------------------------------------------


def test_a_run_without_a_tape_has_none() -> None:
    sim = lamc.compile(oscillator(), lamc.Scene(effects=(lamc.HingeStiffness(),), angles={"h": 0.3}))
    plain, taped = sim.run(t_end=0.1), sim.run(t_end=0.1, taped=True)
    pickled = pickle.loads(pickle.dumps(taped))
    for result, words in (
        (plain, "was not taped"),
        (pickle.loads(pickle.dumps(plain)), "was not taped"),
        (pickled, "is not pickled with its result"),
        (pickle.loads(pickle.dumps(pickled)), "is not pickled with its result"),
        (pickled.at_rows(taped.t > 0.05), "is not pickled with its result"),
        (taped.at_rows(taped.t > 0.05), "some are left out here"),
    ):
        with pytest.raises(lamc.RequestError, match=words):
            result.gradient("last(h)")
    short = sim.run(t_end=10.0, max_steps=5, taped=True)
    with pytest.raises(lamc.SimulationError, match="did not reach its end"):
        short.gradient("last(h)")


def test_runs_that_leave_no_tape_are_refused() -> None:
    sim = lamc.compile(oscillator(), lamc.Scene(effects=(lamc.HingeStiffness(),), angles={"h": 0.3}))
    for options, words in (
        ({"integrator": "scipy:LSODA"}, "leaves no tape"),
        ({"energy_balance": True}, "run it once more"),
        ({"accuracy": 1e-3}, "run it once more"),
        ({"sensitivities": ["h.stiffness"]}, "run it once more"),
    ):
        with pytest.raises(lamc.RequestError, match=words):
            sim.run(t_end=0.1, taped=True, **options)
    loop = lamc.compile(example("four_bar"))
    with pytest.raises(lamc.RequestError, match="baumgarte"):
        loop.run(t_end=0.1, taped=True, baumgarte=10.0)


def test_measures_and_names_without_a_gradient_are_refused() -> None:
    sim = lamc.compile(example("four_bar"))
    result = sim.run(t_end=0.1, t_eval=np.linspace(0.0, 0.1, 11), taped=True)
    for measure, words in (
        (lambda result: 1.0, "is a function"),
        ("max(constraint_error)", "no gradient of 'constraint_error'"),
        ("time_of(max(-t))", "stays there"),
        ("rms(0 * arm)", "has no derivative"),
        ("max(arn)", "did you mean 'arm'"),
        (3, "it must be text"),
    ):
        with pytest.raises(lamc.LamcError, match=words):
            result.gradient(measure)
    with pytest.raises(lamc.RequestError, match=r"did you mean 'link\.stiffness'"):
        result.gradient("last(arm)", ["link.stifness"])
    with pytest.raises(lamc.RequestError, match="names is 'arm_length'; it must be a list"):
        result.gradient("last(arm)", "arm_length")
    with pytest.raises(
        lamc.RequestError, match=r"names is \['gap', 'gap'\]; every name may stand there once"
    ):
        result.gradient("last(arm)", ["gap", "gap"])


def test_two_impacts_at_one_instant_have_no_gradient() -> None:
    """Two flaps alike, side by side, fall on their stops at once: what looks at them later is told since when."""
    scene = lamc.Scene(effects=(lamc.Gravity(), lamc.JointLimits(restitution=0.5)))
    result = lamc.compile(two_flaps(), scene).run(t_end=0.2, taped=True)
    first = result.events[0].t
    with pytest.raises(lamc.SimulationError, match=f"at t = {first:.9g}.*several events fall on one instant"):
        result.gradient("last(h_a)")
    before = int(np.flatnonzero(result.t < first)[-1])
    assert np.isfinite(result.gradient(f"h_a[{before}]")["a.mass"])


def test_nothing_of_it_stands_in_the_c_of_others() -> None:
    sim = lamc.compile(oscillator(), lamc.Scene(effects=(lamc.HingeStiffness(),)))
    before = sim.program.digest
    sim.run(t_end=0.1, taped=True)
    assert "motion_pullback" not in sim.program.functions
    assert sim.program.digest == before
    text = "".join(path.read_text() for path in sim.source_dir.glob("*.[ch]"))
    assert "pullback" not in text


def test_tapes_of_many_pieces_give_the_same(monkeypatch: pytest.MonkeyPatch) -> None:
    """Entries come in pieces of 64 here, and rows one by one."""
    sim = lamc.compile(oscillator(), lamc.Scene(effects=(lamc.HingeStiffness(),), angles={"h": 0.3}))
    whole = sim.run(t_end=3.0, taped=True).gradient("mean(h^2)")
    monkeypatch.setattr(taping, "CHUNK", 1)
    monkeypatch.setattr(native, "CHUNK", 1)
    result = sim.run(t_end=3.0, taped=True)
    assert result.tape is not None
    assert len(result.tape.chunks) >= 3
    assert dict(result.gradient("mean(h^2)")) == dict(whole)
    monkeypatch.setattr(taping, "MOST", 100)
    with pytest.raises(lamc.SimulationError, match=r"the tape of this run, at t = .* takes more than"):
        sim.run(t_end=3.0, taped=True)


def test_code_that_would_be_too_long_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    sim = lamc.compile(oscillator(), lamc.Scene(effects=(lamc.HingeStiffness(),)))
    monkeypatch.setattr(pullbacks, "MAX_FLOPS", 1)
    with pytest.raises(lamc.RequestError, match="more than 1; take differences of runs"):
        lower(sim.equations, pullbacks=True)
