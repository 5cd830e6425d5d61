"""What a call costs in the programs that embed an export: C, C++, Python, FMPy, node, on the triple pendulum.

    python -m benchmarks.embedding [--quick] [--out FOLDER] [--docs]

Each host runs the same design over the same ten seconds and reports, as the shortest of many turns:

    rhs     ns for one right-hand side
    step    ns for a step of the integrator, where one call goes to the end
    call    ns for a call to the next millisecond, ten thousand of them, the integrator's own steps included
    run     ms for the whole run in one call

Ratios are to C in the same run. C, C++ and Python are the C of `--to c`; node runs that of `--no-libm`, which stands
beside it natively too. A host that is not there has a row that says so. Prints a table, writes JSON; `--docs` puts the
table into docs/embedding.md.
"""

import argparse
import importlib.util
import json
import shutil
import subprocess
import sys
import tempfile
import time
import zipfile
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import lamc
from benchmarks.measure import ROOT, environment, table, write_json
from lamc.commands.examples import mechanism_of_example
from lamc.examples import find
from lamc.export import files_of
from lamc.records.mechanism import Mechanism

NAME = "pendulum"
T_END = 10.0  # s
CALLS = 10_000  # from the start to the end, one to each millisecond
PAGE = ROOT / "docs" / "embedding.md"
MARKS = ("<!-- benchmarks.embedding: begin -->", "<!-- benchmarks.embedding: end -->")
Times = dict[str, float]  # s: "rhs" for one, "run" for the whole in one call, "calls" for it in CALLS

C_TIMER = """
#define _POSIX_C_SOURCE 199309L
#include "pendulum.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

static double now(void) {
  struct timespec t;
  clock_gettime(CLOCK_MONOTONIC, &t);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

int main(int count, char **words) {
  const int turns = count > 1 ? atoi(words[1]) : 1;
  double rhs = 1e9, run = 1e9, calls = 1e9, sum = 0.0;
  static pendulum_t it;
  for (int turn = 0; turn < turns; turn++) {
    double began = now(), y[6] = {0.1, 0.2, 0.3, 0.0, 0.0, 0.0}, dydt[6];
    pendulum_init(&it, 0, 0);
    began = now();
    for (int k = 0; k < 10000; k++) {
      y[3] = 1e-6 * k;
      pendulum_rhs(&it, 0.0, y, dydt);
      sum += dydt[3];
    }
    rhs = fmin(rhs, (now() - began) / 10000);
    began = now();
    pendulum_init(&it, 0, 0);
    if (pendulum_step(&it, 10.0) != 0) return 1;
    run = fmin(run, now() - began);
    sum += it.q[0];
    began = now();
    pendulum_init(&it, 0, 0);
    for (int k = 1; k <= 10000; k++)
      if (pendulum_step(&it, 1e-3 * k) != 0) return 1;
    calls = fmin(calls, now() - began);
  }
  printf("{\\"rhs\\": %.9g, \\"run\\": %.9g, \\"calls\\": %.9g, \\"sum\\": %.9g}\\n", rhs, run, calls, sum);
  return 0;
}
"""

JS_TIMER = """
import { load } from "./pendulum.mjs";
const model = await load();
const turns = Number(process.argv[2]);
const found = { rhs: Infinity, run: Infinity, calls: Infinity };
const timed = (what, times, work) => {
  const began = performance.now();
  work();
  found[what] = Math.min(found[what], (performance.now() - began) / 1e3 / times);
};
for (let turn = 0; turn < turns; turn++) {
  let it = model.create();
  const y = [0.1, 0.2, 0.3, 0, 0, 0];
  timed("rhs", 10000, () => { for (let k = 0; k < 10000; k++) { y[3] = 1e-6 * k; it.rhs(0, y); } });
  it.free();
  timed("run", 1, () => { it = model.create(); it.step(10); });
  it.free();
  timed("calls", 1, () => { it = model.create(); for (let k = 1; k <= 10000; k++) it.step(1e-3 * k); });
  it.free();
}
console.log(JSON.stringify(found));
"""

