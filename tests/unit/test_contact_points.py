"""Which points of a mechanism can touch: corners of outlines, listed points, and what is refused."""

import math
from dataclasses import replace
from pathlib import Path

import pytest
from shapely.geometry import MultiPoint, Point, Polygon, box

import lamc
import lamc.readers.mechanism_file
from lamc import Body, DesignError, GroundContact, Joint, Mechanism, Scene, Slab
from lamc.effects.contact_points import contact_points, corners_of, hull_corners
from lamc.readers.effects_schema import effect_schema

EXAMPLES = Path(lamc.__file__).parent / "examples"
WALL = Body("wall", fixed=True)
DIAGONAL = [[1e-5, 0, 0], [0, 1e-5, 0], [0, 0, 1e-5]]


def plated(*plates: Slab, name: str = "leaf") -> Body:
    return Body(name, 0.01, (0.0, 0.0, 0.0), DIAGONAL, outline=plates)


def mechanism(*bodies: Body) -> Mechanism:
    joints = tuple(Joint(f"h_{b.name}", "wall", b.name, axis=(0.0, 1.0, 0.0)) for b in bodies)
    return Mechanism((WALL, *bodies), joints)


def moving(mechanism: Mechanism) -> list[str]:
    return [body.name for body in mechanism.bodies if not body.fixed]


def test_corners_are_those_of_both_faces() -> None:
    found = corners_of(plated(Slab(box(0, 0, 2, 1), 0.1, 0.3)), 8)
    assert sorted(found) == sorted((x, y, z) for x in (0.0, 2.0) for y in (0.0, 1.0) for z in (0.1, 0.3))


def test_corners_of_a_sheet_without_thickness_are_there_once() -> None:
    assert len(corners_of(plated(Slab(box(0, 0, 2, 1), 0.1, 0.1)), 8)) == 4


def test_each_face_has_the_corners_of_its_own_layer() -> None:
    """A wide film between narrower sheets: the sheets are what touches."""
    sheets = [Slab(box(0, 0, 1, 1), z, z + 0.1) for z in (0.0, 0.2)]
    film = Slab(box(-1, 0, 2, 1), 0.1, 0.2)
    found = corners_of(plated(sheets[0], film, sheets[1]), 8)
    assert sorted({x for x, _, _ in found}) == [0.0, 1.0]
    assert sorted({z for _, _, z in found}) == [0.0, pytest.approx(0.3)]


def test_a_notch_has_no_corner_that_could_touch() -> None:
    notched = Polygon([(0, 0), (2, 0), (2, 2), (1, 1), (0, 2)])
    assert set(hull_corners([notched], 8)) == {(0.0, 0.0), (2.0, 0.0), (2.0, 2.0), (0.0, 2.0)}


@pytest.mark.parametrize("most", [3, 4, 8, 20])
def test_a_round_outline_keeps_as_many_corners_as_asked(most: int) -> None:
    disc = Point(0, 0).buffer(1.0, quad_segs=32)
    corners = hull_corners([disc], most)
    assert len(corners) == most
    # A regular polygon of so many corners is the best there is. Taking corners one by one comes exactly to it where the
    # number is halved again and again; in between it is worst for three, half of a square: 1 / 1.299
    kept = MultiPoint(corners).convex_hull.area
    regular = 0.5 * most * math.sin(2.0 * math.pi / most)
    assert kept > 0.76 * regular
    if most in (4, 8):
        assert kept == pytest.approx(regular, rel=1e-9)


def test_all_bodies_with_an_outline_touch_unless_some_are_named() -> None:
    leaf, twig = (plated(Slab(box(0, 0, 1, 1), 0, 0), name=name) for name in ("leaf", "twig"))
    stone = Body("stone", 0.01, (0.0, 0.0, 0.0), DIAGONAL)
    three = mechanism(leaf, twig, stone)
    assert [p.body for p in contact_points(three, moving(three), None, None, 8)] == ["leaf"] * 4 + [
        "twig"
    ] * 4
    assert {p.body for p in contact_points(three, moving(three), ["twig"], None, 8)} == {"twig"}
    listed = {"stone": [(0.5, 0.5, 0.0)]}
    assert [p.body for p in contact_points(three, moving(three), None, listed, 8)] == ["stone"]
    assert len(contact_points(three, moving(three), ["leaf"], listed, 8)) == 5


def test_a_point_that_is_a_corner_too_is_one_point() -> None:
    leaf = mechanism(plated(Slab(box(0, 0, 1, 1), 0, 0)))
    assert (
        len(contact_points(leaf, moving(leaf), ["leaf"], {"leaf": [(1.0, 1.0, 0.0), (0.5, 0.0, 0.0)]}, 8))
        == 5
    )


