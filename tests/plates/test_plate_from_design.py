"""Bodies of designs as plates: areas and masses against the drawing, edges at hinges, slivers, and what is refused."""

import dataclasses
import math

import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st
from shapely.geometry import LineString, MultiPolygon, box

import lamc
from lamc import examples, plate
from lamc.basics.errors import DesignError
from lamc.design.split import split_steps
from lamc.design.steps import SplitSteps
from lamc.plates.designs.overlay import is_sliver, overlay, stack_name
from lamc.plates.records import DesignPlate
from lamc.readers.load import load_text
from lamc.records.design import Design

KAPTON, T300 = plate.material("Kapton HN"), plate.material("T300/5208")

# Two links of board, glue, film, board, 20 and 30 mm long and 10 mm wide, hinged at x = 0; the stiff layers are open by
# one hinge width, 0.5 mm, to both sides. Fixed at the left. The left link has a window in its upper board.
TWO_LINKS = """
kind: design
name: two links
units: mm
materials:
  board: {density: 1600 kg/m^3, E1: 60 GPa, poisson: 0.3, rigid: true}
  glue: {density: 1100 kg/m^3, E1: 1 GPa, poisson: 0.4, adhesive: true}
  film: {density: 1420 kg/m^3, E1: 2.5 GPa, poisson: 0.34, flexible: true}
layers:
  - {name: lower, material: board, thickness: 0.3}
  - {name: glue, material: glue, thickness: 0.05}
  - {name: film, material: film, thickness: 0.025}
  - {name: upper, material: board, thickness: 0.2, angle: 30 deg}
shapes:
  - {rect: [-20, 0, 30, 10]}
  - {cut: {rect: [-0.5, 0, 0.5, 10]}, layers: [lower, glue, upper]}
  - {cut: {rect: [-15, 2, -10, 6]}, layers: upper}
hinges:
  - {name: h, line: [[0, 0], [0, 10]], gap: 1, layer: film}
fixed:
  - {rect: [-20, 0, -18, 10]}
bodies: {left: [-5, 5], right: [5, 5]}
"""
MM2 = 1e-6
# Coordinates are brought to a grid of 1e-8 mm or less: some cm of edge times that.
SNAPPED = 1e-6 * MM2


def two_links() -> Design:
    design = load_text(TWO_LINKS, "two.yaml")
    assert isinstance(design, Design)
    return design


def areas(found: DesignPlate) -> dict[str, float]:
    return {name: region.area / MM2 for name, region in found.regions.items()}


# --- one hinge, by hand ----------------------------------------------------------------------------------------------


def test_regions_of_a_link_are_those_that_were_drawn() -> None:
    """Left link as cut: 19.5 x 10 of stack, 5 x 4 of it without the upper board, film up to 0.05 mm from the line."""
    found = plate.plate_of(two_links(), "left")
    expected = {"all layers": 175.0, "all but upper": 20.0, "film": 0.45 * 10}
    assert areas(found) == pytest.approx(expected, rel=1e-9)
    window = box(-0.015, 0.002, -0.010, 0.006)
    assert shapely.symmetric_difference(found.regions["all but upper"], window).area < SNAPPED
    assert found.fixed.area == pytest.approx(20 * MM2, rel=1e-9)
    assert found.notes == ()


def test_laminates_of_all_regions_share_one_surface() -> None:
    """Heights above the reference surface, plus its own height, are those of the layers in the drawing."""
    design = two_links()
    found = plate.plate_of(design, "left")
    assert found.height == pytest.approx(0.575e-3 / 2)  # the middle of the largest region
    stacks = {"all layers": [0, 1, 2, 3], "all but upper": [0, 1, 2], "film": [2]}
    for name, layers in stacks.items():
        laminate = found.laminates[name]
        drawn = [[design.z[k], design.z[k + 1]] for k in layers]
        np.testing.assert_allclose(laminate.heights + found.height, drawn, rtol=0, atol=1e-18)
    assert [p.material.name for p in found.laminates["all layers"].plies] == [
        "board",
        "glue",
        "film",
        "board",
    ]
    assert [p.angle for p in found.laminates["all layers"].plies] == pytest.approx([0, 0, 0, 30])
    lowered = plate.plate_of(design, "left", height=0.0)
    assert lowered.laminates["film"].heights == pytest.approx(np.array([[0.35e-3, 0.375e-3]]))


