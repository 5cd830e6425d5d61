"""What a hand-written simulator and a general tool take for the same precision: the triple pendulum of the paper.

    python -m benchmarks.precision [--quick] [--out FOLDER]

Peers in the same run: C written by hand for three equal links (closed form, DOPRI5; as textbooks print it, and tuned),
with the flags of lamc's modules and, beside lamc's `fast` modules, with theirs; and CasADi with CVODES, its best of
four ways. Everyone is run at many tolerances; the error is the largest of any hinge angle at ten times, rad, against
lamc's DOP853 at 1e-13, and the time for an error of 1e-6 and of 1e-9 is read off each curve. Times are processor time
of a whole run of 10 s, the shortest of repeats that take turns; lamc's include the call from Python. Prints tables and
writes JSON.
"""

import argparse
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

import lamc
from benchmarks.devices import SCENE, plates
from benchmarks.measure import environment, write_json
from benchmarks.peers.closed_triple import FLAGS, ClosedTriple
from benchmarks.spine import fresh_folder, show, target
from lamc.ledger.clock import processor_seconds, shortest

try:
    from benchmarks.peers import casadi_peer
except ImportError:  # the bench extra is not installed; its rows are left out
    casadi_peer = None  # type: ignore[assignment]

Array = npt.NDArray[np.float64]
Rows = list[dict[str, Any]]

T_END = 10.0  # s
TIMES = np.array([0.25, 0.5, 0.75, 1.0, 1.5, 2.0, 3.0, 4.0, 6.0, T_END])  # s, when errors are looked at
TARGETS = (1e-6, 1e-9)  # rad
TOLERANCES = tuple(10.0 ** (-k / 2) for k in range(4, 24))
LAMC, AUTO, FAST = "lamc, rk45", "lamc, auto", "lamc fast, rk45"
TUNED, TEXTBOOK, CASADI = "C by hand, tuned", "C by hand, textbook", "CasADi, CVODES"
TUNED_FAST, TEXTBOOK_FAST = f"{TUNED}, fast flags", f"{TEXTBOOK}, fast flags"
RIVALS = {LAMC: (TUNED, TEXTBOOK), AUTO: (TUNED, TEXTBOOK), FAST: (TUNED_FAST, TEXTBOOK_FAST)}
FAST_OPTIONS = lamc.CompileOptions(fast=True)


@dataclass(frozen=True)
class Tool:
    """Angles at TIMES, (m, 3), for a tolerance, and the run of T_END to be timed."""

    angles: Callable[[float], Array]
    job: Callable[[float], Callable[[], object]]
    tolerances: tuple[float, ...] = TOLERANCES


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="few repeats")
    parser.add_argument("--out", type=Path, default=Path(__file__).parent / "results")
    arguments = parser.parse_args()
    report: dict[str, Any] = {"environment": environment(), "t_end": T_END}
    with fresh_folder() as folder:
        sim, fast = (lamc.compile(plates(3), SCENE, options) for options in (None, FAST_OPTIONS))
        reference = sim.run(T_END, 1e-13, 1e-15, TIMES, "dop853").q
        curves = measure(tools(sim, fast, folder), reference, 2.0 if arguments.quick else 20.0)
    report["curves"] = {name: [list(point) for point in curve] for name, curve in curves.items()}
    report["equal_error"] = show("Time for an error of at most …, ms", equal_errors(curves))
    report["targets"] = show("Targets", targets(report["equal_error"]))
    write_json(arguments.out / "precision.json", report)


def tools(sim: Any, fast: Any, folder: Path) -> dict[str, Tool]:
    """Every tool that is there."""
    found = {
        name: Tool(partial(_own, own, integrator), partial(_own_job, own, integrator))
        for name, own, integrator in ((LAMC, sim, "rk45"), (AUTO, sim, "auto"), (FAST, fast, "rk45"))
    }
    for name, textbook, flags in (
        (TUNED, False, FLAGS),
        (TEXTBOOK, True, FLAGS),
        (TUNED_FAST, False, FAST_OPTIONS.flags),
        (TEXTBOOK_FAST, True, FAST_OPTIONS.flags),
    ):
        peer = ClosedTriple(folder / name.replace(" ", "_"), textbook=textbook, flags=flags)
        found[name] = Tool(partial(_by_hand, peer), partial(_by_hand_job, peer))
    if casadi_peer is not None:
        for label, method in (("BDF", casadi_peer.BDF), ("Adams", casadi_peer.ADAMS)):
            for how, compiled in (("", False), (", C", True)):
                tool = casadi_peer.CasadiTriple(method, compiled=compiled)
                found[f"{CASADI} {label}{how}"] = Tool(
                    partial(_casadi, tool),
                    partial(_casadi_job, tool),
                    TOLERANCES[::2] if compiled else TOLERANCES,
                )
    return found


