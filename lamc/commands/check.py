"""`lamc check`: compares the three cross-checks on a design. In: a design. Out: a table; exit code 3 beyond the
limits."""

import time
from collections.abc import Callable

from lamc.basics.errors import LamcError, SimulationError
from lamc.basics.times import Times
from lamc.commands.inputs import SceneChanges, Source, changed_scene, load_source, mechanism_of
from lamc.commands.terminal import Progress, Terminal
from lamc.pipeline import compile as compile_design
from lamc.reference import check as compare

_EVERY = 0.1  # s between two fractions of a stage


def check(source: Source, changes: SceneChanges, states: int, t_end: float, terminal: Terminal) -> int:
    """Prints the largest differences. Returns 0 if all are within their limits, else 3."""
    if states < 1 or not 0.0 < t_end < float("inf"):
        raise LamcError(f"--states is {states} and --t-end {t_end:g} s; both must be above zero")
    times = Times()
    with terminal.progress() as progress:
        times.observer = progress.stage
        loaded = load_source(source, times, progress)
        mechanism = mechanism_of(loaded, times, progress)
        scene, _ = changed_scene(mechanism, changes)
        simulator = compile_design(mechanism, scene, source.options, times)
        report = compare(simulator, states=states, t_end=t_end, progress=_reporter(progress))
    terminal.say(f"{mechanism.name}: {states} random states, and a run of {t_end:g} s\n\n{report.table()}\n")
    terminal.result({"ok": report.passed, **report.to_dict()})
    failed = sum(comparison.failed for comparison in report.comparisons)
    compared = sum(comparison.compared for comparison in report.comparisons)
    if failed:
        terminal.error(f"{failed} of {compared} comparisons are beyond their limits")
        return SimulationError.exit_code
    missed = len(report.comparisons) - compared
    rest = f"; {missed} could not be compared" if missed else ""
    terminal.say(f"all {compared} comparisons are within their limits{rest}")
    return 0


def _reporter(progress: Progress) -> Callable[[str, float], None]:
    """Passes stages on when they change, and fractions a few times a second."""
    stage, reported_at = "", 0.0

    def tell(name: str, fraction: float) -> None:
        nonlocal stage, reported_at
        now = time.monotonic()
        if name != stage:
            stage, reported_at = name, now
            progress.stage(name)
        elif now - reported_at >= _EVERY:
            reported_at = now
            progress.part(fraction, 1.0)

    return tell