PYTHON_TIMER = """
import json, sys, time
import pendulum
turns = int(sys.argv[1])
found = {"rhs": 1e9, "run": 1e9, "calls": 1e9}
def timed(what, times, work):
    began = time.perf_counter()
    work()
    found[what] = min(found[what], (time.perf_counter() - began) / times)
def rhs():
    it, y = pendulum.Pendulum(), [0.1, 0.2, 0.3, 0.0, 0.0, 0.0]
    for k in range(10000):
        y[3] = 1e-6 * k
        it.rhs(0.0, y)
def calls():
    step = pendulum.Pendulum().step
    for k in range(1, 10001):
        step(1e-3 * k)
for turn in range(turns):
    timed("rhs", 10000, rhs)
    timed("run", 1, lambda: pendulum.Pendulum().step(10.0))
    timed("calls", 1, calls)
print(json.dumps(found))
"""


class Absent(Exception):  # noqa: N818  not an error: a row of the table
    """A host is not there; says what is missing."""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="fewer turns")
    parser.add_argument("--out", type=Path, default=Path(__file__).parent / "results")
    parser.add_argument("--docs", action="store_true", help="put the table into docs/embedding.md")
    arguments = parser.parse_args()
    mechanism = mechanism_of_example(find(NAME))
    steps = _steps(mechanism)
    rows = measured(mechanism, steps, turns=25 if arguments.quick else 100)
    heads = ["", "rhs, ns", "step, ns", "call, ns", "run, ms", "run / C"]
    cells = [[row["host"], *_cells(row)] for row in rows]
    print(table(heads, cells))
    print(f"{steps} steps in {T_END:g} s")
    data = {"environment": environment(), "steps": steps, "hosts": rows}
    write_json(arguments.out / "embedding.json", data)
    if arguments.docs:
        _into_page(heads, cells)


def measured(mechanism: Mechanism, steps: int, turns: int) -> list[dict[str, Any]]:
    """A row for each host. Two rounds, the shorter time of each, so that a busy moment does not fall on one alone."""
    hosts: Mapping[str, Callable[[Mechanism, Path, int], Times]] = {
        "C": lambda m, f, n: in_c(m, f, n),
        "C, --no-libm": lambda m, f, n: in_c(m, f, n, libm=False),
        "C++": lambda m, f, n: in_cxx(m, f, n),
        "Python, wheel": in_python,
        "Python, FMPy": in_fmpy,
        "node, wasm": in_node,
    }
    found: dict[str, Times] = {}
    absent: dict[str, str] = {}
    with tempfile.TemporaryDirectory() as name:
        for turn in range(2):
            for index, (host, run) in enumerate(hosts.items()):
                folder = Path(name) / f"{turn}_{index}"
                folder.mkdir()
                try:
                    times = run(mechanism, folder, turns)
                except Absent as reason:
                    absent[host] = str(reason)
                    continue
                kept = found.get(host, times)
                found[host] = {key: min(times[key], kept[key]) for key in times}
    return [_row(host, found.get(host), absent.get(host, ""), steps, found["C"]) for host in hosts]


def _row(host: str, times: Times | None, absent: str, steps: int, c: Times) -> dict[str, Any]:
    if times is None:
        return {"host": host, "absent": absent}
    return {
        "host": host,
        "rhs_ns": 1e9 * times["rhs"] if "rhs" in times else None,
        "step_ns": 1e9 * times["run"] / steps,
        "call_ns": 1e9 * times["calls"] / CALLS,
        "run_ms": 1e3 * times["run"],
        "run_to_c": times["run"] / c["run"],
        "calls_to_c": times["calls"] / c["calls"],
    }


def _cells(row: Mapping[str, Any]) -> list[str]:
    if "absent" in row:
        return [row["absent"], "", "", "", ""]
    rhs = "-" if row["rhs_ns"] is None else f"{row['rhs_ns']:.0f}"
    cost = [f"{row['step_ns']:.0f}", f"{row['call_ns']:.0f}", f"{row['run_ms']:.2f}"]
    return [rhs, *cost, f"{row['run_to_c']:.2f}"]


def _into_page(heads: list[str], cells: list[list[str]]) -> None:
    begin, end = MARKS
    text = PAGE.read_text(encoding="utf-8")
    before, _, rest = text.partition(begin)
    _, _, after = rest.partition(end)
    lines = [heads, ["---"] + ["--:"] * (len(heads) - 1), *cells]
    body = "\n".join("| " + " | ".join(line) + " |" for line in lines)
    PAGE.write_text(f"{before}{begin}\n{body}\n{end}{after}", encoding="utf-8")


