"""The ledger: its errors against closed forms, the orders it observes, the account of effects, its verdict."""

import json
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pytest
from scipy.special import ellipj, ellipk

import lamc
from lamc import examples
from lamc.basics.errors import SimulationError
from lamc.codegen.options import CompileOptions
from lamc.commands.examples import mechanism_of_example
from lamc.ledger import Ledger, Sweep, measure, reference
from lamc.ledger.clock import Clock
from lamc.ledger.effects_account import Accounting, Setting
from lamc.ledger.making import Workshop
from lamc.ledger.outputs import errors
from lamc.ledger.precision import observed_orders, slope
from lamc.ledger.records import Account, EffectRow, Point, Reference
from lamc.ledger.reference import Truth, events_differ_after, make_reference
from lamc.ledger.runners import Trace
from lamc.ledger.schema import ledger_schema, read_ledger
from lamc.ledger.verdict import cheapest, make_verdict
from lamc.mechanics.loads import Loads
from lamc.report.ledger import draw_ledger, spread
from lamc.report.ledger_text import ledger_text
from lamc.run.run_record import Event
from tests.support.mechanisms import chain, unit_plate_pendulum
from tests.support.paths import ROOT

OWN = ("rk45", "dop853", "rodas5p", "radau5")


class Quiet:
    """Progress that nobody watches."""

    def stage(self, name: str) -> None: ...
    def part(self, done: float, total: float) -> None: ...


def rod(length: float = 1.0) -> lamc.Mechanism:
    """A rod without thickness that hangs along -z from a hinge along y, with a hinge that is faintly damped."""
    body = lamc.Body("rod", 1.0, (0.0, 0.0, -length / 2), np.diag([length**2, length**2, 0.0]) / 12)
    hinge = lamc.Joint("h", "ground", "rod", (0.0, 0.0, 0.0), (0.0, 1.0, 0.0), damping=1e-5)
    return lamc.Mechanism((lamc.Body("ground", fixed=True), body), (hinge,), name="rod")


def swing(t: np.ndarray, amplitude: float) -> np.ndarray:
    """Angle of the undamped rod let go at `amplitude`, rad: θ'' = -(3 g / 2 L) sin θ, by elliptic functions."""
    omega, k = math.sqrt(1.5 * 9.81), math.sin(amplitude / 2)
    sn, _, _, _ = ellipj(ellipk(k * k) - omega * t, k * k)
    return 2 * np.arcsin(k * np.asarray(sn))


FREE = lamc.Scene(effects=(lamc.Gravity(),), angles={"h": 1.5})
BOTH = lamc.Scene(effects=(lamc.Gravity(), lamc.HingeDamping()), angles={"h": 1.5})


def sweep_of(t_end: float, *integrators: str, **more: Any) -> Sweep:
    return Sweep(t_end=t_end, integrators=integrators, **{"budget": 20.0, **more})


def points_alone(mechanism: lamc.Mechanism, scene: lamc.Scene, sweep: Sweep) -> Ledger:
    """Without the account of effects."""
    return measure(mechanism, scene, CompileOptions(), sweep, Quiet(), with_account=False)


@pytest.fixture(scope="module")
def swinging() -> Ledger:
    """4 s of the rod, faintly damped, by every integrator that is installed."""
    return measure(
        rod(),
        BOTH,
        CompileOptions(),
        Sweep(t_end=4.0, tolerances=(1e-3, 1e-5, 1e-8, 1e-12), budget=20.0, rows=101),
        Quiet(),
    )


@pytest.fixture(scope="module")
def free() -> Ledger:
    """4 s of the rod without damping, by lamc's own integrators."""
    return points_alone(rod(), FREE, sweep_of(4.0, *OWN))


@pytest.fixture(scope="module")
def plates() -> Ledger:
    """5 s of three plates without damping."""
    mechanism, _ = unit_plate_pendulum()
    return points_alone(
        mechanism, lamc.Scene(effects=(lamc.Gravity(), lamc.HingeStiffness())), sweep_of(5.0, "dop853")
    )


