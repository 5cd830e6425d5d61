"""Runs to an accuracy: the error is estimated honestly, the integrator is chosen by its work, what cannot be is
reported.

True errors come from closed forms, from a reference made elsewhere, and on the gallery from runs at the tightest
tolerance there is by another method than the one that was judged, where another one is exact enough.
"""

import json
import math
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner
from scipy.special import ellipj

import lamc
from lamc import examples
from lamc.basics.errors import RequestError
from lamc.cli import main
from lamc.commands.examples import mechanism_of_example
from lamc.run.accuracy_ladder import power
from lamc.run.outputs_error import output_errors
from lamc.run.request import Status
from lamc.run.result import Result
from lamc.run.simulator import Simulator
from tests.physics.test_integrators import WEIGHT, triple

HONEST = 10.0  # the factor within which an estimate is promised to lie
REFERENCE = 3e-12  # relative: what runs at 1e-13 differ by among themselves on the gallery, over 10 s
STIFF = {"knee.stiffness": 981_000.0, "ankle.stiffness": 981_000.0}  # N·m/rad: k / (m g L) some 1e7


def simulator(name: str) -> Simulator:
    return lamc.compile(mechanism_of_example(examples.find(name)))


def true_error(sim: Simulator, result: Result) -> float:
    """Largest relative error of any output, against DOP853 at the tightest tolerance."""
    end = float(result.t[-1])
    exact = sim.run(end, 1e-13, 1e-15, result.t, "dop853", max_steps=20_000_000)
    assert exact.success, exact.message
    return max(output_errors(result, exact, sim.scene).values())


def check_honest(sim: Simulator, result: Result, wanted: float) -> None:
    assert caution(sim, result, wanted) <= HONEST


def caution(sim: Simulator, result: Result, wanted: float) -> float:
    """The estimate over the true error, which it may not fall below by more than promised."""
    assert result.success, result.message
    assert result.error_estimate is not None
    true = true_error(sim, result)
    assert true <= wanted
    assert result.error_estimate <= wanted
    assert true <= HONEST * result.error_estimate + REFERENCE
    return result.error_estimate / (true + REFERENCE)


# ---- honesty -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", examples.names())
@pytest.mark.quick("five_bar", "flaps", "four_bar", "limit_stop", "pendulum", "pendulum.cad", "vertex")
@pytest.mark.ci(
    "[!cfrwy]*", "five_bar", "flaps", "four_bar", "waterbomb"
)  # up to a minute for others' references
def test_errors_of_the_gallery_are_what_is_estimated(name: str) -> None:
    sim = simulator(name)
    cautions = [caution(sim, sim.run(2.0, accuracy=wanted), wanted) for wanted in (1e-2, 1e-3, 1e-6)]
    # At some tolerance between two others the error changes its sign, and is less than any tolerance says. Two runs
    # bear out the first two accuracies, and tell what the looser is off by, however exact the other happens to be.
    assert sorted(cautions)[-2] <= HONEST
    assert cautions[-1] <= HONEST**2


def test_a_start_that_is_over_in_some_rows_is_compared_there() -> None:
    """The box snaps within 0.1 s of 10, and errs most then: a tenth of the rows, evenly, tell a fiftieth of it."""
    sim = simulator("folding_box")
    check_honest(sim, sim.run(10.0, accuracy=1e-3), 1e-3)


@pytest.mark.campaign
@pytest.mark.parametrize("name", examples.names())
@pytest.mark.parametrize("wanted", [1e-3, 1e-6, 1e-8])
def test_errors_of_long_runs_are_what_is_estimated(name: str, wanted: float) -> None:
    sim = simulator(name)
    check_honest(sim, sim.run(10.0, accuracy=wanted), wanted)


