"""Starts of mechanisms with loops: positions that close, and rates that keep them closed.

In: a `LoopGeometry`, what its loops come to, and what a scene gives for some of the joints, cut ones included. Out:
the nearest consistent start, by the squares of what was left open. Never: integrates, or changes what was given.
"""

import math
from collections.abc import Mapping
from functools import cache

import numpy as np

from lamc.basics.errors import DesignError
from lamc.basics.threads import on_one_thread
from lamc.loops.branches import Branch, Lead, clear_of, find_branches, moved_out
from lamc.loops.closing import ARRIVED, CLOSED, Mask, approach, settle, settle_all
from lamc.loops.geometry import LoopGeometry
from lamc.loops.leading import led_along
from lamc.loops.linear import EXACT
from lamc.loops.pushed import Push, pushed_branch
from lamc.loops.rank import LoopCount
from lamc.loops.tangents import tangents
from lamc.loops.texts import listed, named, ratios, resistance
from lamc.records.mechanism import Array
from lamc.records.scene import Scene

TRIES = 12  # random guesses from which to look for the nearest closed position
LARGE = 60  # joints: more than these are content with the first position found
SPREAD = 0.4  # rad, of the guesses
MOST_LED = 64  # steps of a given angle on the way from the drawn position
LED, FAR = (
    0.1,
    10.0,
)  # rad, their length; others may move as many times as much
CONSISTENT = 1e-8  # of the largest rate: given rates are some motion's if they miss it by less
ZERO = 1e-12  # rad/s below which a given rate is none


