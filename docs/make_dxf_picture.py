"""The drawing and the picture of the guide's page on DXF, docs/strip.dxf and docs/dxf_layers.png:
`python docs/make_dxf_picture.py`.

In: nothing. Out: a drawing with a line for each of the usual layers, as small as DXF may be, and its picture with the
device folded from it.
"""

import tempfile
import warnings
from pathlib import Path

import matplotlib as mpl
import numpy as np

import lamc
from lamc.basics.errors import DesignWarning
from lamc.readers.drawings.dxf import read_dxf
from lamc.readers.inert import Limits
from lamc.records.card import SheetOptions

DOCS = Path(__file__).parent
COLOURS = {
    "mountain": "red",
    "valley": "blue",
    "border": "black",
    "hole": "black",
    "cut": "lime",
    "flat": "gold",
    "hinge": "darkorange",
}
# Layer: the words, where they stand and where they point, mm.
WORDS = {
    "body": ("body: an outline", (38, -7), (38, 0)),
    "holes": ("holes", (4, 35), (8, 19)),
    "mountain_90": ("mountain_90: rests at -90°", (25, 42), (25, 30)),
    "facet": ("facet: stays flat", (50, 35), (50, 30)),
    "fold(45)": ("fold(45): rests at 45°", (74, 42), (70, 30)),
    "hinge": ("hinge: rests flat", (70, -7), (70, 0)),
    "cuts": ("cuts", (100, 35), (100, 15)),
}
LINES = {
    "mountain_90": (25, 0, 25, 30),
    "facet": (50, 0, 50, 30),
    "fold(45)": (70, 15, 70, 30),
    "hinge": (70, 0, 70, 15),
    "cuts": (70, 15, 115, 15),
}


def strip() -> str:
    """The file, R2000: groups of a code and a value, a line each."""
    groups: list[tuple[int, object]] = [(0, "SECTION"), (2, "HEADER"), (9, "$ACADVER"), (1, "AC1015")]
    groups += [(9, "$INSUNITS"), (70, 4), (0, "ENDSEC"), (0, "SECTION"), (2, "ENTITIES")]
    groups += [(0, "LWPOLYLINE"), (5, "20"), (100, "AcDbEntity"), (8, "body"), (100, "AcDbPolyline")]
    groups += [(90, 4), (70, 1), (10, 0.0), (20, 0.0), (10, 100.0), (20, 0.0), (42, 1.0)]
    groups += [(10, 100.0), (20, 30.0), (10, 0.0), (20, 30.0)]
    groups += [(0, "CIRCLE"), (5, "21"), (8, "holes"), (10, 12.0), (20, 15.0), (30, 0.0), (40, 6.0)]
    for handle, (layer, (x1, y1, x2, y2)) in enumerate(LINES.items(), 0x22):
        groups += [(0, "LINE"), (5, f"{handle:X}"), (8, layer), (10, float(x1)), (20, float(y1)), (30, 0.0)]
        groups += [(11, float(x2)), (21, float(y2)), (31, 0.0)]
    groups += [(0, "ENDSEC"), (0, "EOF")]
    return "".join(f"{code}\n{value}\n" for code, value in groups)


def main() -> None:
    """Writes both."""
    mpl.use("agg")
    import matplotlib.pyplot as plt

    file = DOCS / "strip.dxf"
    file.write_text(strip(), encoding="ascii")
    figure = plt.figure(figsize=(9.6, 3.4), dpi=130)
    flat = figure.add_axes((0.01, 0.02, 0.56, 0.96))
    for stroke in read_dxf(file.read_bytes(), "strip.dxf", SheetOptions(), Limits()).strokes:
        points = 1e3 * (np.vstack([stroke.points, stroke.points[:1]]) if stroke.closed else stroke.points)
        flat.plot(*points.T, color=COLOURS[stroke.role], linewidth=2.2, solid_capstyle="butt")
    for word, at, to in WORDS.values():
        line = {"arrowstyle": "-", "color": "0.6", "shrinkB": 1, "linewidth": 0.8}
        flat.annotate(word, to, at, ha="center", va="center", fontsize=9, arrowprops=line)
    flat.set(xlim=(-6, 119), ylim=(-12, 47), aspect="equal")
    flat.axis("off")
    with tempfile.TemporaryDirectory() as folder, warnings.catch_warnings():
        warnings.simplefilter("ignore", DesignWarning)
        copy = Path(folder) / file.name
        copy.write_bytes(file.read_bytes())
        sheet = lamc.load(copy, fixed=(0.04, 0.01))
        assert isinstance(sheet, lamc.Mechanism)
        folded = figure.add_axes((0.57, 0.0, 0.43, 1.0))
        sheet.draw({j.name: j.rest_angle for j in sheet.joints}, axes=folded, camera=(-60.0, 25.0))
    folded.axis("off")
    figure.savefig(DOCS / "dxf_layers.png")


if __name__ == "__main__":
    main()
