"""The picture of the guide's page on healing, docs/healed.png: `python docs/make_healing_picture.py`.

In: the drawing rough.svg in docs/guide/drawings.md. Out: it with its defects enlarged, and the bodies with rings.
"""

import re
import warnings
from pathlib import Path

import matplotlib as mpl
import numpy as np

from lamc.basics.errors import DesignWarning
from lamc.readers.drawings.sheet import sheet_of
from lamc.readers.drawings.svg import read_svg
from lamc.readers.inert import Limits
from lamc.records.card import SheetOptions
from lamc.report.plan_view import fill, ring_mends, view_of
from lamc.report.style import body_colours

DOCS = Path(__file__).parent
COLOURS = {"mountain": "red", "valley": "blue", "border": "black"}
# Where a defect is enlarged, mm: its middle, and the middle of the circle that shows it.
LENSES = (
    ((0.0, 0.0), (-9.0, 6.0)),
    ((20.0, 0.0), (20.0, 9.0)),
    ((40.0, -30.0), (40.0, -39.0)),
    ((50.1, -15.0), (69.0, -15.0)),
)
RADIUS, TIMES = 5.0, 7.0
SHOWN = {
    "hinge extended": (6, 5),
    "hinge cut back": (0, -5),
    "gap in an outline": (-3, 5),
    "stray mark": (0, 4),
    "doubled line": (-8, 4),
}


def main() -> None:
    """Writes the picture."""
    mpl.use("agg")
    import matplotlib.pyplot as plt

    text = re.search(
        r"`rough.svg`.*?\n```\n(.*?)^```$",
        (DOCS / "guide" / "drawings.md").read_text(),
        re.DOTALL | re.MULTILINE,
    )
    assert text is not None
    options = SheetOptions(heal=5e-4)
    drawing = read_svg(text[1].encode(), "rough.svg", options, Limits())
    figure, (drawn, healed) = plt.subplots(1, 2, figsize=(9.6, 3.6), dpi=130)
    for stroke in drawing.strokes:
        points = 1e3 * stroke.points
        drawn.plot(*points.T, color=COLOURS[stroke.role], linewidth=1.6)
        for middle, shown in LENSES:
            lens = plt.Circle(shown, RADIUS, facecolor="#F4F4F4", edgecolor="0.5", linewidth=0.8, zorder=2)
            drawn.add_patch(lens)
            (line,) = drawn.plot(
                *((points - middle) * TIMES + shown).T, color=COLOURS[stroke.role], linewidth=2.0, zorder=3
            )
            line.set_clip_path(lens)
    for middle, shown in LENSES:
        away = np.subtract(shown, middle)
        away = away / np.linalg.norm(away)
        drawn.plot(
            *np.transpose([middle + 1.0 * away, shown - RADIUS * away]), color="0.6", linewidth=0.8, zorder=1
        )
    drawn.set(xlim=(-15, 75), ylim=(-46, 16), aspect="equal", title="as drawn, defects seven times enlarged")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DesignWarning)
        sheet = sheet_of(drawing, options)
    view = view_of(np.array([[0.0, -0.03], [0.06, 0.0]]), 0.06, 4.0)
    colours = body_colours(sheet)
    for body in sheet.bodies:
        fill(
            healed,
            [slab.polygon for slab in body.outline],
            view,
            face=colours[body.name],
            edge="white",
            line=1.5,
        )
    ring_mends(healed, sheet.mends, view)
    for mend in sheet.mends:
        at = 1e3 * np.array(mend.at)
        healed.annotate(mend.what, at, at + SHOWN[mend.what], ha="center", va="center", fontsize=8.5)
    healed.set(xlim=(-15, 75), ylim=(-46, 16), aspect="equal", title="healed within 0.5 mm")
    for axes in (drawn, healed):
        axes.axis("off")
    figure.tight_layout()
    figure.savefig(DOCS / "healed.png")


if __name__ == "__main__":
    main()