@pytest.mark.parametrize("wanted", [1e-2, 1e-4, 1e-6, 1e-8, 1e-10])
def test_a_plate_swings_as_jacobis_functions_say(wanted: float) -> None:
    """Pendulum equation θ'' = -w² sin θ from rest at a: sin(θ/2) = sin(a/2) cd(w t, sin²(a/2))."""
    inertia = np.diag([1e-4, 1e-6, 1e-4])
    plate = lamc.Body("plate", 0.1, (0.0, -0.1, 0.0), inertia)
    hinge = lamc.Joint("h", "ground", "plate", axis=(0.0, 0.0, 1.0))
    amplitude = 2.0
    scene = lamc.Scene(effects=(lamc.Gravity((0.0, -9.81, 0.0)),), angles={"h": amplitude})
    sim = lamc.compile(lamc.Mechanism((lamc.Body("ground", fixed=True), plate), (hinge,)), scene)
    result = sim.run(5.0, accuracy=wanted)
    at_rest = float(sim.acceleration([amplitude], [0.0])[0])
    w = math.sqrt(-at_rest / math.sin(amplitude))
    modulus = math.sin(amplitude / 2) ** 2
    _, cn, dn, _ = ellipj(w * result.t, modulus)
    exact = 2.0 * np.arcsin(math.sin(amplitude / 2) * cn / dn)
    true = float(np.abs(result.angle("h") - exact).max()) / (2.0 * amplitude)
    assert result.error_estimate is not None
    assert true <= wanted
    assert true / HONEST <= result.error_estimate + 1e-13  # ellipj has 14 digits or so
    assert result.error_estimate <= HONEST * (true + 1e-13)


@pytest.mark.slow
def test_estimates_hold_where_steps_pass_over_fast_motion() -> None:
    """Hinges of k / (m g L) = 1e7 keep three rods straight but for some 1e-7 rad, so that they swing as one."""
    sim = simulator("stiff_triple")
    result = sim.run(0.5, accuracy=1e-4, parameters=STIFF)
    exact = sim.run(0.5, 1e-7, 1e-9, result.t, "radau5", STIFF, max_steps=20_000_000)
    true = max(output_errors(result, exact, sim.scene).values())
    assert result.error_estimate is not None
    assert true / HONEST <= result.error_estimate <= 1e-4


# ---- chaos and obstacles -----------------------------------------------------------------------------------


@pytest.fixture(scope="session")
def chaotic() -> Simulator:
    """A triple pendulum that goes over the top."""
    sim = triple(0.0)
    return lamc.compile(sim.mechanism, replace(sim.scene, angles={"j0": 3.0, "j1": 0.5}))


def test_a_chaotic_run_says_what_was_reached(chaotic: Simulator) -> None:
    """After 60 s a start that differs by round-off ends anywhere: no tolerance can help."""
    result = chaotic.run(60.0, accuracy=1e-3)
    assert result.success  # the run reached its end, and is one of those that might be
    assert result.error_estimate is not None
    assert result.error_estimate > 0.05
    assert result.accuracy is not None
    assert not result.accuracy.reached
    assert "an accuracy of 0.001 was not reached" in result.message


def test_a_chaotic_run_that_ends_in_time_is_known(chaotic: Simulator) -> None:
    """Small changes grow a thousandfold until then, and more at loose tolerances than at tight ones: errors fall faster
    than the tolerance, and the estimate, which does not count on that, may be far on the safe side."""
    result = chaotic.run(1.5, accuracy=1e-4)
    true = true_error(chaotic, result)
    assert result.error_estimate is not None
    assert true / HONEST <= result.error_estimate <= 1e-4
    assert true <= 1e-4


def test_a_run_of_too_few_steps_is_reported(chaotic: Simulator) -> None:
    result = chaotic.run(60.0, accuracy=1e-3, max_steps=50)
    assert result.status == Status.STEP_LIMIT
    assert result.accuracy is not None
    assert not result.accuracy.reached
    assert "was not reached" in result.message


def test_interruption_keeps_what_there_is() -> None:
    calls = 0

    def interrupt(t: float, _end: float) -> None:
        nonlocal calls
        calls += 1
        if calls > 3:
            raise KeyboardInterrupt

    result = simulator("shutter").run(50.0, accuracy=1e-9, progress=interrupt)
    assert result.status == Status.CANCELLED
    assert result.accuracy is not None
    assert not result.accuracy.reached


# ---- the choice --------------------------------------------------------------------------------------------


def test_stiff_hinges_get_an_implicit_method_and_few_steps() -> None:
    sim = simulator("stiff_triple")
    result = sim.run(2.0, accuracy=1e-3, parameters=STIFF)
    assert result.accuracy is not None
    assert {"rodas5p", "radau5"} & set(result.stats.integrator.split(", "))
    assert result.accuracy.reached
    # Stability of explicit steps: 3.3 / (the fastest mode's rate), some 1e6 of them for these 2 s.
    assert result.accuracy.evaluations < 1e5