def points_of(ledger: Ledger, integrator: str) -> list[Point]:
    return [p for p in ledger.points if p.integrator == integrator and p.succeeded]


# ---- errors and the reference ---------------------------------------------------------------------------------


def test_reference_is_as_exact_as_it_says() -> None:
    simulator = lamc.compile(rod(), FREE)
    truth = make_reference(simulator, Sweep(t_end=4.0), Clock(10.0), 5.0)
    exact = swing(truth.result.t, 1.5)
    found = np.abs(truth.result.angle("h") - exact).max() / np.ptp(exact)
    # 1e-13: 200 units of round-off, of some 1000 steps and of the elliptic functions
    assert found < truth.facts.uncertainty + 1e-13
    assert truth.facts.uncertainty < 1e-12  # what tolerances of 1e-13 lead one to expect of a swing


@pytest.mark.slow
def test_errors_of_the_points_are_those_against_the_closed_form(free: Ledger) -> None:
    simulator, times = lamc.compile(rod(), FREE), np.linspace(0.0, 4.0, free.sweep.rows)
    exact = swing(times, 1.5)
    for point in points_of(free, "rk45")[:5]:
        result = simulator.run(4.0, point.setting, 1e-2 * point.setting, times, "rk45")
        off = np.abs(result.angle("h") - exact) / np.ptp(exact)
        assert point.path == pytest.approx(
            off.max(), rel=1e-4
        )  # errors above 1e-7, the reference's below 1e-12
        assert point.end == pytest.approx(off[-1], rel=1e-4)
        assert point.steps == result.stats.accepted


@pytest.mark.slow
def test_energy_of_a_free_swing_drifts_less_at_tighter_tolerances(free: Ledger) -> None:
    drifts = [p.drift for p in points_of(free, "rk45") if p.drift is not None]
    assert len(drifts) == 10
    assert drifts[0] > 1e3 * drifts[-1]  # nine decades of tolerance, at least three of drift


@pytest.mark.slow
def test_damped_scene_has_no_drift_to_tell(swinging: Ledger) -> None:
    assert all(p.drift is None for p in swinging.points)


@pytest.mark.slow
def test_two_peers_that_share_no_integrator_code_agree_with_the_reference(swinging: Ledger) -> None:
    for name in ("scipy:DOP853", "scipy:LSODA"):
        tightest = points_of(swinging, name)[-1]
        assert tightest.path is not None
        assert tightest.path < 1e-9  # rtol 1e-12 over some hundred steps; LSODA loses two digits and more


def test_chaos_is_reported_and_the_horizon_is_not_shortened_in_silence() -> None:
    mechanism = chain(
        3, "parallel", seed=4
    )  # three bodies on parallel hinges, let go high: a triple pendulum
    gravity = lamc.Gravity((0.0, -9.81, 0.0))
    scene = lamc.Scene(effects=(gravity,), angles={j.name: 2.0 for j in mechanism.joints})
    ledger = points_alone(mechanism, scene, sweep_of(30.0, "rk45", tolerances=(1e-4, 1e-6)))
    assert ledger.sweep.t_end == 30.0
    assert ledger.reference.growth > 1e3
    assert any("--t-end" in note for note in ledger.notes)
    assert ledger.reference.uncertainty > 1e-12  # round-off, grown as well


def test_without_a_run_that_arrives_there_is_no_ledger() -> None:
    with pytest.raises(SimulationError, match="--t-end"):
        make_reference(lamc.compile(rod(), FREE), Sweep(t_end=1e8), Clock(0.2), 0.05)


Tried = list[tuple[str, float, float]]


@pytest.fixture
def slow_machine(monkeypatch: pytest.MonkeyPatch) -> Callable[..., Tried]:
    """Makes runs take as long as their steps say, at so many steps a second; `fails`: methods that break down at
    tolerances below the one given. What is tried is reported: method, rtol, patience."""
    trace, tried = reference.Own.trace, []

    def slow(pace: float, fails: dict[str, float]) -> Tried:
        def run(own: reference.Own, rtol: float, clock: Clock, seconds: float) -> Trace:
            tried.append((own.name, rtol, seconds))
            if rtol < fails.get(own.name, 0.0):
                return Trace(None, "the step becomes too small")
            found = trace(own, rtol, clock, 60.0)
            share = seconds * pace / (found.steps or 1)
            if share >= 1.0:
                return found
            return Trace(None, f"stopped after {seconds:g} s", reached=share * float(own.times[-1]))

        monkeypatch.setattr(reference.Own, "trace", run)
        return tried

    return slow


