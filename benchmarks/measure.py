"""Timing and bookkeeping that the benchmarks share: interleaved repeats, the machine, tables, JSON."""

import json
import os
import platform
import shutil
import subprocess
import time
from collections.abc import Callable, Mapping, Sequence
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

PACKAGES = (
    "lamc",
    "numpy",
    "scipy",
    "sympy",
    "pydy",
    "cython",
    "cffi",
    "mujoco",
    "casadi",
    "scikit-sundae",
    "scikit-fem",
    "scikit-sparse",
    "triangle",
    "meshpy",
    "gmsh",
)
ROOT = Path(__file__).resolve().parent.parent


def interleaved(
    jobs: Mapping[str, Callable[[], Any]],
    repeats: int,
    turn: float = 0.02,
    clock: Callable[[], float] = time.perf_counter,
) -> dict[str, float]:
    """Shortest time of each job by the clock, s, over `repeats` turns; for what has one thread, time.process_time does
    not count what else a machine does.

    The jobs take turns, so that a busy machine disturbs all alike; one turn lasts `turn` seconds at least, so
    that a short job is not measured with the caches that a long one left behind.
    """
    best = dict.fromkeys(jobs, float("inf"))
    for _ in range(repeats):
        for name, job in jobs.items():
            began = now = clock()
            while now - began <= turn:
                started = clock()
                job()
                now = clock()
                best[name] = min(best[name], now - started)
    return best


def environment(compiler: str = "cc") -> dict[str, Any]:
    """What the numbers depend on: processor, compiler, commit, versions."""
    return {
        "date": time.strftime("%Y-%m-%d", time.gmtime()),
        "processor": _processor(),
        "cores": os.cpu_count(),
        "system": platform.system(),
        "python": platform.python_version(),
        "compiler": _first_line([compiler, "--version"]),
        "commit": _first_line(["git", "-C", str(ROOT), "rev-parse", "HEAD"]),
        "changed_since_commit": bool(_first_line(["git", "-C", str(ROOT), "status", "--porcelain"])),
        "packages": {name: found for name in PACKAGES if (found := _version(name))},
    }


def table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Aligned text; the first column to the left, the others to the right."""
    widths = [max(len(row[k]) for row in (head, *rows)) for k in range(len(head))]
    lines = []
    for row in (head, *rows):
        cells = [
            cell.ljust(w) if k == 0 else cell.rjust(w)
            for k, (cell, w) in enumerate(zip(row, widths, strict=True))
        ]
        lines.append("  ".join(cells).rstrip())
    return "\n".join(lines)


def seconds(value: float) -> str:
    """A time with a unit that suits it."""
    for unit, size in (("s", 1.0), ("ms", 1e-3), ("µs", 1e-6)):
        if value >= size:
            return f"{value / size:.3g} {unit}"
    return f"{value * 1e9:.3g} ns"


def write_json(path: Path, data: Mapping[str, Any]) -> None:
    """Writes `data`, with one rename so that no half-written file is left."""
    path.parent.mkdir(parents=True, exist_ok=True)
    partial = path.with_suffix(".partial")
    partial.write_text(
        json.dumps(data, indent=2, sort_keys=True, ensure_ascii=False) + "\n", encoding="utf-8"
    )
    partial.replace(path)


def _first_line(command: list[str]) -> str:
    if shutil.which(command[0]) is None:
        return ""
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    lines = done.stdout.splitlines()
    return lines[0].strip() if lines else ""


def _processor() -> str:
    facts = Path("/proc/cpuinfo")
    if facts.is_file():
        for line in facts.read_text(encoding="utf-8").splitlines():
            if line.startswith("model name"):
                return line.split(":", 1)[1].strip()
    return platform.processor() or platform.machine()


def _version(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:
        return ""