def test_plate_without_what_bends_ends_at_its_stiff_layers() -> None:
    left, right = (plate.plate_of(two_links(), body, hinges="lines") for body in ("left", "right"))
    assert areas(left) == pytest.approx({"all layers": 175.0, "all but upper": 20.0}, rel=1e-9)
    assert left.hinges["h"].neighbour == "right"
    assert right.hinges["h"].neighbour == "left"
    for found, x in ((left, -0.5e-3), (right, 0.5e-3)):
        line = found.hinges["h"].line
        assert line.hausdorff_distance(LineString([(x, 0), (x, 0.01)])) < 1e-12
        assert found.outline.boundary.distance(line) < 1e-12


def test_strip_reaches_from_link_to_link() -> None:
    found = plate.plate_of(two_links(), "left", hinges="strips")
    expected = {"all layers": 175.0, "all but upper": 20.0, "hinge h": 10.0}
    assert areas(found) == pytest.approx(expected, rel=1e-9)
    assert (
        shapely.symmetric_difference(found.regions["hinge h"], box(-0.5e-3, 0, 0.5e-3, 0.01)).area < SNAPPED
    )
    far = found.hinges["h"].line
    assert far.length == pytest.approx(0.01, rel=1e-9)
    assert far.bounds[0] == far.bounds[2] == pytest.approx(0.5e-3)
    assert [p.material.name for p in found.laminates["hinge h"].plies] == ["film"]


def test_both_links_hang_together_by_their_strip() -> None:
    """All that was drawn, in one piece, and no hinge leads out of it."""
    found = plate.plate_of(two_links(), ["left", "right"], hinges="strips")
    assert areas(found) == pytest.approx(
        {"all layers": 470.0, "all but upper": 20.0, "hinge h": 10.0}, rel=1e-9
    )
    assert found.outline.geom_type == "Polygon"
    assert not found.hinges
    assert found.name == "left+right"


def test_strip_ends_where_the_neighbour_is_stiff() -> None:
    """Board of the right link up to 0.2 mm from the line: the strip is shorter there, and so is the line at its end."""
    text = TWO_LINKS.replace("rect: [-0.5, 0, 0.5, 10]", "rect: [-0.5, 0, 0.2, 10]")
    design = load_text(text, "two.yaml")
    assert isinstance(design, Design)
    found = plate.plate_of(design, "left", hinges="strips")
    assert areas(found)["hinge h"] == pytest.approx(7.0, rel=1e-9)
    assert found.hinges["h"].line.bounds[0] == pytest.approx(0.2e-3)


def deflection_at_the_end(found: DesignPlate, held: plate.Clamped | plate.Hinged, load: float) -> float:
    """Of the right link, m, where a load pulls its end up."""
    sizes = {name: 0.25e-3 for name in found.regions if name.startswith("hinge")}
    cells = plate.mesh(found.outline, 2e-3, regions=found.regions, sizes=sizes)
    pull = plate.EdgeLoad(LineString([(30e-3, 0), (30e-3, 10e-3)]), load / 10e-3)
    solution = plate.solve(plate.Problem(cells, found.laminates, supports=[held], loads=[pull]))
    assert isinstance(solution, plate.Solution)
    return float(solution.deflection(30e-3, 5e-3))


def test_flap_on_its_hinge_turns_as_the_hinge_stiffness_says() -> None:
    """The film is 1e4 times softer than the link, so the end goes up by P/k times the square of the arm: the mean of
    the square over a strip, from 29.5 to 30.5 mm, or 29.5 mm to the edge that a spring holds."""
    load, design = 1e-3, two_links()
    right = {hinges: plate.plate_of(design, "right", hinges=hinges) for hinges in ("strips", "lines")}
    k = plate.hinge_stiffness(right["strips"].laminates["hinge h"], 1e-3, 10e-3)
    strip = deflection_at_the_end(right["strips"], plate.Clamped(right["strips"].hinges["h"].line), load)
    # What curls at the strip's ends is 0.4 % of k; a mesh of four cells across is stiffer by some of that.
    assert strip == pytest.approx(load / k.plate_formula * (30.5**3 - 29.5**3) / 3 * MM2, rel=5e-3)
    assert k.finite_element is not None
    spring = plate.Hinged(right["lines"].hinges["h"].line, k.finite_element / 10e-3)
    line = deflection_at_the_end(right["lines"], spring, load)
    # The link's own bending, of its length cubed over 3 times its stiffness: 4e-5 of the rotation's part.
    assert line == pytest.approx(load / k.finite_element * 29.5**2 * MM2, rel=2e-4)


