"""Large crease patterns through the command line: what each takes from its file to results, and how it ends.

    python -m benchmarks.large_drawings [--only miura --only hostile] [--sizes 8 16 32] [--kinds fold folded svg dxf]
                                        [--verb run|split|cut|fold|convert] [--limit 20] [--json FILE]

In: patterns that it draws itself, as FOLD, SVG and DXF files, flat and folded; and drawings that try a reader hard.
Out: a table of processor times, each from an empty cache in a process of its own, and how the command ended. A command
that takes longer than eight times the limit, by the clock, is ended.
"""

import argparse
import json
import os
import re
import resource
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

from benchmarks.measure import table
from tests.support import dxf_corpus, fold_corpus, hostile_corpus, large_corpus, svg_corpus

SHEET = ("--card", "0.3 mm, 700 kg/m^3", "--crease", "1e-3 N*mm/rad/mm")
VERBS: dict[str, Callable[[Path, Path], list[str]]] = {
    "run": lambda file, out: ["run", str(file), "--out", str(out), *SHEET],
    "split": lambda file, _: ["split", str(file), *SHEET],
    "cut": lambda file, out: ["export", str(file), "--to", "cut", "--out", str(out), *SHEET],
    "fold": lambda file, out: ["export", str(file), "--to", "fold", "--out", str(out), *SHEET],
    "convert": lambda file, out: ["convert", str(file), f"{out}.yaml", *SHEET],
}
KINDS = ("fold", "folded", "svg", "dxf")


def written(folder: Path, name: str, data: Any, kind: str) -> Path:
    """A pattern as a file of a kind; `folded`: a FOLD file in space."""
    if kind == "svg":
        return svg_corpus.write(folder / f"{name}.svg", data)
    if kind == "dxf":
        file = folder / f"{name}.dxf"
        file.write_bytes(dxf_corpus.pattern(data))
        return file
    if kind == "folded":
        return fold_corpus.write(folder / f"{name}_folded.fold", large_corpus.in_space(data))
    return fold_corpus.write(folder / f"{name}.fold", data)


def files(
    folder: Path, only: Sequence[str], sizes: Sequence[int], kinds: Sequence[str]
) -> Iterator[tuple[str, Path]]:
    for pattern, make in large_corpus.PATTERNS.items():
        for size in sizes if not only or pattern in only else ():
            data = make(size, size)
            for kind in kinds:
                yield f"{pattern} {size}x{size} {kind}", written(folder, f"{pattern}_{size}", data, kind)
    for name, draw in hostile_corpus.HOSTILE.items():
        if name in only or "hostile" in only:
            yield name, draw(folder)


def ended(verb: str, file: Path, limit: float, folder: Path) -> tuple[float, str, str]:
    """Processor seconds of a command and its compilers from an empty cache, bodies, and how it ended."""
    with tempfile.TemporaryDirectory(dir=folder) as home:
        out = Path(home) / "out"
        command = [sys.executable, "-m", "lamc", *VERBS[verb](file, out)]
        own = {**os.environ, "HOME": home, "XDG_CACHE_HOME": home, "LAMC_CACHE_DIR": f"{home}/cache"}
        own["OPENBLAS_NUM_THREADS"] = "1"
        own["MPLCONFIGDIR"] = str(folder / "fonts")  # its list of fonts, which is made once, is not lamc's
        begun = _processor_time()
        try:
            done = subprocess.run(command, capture_output=True, text=True, env=own, timeout=8.0 * limit)
        except subprocess.TimeoutExpired:
            return _processor_time() - begun, "", "ENDED BY THE BENCHMARK"
        taken = _processor_time() - begun
        facets = re.search(r"(\d+) (?:bodies|facets)", done.stdout)
        return taken, facets[1] if facets else "", _outcome(done)


def _processor_time() -> float:
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def _outcome(done: subprocess.CompletedProcess[str]) -> str:
    lines = [
        line for line in done.stderr.splitlines() if line.startswith(("error", "lamc: error", "Traceback"))
    ]
    tail = (lines or done.stderr.splitlines() or [""])[-1]
    return "device" if done.returncode == 0 else f"{done.returncode}: {tail[:300]}"


def main(words: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--only", action="append", default=[])
    parser.add_argument("--sizes", type=int, nargs="*", default=[8, 16, 32])
    parser.add_argument("--kinds", nargs="*", default=list(KINDS), choices=KINDS)
    parser.add_argument("--verb", default="run", choices=sorted(VERBS))
    parser.add_argument("--limit", type=float, default=20.0)
    parser.add_argument("--json", type=Path)
    given = parser.parse_args(words)
    rows = []
    with tempfile.TemporaryDirectory(prefix="lamc-drawings-") as name:
        folder = Path(name)
        for title, file in files(folder, given.only, given.sizes, given.kinds):
            taken, facets, outcome = ended(given.verb, file, given.limit, folder)
            mark = "!" if taken > given.limit else ""
            rows.append([title, facets, f"{taken:.1f} s{mark}", outcome])
            print(*rows[-1], sep="\t", flush=True)
            file.unlink()
    print(table(["input", "bodies", given.verb, "outcome"], rows))
    if given.json:
        given.json.write_text(json.dumps(rows, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
