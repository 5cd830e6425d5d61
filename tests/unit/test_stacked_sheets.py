"""Laminates of two hinged sheets above one another: the bodies and hinges they make, and the refusal of what errs."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from shapely.geometry import Point

from lamc.basics.errors import DesignError, LamcError
from lamc.design.split import split, split_steps
from lamc.readers.load import load
from lamc.records.design import BodyName, Design

LOWER, UPPER = "[low_board, low_film]", "[high_board, high_film]"
# A parallelogram, drawn flat: lower sheet ground | a | b with hinges at 0 and 10 mm, upper sheet ground | c | b with
# hinges at 3 and 13 mm, glued where ground meets ground and where b meets b.
RING = f"""\
units: mm
materials:
  board: {{density: 700, rigid: true}}
  film: {{density: 1420, flexible: true}}
  glue: {{density: 1100, adhesive: true}}
layers:
  - {{name: low_film, material: film, thickness: 0.05}}
  - {{name: low_board, material: board, thickness: 0.3}}
  - {{name: glue, material: glue, thickness: 1}}
  - {{name: high_board, material: board, thickness: 0.3}}
  - {{name: high_film, material: film, thickness: 0.05}}
shapes:
  - {{rect: [-10, 0, 23, 8], layers: [low_film, low_board, high_board, high_film]}}
  - {{rect: [-10, 0, -2, 8], layers: glue}}
  - {{rect: [15, 0, 23, 8], layers: glue}}
hinges:
  - {{name: a1, line: [[0, 0], [0, 8]], layer: low_film, layers: {LOWER}, gap: 0.4}}
  - {{name: a2, line: [[10, 0], [10, 8]], layer: low_film, layers: {LOWER}, gap: 0.4}}
  - {{name: c1, line: [[3, 0], [3, 8]], layer: high_film, layers: {UPPER}, gap: 0.4}}
  - {{name: c2, line: [[13, 0], [13, 8]], layer: high_film, layers: {UPPER}, gap: 0.4}}
fixed:
  - {{rect: [-10, 0, -6, 8], layers: glue}}
bodies:
  ground: [-8, 4]
  a: {{at: [5, 4], layer: low_board}}
  b: [20, 4]
  c: {{at: [5, 4], layer: high_board}}
