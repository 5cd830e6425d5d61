"""What each effect costs: operations of one evaluation, effect by effect.

Goes in: Equations. Comes out: counts that add up to the whole. Much of what an effect costs lies outside its own
statements: a field in the accelerations of all links, a hinge torque in what is solved for. So the equations are
derived with one effect after the other, and each is charged with what it adds to those before it. Work that two effects
share is thus the first one's.
"""

from collections.abc import Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING

from lamc.mechanism.plan import plan
from lamc.records.effect import overrides
from lamc.symbolic.program import Operations

if TYPE_CHECKING:
    from lamc.mechanics.equations import Equations

MECHANISM = ""  # the motion without effects


def operations_by_effect(equations: "Equations") -> Mapping[str, Operations]:
    """Operations of one evaluation: of the mechanism alone under "", then what each effect adds, by its name.

    Those that bring coordinates come first, then the others in the order of the scene. They add up to
    `equations.operations`."""
    tree = plan(equations.tree.mechanism)
    ordered = sorted(equations.effects, key=lambda effect: not overrides(effect, "arrange"))
    loops = None if any(overrides(effect, "arrange") for effect in ordered) else equations.loops
    before = equations.derive(tree, (), loops, equations.inputs).operations
    result = {MECHANISM: before}
    for count, effect in enumerate(ordered, start=1):
        with_it = (
            equations
            if count == len(ordered)
            else equations.derive(tree, ordered[:count], loops, equations.inputs)
        )
        # Several motors, springs or wings have one name, and one line.
        so_far = result.get(effect.name, Operations())
        result[effect.name] = _changed(so_far, with_it.operations, before)
        before = with_it.operations
    return MappingProxyType(result)


def _changed(count: Operations, after: Operations, before: Operations) -> Operations:
    """`count` and what came after more than before."""
    return Operations(
        count.additions + after.additions - before.additions,
        count.multiplications + after.multiplications - before.multiplications,
        count.reciprocals + after.reciprocals - before.reciprocals,
        count.calls + after.calls - before.calls,
    )
