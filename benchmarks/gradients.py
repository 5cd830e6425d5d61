"""What derivatives of a run cost: beside the run itself, and beside CVODES' forward sensitivities by way of CasADi.

    python -m benchmarks.gradients [--quick]

First, examples with 1 to 20 derivatives, over the run without them: `sim.run` as users call it; and the gradient of
one number by all parameters. Then a chain of 24
hinges in space, by 10 to 200 of its numbers: sensitivities, and the gradient of one measure by the run backwards, a
run that keeps its steps included. Processor time; what is compiled the first time is told beside it. Then the paper's
triple pendulum, differentiated by stiffness and damping of its hinges: of each program the fastest run whose
derivatives at the end are within an error, over a ladder of tolerances. CasADi's equations are C that it made and
compiled; both of CVODES' methods are tried, and the faster one counts. Errors are against lamc and CVODES at their
tightest, which must agree.
"""

import argparse
import importlib
import time
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

import lamc
from benchmarks.measure import interleaved, seconds, table
from lamc.examples import path

Array = npt.NDArray[np.float64]
peer: Any = None
try:
    peer = importlib.import_module("benchmarks.peers.casadi_peer")
except ImportError:
    print("CasADi is not installed: pip install lamc[bench]")

EXAMPLES = (("four_bar", 3.0), ("five_bar", 1.0), ("six_bar", 1.0), ("limit_stop", 1.0), ("pendulum", 5.0))
COUNTS = (1, 5, 10, 20)
T_END = 5.0  # s
NAMES = [f"h{k}.{what}" for what in ("stiffness", "damping") for k in range(3)]
LADDER = [10.0**-k for k in range(4, 13)]
TARGETS = (1e-4, 1e-6, 1e-8)
AGREE = 1e-9  # of the two references: CVODES goes no further than some 1e-10 of a derivative
GOAL = 3.0
LINKS = 24
MANY = (1, 10, 50, 100, 200)  # sensitivities by each take a minute or two of gcc the first time


def of_examples(repeats: int) -> None:
    rows = []
    for name, t_end in EXAMPLES:
        sim = lamc.compile(lamc.load(path(name)))
        known = [
            each for each in sim.parameters if each.endswith((".mass", ".stiffness", ".damping", "_x", "_y"))
        ]
        times = np.linspace(0.0, t_end, 101)
        counts = [count for count in COUNTS if count <= len(known)]

        def job(names: list[str], sim: lamc.Simulator = sim, times: Array = times) -> Callable[[], object]:
            return lambda: sim.run(t_end=float(times[-1]), t_eval=times, sensitivities=names)

        def backwards(sim: lamc.Simulator = sim, times: Array = times) -> object:
            result = sim.run(t_end=float(times[-1]), t_eval=times, taped=True)
            return result.gradient(f"last({sim.joints[0]})")

        jobs: dict[str, Callable[[], object]] = {str(count): job(known[:count]) for count in (0, *counts)}
        jobs["backwards"] = backwards
        for each in jobs.values():
            each()
        best = interleaved(jobs, repeats)
        for count in counts:
            ratio = best[str(count)] / best["0"]
            rows.append(
                [
                    name,
                    str(count),
                    seconds(best["0"]),
                    seconds(best[str(count)]),
                    f"{ratio:.2f}",
                    f"{1 + 0.4 * count:.1f}",
                ]
            )
        took = best["backwards"]
        every = f"{len(sim.parameters)}, of one number"
        rows.append([name, every, seconds(best["0"]), seconds(took), f"{took / best['0']:.2f}", "-"])
    print(table(["example", "derivatives", "run", "with them", "ratio", "asked"], rows))


def chain() -> lamc.Simulator:
    """LINKS cards of 20 mm, of 1 g each, hinged in space, which fall against their springs."""
    bodies, joints = [lamc.Body("ground", fixed=True)], []
    for k in range(LINKS):
        com, inertia = (
            np.array([(k + 0.5) * 0.02, 0.01, 0.0]),
            np.diag([1.0, 1.0, 2.0]) * 1e-3 * 0.02**2 / 12.0,
        )
        bodies.append(lamc.Body(f"link{k}", 1e-3, com, inertia))
        axis = np.array([0.0, 1.0, 0.0] if k % 2 == 0 else [0.6, 0.8, 0.0])
        where = {"point": np.array([k * 0.02, 0.0, 0.0]), "axis": axis}
        joints.append(
            lamc.Joint(f"h{k}", bodies[k].name, bodies[k + 1].name, **where, stiffness=0.05, damping=1e-4)
        )
    effects = (lamc.Gravity((0.0, 0.0, -9.81)), lamc.HingeStiffness(), lamc.HingeDamping(), lamc.RestAngle())
    return lamc.compile(
        lamc.Mechanism(tuple(bodies), tuple(joints), name="chain"), lamc.Scene(effects=effects)
    )


