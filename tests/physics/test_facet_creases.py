"""Facets that bend along their diagonals: what is parted, what it weighs, how stiff it is, and that it moves."""

import math
import random

import numpy as np
import pytest
from shapely.geometry import LineString, Polygon

import lamc
from lamc.basics.errors import DesignError, DesignErrors
from lamc.design.facet_corners import corners_of, shortest_diagonals, triangle_corners
from lamc.design.split import split, split_steps
from lamc.design.steps import SplitSteps
from lamc.examples.miura import miura
from lamc.examples.sheet import CreasePattern, sheet
from lamc.readers.load import load_text
from lamc.records.design import Design
from lamc.records.mechanism import Mechanism
from tests.support.ctools import needs_cc

SIDE = 40.0  # mm
HEXAGON = [
    [SIDE * math.cos(math.radians(t)), SIDE * math.sin(math.radians(t))] for t in (30, 90, 150, 210, 270, 330)
]
HEAD = """\
kind: design
name: corner
units: mm
materials:
  card: {density: 700 kg/m^3, E1: 3 GPa, poisson: 0.3, rigid: true}
  film: {density: 1.42 g/cm^3, flexible: true}
layers:
  - {name: card, material: card, thickness: 0.4}
  - {name: film, material: film, thickness: 25 um}
"""
TIMES = np.linspace(0.0, 0.02, 11)
FOLDED = "scene: {angles: {c0: 20 deg, c1: -25 deg}, effects: [{gravity: [0, 0, -9.81]}, hinge_stiffness]}\n"


def design_of(text: str) -> Design:
    design = load_text(text, "drawn.yaml")
    assert isinstance(design, Design)
    return design


def corner(creases: str, rest: str = "") -> str:
    """Three rhombi about a point: a vertex of three creases, which is rigid."""
    lines = "".join(
        f"  - {{name: c{k}, line: [[0, 0], {HEXAGON[2 * k]}], gap: 1, stiffness: 0.1 N*mm/rad}}\n"
        for k in range(3)
    )
    shapes = f"shapes:\n  - {{polygon: {HEXAGON}, layers: film}}\n  - {{polygon: {HEXAGON}, layers: card}}\n"
    fixed = "fixed:\n  - {circle: {center: [0, 24], radius: 2}}\n"
    return f"{HEAD}{shapes}hinges:\n{lines}{fixed}{creases and f'facet_creases: {creases}'}\n{rest}"


def bent_miura(columns: int, rows: int, stiffness: str) -> str:
    return miura(columns, rows).replace("fixed:\n", f"facet_creases: {{stiffness: {stiffness}}}\nfixed:\n", 1)


def inertia_of(steps: SplitSteps, point: np.ndarray) -> np.ndarray:
    """Of all moving bodies about a point, kg·m², world axes."""
    total = np.zeros((3, 3))
    for body in steps.mechanism.bodies:
        if not body.fixed:
            arm = body.com - point
            total += body.inertia + body.mass * (arm @ arm * np.eye(3) - np.outer(arm, arm))
    return total


def test_parts_of_facets_share_their_mass_and_inertia() -> None:
    whole, parted = (
        split_steps(design_of(miura(3, 3))),
        split_steps(design_of(bent_miura(3, 3, "from-material"))),
    )
    assert len(parted.mechanism.bodies) == 1 + 2 * 8  # the fixed facet stays whole
    assert len(parted.mechanism.joints) == 12 + 8
    assert [name for name in (c.hinge.name for c in parted.connections) if name.endswith("_d1")] == [
        f"f{i}_{j}_d1" for i, j in sorted((i, j) for i in range(3) for j in range(3))[1:]
    ]
    masses = [sum(b.mass for b in each.mechanism.bodies) for each in (whole, parted)]
    assert masses[1] == pytest.approx(masses[0], rel=1e-13)  # sums of 26 numbers
    point = np.array([0.04, 0.03, 0.0])
    # Polygons cut anew: corners of 1e-17 m in facets of 1e-2 m.
    np.testing.assert_allclose(inertia_of(parted, point), inertia_of(whole, point), rtol=1e-12, atol=1e-20)
    assert "8 facets bend along 8 diagonals of 0.06 N·m/rad" in parted.notes[0]
    assert parted.notes[0].endswith("left whole: 1 fixed")


def test_creases_keep_parent_child_and_axis() -> None:
    """Angles, rest angles and scenes mean the same with facets that bend."""
    whole, parted = (split(design_of(text)) for text in (miura(3, 4), bent_miura(3, 4, "1 N*mm/rad")))
    for joint in whole.joints:
        same = parted.joint(joint.name)
        assert (same.parent.split("_t")[0], same.child.split("_t")[0]) == (joint.parent, joint.child)
        assert same.axis.tolist() == joint.axis.tolist()
        assert same.rest_angle == joint.rest_angle


