"""The picture of a stack: what is drawn where, by reading the drawing back."""

from pathlib import Path

import matplotlib.image
import numpy as np
import pytest
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure

from lamc import plate
from lamc.basics.errors import LamcError
from lamc.plate import Laminate, Ply
from lamc.report.laminate_picture import draw_stack, tint
from lamc.report.style import PALETTE

STEEL, KAPTON = plate.material("steel"), plate.material("Kapton HN")


def column(path: Path) -> np.ndarray:
    """Colours from the top down along a line through the plies, right of the labels."""
    image = matplotlib.image.imread(path)[..., :3]
    return image[:, int(0.85 * image.shape[1])]


def share_of(path: Path, colour: str) -> float:
    """Part of the line that has a material's colour."""
    return float((np.abs(column(path) - tint(colour)).max(axis=1) < 0.01).mean())


def test_plies_are_drawn_to_scale_with_the_lowest_at_the_bottom(tmp_path: Path) -> None:
    path = draw_stack(
        Laminate([Ply(STEEL, 3e-3), Ply(KAPTON, 2e-3)]), tmp_path / "stack.png", "a $title_ of 5 %"
    )
    # Isotropic plies have no hatching; outlines take a pixel or two of some hundred.
    assert share_of(path, PALETTE[0]) / share_of(path, PALETTE[1]) == pytest.approx(1.5, rel=0.05)
    colours = column(path)
    steel, kapton = (np.abs(colours - tint(c)).max(axis=1) < 0.01 for c in PALETTE[:2])
    assert np.flatnonzero(steel).min() > np.flatnonzero(kapton).max()


def test_thin_ply_can_be_seen(tmp_path: Path) -> None:
    """A film of a thousandth of the thickness keeps a tenth of the picture or more."""
    path = draw_stack(Laminate([Ply(STEEL, 3e-3), Ply(KAPTON, 3e-6)]), tmp_path / "stack.png")
    assert share_of(path, PALETTE[1]) > 0.1


def test_gap_stays_white_and_far_reference_is_no_obstacle(tmp_path: Path) -> None:
    hollow = Laminate([Ply(STEEL, 1e-3), Ply(STEEL, 1e-3, gap=2e-3)], reference=0.1)
    path = draw_stack(hollow, tmp_path / "stack.png")
    colours = np.abs(column(path) - tint(PALETTE[0])).max(axis=1) < 0.01
    inside = np.flatnonzero(colours)
    assert 0.35 < 1 - colours[inside.min() : inside.max()].mean() < 0.65  # half of it


def test_the_reference_surface_does_not_strike_a_label_through(tmp_path: Path) -> None:
    """The middle ply's label stands where z = 0 is: its white ground interrupts the red line."""
    path = draw_stack(Laminate([Ply(STEEL, 1e-3)] * 3), tmp_path / "stack.png")
    image = matplotlib.image.imread(path)[..., :3]
    red = (image[..., 0] > 0.5) & (image[..., 1] < 0.2) & (image[..., 2] < 0.3)
    line = int(red.sum(axis=1).argmax())
    middle = slice(int(0.45 * image.shape[1]), int(0.55 * image.shape[1]))
    assert red[line].mean() > 0.3
    assert not red[:, middle].any()


@pytest.mark.parametrize("angle", [0.0, 22.5, 45.0, 90.0, -60.0])
def test_strokes_have_the_angle_of_the_fibres_on_paper(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, angle: float
) -> None:
    kept: list[Figure] = []
    monkeypatch.setattr(
        "lamc.report.laminate_picture.save", lambda figure, path: (kept.append(figure), path)[1]
    )
    draw_stack(Laminate([Ply(plate.material("T300/5208"), 1e-4, angle)]), tmp_path / "stack.png")
    (axis,) = kept[0].axes
    (strokes,) = axis.collections
    assert isinstance(strokes, LineCollection)
    ends = [axis.transData.transform(each) for each in strokes.get_segments()]  # pixels
    assert len(ends) > 5
    for start, end in ends:
        x, y = end - start
        rotation = np.degrees(np.arctan2(y, x)) - angle
        assert abs((rotation + 90.0) % 180.0 - 90.0) < 1e-6  # round-off of some hundred pixels


@pytest.mark.slow
def test_same_laminate_gives_the_same_picture(tmp_path: Path) -> None:
    laminate = Laminate.parse("[0/90/±45/22.5]10s", plate.material("T300/5208"), 1e-4)
    one, other = (draw_stack(laminate, tmp_path / name).read_bytes() for name in ("a.png", "b.png"))
    assert one == other


def test_other_files_are_refused(tmp_path: Path) -> None:
    with pytest.raises(LamcError, match=r"cannot draw into 'stack.gif'; the name must end in .png"):
        draw_stack(Laminate([Ply(STEEL, 1e-3)]), tmp_path / "stack.gif")
