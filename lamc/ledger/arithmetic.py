"""Arithmetic: the same equations compiled in other ways, what they gain and how exact they still are.

In: a workshop, the scene, a list of compile options by name. Out: an `ArithmeticRow` each.
"""

from collections.abc import Sequence
from dataclasses import replace

from lamc.basics.errors import LamcError
from lamc.codegen.options import CompileOptions
from lamc.ledger.clock import Clock, processor_seconds, shortest
from lamc.ledger.effects_account import Setting
from lamc.ledger.making import Workshop, end_run, evaluation_ns
from lamc.ledger.outputs import errors
from lamc.ledger.records import ArithmeticRow, Sweep
from lamc.ledger.reference import Truth
from lamc.ledger.runners import Own, grid
from lamc.records.scene import Scene

_TOLERANCES = (1e-4, 1e-6, 1e-8, 1e-10, 1e-12)  # at which the floor is looked for
_OF_FLOATS = (
    4  # of them: below 1e-10, steps with the round-off of single precision are tried in vain, for minutes
)
_REPEATS = 0.3  # s


def variants(options: CompileOptions) -> tuple[tuple[str, CompileOptions], ...]:
    """The ways to compile that are compared, by name; the ordinary one first."""
    plain = replace(options, fast=False, precision="double")
    return (
        ("double", plain),
        ("fast", replace(plain, fast=True)),
        ("float", replace(plain, precision="float")),
        ("fast float", replace(plain, fast=True, precision="float")),
    )


def measure_arithmetic(
    workshop: Workshop,
    scene: Scene,
    truth: Truth,
    sweep: Sweep,
    setting: Setting,
    clock: Clock,
    rows: list[ArithmeticRow],
) -> None:
    """A row for each variant, the times of their runs taken in turns. rows: empty, grows by what is measured."""
    jobs, able = [], []
    for name, options in variants(workshop.options):
        row = ArithmeticRow(name, options.flags, succeeded=False)
        if clock.left() <= 0.0:
            rows.append(replace(row, note="left out: the budget is spent"))
            continue
        try:
            made = workshop.make(scene, options)
        except LamcError as error:
            rows.append(replace(row, note=error.message))
            continue
        runner = Own(truth.facts.integrator, made.simulator, grid(sweep.t_end, sweep.rows), ())
        tolerances = _TOLERANCES[:_OF_FLOATS] if options.precision == "float" else _TOLERANCES
        floors = _floors(runner, truth, clock, tolerances)
        job = end_run(made.simulator, sweep.t_end, setting.rtol, setting.integrator)
        ended = job()
        if not floors or not ended.success:
            rows.append(replace(row, note=ended.message if floors else "no tolerance reaches the end"))
            continue
        floor, rtol = min(floors)
        able.append(len(rows))
        jobs.append(job)
        evaluation = evaluation_ns(runner.trace(_TOLERANCES[0], clock, clock.left() + 1.0).result or ended)
        rows.append(replace(row, succeeded=True, evaluation=evaluation, floor=floor, floor_rtol=rtol))
    first = [processor_seconds(job) for job in jobs]
    times = shortest(jobs, first, max(_REPEATS, 5.0 * sum(first)))
    for k, (best, _) in zip(able, times, strict=True):
        rows[k] = replace(rows[k], seconds=best)


def _floors(
    runner: Own, truth: Truth, clock: Clock, tolerances: Sequence[float]
) -> Sequence[tuple[float, float]]:
    """Path errors with the tolerances that gave them."""
    found = []
    for rtol in tolerances:
        result = runner.trace(rtol, clock, max(clock.left(), 0.5)).result
        if result is not None:
            found.append((errors(result, truth.result, truth.scales).path, rtol))
    return found
