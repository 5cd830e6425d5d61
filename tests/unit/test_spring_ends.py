"""Springs whose ends lie in one place: refused where they need a direction, and without effect where not."""

from dataclasses import replace

import numpy as np
import pytest

import lamc
from lamc import plate
from lamc.effects.engine_loads import carried
from lamc.readers.load_scene import scene_of_text
from lamc.records.mechanism import Mechanism
from tests.support.ctools import needs_cc
from tests.support.mechanisms import chain

PIEZO = plate.Material(62e9, 62e9, 0.31, 23e9, 7800.0, d31=-190e-12, d32=-190e-12)
BIMORPH = plate.Laminate([plate.Ply(PIEZO, 127e-6), plate.Ply(PIEZO, 127e-6)])


def on_the_last_hinge(mechanism: Mechanism, **values: float) -> lamc.Spring:
    joint = mechanism.joints[-1]
    place = tuple(joint.point)
    return lamc.Spring(joint.parent, place, joint.child, place, stiffness=1.0, **values)


@needs_cc
@pytest.mark.parametrize(
    "count", [1, 3]
)  # ends known to be one when equations are made, and not before the run
@pytest.mark.parametrize("values", [{"rest_length": 0.01}, {"damping": 0.1}])
def test_a_spring_that_never_has_a_direction_is_refused(count: int, values: dict[str, float]) -> None:
    mechanism = chain(count)
    scene = lamc.Scene(effects=(on_the_last_hinge(mechanism, **values),))
    with pytest.raises(lamc.DesignError, match="both ends in one place at the start"):
        lamc.compile(mechanism, scene).run(t_end=0.1)


@needs_cc
def test_ends_that_have_parted_at_the_start_may_have_been_drawn_in_one_place() -> None:
    mechanism = chain(1)
    (joint,) = mechanism.joints
    away = tuple(joint.point + np.array([0.1, 0.0, 0.0]))
    spring = lamc.Spring(joint.parent, away, joint.child, away, stiffness=1.0, rest_length=0.01)
    assert (
        lamc.compile(mechanism, lamc.Scene(effects=(spring,), angles={joint.name: 0.5}))
        .run(t_end=0.1)
        .success
    )
    with pytest.raises(lamc.DesignError, match="both ends in one place at the start"):
        lamc.compile(mechanism, lamc.Scene(effects=(spring,))).run(t_end=0.1)


@needs_cc
def test_a_spring_without_length_may_lie_on_a_hinge() -> None:
    mechanism = chain(3)
    scene = lamc.Scene(effects=(on_the_last_hinge(mechanism),))
    assert lamc.compile(mechanism, scene).run(t_end=0.1).success


def with_two_walls() -> Mechanism:
    mechanism = chain(2)
    return replace(mechanism, bodies=(*mechanism.bodies, lamc.Body("wall", fixed=True)))


@pytest.mark.parametrize(
    ("ends", "told"),
    [
        (("body1", "body1"), "is within body 'body1', which is rigid"),
        (("ground", "ground"), "is within body 'ground', which is rigid"),
        (("ground", "wall"), "joins 'ground' and 'wall', which are both fixed"),
    ],
)
@pytest.mark.parametrize("values", [{"stiffness": 1.0}, {"stiffness": 0.0, "damping": 1.0}])
def test_a_spring_or_damper_within_one_rigid_body_is_refused(
    ends: tuple[str, str], told: str, values: dict[str, float]
) -> None:
    spring = lamc.Spring(ends[0], (0.0, 0.0, 0.0), ends[1], (0.1, 0.0, 0.0), **values)
    with pytest.raises(lamc.DesignError, match=f"the spring {told}, so that it acts on nothing"):
        lamc.compile(with_two_walls(), lamc.Scene(effects=(spring,)))


def test_it_is_refused_at_its_line_of_a_scene_file() -> None:
    scene = scene_of_text(
        "effects:\n  - spring: {body_a: body0, point_a: [0, 0, 0], body_b: body0, point_b: [1, 0, 0], stiffness: 1}\n",
        "scene.yaml",
    )
    with pytest.raises(lamc.DesignError, match=r"scene\.yaml:2:\d+: the spring is within body 'body0'"):
        lamc.compile(chain(1), scene)


def test_a_bender_between_fixed_bodies_is_refused() -> None:
    ends = ("ground", (0.0, 0.0, 0.0), "wall", (1e-2, 0.0, 0.0))
    bender = lamc.PiezoBender(*ends, (0.0, 0.0, 1.0), 2e-3, BIMORPH, (1.0, -1.0), 100.0)
    with pytest.raises(
        lamc.DesignError, match="piezo bender joins 'ground' and 'wall', which are both fixed"
    ):
        lamc.compile(with_two_walls(), lamc.Scene(effects=(bender,)))


def test_what_acts_on_nothing_is_no_spring_of_other_engines() -> None:
    spring = lamc.Spring("ground", (0.0, 0.0, 0.0), "wall", (0.1, 0.0, 0.0), 1.0)
    engine = carried(with_two_walls(), (spring,), ("body0", "body1"))
    assert not engine.springs
    assert "acts on nothing" in engine.lost[0].what
