"""What loops cost: mechanisms with few of them, and Miura sheets of growing size.

    python -m benchmarks.sheets [--largest 4] [--quick]

In: the examples, compiled in a cache of the benchmark's own; with `pip install -e '.[bench]'` MuJoCo steps the same
devices, from lamc's own MJCF. Out: a table of wall times, the shortest of several turns: per evaluation of the
accelerations along a run, cold from text to simulator, per second of motion at rtol 1e-6; and how they grow with the
number of hinges.
"""

import argparse
import importlib.util
import math
import os
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np

import lamc
from benchmarks.measure import interleaved, seconds, table
from lamc.examples import path
from lamc.examples.miura import miura

SMALL = ("four_bar", "vertex", "waterbomb", "folding_box")
ROWS = 2000  # states in a call, so that Python's share is small
T_END = 0.2  # s
STEP = 1e-3  # s, of MuJoCo


def sheet(count: int, folder: Path) -> Path:
    """A Miura sheet of count x count facets, as a file."""
    file = folder / f"miura_{count}x{count}.yaml"
    file.write_text(miura(count, count), encoding="utf-8")
    return file


def measured(name: str, file: Path, repeats: int) -> tuple[int, float, float, list[str]]:
    """Hinges, seconds per evaluation and cold, and the row of the table."""
    begun = time.perf_counter()
    device = lamc.load(file)
    simulator = lamc.compile(device)
    cold = time.perf_counter() - begun
    result = simulator.run(t_end=T_END, rtol=1e-6, atol=1e-8)
    turns = math.ceil(ROWS / len(result.t))
    q, u = np.tile(result.q, (turns, 1)), np.tile(result.u, (turns, 1))
    jobs: dict[str, Any] = {
        "evaluation": lambda: simulator.acceleration(q, u),
        "run": lambda: simulator.run(t_end=T_END, rtol=1e-6, atol=1e-8),
    }
    if importlib.util.find_spec("mujoco") is not None:
        jobs["MuJoCo"] = mujoco_steps(device)
    best = interleaved(jobs, repeats)
    evaluation = best["evaluation"] / len(q)
    gap = result.constraint_error.max() / simulator.mechanism.size
    row = [
        name,
        str(len(simulator.joints)),
        str(simulator.loops.freedoms),
        seconds(evaluation),
        seconds(cold),
        seconds(best["run"] / T_END),
        f"{gap:.0e}",
        seconds(best["MuJoCo"] / round(T_END / STEP)) if "MuJoCo" in best else "",
    ]
    return len(simulator.joints), evaluation, cold, row


def mujoco_steps(device: Any) -> Any:
    """A job: the run, by MuJoCo in steps of a millisecond."""
    import mujoco

    with tempfile.TemporaryDirectory(prefix="lamc-sheets-") as folder:
        made = lamc.export(device, "mjcf", out=Path(folder) / "mjcf")
        (file,) = Path(made).glob("*.xml")
        model = mujoco.MjModel.from_xml_path(str(file))
    model.opt.timestep = STEP
    data = mujoco.MjData(model)

    def run() -> None:
        mujoco.mj_resetData(model, data)
        for _ in range(round(T_END / STEP)):
            mujoco.mj_step(model, data)

    return run


def sheets(largest: int, repeats: int, folder: Path) -> None:
    """Prints the table and the exponents of growth."""
    files = {name: path(name) for name in SMALL}
    sizes = [n for n in (2, 3, 4, 6, 8, 12, 16, 24, 32) if n <= largest]
    files |= {f"miura {n} x {n}": sheet(n, folder) for n in sizes}
    found = {name: measured(name, file, repeats) for name, file in files.items()}
    head = [
        "device",
        "hinges",
        "freedoms",
        "evaluation",
        "cold",
        "1 s of motion",
        "gap / size",
        "MuJoCo, 1 ms",
    ]
    print(table(head, [row for *_, row in found.values()]))
    grown = [each for name, each in found.items() if name.startswith("miura")][1:]
    if len(grown) < 2:
        return
    hinges, evaluation, cold = np.log(np.array([each[:3] for each in grown])).T
    print(
        f"\nFrom {grown[0][0]} hinges on, evaluations grow as hinges^{np.polyfit(hinges, evaluation, 1)[0]:.2f}, "
        f"cold starts as hinges^{np.polyfit(hinges, cold, 1)[0]:.2f}."
    )


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description="Loops: evaluation, cold start and run, and how they grow.")
    parser.add_argument("--largest", type=int, default=4, metavar="N", help="facets along a side (4)")
    parser.add_argument("--quick", action="store_true", help="one turn of each")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="lamc-sheets-") as place:
        os.environ["LAMC_CACHE_DIR"] = str(Path(place) / "cache")
        sheets(given.largest, 1 if given.quick else 5, Path(place))