def test_probes_see_where_an_implicit_method_pays() -> None:
    """A long stiff run: the probes themselves measure that explicit steps cost more than they bring."""
    sim = triple(1e5 * WEIGHT, damping=1e-2)
    result = sim.run(40.0, accuracy=1e-4)
    assert result.accuracy is not None
    tried = result.accuracy.candidates
    assert set(tried) == {"rk45", "dop853", "rodas5p", "radau5"}
    assert min(tried, key=lambda name: tried[name]) == result.accuracy.integrator
    assert result.accuracy.integrator in ("rodas5p", "radau5")


@pytest.mark.parametrize("wanted", [1e-3, 1e-8])
def test_probes_take_the_method_that_does_with_less(wanted: float) -> None:
    """Against runs of both explicit methods to the same error: the choice costs at most a third more than the other."""
    sim = triple(0.0)
    chosen = sim.run(40.0, accuracy=wanted).accuracy
    assert chosen is not None
    costs = {}
    for name in ("rk45", "dop853"):
        facts = sim.run(40.0, accuracy=wanted, integrator=name).accuracy
        assert facts is not None
        order = 5.0 if name == "rk45" else 8.0
        last = next(rung.evaluations for rung in facts.runs if rung.rtol == facts.rtol)
        costs[name] = last * (facts.error / wanted) ** (1.0 / order)
    assert costs[chosen.integrator] <= 1.33 * min(costs.values())


@pytest.mark.parametrize("name", ["five_bar", "shutter", "stiff_triple", "two_loops", "pendulum"])
@pytest.mark.quick("five_bar", "two_loops", "pendulum")
def test_probes_and_all_runs_cost_a_bounded_multiple(name: str) -> None:
    """Evaluations, not seconds: what one run at the final tolerance takes is the unit."""
    sim = simulator(name)
    for wanted in (1e-3, 1e-6):
        facts = sim.run(10.0, accuracy=wanted).accuracy
        assert facts is not None
        last = next(rung.evaluations for rung in facts.runs if rung.rtol == facts.rtol)
        assert facts.probe_evaluations <= 0.75 * last
        # Tolerances 10 apart cost 10^(1/8) apart at order 8: five of them take less than five, and the rough run.
        assert facts.evaluations <= 5.5 * last
        assert facts.evaluations == pytest.approx(
            facts.probe_evaluations + sum(rung.evaluations for rung in facts.runs)
        )


@pytest.mark.parametrize(
    "name", ["five_bar", "flaps", "four_bar", "limit_stop", "miura", "pendulum", "vertex"]
)
def test_a_thousandth_takes_fewer_evaluations_than_the_default_and_is_not_far_below(name: str) -> None:
    """All examples: `python -m benchmarks.accuracy`. Damped motion may be far better than was asked: the loosest run
    that lamc starts with is that good."""
    sim = simulator(name)
    facts = sim.run(2.0, accuracy=1e-3).accuracy
    assert facts is not None
    assert facts.reached
    assert facts.evaluations < sim.run(2.0).stats.evaluations
    assert facts.rtol <= 1e-3  # and no looser run is the result
    assert max(rung.rtol for rung in facts.runs) <= 1e-2


def test_the_integrator_can_be_named() -> None:
    result = triple(0.0).run(2.0, accuracy=1e-5, integrator="radau5")
    assert result.accuracy is not None
    assert result.accuracy.candidates == {}
    assert result.stats.integrator == "radau5"
    check_honest(triple(0.0), result, 1e-5)


# ---- the estimate ------------------------------------------------------------------------------------------


@pytest.mark.parametrize("k", [0.5, 0.9, 1.0, 1.2])
@pytest.mark.parametrize(("a", "b", "c"), [(1e-3, 1e-4, 1e-5), (1e-4, 3e-6, 2e-9)])
def test_the_power_of_errors_is_found(k: float, a: float, b: float, c: float) -> None:
    found = power(a, b, c, a**k - c**k, b**k - c**k)
    assert found == pytest.approx(k, abs=1e-3)  # the interval that is halved until then


def test_errors_that_do_not_follow_the_tolerance_have_no_power() -> None:
    assert power(1e-3, 1e-4, 1e-5, 1.0, 0.9) is None
    assert power(1e-3, 1e-4, 1e-5, 0.0, 0.0) == 1.0


# ---- rows and refusals -------------------------------------------------------------------------------------