def of_many(repeats: int, counts: Sequence[int] = MANY) -> None:
    sim = chain()
    known = [
        *(each for each in sim.parameters if not each.startswith("gravity")),
        *(f"{what}.{joint}" for what in ("angles", "rates") for joint in sim.joints),
    ]
    asked: dict[str, Any] = {"t_end": 0.5, "t_eval": np.linspace(0.0, 0.5, 101), "rtol": 1e-7, "atol": 1e-9}
    plain = fastest(lambda: sim.run(**asked), repeats)
    rows = []
    began = time.perf_counter()
    sim.run(**asked, taped=True)
    compiled = time.perf_counter() - began
    for count in counts:
        names = known[:count]

        def backwards(names: list[str] = names) -> object:
            return sim.run(**asked, taped=True).gradient(f"last(h{LINKS - 1})", names)

        backward = fastest(backwards, repeats)

        def forwards(names: list[str] = names) -> object:
            return sim.run(**asked, sensitivities=names)

        began = time.perf_counter()
        forwards()
        first = time.perf_counter() - began
        forward = fastest(forwards, max(repeats // 5, 1))
        told = [seconds(forward), f"{forward / plain:.1f}", seconds(first)]
        rows.append([str(count), *told, seconds(backward), f"{backward / plain:.1f}", seconds(compiled)])
    print(f"chain of {LINKS} hinges: a run takes {seconds(plain)}")
    heads = ["derivatives", "forward", "runs", "compiled in", "gradient", "runs", "compiled in"]
    print(table(heads, rows))


def fastest(job: Callable[[], object], repeats: int) -> float:
    """Processor time, s."""
    job()
    best = float("inf")
    for _ in range(repeats):
        began = time.process_time()
        job()
        best = min(best, time.process_time() - began)
    return best


def triple() -> tuple[lamc.Simulator, Callable[[float], Callable[[], Array]]]:
    """The pendulum, and for a tolerance what gives d(angles)/d(parameters) at the end, (3, 6)."""
    bodies = [lamc.Body("ground", fixed=True)]
    joints = []
    for k in range(3):
        com, inertia = np.array([k + 0.5, 0.5, 0.0]), np.diag([1.0, 1.0, 2.0]) / 12.0
        bodies.append(lamc.Body(f"link{k}", 1.0, com, inertia))
        where = {"point": np.array([float(k), 0.0, 0.0]), "axis": np.array([0.0, 1.0, 0.0])}
        joints.append(
            lamc.Joint(f"h{k}", bodies[k].name, bodies[k + 1].name, **where, stiffness=100.0, damping=10.0)
        )
    effects = (lamc.Gravity((0.0, 0.0, -9.81)), lamc.HingeStiffness(), lamc.HingeDamping())
    sim = lamc.compile(
        lamc.Mechanism(tuple(bodies), tuple(joints), name="unit_plates"), lamc.Scene(effects=effects)
    )

    def gradient(rtol: float) -> Callable[[], Array]:
        def run() -> Array:
            result = sim.run(T_END, rtol, 1e-2 * rtol, [T_END], sensitivities=NAMES)
            assert result.sensitivities is not None
            return result.sensitivities.values[-1, :3]

        return run

    return sim, gradient


def beside_cvodes(repeats: int) -> None:
    _, own = triple()
    others = {
        name: peer.CasadiTriple(method, compiled=True)
        for name, method in (("CVODES BDF", peer.BDF), ("CVODES Adams", peer.ADAMS))
    }
    reference, second = own(1e-13)(), others["CVODES Adams"].gradient(T_END, 1e-13, 1e-15)()
    size = np.abs(reference).max()
    apart = np.abs(reference - second).max() / size
    print(f"references differ by {apart:.1e} of the largest derivative (at most {AGREE:g} is expected)")
    jobs: dict[str, Callable[[], Array]] = {}
    errors: dict[str, float] = {}
    for rtol in LADDER:
        made = {"lamc": own(rtol)} | {
            n: each.gradient(T_END, rtol, 1e-2 * rtol) for n, each in others.items()
        }
        for name, job in made.items():
            key = f"{name} {rtol:g}"
            jobs[key], errors[key] = job, float(np.abs(job() - reference).max() / size)
    best = interleaved(jobs, repeats)
    rows = []
    for target in TARGETS:
        fastest = {}
        for name in ("lamc", *others):
            good = [
                best[key]
                for key, error in errors.items()
                if key.rsplit(" ", 1)[0] == name and error <= target
            ]
            fastest[name] = min(good, default=float("inf"))
        peers = min(fastest[name] for name in others)
        ratio = peers / fastest["lamc"]
        rows.append(
            [f"{target:g}", *(seconds(value) for value in fastest.values()), f"{ratio:.1f}", f"{GOAL:g}"]
        )
    print(table(["error", "lamc", *others, "ratio", "asked"], rows))


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n", 1)[0])
    parser.add_argument("--quick", action="store_true", help="one turn each")
    repeats = 1 if parser.parse_args().quick else 15
    of_examples(repeats)
    of_many(repeats, MANY[1:2] if repeats == 1 else MANY)
    if peer is not None:
        beside_cvodes(repeats)


if __name__ == "__main__":
    main()
