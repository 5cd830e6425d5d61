"""Splitting: bodies, hinges and masses of laminates whose answers follow from their geometry."""

import math
import random as random_module
import time
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st
from shapely.geometry import LineString, MultiPolygon, Point, Polygon, box

from lamc.basics.errors import DesignError, LamcError, Place, TopologyError
from lamc.design.split import split, split_steps
from lamc.records.design import BodyName, Design, HingeLine, HingeSet, Layer, Line, Material
from lamc.records.scene import Scene
from tests.support.laminates import FLEX, GLUE, MM, RIGID, flaps, miura, multi, pendulum, sheet, strip, vertex
from tests.support.quick import tries

EMPTY = MultiPolygon()


def test_popupcad_pendulum_has_the_published_masses_and_inertia() -> None:
    mechanism = split(pendulum())
    links = [b for b in mechanism.bodies if not b.fixed]
    # Published to all digits: 1 kg less gaps of 10 µm (1 µm in the flexible layer) on each hinged side.
    np.testing.assert_allclose([b.mass for b in links], [0.9999836, 0.9999836, 0.9999918], rtol=0, atol=1e-12)
    assert links[0].inertia[1, 1] == pytest.approx(0.1666609120801995, abs=1e-12)
    assert [(j.parent, j.child) for j in mechanism.joints] == [
        ("ground", "link_1"),
        ("link_1", "link_2"),
        ("link_2", "link_3"),
    ]
    np.testing.assert_allclose(
        [j.point for j in mechanism.joints], [[x, 0.5, 0.5] for x in range(3)], rtol=0.0, atol=1e-15
    )
    np.testing.assert_allclose(
        [j.axis for j in mechanism.joints], [[0, 1, 0], [0, 1, 0], [0, -1, 0]], rtol=0.0, atol=1e-15
    )


def test_flaps_are_cut_as_popupcad_exports_them() -> None:
    """flaps.joints: rigid layers open at 0.2 mm from the line, the flexible one cut at 0.02 mm."""
    steps = split_steps(flaps())
    ground, left, right = steps.bodies
    assert [b.name for b in steps.bodies] == ["ground", "link_1", "link_2"]
    for body, rigid, flexible in (
        (ground, (-0.0198, 0.0198), (-0.01998, 0.01998)),
        (left, (-0.05, -0.0202), (-0.05, -0.02002)),
        (right, (0.0202, 0.06), (0.02002, 0.06)),
    ):
        for polygons, (low, high) in zip(body.polygons, (rigid, flexible, rigid), strict=True):
            (polygon,) = polygons
            # Round-off of coordinates of 0.06 m.
            np.testing.assert_allclose(polygon.bounds, (low, 0.0, high, 0.012), rtol=0, atol=1e-16)
            assert polygon.area == pytest.approx((high - low) * 0.012, rel=1e-12)
    first, second = steps.mechanism.joints
    assert (first.parent, first.child, second.parent, second.child) == (
        "ground",
        "link_1",
        "ground",
        "link_2",
    )
    np.testing.assert_allclose(first.point, [-0.02, 0.006, 0.000525], rtol=0, atol=1e-17)
    assert (first.stiffness, first.damping, first.rest_angle) == (0.004, 2e-6, math.radians(15))
    assert first.limits == (math.radians(-120), math.radians(120))
    mass = 0.012 * (1800 * 2 * 0.5e-3 * (0.05 - 0.0202) + 1420 * 0.05e-3 * (0.05 - 0.02002))
    assert steps.mechanism.body("link_1").mass == pytest.approx(mass, rel=1e-12)


@pytest.mark.parametrize("angles", [(0, 90, 180, 270), (0, 60, 140, 250), (10, 30, 190, 250)])
def test_four_creases_in_a_vertex_give_a_loop_of_four_bodies(angles: tuple[int, ...]) -> None:
    steps = split_steps(vertex(angles))
    assert len(steps.bodies) == len(steps.connections) == 4
    ends = sorted(tuple(sorted((c.parent, c.child))) for c in steps.connections)
    assert len(set(ends)) == 4
    assert sorted(name for pair in ends for name in pair) == sorted(2 * [b.name for b in steps.bodies])
    # The hole holds the disc of one hinge width about the vertex, up to the caps' arc segments.
    assert steps.holes[0].contains(Point(0, 0).buffer(0.99 * 0.2 * MM))


