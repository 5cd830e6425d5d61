"""The picture of the guide's page on cut files, docs/cut.png: `python docs/make_cut_picture.py`.

In: the example `flaps`. Out: its lower boards and film near a hinge in each style, lines beside edges for a kerf, and a
sheet with its frame and pins, all drawn from the lines that an export writes.
"""

import io
from pathlib import Path

import ezdxf
import matplotlib as mpl
import numpy as np
from shapely.geometry import Polygon

import lamc
from lamc import examples
from lamc.export import files_of
from lamc.export.options import options_from

COLOURS = {"1_holes": "tab:blue", "2_slits": "tab:red", "3_outline": "black", "4_reference": "0.6"}
NEAR = ((-23.0, -17.0), (-0.8, 8.2))  # mm, about the left hinge
BOARD, FILM = "#d9c8a9", "#f3dd9c"


def lines(layer: str, **options: object) -> list[tuple[str, bool, np.ndarray]]:
    """(layer of the file, closed, points in mm) of one drawing."""
    path = examples.find("flaps").path
    assert path is not None
    made = files_of(lamc.load(path), "cut", options=options_from(**options))
    text = next(data for name, data in made.items() if name.endswith(f"_{layer}.dxf")).decode("cp1252")
    return [
        (each.dxf.layer, each.closed, np.array(each.get_points("xy")))
        for each in ezdxf.read(io.StringIO(text)).modelspace()
    ]


def draw(axes, found, fill: str, *, kerf: float = 0.0) -> None:
    """Parts filled, and the lines over them."""
    for name, _, points in found:
        if name == "3_outline":
            part = Polygon(points).buffer(-0.5 * kerf, join_style="mitre")
            axes.fill(*np.array(part.exterior.coords).T, color=fill)
    for name, closed, points in found:
        ring = np.vstack([points, points[:1]]) if closed else points
        axes.plot(*ring.T, color=COLOURS[name], linewidth=1.1 if closed else 1.8)


def main() -> None:
    """Writes the picture."""
    mpl.use("agg")
    import matplotlib.pyplot as plt

    figure, panels = plt.subplots(1, 5, figsize=(11.0, 3.5), dpi=130, width_ratios=(1, 1, 1, 1, 3.0))
    shown = (
        ("gap: boards", "lower", {}, BOARD),
        ("castellated: boards", "lower", {"hinge_style": "castellated, 2 mm"}, BOARD),
        ("perforated: film", "film", {"hinge_style": "perforated, 2 mm"}, FILM),
        ("kerf of 0.3 mm", "lower", {"kerf": "0.3 mm"}, BOARD),
    )
    for axes, (title, layer, options, fill) in zip(panels, shown, strict=False):
        draw(axes, lines(layer, **options), fill, kerf=1e3 * options_from(**options).kerf)
        axes.plot((-20, -20), (-9, 20), color="tab:red", linestyle=(0, (1, 3)), linewidth=0.8)
        axes.set(xlim=(-21.2, -18.8), ylim=(-0.8, 8.2), title=title)
        axes.set_xticks((-21, -20, -19))
        axes.set_yticks((0, 4, 8))
    panels[0].set_ylabel("mm; x is drawn larger than y")
    sheet = panels[-1]
    draw(sheet, lines("lower", stock="150 mm x 60 mm", pins="3 mm"), BOARD)
    sheet.set(title="a sheet, 150 mm x 60 mm, with pins of 3 mm", aspect="equal")
    for name, at in (("1_holes", (14, 52)), ("3_outline", (52, 41)), ("4_reference", (75, -6))):
        sheet.text(*at, name, color=COLOURS[name], ha="center", va="center", fontsize=8)
    sheet.set_ylim(-11, 63)
    for axes in panels:
        axes.tick_params(labelsize=7)
        axes.title.set_fontsize(9)
    figure.tight_layout()
    figure.savefig(Path(__file__).parent / "cut.png", metadata={"Software": None})


if __name__ == "__main__":
    main()
