"""What another geometry of a known topology takes before it runs: splitting, planning, counting loops and finding the
start, each from nothing; beside a full compile from an empty cache. And 200 geometries of four_bar, 2 s each.

    python -m benchmarks.geometries [--quick]

In: examples. Out: a table of times, the least of some, taken in turns; and processor times of the 200. `--quick`: few
turns, and 20 geometries.
"""

import argparse
import tempfile
import time
from collections.abc import Callable
from copy import copy
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

import lamc
from benchmarks.measure import interleaved, seconds, table
from lamc.codegen.cache import Cache
from lamc.design.split import split
from lamc.examples import path
from lamc.loops.at_start import loops_of
from lamc.loops.geometry import geometry_of
from lamc.loops.starts import Starter
from lamc.loops.yielding import rigid_scene
from lamc.mechanics.arranging import arrange
from lamc.mechanism.plan import plan
from lamc.pipeline import effects_of
from lamc.records.design import Design
from lamc.records.scene import Scene

EXAMPLES = ("four_bar", "six_bar", "two_loops", "folding_box", "flapping_wing")
STAGES = ("split", "plan", "effects", "loops", "start")


def stages(design: Design) -> dict[str, Callable[[], Any]]:
    """What each stage does for a new geometry, by what the stages before it gave: a tree keeps what was found of its
    loops, so that they are counted for a copy of it, and a start has what counting found."""
    mechanism = split(design)
    scene = mechanism.scene or Scene()
    effects = effects_of(mechanism, scene)
    tree = arrange(plan(mechanism), effects).tree
    held = rigid_scene(plan(mechanism), tree, scene)
    count = loops_of(tree, held)

    def start() -> None:
        if tree.cuts:
            Starter(geometry_of(tree), count).state(held)

    return {
        "split": lambda: split(design),
        "plan": lambda: arrange(plan(copy(mechanism)), effects),
        "effects": lambda: effects_of(mechanism, scene),
        "loops": lambda: loops_of(replace(tree), held),
        "start": start,
    }


def compiled(design: Design) -> None:
    """From an empty cache."""
    with tempfile.TemporaryDirectory(prefix="lamc-geometries-") as folder:
        lamc.compile(design, cache=Cache(Path(folder)))


def many(count: int) -> None:
    """Geometries of four_bar, one after the other, by one compiled module."""
    design = lamc.load(path("four_bar"))
    assert isinstance(design, Design)
    taken = dict.fromkeys(("with_parameters", "with_design", "start", "run"), 0.0)
    with tempfile.TemporaryDirectory(prefix="lamc-geometries-") as folder:
        first = lamc.compile(design, cache=Cache(Path(folder)))
        for length in np.linspace(0.046, 0.06, count).tolist():
            times = [time.process_time()]
            drawn = design.with_parameters(link_length=length)
            times.append(time.process_time())
            simulator = first.with_design(drawn)
            times.append(time.process_time())
            _ = simulator.start
            times.append(time.process_time())
            assert simulator.run(2.0).success
            times.append(time.process_time())
            assert simulator.structure == first.structure
            for stage, (begun, ended) in zip(taken, pairwise(times), strict=True):
                taken[stage] += ended - begun
    row = [f"{count} of four_bar, each", *(seconds(each / count) for each in taken.values())]
    print(table(["", *taken, "all together"], [[*row, seconds(sum(taken.values()))]]))


def main(repeats: int) -> None:
    rows = []
    for name in EXAMPLES:
        design = lamc.load(path(name))
        assert isinstance(design, Design)
        taken = interleaved(stages(design), repeats)
        whole = interleaved({"compile": lambda design=design: compiled(design)}, 2, turn=0.0)["compile"]  # type: ignore[misc]
        total = sum(taken.values())
        rows.append([name, *(seconds(taken[stage]) for stage in STAGES), seconds(total), seconds(whole)])
        rows[-1].append(f"{whole / total:.0f}")
    head = ["a geometry of", *STAGES, "together", "full compile", "ratio"]
    print(table(head, rows))


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description="Another geometry of a known topology.")
    parser.add_argument("--quick", action="store_true", help="few turns")
    is_quick = parser.parse_args().quick
    main(3 if is_quick else 40)
    print()
    many(20 if is_quick else 200)
