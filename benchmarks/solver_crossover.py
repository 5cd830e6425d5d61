"""Where the two ways to the accelerations cross, in operations; and what the cyclic collector costs.

    python -m benchmarks.solver_crossover

In: chains of plates with oblique, right-angled and parallel hinges. Out: a table of operations by number of hinges,
and the growth of derivation with the collector on and off. Operation counts repeat exactly; times are minima.
"""

import gc
import math
import time

from benchmarks.devices import CROSSED, OBLIQUE, PARALLEL, SCENE, plates
from benchmarks.measure import table
from lamc.mechanics import derive as derivation
from lamc.mechanism.plan import plan

KINDS = {"parallel": PARALLEL, "right-angled": CROSSED, "oblique": OBLIQUE}
EFFECTS = SCENE.effects or ()
SIZES = (2, 3, 4, 5, 6, 8, 10, 12, 16)


def crossover() -> None:
    derivation.MAX_PAIRS_FOR_MASS_MATRIX = 10**6  # try both ways everywhere
    rows = []
    for name, directions in KINDS.items():
        for n in SIZES:
            flops = derivation.derive(plan(plates(n, directions)), EFFECTS).solver_flops
            pairs = n * (n - 1) // 2
            row = [name, str(n), str(pairs), str(flops["elimination"]), str(flops["mass matrix"])]
            rows.append([*row, min(flops, key=lambda way: flops[way])])
    print(table(["hinges", "n", "pairs", "elimination", "mass matrix", "cheaper"], rows))


def seconds_to_derive(n: int, *, collector: bool) -> float:
    """The shortest of three derivations, without `collector_paused`."""
    bare = derivation.derive.__wrapped__  # type: ignore[attr-defined]
    tree = plan(plates(n, OBLIQUE))
    best = math.inf
    (gc.enable if collector else gc.disable)()
    for _ in range(3):
        start = time.perf_counter()
        bare(tree, EFFECTS)
        best = min(best, time.perf_counter() - start)
    gc.enable()
    return best


def growth() -> None:
    derivation.MAX_PAIRS_FOR_MASS_MATRIX = 60
    rows = []
    for collector in (True, False):
        times = [seconds_to_derive(n, collector=collector) for n in (25, 50, 100, 200)]
        order = math.log(times[-1] / times[0]) / math.log(8.0)
        rows.append(["on" if collector else "off", *(f"{t:.3f}" for t in times), f"{order:.2f}"])
    print(table(["collector", "25", "50", "100", "200 hinges, s", "order"], rows))


if __name__ == "__main__":
    crossover()
    growth()