def test_diagonals_run_from_vertex_to_vertex() -> None:
    """Each shortest diagonal of a Miura facet joins its obtuse corners, where creases end, to the bit."""
    mechanism = split(design_of(bent_miura(3, 3, "1 N*mm/rad")))
    crease = mechanism.joint("f1_1_d1")
    before, after = mechanism.joint("z1_1"), mechanism.joint("z2_1")
    across = np.cross(crease.axis, [before.point - crease.point, after.point - crease.point])
    assert across[0] @ across[1] < 0.0  # between the zigzags
    ends = {tuple(np.round(j.point + s * 0.0125 * j.axis, 12)) for j in (before, after) for s in (-1.0, 1.0)}
    line = next(
        c.hinge.line
        for c in split_steps(design_of(bent_miura(3, 3, "1"))).connections
        if c.hinge.name == "f1_1_d1"
    )
    assert {tuple(np.round([*end, crease.point[2]], 12)) for end in line.coords} < ends


def test_polygons_are_parted_by_their_shortest_diagonals() -> None:
    angles = np.radians([0, 50, 150, 200, 290])
    corners = np.column_stack([np.cos(angles), 0.7 * np.sin(angles)])
    diagonals = shortest_diagonals(corners)
    lengths = {
        (i, j): math.dist(corners[i], corners[j])
        for i in range(5)
        for j in range(i + 2, 5)
        if (i, j) != (0, 4)
    }
    assert diagonals[0] == min(lengths, key=lambda pair: lengths[pair])
    assert len(diagonals) == 2
    assert triangle_corners(4, [(0, 2)], (0, 2)) == [1, 3]


def test_corners_are_ends_of_hinges_and_turns_of_free_edges() -> None:
    square = Polygon([(0.05, 0.05), (10, 0.05), (10, 10), (0.05, 10)])
    lines = [LineString([(0, 0), (10, 0)]), LineString([(0, 0), (0, 10)])]
    corners = corners_of(square, lines, 0.5)
    assert corners is not None
    assert sorted(corners.tolist()) == [[0, 0], [0, 10], [10, 0], [10, 10]]
    notched = Polygon([(0.05, 0.05), (10, 0.05), (10, 10), (5, 2), (0.05, 10)])
    assert corners_of(notched, lines, 0.5) is None


def test_stiffness_is_that_of_bar_and_hinge_models() -> None:
    """Rhombi of 120 degrees bend along 40 mm and cut off corners of 60: C = 0.55 - 0.42 · 2/3 = 0.27; the film has no
    card's share, as layers are bonded."""
    text = corner("{stiffness: from-material}").replace(
        "flexible: true", "flexible: true, E1: 1 Pa, poisson: 0"
    )
    steps = split_steps(design_of(text))
    bending = 3e9 * 0.4e-3**3 / (12.0 * (1.0 - 0.3**2))
    expected = 0.27 * bending * (40e-3 / 0.425e-3) ** (1 / 3)
    found = steps.mechanism.joint("link_1_d1").stiffness
    assert found == pytest.approx(expected, rel=1e-6)  # the film's modulus is 3e-10 of the card's


@pytest.mark.parametrize("slenderness", [50.0, 1000.0])
def test_stiffness_is_near_that_of_a_thin_plate(slenderness: float) -> None:
    """A square plate loaded at its corners twists with 1/2 D (1 - ν) θ²: exact for small rotations and free edges. The
    fit, for edges held by folds, lies within a factor of two of it where sheets are thin."""
    side = 20.0
    thickness = side * math.sqrt(2.0) / slenderness
    text = f"""
kind: design
units: mm
materials: {{card: {{density: 700, E1: 3 GPa, poisson: 0.3, flexible: true}}}}
layers: [{{name: card, material: card, thickness: {thickness}}}]
shapes: [{{rect: [0, 0, {3 * side}, {side}]}}]
hinges:
  - {{line: [[{side}, 0], [{side}, {side}]], gap: 0.2}}
  - {{line: [[{2 * side}, 0], [{2 * side}, {side}]], gap: 0.2}}
fixed: [{{rect: [0, 0, 5, 5]}}]
facet_creases: {{stiffness: from-material}}
"""
    bending = 3e9 * (1e-3 * thickness) ** 3 / (12.0 * (1.0 - 0.3**2))
    found = split(design_of(text)).joint("link_1_d1").stiffness
    assert 0.5 < found / (bending * (1.0 - 0.3)) < 2.0


@needs_cc
def test_a_rigid_vertex_moves_where_facets_bend_and_keeps_its_energy() -> None:
    """Three creases of a vertex are rigid; with diagonals in two facets they are five, of two freedoms."""
    mechanism = split(design_of(corner("{stiffness: 0.5 N*mm/rad}", FOLDED)))
    sim = lamc.compile(mechanism, mechanism.scene)
    assert sim.loops.freedoms == 2
    result = sim.run(t_end=0.3, rtol=1e-9, atol=1e-11)
    assert result.status == 0
    assert np.ptp(result.angle("c0")) > 0.1
    energy = result.energy
    # Undamped: what is lost is what integration to 1e-9 loses, of the energy that moves.
    assert np.ptp(energy) < 1e-7 * np.ptp(result.energies["kinetic"])


