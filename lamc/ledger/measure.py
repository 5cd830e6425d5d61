"""`measure`: the ledger of one design in one scene.

In: a mechanism, a scene, a sweep. Out: a `Ledger`: work against precision of every integrator, the account of effects,
arithmetic, and a verdict. It prints nothing; the account compiles in a cache of its own.
"""

import platform
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Protocol

from lamc.basics._version import __version__
from lamc.codegen.options import CompileOptions
from lamc.ledger import peers
from lamc.ledger.arithmetic import measure_arithmetic
from lamc.ledger.clock import Clock
from lamc.ledger.effects_account import Accounting, Setting
from lamc.ledger.making import Workshop
from lamc.ledger.precision import Measured, in_order, measure_points, observed_orders, repeat
from lamc.ledger.records import Account, ArithmeticRow, Ledger, Sweep
from lamc.ledger.reference import SENSITIVE, Truth, make_reference
from lamc.ledger.verdict import cheapest, make_verdict
from lamc.pipeline import effects_of
from lamc.records.effect import Effect
from lamc.records.mechanism import Mechanism
from lamc.records.scene import Scene
from lamc.run.simulator import Simulator

# Shares of the budget, up to the end of each part.
_REFERENCE, _SWEEP, _EFFECTS = 0.5, 0.6, 0.9
_ONE_REFERENCE, _LEAST_REFERENCE = (
    0.1,
    0.5,
)  # of the budget, and s, that one run of it may take: nothing goes without
_WIDE_FLOOR = 1e-6  # relative: a floor above this is worth a word


class Progress(Protocol):
    """Told what is being done, and how far it is."""

    def stage(self, name: str) -> None: ...
    def part(self, done: float, total: float) -> None: ...


def measure(
    mechanism: Mechanism,
    scene: Scene,
    options: CompileOptions,
    sweep: Sweep,
    progress: Progress,
    *,
    with_account: bool = True,
) -> Ledger:
    """Measures everything within the sweep's budget, but for compiling and one run of each thing. Where making the
    reference takes most of the budget, the rest has another one: a reference alone tells nothing. Ctrl-C ends it with
    what there is (`Ledger.interrupted`).

    Raises LamcError as `lamc.compile` does, SimulationError where no reference can be had, and KeyboardInterrupt on
    Ctrl-C before there is one.
    """
    effects = effects_of(mechanism, scene)
    with tempfile.TemporaryDirectory(prefix="lamc-ledger-") as folder:
        workshop = Workshop(mechanism, options, Path(folder) if with_account else None)
        progress.stage("compile")
        simulator = workshop.make(scene).simulator
        progress.stage("reference")
        clock = Clock(sweep.budget)
        truth = make_reference(simulator, sweep, clock, max(_ONE_REFERENCE * sweep.budget, _LEAST_REFERENCE))
        work = _Work(workshop, scene, effects, simulator, truth, sweep, progress)
        work.do(clock, with_account=with_account)
        points = in_order(work.points)
        account = work.account
    return Ledger(
        design=mechanism.name,
        digest=truth.result.provenance.digest,
        effects=tuple(effect.name for effect in effects),
        sweep=sweep,
        outputs=truth.scales.outputs,
        rate_scales=dict(truth.scales.rates),
        reference=truth.facts,
        points=points,
        orders=observed_orders(points, truth),
        account=account,
        arithmetic=tuple(work.arithmetic),
        verdict=make_verdict(points, account, truth.facts, sweep),
        notes=(*_notes(truth), *work.notes),
        seconds=clock.spent,
        versions=_versions(simulator, truth),
        interrupted=work.interrupted,
    )


