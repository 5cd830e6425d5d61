"""Fits of recordings that a model made itself: what is told comes back, and what is not told is named."""

from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import lamc
from lamc.commands.fit import scene_text
from lamc.fitting.predictions import Predictor
from lamc.fitting.setting import setting_of
from lamc.fitting.simulators import Simulators

EXAMPLES = Path(__file__).parents[2] / "lamc/examples"
TRUE = {"h1.stiffness": 120.0, "h2.stiffness": 80.0, "h1.damping": 7.0, "h2.damping": 12.0}
T = np.linspace(0.01, 2.0, 200)
NOISE = 0.01  # rad


@pytest.fixture(scope="module")
def design() -> lamc.Design:
    design = lamc.load(EXAMPLES / "pendulum.yaml")
    assert isinstance(design, lamc.Design)
    return design


def angles(
    design: lamc.Design, t: np.ndarray = T, seed: int = 0, noise: float = NOISE, **scene: object
) -> dict[str, np.ndarray]:
    """Angles of all hinges with TRUE, and noise."""
    result = lamc.compile(design, lamc.Scene(**scene)).run(t_end=float(t[-1]), t_eval=t, parameters=TRUE)  # type: ignore[arg-type]
    rng = np.random.default_rng(seed)
    return {name: result.angle(name) + noise * rng.normal(size=len(t)) for name in result.joints}


def one_link(stiffness: float = 2e-3, damping: float = 1e-5) -> lamc.Mechanism:
    """A flap of 2 g whose centre of mass is 20 mm below a hinge along y."""
    ground = lamc.Body(name="ground", fixed=True)
    flap = lamc.Body(name="flap", mass=2e-3, com=(0.0, 0.0, -0.02), inertia=np.diag([4e-7, 4e-7, 1e-8]))
    hinge = lamc.Joint(
        name="h", parent="ground", child="flap", axis=(0.0, 1.0, 0.0), stiffness=stiffness, damping=damping
    )
    return lamc.Mechanism(name="flap", bodies=(ground, flap), joints=(hinge,))


def test_a_number_that_is_hardly_felt_is_no_better_told_than_those_it_goes_with() -> None:
    """Without gravity a swing tells k / J and c / J alone: of little damping the interval was one of 0.7 %, about what
    the start of the search had left."""
    c = 0.02
    inertia = 4e-7 + 2e-3 * c * c
    true = {"h.stiffness": 3e-3, "h.damping": 2e-7, "flap.mass": 2e-3}
    t = np.linspace(0.0, 1.0, 201)

    def swing(_t: float, y: np.ndarray) -> list[float]:
        return [y[1], -(true["h.stiffness"] * y[0] + true["h.damping"] * y[1]) / inertia]

    q = solve_ivp(swing, (0.0, 1.0), [0.5, 0.0], t_eval=t, rtol=1e-10, atol=1e-12).y[0]
    q += 2e-3 * np.random.default_rng(3).normal(size=len(t))
    scene = lamc.Scene(without=("gravity",), angles={"h": 0.5})
    for free in (
        dict.fromkeys(true),
        {"h.stiffness": "1e-3:1e-2", "flap.mass": "5e-4:8e-3", "h.damping": "1e-8:1e-5"},
    ):
        fit = lamc.fit(one_link(), lamc.Recording(t, {"h": q}), free, scene)
        for name, value in true.items():
            low, high = fit.intervals[name]
            assert low <= value <= high
        (together,) = fit.unidentifiable
        assert set(together.names) == set(true)
    found = lamc.fit(
        one_link(), lamc.Recording(t, {"h": q}), ["h.stiffness", "h.damping"], scene
    )  # with the mass known
    low, high = found.intervals["h.damping"]
    assert low <= true["h.damping"] <= high < 1.5 * low


