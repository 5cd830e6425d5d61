"""What each effect costs: operations by effect add up to the whole, and are what the effect brings."""

import pytest

import lamc
from lamc.pipeline import equations_of
from tests.every_effect import SAMPLES, mechanism
from tests.mechanisms import ALL_PASSIVE, chain, random_tree

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
