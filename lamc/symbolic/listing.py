"""A function of a program as a list of steps that Python can walk through.

Goes in: a Function and what its operations mean. Comes out: a Listing, and by `run` the values of all its slots, be
they numbers or arrays. No text is made on the way.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from lamc.basics.errors import EmitError
from lamc.symbolic.program import Function, Operand, Shape, Space

Number = float | Fraction
Step = tuple[int, Callable[[Sequence[Any]], Any], tuple[int, ...]]


@dataclass(frozen=True)
class Listing:
    """A function with every slot as one address: steps (target, shape, operands) and signed outputs."""

    steps: tuple[Step, ...]
    outputs: tuple[tuple[int, int], ...]
    inputs: tuple[tuple[int, Space, int], ...]  # address, space, index
    literals: tuple[tuple[int, Number], ...]
    constants: tuple[tuple[int, int], ...]  # address, index of constant slots that the function assigns
    size: int


def run(
    listing: Listing, values: Mapping[Space, Sequence[Any]], number: Callable[[Number], Any] = float
) -> list[Any]:
    """The values of all slots, by address; `number` makes a value of a literal."""
    memory: list[Any] = [None] * listing.size
    for address, value in listing.literals:
        memory[address] = number(value)
    for address, space, index in listing.inputs:
        memory[address] = values[space][index]
    for target, operation, operands in listing.steps:
        memory[target] = operation([memory[k] for k in operands])
    return memory


def listing_of(function: Function, table: Mapping[str, Callable[..., Any]]) -> Listing:
    """`function` with flat addresses. A slot that no statement assigned before is an input or a literal."""
    addresses: dict[tuple[Space, int, Number], int] = {}
    inputs: list[tuple[int, Space, int]] = []
    literals: list[tuple[int, Number]] = []
    constants: list[tuple[int, int]] = []
    shapes: dict[Shape, Callable[[Sequence[Any]], Any]] = {}
    steps: list[Step] = []

    def address(operand: Operand) -> int:
        key = (operand.space, operand.index, operand.value)
        if key not in addresses:
            assert operand.space is not Space.LOCAL, f"{function.name} reads z{operand.index} too early"
            addresses[key] = len(addresses)
            if operand.space is Space.NUMBER:
                literals.append((addresses[key], operand.value))
            else:
                inputs.append((addresses[key], operand.space, operand.index))
        return addresses[key]

    for statement in function.statements:
        operands = tuple(address(o) for o in statement.operands)
        target = statement.target
        key = (target.space, target.index, target.value)
        assert key not in addresses, f"{function.name} assigns {target} twice or after reading it"
        addresses[key] = len(addresses)
        if target.space is Space.CONSTANT:
            constants.append((addresses[key], target.index))
        if statement.shape not in shapes:
            shapes[statement.shape] = _meaning(statement.shape, table)
        steps.append((addresses[key], shapes[statement.shape], operands))
    outputs = tuple((sign, address(operand)) for sign, operand in function.outputs)
    return Listing(tuple(steps), outputs, tuple(inputs), tuple(literals), tuple(constants), len(addresses))


def _meaning(shape: Shape, table: Mapping[str, Callable[..., Any]]) -> Callable[[Sequence[Any]], Any]:
    """The shape as a function of its operands' values."""
    if isinstance(shape, int):
        position = shape
        return lambda values: values[position]
    name, *parts = shape
    if not isinstance(name, str) or name not in table:
        raise EmitError(f"the operation {name!r} has no meaning in the interpreter")
    operation = table[name]
    if all(isinstance(part, int) for part in parts) and len(parts) == 2:
        i, j = parts
        return lambda values: operation(values[i], values[j])  # type: ignore[index]
    arguments = [_meaning(part, table) for part in parts]  # type: ignore[arg-type]
    if len(arguments) == 1:
        (only,) = arguments
        return lambda values: operation(only(values))
    first, second = arguments
    return lambda values: operation(first(values), second(values))
