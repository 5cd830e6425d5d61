"""`measure`: the ledger of one design in one scene.

In: a mechanism, a scene, a sweep. Out: a `Ledger`: work against precision of every integrator, the account of effects,
arithmetic, and a verdict. It prints nothing; the account compiles in a cache of its own.
"""

import platform
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Protocol

from lamc._version import __version__
from lamc.ledger import peers
from lamc.ledger.arithmetic import measure_arithmetic
from lamc.ledger.clock import Clock
from lamc.ledger.effects_account import Accounting, Setting
from lamc.ledger.making import Workshop
from lamc.ledger.precision import measure_points, observed_orders, repeat
from lamc.ledger.records import Ledger, Point, Reference, Sweep
from lamc.ledger.reference import SENSITIVE, Truth, make_reference
from lamc.ledger.verdict import cheapest, make_verdict
from lamc.mechanism.records import Mechanism
from lamc.options import CompileOptions
from lamc.pipeline import effects_of
from lamc.run.simulator import Simulator
from lamc.scene import Scene

# Shares of the budget, up to the end of each part.
_REFERENCE, _SWEEP, _EFFECTS = 0.5, 0.6, 0.9
_ONE_REFERENCE, _LEAST_REFERENCE = (
    0.1,
    0.5,
)  # of the budget, and s, that one run of it may take: nothing goes without


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
    reference takes most of the budget, the rest has another one: a reference alone tells nothing.

    Raises LamcError as `lamc.compile` does, and SimulationError where no reference can be had.
    """
    effects = effects_of(mechanism, scene)
    with tempfile.TemporaryDirectory(prefix="lamc-ledger-") as folder:
        workshop = Workshop(mechanism, options, Path(folder) if with_account else None)
        progress.stage("compile")
        simulator = workshop.make(scene).simulator
        progress.stage("reference")
        clock = whole = Clock(sweep.budget)
        truth = make_reference(simulator, sweep, clock, max(_ONE_REFERENCE * sweep.budget, _LEAST_REFERENCE))
        clock = clock if clock.left(_REFERENCE) > 0.0 else Clock(sweep.budget)
        progress.stage("work and precision")
        runners, notes = peers.make_runners(simulator, truth.result, sweep)
        measured = measure_points(runners, truth, clock, _SWEEP, progress.part)
        setting = _setting(measured.points, truth.facts, sweep)
        account = None
        if with_account:
            progress.stage("effects")
            accounting = Accounting(workshop, scene, effects, truth, sweep, clock)
            account = accounting.account(setting, _EFFECTS, progress.part)
        progress.stage("arithmetic")
        arithmetic = measure_arithmetic(workshop, scene, truth, sweep, setting, clock) if with_account else ()
        progress.stage("repeats")
        points = repeat(measured, max(clock.left(), 0.1 * sweep.budget))
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
        arithmetic=arithmetic,
        verdict=make_verdict(points, account, truth.facts, sweep),
        notes=(*_notes(truth), *notes),
        seconds=whole.spent,
        versions=_versions(simulator, truth),
    )


def _setting(points: Sequence[Point], reference: Reference, sweep: Sweep) -> Setting:
    """The cheapest setting that is accurate enough for the user, at which effects are priced."""
    point = cheapest(points, sweep.accuracy, reference.uncertainty)
    return Setting(point.integrator, point.setting) if point is not None else Setting("auto", 1e-6)


def _notes(truth: Truth) -> list[str]:
    facts, found = truth.facts, []
    if facts.sensitive_after is not None:
        found.append(
            f"a small change of the start grows {facts.growth:.1e}-fold by the end, {SENSITIVE:g}-fold by "
            f"{facts.sensitive_after:.3g} s: errors tell of the motion as much as of the integrator; "
            f"--t-end {0.99 * facts.sensitive_after:.2g} ends before"
        )
    if facts.uncertainty > 1e-6:
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