def test_a_column_to_one_side_of_the_model_has_a_note_and_its_bias_a_unit() -> None:
    device, t = one_link(), np.linspace(0.0, 1.0, 201)
    scene = lamc.Scene(angles={"h": 0.5})
    q = lamc.compile(device, scene).run(1.0, t_eval=t).angle("h") + 0.02
    q += 5e-3 * np.random.default_rng(0).normal(size=len(t))
    fit = lamc.fit(device, lamc.Recording(t, {"h": q}, name="run"), ["h.damping"], scene)
    (note,) = [note for note in fit.notes if "throughout" in note]
    assert "the model is off h by -0.0" in note
    assert "--free h.bias=LOW:HIGH" in note
    free = lamc.Recording(t, {"h": q}, name="run", bias={"h": "-5 deg:5 deg"})
    told = lamc.fit(device, free, ["h.damping"], scene)
    assert not [note for note in told.notes if "throughout" in note]
    assert told.units["run.h.bias"] == "rad"
    assert told.values["run.h.bias"] == pytest.approx(
        0.02, abs=4 * 5e-3 / np.sqrt(len(t))
    )  # four standard errors


def test_the_scene_moves_as_the_fit_does_with_the_recordings_own_numbers() -> None:
    """They had been left out: the scene swung as the design says, and the fit as the recording does."""
    device, t = one_link(), np.linspace(0.0, 1.0, 201)
    scene, own = lamc.Scene(angles={"h": 0.5}), {"h.damping": 5e-5}
    q = lamc.compile(device, scene).run(1.0, t_eval=t, parameters=own).angle("h")
    recording = lamc.Recording(t, {"h": q}, parameters=own)
    fit = lamc.fit(device, recording, ["h.stiffness"], scene)
    again = lamc.compile(fit.design, fit.scene).run(1.0, t_eval=t)
    assert again.angle("h") == pytest.approx(q, abs=1e-7)  # both to rtol 1e-9, stiffness to 1e-8
    two = lamc.fit(device, [recording, recording], ["h.stiffness"], scene)
    assert "h.damping" not in two.scene.parameters
    remarks = scene_text(two, "flap")
    assert remarks.count(" has h.damping = 5e-05\n") == 2


def test_stiffness_and_damping_of_a_flap_that_scipy_swung() -> None:
    """The recording is made by nobody here: I q̈ = -m g c sin q - k q - d q̇, by scipy."""
    m, c, g, k, d = 2e-3, 0.02, 9.81, 3e-3, 2e-5
    inertia = 4e-7 + m * c * c

    def swing(_t: float, y: np.ndarray) -> list[float]:
        return [y[1], (-m * g * c * np.sin(y[0]) - k * y[0] - d * y[1]) / inertia]

    t = np.linspace(0.0, 1.0, 201)
    q = solve_ivp(swing, (0.0, 1.0), [0.5, 0.0], t_eval=t, rtol=1e-11, atol=1e-13).y[0]
    fit = lamc.fit(
        one_link(), lamc.Recording(t, {"h": q}), ["h.stiffness", "h.damping"], lamc.Scene(angles={"h": 0.5})
    )
    assert fit.values["h.stiffness"] == pytest.approx(k, rel=1e-8)  # runs of 1e-10 a step, some 1e3 steps
    assert fit.values["h.damping"] == pytest.approx(d, rel=1e-7)  # a hundredth of the torque
    assert fit.converged
    assert not fit.unidentifiable


def test_what_is_told_comes_back(design: lamc.Design) -> None:
    fit = lamc.fit(design, [lamc.Recording(T, angles(design))], list(TRUE))
    for name, true in TRUE.items():
        low, high = fit.intervals[name]
        assert low < fit.values[name] < high
        assert (
            low - 0.2 * (high - low) < true < high + 0.2 * (high - low)
        )  # 95 % intervals: 3 standard errors here
    rms = np.sqrt(np.mean([each**2 for each in fit.compared[0].rms.values()]))
    assert rms == pytest.approx(NOISE, rel=0.1)  # 600 numbers: 3 % is one standard deviation
    run = lamc.compile(fit.design, fit.scene).run(t_end=1.0, t_eval=[1.0])
    assert run.provenance.parameters["h1.stiffness"] == fit.values["h1.stiffness"]
    assert not fit.notes