def off_the_swing(truth: Truth) -> float:
    exact = swing(truth.result.t, 1.5)
    return float(np.abs(truth.result.angle("h") - exact).max() / np.ptp(exact))


@pytest.mark.parametrize(("pace", "rtol", "rounds"), [(100.0, 1e-12, 2), (15.0, 1e-6, 3)])
def test_a_reference_that_takes_too_long_is_made_looser_and_for_longer(
    slow_machine: Callable[..., Tried], pace: float, rtol: float, rounds: int
) -> None:
    """The swing's 4 s take some 280 steps of dop853 at 1e-13."""
    tried = slow_machine(pace, {})
    truth = make_reference(lamc.compile(rod(), FREE), Sweep(t_end=4.0), Clock(10.0), 1.0)
    asked = sorted({(rtol, patience) for _, rtol, patience in tried})
    assert [patience for _, patience in asked] == [1.0, 2.0, 4.0, 8.0][: len(asked)]
    assert truth.facts.integrator != truth.facts.second
    assert max(truth.facts.rtol, truth.facts.second_rtol) == asked[-1][0]
    # Ten times the tolerance it was made at, of two swings; the two runs tell it themselves to within a tenth.
    assert off_the_swing(truth) < min(10.0 * asked[-1][0], 1.1 * truth.facts.uncertainty + 1e-13)


def test_methods_that_break_down_at_a_tight_tolerance_are_tried_at_a_looser_one(
    slow_machine: Callable[..., Tried],
) -> None:
    slow_machine(1e9, dict.fromkeys(OWN, 1e-11))
    truth = make_reference(lamc.compile(rod(), FREE), Sweep(t_end=4.0), Clock(10.0), 5.0)
    assert truth.facts.rtol == pytest.approx(1e-11, rel=1e-9)
    assert off_the_swing(truth) < 1e-10  # ten times its tolerance


def test_one_method_alone_is_held_against_itself_and_that_is_reported(
    slow_machine: Callable[..., Tried],
) -> None:
    slow_machine(1e9, dict.fromkeys(("rk45", "rodas5p", "radau5", "scipy:DOP853"), 1.0))
    truth = make_reference(lamc.compile(rod(), FREE), Sweep(t_end=4.0), Clock(10.0), 5.0)
    facts = truth.facts
    assert facts.is_one_method
    assert facts.integrator == facts.second == "dop853"
    assert facts.second_rtol == pytest.approx(10.0 * facts.rtol, rel=1e-9)
    assert off_the_swing(truth) < facts.uncertainty + 1e-13  # round-off, as above
    ledger = points_alone(rod(), FREE, sweep_of(4.0, "rk45", tolerances=(1e-3, 1e-6)))
    assert any("no second method arrives" in note for note in ledger.notes)
    assert "dop853 alone" in ledger_text(ledger)


@pytest.mark.slow
def test_a_slow_contact_scene_has_a_reference_and_says_its_floor(slow_machine: Callable[..., Tried]) -> None:
    """Half a second of the crawler, some 60 touches, on a machine that hardly gets through at any tolerance."""
    mechanism = mechanism_of_example(examples.find("crawler"))
    simulator = lamc.compile(mechanism, mechanism.scene)
    sweep = Sweep(t_end=0.5, budget=1.0)
    explicit = dict.fromkeys(("rodas5p", "radau5"), 1.0)  # these take longer still
    slow_machine(1e9, explicit)
    tight = make_reference(simulator, sweep, Clock(60.0), 1.0)
    slow_machine(1000.0, explicit)
    truth = make_reference(simulator, sweep, Clock(1.0), 1.0)
    assert truth.facts.rtol > 1e-11
    assert truth.facts.events == tight.facts.events > 20
    assert truth.facts.events_differ_after is None
    # What two loose runs differ by is about what the tighter of them is off by: ten times that covers both erring alike
    assert errors(truth.result, tight.result, tight.scales).path < 10.0 * truth.facts.uncertainty


