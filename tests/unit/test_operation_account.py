"""What each effect costs: operations by effect add up to the whole, and are what the effect brings."""

from pathlib import Path

import pytest

import lamc
from lamc.mechanics.lower import lower
from lamc.pipeline import effects_of, equations_of
from lamc.records.effect import Effect
from lamc.records.mechanism import Mechanism
from tests.support.every_effect import SAMPLES, mechanism
from tests.support.mechanisms import ALL_PASSIVE, chain, random_tree

OTHERS = ("gravity", "hinge_damping", "spring", "torque")


@pytest.mark.parametrize("name", sorted(SAMPLES))
def test_operations_by_effect_add_up_to_the_whole(name: str) -> None:
    effects = [SAMPLES[other] for other in OTHERS if other != name] + [SAMPLES[name]]
    whole = equations_of(mechanism(), tuple(effects))
    by_effect = whole.operations_by_effect
    assert set(by_effect) == {"", *(effect.name for effect in effects)}
    for count in ("additions", "multiplications", "reciprocals", "calls", "flops"):
        parts = [getattr(cost, count) for cost in by_effect.values()]
        assert sum(parts) == getattr(whole.operations, count)


@pytest.mark.parametrize("name", sorted(SAMPLES))
def test_one_effect_is_charged_with_what_it_adds_to_the_bare_mechanism(name: str) -> None:
    alone, bare = equations_of(mechanism(), (SAMPLES[name],)), equations_of(mechanism(), ())
    assert alone.operations_by_effect[""] == bare.operations
    assert alone.operations_by_effect[name].flops == alone.operations.flops - bare.operations.flops


def test_the_whole_is_what_the_c_computes() -> None:
    """Of a tree: operations in the header of its C; damping of n hinges costs a product and a sum each."""
    for made in (chain(4, "space", seed=1), random_tree(9, seed=2, kind="mixed")):
        sim = lamc.compile(made, lamc.Scene(effects=ALL_PASSIVE))
        equations = equations_of(made, ALL_PASSIVE)
        assert equations.operations == sim.program.functions["acceleration"].operations
        assert equations.operations_by_effect["hinge_damping"].flops == 2 * len(made.joints)


EXAMPLES = sorted(Path(lamc.__file__).parent.joinpath("examples").glob("*.yaml"))


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
@pytest.mark.quick(
    "bricard", "flapping_wing", "four_bar", "limit_stop", "pendulum", "shutter", "stiff_triple", "vertex"
)
def test_the_account_of_every_example_is_what_its_c_computes(path: Path) -> None:
    """In each of its scenes: trees and loops, fixed and afloat, in the air and on the ground."""
    drawn = lamc.load(path)
    made = drawn if isinstance(drawn, Mechanism) else lamc.split(drawn)
    for scene in (made.scene or lamc.Scene(), *made.scenes.values()):
        effects = effects_of(made, scene)
        assert_adds_up(made, effects)


@pytest.mark.slow
def test_the_account_of_all_effects_at_once_is_what_their_c_computes() -> None:
    """All samples that do not claim the same thing, several of those that may act several times."""
    alone = {"base_motion": "free_base", "free_base": "base_motion"}  # both claim the motion of the base
    for base, other in alone.items():
        motor = lamc.LinearMotor("h2", 1.0, torque_constant=0.2, resistance=3.0)
        spring = lamc.Spring("ground", (0.0, 0.1, 0.5), "a", (0.5, 0.0, 0.0), 4.0)
        effects = [SAMPLES[name] for name in sorted(SAMPLES) if name not in (other, "flexible_links")]
        by_effect = assert_adds_up(mechanism(), (*effects, motor, spring))
        assert base in by_effect
        one = assert_adds_up(mechanism(), (*effects, spring))
        assert by_effect["linear_motor"] > one["linear_motor"] > 0


def assert_adds_up(made: Mechanism, effects: tuple[Effect, ...]) -> dict[str, int]:
    """Flops by effect, which add up to those of the C that gives accelerations: to the last one where that is one
    function; where rates of coordinates have their own, up to the few numbers that both compute."""
    equations = equations_of(made, effects)
    counts = {name: cost.flops for name, cost in equations.operations_by_effect.items()}
    program = lower(equations)
    rates = program.functions["rates"].operations.flops if "rates" in program.functions else 0
    assert set(counts) == {"", *(effect.name for effect in effects)}
    whole = program.motion_operations.flops + rates
    assert sum(counts.values()) == (pytest.approx(whole, rel=2e-3) if rates else whole)
    return counts
