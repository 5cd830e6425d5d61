"""A patch on one face that lies about its own middle is reported; plies on both faces, and patches that say so, are
not."""

import pytest
from shapely.geometry import LineString, box

from lamc import plate

METAL = plate.Material.isotropic(70e9, 0.3, 2700)
BASE, PATCH = plate.Ply(METAL, 1e-3), plate.Ply(METAL, 0.5e-3)
LEFT, RIGHT = LineString([(0, 0), (0, 0.02)]), LineString([(0.1, 0), (0.1, 0.02)])


def strip(base: plate.Laminate, patched: plate.Laminate) -> plate.Problem:
    mesh = plate.grid(0.1, 0.02, 40, 8, regions={"p": box(0.025, 0, 0.05, 0.02)})
    return plate.Problem(
        mesh,
        {"": base, "p": patched},
        element="dkt+lst",
        supports=[plate.Clamped(LEFT)],
        loads=[plate.EdgeLoad(RIGHT, (1e3, 0, 0))],
    )


def told(problem: plate.Problem) -> list[str]:
    return [note for note in plate.solve(problem).report.notes if "about their own middle" in note]  # type: ignore[union-attr]


def test_patch_on_one_face_about_its_middle_is_reported() -> None:
    problem = strip(plate.Laminate([BASE]), plate.Laminate([BASE, PATCH]))
    (note,) = told(problem)
    assert "region 'p' is 0.5 mm thicker than 'the rest'" in note
    assert "reference: bottom" in note
    assert note in plate.modes(problem, 1).notes
    assert note in plate.buckling(problem, 1, forces=(-1.0, 0.0, 0.0)).notes


@pytest.mark.parametrize("reference", ["bottom", "top"])
def test_patch_with_a_common_face_bends_under_a_pull_and_is_not_told(reference: str) -> None:
    """A pull P along the common face is e = h/2 off the middle of each stretch of a beam, which so has the curvature
    P e / E I; the tip moves by the sum of curvatures times their distance from it: 354 µm."""
    plies = [BASE, PATCH] if reference == "bottom" else [PATCH, BASE]
    problem = strip(plate.Laminate([BASE], reference), plate.Laminate(plies, reference))
    assert not told(problem)
    tip = abs(float(plate.solve(problem).deflection(0.1, 0.01)))  # type: ignore[union-attr]
    bend = {h: 1e3 * 0.5 * h / (70e9 * h**3 / 12) for h in (1e-3, 1.5e-3)}
    beam = sum(
        bend[h] * (0.5 * (0.1 - x0) ** 2 - 0.5 * (0.1 - x1) ** 2)
        for h, x0, x1 in ((1e-3, 0, 0.025), (1.5e-3, 0.025, 0.05), (1e-3, 0.05, 0.1))
    )
    # The clamped edge and the patch keep the strip, five times as long as wide, from curving across: some 2 %.
    assert tip == pytest.approx(beam, rel=0.03)


def test_plies_on_both_faces_are_not_told() -> None:
    both = plate.Laminate([PATCH, BASE, PATCH])
    assert not told(strip(plate.Laminate([BASE]), both))


def test_regions_of_equal_thickness_are_not_told() -> None:
    assert not told(strip(plate.Laminate([BASE]), plate.Laminate([PATCH, PATCH])))
