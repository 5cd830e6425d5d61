"""Guards: conditions on the state whose passing of zero is an event, staged.

Goes in: what effects say in `Loads.switch` and `Loads.impact`. Comes out: each guard with its rate, in two parts where
it depends on rates, and for impacts its derivatives by the angles. It knows no effect by name, and finds no event: the
runtime does.

A guard is negative where nothing happens. At a switch a force begins, and ends when the guard is negative again; the
force is written with a mode, a number that is 1 beyond the guard and 0 before, so that between two events the
equations are smooth. At an impact the guard's rate is reversed.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from lamc.basics.errors import DesignError
from lamc.symbolic.derivative import derivative
from lamc.symbolic.scalars import Scalar, Value


@dataclass(frozen=True)
class Guard:
    """What an effect gives. Either `mode` or `restitution` is there."""

    name: str
    value: Scalar
    mode: Value | None = None
    restitution: Scalar | None = None


@dataclass(frozen=True)
class GuardTerms:
    """A guard with what the runtime needs of it."""

    guard: Guard
    rate: Scalar  # of the guard, per s, as far as it depends on t and q
    gradient: tuple[Scalar, ...]  # (nu,), of an impact, of the rate by u; empty for a switch
    by_rates: Scalar = 0  # what u̇ adds to the rate; 0 for a guard that does not depend on u


def guard_terms(
    guard: Guard, speeds: Mapping[Value, Scalar], u: Sequence[Value], udot: Callable[[], Sequence[Value]]
) -> GuardTerms:
    """The guard with its derivatives. An impact may depend on t and q only, and impulses act along the derivatives of
    its rate by the rates; a switch may depend on u too.

    speeds  dq/dt, and of t; udot: makes the symbols of u̇, which nothing has that does not ask
    """
    with u[0].store.section(f"Guard {guard.name}", source="event where it passes zero"):
        rate = derivative(guard.value, speeds)
        impact = guard.restitution is not None
        gradient = tuple(derivative(rate, {x: 1}) for x in u) if impact else ()
        if not _depends(guard.value, u):
            return GuardTerms(guard, rate, gradient)
        if impact:
            raise DesignError(
                f"the impact {guard.name!r} depends on rates; an impact may depend on angles only"
            )
        changes = dict(zip(u, udot(), strict=True))
        return GuardTerms(guard, rate, gradient, derivative(guard.value, changes))


def _depends(value: Scalar, symbols: Sequence[Value]) -> bool:
    """Whether any of the symbols stands in `value`."""
    if not isinstance(value, Value):
        return False
    live = set(value.store.live([value]))
    return any(symbol.index in live for symbol in symbols)
