"""What `--accuracy` costs and reaches, beside a run at lamc's default tolerances, on all examples.

Prints a row for each example: the error that was asked for, the true one (against DOP853 at 1e-13), the estimate, and
the time over that of the default run. Writes benchmarks/results/accuracy.json where --json names a file.
"""

import argparse
import json
import time
from pathlib import Path

import numpy as np

import lamc
from lamc import examples
from lamc.commands.examples import mechanism_of_example
from lamc.run.outputs_error import output_errors
from lamc.run.result import Result
from lamc.run.simulator import Simulator

T_END = 2.0  # s
ROWS = np.linspace(0.0, T_END, 400)  # as `lamc run` has them
REPEATS = 3


def best(sim: Simulator, **asked: float) -> tuple[float, Result]:
    """The shortest of some runs, s, and the result."""
    times = []
    for _ in range(REPEATS):
        start = time.perf_counter()
        result = sim.run(T_END, t_eval=ROWS, **asked)  # type: ignore[arg-type]
        times.append(time.perf_counter() - start)
    return min(times), result


def row(name: str, wanted: float) -> dict[str, object]:
    """One example."""
    sim = lamc.compile(mechanism_of_example(examples.find(name)))
    sim.run(0.01)
    usual, default = best(sim)
    taken, result = best(sim, accuracy=wanted)
    exact = sim.run(T_END, 1e-13, 1e-15, result.t, "dop853", max_steps=20_000_000)
    accuracy = result.accuracy
    assert accuracy is not None
    return {
        "name": name,
        "asked": wanted,
        "true": max(output_errors(result, exact, sim.scene).values()) if exact.success else None,
        "estimate": accuracy.error,
        "integrator": accuracy.integrator,
        "runs": [[each.integrator, each.rtol, each.evaluations] for each in accuracy.runs],
        "probes": accuracy.probe_evaluations,
        "seconds": taken,
        "default_seconds": usual,
        "default_evaluations": default.stats.evaluations,
        "ratio": taken / usual,
        "evaluations": accuracy.evaluations,
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--accuracy", type=float, default=1e-3)
    parser.add_argument("--json", type=Path)
    parser.add_argument("names", nargs="*", default=examples.names())
    given = parser.parse_args()
    print(
        f"{'example':<16} {'asked':>8} {'true':>8} {'estimate':>8} {'default':>9} {'accuracy':>9} {'ratio':>6}  runs"
    )
    rows = []
    for name in given.names:
        found = row(name, given.accuracy)
        rows.append(found)
        runs = ", ".join(f"{i} {rtol:.0e}: {e:.0f}" for i, rtol, e in found["runs"])  # type: ignore[attr-defined]
        true = "-" if found["true"] is None else f"{found['true']:.1e}"
        usual, taken, ratio = found["default_seconds"], found["seconds"], found["ratio"]
        share = found["evaluations"] / found["default_evaluations"]  # type: ignore[operator]
        print(
            f"{name:<16} {given.accuracy:8.0e} {true:>8} {found['estimate']:8.1e} {1e3 * usual:7.2f}ms "  # type: ignore[operator]
            f"{1e3 * taken:7.2f}ms {ratio:6.2f} {share:6.2f}  {found['probes']:.0f}; {runs}",  # type: ignore[operator]
            flush=True,
        )
    if given.json:
        given.json.write_text(json.dumps(rows, indent=2) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
