"""Which coordinates, rates and inputs each result of a program depends on.

In: a `Program`. Out: per result the set of slots that it is made from, found by following its statements. Never:
evaluates anything; a dependence through a factor that happens to be zero counts.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from lamc.symbolic.program import Function, Operand, Program, Space

Slots = frozenset[tuple[Space, int]]
_NONE: Slots = frozenset()
_KNOWN = (Space.ANGLE, Space.RATE, Space.PARAMETER)


@dataclass(frozen=True)
class Dependencies:
    """Slots of coordinates, rates and parameters that results depend on, in the order of each function's results."""

    slopes: tuple[Slots, ...]  # of dq/dt, (nq,)
    accelerations: tuple[Slots, ...]  # (nu,)
    gap: Slots  # of the largest gap at a loop
    poses: tuple[Slots, ...]  # (12 bodies,)
    energies: tuple[Slots, ...]
    guards: Slots  # of all conditions for events


def dependencies(program: Program) -> Dependencies:
    """What the program's results depend on. Where the runtime solves M u̇ = f, all accelerations depend on all of M, f
    and what holds the loops."""
    constants = tuple(_followed(program.functions["setup"], ()))
    found = {name: tuple(_followed(f, constants)) for name, f in program.functions.items()}
    count = len(program.rates)
    if "acceleration" in found:
        accelerations = found["acceleration"]
    else:
        everything = _NONE.union(*(slots for name in program.motion for slots in found[name]))
        accelerations = (everything,) * count
    return Dependencies(
        slopes=found.get("rates") or tuple(frozenset({(Space.RATE, i)}) for i in range(count)),
        accelerations=accelerations,
        gap=_NONE.union(*found.get("closure", ())),
        poses=found["poses"],
        energies=found["energy"],
        guards=_NONE.union(*found.get("guards", ())),
    )


def _followed(function: Function, constants: tuple[Slots, ...]) -> Iterator[Slots]:
    """The slots behind each result, in order."""
    local: dict[int, Slots] = {}

    def behind(operand: Operand) -> Slots:
        if operand.space is Space.LOCAL:
            return local[operand.index]
        if operand.space is Space.CONSTANT:
            # A guard's mode is a constant that no setup makes: only the runtime changes it.
            return constants[operand.index] if operand.index < len(constants) else _NONE
        return frozenset({(operand.space, operand.index)}) if operand.space in _KNOWN else _NONE

    for statement in function.statements:
        local[statement.target.index] = _NONE.union(*map(behind, statement.operands))
    for _, operand in function.outputs:
        yield behind(operand)


def named(slots: Slots, references: Mapping[tuple[Space, int], int]) -> tuple[int, ...]:
    """The references of those slots that have one, ascending."""
    return tuple(sorted(references[slot] for slot in slots if slot in references))
