"""One run that measures lamc against its peers: derivation, compilation, right-hand sides, whole runs.

    python -m benchmarks.spine [--quick] [--out FOLDER]

Peers, on the same mechanism in the same run: a hand-written C recursion (own Dormand-Prince in C), sympy's
KanesMethod with lambdify and scipy's RK45, PyDy's Cython generator. Each figure is the shortest of several
repeats, and the repeats of lamc and peer take turns. Prints tables and writes JSON.
"""

import argparse
import os
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

import lamc
from benchmarks.devices import CROSSED, OBLIQUE, PARALLEL, SCENE, plates
from benchmarks.measure import environment, interleaved, seconds, table, write_json
from benchmarks.peers import hand, kane_lambdify
from lamc.codegen.emit import emit
from lamc.mechanics.derive import derive
from lamc.mechanics.lower import lower
from lamc.mechanism.plan import plan
from lamc.records.mechanism import Mechanism
from lamc.reference.sympy_kane import KaneModel, kane

try:
    from benchmarks.peers import pydy_peer
except ImportError:  # the bench extra is not installed; its rows are left out
    pydy_peer = None  # type: ignore[assignment]

Array = npt.NDArray[np.float64]
Rows = list[dict[str, Any]]

SIZES = (3, 10, 40)
ROWS = 1000  # states per timed call: few enough to stay in the cache, enough to hide the call
TOLERANCES = (1e-6, 1e-9)
T_END = 10.0  # s
EFFECTS = SCENE.effects or ()


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="few repeats, no KanesMethod at six hinges")
    parser.add_argument("--out", type=Path, default=Path(__file__).parent / "results")
    arguments = parser.parse_args()
    repeats = 3 if arguments.quick else 15
    with fresh_folder() as folder:
        library = hand.compile_library(folder)
        report: dict[str, Any] = {"environment": environment()}
        report["derivation"] = show("Derivation", derivations(arguments.quick))
        report["right_hand_side"] = show(
            "Right-hand side, one evaluation", right_hand_sides(library, repeats)
        )
        report["triple_pendulum"] = show(
            f"Triple pendulum of the paper, {T_END:g} s", triple_pendulum(library, folder, repeats)
        )
    report["targets"] = show("Targets", targets(report))
    write_json(arguments.out / "spine.json", report)


@contextmanager
def fresh_folder() -> Iterator[Path]:
    """A temporary folder with an empty cache for lamc, so that compilation is measured and not loading."""
    with tempfile.TemporaryDirectory() as name:
        os.environ["LAMC_CACHE_DIR"] = str(Path(name) / "cache")
        yield Path(name)


def show(title: str, rows: Rows) -> Rows:
    """Prints the rows as a table and hands them back."""
    columns = list(rows[0])
    print(f"\n{title}\n{table(columns, [[text(row[c]) for c in columns] for row in rows])}", flush=True)
    return rows


def text(value: Any) -> str:
    return f"{value:.3g}" if isinstance(value, float) else str(value)


def stages(mechanism: Mechanism) -> Any:
    """Derive, lower and emit: what lamc does before the C compiler."""
    return emit(lower(derive(plan(mechanism), EFFECTS)))


def timed(job: Callable[[], Any]) -> tuple[float, Any]:
    started = time.perf_counter()
    result = job()
    return time.perf_counter() - started, result


def derivations(quick: bool) -> Rows:
    """lamc's derivation and C text against KanesMethod's equations (without any code from them)."""
    cases = [("triple pendulum", plates(3, PARALLEL)), ("3 hinges in space", plates(3, CROSSED))]
    if not quick:
        cases.append(("6 hinges in space", plates(6, CROSSED)))
    rows = []
    for name, mechanism in cases:
        peer, _ = timed(partial(kane, mechanism, EFFECTS))
        own = interleaved({"lamc": partial(stages, mechanism)}, 5)["lamc"]
        rows.append({"case": name, "lamc s": own, "KanesMethod s": peer, "ratio": peer / own})
    for n in (20, 50, 100):
        own = interleaved({"lamc": partial(stages, plates(n, OBLIQUE))}, 3)["lamc"]
        rows.append({"case": f"{n} hinges in space", "lamc s": own, "KanesMethod s": "-", "ratio": "-"})
    return rows


