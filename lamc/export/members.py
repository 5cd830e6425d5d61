"""Members of the structs of parameters and of inputs, as C and as people are told of them.

In: the parameters of a program. Out: their fields, with defaults and ranges as C says them, and rows of tables.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from lamc.codegen.names import comment, identifiers
from lamc.codegen.printer import REAL, literal
from lamc.export.markdown import markdown
from lamc.run.parameters import Bounds, bounds
from lamc.symbolic.program import Parameter, Program


@dataclass(frozen=True)
class CMember:
    """A member of the struct of parameters or of inputs; `slot` counts the program's parameters."""

    field: str
    name: str
    unit: str
    meaning: str
    default: str
    shown: str  # the default in print
    slot: int
    bounds: Bounds

    @property
    def least(self) -> str:
        """In C of either precision, as `most`."""
        return literal(self.bounds.least, REAL) if math.isfinite(self.bounds.least) else "-LAMC_GREATEST"

    @property
    def most(self) -> str:
        return literal(self.bounds.most, REAL) if math.isfinite(self.bounds.most) else "LAMC_GREATEST"

    @property
    def is_open(self) -> int:
        return int(self.bounds.is_open)

    @property
    def range(self) -> str:
        """What it can be, in print, with a semicolon; empty: any number."""
        parts = []
        if math.isfinite(self.bounds.least):
            parts.append(f"{'>' if self.bounds.is_open else '>='} {self.bounds.least:g}")
        if math.isfinite(self.bounds.most):
            parts.append(f"<= {self.bounds.most:g}")
        return " and ".join(parts) + ("; " if parts else "")


def members_of(parameters: Sequence[Parameter]) -> tuple[tuple[CMember, ...], tuple[CMember, ...]]:
    """Parameters and inputs."""
    fields = identifiers((p.name for p in parameters), taken=["geometry", "start"])
    members = [
        CMember(
            field,
            comment(p.name),
            comment(p.unit),
            comment(p.meaning),
            literal(p.default),
            repr(p.default),
            slot,
            bounds(p.name),
        )
        for slot, (field, p) in enumerate(zip(fields, parameters, strict=True))
    ]
    return (
        tuple(m for m, p in zip(members, parameters, strict=True) if not p.is_input),
        tuple(m for m, p in zip(members, parameters, strict=True) if p.is_input),
    )


def table_rows(program: Program, members: Sequence[CMember]) -> list[dict[str, str]]:
    """Field, default, unit and meaning of each, as text of Markdown."""
    rows = []
    for member in members:
        parameter = program.parameters[member.slot]
        rows.append(
            {
                "field": member.field,
                "default": f"{parameter.default:.6g}",
                "unit": markdown(parameter.unit),
                "meaning": f"{markdown(parameter.name)}: {markdown(parameter.meaning)}",
            }
        )
    return rows