def test_material_is_conserved_but_for_holes_and_slits() -> None:
    steps = split_steps(vertex((0, 60, 140, 250)))
    drawn = steps.design.layers[0].geometry
    removed = drawn.intersection(steps.holes[0].union(steps.slits[0])).area
    bodies = sum(p.area for b in steps.bodies for p in b.polygons[0])
    assert bodies + removed == pytest.approx(drawn.area, rel=1e-12)


def test_miura_of_nine_facets_has_nine_bodies_and_twelve_hinges() -> None:
    mechanism = split(miura(3, 3))
    assert (len(mechanism.bodies), len(mechanism.joints)) == (9, 12)
    assert sum(b.fixed for b in mechanism.bodies) == 1
    touching = dict.fromkeys((b.name for b in mechanism.bodies), 0)
    for joint in mechanism.joints:
        touching[joint.parent] += 1
        touching[joint.child] += 1
    assert sorted(touching.values()) == [2, 2, 2, 2, 3, 3, 3, 3, 4]


def stack(*parts: tuple[Material, MultiPolygon]) -> tuple[Layer, ...]:
    return tuple(Layer(f"layer {i}", m, 0.1 * MM, g) for i, (m, g) in enumerate(parts))


def test_pieces_joined_only_through_an_adhesive_layer_are_one_body() -> None:
    """Two rigid tiles lie apart; a patch of adhesive below overlaps both."""
    flexible = box(0, 0, 0.02, 0.01)
    glue = MultiPolygon([box(0.001, 0.001, 0.009, 0.009), box(0.012, 0.004, 0.018, 0.006)])
    tiles = MultiPolygon([box(0, 0, 0.0098, 0.01), box(0.0105, 0, 0.014, 0.01), box(0.016, 0, 0.02, 0.01)])
    line = HingeLine(((0.01, 0.0), (0.01, 0.01)))
    with_flex = stack((FLEX, multi(flexible)), (GLUE, glue), (RIGID, tiles))
    mechanism = split(sheet(flexible, [line], box(0, 0, 0.005, 0.01), layers=with_flex))
    assert [len(b.outline) for b in mechanism.bodies] == [3, 4]
    area = 0.01 * (0.0035 + 0.004)
    mass = 0.1 * MM * (1800 * area + 1100 * 0.006 * 0.002 + 1420 * (0.01 - 0.02 * MM) * 0.01)
    assert mechanism.body("link_1").mass == pytest.approx(mass, rel=1e-12)


def test_layers_touching_along_an_edge_only_are_no_bond() -> None:
    line = HingeLine(((0.01, 0.0), (0.01, 0.01)))
    layers = stack((FLEX, multi(box(0, 0, 0.02, 0.01))), (RIGID, multi(box(0.02, 0, 0.03, 0.01))))
    with pytest.raises(TopologyError, match=r"1 body has no path to the world: 'link_2' at \(25, 5\) mm"):
        split(sheet(box(0, 0, 1, 1), [line], box(0, 0, 0.005, 0.01), layers=layers))


def test_a_hinge_cuts_only_the_layers_it_runs_through() -> None:
    """A cover above the sublaminate holds both sides together, so the hinge touches one body."""
    plate = multi(box(0, 0, 0.02, 0.01))
    layers = stack((FLEX, plate), (RIGID, plate))
    design = sheet(box(0, 0, 1, 1), [((0.01, 0), (0.01, 0.01))], box(0, 0, 0.005, 0.01), layers=layers)
    assert len(split(design).bodies) == 2
    shallow = replace(design, hinges=(replace(design.hinges[0], sublaminate=(0,)),))
    with pytest.raises(TopologyError, match=r"'h1' at \(10, 5\) mm touches 1 body \('ground'\)"):
        split(shallow)