# --- all examples ----------------------------------------------------------------------------------------------------


def steps_of(name: str) -> SplitSteps:
    example = examples.find(name)
    design = lamc.load(example.path) if example.path is not None else load_text(example.text, example.name)
    assert isinstance(design, Design)
    return split_steps(design)


def drawn_examples() -> list[str]:
    names = []
    for name in examples.names():
        example = examples.find(name)
        text = example.text if example.path is None else example.path.read_text(encoding="utf-8")
        if "kind: mechanism" not in text:
            names.append(name)
    return names


def materials_of(steps: SplitSteps) -> dict[str, plate.Material]:
    """Any stiffness, and the design's own densities."""
    own = {layer.material.name: layer.material for layer in steps.design.layers}
    return {
        name: dataclasses.replace(KAPTON if m.is_flexible else T300, density=m.density)
        for name, m in own.items()
    }


@pytest.mark.parametrize("name", drawn_examples())
@pytest.mark.quick("pendulum", "four_bar", "folding_box", "yoshimura", others="campaign")
def test_plates_of_an_example_weigh_what_its_bodies_weigh(name: str) -> None:
    """Mass and centre by regions and laminates are those that splitting found from the polygons of each layer."""
    steps = steps_of(name)
    size = max(steps.mechanism.size, 1e-3)
    for body in steps.mechanism.bodies:
        found = plate.plate_of(steps, body.name, materials=materials_of(steps))
        pieces = [(found.laminates[key].areal_mass, region) for key, region in found.regions.items()]
        mass = sum(areal * region.area for areal, region in pieces)
        # Edges move by up to 1e-9 of the drawing's size, on plates whose width is a hundredth of it or more.
        assert mass == pytest.approx(body.mass, rel=1e-6)
        centre = (
            sum(areal * region.area * np.array(region.centroid.coords[0]) for areal, region in pieces) / mass
        )
        np.testing.assert_allclose(centre, body.com[:2], rtol=0, atol=1e-6 * size)
        for one, other in zip(
            list(found.regions.values())[:-1], list(found.regions.values())[1:], strict=True
        ):
            assert shapely.intersection(one, other).area < 1e-9 * size * size


@pytest.mark.parametrize("name", drawn_examples())
@pytest.mark.parametrize("hinges", ["lines", "strips"])
@pytest.mark.quick("*-flaps", "*-four_bar", "*-pendulum", "*-vertex", "*-folding_box", others="campaign")
def test_every_hinge_of_an_example_is_an_edge_of_its_plates(name: str, hinges: str) -> None:
    steps = steps_of(name)
    materials = materials_of(steps)
    width = {hinge.name: hinge.properties.width for hinge in steps.hinges}
    layers = steps.design.layers
    line = {h.name: shapely.intersection(h.line, layers[h.properties.layer].geometry) for h in steps.hinges}
    for body in steps.bodies[:4]:
        found = plate.plate_of(steps, body.name, hinges=hinges, materials=materials)
        joints = {c.hinge.name for c in steps.connections if body.name in (c.parent, c.child)}
        assert set(found.hinges) == joints
        for joint, edge in found.hinges.items():
            # Holes take a few widths from a line's ends, more where lines meet at small angles.
            assert edge.line.length > line[joint].length - 12 * width[joint]
            assert edge.line.length > 0
            assert edge.line.distance(line[joint]) <= 1.001 * width[joint]
        assert all(region.is_valid for region in found.regions.values())


def test_neighbours_end_on_both_sides_of_their_hinge_line() -> None:
    """Two hinge widths apart, and the line in the middle."""
    steps = steps_of("flaps")
    materials = materials_of(steps)
    ground, link = (
        plate.plate_of(steps, b, hinges="lines", materials=materials) for b in ("ground", "link_1")
    )
    one, other = ground.hinges["left"].line, link.hinges["left"].line
    assert one.length == other.length == pytest.approx(12e-3, rel=1e-9)
    assert one.distance(other) == pytest.approx(0.4e-3, rel=1e-6)
    assert (one.centroid.x + other.centroid.x) / 2 == pytest.approx(-20e-3, rel=1e-9)