@pytest.mark.slow  # of the kind: tests/physics/test_fit_coverage.py
def test_errors_are_those_of_repeated_fits(design: lamc.Design) -> None:
    """Standard errors against the scatter of 30 fits."""
    fits = [lamc.fit(design, lamc.Recording(T, angles(design, seed=k)), list(TRUE)) for k in range(30)]
    for name in TRUE:
        scatter = np.std([np.log(fit.values[name]) for fit in fits], ddof=1)
        # A standard deviation of 30 numbers is known to 13 %: three times that.
        assert np.mean([fit.errors[name] for fit in fits]) == pytest.approx(scatter, rel=0.4)


def test_slopes_are_those_of_coarse_differences(design: lamc.Design) -> None:
    """Chain rule through a slanted camera, delay, gain and bias, against differences of whole predictions."""
    camera = lamc.Camera(
        ("x", "-z"), scale=lamc.Free(100.0, 900.0, start=300.0), rotation=(0.1, lamc.Free(-1, 1, 0.2), 0.3),
        origin=(lamc.Free(), 240.0),
    )  # fmt: skip
    recording = lamc.Recording(
        T,
        {"m.x": 0.0 * T, "m.y": 0.0 * T, "h1": 0.0 * T, "h2.rate": 0.0 * T},
        name="a",
        start="estimated",
        markers={"m": "link_2@(1.5 m, 0.2 m, 0.1 m)"},
        camera=camera,
        delay=(-0.02, 0.02),
        gain={"h1": (0.5, 2.0), "m.x": (0.5, 2.0)},
        bias={"h2.rate": (-1.0, 1.0)},
    )
    setting = setting_of(
        Simulators(design, None), [recording], {"h1.stiffness": None, "h2.damping": (1.0, 30.0)}, {}
    )
    from lamc.fitting.flights import Differences

    predictor = Predictor(setting, Differences())
    at = np.array([each.start for each in setting.unknowns.all])
    at[setting.unknowns.names.index("a.delay")] = 0.003
    slopes = predictor.prediction(0, at, sloped=True, fine=True).slopes
    for k, each in enumerate(setting.unknowns.all):
        step = 1e-4 * max(abs(at[k]), 0.1)
        ends = [
            predictor.prediction(0, at + s * step * np.eye(len(at))[k], sloped=False).values
            for s in (-1.0, 1.0)
        ]
        expected = (ends[1] - ends[0]) / (2.0 * step)
        error = np.max(np.abs(slopes[:, :, k] - expected), axis=0)
        size = np.max(np.abs(expected)) + 1e-12
        assert np.all(error < 1e-5 * size), each.name  # central differences miss 1e-8 times third derivatives


@pytest.mark.slow
def test_a_product_is_named_and_not_guessed(design: lamc.Design) -> None:
    both = lamc.Recording(
        T,
        {"m.x": 1e3 * angles(design)["h1"]},
        markers={"m": "link_1@(1 m, 0.5 m, 0.5 m)"},
        camera=lamc.Camera(("z", "x"), scale=lamc.Free(100.0, 2000.0, start=900.0)),
        gain={"m.x": lamc.Free(0.1, 10.0, start=1.2)},
    )
    told = lamc.fit(design, both, {"h1.damping": None}, starts=1)
    assert [str(each) for each in told.unidentifiable] == [
        "run1.m.x.gain and camera.scale: only their product"
    ]
    assert told.intervals["camera.scale"][1] == np.inf