@pytest.mark.parametrize(
    ("ground", "message"),
    [
        (GroundContact(bodies=("leag",)), "no body is named 'leag'; the bodies are leaf, stone, wall"),
        (GroundContact(points={"leag": [(0, 0, 0)]}), "no body is named 'leag'"),
        (GroundContact(bodies=("wall",)), "body 'wall' does not move"),
        (GroundContact(bodies=("stone",)), "body 'stone' has no outline and so no corners; list its points"),
    ],
)
def test_bodies_that_cannot_touch_are_refused(ground: GroundContact, message: str) -> None:
    both = mechanism(plated(Slab(box(0, 0, 1, 1), 0, 0)), Body("stone", 0.01, (0.0, 0.0, 0.0), DIAGONAL))
    with pytest.raises(DesignError, match=message):
        lamc.compile(both, Scene((ground,)))


def test_where_nothing_can_touch_the_way_out_is_reported() -> None:
    bare = mechanism(Body("stone", 0.01, (0.0, 0.0, 0.0), DIAGONAL))
    with pytest.raises(DesignError, match=r"no moving body has an outline, .* list points by body"):
        lamc.compile(bare, Scene((GroundContact(),)))


def test_a_scene_file_gives_lengths_with_units() -> None:
    data = {
        "height": "2 mm",
        "slip_speed": "1 mm/s",
        "points": {"leaf": [["1 mm", 0, "0.5 cm"]]},
        "bodies": ["leaf"],
    }
    ground = GroundContact.from_data(data, "scene")
    assert ground == GroundContact(
        height=2e-3, slip_speed=1e-3, points={"leaf": ((1e-3, 0.0, 5e-3),)}, bodies=("leaf",)
    )
    assert GroundContact.from_data(None, "scene") == GroundContact()
    with pytest.raises(DesignError, match=r"ground_contact has no field 'frction'; .*friction"):
        GroundContact.from_data({"frction": 0.5}, "scene")


def test_popupcad_contact_sketch_is_read_and_taken_where_a_scene_asks_for_it() -> None:
    """The pendulum of popupCAD has one contact point, at (0.7495…, 0.6114…) mm: on a corner of its first link."""
    design = lamc.load(EXAMPLES / "pendulum.cad")
    ((x, y),) = design.contact_points
    assert (x, y) == pytest.approx((0.7495069033530571e-3, 0.611439842209073e-3), rel=1e-15)
    pendulum = lamc.split(design)
    assert pendulum.contact_points == design.contact_points
    found = contact_points(pendulum, moving(pendulum), None, "drawn", 8)
    link = pendulum.body("link_1")
    heights = (link.outline[0].z_bottom, link.outline[-1].z_top)
    assert [(p.body, p.point) for p in found] == [("link_1", (x, y, z)) for z in heights]


def test_contact_points_of_a_mechanism_file_come_back(tmp_path: Path) -> None:
    leaf = replace(mechanism(plated(Slab(box(0, 0, 1, 1), 0, 0.1))), contact_points=((0.25, 0.5), (1.0, 1.0)))
    file = tmp_path / "leaf.yaml"
    lamc.readers.mechanism_file.write_mechanism(leaf, file)
    assert lamc.load(file).contact_points == leaf.contact_points
    assert len(contact_points(leaf, moving(leaf), None, "drawn", 8)) == 4


def test_contact_points_of_a_design_are_in_its_units(tmp_path: Path) -> None:
    text = (EXAMPLES / "limit_stop.yaml").read_text(encoding="utf-8")
    file = tmp_path / "stop.yaml"
    file.write_text(text + "contact_points: [[70, 0], [70, 15]]\n", encoding="utf-8")
    assert lamc.load(file).contact_points == ((0.07, 0.0), (0.07, 0.015))


def test_drawn_points_that_are_none_or_lie_beside_are_refused() -> None:
    leaf = mechanism(plated(Slab(box(0, 0, 1, 1), 0, 0.1)))
    with pytest.raises(DesignError, match="the drawing of 'mechanism' has no contact points: draw some"):
        contact_points(leaf, moving(leaf), None, "drawn", 8)
    beside = replace(leaf, contact_points=((1.5, 0.5),))
    with pytest.raises(DesignError, match=r"contact point \(1500, 500\) mm lies on no moving body"):
        contact_points(beside, moving(beside), None, "drawn", 8)
    with pytest.raises(DesignError, match="or 'drawn'"):
        GroundContact(points="darwn")


def test_a_scene_file_may_ask_for_the_points_of_the_drawing() -> None:
    assert GroundContact.from_data({"points": "drawn"}, "scene").points == "drawn"
    with pytest.raises(DesignError, match=r"points.*'darwn'.*or 'drawn'"):
        GroundContact.from_data({"points": "darwn"}, "scene")
    points = effect_schema(GroundContact)["properties"]["points"]["anyOf"]
    assert {"enum": ["drawn"]} in points