def test_events_of_two_runs_are_compared_one_by_one() -> None:
    def events(**times: Sequence[float]) -> list[Event]:
        return sorted((Event(t, name) for name, ts in times.items() for t in ts), key=lambda e: e.t)

    mine = events(left=[0.1, 0.4, 0.9], right=[0.1, 0.5])
    assert events_differ_after(mine, [mine[1], mine[0], *mine[2:]], 1e-3) is None  # two at one instant
    assert events_differ_after(mine, events(left=[0.1, 0.4, 0.9001], right=[0.1, 0.5]), 1e-3) is None
    assert events_differ_after(mine, events(left=[0.1, 0.4, 0.9], right=[0.1]), 1e-3) == 0.5
    assert events_differ_after(mine, events(left=[0.1, 0.3, 0.4, 0.9], right=[0.1, 0.5]), 1e-3) == 0.3
    assert events_differ_after([], [], 1e-3) is None


# ---- interruption ---------------------------------------------------------------------------------------------


class Interrupting(Quiet):
    """Ctrl-C as a part begins, or as it tells of its second piece."""

    def __init__(self, stage: str, *, within: bool = False) -> None:
        self.at, self.within, self.now = stage, within, ""

    def stage(self, name: str) -> None:
        self.now = name
        if name == self.at and not self.within:
            raise KeyboardInterrupt

    def part(self, done: float, _total: float) -> None:
        if self.now == self.at and self.within and done >= 1.0:
            raise KeyboardInterrupt


@pytest.mark.parametrize(
    ("stage", "within"),
    [
        ("work and precision", True),
        ("effects", True),
        pytest.param("effects", False, marks=pytest.mark.slow),
        pytest.param("arithmetic", False, marks=pytest.mark.slow),
        pytest.param("repeats", False, marks=pytest.mark.campaign),
    ],
)
@pytest.mark.usefixtures("unpainted")
def test_interrupted_ledger_has_what_was_measured_and_claims_no_more(
    stage: str, within: bool, tmp_path: Path
) -> None:
    from lamc.commands.ledger import ledger_data

    sweep = sweep_of(1.0, "rk45", "dop853", tolerances=(1e-3, 1e-6))
    ledger = measure(rod(), BOTH, CompileOptions(), sweep, Interrupting(stage, within=within))
    assert ledger.interrupted == stage
    measured = [p for p in ledger.points if p.succeeded]
    assert len(ledger.points) == 4  # what was not measured has a row too, with the reason
    assert len(measured) == (1 if stage == "work and precision" else 4)
    assert all("interrupted" in p.note for p in ledger.points if not p.succeeded)
    rows = ledger.account.rows if ledger.account is not None else ()
    if stage in ("work and precision", "effects"):
        assert not any("can be left out" in line or "leaving it out" in line for line in ledger.verdict.lines)
        assert sum(row.succeeded for row in rows) == (1 if (stage, within) == ("effects", True) else 0)
    else:
        assert all(row.succeeded for row in rows)
    assert len(ledger.arithmetic) == (4 if stage == "repeats" else 0)
    assert "INCOMPLETE" in ledger_text(ledger)
    assert read_ledger(json.dumps(ledger_data(ledger), allow_nan=False)) == ledger
    assert draw_ledger(ledger, tmp_path / "ledger.png").is_file()


