"""Springs whose ends lie in one place: refused where they need a direction, and without effect where not."""

import numpy as np
import pytest

import lamc
from lamc.records.mechanism import Mechanism
from tests.support.ctools import needs_cc
from tests.support.mechanisms import chain


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