def test_hinges_in_different_layers_cut_no_hole_where_they_cross_in_plan() -> None:
    """Two separate sheets, one above the other, bonded at a corner; their hinge lines cross in plan."""
    low, high = box(0, 0, 0.02, 0.02), box(0, 0, 0.02, 0.02)
    bond = box(0, 0, 0.005, 0.005)
    layers = stack((FLEX, multi(low)), (GLUE, multi(bond)), (FLEX, multi(high)))
    sets = (
        HingeSet((HingeLine(((0.01, 0), (0.01, 0.02))),), 0.2 * MM, 0, (0,)),
        HingeSet((HingeLine(((0, 0.01), (0.02, 0.01))),), 0.2 * MM, 2, (2,)),
    )
    steps = split_steps(Design("two sheets", layers, sets, (multi(bond), EMPTY, EMPTY)))
    assert all(hole.is_empty for hole in steps.holes)
    # The lower sheet's flap lies to the right of the upper sheet's.
    assert [(c.parent, c.child) for c in steps.connections] == [("ground", "link_2"), ("ground", "link_1")]
    np.testing.assert_allclose([c.hinge.z for c in steps.connections], [0.05 * MM, 0.25 * MM], rtol=1e-12)


def test_collinear_hinges_in_series_join_their_own_bodies() -> None:
    """One crease drawn as two lines end to end; a slot parts the two flaps on its right."""
    plate = box(0, 0, 0.02, 0.02).difference(box(0.01, 0.0099, 0.03, 0.0101))
    lines: list[Line] = [((0.01, 0), (0.01, 0.01)), ((0.01, 0.01), (0.01, 0.02))]
    steps = split_steps(sheet(plate, lines, box(0, 0, 0.005, 0.02)))
    assert [(c.parent, c.child) for c in steps.connections] == [("ground", "link_1"), ("ground", "link_2")]
    assert steps.holes[0].contains(Point(0.01, 0.01))


def test_a_door_with_two_hinges_on_one_line_keeps_both() -> None:
    door = box(0, 0, 0.02, 0.03).difference(box(0.0099, 0.01, 0.0101, 0.02))
    lines: list[Line] = [((0.01, 0), (0.01, 0.0101)), ((0.01, 0.0199), (0.01, 0.03))]
    joints = split(sheet(door, lines, box(0, 0, 0.005, 0.03))).joints
    assert [(j.parent, j.child) for j in joints] == [("ground", "link_1")] * 2


def test_overshooting_ends_are_no_contact() -> None:
    """A flap in a window; its hinge line runs past the window's slits by a twentieth of a width."""
    window = box(0.004, 0.004, 0.012, 0.012).difference(box(0.004, 0.0042, 0.0118, 0.0118))
    over = 0.01 * MM
    line = ((0.004, 0.004 - over), (0.004, 0.012 + over))
    mechanism = split(sheet(box(0, 0, 0.016, 0.016).difference(window), [line], box(0, 0, 0.002, 0.002)))
    assert len(mechanism.bodies) == 2


def test_crumbs_are_left_out_and_reported() -> None:
    crumb = box(0.03, 0.03, 0.03 + 0.1 * MM, 0.03 + 0.1 * MM)
    design = strip([0.01, 0.01])
    layer = design.layers[0]
    dirty = replace(layer, geometry=MultiPolygon([*layer.geometry.geoms, crumb]))
    steps = split_steps(replace(design, layers=(dirty,)))
    assert len(steps.bodies) == 2
    assert len(steps.scraps) == 1
    assert steps.scraps[0].area == pytest.approx(1e-8, rel=1e-9)
    assert "left out a scrap of 0.01 mm² at (30.05, 30.05) mm" in steps.notes[0]
    assert split_steps(design).notes == ()


def test_names_from_the_drawing_are_kept() -> None:
    design = strip([0.01, 0.01, 0.01])
    lines = tuple(
        HingeLine(h.line, name) for h, name in zip(design.hinges[0].lines, ("knee", None), strict=True)
    )
    named = replace(
        design,
        hinges=(replace(design.hinges[0], lines=lines),),
        body_names=(BodyName("foot", Point(0.025, 0.002)), BodyName("table", Point(0.002, 0.002))),
        scene=Scene(angles={"knee": 0.3}),
    )
    mechanism = split(named)
    assert [b.name for b in mechanism.bodies] == ["table", "link_1", "foot"]
    assert [(j.name, j.parent, j.child) for j in mechanism.joints] == [
        ("knee", "table", "link_1"),
        ("h2", "link_1", "foot"),
    ]
    assert mechanism.scene is named.scene
    assert mechanism.name == "strip"


