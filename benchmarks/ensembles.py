"""Ensembles beside one run at a time, MuJoCo's rollout and CasADi's map: `python -m benchmarks.ensembles`.

    python -m benchmarks.ensembles [--quick] [--out FOLDER]

Processor time per body, evaluation of the accelerations and instance, on one thread, of whole runs (steps, errors and
rows are in it), for trees of the paper's unit plates; CasADi's is of evaluations alone, of the same equations by its
virtual machine. MuJoCo takes RK4 steps, of four evaluations. Per hinge for loops of the gallery, each instance with
masses, stiffness and damping of its own. Then 10 000 triple pendulums of 10 s at 1e-6 on as many threads as there are
processors. The shortest of several repeats in turns; prints tables and writes JSON. Both peers: lamc[bench].
"""

import argparse
import importlib
import tempfile
import time
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

import lamc
from benchmarks.devices import CROSSED, OBLIQUE, PARALLEL, SCENE, plates
from benchmarks.measure import environment, interleaved, table, write_json
from benchmarks.spine import target
from lamc.commands.examples import mechanism_of_example
from lamc.examples import find
from lamc.records.mechanism import Mechanism
from lamc.symbolic.listing import listing_of, run
from lamc.symbolic.program import Program, Space
from tests.support.engines import InMujoco, mujoco

casadi: Any = None
with suppress(ImportError):
    casadi = importlib.import_module("casadi")

CASES = (
    ("triple pendulum", 3, PARALLEL),
    ("6 hinges, right angles", 6, CROSSED),
    ("6 hinges in space", 6, OBLIQUE),
    ("24 hinges, right angles", 24, CROSSED),
    ("24 hinges in space", 24, OBLIQUE),
)
LOOPS = ("four_bar", "five_bar", "six_bar", "two_loops", "vertex", "waterbomb", "bricard", "sarrus")
INSTANCES = 128  # that a repeat takes: milliseconds, so that some repeat is not disturbed
T_END = 1.0  # s
STEP = 1e-3  # s, of MuJoCo
LIMIT = 10.0  # ns


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="few repeats")
    parser.add_argument("--out", type=Path, default=Path(__file__).parent / "results")
    arguments = parser.parse_args()
    repeats = 5 if arguments.quick else 40
    report: dict[str, Any] = {"environment": environment()}
    report["per_evaluation"] = [row(name, plates(n, lines), repeats) for name, n, lines in CASES]
    _show("ns per body, evaluation and instance", report["per_evaluation"])
    report["loops"] = [loops(name, repeats) for name in LOOPS]
    _show("ns per hinge, evaluation and instance", report["loops"])
    report["pendulums"] = pendulums(2 if arguments.quick else 6)
    print(", ".join(f"{name}: {value:.3g} s" for name, value in report["pendulums"].items()))
    report["targets"] = [
        *(
            target(f"{r['case']}: lanes, ns", r["lanes"], LIMIT, at_most=True)
            for r in report["per_evaluation"]
            if r["case"] != "triple pendulum"
        ),
        target("10 000 triple pendulums, 10 s at 1e-6, s", report["pendulums"]["dop853"], 1.0, at_most=True),
    ]
    _show("targets", report["targets"])
    write_json(arguments.out / "ensembles.json", report)


def _show(title: str, rows: list[dict[str, Any]]) -> None:
    heads = list(rows[0])
    print(title)
    print(table(heads, [[_text(row[head]) for head in heads] for row in rows]))


def _text(value: Any) -> str:
    return f"{value:.3g}" if isinstance(value, float) else str(value)


def row(name: str, mechanism: Mechanism, repeats: int) -> dict[str, Any]:
    """One case: ns per body, evaluation and instance by each of those that are there."""
    sim = lamc.compile(mechanism, SCENE)
    rng = np.random.default_rng(1)
    first = sim.joints[0]
    asked = partial(
        sim.ensemble,
        T_END,
        1e-6,
        1e-8,
        integrator="dop853",
        parameters={f"{first}.stiffness": rng.uniform(50.0, 150.0, INSTANCES)},
        angles={first: rng.uniform(-1.0, 1.0, INSTANCES)},
        threads=1,
    )
    made = asked()
    bodies = len(sim.joints)
    evaluations = float(made.stats.evaluations.sum())
    jobs: dict[str, Callable[[], Any]] = {"lanes": asked, "one at a time": partial(asked, side_by_side=False)}
    counts = {"lanes": evaluations, "one at a time": evaluations}
    if mujoco is not None:
        jobs["MuJoCo rollout"], counts["MuJoCo rollout"] = rollout(mechanism)
    if casadi is not None:
        jobs["CasADi map"], counts["CasADi map"] = mapped(sim.program)
    best = interleaved(jobs, repeats, clock=time.process_time)
    return {
        "case": name,
        "lanes side by side": made.stats.lanes,
        **{job: best[job] / counts[job] / bodies * 1e9 for job in jobs},
        "one / lanes": best["one at a time"] / best["lanes"],
    }