def right_hand_sides(library: Any, repeats: int) -> Rows:
    """One evaluation of the accelerations, both sides called from C over the same random states."""
    rows = []
    for kind, directions in (("parallel", PARALLEL), ("space", OBLIQUE)):
        for n in SIZES:
            mechanism = plates(n, directions)
            compiling, sim = timed(partial(lamc.compile, mechanism, SCENE))
            states = np.random.default_rng(n).uniform(-1.0, 1.0, (ROWS, 2 * n))
            peer = hand.HandRecursion(library, mechanism, EFFECTS, sim.joints)
            peer_rows, peer_out = peer.rows(states[:, :n], states[:, n:]), np.empty((ROWS, n))
            evaluate, own_out = rows_in_c(sim, states)
            best = interleaved(
                {
                    "lamc": evaluate,
                    "hand": partial(peer.accelerations_of, peer_rows, peer_out),
                },
                repeats,
            )
            difference = np.abs(own_out - peer.in_order_of_joints(peer_out)).max() / np.abs(own_out).max()
            assert difference < 1e-10, f"lamc and the hand recursion differ by {difference:.1e}"
            own, theirs = best["lamc"] / ROWS * 1e9, best["hand"] / ROWS * 1e9
            flops = sim.program.functions["acceleration"].operations.flops
            rows.append(
                {
                    "case": f"{kind}, n = {n}",
                    "lamc ns": own,
                    "hand C ns": theirs,
                    "lamc / hand": own / theirs,
                    "flops / n": flops / n,
                    "derive + compile s": compiling,
                }
            )
    return rows


def rows_in_c(sim: Any, states: Array) -> tuple[Callable[[], Any], Array]:
    """A call that evaluates all rows in one C loop, without copies, and the array that it fills."""
    motion = sim.run(t_end=0.0, t_eval=[0.0]).motion
    model = motion.model
    result = np.zeros((len(states), len(sim.joints)))
    times = np.zeros(len(states))
    opened = motion.opened()
    arguments = (opened.handle, len(states), model.read(times), model.read(states), model.write(result))
    function = model.lib.lamc_motion_accelerations

    def evaluate(keep: tuple[Any, ...] = (opened, times, states)) -> None:
        function(*arguments)

    return evaluate, result


def triple_pendulum(library: Any, folder: Path, repeats: int) -> Rows:
    """The paper's three unit plates, released flat: making the simulator, and 10 s of motion."""
    mechanism = plates(3, PARALLEL)
    os.environ["LAMC_CACHE_DIR"] = str(folder / "triple")
    making, sim = timed(partial(lamc.compile, mechanism, SCENE))
    warm = interleaved({"lamc": partial(lamc.compile, mechanism, SCENE)}, 5)["lamc"]
    deriving, model = timed(lambda: kane(mechanism, EFFECTS, sim.joints))
    jobs, made = _peers(library, mechanism, sim, model)
    made["lamc"] = making
    rows = [
        {
            "simulator": name,
            "making s": made[name] + (deriving if name not in ("lamc", "hand C") else 0.0),
            **{f"rtol {tol:g}": None for tol in TOLERANCES},
        }
        for name in jobs
    ]
    reference = sim.run(T_END, rtol=1e-11, atol=1e-13, t_eval=[T_END]).q[-1]
    for tol in TOLERANCES:
        for name, job in jobs.items():
            error = float(np.abs(job(tol) - reference).max())
            assert error < 3e4 * tol, f"{name} is off by {error:.1e} rad at rtol {tol:g}"
        best = interleaved({name: partial(job, tol) for name, job in jobs.items()}, repeats)
        for row in rows:
            row[f"rtol {tol:g}"] = best[row["simulator"]]
    for row in rows:
        for tol in TOLERANCES:
            row[f"/ lamc at {tol:g}"] = row[f"rtol {tol:g}"] / rows[0][f"rtol {tol:g}"]
    print(f"\nLoading the triple pendulum from a warm cache: {seconds(warm)}")
    rows[0]["warm cache s"] = warm
    for row in rows[1:]:
        row["warm cache s"] = "-"
    return rows