def _own(sim: Any, integrator: str, tol: float) -> Array:
    return np.array([sim.run(t, tol, 1e-2 * tol, [t], integrator).q[-1] for t in TIMES])


def _own_job(sim: Any, integrator: str, tol: float) -> Callable[[], object]:
    return partial(sim.run, T_END, tol, 1e-2 * tol, [T_END], integrator)


def _by_hand(peer: ClosedTriple, tol: float) -> Array:
    return np.array([peer.run(t, tol, 1e-2 * tol)[0][:3] for t in TIMES])


def _by_hand_job(peer: ClosedTriple, tol: float) -> Callable[[], object]:
    return peer.job(T_END, tol, 1e-2 * tol)


def _casadi(tool: Any, tol: float) -> Array:
    return np.asarray(tool.angles(TIMES, tol, 1e-2 * tol))


def _casadi_job(tool: Any, tol: float) -> Callable[[], object]:
    job: Callable[[], object] = tool.job(T_END, tol, 1e-2 * tol)
    return job


def measure(
    found: Mapping[str, Tool], reference: Array, seconds: float
) -> dict[str, list[tuple[float, ...]]]:
    """Curves by name: (tolerance, error, s) of each setting that worked, all timed in turns."""
    entries, jobs = [], []
    for name, tool in found.items():
        for tol in tool.tolerances:
            try:
                off = float(np.abs(tool.angles(tol) - reference).max())
                job = tool.job(tol)
                job()
            except RuntimeError as error:  # CVODES gives up at its tightest tolerances
                print(f"{name} at {tol:.1e}: {str(error).splitlines()[-1][:80]}")
                continue
            entries.append((name, tol, off))
            jobs.append(job)
    best = shortest(jobs, [processor_seconds(job) for job in jobs], seconds)
    curves: dict[str, list[tuple[float, ...]]] = {name: [] for name in found}
    for (name, tol, off), (time, _) in zip(entries, best, strict=True):
        curves[name].append((tol, off, time))
    return curves


def time_for(curve: list[tuple[float, ...]], error: float) -> float:
    """s for an error of at most `error`: between the settings beside it, or of the cheapest that is better."""
    usable = sorted((off, time) for _, off, time in curve if off > 1e-14)
    better = min((time for off, time in usable if off <= error), default=float("nan"))
    if not usable or not usable[0][0] <= error <= usable[-1][0]:
        return better
    logs = np.log(np.array(usable))
    return min(better, float(np.exp(np.interp(np.log(error), logs[:, 0], logs[:, 1]))))


def equal_errors(curves: Mapping[str, list[tuple[float, ...]]]) -> Rows:
    rows = []
    for name, curve in curves.items():
        row: dict[str, Any] = {"tool": name}
        for error in TARGETS:
            taken = time_for(curve, error)
            row[f"{error:g} rad"] = 1e3 * taken
            for own in RIVALS:
                row[f"{own} / it at {error:g}"] = time_for(curves[own], error) / taken
        rows.append(row)
    return rows


def targets(rows: Rows) -> Rows:
    by_name = {row["tool"]: row for row in rows}
    found: Rows = []
    for error, limit in zip(TARGETS, (0.8, 1.8), strict=True):
        for own, rivals in RIVALS.items():
            for name in rivals:
                ratio = by_name[name][f"{own} / it at {error:g}"]
                found.append(target(f"{own} / {name}, {error:g} rad", ratio, limit, at_most=True))
            best = [1 / row[f"{own} / it at {error:g}"] for row in rows if row["tool"].startswith(CASADI)]
            if best:
                found.append(
                    target(f"{CASADI}, its best / {own}, {error:g} rad", min(best), 4.0, at_most=False)
                )
    return found


if __name__ == "__main__":
    main()
