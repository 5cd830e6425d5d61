"""What a page takes for a frame, and for a run of the model in it, in a headless browser.

    python -m benchmarks.pages [--quick] [EXAMPLE ...]

In: examples. Out: a table: size of the page; median time of drawing a frame; of stepping the model by a sixtieth of a
second and drawing; of a run anew of the scene's length, the engine warm. A frame of 60 a second is 16.7 ms. Times are
the processor's: a headless browser has no graphics card, and calls of WebGL return before it has drawn. It needs
Chromium and a compiler for WebAssembly. `--quick`: fewer frames.
"""

import argparse
import sys
import tempfile
from pathlib import Path

import numpy as np

import lamc
from benchmarks.measure import seconds, table
from lamc import examples
from lamc.export.pages import result_show
from lamc.readers.load import load_text
from lamc.run.defaults import DURATION
from lamc.view.document import page
from tests.support.browser import CHROMIUM, Page, browser

EXAMPLES = ("pendulum", "four_bar", "crawler", "miura:8x8")
FRAME = 1.0 / 60.0  # s
_DRAWN = """(() => {{
  const show = lamcView.shows[0]; const found = [];
  for (let k = 0; k < {count}; k++) {{
    const began = performance.now();
    show.seek((show.duration * k) / {count});
    show.stage.paint();
    show.curves.forEach((each) => each.paint());
    found.push(performance.now() - began);
  }}
  return found;
}})()"""
_DRIVEN = """(() => {{
  const show = lamcView.shows[0]; const found = [];
  show.drive(true);
  for (let k = 0; k < {count}; k++) {{
    const began = performance.now();
    show.advance({frame});
    show.seek(show.driver.t);
    show.stage.paint();
    show.curves.forEach((each) => each.paint());
    found.push(performance.now() - began);
  }}
  show.drive(false);
  return found;
}})()"""
_RUN = """(() => {
  const show = lamcView.shows[0]; const found = [];
  for (let k = 0; k < 3; k++) {
    const began = performance.now();
    show.engine.run(show.order(), () => true);
    found.push(performance.now() - began);
  }
  return found;
})()"""


def _written(name: str, folder: Path) -> Path:
    example = examples.find(name)
    design = lamc.load(example.path) if example.path else load_text(example.text, example.name)
    simulator = lamc.compile(design)
    end = simulator.scene.duration or DURATION
    result = simulator.run(end, t_eval=np.linspace(0.0, end, 2001))
    path = folder / "page.html"
    path.write_text(page([result_show(result, live=True)]), encoding="utf-8")
    return path


def _row(name: str, tab: Page, folder: Path, count: int) -> list[str]:
    path = _written(name, folder)
    tab.open(path, fragment="#t=0")
    drawn = np.median(tab.value(_DRAWN.format(count=count))) / 1e3
    driven = np.median(tab.value(_DRIVEN.format(count=count, frame=FRAME))) / 1e3
    run = min(tab.value(_RUN)) / 1e3
    size = f"{path.stat().st_size / 1000:.0f} kB"
    return [
        name,
        size,
        seconds(float(drawn)),
        seconds(float(driven)),
        seconds(run),
        "yes" if driven < FRAME else "no",
    ]


def pages(names: list[str], count: int) -> None:
    with tempfile.TemporaryDirectory(prefix="lamc-pages-") as folder, browser() as tab:
        rows = [_row(name, tab, Path(folder), count) for name in names]
    heads = ["example", "page", "drawing", "1/60 s of the model, drawn", "run anew", "60 frames a second"]
    print(table(heads, rows))


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description="Frames and runs of pages, in a headless browser.")
    parser.add_argument("--quick", action="store_true", help="fewer frames")
    parser.add_argument("examples", nargs="*", help=f"default: {' '.join(EXAMPLES)}")
    given = parser.parse_args()
    if CHROMIUM is None:
        sys.exit(
            "no Chromium is on the path: install one (Debian: apt install chromium), or name it in $CHROMIUM"
        )
    pages(given.examples or list(EXAMPLES), 20 if given.quick else 120)
