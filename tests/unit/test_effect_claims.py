"""What only one effect of a scene may have: two that claim it are refused, and those that give way do."""

from dataclasses import dataclass
from typing import ClassVar

import pytest

import lamc
from lamc.effects import Gravity, HingeStiffness, RestAngle
from lamc.effects.hinges import stiffness_claim
from lamc.effects.registry import choose
from lamc.mechanics.loads import Loads
from lamc.pipeline import equations_of
from lamc.records.mechanism import Mechanism
from lamc.records.scene import Scene
from tests.support.mechanisms import chain


@dataclass(frozen=True)
class Owner:
    """Claims whatever it is told to, and does nothing."""

    claimed: tuple[str, ...]
    name: ClassVar[str] = "owner"
    summary: ClassVar[str] = "Owner"
    repeatable: ClassVar[bool] = True

    def claims(self) -> tuple[str, ...]:
        return self.claimed

    def contribute(self, loads: Loads) -> None:
        pass


@dataclass(frozen=True)
class Rival(Owner):
    name: ClassVar[str] = "rival"


def sprung() -> Mechanism:
    """Two bodies in a row, hinges h0 and h1 with a stiffness and a rest angle."""
    mechanism = chain(2)
    joints = [
        lamc.Joint(j.name, j.parent, j.child, point=j.point, axis=j.axis, stiffness=2.0, rest_angle=0.3)
        for j in mechanism.joints
    ]
    return Mechanism(mechanism.bodies, tuple(joints))


@pytest.mark.parametrize("second", [Rival(("motion of the base",)), Owner(("motion of the base",))])
def test_two_effects_that_claim_the_same_are_refused_by_name(second: Owner) -> None:
    scene = Scene(effects=(Owner(("shade", "motion of the base")), Gravity(), second))
    words = (
        f"owner and {second.name} both claim the motion of the base, which only one.*leave one of them out"
    )
    with pytest.raises(lamc.DesignError, match=words):
        choose(chain(1), scene)


def test_one_effect_may_say_the_same_thing_twice_and_others_may_claim_other_things() -> None:
    scene = Scene(effects=(Owner(("motion of the base",) * 2), Rival(("light",))))
    assert [c.name for c in choose(chain(1), scene) if c.effect is not None] == ["owner", "rival"]


def test_the_account_says_what_an_effect_has_for_itself() -> None:
    reported = {c.name: c.reason for c in choose(chain(1), Scene(effects=(Owner(tuple("abcde")), Gravity())))}
    assert reported["owner"] == "the scene calls for it; it alone gives the a, the b, the c and 2 more"
    assert reported["gravity"] == "the scene calls for it"


def test_linear_springs_give_way_where_another_effect_claims_the_hinge() -> None:
    effects = (HingeStiffness(), Owner((stiffness_claim("h0"),)), RestAngle())
    parameters = {p.name for p in equations_of(sprung(), effects).parameters}
    assert {"h1.stiffness", "h1.rest_angle"} <= parameters
    assert not {"h0.stiffness", "h0.rest_angle"} & parameters