def test_a_common_factor_is_named(design: lamc.Design) -> None:
    """Angles of a pendulum tell no scale of forces: all stiffness, damping and masses may grow together."""
    free = dict.fromkeys(
        ("h1.stiffness", "h2.stiffness", "h3.stiffness", "h1.damping", "h2.damping", "h3.damping")
    )
    masses = {f"link_{k}.{what}": None for k in (1, 2, 3) for what in ("mass", "inertia_zz")}
    fit = lamc.fit(design, lamc.Recording(T, angles(design, noise=1e-4)), {**free, **masses}, starts=1)
    names = [set(each.names) for each in fit.unidentifiable]
    assert any({"h1.stiffness", "h2.stiffness", "link_3.mass"} <= each for each in names)


def test_gaps_are_left_out(design: lamc.Design) -> None:
    values = angles(design)
    values["h2"][50:150] = np.nan
    values["h3"][::2] = np.nan
    fit = lamc.fit(design, lamc.Recording(T, values), list(TRUE))
    assert fit.setting.count == 200 + 100 + 100
    assert fit.values["h1.stiffness"] == pytest.approx(120.0, rel=0.02)  # 3 standard errors are 1 %


def test_recordings_with_starts_delays_and_biases_of_their_own(design: lamc.Design) -> None:
    first, second = angles(design), angles(design, seed=1, angles={"h1": 0.6})
    late = T + 0.007
    data = [
        lamc.Recording(late, first, name="a", delay=(-0.02, 0.02)),
        lamc.Recording(
            T, {**second, "h2": second["h2"] + 0.3}, name="b", start="estimated", bias={"h2": (-1.0, 1.0)}
        ),
    ]
    fit = lamc.fit(design, data, list(TRUE))
    assert fit.values["a.delay"] == pytest.approx(0.007, abs=0.001)
    assert fit.values["b.angles.h1"] == pytest.approx(
        angles(design, noise=0.0, angles={"h1": 0.6})["h1"][0], abs=0.02
    )
    assert fit.values["b.h2.bias"] == pytest.approx(0.3, abs=0.05)
    assert fit.values["h1.stiffness"] == pytest.approx(120.0, rel=0.02)


def test_outliers_count_less_with_a_robust_loss(design: lamc.Design) -> None:
    values = angles(design)
    rng = np.random.default_rng(5)
    for column in values.values():
        column[rng.integers(0, len(T), 10)] += 2.0
    plain = lamc.fit(design, lamc.Recording(T, values), list(TRUE), starts=1)
    robust = lamc.fit(design, lamc.Recording(T, values, sigma=NOISE), list(TRUE), loss="soft_l1")
    off = {n: [abs(np.log(f.values[n] / TRUE[n])) for f in (plain, robust)] for n in TRUE}
    assert all(r < 0.05 for _, r in off.values())
    assert sum(r for _, r in off.values()) < 0.3 * sum(p for p, _ in off.values())
    low, high = robust.intervals["h1.stiffness"]
    assert low < 120.0 < high
    assert high - low < 0.3 * np.subtract(*reversed(plain.intervals["h1.stiffness"]))


@pytest.mark.slow
def test_a_prior_holds_what_the_data_do_not_tell() -> None:
    t = np.linspace(0.0, 1.0, 101)
    scene = lamc.Scene(angles={"h": 0.3})
    q = lamc.compile(one_link(), scene).run(t_end=1.0, t_eval=t).angle("h")
    q = q + 1e-3 * np.random.default_rng(0).normal(size=len(t))
    free = {
        "h.stiffness": None,
        "gravity.z": lamc.Free(-12.0, -8.0),
        "flap.mass": "2 g ± 0.02 g",
        "flap.inertia_zz": None,
    }
    fit = lamc.fit(one_link(), lamc.Recording(t, {"h": q}), {**free, "h.damping": None}, scene, starts=1)
    assert fit.values["flap.mass"] == pytest.approx(2e-3, rel=1e-2)
    low, high = fit.intervals["flap.mass"]
    assert high - low == pytest.approx(4.0 * 2e-5, rel=0.15)  # twice 1.98 standard deviations of the prior