@pytest.mark.parametrize("name", ["six_bar", "vertex", "sarrus", "shutter"])
@pytest.mark.parametrize("hinges", ["none", "lines", "strips"])
def test_plates_of_examples_can_be_meshed(name: str, hinges: str) -> None:
    """All of the area is in a region with a laminate."""
    steps = steps_of(name)
    found = plate.plate_of(steps, steps.bodies[1].name, hinges=hinges, materials=materials_of(steps))
    outline = found.outline
    cells = plate.mesh(outline, 0.1 * math.sqrt(outline.area), regions=found.regions)
    assert cells.areas.sum() == pytest.approx(outline.area, rel=1e-9)
    assert {cells.region_names[k] for k in cells.regions} == set(found.laminates)


# --- overlay ---------------------------------------------------------------------------------------------------------


def test_slivers_between_edges_drawn_twice_go_to_a_neighbour() -> None:
    """Two sheets whose edges differ by 1e-8: no region is 1e-8 wide, nothing overlaps and nothing is lost."""
    low, high = box(0, 0, 1, 1), box(0, 0, 0.5 + 1e-8, 1)
    third = box(0, 0, 0.5, 1)
    found = overlay([low, high, third], tolerance=1e-6)
    assert found.slivers == 1
    assert found.moved == pytest.approx(1e-8, rel=1e-2)
    assert set(found.regions) == {(0,), (0, 1, 2)}
    assert sum(region.area for region in found.regions.values()) == pytest.approx(1.0, abs=1e-12)
    assert shapely.intersection(*found.regions.values()).area == 0.0


def test_regions_do_not_depend_on_how_polygons_are_written() -> None:
    """Another starting corner, another direction, another order of parts."""
    parts = [box(0, 0, 1, 1), box(2, 0, 3, 1)]
    rotated = [shapely.reverse(shapely.Polygon([(1, 1), (0, 1), (0, 0), (1, 0)])), parts[1]]
    over = box(0.5, -1, 2.5, 2)
    one = overlay([MultiPolygon(parts), over], 1e-6)
    other = overlay([MultiPolygon(rotated[::-1]), over], 1e-6)
    assert {k: v.wkt for k, v in one.regions.items()} == {k: v.wkt for k, v in other.regions.items()}
    assert {k: v.area for k, v in one.regions.items()} == pytest.approx({(0,): 1.0, (0, 1): 1.0, (1,): 5.0})


corner = st.integers(0, 12).map(lambda k: k / 4) | st.floats(0, 3)
boxes = st.tuples(corner, corner, corner, corner).filter(lambda b: abs(b[0] - b[2]) > 0.1 < abs(b[1] - b[3]))
wobbles = st.sampled_from([0.0, 0.0, 1e-9, -1e-8])  # edges meant to coincide, and drawn twice


@st.composite
def sheets(draw: st.DrawFn) -> list[MultiPolygon]:
    drawn = []
    for _ in range(draw(st.integers(1, 4))):
        parts = []
        for x0, y0, x1, y1 in draw(st.lists(boxes, min_size=1, max_size=3)):
            shift = draw(wobbles)
            parts.append(box(min(x0, x1) + shift, min(y0, y1), max(x0, x1), max(y0, y1) - shift))
        joined = shapely.union_all(parts)
        drawn.append(MultiPolygon(joined.geoms if isinstance(joined, MultiPolygon) else [joined]))
    return drawn


@given(sheets())
def test_regions_part_what_was_drawn(drawn: list[MultiPolygon]) -> None:
    """Disjoint, none of them a sliver, and each layer's area is that of the regions whose stack names it."""
    tolerance = 1e-6
    found = overlay(drawn, tolerance)
    regions = list(found.regions.values())
    # Slivers of a tolerance along all edges, some metres of each, may have changed their stack or be lost.
    lost = 100 * tolerance
    for index, sheet in enumerate(drawn):
        kept = sum(region.area for stack, region in found.regions.items() if index in stack)
        assert kept == pytest.approx(sheet.area, abs=lost)
    assert sum(r.area for r in regions) == pytest.approx(shapely.union_all(drawn).area, abs=lost)
    for k, one in enumerate(regions):
        assert one.is_valid
        assert not any(is_sliver(part, tolerance) for part in one.geoms)
        for other in regions[k + 1 :]:
            assert shapely.intersection(one, other).area <= 1e-9


def test_names_say_which_layers_there_are() -> None:
    names = ["lower", "glue", "film", "glue_2", "upper"]
    present = range(5)
    assert stack_name((0, 1, 2, 3, 4), names, present) == "all layers"
    assert stack_name((2,), names, present) == "film"
    assert stack_name((0, 1), names, present) == "lower+glue"
    assert stack_name((0, 1, 2, 4), names, present) == "all but glue_2"
    assert stack_name((2,), names, [2]) == "film"


