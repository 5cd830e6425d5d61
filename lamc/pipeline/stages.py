"""The stages from a mechanism to C, as pure functions from record to record. Never: look into the cache."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

from lamc.basics.times import Times
from lamc.effects.registry import choose
from lamc.loops.rank import LoopCount
from lamc.mechanics.tangents import Columns
from lamc.mechanism.plan import plan
from lamc.records.effect import Effect
from lamc.records.inputs import NO_INPUTS, Input
from lamc.records.mechanism import Mechanism
from lamc.records.scene import Scene

if TYPE_CHECKING:
    from lamc.codegen.emit import SourceTree
    from lamc.mechanics.equations import Equations
    from lamc.symbolic.program import Program


def effects_of(mechanism: Mechanism, scene: Scene) -> tuple[Effect, ...]:
    """The effects that act, in the order of their names."""
    return tuple(choice.effect for choice in choose(mechanism, scene) if choice.effect is not None)


def equations_of(
    mechanism: Mechanism,
    effects: tuple[Effect, ...],
    times: Times | None = None,
    loops: LoopCount | None = None,
    inputs: Mapping[str, Input] = NO_INPUTS,
) -> "Equations":
    """plan and derive. loops: what the mechanism's loops come to; None: counted here. inputs: of the scene."""
    from lamc.mechanics.derive import derive

    times = times or Times()
    with times.stage("plan"):
        tree = plan(mechanism)
    with times.stage("derive"):
        return derive(tree, effects, loops, inputs)


def sources_of(
    equations: "Equations",
    times: Times | None = None,
    *,
    energy_balance: bool = False,
    columns: Columns | None = None,
    pullbacks: bool = False,
    precision: str = "double",
) -> "tuple[Program, SourceTree]":
    """lower and emit. energy_balance: with the power of every effect; columns: with derivatives by these; pullbacks:
    with those of weighted sums; precision: "double" or "float"."""
    from lamc.codegen.emit import emit
    from lamc.mechanics.lower import lower

    times = times or Times()
    with times.stage("lower"):
        program = lower(equations, energy_balance=energy_balance, columns=columns, pullbacks=pullbacks)
    with times.stage("emit"):
        return program, emit(program, precision)


def branch_sources(
    before: "tuple[Program, SourceTree]", equations: "Equations", times: Times, *, precision: str
) -> "tuple[Program, SourceTree]":
    """emit, of equations whose loops have another rank than those that the program `before` was lowered from."""
    from lamc.codegen.emit import emit
    from lamc.mechanics.lower import on_branch

    with times.stage("emit"):
        program, tree = before
        taken = on_branch(program, equations)
        return taken, emit(taken, precision, like=tree)
