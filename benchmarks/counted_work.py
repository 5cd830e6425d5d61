"""What so much counted work of loops takes, and how far it comes at two tolerances, out of a flat start.

    python -m benchmarks.counted_work [--sizes 4 8] [--work 1e9]

In: flat sheets that it draws itself, exact and of four digits, and random lines. Out: a table of processor seconds for
1e9 units of `Simulator.run(max_work=…)`, and of the times and angles that are reached at rtol 1e-9 and 1e-6.
"""

import argparse
import json
import tempfile
import time
import warnings
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

import lamc
from benchmarks.measure import table
from lamc.basics.errors import LamcError
from tests.support import fold_corpus, hostile_corpus, large_corpus

TOLERANCES = (1e-9, 1e-6)
OFF = 5e-4  # of the sheet's size: what drawing by eye leaves


def sheets(folder: Path, sizes: Sequence[int]) -> Iterator[tuple[str, Path]]:
    """Flat sheets by name, as files."""
    random = np.random.default_rng(7)
    for pattern, make in large_corpus.PATTERNS.items():
        for size in sizes:
            data = make(size, size)
            yield f"{pattern} {size}x{size}", fold_corpus.write(folder / "exact.fold", data)
            rough = json.loads(json.dumps(data))
            corners = np.array(rough["vertices_coords"], dtype=float)
            corners[:, :2] += OFF * np.ptp(corners[:, :2]) * (random.random((len(corners), 2)) - 0.5)
            rough["vertices_coords"] = corners.tolist()
            yield f"{pattern} {size}x{size}, by eye", fold_corpus.write(folder / "rough.fold", rough)
    yield "16 random lines", hostile_corpus.HOSTILE["16 random lines"](folder)


def measured(name: str, file: Path, work: float) -> list[str]:
    """A row of the table."""
    try:
        simulator: Any = lamc.compile(lamc.load(file, card=lamc.Card(), crease=1e-3))
    except LamcError as error:
        return [name, "", "", "", str(error)[:60], ""]
    row = [name, str(len(simulator.joints)), str(simulator.freedoms)]
    seconds, reached = 0.0, []
    for rtol in TOLERANCES:
        begun = time.process_time()
        result = simulator.run(10.0, max_work=work, rtol=rtol, atol=1e-2 * rtol, until_folded=True)
        taken = time.process_time() - begun
        limited = result.status == -3
        seconds = max(seconds, taken * 1e9 / work if limited else 0.0)
        angle = float(np.degrees(np.abs(result.q[-1] - result.q[0]).max()))
        reached.append(f"{result.t[-1]:.3g} s, {angle:.3g}°{'' if limited else ' (end)'}")
    return [*row, f"{seconds:.2f} s" if seconds else "", *reached]


def main(words: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--sizes", type=int, nargs="*", default=[4, 8])
    parser.add_argument("--work", type=float, default=1e9)
    given = parser.parse_args(words)
    warnings.simplefilter("ignore")
    rows = []
    with tempfile.TemporaryDirectory(prefix="lamc-work-") as name:
        for title, file in sheets(Path(name), given.sizes):
            rows.append(measured(title, file, given.work))
            print(*rows[-1], sep="\t", flush=True)
    heads = ["sheet", "hinges", "freedoms", "1e9 units", *(f"reached at {rtol:g}" for rtol in TOLERANCES)]
    print(table(heads, rows))


if __name__ == "__main__":
    main()