def loops(name: str, repeats: int) -> dict[str, Any]:
    """An example with loops: ns per hinge, evaluation and instance, side by side and one run at a time."""
    mechanism = mechanism_of_example(find(name))
    sim = lamc.compile(mechanism, mechanism.scene or lamc.Scene())
    rng = np.random.default_rng(1)
    varied = {
        name: value * rng.uniform(0.5, 1.5, INSTANCES)
        for name, value in sim.parameters.items()
        if name.endswith((".mass", ".stiffness", ".damping"))
    }
    asked = partial(sim.ensemble, T_END, 1e-6, 1e-8, integrator="dop853", parameters=varied, threads=1)
    jobs = {"lanes": asked, "one at a time": partial(asked, side_by_side=False)}
    made, alone = (job() for job in jobs.values())
    assert made.q.tobytes() == alone.q.tobytes()
    best = interleaved(jobs, repeats, clock=time.process_time)
    count = float(made.stats.evaluations.sum()) * len(sim.joints)
    return {
        "case": name,
        "lanes side by side": made.stats.lanes,
        **{job: best[job] / count * 1e9 for job in jobs},
        "one / lanes": best["one at a time"] / best["lanes"],
    }


def rollout(mechanism: Mechanism) -> tuple[Callable[[], Any], float]:
    """MuJoCo's runs from as many starts, and their evaluations."""
    runner = importlib.import_module("mujoco.rollout")
    with tempfile.TemporaryDirectory() as folder:
        engine = InMujoco(mechanism, SCENE, Path(folder))
    engine.model.opt.timestep = STEP
    engine.model.opt.integrator = mujoco.mjtIntegrator.mjINT_RK4
    rng = np.random.default_rng(1)
    states = np.zeros((INSTANCES, mujoco.mj_stateSize(engine.model, mujoco.mjtState.mjSTATE_FULLPHYSICS)))
    states[:, 1] = rng.uniform(-1.0, 1.0, INSTANCES)
    steps = round(0.05 / STEP)
    return lambda: runner.rollout(engine.model, engine.data, states, nstep=steps), 4.0 * steps * INSTANCES


def mapped(program: Program) -> tuple[Callable[[], Any], float]:
    """CasADi's accelerations of the same equations, at as many states as there are instances, by its own machine."""
    n, count = len(program.joints), 50 * INSTANCES
    operations = {
        "+": lambda a, b: a + b,
        "-": lambda a, b: a - b,
        "*": lambda a, b: a * b,
        "neg": lambda a: -a,
        "reciprocal": lambda a: 1.0 / a,
        "sin": casadi.sin,
        "cos": casadi.cos,
    }
    q, u, c = (casadi.SX.sym(name, k) for name, k in (("q", n), ("u", n), ("c", program.constant_count)))
    listing = listing_of(program.functions["acceleration"], operations)
    inputs = {Space.ANGLE: q.elements(), Space.RATE: u.elements(), Space.CONSTANT: c.elements()}
    memory = run(listing, inputs)
    out = casadi.vertcat(*(sign * memory[address] for sign, address in listing.outputs))
    evaluate = casadi.Function("udot", [q, u, c], [out]).map(count, "serial")
    rng = np.random.default_rng(1)
    states = [casadi.DM(rng.uniform(0.5, 1.0, (k, count))) for k in (n, n, program.constant_count)]
    return lambda: evaluate(*states), float(count)


def pendulums(repeats: int) -> dict[str, float]:
    """Shortest wall time, s, of 10 000 of them by integrator, on all processors; and the time that threads had on
    processors together, which tells more where a machine has other work."""
    sim = lamc.compile(plates(3, PARALLEL), SCENE)
    rng = np.random.default_rng(2)
    asked = partial(sim.ensemble, 10.0, 1e-6, 1e-8, angles={"h0": rng.uniform(-1.0, 1.0, 10_000)})
    found: dict[str, float] = {}
    for name in ("dop853", "auto"):
        asked(integrator=name)  # compiled
        for _ in range(repeats):
            before = time.process_time()
            wall = asked(integrator=name).stats.wall_time
            spent = time.process_time() - before
            found[name] = min(found.get(name, wall), wall)
            found[f"{name}, of processors"] = min(found.get(f"{name}, of processors", spent), spent)
    return found


if __name__ == "__main__":
    main()
