"""Guards: conditions on the state whose passing of zero is an event, staged.

Goes in: what effects say in `Loads.switch` and `Loads.impact`. Comes out: each guard with its rate and, for impacts,
its derivatives by the angles. It knows no effect by name, and finds no event: the runtime does.

A guard is negative where nothing happens. At a switch a force begins, and ends when the guard is negative again; the
force is written with a mode, a number that is 1 beyond the guard and 0 before, so that between two events the
equations are smooth. At an impact the guard's rate is reversed.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

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
    rate: Scalar  # of the guard, per s
    gradient: tuple[Scalar, ...]  # (nu,), of an impact, of the rate by u; empty for a switch


def guard_terms(guard: Guard, speeds: Mapping[Value, Scalar], u: Sequence[Value]) -> GuardTerms:
    """The guard with its derivatives; it may depend on q only. speeds: dq/dt. Impulses act along the guard's
    derivatives by the rates."""
    with u[0].store.section(f"Guard {guard.name}", source="event where it passes zero"):
        rate = derivative(guard.value, speeds)
        impact = guard.restitution is not None
        gradient = tuple(derivative(rate, {x: 1}) for x in u) if impact else ()
    return GuardTerms(guard, rate, gradient)
