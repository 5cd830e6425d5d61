"""The picture of the guide's page on SVG, docs/svg_roles.png: `python docs/make_svg_picture.py`.

In: the drawing in docs/guide/svg.md. Out: its lines with what they are for, and the device folded from it.
"""

import re
import tempfile
import warnings
from pathlib import Path

import matplotlib as mpl
import numpy as np

import lamc
from lamc.basics.errors import DesignWarning
from lamc.readers.drawings.svg import read_svg
from lamc.readers.inert import Limits
from lamc.records.card import SheetOptions

DOCS = Path(__file__).parent
COLOURS = {
    "mountain": "red",
    "valley": "blue",
    "border": "black",
    "cut": "lime",
    "flat": "gold",
    "undriven": "magenta",
}
# Where the words stand, mm.
WORDS = {
    "rim": ("border", (38, -36.5), "center"),
    "window": ("border within: a hole", (0, 5), "left"),
    "fold1": ("mountain, opacity 0.5: -90°", (25, 11), "center"),
    "rib": ("flat", (50, 5), "center"),
    "fold2": ("valley, opacity 0.25: 45°", (76, 11), "center"),
    "free": ("undriven", (70, -36.5), "center"),
    "slit": ("cut", (90, 5), "center"),
}


def main() -> None:
    """Writes the picture."""
    mpl.use("agg")
    import matplotlib.pyplot as plt

    text = re.search(r"^<svg.*?^</svg>$", (DOCS / "guide" / "svg.md").read_text(), re.DOTALL | re.MULTILINE)
    assert text is not None
    figure = plt.figure(figsize=(9.6, 3.4), dpi=130)
    flat = figure.add_axes((0.01, 0.02, 0.56, 0.96))
    drawing = read_svg(text[0].encode(), "strip.svg", SheetOptions(), Limits())
    for stroke in drawing.strokes:
        points = 1e3 * (np.vstack([stroke.points, stroke.points[:1]]) if stroke.closed else stroke.points)
        angle = stroke.angle
        alpha = 1.0 if angle is None else abs(angle) / np.pi
        flat.plot(*points.T, color=COLOURS[stroke.role], alpha=alpha, linewidth=2.2)
        word, at, align = WORDS[stroke.source.partition("#")[2]]
        near = points[np.argmin(np.hypot(*(points - at).T))]
        for name, place in (("rim", (38.0, -30.0)), ("slit", (90.0, -15.0))):
            if stroke.source.endswith(name):
                near = np.array(place)
        flat.annotate(
            word,
            near,
            at,
            ha=align,
            va="center",
            fontsize=9,
            arrowprops={"arrowstyle": "-", "color": "0.6", "shrinkB": 1, "linewidth": 0.8},
        )
    flat.set(xlim=(-2, 103), ylim=(-39, 14), aspect="equal")
    flat.axis("off")
    with tempfile.TemporaryDirectory() as folder, warnings.catch_warnings():
        warnings.simplefilter("ignore", DesignWarning)
        (Path(folder) / "strip.svg").write_text(text[0])
        sheet = lamc.load(Path(folder) / "strip.svg", fixed=(0.04, -0.01))
        assert isinstance(sheet, lamc.Mechanism)
        folded = figure.add_axes((0.57, 0.0, 0.43, 1.0))
        sheet.draw({j.name: j.rest_angle for j in sheet.joints}, axes=folded, camera=(-60.0, 25.0))
    folded.axis("off")
    figure.savefig(DOCS / "svg_roles.png")


if __name__ == "__main__":
    main()
