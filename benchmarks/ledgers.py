"""The ledgers that the repository keeps: what accuracy costs on five designs of the gallery.

    python -m benchmarks.ledgers [NAME …] [--budget '2 min'] [--out docs/ledgers]

Each is `lamc ledger --example NAME` with the end below; its record and its picture are kept as NAME.json and NAME.png.
Peers appear where they are installed (the bench extra).
"""

import argparse
import shutil
import tempfile
from pathlib import Path

from benchmarks.measure import ROOT
from lamc import examples
from lamc.cli import main as lamc

# Name → example, and the end of the run, s, None for its scene's own: long enough for the motion to show.
LEDGERS = {
    "triple_pendulum": ("pendulum", 5.0),
    "four_bar": ("four_bar", 5.0),
    "miura": ("miura:3x3", 2.0),
    "stiff_triple": ("stiff_triple", 2.0),
    "flapping_wing": ("flapping_wing", None),
}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument(
        "names", nargs="*", metavar="NAME", help=f"of {', '.join(LEDGERS)}; all, if none is named"
    )
    parser.add_argument("--budget", default="2 min", help="for each")
    parser.add_argument("--out", type=Path, default=ROOT / "docs" / "ledgers")
    arguments = parser.parse_args()
    for name in arguments.names or LEDGERS:
        if name not in LEDGERS:
            parser.error(f"no ledger is named {name!r}; there are {', '.join(LEDGERS)}")
        example, t_end = LEDGERS[name]
        if example.partition(":")[0] not in examples.names():
            print(f"{name} is left out: there is no example {example!r}")
            continue
        make(example, t_end, arguments.budget, arguments.out / name)


def make(example: str, t_end: float | None, budget: str, kept: Path) -> None:
    """Measures one and keeps its files beside `kept`, which has no suffix."""
    kept.parent.mkdir(parents=True, exist_ok=True)
    end = [] if t_end is None else ["--t-end", str(t_end)]
    with tempfile.TemporaryDirectory() as folder:
        words = ["ledger", "--example", example, *end, "--budget", budget, "--out", folder]
        code = lamc.main(words, standalone_mode=False)
        if code:
            raise SystemExit(code)
        for kind in ("json", "png"):
            shutil.copyfile(Path(folder) / f"ledger.{kind}", kept.with_suffix(f".{kind}"))


if __name__ == "__main__":
    main()
