"""Guards: conditions on the state whose passing of zero is an event, staged.

Goes in: what effects say in `Loads.switch` and `Loads.impact`. Comes out: each guard with its rate, in two parts where
it depends on rates, and for impacts its derivatives by the angles. It knows no effect by name, and finds no event: the
runtime does.

A guard is negative where nothing happens. At a switch a force begins, and ends when the guard is negative again; the
force is written with a mode, a number that is 1 beyond the guard and 0 before, so that between two events the
equations are smooth. At an impact the guard's rate is reversed. At the tick of a clock, samples are taken and held.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

from lamc.basics.errors import DesignError
from lamc.symbolic.derivative import derivative
from lamc.symbolic.program import Space
from lamc.symbolic.scalars import Scalar, Value
from lamc.symbolic.staging import Store

MOST_HELD = 1000  # by one clock


@dataclass(frozen=True)
class Guard:
    """What an effect gives. One of `mode`, `restitution` and `clock` is there."""

    name: str
    value: Scalar
    mode: Value | None = None
    restitution: Scalar | None = None
    clock: "Clock | None" = None


@dataclass
class Clock:
    """What is sampled at each multiple of a period, s, and held until the next.

    tick  symbol of the time of the next sample, s; held: symbols of what is held, each with what it is a sample of
    """

    store: Store
    number: int  # among clocks
    period: Scalar
    tick: Value
    held: dict[Value, Scalar] = field(default_factory=dict)

    def hold(self, value: Scalar) -> Value:
        """A number that is `value` as it was at the last sample, a function of the state and of no mode."""
        place = len(self.held)
        symbol = self.store.symbol(
            f"held_{self.number}_{place}", Space.CONSTANT, held_index(self.number, place)
        )
        self.held[symbol] = value
        return symbol


def held_index(clock: int, place: int) -> int:
    """Of the symbols of a clock among those that the runtime sets: below zero, where no mode is. place -1: its tick."""
    return -(1 + MOST_HELD * clock + place + 1)


@dataclass(frozen=True)
class GuardTerms:
    """A guard with what the runtime needs of it."""

    guard: Guard
    rate: Scalar  # of the guard, per s, as far as it depends on t and q
    gradient: tuple[Scalar, ...]  # (nu,), of an impact, of the rate by u; empty for a switch
    by_rates: Scalar = 0  # what u̇ adds to the rate; 0 for a guard that does not depend on u


def check_guards(guards: Sequence[Guard]) -> None:
    """Raises DesignError for a guard or a sample that holds a mode: where a run starts all modes are set at once."""
    modes = [guard.mode for guard in guards if guard.mode is not None]
    for guard in guards:
        sampled = [] if guard.clock is None else [*guard.clock.held.values()]
        if modes and any(_depends(value, modes) for value in (guard.value, *sampled)):
            raise DesignError(
                f"the guard {guard.name!r} depends on what another switch gives, which is not known where a run "
                "starts; write it without, as by max(…) or min(…)"
            )


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
