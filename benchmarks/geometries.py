"""What another geometry of a known topology takes before it runs: splitting, planning, counting loops and finding the
start, each from nothing; beside a full compile from an empty cache.

    python -m benchmarks.geometries [--quick]

In: examples. Out: a table of times, the least of some, taken in turns. `--quick`: few turns.
"""

import argparse
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import lamc
from benchmarks.measure import interleaved, seconds, table
from lamc.codegen.cache import Cache
from lamc.design.split import split
from lamc.examples import path
from lamc.loops.at_start import loops_of
from lamc.loops.geometry import LoopGeometry
from lamc.loops.starts import Starter
from lamc.loops.yielding import rigid_scene
from lamc.mechanics.arrangement import arrange
from lamc.mechanism.plan import plan
from lamc.pipeline import effects_of
from lamc.records.design import Design
from lamc.records.scene import Scene

EXAMPLES = ("four_bar", "six_bar", "two_loops", "folding_box", "flapping_wing")
STAGES = ("split", "plan", "effects", "loops", "start")


def stages(design: Design) -> dict[str, Callable[[], Any]]:
    """What each stage does for a new geometry, by what the stages before it gave. start: of loops, as it is had with
    what counting them found."""
    mechanism = split(design)
    scene = mechanism.scene or Scene()
    effects = effects_of(mechanism, scene)
    tree = arrange(plan(mechanism), effects).tree
    held = rigid_scene(plan(mechanism), tree, scene)
    count = loops_of(tree, held)

    def start() -> None:
        if tree.cuts:
            Starter(LoopGeometry(tree), count).state(held)

    return {
        "split": lambda: split(design),
        "plan": lambda: arrange(plan(mechanism), effects),
        "effects": lambda: effects_of(mechanism, scene),
        "loops": lambda: loops_of(tree, held),
        "start": start,
    }


def compiled(design: Design) -> None:
    """From an empty cache."""
    with tempfile.TemporaryDirectory(prefix="lamc-geometries-") as folder:
        lamc.compile(design, cache=Cache(Path(folder)))


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
    main(3 if parser.parse_args().quick else 40)
