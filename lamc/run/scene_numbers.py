"""Defaults of a compiled model's parameters as a scene gives them.

In: a module, the numbers of the design, what a scene says of parameters by name. Out: numbers, or a program, with other
defaults. Nothing is compiled for it. Raises RequestError for names that the model does not have.
"""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from lamc.basics.errors import about
from lamc.run.model import CompiledModule, DesignNumbers
from lamc.run.parameters import checked_parameters
from lamc.symbolic.program import Program, design_digest


def scene_numbers(
    module: CompiledModule, numbers: DesignNumbers, said: Mapping[str, float | str]
) -> DesignNumbers:
    """The numbers with what the scene says of parameters."""
    if not said:
        return numbers
    handle: Any = module.lib.lamc_this_model()
    count = int(handle.parameter_count)
    names, units = (
        tuple(module.ffi.string(pointers[k]).decode("utf-8") for k in range(count))
        for pointers in (handle.parameter_names, handle.parameter_units)
    )
    values = _checked(said, dict(zip(names, units, strict=True)))
    own = [values.get(name, value) for name, value in zip(names, numbers.inputs, strict=False)]
    return replace(numbers, inputs=(*own, *numbers.inputs[count:]))


def scene_program(program: Program, said: Mapping[str, float | str]) -> Program:
    """The program with what the scene says of parameters."""
    if not said:
        return program
    values = _checked(said, {p.name: p.unit for p in program.parameters})
    parameters = tuple(replace(p, default=values.get(p.name, p.default)) for p in program.parameters)
    made = replace(program, parameters=parameters)
    return replace(made, digest=design_digest(made.structure, made.inputs, made.drawn))


def _checked(said: Mapping[str, float | str], units: Mapping[str, str]) -> dict[str, float]:
    found: dict[str, float] = {}
    for name, value in said.items():
        with about(("parameters", name)):
            found |= checked_parameters({name: value}, units)
    return found