def quadrilaterals(extra: str) -> Mechanism:
    """3 x 3 facets whose corners are anywhere within 2 mm: four vertices that do not fold together."""
    dice = random.Random(3)
    points = [
        (30 * i + 8 * (j % 2) + dice.uniform(-2, 2), 25 * j + dice.uniform(-2, 2))
        for j in range(4)
        for i in range(4)
    ]
    facets = [(k, k + 1, k + 5, k + 4) for k in (4 * j + i for j in range(3) for i in range(3))]

    def rest(a: int, b: int) -> tuple[str, float]:
        return ("z", math.radians(60.0)) if abs(a - b) == 4 else ("s", math.radians(30.0))

    names = [f"q{k}" for k in range(9)]
    return split(
        design_of(
            sheet(
                "quads",
                "made to be rigid",
                "",
                CreasePattern(points, facets, rest, names),
                {"z1": 20.0},
                extra,
            )
        )
    )


@pytest.mark.slow
@needs_cc
def test_quadrilaterals_of_any_shape_move_where_facets_bend() -> None:
    rigid = quadrilaterals("")
    with pytest.raises(DesignError, match=r"closes only within .* nothing moves: .*facet_creases"):
        lamc.compile(rigid, rigid.scene)
    mechanism = quadrilaterals("facet_creases: {stiffness: from-material}")
    sim = lamc.compile(mechanism, mechanism.scene)
    assert sim.loops.freedoms == 12 + 8 - 3 * 4  # creases and diagonals, less three for each vertex
    result = sim.run(t_end=0.3, rtol=1e-7, atol=1e-9)
    assert result.success
    assert np.ptp(result.angle("z1")) > 0.3
    bent = np.abs([result.angle(name) for name in mechanism.facet_creases])
    assert 1e-4 < bent.max() < 0.2  # some 600 times as stiff as creases
    assert result.constraint_error.max() <= 1e-9 * mechanism.size  # what lamc promises for any run


@needs_cc
def test_stiff_facets_fold_as_rigid_ones() -> None:
    """At 1e4 times the creases' stiffness facets bend by 1e-4 of a turn or so; angles of the first swing follow."""
    runs = []
    for text in (miura(2, 2), bent_miura(2, 2, "1 N*m/rad")):
        mechanism = split(design_of(text))
        assert mechanism.scene is not None
        runs.append(lamc.compile(mechanism, mechanism.scene).run(t_end=0.02, rtol=1e-7, t_eval=TIMES))
    rigid, bent = (np.array([run.angle(name) for name in ("z1_0", "z1_1", "s0_1", "s1_1")]) for run in runs)
    assert np.ptp(rigid) > 0.1
    np.testing.assert_allclose(bent, rigid, atol=2e-3)


def test_what_is_left_whole_is_told() -> None:
    steps = split_steps(
        design_of(miura(2, 1).replace("hinges:\n", "facet_creases: {stiffness: 1}\nhinges:\n", 1))
    )
    assert "1 facet bends along 1 diagonal of 1 N·m/rad" in steps.notes[0]
    assert steps.notes[0].endswith("left whole: 1 fixed")
    triangle = f"""{HEAD}
shapes: [{{polygon: [[0, 0], [20, 0], [40, 10], [20, 20], [0, 20]]}}]
hinges: [{{line: [[20, 0], [20, 20]], gap: 1}}]
fixed: [{{rect: [0, 0, 5, 20]}}]
facet_creases: {{stiffness: 1}}
"""
    (note,) = split_steps(design_of(triangle)).notes
    assert "none is parted; left whole: 1 fixed, 1 of three corners" in note


def test_materials_without_moduli_are_refused_at_their_layer() -> None:
    with pytest.raises(
        DesignError, match=r"drawn.yaml:9:.*'film' has no modulus or Poisson's ratio.*N\*m/rad"
    ):
        split(design_of(corner("{stiffness: from-material}")))
    grained = corner("{stiffness: from-material}").replace("E1: 3 GPa", "E1: 3 GPa, E2: 1 GPa")
    with pytest.raises(
        DesignError, match=r"drawn.yaml:8:.*isotropic.*'card' has moduli of 3e\+09 and 1e\+09 Pa"
    ):
        split(design_of(grained))


@pytest.mark.parametrize(
    ("said", "message"),
    [
        (
            "{stiffness: paper}",
            r"drawn.yaml:\d+:\d+: facet_creases.stiffness: it is 'paper'; .* or from-material",
        ),
        ("{stiffness: -1}", r"facet_creases.stiffness: .*at least 0"),
        ("{damping: 1e-6}", r"facet_creases.stiffness: this key is missing"),
        ("{stiffness: 1, bend: 2}", r"facet_creases.bend: the key 'bend' is unknown"),
        ("from-material", r"facet_creases: "),
    ],
)
def test_faults_are_told_at_their_line(said: str, message: str) -> None:
    with pytest.raises(DesignErrors, match=message):
        design_of(corner(said))
