"""What a second process takes until it can run: reading a design and compiling it from the cache, after the imports;
and what the whole of `lamc run` takes from a warm cache, with pictures and without.

    python -m benchmarks.starts [--quick]

In: examples, in a cache of the benchmark's own that has them. Out: a table of processor times, the least of some
fresh processes; unlike wall times they leave out other work on the machine. `--quick`: one process each.
"""

import argparse
import json
import os
import resource
import subprocess
import sys
import tempfile

from benchmarks.measure import seconds, table

EXAMPLES = ("flaps", "pendulum", "pendulum.cad", "four_bar", "crawler", "waterbomb", "folding_box")
GOAL = 0.05  # s, of reading and compiling together
RUN = ["run", "--example", "pendulum", "--quiet", "--out"]
RUN_GOALS = {"with pictures": ([], 1.5), "--no-pictures": (["--no-pictures"], 0.6)}  # s, imports included
_START = """
import json, sys, time
begun = time.process_time()
import lamc
from lamc.examples import path
from lamc.basics.times import Times
imported = time.process_time()
design = lamc.load(path(sys.argv[1]))
loaded = time.process_time()
times = Times()
lamc.compile(design, times=times)
ended = time.process_time()
print(json.dumps([imported - begun, loaded - imported, ended - loaded, times.from_cache]))
"""


def start(name: str) -> tuple[float, float, float, bool]:
    """Processor time, s, of imports, reading and compiling in a fresh process; whether the cache had it."""
    done = subprocess.run(
        [sys.executable, "-c", _START, name], capture_output=True, text=True, check=True, env=os.environ
    )
    imports, reading, compiling, hit = json.loads(done.stdout)
    return imports, reading, compiling, hit


def starts(processes: int) -> None:
    rows = []
    for name in EXAMPLES:
        start(name)  # fills the cache
        reported = [start(name) for _ in range(processes)]
        assert all(hit for *_, hit in reported), f"{name} did not come from the cache"
        imports, reading, compiling = (min(times[k] for times in reported) for k in range(3))
        verdict = "yes" if reading + compiling < GOAL else "no"
        rows.append([name, seconds(imports), seconds(reading), seconds(compiling), verdict])
    print(table(["example", "imports", "reading", "from the cache", f"both below {seconds(GOAL)}"], rows))


def command(words: list[str]) -> float:
    """Processor time, s, of a whole process."""
    code = f"import sys; from lamc_command import main; sys.argv[1:] = {words!r}; main()"
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run([sys.executable, "-c", code], check=True, env=os.environ)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime


def runs(processes: int, folder: str) -> None:
    rows = []
    for name, (options, goal) in RUN_GOALS.items():
        words = [*RUN, f"{folder}/out", *options]
        command(words)  # fills the cache
        taken = min(command(words) for _ in range(processes))
        rows.append([name, seconds(taken), "yes" if taken < goal else "no", seconds(goal)])
    print(table(["lamc run --example pendulum", "processor time", "below", "goal"], rows))


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description="Start of a second process, in processor time.")
    parser.add_argument("--quick", action="store_true", help="one process for each example")
    with tempfile.TemporaryDirectory(prefix="lamc-starts-") as folder:
        os.environ["LAMC_CACHE_DIR"] = folder
        os.environ.pop("PYTHONDONTWRITEBYTECODE", None)  # as users have it: modules are compiled once
        processes = 1 if parser.parse_args().quick else 7
        starts(processes)
        print()
        runs(processes, folder)