def test_rows_lie_where_they_were_asked_for() -> None:
    sim = triple(0.0)
    times = [0.1, 0.25, 1.9]
    assert sim.run(2.0, accuracy=1e-4, t_eval=times).t.tolist() == times
    even = sim.run(2.0, accuracy=1e-4)
    np.testing.assert_array_equal(even.t, np.linspace(0.0, 2.0, 1001))
    again = sim.run(2.0, accuracy=1e-4)
    np.testing.assert_array_equal(even.q, again.q)
    assert even.error_estimate == again.error_estimate


def test_nothing_that_happens_has_no_error() -> None:
    result = triple(0.0).run(0.0, accuracy=1e-3)
    assert result.error_estimate == 0.0
    assert len(result.t) == 1


def test_a_run_at_a_tolerance_has_no_estimate() -> None:
    result = triple(0.0).run(1.0)
    assert result.error_estimate is None
    assert result.accuracy is None
    assert (result.stats.rtol, result.stats.atol) == (1e-9, 1e-11)


def test_energy_balance_go_with_an_accuracy() -> None:
    result = triple(0.0).run(1.0, accuracy=1e-6, energy_balance=True, t_eval=[0.0, 0.5, 1.0])
    assert result.work["gravity"].shape == (3,)
    assert result.energy_balance.balance < 1e-5  # the accuracy that was asked for, times a few


@pytest.mark.parametrize(
    ("arguments", "reported"),
    [
        (
            {"rtol": 1e-6},
            "rtol is 1e-06 and accuracy is 0.001; accuracy finds the tolerances: leave rtol out",
        ),
        ({"atol": 1e-6}, "leave atol out"),
        ({"accuracy": 0.0}, "accuracy is 0.0; it must be an error relative to the range"),
        ({"accuracy": 1e-15}, "between 1e-11 and 0.5"),
        ({"accuracy": 0.7}, "between 1e-11 and 0.5"),
        ({"accuracy": math.nan}, "accuracy is nan; it must be finite"),
        ({"accuracy": "fine"}, "accuracy is 'fine'; it must be a number"),
        ({"accuracy": True}, "accuracy is True"),
        ({"integrator": "euler"}, "no integrator is named 'euler'"),
    ],
)
def test_what_is_no_accuracy_is_refused(arguments: Mapping[str, Any], reported: str) -> None:
    with pytest.raises(RequestError, match=reported):
        triple(0.0).run(1.0, **{"accuracy": 1e-3, **arguments})


@pytest.mark.slow
def test_the_command_tells_error_choice_and_cost(tmp_path: Path) -> None:
    words = ["run", "--example", "two_loops", "--t-end", "1", "--accuracy", "0.1 %"]
    done = CliRunner().invoke(main, [*words, "--out", str(tmp_path)], standalone_mode=False)
    assert done.return_value == 0, done.output
    assert "of the outputs' range, 0.001 asked for" in done.stdout
    assert "runs and probes took" in done.stdout
    manifest = json.loads((tmp_path / "manifest.json").read_text(encoding="utf-8"))
    assert manifest["error_estimate"] <= 1e-3
    assert manifest["accuracy"]["reached"] is True
    done = CliRunner().invoke(main, [*words, "--rtol", "1e-6", "--out", str(tmp_path)], standalone_mode=False)
    assert done.return_value == 2
    assert "leave rtol out" in done.stderr
    done = CliRunner().invoke(main, [*words[:5], "--accuracy", "much"], standalone_mode=False)
    assert done.return_value == 2
    assert "--accuracy 'much' is no number" in done.stderr


@pytest.mark.slow
def test_an_accuracy_that_is_not_reached_is_reported_and_no_failure(tmp_path: Path) -> None:
    """Single precision leaves errors of some 1e-8 of an angle: 1e-10 is out of reach, and all else is there."""
    words = ["run", "--example", "pendulum", "--t-end", "1", "--accuracy", "1e-10", "--precision", "float"]
    done = CliRunner().invoke(
        main,
        [*words, "--max-steps", "20000", "--out", str(tmp_path)],
        standalone_mode=False,
    )
    assert done.return_value == 0, done.output
    assert "NOT REACHED" in done.stdout
    manifest = json.loads((tmp_path / "manifest.json").read_text(encoding="utf-8"))
    assert manifest["accuracy"]["reached"] is False
    assert "-DLAMC_FLOAT" in manifest["flags"]