def test_progress_runs_from_zero_to_one() -> None:
    seen: list[float] = []
    split(strip([0.01, 0.01]), lambda _stage, part: seen.append(part))
    assert seen[0] == 0.0
    assert seen[-1] == 1.0
    assert seen == sorted(seen)


def shuffled(design: Design, random: random_module.Random) -> Design:
    """The same drawing with layers' polygons, rings' starts, lines and sets in another order."""

    def mixed(items: list) -> list:  # type: ignore[type-arg]
        return random.sample(items, len(items))

    def polygons(geometry: MultiPolygon) -> MultiPolygon:
        rotated = []
        for polygon in mixed(list(geometry.geoms)):
            ring = list(polygon.exterior.coords)[:-1]
            start = random.randrange(len(ring))
            rotated.append(Polygon(ring[start:] + ring[:start], polygon.interiors))
        return MultiPolygon(rotated)

    layers = tuple(replace(layer, geometry=polygons(layer.geometry)) for layer in design.layers)
    sets = []
    for hinge_set in design.hinges:
        lines = mixed(list(hinge_set.lines))
        where = random.randrange(len(lines) + 1)
        sets += [replace(hinge_set, lines=tuple(part)) for part in (lines[:where], lines[where:]) if part]
    return replace(design, layers=layers, hinges=tuple(mixed(sets)))


@settings(max_examples=tries(25), deadline=None)
@given(st.sampled_from(["miura", "vertex", "flaps", "pendulum"]), st.randoms(use_true_random=False))
def test_order_of_input_does_not_matter(which: str, random: random_module.Random) -> None:
    make: dict[str, Callable[[], Design]] = {
        "miura": miura,
        "vertex": lambda: vertex((0, 60, 140, 250)),
        "flaps": flaps,
        "pendulum": pendulum,
    }
    design = make[which]()
    first, second = split(design), split(shuffled(design, random))
    assert first == second


def outline_of(count: int) -> Polygon:
    """A wavy outline of `count` vertices around a 20 mm by 10 mm plate."""
    angle = 2 * math.pi * np.arange(count) / count
    radius = 1 + 0.01 * np.sin(200 * angle)
    return Polygon(np.column_stack([0.02 * radius * np.cos(angle), 0.01 * radius * np.sin(angle)]))


def test_outlines_of_many_vertices_split_in_reasonable_time() -> None:
    outline = outline_of(200_000)
    layers = stack((RIGID, multi(outline)), (FLEX, multi(outline)), (RIGID, multi(outline)))
    lines: list[Line] = [((x, -0.02), (x, 0.02)) for x in (-0.01, 0.0, 0.01)]
    start = time.perf_counter()
    mechanism = split(sheet(outline, lines, box(-0.03, -0.001, -0.015, 0.001), layers=layers, flexible=1))
    elapsed = time.perf_counter() - start
    assert len(mechanism.bodies) == 4
    slits = sum(outline.intersection(box(x - 2e-5, -1, x + 2e-5, 1)).area for x in (-0.01, 0.0, 0.01))
    mass = 0.1 * MM * (1800 * 2 + 1420) * (outline.area - slits)
    assert sum(b.mass for b in mechanism.bodies) == pytest.approx(mass, rel=1e-12)
    # Takes about 2 s; anything that looks at all pairs of vertices would take hours.
    assert elapsed < 60.0


# Refusals. Each names the hinge or body, how many it touched, where, and what to do.


def plate_with(*lines: Line | HingeLine, fixed: Polygon | None = None) -> Design:
    return sheet(box(0, 0, 0.02, 0.01), lines, fixed or box(0, 0, 0.004, 0.01))


def across(x: float) -> Line:
    return ((x, 0.0), (x, 0.01))


def without_density(design: Design) -> Design:
    layer = design.layers[0]
    return replace(design, layers=(replace(layer, material=replace(layer.material, density=0.0)),))


def with_layer(**changes: object) -> Design:
    design = strip([0.01, 0.01])
    return replace(design, layers=(replace(design.layers[0], **changes),))  # type: ignore[arg-type]