def test_dimensions_of_a_drawing_are_found() -> None:
    def flap(length: float = 0.02) -> lamc.Mechanism:
        """A flap that is longer: mass, centre and inertia of a thin strip."""
        m = 0.1 * length
        ground = lamc.Body(name="ground", fixed=True)
        body = lamc.Body(
            name="flap",
            mass=m,
            com=(0.0, 0.0, -0.5 * length),
            inertia=np.diag([m * length**2 / 12.0] * 2 + [1e-9]),
        )
        hinge = lamc.Joint(name="h", parent="ground", child="flap", axis=(0.0, 1.0, 0.0), stiffness=1e-3)
        return lamc.Mechanism(name="flap", bodies=(ground, body), joints=(hinge,))

    t = np.linspace(0.0, 0.5, 101)
    scene = lamc.Scene(angles={"h": 0.3})
    result = lamc.compile(flap(0.023), scene).run(t_end=0.5, t_eval=t)
    com = result.pose("flap")[0]
    recording = lamc.Recording(t, {"h": result.angle("h"), "flap.x": com[:, 0]})
    fit = lamc.fit(flap, recording, {"length": (0.015, 0.03), "h.stiffness": None}, scene)
    assert fit.values["length"] == pytest.approx(0.023, rel=1e-6)
    assert fit.dimensions == {"length": fit.values["length"]}


def test_loops_start_where_they_are_told_to() -> None:
    design = lamc.load(EXAMPLES / "four_bar.yaml")
    sim = lamc.compile(design)  # type: ignore[arg-type]
    name = next(n for n in sim.parameters if n.endswith(".damping"))
    joint = next(iter(sim.scene.angles))
    t = np.linspace(0.0, 0.3, 61)
    result = sim.run(t_end=0.3, t_eval=t, parameters={name: 2.0 * sim.parameters[name]})
    recording = lamc.Recording(t, {n: result.angle(n) for n in result.joints}, angles={joint: (-3.0, 3.0)})
    fit = lamc.fit(design, recording, [name])  # type: ignore[arg-type]
    assert fit.values[name] == pytest.approx(2.0 * sim.parameters[name], rel=1e-5)
    assert fit.values[f"run1.angles.{joint}"] == pytest.approx(sim.scene.angles[joint], abs=1e-6)


def test_residuals_that_are_no_noise_are_told(design: lamc.Design) -> None:
    values = angles(design)
    wave = {name: column + 0.03 * np.sin(8.0 * T) for name, column in values.items()}
    fit = lamc.fit(design, lamc.Recording(T, wave), list(TRUE))
    assert any("alike from row to row" in note for note in fit.notes)


def test_white_noise_is_not_taken_for_a_bad_fit() -> None:
    """A fifth of what was recorded is noise: no other start leaves less, and none is looked at."""
    t, scene = np.linspace(0.0, 2.0, 401), lamc.Scene(angles={"h": 0.1})
    q = lamc.compile(one_link(3e-3, 2e-5), scene).run(t_end=2.0, t_eval=t).angle("h")
    q = q + 0.5 * q.std() * np.random.default_rng(0).normal(size=len(t))
    fit = lamc.fit(one_link(), lamc.Recording(t, {"h": q}), ["h.stiffness", "h.damping"], scene)
    assert fit.converged
    assert fit.compared[0].share["h"] > 0.15
    assert fit.runs <= 12  # a walk and its end, where other starts took sixty and more
    assert not fit.notes


def test_degrees_in_place_of_radians_are_asked_about(design: lamc.Design) -> None:
    told = {name: np.degrees(q) for name, q in angles(design, angles={"h1": 0.8}).items()}
    fit = lamc.fit(
        design, lamc.Recording(T, told), ["h1.stiffness"], lamc.Scene(angles={"h1": 0.8}), starts=1
    )
    assert any("h1 reaches" in note and "are these degrees?" in note for note in fit.notes)


