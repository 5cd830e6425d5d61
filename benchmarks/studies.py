"""What studies cost: many runs of one mechanism, and what a sweep adds to a loop around the simulator.

    python -m benchmarks.studies [--quick]

A published course on foldable robots swept one parameter over 67 runs of 2 s in 6.4 hours. Here a six-bar is driven by
a torque with a frequency of its own in each of 67 runs of 2 s, at lamc's usual tolerances, in one process that has
lamc imported and a warm cache; and 2000 short runs of a rod, of which nothing but the overhead remains. The loop is the
peer: `sim.run` again and again, and the measure by numpy. Shortest of some turns; `--quick`: one.
"""

import argparse
import os
import tempfile
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np

import lamc
from benchmarks.measure import interleaved, seconds, table
from lamc.records.mechanism import Mechanism
from lamc.records.scene import Scene
from lamc.studies.bench import RunOptions
from lamc.studies.making import study_of
from lamc.studies.study import Study

GOAL = 1.0  # s, of the 67 runs on two cores
RUNS, SHORT = 67, 2000


def driven_six_bar() -> tuple[Mechanism, Scene]:
    """The example, with a torque of the frequency that an input says."""
    from lamc.examples import path

    mechanism = lamc.split(lamc.load(path("six_bar")))
    assert mechanism.scene is not None
    drive = lamc.Torque({"arm": "2e-4*sin(2*pi*frequency*t)"})
    effects = (lamc.HingeStiffness(), lamc.HingeDamping(), lamc.Gravity((0.0, 0.0, -9.81)), drive)
    inputs = {"frequency": lamc.Input(1.0, "Hz")}
    return mechanism, replace(mechanism.scene, effects=effects, inputs=inputs)


def loop_over(simulator: lamc.Simulator, name: str, values: np.ndarray, study: Study) -> list[float]:
    """The loop that people write."""
    t_end, rows = study.subject.run.t_end, study.subject.run.rows or 2001
    times = np.linspace(0.0, t_end or 0.0, rows)
    joint = simulator.joints[0]
    return [
        float(simulator.run(t_end, t_eval=times, parameters={name: value}).angle(joint).max())
        for value in values.tolist()
    ]


def jobs(workers: int) -> dict[str, Callable[[], object]]:
    mechanism, scene = driven_six_bar()
    joint = "arm"
    frequencies = np.linspace(0.5, 10.0, RUNS)
    crank = study_of(
        mechanism, {"frequency": frequencies}, {"most": f"max({joint})"}, scene, run=RunOptions(t_end=2.0)
    )
    six_bar = lamc.compile(mechanism, scene)
    rod = lamc.compile(lamc.load(_pendulum()))
    stiffness = np.linspace(0.01, 0.1, SHORT)
    short = study_of(
        lamc.split(lamc.load(_pendulum())),
        {"h1.stiffness": stiffness},
        {"most": "max(h1)"},
        run=RunOptions(t_end=0.2, rows=101),
    )
    return {
        f"{RUNS} runs, loop": lambda: loop_over(six_bar, "frequency", frequencies, crank),
        f"{RUNS} runs, sweep, 1 process": lambda: crank.run(None, 1),
        f"{RUNS} runs, sweep, {workers} processes": lambda: crank.run(None, workers),
        f"{RUNS} runs, sweep into a folder": lambda: _stored(crank, workers),
        f"{SHORT} short runs, loop": lambda: loop_over(rod, "h1.stiffness", stiffness, short),
        f"{SHORT} short runs, sweep, 1 process": lambda: short.run(None, 1),
        f"{SHORT} short runs, sweep, {workers} processes": lambda: short.run(None, workers),
    }


def _pendulum() -> Path:
    from lamc.examples import path

    return Path(path("pendulum"))


def _stored(study: Study, workers: int) -> None:
    with tempfile.TemporaryDirectory() as folder:
        study.run(Path(folder), workers)


def main(turns: int) -> None:
    workers = min(2, os.cpu_count() or 1)
    taken = interleaved(jobs(workers), turns, turn=0.0)
    loops = {name.split(",")[0]: time for name, time in taken.items() if name.endswith("loop")}
    rows = [
        [name, seconds(time), f"{time / loops[name.split(',')[0].split(' sweep')[0]]:.2f}"]
        for name, time in taken.items()
    ]
    print(table(["study", "wall time", "× loop"], rows))
    whole = taken[f"{RUNS} runs, sweep, {workers} processes"]
    verdict = "yes" if whole < GOAL else "no"
    print(f"{RUNS} runs of 2 s on {workers} cores: {seconds(whole)}; below {seconds(GOAL)}: {verdict}")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="one turn")
    main(1 if parser.parse_args().quick else 5)