def with_set(**changes: object) -> Design:
    design = strip([0.01, 0.01])
    return replace(design, hinges=(replace(design.hinges[0], **changes),))  # type: ignore[arg-type]


AT = Place("device.yaml", 12, 5)

REFUSED = {
    "ends inside the plate": (
        plate_with(HingeLine(((0.01, 0.0), (0.01, 0.005)), "h", AT)),
        r"^device.yaml:12:5: hinge 'h' at \(10, 2.5\) mm touches 1 body \('ground'\); a hinge needs "
        "exactly 2: it does not cut the body apart; lengthen it",
    ),
    "lies outside": (plate_with(across(0.01), across(0.05)), "'h2' .*touches 0 bodies.*outside the device"),
    "along the edge": (plate_with(across(0.01), across(0.02)), "'h2' .*touches 1 body.*on its left only"),
    "crosses another": (
        plate_with(across(0.01), ((0.0, 0.005), (0.02, 0.005)), fixed=box(0, 0, 0.004, 0.004)),
        r"touches 4 bodies \('ground', 'link_1', 'link_2', 'link_3'\).*it crosses hinge 'h2'; draw it as",
    ),
    "three bodies": (
        sheet(
            box(0, 0, 0.02, 0.01).difference(box(0.01, 0.0048, 0.02, 0.0052)),
            [across(0.01)],
            box(0, 0, 0.004, 0.01),
        ),
        "'h1' .*touches 3 bodies.*draw one line for each pair",
    ),
    "drawn twice": (
        plate_with(across(0.01), across(0.01)),
        "are drawn on the same line; keep one of them",
    ),
    "a body swallowed by a hole": (
        plate_with(across(0.01), across(0.01015)),
        "'h1' .*touches 0 bodies.*the holes where it meets hinge 'h2' swallow it; move them apart",
    ),
    "a body torn by a hole": (
        plate_with(across(0.01), across(0.0103)),
        "2 bodies have no path to the world: 'link_2' at",
    ),
    "cut off": (
        sheet(
            MultiPolygon([box(0, 0, 0.02, 0.01), box(0.03, 0, 0.04, 0.01)]),
            [across(0.01)],
            box(0, 0, 0.004, 0.01),
        ),
        r"1 body has no path to the world: 'link_2' at \(35, 5\) mm; join",
    ),
    "cut off in a group": (
        sheet(
            MultiPolygon([box(0, 0, 0.02, 0.01), box(0.03, 0, 0.04, 0.01)]),
            [across(0.01), across(0.035)],
            box(0, 0, 0.004, 0.01),
        ),
        "2 bodies have no path to the world: 'link_2' at .*'link_3' at",
    ),
    "fixed on both sides": (
        plate_with(across(0.01), fixed=box(0.008, 0, 0.012, 0.01)),
        "'h1' .*joins 'ground_1' and 'ground_2', which are both fixed",
    ),
    "locked pair": (
        sheet(
            box(0, 0, 0.02, 0.02),
            [((0.01, 0.0), (0.01, 0.01)), ((0.01, 0.01), (0.02, 0.01))],
            box(0, 0, 0.004, 0.01),
        ),
        "'h2' .*and hinge 'h1' both join 'ground' and 'link_1' but do not lie on one line",
    ),
    "nothing fixed": (replace(strip([0.01, 0.01]), fixed=(EMPTY,)), "has no fixed region"),
    "fixed beside the device": (
        plate_with(across(0.01), fixed=box(1, 1, 2, 2)),
        "fixed region .*meets no body",
    ),
    "no hinges": (plate_with(), "has no hinge lines"),
    "no layers": (replace(strip([0.01, 0.01]), layers=(), fixed=()), "has no layers"),
    "no material": (with_layer(geometry=EMPTY), "no material in any layer"),
    "zero density": (
        without_density(strip([0.01, 0.01])),
        "'link_1' at .* has zero mass: the density of 'flex'",
    ),
    "nan density": (with_layer(material=Material("m", math.nan)), "density of layer 'flex' is nan kg/m³"),
    "negative thickness": (with_layer(thickness=-1e-4), "thickness of layer 'flex' is -0.0001 m"),
    "bow tie": (
        with_layer(geometry=MultiPolygon([Polygon([(0, 0), (1, 1), (1, 0), (0, 1)])])),
        "Self-intersection",
    ),
    "zero width": (with_set(width=0.0), r"width of the hinge line from \(10, 0\) to \(10, 5\) mm is 0.0 m"),
    "bad layer": (with_set(layer=3), "refers to layer 3; the design has layers 0 to 0"),
    "no sublaminate": (with_set(sublaminate=()), "runs through no layers"),
    "a point for a line": (plate_with(((0.01, 0.0), (0.01, 0.0))), "has no length"),
    "nan line": (plate_with(((0.01, math.nan), (0.01, 0.0))), "not finite"),
    "one name twice": (
        plate_with(HingeLine(across(0.01), "a"), HingeLine(across(0.015), "a")),
        "two hinges are named 'a'",
    ),
    "huge name": (plate_with(HingeLine(across(0.01), "😀" * 10_000)), "10000 characters"),
    "name outside": (
        replace(strip([0.01, 0.01]), body_names=(BodyName("b", Point(1, 1)),)),
        r"names body 'b', \(1000, 1000\) mm, lies in 0 bodies",
    ),
    "two names for one body": (
        replace(
            strip([0.01, 0.01]),
            body_names=(BodyName("b", Point(0.002, 0.002)), BodyName("c", Point(0.003, 0.002))),
        ),
        "'b' and 'c' name the same body",
    ),
}


