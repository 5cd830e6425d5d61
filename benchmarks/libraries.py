"""What libraries would take in place of lamc's own code that docs/by-hand.md keeps: `python -m benchmarks.libraries`.

Reading: nodes of `folding_box` by lamc, by ruamel.yaml's compose() and, where PyYAML has it, by libyaml. Units: a text
with a unit split by lamc, and by pint; pint's import and registry in a fresh process.
"""

import statistics
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pint
from ruamel.yaml import YAML

import lamc
from lamc.basics.units import STIFFNESS, to_si
from lamc.readers.inert import compose

REPEATS = 30


def main() -> None:
    path = Path(lamc.__file__).parent / "examples" / "folding_box.yaml"
    text = path.read_text(encoding="utf-8")
    row("nodes of folding_box, lamc", lambda: compose(text, str(path)))
    row("nodes of folding_box, ruamel.yaml compose()", lambda: YAML(typ="safe", pure=True).compose(text))
    libyaml = _libyaml()
    if libyaml is not None:
        row("nodes of folding_box, libyaml", lambda: libyaml(text))
    registry = pint.UnitRegistry()
    row("'3 N*mm/deg', lamc", lambda: to_si("3 N*mm/deg", STIFFNESS))
    row("'3 N*mm/deg', pint", lambda: registry.Quantity("3 N*mm/deg").to("N*m/rad"))
    program = "import time; t = time.perf_counter(); import pint; pint.UnitRegistry(); print(time.perf_counter() - t)"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    print(f"{'pint imported, with its registry':<48} {1e3 * float(done.stdout):9.3f} ms")


def row(name: str, work: Callable[[], object]) -> None:
    times = []
    for _ in range(REPEATS):
        start = time.perf_counter()
        work()
        times.append(time.perf_counter() - start)
    print(f"{name:<48} {1e3 * statistics.median(times):9.3f} ms")


def _libyaml() -> Callable[[str], object] | None:
    try:
        import yaml
    except ImportError:
        return None
    loader = getattr(yaml, "CSafeLoader", None)
    return None if loader is None else lambda text: yaml.compose(text, Loader=loader)


if __name__ == "__main__":
    main()