def test_interruption_before_there_is_a_reference_is_one(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(KeyboardInterrupt):
        measure(rod(), FREE, CompileOptions(), sweep_of(1.0, "rk45"), Interrupting("reference"))


def test_the_verdict_claims_nothing_of_effects_that_were_not_measured() -> None:
    def row(name: str, change: float | None) -> EffectRow:
        return EffectRow((name,), is_added=False, succeeded=change is not None, change=change)

    facts = Reference("dop853", 1e-13, "rk45", 1e-13, 1e-14, 1e-14, 1.0, None)

    def verdict(*rows: EffectRow) -> str:
        account = Account("rk45", 1e-3, row("", None), rows, None)
        return make_verdict((), account, facts, Sweep(t_end=1.0)).lines[-1]

    assert verdict(row("gravity", 0.5)).startswith("every effect changes the outputs")
    assert verdict(row("gravity", None)).endswith("not known of gravity")
    assert "the 1 measured" in verdict(row("gravity", 0.5), row("torque", None))


# ---- orders ---------------------------------------------------------------------------------------------------


# Step control lets steps, and with them the error's constant, vary over a swing, which bends the lines a little.
@pytest.mark.parametrize(
    ("integrator", "low", "high"), [("rk45", 4.7, 5.5), ("rodas5p", 4.4, 5.5), ("radau5", 4.6, 5.5)]
)
def test_observed_order_is_that_of_the_method(free: Ledger, integrator: str, low: float, high: float) -> None:
    (order,) = (each for each in free.orders if each.integrator == integrator)
    assert order.end is not None
    assert low < order.end < high


def test_observed_order_of_dop853_is_eight(plates: Ledger) -> None:
    """On plates: in a lone swing its steps are so long that terms beyond the leading one count."""
    (order,) = plates.orders
    assert order.path is not None
    assert 7.3 < order.path < 8.8


def test_radau5_is_of_order_four_between_its_steps(free: Ledger) -> None:
    (order,) = (each for each in free.orders if each.integrator == "radau5")
    assert order.path is not None
    assert 3.6 < order.path < 4.4  # the polynomial through three stages and the start has degree 3


def test_slope_of_a_power_law_is_its_exponent() -> None:
    assert slope([(10 * 2**k, 3.0 / 2 ** (5 * k)) for k in range(5)]) == pytest.approx(5.0, abs=1e-12)


def test_steps_that_stability_dictates_do_not_pass_for_an_order(swinging: Ledger) -> None:
    truth = make_reference(lamc.compile(rod(), FREE), Sweep(t_end=1.0, tolerances=(1e-6,)), Clock(5.0), 5.0)
    base = points_of(swinging, "rk45")[0]
    flat = [replace(base, setting=10.0**-k, steps=100 + k, end=10.0**-k, path=10.0**-k) for k in range(3, 9)]
    (order,) = observed_orders(flat, truth)
    assert order.end is None


# ---- effects --------------------------------------------------------------------------------------------------


def test_leaving_out_a_faint_damping_changes_what_it_takes_from_the_swing(swinging: Ledger) -> None:
    assert swinging.account is not None
    (row,) = (row for row in swinging.account.rows if row.effects == ("hinge_damping",))
    exact = swing(np.linspace(0.0, 4.0, swinging.sweep.rows), 1.5)
    assert row.change is not None
    assert row.discretisation is not None
    # c / (2 I) · t · amplitude is an upper bound of what a linear damper takes, and no less than a fifth stays of it
    # as a lag of phase or of amplitude: c = 1e-5 N·m·s/rad, I = 1/3 kg·m², 4 s.
    most = 1e-5 / (2 / 3) * 4.0 * 1.5 * 3.9 / np.ptp(exact)  # rates reach 3.9 rad/s per rad of angle
    assert row.discretisation < 0.1 * row.change
    assert 1e-6 < row.change < most


def test_effect_without_weight_is_reported_and_one_with_weight_is_not(swinging: Ledger) -> None:
    assert swinging.verdict.idle == ("hinge_damping",)
    assert "hinge_damping" in swinging.verdict.lines[-1]
    assert swinging.account is not None
    (gravity,) = (row for row in swinging.account.rows if row.effects == ("gravity",))
    assert gravity.change is not None
    assert gravity.change > 0.9  # at rest for ever: off by the whole range


def test_operations_of_an_effect_are_those_that_leave_with_it(swinging: Ledger) -> None:
    assert swinging.account is not None
    for row in swinging.account.rows:
        effects = tuple(e for e in BOTH.effects or () if e.name not in row.effects)
        alone = lamc.compile(rod(), replace(BOTH, effects=effects))
        assert row.operations == alone.program.functions["acceleration"].operations.flops


@pytest.mark.slow
def test_effect_that_the_design_asks_for_and_the_scene_lacks_is_tried() -> None:
    sweep = sweep_of(1.0, "rk45", tolerances=(1e-4, 1e-6))
    ledger = measure(rod(), FREE, CompileOptions(), sweep, Quiet())
    assert ledger.account is not None
    (added,) = (row for row in ledger.account.rows if row.is_added)
    assert added.effects == ("hinge_damping",)
    assert added.succeeded
    assert added.change is not None
    assert 1e-7 < added.change < 1e-4  # 1e-5 N·m·s/rad for a second


def test_scene_that_cannot_be_simulated_is_a_row_with_the_reason(tmp_path: Path) -> None:
    class Needy:
        """An effect that another one has to come with."""

        name, summary = "needy", "needs gravity"

        def contribute(self, loads: object) -> None:
            raise lamc.DesignError("needy needs gravity")

    truth = make_reference(lamc.compile(rod(), FREE), Sweep(t_end=1.0), Clock(5.0), 5.0)
    workshop = Workshop(rod(), CompileOptions(), tmp_path)
    accounting = Accounting(workshop, FREE, (lamc.Gravity(), Needy()), truth, Sweep(t_end=1.0), Clock(600.0))
    account = accounting.account(Setting("rk45", 1e-6), 1.0, lambda _done, _total: None)
    (without_gravity,) = (row for row in account.rows if row.effects == ("gravity",))
    (without_needy,) = (row for row in account.rows if row.effects == ("needy",))
    assert not without_gravity.succeeded
    assert "needy needs gravity" in without_gravity.note
    assert without_needy.succeeded
    assert without_needy.change is not None
    assert without_needy.change < 1e-9  # nothing but the integrator at 1e-10


@dataclass(frozen=True)
class Brake:
    """Damping of the rod's hinge, which can be had halved."""

    coefficient: float  # N·m·s/rad
    name: ClassVar[str] = "brake"
    summary: ClassVar[str] = "Damper beside the hinge"

    def contribute(self, loads: Loads) -> None:
        loads.hinge_torque("h", -(self.coefficient * loads.hinge("h").rate))

    def alternatives(self) -> dict[str, "Brake"]:
        return {"half as strong": Brake(0.5 * self.coefficient)}


def test_other_form_of_an_effect_is_measured_in_its_place(tmp_path: Path) -> None:
    scene = lamc.Scene(effects=(lamc.Gravity(), Brake(1e-3)), angles={"h": 0.5})
    truth = make_reference(lamc.compile(rod(), scene), Sweep(t_end=1.0), Clock(20.0), 5.0)
    workshop = Workshop(rod(), CompileOptions(), tmp_path)
    accounting = Accounting(workshop, scene, scene.effects or (), truth, Sweep(t_end=1.0), Clock(600.0))
    account = accounting.account(Setting("rk45", 1e-6), 1.0, lambda _done, _total: None)
    half, none = (
        next(r for r in account.rows if r.effects == ("brake",) and r.form == f)
        for f in ("half as strong", "")
    )
    assert half.change is not None
    assert none.change is not None
    # to first order in so faint a damping (c t / 2 I = 1.5e-3) half of it is missing: half of the change
    assert half.change == pytest.approx(0.5 * none.change, rel=1e-2)


# ---- verdict, budget, forms -----------------------------------------------------------------------------------


def test_cheapest_setting_reaches_its_target_and_none_that_reaches_it_is_quicker(swinging: Ledger) -> None:
    for each in swinging.verdict.cheapest:
        assert each.point is not None
        assert each.point.path is not None
        assert each.point.seconds is not None
        assert each.point.path <= each.target
        good = [
            p for p in swinging.points if not p.is_peer and p.path is not None and p.path < 0.99 * each.target
        ]
        assert all(p.seconds is None or p.seconds >= each.point.seconds for p in good)


def test_what_the_reference_leaves_open_counts_against_a_setting(swinging: Ledger) -> None:
    assert cheapest(swinging.points, 1e-6, uncertainty=1e-5) is None


def test_budget_that_is_spent_leaves_rows_with_the_reason() -> None:
    sweep = Sweep(t_end=100.0, budget=0.1)
    ledger = points_alone(rod(), FREE, sweep)
    left = [p for p in ledger.points if not p.succeeded]
    assert left
    assert all("left out" in p.note or "stopped" in p.note for p in left if not p.is_peer)
    names = [p.integrator for p in ledger.points]
    assert names.count("rk45") == len(sweep.tolerances)  # every setting has a row, measured or not


def test_ledger_reads_back_from_its_json_and_its_schema_names_every_part(swinging: Ledger) -> None:
    from lamc.commands.ledger import ledger_data

    text = json.dumps(ledger_data(swinging), allow_nan=False)
    assert read_ledger(text) == swinging
    schema = ledger_schema()
    assert set(schema["properties"]) == set(json.loads(text))
    with pytest.raises(lamc.LamcError, match="no ledger"):
        read_ledger("{}")


def test_tables_and_picture_have_every_integrator_and_every_effect(swinging: Ledger, tmp_path: Path) -> None:
    text = ledger_text(swinging, full=True)
    for name in (
        *OWN,
        "auto",
        "scipy DOP853",
        "scipy LSODA",
        "without gravity",
        "without hinge_damping",
        "verdict",
    ):
        assert name in text
    picture = draw_ledger(swinging, tmp_path / "ledger.png")
    assert picture.stat().st_size > 20_000  # an empty figure of this size has some 10 kB


def test_labels_that_are_spread_keep_their_order_and_their_distance() -> None:
    placed = spread([0.1, 0.11, 0.12, 0.9, 0.99, 0.995], 0.05)
    assert placed == sorted(placed)
    assert min(np.diff(placed)) > 0.0499
    assert max(placed) <= 1.0


# ---- the ledgers that are kept --------------------------------------------------------------------------------

KEPT = sorted((ROOT / "docs" / "ledgers").glob("*.json"))


@pytest.mark.parametrize("path", KEPT, ids=lambda path: path.stem)
def test_kept_ledger_has_its_picture_and_the_slopes_of_theory(path: Path) -> None:
    ledger = read_ledger(path.read_text(encoding="utf-8"))
    assert path.with_suffix(".png").is_file()
    reported = [
        o for o in ledger.orders if o.integrator in OWN and o.path is not None and o.path_theory is not None
    ]
    assert len(reported) >= 3
    for order in reported:
        assert order.path is not None
        assert order.path_theory is not None
        # one order: where steps are long, terms beyond the leading one count, and they make lines steeper
        assert abs(order.path - order.path_theory) < 1.0, order


def test_every_design_of_the_list_is_kept() -> None:
    assert {path.stem for path in KEPT} >= {"triple_pendulum", "four_bar", "miura", "stiff_triple"}


def test_peers_that_do_not_project_show_by_how_far_loops_come_apart() -> None:
    """scipy's DOP853 integrates accelerations that keep the loop closed: its errors fall with the tolerance as its own
    do, down to 1e-9 of the range, and the gap falls with them. lamc's run projects, so that its gap is round-off."""
    mechanism = mechanism_of_example(examples.find("four_bar"))
    sweep = sweep_of(1.0, "dop853", "scipy:DOP853", tolerances=(1e-4, 1e-7, 1e-10), rows=11)
    ledger = points_alone(mechanism, mechanism.scene or lamc.Scene(), sweep)
    scipys = points_of(ledger, "scipy:DOP853")
    errors_of, gaps = [p.path or 0.0 for p in scipys], [p.closure or 0.0 for p in scipys]
    assert len(scipys) == 3
    assert errors_of[0] > 10.0 * errors_of[1] > 100.0 * errors_of[2]
    assert errors_of[2] < 1e-9
    assert gaps[0] > 10.0 * gaps[2] > 0.0
    assert all((p.closure or 0.0) < 1e-13 for p in points_of(ledger, "dop853"))
    assert any("accelerations alone in scipy" in note for note in ledger.notes)
