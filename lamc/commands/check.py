"""`lamc check`: compares the three voices on a design. In: a design. Out: a table; exit code 3 beyond the limits."""

from lamc.commands.inputs import SceneChanges, Source, changed_scene, load_source, mechanism_of
from lamc.commands.terminal import Terminal
from lamc.errors import LamcError, SimulationError
from lamc.pipeline import Times
from lamc.pipeline import compile as compile_design
from lamc.reference import check as compare


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
        progress.stage("compare")
        report = compare(simulator, states=states, t_end=t_end)
    terminal.say(f"{mechanism.name}: {states} random states, and a run of {t_end:g} s\n\n{report.table()}\n")
    terminal.result({"ok": report.passed, **report.to_dict()})
    failed = sum(not comparison.passed for comparison in report.comparisons)
    if failed:
        terminal.error(f"{failed} of {len(report.comparisons)} comparisons are beyond their limits")
        return SimulationError.exit_code
    terminal.say(f"all {len(report.comparisons)} comparisons are within their limits")
    return 0