def test_each_recording_follows_its_own_command() -> None:
    def scene(series: lamc.Series) -> lamc.Scene:
        torque = lamc.Torque({"h": "2e-3*drive"})
        return lamc.Scene(added=(torque,), inputs={"drive": lamc.Input(series=series)})

    t = np.linspace(0.0, 1.0, 101)
    commands = [lamc.Series(t, np.sin(9.0 * t + k), "linear", "hold") for k in range(2)]
    sim = lamc.compile(one_link(), scene(commands[0]))
    true = {"h.stiffness": 3e-3, "h.damping": 2e-5}
    runs = [sim.run(t_end=1.0, t_eval=t, parameters=true, series={"drive": each}) for each in commands]
    data = [
        lamc.Recording(t, {"h": r.angle("h")}, series={"drive": c})
        for r, c in zip(runs, commands, strict=True)
    ]
    fit = lamc.fit(one_link(), data, list(true), scene(commands[0]))
    for name, value in true.items():
        assert fit.values[name] == pytest.approx(value, rel=1e-6)  # noise-free; runs of 1e-9 a step
    short = lamc.Recording(t, {"h": t}, series={"drive": lamc.Series([0.0, 0.5], [0.0, 1.0])})
    with pytest.raises(lamc.RequestError, match=r"'drive' ends at t = 0.5 s, before the run does at 1 s"):
        lamc.fit(one_link(), short, list(true), scene(commands[0]))
    with pytest.raises(lamc.RequestError, match=r"follows a series"):
        lamc.fit(
            one_link(),
            lamc.Recording(t, {"h": t}, series={"driv": commands[0]}),
            list(true),
            scene(commands[0]),
        )


def test_a_centre_of_mass_is_not_free_beside_points() -> None:
    t = np.linspace(0.0, 1.0, 101)
    recording = lamc.Recording(t, {"m.x": 0.0 * t}, markers={"m": "flap@(0, 0, -0.03)"})
    with pytest.raises(lamc.RequestError, match=r"'flap\.com_y' is free, and 'm\.x' is a point"):
        lamc.fit(one_link(), recording, ["flap.com_y"])


def test_stops_are_fitted_through_and_starts_beyond_them_refused() -> None:
    design = lamc.load(EXAMPLES / "limit_stop.yaml")
    sim = lamc.compile(design)  # type: ignore[arg-type]
    t = np.linspace(0.0, 1.0, 101)
    true = 1.3 * sim.parameters["flap.mass"]
    run = sim.run(t_end=1.0, t_eval=t, parameters={"flap.mass": true})
    assert len(run.events) > 3
    fit = lamc.fit(design, lamc.Recording(t, {"flap": run.angle("flap")}), ["flap.mass"])  # type: ignore[arg-type]
    assert fit.values["flap.mass"] == pytest.approx(true, rel=1e-6)  # noise-free; runs of 1e-9 a step
    with pytest.raises(lamc.DesignError, match="limit"):
        lamc.fit(design, lamc.Recording(t, {"flap": t}, angles={"flap": 3.0}), ["flap.mass"])  # type: ignore[arg-type]


def test_a_candidate_tells_what_a_fit_with_it_finds(design: lamc.Design) -> None:
    """Errors that are foretold of a column, against those of the fit with it."""
    values = angles(design, noise=0.003)
    free = list(TRUE)
    first = lamc.fit(design, lamc.Recording(T, {"h1": values["h1"]}), free)
    told = {each.name: each for each in first.candidates(["h1.rate", "h3", "h1"])}
    assert [each.shrinks for each in told.values()] == sorted(
        (each.shrinks for each in told.values()), reverse=True
    )
    # Once more halves variances of all four: 2^(4/2).
    assert told["h1"].shrinks == pytest.approx(4.0, rel=1e-6)
    both = lamc.fit(design, lamc.Recording(T, {"h1": values["h1"], "h3": values["h3"]}), free)
    for name in free:
        assert told["h3"].errors[name] == pytest.approx(
            both.errors[name], rel=0.2
        )  # noise of 200 rows, nearby values
    with pytest.raises(lamc.RequestError, match="nothing of this model"):
        first.candidates(["h9"])