def test_sheets_with_nothing_between_them_are_reported() -> None:
    text = TWO_LINKS.replace("layers: upper}", "layers: glue}")
    design = load_text(text, "two.yaml")
    assert isinstance(design, Design)
    found = plate.plate_of(design, "left")
    (note,) = found.notes
    assert "region 'all but glue' is empty in 'glue'" in note
    hollow = found.laminates["all but glue"]
    assert [ply.gap for ply in hollow.plies] == pytest.approx([0.0, 0.05e-3, 0.0])
    assert hollow.thickness == pytest.approx(0.575e-3)


# --- materials and refusals ------------------------------------------------------------------------------------------


def test_moduli_come_from_the_file_or_from_the_caller() -> None:
    found = plate.plate_of(two_links(), "left")
    film = found.laminates["film"].plies[0].material
    assert (film.E1, film.E2, film.nu12, film.density) == (2.5e9, 2.5e9, 0.34, 1420)
    assert pytest.approx(2.5e9 / 2.68) == film.G12
    replaced = plate.plate_of(two_links(), "left", materials={"board": T300})
    assert replaced.laminates["all layers"].plies[0].material is T300
    text = TWO_LINKS.replace("E1: 60 GPa, poisson: 0.3", "E1: 60 GPa, E2: 6 GPa, G12: 4 GPa, poisson: 0.3")
    design = load_text(text, "two.yaml")
    assert isinstance(design, Design)
    board = plate.plate_of(design, "left").laminates["all layers"].plies[0].material
    assert (board.E1, board.E2, board.G12) == (60e9, 6e9, 4e9)


def test_placeholder_moduli_are_refused_with_the_way_out() -> None:
    """popupCAD writes E1 = E2 = 1 and poisson = 1/2 where nobody measured."""
    steps = steps_of("pendulum.cad")
    with pytest.raises(DesignError, match="moduli are needed for a plate") as caught:
        plate.plate_of(steps, "ground")
    text = str(caught.value)
    for name in {layer.material.name for layer in steps.design.layers}:
        assert f"{name!r} has no E1, poisson" in text
    assert "materials={" in text
    assert "\n" not in text


def test_body_that_is_all_hinge_is_no_plate_without_it() -> None:
    """A film alone that ends 0.4 mm from its line, within the hinge width of 0.5 mm."""
    text = TWO_LINKS.replace("  - {rect: [-20, 0, 30, 10]}", "  - {rect: [-20, 0, 0.4, 10]}")
    text = text.replace("bodies: {left: [-5, 5], right: [5, 5]}", "bodies: {left: [-5, 5], right: [0.3, 5]}")
    design = load_text(text, "two.yaml")
    assert isinstance(design, Design)
    assert areas(plate.plate_of(design, "right")) == pytest.approx({"film": 3.5}, rel=1e-9)
    with pytest.raises(DesignError, match="nothing is left of 'right' with hinges='lines'"):
        plate.plate_of(design, "right", hinges="lines")


def test_orthotropic_material_needs_its_shear_modulus() -> None:
    design = load_text(TWO_LINKS.replace("E1: 60 GPa,", "E1: 60 GPa, E2: 6 GPa,"), "two.yaml")
    assert isinstance(design, Design)
    with pytest.raises(DesignError, match="'board' has no G12"):
        plate.plate_of(design, "left")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"body": "lefd"}, "has no body 'lefd'; did you mean 'left'"),
        ({"body": ()}, "no body of design 'two links' is named; known are"),
        ({"body": "left", "hinges": "soft"}, "hinges is 'soft'; it must be one of none, lines, strips"),
        ({"body": "left", "tolerance": 0.0}, "the tolerance of a plate is 0 m"),
        ({"body": "left", "tolerance": math.nan}, "the tolerance of a plate is nan"),
        (
            {"body": "left", "materials": {"film": "steel"}},
            "the material for 'film' is 'steel'; it must be",
        ),
    ],
)
def test_impossible_request_is_refused(arguments: dict[str, object], message: str) -> None:
    with pytest.raises(DesignError, match=message) as caught:
        plate.plate_of(two_links(), **arguments)  # type: ignore[arg-type]
    assert "\n" not in str(caught.value)