def _steps(mechanism: Mechanism) -> int:
    """Accepted steps of the run, as lamc counts them: all hosts take these."""
    result = lamc.compile(mechanism).run(T_END, rtol=1e-9, atol=1e-11, t_eval=[0.0, T_END], max_step=1.0)
    return int(result.stats.steps)


# --- hosts ------------------------------------------------------------------------------------------------------------


def _written(mechanism: Mechanism, to: str, folder: Path, **options: Any) -> list[Path]:
    files = files_of(mechanism, to, None, lamc.ExportOptions(prefix=NAME, **options))
    for name, content in files.items():
        (folder / name).write_bytes(content)
    return [folder / name for name in files]


def _output(command: list[str], folder: Path) -> str:
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False, timeout=600)
    if done.returncode != 0:
        raise SystemExit(f"{command[0]} failed: {done.stderr[:2000]}")
    return done.stdout


def _needed(program: str) -> str:
    found = shutil.which(program)
    if found is None:
        raise Absent(f"{program} is not there")
    return found


def in_c(mechanism: Mechanism, folder: Path, turns: int, libm: bool = True) -> Times:
    cc = _needed("cc")
    _written(mechanism, "c", folder, libm=libm)
    (folder / "timer.c").write_text(C_TIMER)
    flags = ["-O2", "-std=c99", "-ffp-contract=off"]
    _output([cc, *flags, "timer.c", f"{NAME}.c", "-lm", "-o", "timer"], folder)
    return _reported(_output(["./timer", str(turns)], folder))


def in_cxx(mechanism: Mechanism, folder: Path, turns: int) -> Times:
    cxx = _needed("c++")
    _written(mechanism, "c", folder)
    (folder / "timer.c").write_text(C_TIMER)
    flags = ["-O2", "-std=c++17", "-ffp-contract=off", "-x", "c++"]
    _output([cxx, *flags, "timer.c", f"{NAME}.c", "-lm", "-o", "timer"], folder)
    return _reported(_output(["./timer", str(turns)], folder))


def in_python(mechanism: Mechanism, folder: Path, turns: int) -> Times:
    wheel, _ = _written(mechanism, "wheel", folder)
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(folder)
    return _reported(_output([sys.executable, "-c", PYTHON_TIMER, str(turns)], folder))


def in_node(mechanism: Mechanism, folder: Path, turns: int) -> Times:
    node = _needed("node")
    try:
        _written(mechanism, "wasm", folder)
    except lamc.BuildError:
        raise Absent("no compiler for wasm32") from None
    (folder / "timer.mjs").write_text(JS_TIMER)
    return _reported(_output([node, "timer.mjs", str(turns)], folder))


def in_fmpy(mechanism: Mechanism, folder: Path, turns: int) -> Times:
    """FMI 2.0, whose co-simulation has no right-hand side to call."""
    if importlib.util.find_spec("fmpy") is None:
        raise Absent("FMPy is not there")
    from fmpy import extract, read_model_description
    from fmpy.fmi2 import FMU2Slave

    (path,) = _written(mechanism, "fmu", folder)
    place = extract(str(path), unzipdir=str(folder / "fmu"))
    description = read_model_description(place)
    slave = FMU2Slave(
        guid=description.guid,
        unzipDirectory=place,
        modelIdentifier=description.coSimulation.modelIdentifier,
        instanceName="one",
    )
    slave.instantiate()

    def run(count: int) -> float:
        slave.setupExperiment(startTime=0.0, tolerance=1e-9)
        slave.enterInitializationMode()
        slave.exitInitializationMode()
        step, h, began = slave.doStep, T_END / count, time.perf_counter()
        for k in range(count):
            step(currentCommunicationPoint=k * h, communicationStepSize=h)
        passed = time.perf_counter() - began
        slave.reset()
        return passed

    times = {"run": min(run(1) for _ in range(turns)), "calls": min(run(CALLS) for _ in range(turns))}
    slave.freeInstance()
    return times


def _reported(output: str) -> Times:
    found = json.loads(output)
    return {key: float(found[key]) for key in ("rhs", "run", "calls")}


if __name__ == "__main__":
    main()