@pytest.mark.parametrize("case", sorted(REFUSED))
def test_what_is_no_mechanism_is_refused_by_name(case: str) -> None:
    design, message = REFUSED[case]
    with pytest.raises(DesignError, match=message) as caught:
        split(design)
    assert isinstance(caught.value, LamcError)
    assert "\n" not in str(caught.value)


def test_fixed_body_without_mass_is_allowed() -> None:
    """Only what moves needs mass: the ground may be a sheet of unknown density."""
    ghost = Material("ghost", 0.0)
    layers = stack((ghost, multi(box(0, 0, 0.0099, 0.01))), (FLEX, multi(box(0.005, 0, 0.02, 0.01))))
    mechanism = split(
        sheet(box(0, 0, 1, 1), [across(0.01)], box(0, 0, 0.004, 0.01), layers=layers, flexible=1)
    )
    assert [b.fixed for b in mechanism.bodies] == [True, False]


def test_hinge_strip_is_read_where_only_rigid_layers_are_drawn() -> None:
    """No material in the flexible layer near the line: the opened rigid layers tell what it joins."""
    rigid = MultiPolygon([box(0, 0, 0.0098, 0.01), box(0.0102, 0, 0.02, 0.01)])
    layers = stack((RIGID, rigid), (FLEX, multi(box(0, 0, 0.001, 0.001))))
    mechanism = split(
        sheet(box(0, 0, 1, 1), [across(0.01)], box(0, 0, 0.004, 0.01), layers=layers, flexible=1)
    )
    assert [(j.parent, j.child) for j in mechanism.joints] == [("ground", "link_1")]


@settings(max_examples=tries(30), deadline=None)
@given(st.floats(0, 2 * math.pi), st.floats(-0.5, 0.5), st.floats(-0.5, 0.5))
def test_masses_do_not_depend_on_where_the_device_lies(rotation: float, x: float, y: float) -> None:
    design = flaps()

    def move(geometry: MultiPolygon) -> MultiPolygon:
        rotated = shapely.affinity.rotate(geometry, rotation, (0, 0), use_radians=True)
        return shapely.affinity.translate(rotated, x, y)

    sets = []
    for s in design.hinges:
        moved = move(LineString(s.lines[0].line)).coords  # type: ignore[arg-type]
        sets.append(replace(s, lines=(HingeLine((moved[0], moved[1])),)))
    layers = tuple(replace(layer, geometry=move(layer.geometry)) for layer in design.layers)
    there = split(
        replace(design, layers=layers, hinges=tuple(sets), fixed=tuple(move(f) for f in design.fixed))
    )
    here = split(design)
    # Slits of 20 µm lie at coordinates of 0.5 m, rounded at 1e-16: 1e-12 of a body's size.
    np.testing.assert_allclose(
        sorted(b.mass for b in there.bodies), sorted(b.mass for b in here.bodies), rtol=1e-11
    )
    assert len(there.joints) == 2