def _peers(
    library: Any, mechanism: Mechanism, sim: Any, model: KaneModel
) -> tuple[dict[str, Callable[[float], Array]], dict[str, float]]:
    """Runs of 10 s from rest by name, tolerance → final angles; and the time that making each took."""
    by_hand = hand.HandRecursion(library, mechanism, EFFECTS, sim.joints)
    lambdified = {
        "defaults": kane_lambdify.build_textbook(model, cse=False),
        "cse": kane_lambdify.build_textbook(model, cse=True),
        "tuned": kane_lambdify.build(model),
    }
    jobs: dict[str, Callable[[float], Array]] = {
        "lamc": lambda tol: sim.run(T_END, rtol=tol, atol=1e-2 * tol, t_eval=[T_END]).q[-1],
        "hand C": lambda tol: by_hand.run(np.zeros(3), np.zeros(3), T_END, tol, 1e-2 * tol)[0],
    }
    made = {"hand C": 0.0}
    for label, kanes in lambdified.items():
        name = f"KanesMethod, lambdify, RK45 ({label})"
        jobs[name] = partial(_final_angles, kanes.run)
        made[name] = kanes.build_seconds
    for label, solver in (("default", "numpy"), ("symbolic solve", "sympy:CH")) if pydy_peer else ():
        peer = pydy_peer.build(model, solver)
        for integrator, run in (("RK45", peer.run_rk45), ("odeint", peer.run_odeint)):
            name = f"PyDy, {integrator} ({label})"
            jobs[name] = partial(_final_angles, run)
            made[name] = peer.build_seconds
    return jobs, made


def _final_angles(run: Callable[[Array, float, float, float], Array], tol: float) -> Array:
    """Angles after 10 s from rest, of a peer that gives whole states."""
    return run(np.zeros(6), T_END, tol, 1e-2 * tol)[:3]


def targets(report: dict[str, Any]) -> Rows:
    """What the first release set out to reach, and what this run found."""
    rows = [
        target(f"{row['case']}: lamc / hand C per evaluation", row["lamc / hand"], 1.0, at_most=True)
        for row in report["right_hand_side"]
    ]
    limits = {
        "KanesMethod, lambdify, RK45 (defaults)": 400.0,
        "KanesMethod, lambdify, RK45 (cse)": 400.0,
        "KanesMethod, lambdify, RK45 (tuned)": 400.0,
        "PyDy, RK45 (default)": 40.0,
        "PyDy, RK45 (symbolic solve)": 40.0,
    }
    for row in report["triple_pendulum"]:
        if row["simulator"] in limits:
            for tol in TOLERANCES:
                title = f"{row['simulator']} / lamc at {tol:g}"
                rows.append(target(title, row[f"/ lamc at {tol:g}"], limits[row["simulator"]], at_most=False))
    for row in report["derivation"]:
        if row["case"] == "6 hinges in space":
            rows.append(
                target("KanesMethod / lamc, deriving 6 hinges in space", row["ratio"], 50.0, at_most=False)
            )
        if row["case"] == "100 hinges in space":
            rows.append(target("derive + emit at 100 bodies, s", row["lamc s"], 1.5, at_most=True))
    warm = report["triple_pendulum"][0]["warm cache s"]
    rows.append(target("triple pendulum from a warm cache, s", warm, 0.020, at_most=True))
    return rows


def target(name: str, value: float, limit: float, *, at_most: bool) -> dict[str, Any]:
    reached = value <= limit if at_most else value >= limit
    return {
        "target": name,
        "found": value,
        "limit": f"{'at most' if at_most else 'at least'} {limit:g}",
        "reached": "yes" if reached else "no",
    }


if __name__ == "__main__":
    main()