class _Work:
    """All that is measured against a reference, part after part, with what there is of it at any time."""

    def __init__(
        self,
        workshop: Workshop,
        scene: Scene,
        effects: Sequence[Effect],
        simulator: Simulator,
        truth: Truth,
        sweep: Sweep,
        progress: Progress,
    ) -> None:
        self._workshop, self._scene, self._effects = workshop, scene, effects
        self._simulator, self._truth, self._sweep, self._progress = simulator, truth, sweep, progress
        self._accounting: Accounting | None = None
        self._setting = Setting("auto", 1e-6)
        self._stage = ""
        self.points: list[Measured] = []
        self.arithmetic: list[ArithmeticRow] = []
        self.notes: list[str] = []
        self.interrupted = ""  # the part that Ctrl-C ended

    @property
    def account(self) -> Account | None:
        """The account of effects, as far as it is."""
        return None if self._accounting is None else self._accounting.so_far(self._setting)

    def do(self, clock: Clock, *, with_account: bool) -> None:
        """Measures until all is done, the budget is spent, or Ctrl-C."""
        try:
            self._measure(
                clock if clock.left(_REFERENCE) > 0.0 else Clock(self._sweep.budget),
                with_account=with_account,
            )
        except KeyboardInterrupt:
            self.interrupted = self._stage

    def _measure(self, clock: Clock, *, with_account: bool) -> None:
        self._begin("work and precision")
        runners, self.notes = peers.make_runners(self._simulator, self._truth.result, self._sweep)
        measure_points(runners, self._truth, clock, _SWEEP, self._progress.part, self.points)
        self._setting = self._priced()
        if with_account:
            self._begin("effects")
            self._accounting = Accounting(
                self._workshop, self._scene, self._effects, self._truth, self._sweep, clock
            )
            self._accounting.account(self._setting, _EFFECTS, self._progress.part)
            self._begin("arithmetic")
            measure_arithmetic(
                self._workshop, self._scene, self._truth, self._sweep, self._setting, clock, self.arithmetic
            )
        self._begin("repeats")
        repeat(self.points, max(clock.left(), 0.1 * self._sweep.budget))

    def _begin(self, stage: str) -> None:
        self._stage = stage
        self._progress.stage(stage)

    def _priced(self) -> Setting:
        """The cheapest setting that is accurate enough for the user, at which effects are priced."""
        points = [each.point for each in self.points]
        point = cheapest(points, self._sweep.accuracy, self._truth.facts.uncertainty)
        return Setting(point.integrator, point.setting) if point is not None else self._setting


def _notes(truth: Truth) -> list[str]:
    facts, found = truth.facts, []
    if facts.is_one_method:
        found.append(
            f"no second method arrives: {facts.integrator} is held against itself at a looser tolerance, and what it "
            "does wrong at every tolerance goes unseen; raise --budget or shorten it with --t-end"
        )
    if facts.events_differ_after is not None:
        found.append(
            f"the two runs of the reference have other events after {facts.events_differ_after:.3g} s: what touches, "
            "and when, is decided by their errors from there on"
        )
    if facts.growth is None:
        found.append(
            "how a small change of the start grows is not known: it takes more than its part of the budget"
        )
    if facts.sensitive_after is not None:
        found.append(
            f"a small change of the start grows {facts.growth:.1e}-fold by the end, {SENSITIVE:g}-fold by "
            f"{facts.sensitive_after:.3g} s: errors tell of the motion as much as of the integrator; "
            f"--t-end {0.99 * facts.sensitive_after:.2g} ends before"
        )
    if facts.uncertainty > _WIDE_FLOOR:
        found.append(
            f"the two best runs differ by {facts.uncertainty:.1e}: errors below that are not told apart"
        )
    return found


def _versions(simulator: Simulator, truth: Truth) -> dict[str, str]:
    provenance = truth.result.provenance
    return {
        "lamc": __version__,
        "compiler": provenance.compiler,
        "flags": " ".join(provenance.flags),
        "machine": platform.machine(),
        "processor": _processor(),
        "python": platform.python_version(),
        **peers.versions(),
    }


def _processor() -> str:
    """The processor's name where the system tells it."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        return platform.processor()
    return next((line.partition(":")[2].strip() for line in lines if line.startswith("model name")), "")
