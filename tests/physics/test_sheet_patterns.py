"""Patterns of triangles: what is drawn, the closed forms by which they fold alike, and that they come to rest so."""

import math
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import lamc
from lamc import examples
from lamc.commands.examples import mechanism_of_example
from lamc.examples.folded import mirrored, third_of_opposites
from lamc.loops.cycles import Kind, short_cycles
from lamc.mechanism.plan import plan
from tests.support.ctools import needs_cc
from tests.support.fold_corpus import hypar, write


def turned_around(folds: list[float], sectors: list[float]) -> np.ndarray:
    """The rotation by which facets come back to the first one, by Rodrigues' formula about one crease after the other
    in the flat sheet; the identity where the vertex closes. Folds about lines that later folds move: in reverse."""
    total, angle = np.eye(3), 0.0
    for fold, sector in zip(folds, sectors, strict=True):
        axis = np.array([math.cos(angle), math.sin(angle), 0.0])
        cross = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
        total = total @ (np.eye(3) + math.sin(fold) * cross + (1.0 - math.cos(fold)) * cross @ cross)
        angle += sector
    return total


@pytest.mark.parametrize("first", [-60.0, -5.0, 40.0])
@pytest.mark.parametrize("second", [-30.0, 0.5, 75.0])
def test_opposite_creases_alike_close_a_vertex(first: float, second: float) -> None:
    sectors = [math.radians(angle) for angle in (50.0, 72.0, 58.0)]
    one, two = math.radians(first), math.radians(second)
    folds = [one, two, third_of_opposites((sectors[0], sectors[1], sectors[2]), one, two)]
    # A dozen rotations' round-off.
    np.testing.assert_allclose(turned_around(2 * folds, 2 * sectors), np.eye(3), atol=1e-14)


@pytest.mark.parametrize(("known", "far"), [(-14.0, 20.0), (-40.0, 50.0), (5.0, 10.0)])
def test_a_vertex_that_is_its_mirror_image_closes(known: float, far: float) -> None:
    sectors = (math.radians(90.0), math.radians(50.0), math.radians(40.0))
    side, last = mirrored(math.radians(known), sectors, math.radians(far))
    folds = [math.radians(known), side, math.radians(far), last, math.radians(far), side]
    np.testing.assert_allclose(turned_around(folds, [*sectors, *sectors[::-1]]), np.eye(3), atol=1e-14)


@pytest.mark.quick(
    "kresling:1x2-4-0",
    "waterbomb_sheet:1x1-6-1",
    "resch:1x1-6-1",
    "yoshimura:4x5-40-12",
    "kresling:4x5-40-12",
)
@pytest.mark.parametrize(
    ("name", "facets", "vertices"),
    [
        ("yoshimura:4x5", 40, 3 * 4),
        ("kresling:4x5", 40, 3 * 4),
        ("kresling:1x2", 4, 0),
        ("waterbomb_sheet:3x4", 72, 12 + 4 * 3),
        ("waterbomb_sheet:1x1", 6, 1),
        ("resch:1x1", 6, 1),
        ("resch:3x3", 70, 25),
        ("resch:4x2", 62, 21),
    ],
)
def test_every_inner_vertex_is_a_cycle_of_six_creases(name: str, facets: int, vertices: int) -> None:
    mechanism = mechanism_of_example(examples.find(name))
    assert len(mechanism.bodies) == facets
    cycles = short_cycles(plan(mechanism))
    assert [(cycle.kind, len(cycle.joints)) for cycle in cycles] == vertices * [(Kind.SPHERICAL, 6)]
    assert all(joint.rest_angle for joint in mechanism.joints)


def test_valleys_fold_up_whichever_facet_is_the_child() -> None:
    """Facets beside a valley rise on both sides: the child turns towards +z about the joint's axis."""
    mechanism = mechanism_of_example(examples.find("yoshimura"))
    for joint in mechanism.joints:
        child = mechanism.body(joint.child)
        rises = float(np.cross(joint.axis, child.com - joint.point)[2])
        assert rises > 0.0
        assert joint.rest_angle * (1.0 if joint.name.startswith("h") else -1.0) > 0.0


@needs_cc
@pytest.mark.slow
@pytest.mark.parametrize("name", ["yoshimura", "kresling", "waterbomb_sheet"])
def test_sheets_come_to_rest_where_all_springs_are_at_ease(name: str) -> None:
    """Rest angles are a closed position with no energy at all. The slowest mode dies away by e in 6 s, measured."""
    mechanism = mechanism_of_example(examples.find(name))
    result = lamc.compile(mechanism, mechanism.scene).run(t_end=120.0, rtol=1e-8, atol=1e-10)
    assert result.success
    for joint in mechanism.joints:
        # 0.6 rad at first, and e^(-120 / 6) of it is left.
        assert result.angle(joint.name)[-1] == pytest.approx(joint.rest_angle, abs=1e-5)


@pytest.mark.quick("5", others="campaign")
@pytest.mark.filterwarnings("ignore::lamc.DesignWarning")
@pytest.mark.parametrize("rings", [3, 5, 9])
def test_a_ring_around_many_vertices_is_no_loop_though_it_is_as_short(rings: int, tmp_path: Path) -> None:
    """Eight creases leave the outermost square, and a corner within."""
    cycles = short_cycles(plan(lamc.load(write(tmp_path / "hypar.fold", hypar(rings)))))
    assert {cycle.kind for cycle in cycles} == {Kind.SPHERICAL}
    assert len(cycles) == 4 * (rings - 1) + 1
    assert max(len(cycle.joints) for cycle in cycles) == 8


@needs_cc
@pytest.mark.filterwarnings("ignore::lamc.DesignWarning")
@pytest.mark.parametrize("rings", [4, 7, 12])
@pytest.mark.quick("4", others="campaign")
def test_a_pleated_square_of_triangles_folds_in_one_way(rings: int, tmp_path: Path) -> None:
    """Three hinges for each vertex and one more. The rotations at each vertex, by scipy, come to none."""
    mechanism = lamc.load(write(tmp_path / "hypar.fold", hypar(rings)))
    simulator = lamc.compile(mechanism)
    assert simulator.freedoms == 1
    assert simulator.loops.misfit is None
    assert len(simulator.branches) > 1
    result = simulator.run(t_end=0.02)
    assert result.success
    tree = plan(mechanism)
    folds = {joint.name: result.angle(joint.name)[-1] for joint in tree.hinges}
    assert max(abs(fold) for fold in folds.values()) > 0.5
    for cycle in short_cycles(tree):
        joints = [tree.hinges[k] for k in cycle.joints]
        turns = [
            Rotation.from_rotvec(sign * folds[j.name] * np.array(j.axis))
            for sign, j in zip(cycle.signs, joints, strict=True)
        ]
        # The tolerance of a run's closure, 1e-12, and a dozen rotations' round-off.
        assert math.prod(turns[1:], start=turns[0]).magnitude() < 1e-11
