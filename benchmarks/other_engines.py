"""lamc beside the models that it writes for MuJoCo: how far angles are apart at the end of a run, by MuJoCo's step.

    python -m benchmarks.other_engines [--quick] [--out FOLDER]

Each example is exported to MJCF and simulated by MuJoCo at ever shorter steps, each half as long as the one before.
The difference is that of the joint that differs most, rad, from lamc's DOP853 at 1e-12. Trees should differ by the
error of RK4, which falls by 16 from step to step, until round-off; loops by the softness of MuJoCo's welds, which falls
by 4. Prints a table and writes JSON.
"""

import argparse
import itertools
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

import lamc
from benchmarks.devices import SCENE, plates
from benchmarks.measure import environment, table, write_json
from lamc.commands.examples import mechanism_of_example
from lamc.examples import find
from lamc.records.mechanism import Mechanism
from tests.support.closed_mechanisms import closed_mechanism
from tests.support.engines import InMujoco, mujoco
from tests.support.mechanisms import ALL_PASSIVE, random_tree

STEPS = tuple(4e-3 / 2**k for k in range(7))  # s
ROUND_OFF = 1e-11  # rad, below which no trend can be seen
APART = 0.1  # rad, above which none can be seen either
GALLERY = ("four_bar", "five_bar", "six_bar", "two_loops", "vertex", "waterbomb", "sarrus", "bricard")
FAMILIES = (("planar", 1), ("spherical", 2), ("spatial", 1), ("bennett", 1), ("several", 2))


@dataclass(frozen=True)
class Case:
    """A mechanism and how it is run."""

    name: str
    mechanism: Mechanism
    scene: lamc.Scene
    t_end: float  # s


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="without the two shortest steps")
    parser.add_argument("--out", type=Path, default=Path(__file__).parent / "results")
    arguments = parser.parse_args()
    if mujoco is None:
        raise SystemExit("MuJoCo is not installed: pip install lamc[bench]")
    steps = STEPS[:-2] if arguments.quick else STEPS
    rows = [differences(case, steps) for case in cases()]
    heads = ["rad", "joints", "loops", *(f"{step * 1e3:g} ms" for step in steps), "falls by", "gap"]
    print(table(heads, [_cells(row) for row in rows]))
    write_json(arguments.out / "other_engines.json", {"environment": environment(), "cases": rows})


def cases() -> Iterator[Case]:
    """Trees, then loops: of the gallery with their own scenes, and random ones."""
    yield Case("the paper's plates", plates(3), SCENE, 1.0)
    for n, kind in ((4, "mixed"), (6, "space")):
        mechanism = random_tree(n, 7, kind)
        start = {mechanism.joints[1].name: 0.8}
        yield Case(f"tree, {kind}", mechanism, lamc.Scene(effects=ALL_PASSIVE, angles=start), 1.0)
    for name in GALLERY:
        mechanism = mechanism_of_example(find(name))
        yield Case(name, mechanism, mechanism.scene or lamc.Scene(), 0.2)
    for family, seed in FAMILIES:
        yield Case(f"loops, {family}", closed_mechanism(family, seed).mechanism, lamc.Scene(), 0.5)


def differences(case: Case, steps: Sequence[float]) -> dict[str, Any]:
    """The row of a case: differences by step, by what they fall from step to step, and the gap at the shortest."""
    simulator = lamc.compile(case.mechanism, case.scene)
    result = simulator.run(case.t_end, 1e-12, 1e-14, [0.0, case.t_end], "dop853")
    if not result.success:
        raise SystemExit(f"{case.name}: {result.message}")
    names = [joint.name for joint in case.mechanism.joints]
    expected = np.array([result.angle(name)[-1] for name in names])
    with tempfile.TemporaryDirectory() as folder:
        engine = InMujoco(case.mechanism, case.scene, Path(folder))
    errors, gap = [], 0.0
    for step in steps:
        engine.end(case.t_end, step)
        away = engine.data.qpos[[engine.place(name)[0] for name in names]] - expected
        errors.append(float(np.abs(away).max()))
        gap = float(np.abs(engine.data.efc_pos).max(initial=0.0))
    return {
        "name": case.name,
        "joints": len(names),
        "loops": len(simulator.cut_joints),
        "steps": list(steps),
        "errors": errors,
        "falls_by": trend(errors),
        "gap": gap,
    }


def trend(errors: Sequence[float]) -> float | None:
    """By what errors fall when the step is halved: the last two that are neither round-off nor too large to tell."""
    pairs = [(a, b) for a, b in itertools.pairwise(errors) if a < APART and b > ROUND_OFF]
    return pairs[-1][0] / pairs[-1][1] if pairs else None


def _cells(row: dict[str, Any]) -> list[str]:
    falls = "-" if row["falls_by"] is None else f"{row['falls_by']:.1f}"
    errors = [f"{error:.1e}" if np.isfinite(error) else "diverges" for error in row["errors"]]
    gap = f"{row['gap']:.0e}" if row["loops"] else "-"
    return [row["name"], str(row["joints"]), str(row["loops"]), *errors, falls, gap]


if __name__ == "__main__":
    main()
