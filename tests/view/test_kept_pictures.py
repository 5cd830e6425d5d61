"""Frames of five examples against kept pictures: what a page draws, from camera to shadow, stays what was looked at.

`pytest --update-golden` writes them anew, from what the browser at hand draws; look at them before they are kept.
"""

import base64
import io
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest
from PIL import Image

from lamc.basics.times import Times
from lamc.commands.plate_input import PlateSource, load_source
from lamc.commands.plate_work import answers
from lamc.export.pages import mechanism_show, result_show
from lamc.view.document import Show, page
from lamc.view.plates import report_show
from tests.support.browser import Page, browser, needs_browser
from tests.support.ctools import needs_cc
from tests.support.exported_folders import mechanism_of
from tests.support.pages import run

pytestmark = [needs_cc, needs_browser]
KEPT = Path(__file__).parent / "kept"
SIZE = (240, 160)  # pixels that are compared: each is a mean of some six of the page's
# Drivers and versions of browsers smooth edges of bodies, lines and shadows differently, by up to a pixel of the page:
# a sixth of the contrast in those of the compared pixels that edges cross, about a tenth of all.
MEAN = 2.0  # of 255
FAR, SHARE = 50, 0.01  # pixels of another colour altogether

Pixels = npt.NDArray[np.int64]

DRAW = """(() => {
  const { stage } = lamcView.shows[0];
  lamcView.player.play(false);
  %s
  stage.paint();
  return stage.canvas.toDataURL("image/png");
})()"""
EXAMPLES = {
    "four_bar": "lamcView.player.seek(0.35);",
    "pendulum": "lamcView.player.seek(0.6);",
    "crawler": "lamcView.player.seek(0.1);",
    "vertex": "lamcView.shows[0].sliders.angles.find((each) => each.name === 'c1').take(0.9, true);",
    "modes": "lamcView.player.seek(0.75);",
}


@pytest.fixture(scope="module")
def tab() -> Iterator[Page]:
    with browser() as page:
        yield page


def show_of(name: str) -> Show:
    if name == "modes":
        file, origin = load_source(PlateSource(None, name))
        return report_show(answers(file, origin, None, "auto", Times()))
    if name == "vertex":
        return mechanism_show(mechanism_of(name))
    return result_show(run(name, 0.2 if name == "crawler" else 1.0), live=False)


def drawn(name: str, before: str, tab: Page, folder: Path) -> Pixels:
    """What the canvas has, shrunk: without words, whose fonts are the machine's."""
    path = folder / f"{name}.html"
    path.write_text(page([show_of(name)]), encoding="utf-8")
    tab.open(path, width=1000, height=800, fragment="#t=0")
    tab.wait("lamcView.shows[0].stage.frames.length > 0")
    data = tab.value(DRAW % before)
    with Image.open(io.BytesIO(base64.b64decode(data.partition(",")[2]))) as picture:
        drawing = picture.convert("RGBA")
        paper = Image.new("RGBA", drawing.size, "white")  # the page behind shows through
        whole = Image.alpha_composite(paper, drawing).convert("RGB")
    small = whole.resize(SIZE, Image.Resampling.BOX)
    return np.asarray(small).astype(int)


def is_like(one: Pixels, other: Pixels) -> bool:
    apart = np.abs(one - other).max(axis=2)
    return bool(apart.mean() <= MEAN and (apart > FAR).mean() <= SHARE)


@pytest.mark.parametrize("name", EXAMPLES)
def test_a_frame_is_what_was_kept(
    name: str, tab: Page, tmp_path: Path, request: pytest.FixtureRequest
) -> None:
    found = drawn(name, EXAMPLES[name], tab, tmp_path)
    kept = KEPT / f"{name}.png"
    if request.config.getoption("--update-golden"):
        kept.parent.mkdir(exist_ok=True)
        Image.fromarray(found.astype(np.uint8)).save(kept, optimize=True)
    with Image.open(kept) as picture:
        expected = np.asarray(picture.convert("RGB")).astype(int)
    apart = np.abs(found - expected).max(axis=2)
    seen = tmp_path / f"{name}.png"
    Image.fromarray(found.astype(np.uint8)).save(seen)
    told = f"{seen} is off by {apart.mean():.2f} of 255, {100 * (apart > FAR).mean():.2f} % of it far: {kept}"
    assert is_like(found, expected), told


def test_another_instant_is_told_apart(tab: Page, tmp_path: Path) -> None:
    """The limits are narrow enough: the crank turned a little farther is another picture."""
    pictures = [drawn("four_bar", f"lamcView.player.seek({t});", tab, tmp_path) for t in (0.35, 0.37)]
    assert not is_like(*pictures)
