"""The integration methods of the C runtime: the one table that every other place reads.

In: nothing. Out: `METHODS`, what each is and does, and what `auto` goes by. `make methods` writes from it what C and
the guide say of them: `lamc_method` in lamc.h, `methods.h`, the table of `docs/guide/stiff.md`. Never: loads anything.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType


@dataclass(frozen=True)
class Method:
    """A method. Its C is the `lamc_method_NAME` of NAME.c in runtime_c/src."""

    name: str
    title: str  # for people
    when: str  # to take it, for people
    order: float  # of the solution that is carried on
    order_between: (
        float  # of the largest error at times between steps, where the continuous extension may have fewer
    )
    least_evaluations: float  # in a step, without a Jacobian
    is_implicit: bool = False  # asks for a Jacobian
    is_stiff: bool = False  # no step is too long for it to be stable
    is_chosen: bool = True  # by "auto" and accuracy=; False: by users alone
    has_fixed_steps: bool = (
        False  # of a length that is given: lamc_stiff_step, which is Rodas5P's and no other's
    )


_TABLE = (
    Method(
        "rk45",
        "Dormand–Prince 5(4), explicit",
        "loose tolerances, or a `max_step` that is short anyway",
        order=5.0,
        order_between=5.0,
        least_evaluations=6.0,
    ),
    Method(
        "dop853",
        "Dormand–Prince 8(5,3), explicit",
        "tight tolerances",
        order=8.0,
        order_between=8.0,
        least_evaluations=11.0,
    ),
    Method(
        "rodas5p",
        "Rosenbrock 5(4), no iteration",
        "stiff hinges",
        order=5.0,
        order_between=5.0,
        least_evaluations=8.0,
        is_implicit=True,
        is_stiff=True,
        has_fixed_steps=True,
    ),
    Method(
        "radau5",
        "Radau IIA of order 5, fully implicit",
        "the stiffest hinges, where `rodas5p` loses digits",
        order=5.0,
        order_between=4.0,
        least_evaluations=12.0,
        is_implicit=True,
        is_stiff=True,
    ),
)
METHODS: Mapping[str, Method] = MappingProxyType({method.name: method for method in _TABLE})
AUTO = "auto"
NUMBERS: Mapping[str, int] = MappingProxyType({name: k for k, name in enumerate((AUTO, *METHODS))})
NAMES = (*METHODS, AUTO)
SHOWN = ", ".join((AUTO, *METHODS))  # for help

# As `auto` and accuracy= try them: of the explicit ones the higher order first.
EXPLICIT = tuple(m.name for m in sorted(_TABLE, key=lambda m: -m.order) if m.is_chosen and not m.is_implicit)
IMPLICIT = tuple(m.name for m in _TABLE if m.is_chosen and m.is_implicit)
STIFFEST = max((m for m in _TABLE if m.is_chosen and m.is_stiff), key=lambda m: m.order).name

# What `auto` goes by, as in runtime_c/src/watch.c.
TIGHT = 3e-6  # rtol below which the higher order is faster
TIGHT_FOR_RADAU = 1e-7  # rtol below which it takes too many steps
LINEAR_ALGEBRA = 3.0  # of an implicit step, in evaluations: factors and solutions


def constant(name: str) -> str:
    """The `lamc_method` of a name, in C."""
    return f"LAMC_{name.upper()}"


def numbers_of_c() -> tuple[str, str]:
    """The first and the last method in C; LAMC_AUTO stands before them."""
    first, *_, last = map(constant, METHODS)
    return first, last