"""


UNNAMED = RING[: RING.index("bodies:")]


def drawn(tmp_path: Path, text: str) -> Design:
    file = tmp_path / "sheets.yaml"
    file.write_text(text, encoding="utf-8")
    record = load(file)
    assert isinstance(record, Design)
    return record


def refusal(tmp_path: Path, text: str) -> str:
    with pytest.raises(LamcError) as caught:
        split(drawn(tmp_path, text))
    return str(caught.value).removeprefix(str(tmp_path / "sheets.yaml"))


def test_two_sheets_glued_at_their_ends_are_a_ring(tmp_path: Path) -> None:
    mechanism = split(drawn(tmp_path, RING))
    assert sorted(body.name for body in mechanism.bodies) == ["a", "b", "c", "ground"]
    ends = {j.name: {j.parent, j.child} for j in mechanism.joints}
    assert ends == {"a1": {"ground", "a"}, "a2": {"a", "b"}, "c1": {"ground", "c"}, "c2": {"c", "b"}}
    places = {j.name: tuple(np.round(j.point * 1e3, 9)) for j in mechanism.joints}  # mm
    low, high = 0.05 / 2, 0.05 + 0.3 + 1 + 0.3 + 0.05 / 2
    assert places == {
        "a1": (0, 4, low),
        "a2": (10, 4, low),
        "c1": (3, 4, high),
        "c2": (13, 4, high),
    }
    assert all(tuple(j.axis) == (0.0, 1.0, 0.0) for j in mechanism.joints)


def test_hinges_that_cross_in_different_sheets_leave_each_other_alone(tmp_path: Path) -> None:
    """The upper hinge runs over the lower one, square to it, and no material is taken where they cross in plan."""
    glued = RING[: RING.index("shapes:")] + (
        "shapes:\n"
        "  - {rect: [-10, -10, 10, 10], layers: [low_film, low_board, high_board, high_film]}\n"
        "  - {rect: [-10, -10, -2, -2], layers: glue}\n"
        "hinges:\n"
        f"  - {{name: below, line: [[0, -10], [0, 10]], layer: low_film, layers: {LOWER}, gap: 0.4}}\n"
        f"  - {{name: above, line: [[-10, 0], [10, 0]], layer: high_film, layers: {UPPER}, gap: 0.4}}\n"
        "fixed:\n"
        "  - {rect: [-10, -10, -6, -6], layers: glue}\n"
    )
    steps = split_steps(drawn(tmp_path, glued))
    assert all(hole.is_empty for hole in steps.holes)
    assert len(steps.mechanism.bodies) == 3
    slit = 2 * 0.02  # mm
    masses = sorted(body.mass for body in steps.mechanism.bodies if not body.fixed)
    sheet = (20 - slit) / 2 * 20 * (0.3 * 700 + 0.05 * 1420) * 1e-9  # kg
    assert masses == pytest.approx([sheet, sheet], rel=1e-12)  # round-off


def test_a_hinge_through_the_other_sheet_too_is_reported(tmp_path: Path) -> None:
    """All layers are the default; in a design of several sheets it would cut the others in two and join nothing."""
    text = UNNAMED.replace(f"layer: low_film, layers: {LOWER}", "layer: low_film")
    message = refusal(tmp_path, text)
    assert "hinge 'a1' at (0, 4) mm runs through layers 'high_board', 'high_film' too" in message
    assert "where it cuts 'link_1', which it does not join" in message
    assert "joins the bodies in its flexible layer, 'low_film'" in message


def test_glue_under_a_hinge_is_reported(tmp_path: Path) -> None:
    text = UNNAMED.replace("rect: [15, 0, 23, 8]", "rect: [8, 0, 23, 8]")
    message = refusal(tmp_path, text)
    assert "hinge 'a2' at (10, 4) mm touches 1 body" in message
    assert (
        "material of layers 'glue', 'high_board', 'high_film' lies across it and holds its two sides"
        in message
    )


def test_a_hinge_says_which_of_two_films_bends(tmp_path: Path) -> None:
    message = refusal(tmp_path, RING.replace("layer: low_film, layers", "layers"))
    assert "hinges[0]: the hinge names no layer, and 2 layers are flexible; say which bends" in message


def test_the_same_line_in_both_sheets_locks_two_bodies(tmp_path: Path) -> None:
    text = UNNAMED.replace("[[3, 0], [3, 8]]", "[[0, 0], [0, 8]]").replace(
        "[[13, 0], [13, 8]]", "[[10, 0], [10, 8]]"
    )
    text = text.replace("rect: [15, 0, 23, 8]", "rect: [1, 0, 9, 8]")
    message = refusal(tmp_path, text)
    assert "but do not lie on one line, so neither can turn" in message


def test_names_by_points_that_fit_no_single_body_are_reported(tmp_path: Path) -> None:
    message = refusal(tmp_path, RING.replace("{at: [5, 4], layer: low_board}", "[5, 4]"))
    assert "names body 'a', (5, 4) mm, lies in 2 bodies" in message
    assert "or say in which layer: {at: [x, y], layer: …}" in message
    message = refusal(tmp_path, RING.replace("{at: [5, 4], layer: low_board}", "{at: [5, 4], layer: glue}"))
    assert "lies in 0 bodies of layer 'glue'; move it" in message
    message = refusal(tmp_path, RING.replace("layer: low_board}", "layer: low_bord}"))
    assert "bodies.a.layer: no layer is named 'low_bord'; did you mean 'low_board'?" in message
    message = refusal(tmp_path, RING.replace("{at: [5, 4], layer: low_board}", "{at: [5], layer: low_board}"))
    assert "bodies.a.at" in message


def test_a_layer_that_a_record_does_not_have_is_reported(tmp_path: Path) -> None:
    design = replace(drawn(tmp_path, RING), body_names=(BodyName("a", Point(0.005, 0.004), 7),))
    with pytest.raises(DesignError, match="body 'a' refers to layer 7; the design has layers 0 to 4"):
        split(design)


def test_a_crease_pattern_drawn_anywhere_meets_in_a_point(tmp_path: Path) -> None:
    """Far from the origin, at an angle that no coordinate shows: the axes still pass through the drawn point."""
    x, y = 371.3, -129.7
    ends = [(x + 40 * np.cos(np.radians(a)), y + 40 * np.sin(np.radians(a))) for a in (17, 77, 152, 272)]
    lines = "".join(f"    - [[{x}, {y}], [{float(px)!r}, {float(py)!r}]]\n" for px, py in ends)
    text = (
        "units: mm\nmaterials:\n  film: {density: 1420, flexible: true}\n"
        "layers:\n  - {name: film, material: film, thickness: 0.1}\n"
        f"shapes:\n  - circle: {{center: [{x}, {y}], radius: 30}}\n"
        f"hinges:\n  - gap: 1\n    lines:\n{lines}"
        f"fixed:\n  - circle: {{center: [{x + 13.6}, {y + 14.6}], radius: 2}}\n"
    )
    mechanism = split(drawn(tmp_path, text))
    assert (len(mechanism.bodies), len(mechanism.joints)) == (4, 4)
    centre = np.array([x, y, 0.05]) * 1e-3
    for joint in mechanism.joints:
        miss = np.linalg.norm(np.cross(centre - joint.point, joint.axis))
        assert miss <= 4 * np.spacing(0.4)  # m: round-off of coordinates of 0.4 m