class Starter:
    """Starts of one mechanism."""

    def __init__(self, geometry: LoopGeometry, count: LoopCount, lead: Lead | None = None) -> None:
        self.geometry = geometry
        self.count = count
        self.cutoff = count.cutoff
        self._weak = count.cutoff if count.accepted_gap > 0.0 else 0.0
        self.size = len(geometry.names)
        self._branches = cache(
            lambda packed: find_branches(
                geometry, np.frombuffer(packed), count.fit, lead=lead, rank=count.rank
            )
        )
        self._found = cache(self._position)  # by angles given, sorted: each is asked for several times

    @on_one_thread
    def state(self, start: Scene) -> Array:
        """The state (2 n,) of all joints, rad and rad/s.

        Raises DesignError where no position has the angles, no motion the rates, and at a singular position where
        rates fit no branch or several. At rest there, without a branch, it stays in the singular position.
        """
        angles = self.position(start.angles)
        moving = _moving(start)
        if not self.is_singular(angles):
            if start.branch is not None:
                raise DesignError(
                    f"branch is {start.branch}, and the start is not singular: no branches part there; leave it out"
                )
            rates = self.rates(angles, start.rates)
        elif start.branch is not None:
            angles, rates = self._on_branch(angles, start.branch, moving)
        else:
            rates = self._at_branching(angles, moving)
        return np.concatenate([angles, rates])

    @on_one_thread
    def is_undecided(self, start: Scene) -> bool:
        """Whether a start is singular and at rest, and the scene does not say which way it goes."""
        if start.branch is not None or _moving(start):
            return False
        return self.is_singular(self.position(start.angles))

    @on_one_thread
    def pushed_branch(self, start: Scene, push: Push) -> int | None:
        """The number of the branch that loads choose at a singular position at rest; None where there is nothing to
        choose, or the scene does."""
        if not self.is_undecided(start):
            return None
        branches = self.branches(start)
        return pushed_branch(self.geometry, self.position(start.angles), branches, push, self.count.fit)

    @on_one_thread
    def branches(self, start: Scene) -> tuple[Branch, ...]:
        """The branches at the position that `start` asks for; empty where it is regular."""
        angles = self.position(start.angles)
        return self._branches(angles.tobytes()) if self.is_singular(angles) else ()

    @on_one_thread
    def rank_on(self, start: Scene, number: int) -> int:
        """The rank of the closure on a branch at the position that `start` asks for."""
        place, _ = self._on_branch(self.position(start.angles), number, {})
        return self.geometry.linear(place).rank(max(EXACT, self._weak))

    @on_one_thread
    def is_singular(self, angles: Array) -> bool:
        """Whether the closure has a smaller rank at `angles` (n,) than it has elsewhere."""
        return self.geometry.linear(angles).rank(max(EXACT, self._weak)) < self.count.rank

    @on_one_thread
    def position(self, given: Mapping[str, float]) -> Array:
        """Angles (n,), rad, of all joints: the given ones, and the others as near to zero as closure allows in the way
        of assembly that was drawn, where this leads there; angles count turns on the way. Facets that may bend are
        flat, where there is such a position."""
        known = self.count.start
        if known and (known.given, known.joints) == (tuple(sorted(given.items())), self.geometry.names):
            return np.array(known.angles)
        flat = dict.fromkeys(self.geometry.tree.mechanism.facet_creases, 0.0)
        if not flat.keys() <= given.keys():
            try:
                return self._found(tuple(sorted((flat | dict(given)).items()))).copy()
            except DesignError:
                pass  # rigid facets do not close there
        return self._found(tuple(sorted(given.items()))).copy()

    def _position(self, pairs: tuple[tuple[str, float], ...]) -> Array:
        given = dict(pairs)
        wanted, free = self._given(given)
        led = self._led_along(wanted, free)
        reached = [self._led_there(wanted, free) if led is None else (led, 0.0)]
        one_will_do = led is not None or not given or self.size > LARGE
        if not one_will_do or reached[0][1] > 0.0:
            random = np.random.default_rng(20260102)
            spread = random.normal(0.0, SPREAD, (TRIES - 2, self.size)) * free
            reached += self._all_closed(wanted + np.concatenate([np.zeros((1, self.size)), spread]), free)
        closed = [angles for angles, gap in reached if gap == 0.0]
        if not closed:
            raise DesignError(self._no_position(given, min(reached, key=lambda each: each[1])[0]))
        return self._nearest(np.array(closed[:1] if one_will_do else closed), wanted, free)

    @on_one_thread
    def rates(self, angles: Array, given: Mapping[str, float]) -> Array:
        """Rates (n,), rad/s, of all joints at closed `angles` (n,): the given ones, and the smallest others."""
        rates, missed = self._completed(angles, given)
        if missed:
            raise DesignError(self._no_motion(angles, given, missed))
        return rates

    @on_one_thread
    def is_elsewhere(self, start: Scene) -> bool:
        """Whether the angles of `start` are none that the mechanism comes to from a regular drawn position without a
        dead point, so that of the closed positions with them the one of smallest angles is taken."""
        drawn, given = np.zeros(self.size), start.angles
        if not given or self.size > LARGE or self.count.accepted_gap or self.is_singular(drawn):
            return False
        if len(given) > self.size - self.count.rank:
            return False  # more than may be chosen, as of a position that is known: they say themselves where it is
        return self._led_along(*self._given(given)) is None

    def given(self, values: Mapping[str, float]) -> Array:
        """`values` by name as a row (n,) of all joints, and zero for the others."""
        return self._given(values)[0]

    def _given(self, given: Mapping[str, float]) -> tuple[Array, Mask]:
        values, free = np.zeros(self.size), np.ones(self.size, dtype=bool)
        for name, value in given.items():
            index = self.geometry.names.index(name)
            values[index], free[index] = value, False
        return values, free

    def _closed(self, guess: Array, free: Mask) -> tuple[Array, float]:
        """The place that `settle` reaches, and the gap there, m; 0 where the loops count as closed."""
        angles, error = settle(self.geometry, guess, free, self.cutoff)
        return angles, self._gap(angles, error)

    def _gap(self, angles: Array, error: float) -> float:
        if error <= CLOSED:
            return 0.0
        # A gap may be nil while a cut hinge is away from its given angle.
        gap = max(float(self.geometry.gaps(angles).max()), error * self.geometry.size)
        return gap if gap > self.count.accepted_gap else 0.0

    def _all_closed(self, guesses: Array, free: Mask) -> list[tuple[Array, float]]:
        """The same of rows of guesses (s, n); of many joints until one is closed."""
        if self.size <= LARGE:
            places, errors = settle_all(self.geometry, guesses, free, self.cutoff)
            return [(a, self._gap(a, e)) for a, e in zip(places, errors.tolist(), strict=True)]
        reached: list[tuple[Array, float]] = []
        for guess in guesses:
            reached.append(self._closed(guess, free))
            if reached[-1][1] == 0.0:
                break
        return reached

    def _led_along(self, wanted: Array, free: Mask) -> Array | None:
        """The position on the branch of the drawn one, if that leads there: the way of assembly that was drawn."""
        if self.size > LARGE or self.count.accepted_gap:
            return None
        return led_along(self.geometry, np.zeros(self.size), wanted, free)

    def _led_there(self, wanted: Array, free: Mask) -> tuple[Array, float]:
        """As `_closed`, from the drawn position by steps of what is given, whose branch is not known to lead there."""
        place = np.zeros(self.size)
        held = np.logical_not(free)
        count = max(1, min(MOST_LED, math.ceil(float(np.abs(wanted).max(initial=0.0)) / LED)))
        for step in range(1, count + 1):
            guess = np.where(held, wanted * step / count, place)
            place, gap = self._closed(guess, free)
            if gap > 0.0 or np.abs(place - guess).max() > FAR * LED:
                return self._closed(wanted, free)
        return place, 0.0

    def _nearest(self, angles: Array, wanted: Array, free: Mask) -> Array:
        """The closed position around `angles` (s, n) with the least squares of its distance from `wanted`, or those."""
        found = list(angles)
        places = approach(self.geometry, angles, wanted, free, self.cutoff)
        moved = np.flatnonzero(np.abs(places - angles).max(axis=1) > ARRIVED)
        for k, (place, gap) in zip(moved.tolist(), self._all_closed(places[moved], free), strict=True):
            if gap == 0.0 and ((place - wanted) ** 2).sum() < ((angles[k] - wanted) ** 2).sum():
                found[k] = place
        return min(found, key=lambda each: float(((each - wanted) ** 2).sum()))

    def _completed(self, angles: Array, given: Mapping[str, float]) -> tuple[Array, float]:
        """Rates (n,), and by how much, rad/s, closure is missed; 0 for round-off."""
        rates, free = self._given(given)
        linear = self.geometry.linear(angles)
        if free.any():
            rates[free] = linear.columns(free).least_change(-linear.matrix @ rates, self.cutoff)
        missed = float(np.abs(linear.matrix @ rates).max())
        largest = max((abs(rate) for rate in given.values()), default=0.0)
        loose = self.count.accepted_gap / self.geometry.size
        return rates, missed if missed > (CONSISTENT + loose) * largest else 0.0

    def _on_branch(self, angles: Array, number: int, given: Mapping[str, float]) -> tuple[Array, Array]:
        """Angles and rates (n,): moved a little along the branch and at rest, or there with the given rates."""
        branches = self._branches(angles.tobytes())
        if not 1 <= abs(number) <= len(branches):
            raise DesignError(
                f"branch is {number}, and the start has {len(branches)}: {listed(branches)}; choose one of them"
            )
        way = float(np.sign(number)) * branches[abs(number) - 1].row(self.geometry.names)
        if not given:
            place = moved_out(self.geometry, angles, way, self.count.fit)
            if place is None:  # of loops that fit badly; exact ones have both ways
                raise DesignError(
                    f"branch {number} leads nowhere: the loops fit badly, and close on its other side only; choose "
                    f"{-number}"
                )
            if self.size > LARGE:
                most_open = max(CLOSED, self.count.accepted_gap / self.geometry.size)
                place = clear_of(self.geometry, angles, place, max(EXACT, self._weak), most_open)
            return place, np.zeros(self.size)
        rates = self._scaled(way, given)
        if rates is None:
            raise DesignError(
                f"no motion on branch {number} has the rates given ({named(given)} rad/s); its ratios are "
                f"{ratios(branches[abs(number) - 1])}"
            )
        return angles, rates

    def _at_branching(self, angles: Array, given: Mapping[str, float]) -> Array:
        """Rates (n,) at a singular position, where those given lie on one branch."""
        if not given:
            return np.zeros(self.size)
        branches = self._branches(angles.tobytes())
        scaled = [self._scaled(b.row(self.geometry.names), given) for b in branches if b.freedoms == 1]
        fitting = [rates for rates in scaled if rates is not None]
        if len(fitting) == 1:
            return fitting[0]
        if fitting:
            raise DesignError(
                f"the start is singular, and the rates given ({named(given)} rad/s) fit {len(fitting)} of its "
                f"branches: {listed(branches)}; choose one with branch=1 in the scene, or give more rates"
            )
        rates = self.rates(angles, given)
        held = np.logical_not(self._given(given)[1])
        on_family = tangents(self.geometry, angles, self.count.fit).nearest(rates, held)
        if on_family is None:
            raise DesignError(
                f"the start is singular, and the rates given ({named(given)} rad/s) lie on none of its branches: "
                f"{listed(branches)}"
            )
        return on_family

    def _scaled(self, way: Array, given: Mapping[str, float]) -> Array | None:
        """A branch's rates (n,) at the size that the given ones have; None where their ratios differ."""
        values, free = self._given(given)
        held = np.logical_not(free)
        square = float(way[held] @ way[held])
        rates = way * (float(way[held] @ values[held]) / square if square else 0.0)
        missed = np.abs(rates - values)[held].max()
        return rates if missed <= CONSISTENT * np.abs(values).max() else None

    def _no_position(self, given: Mapping[str, float], nearest: Array) -> str:
        gap = max(float(self.geometry.gaps(nearest).max()), 0.0)
        text = (
            f"no position closes the loops with the angles given ({named(given)} rad); the nearest comes within "
            f"{gap:.3g} m"
        )

        def without(name: str) -> float | None:
            _, free = self._given({key: value for key, value in given.items() if key != name})
            index = self.geometry.names.index(name)
            angles, left = self._closed(nearest, free)
            return float(angles[index]) if left == 0.0 else None

        return f"{text}; {resistance(given, without, 'rad')}"

    def _no_motion(self, angles: Array, given: Mapping[str, float], missed: float) -> str:
        text = (
            f"no motion of the loops has the rates given ({named(given)} rad/s): the nearest misses them by "
            f"{missed:.3g} rad/s"
        )

        def without(name: str) -> float | None:
            others = {key: value for key, value in given.items() if key != name}
            rates, left = self._completed(angles, others)
            return float(rates[self.geometry.names.index(name)]) if left == 0.0 else None

        return f"{text}; {resistance(given, without, 'rad/s')}"


def _moving(start: Scene) -> dict[str, float]:
    """The rates that are given and not nil."""
    return {name: rate for name, rate in start.rates.items() if abs(rate) > ZERO}
