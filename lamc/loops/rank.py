"""What the loops of a mechanism come to: equations, rank, freedoms, misfit.

In: a `Tree`, a position, and the gap that its user allows. Out: a `LoopCount`. It looks at closed positions that the
mechanism reaches from there by small steps, as rank may be larger or smaller elsewhere; never at masses or forces.

At a regular position the rank is the same all around. At a singular one, such as a flat one, it is smaller than on the
branches that part there, and these may differ. A loop whose axes do not meet, or whose lengths do not close, has a
singular value that is small and not zero. With the rank that leaves it out the mechanism moves, and its loops stay open
by a misfit; with the rank that takes it in it is locked. Which of the two is meant cannot be known from the drawing;
the misfit is measured, and the user's tolerance decides.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from lamc.basics.errors import DesignError
from lamc.basics.threads import on_one_thread
from lamc.loops.closing import CLOSED, SMALL, SOLVE
from lamc.loops.geometry import LoopGeometry, geometry_of
from lamc.loops.linear import DENSE, EXACT
from lamc.loops.misfit import Misfit, measure_misfit, rounded_up
from lamc.loops.surveys import Nullity, Survey, near_surveys, survey
from lamc.loops.tangents import EXACTLY, MOST_FREE, NEARLY, Fit
from lamc.loops.texts import MAY_BEND
from lamc.loops.walks import LoopPosition, walk
from lamc.mechanism.tree import Tree
from lamc.records.mechanism import Array

# Drawings have three decimals of a millimetre: half a micrometre in each of the ten or twenty points around a loop. No
# drawing is meant to be off by more than a thousandth of its size.
TOLERANCE, ROUNDED, MOST_ROUNDED = 1e-4, 1.5e-5, 1e-3  # of the size; m; of the size
MARGIN = 10.0  # times the largest singular value of a misfit is one of no misfit's
# 1/rad: singular values of the second order are some tenths of the distance from a singular position, those of a misfit
# some hundredths of it where that has been left by more than the drawing is off
RISING = 0.05
FARTHER, FAR_STEPS = 2, 5  # ways of many loops that are followed farther, by steps of 0.1 rad


@dataclass(frozen=True)
class Found:
    """The closed position of a start: angles given, rad, by name, sorted; and those of all joints, in this order."""

    given: tuple[tuple[str, float], ...]
    joints: tuple[str, ...]
    angles: tuple[float, ...]


@dataclass(frozen=True)
class LoopCount:
    """What the loops of a mechanism come to, counted as in the field: six equations for each, all joints unknown.

    rank             of the equations where a run is: at its start, or on the branch that it takes from there
    singular_values  of the closure matrix there, descending; rotations in rad, lengths by short cycles in parts of
                     their reach. Of more than 60 hinges the largest and the smallest ones only
    misfit           how far loops stay open that nearly have a lower rank; None where they close
    tolerance        m, the gap that was allowed; a misfit within it is accepted, and `rank` is then the lower one
    cutoff           of the largest singular value: smaller ones are no equations
    branch_ranks     of each branch, where the start is singular; `rank` is the largest, or that of the branch taken
    shakes           rates that hold the loops closed to first order where nothing moves
    position         closed angles, rad, of all joints, at which the rank shows most clearly; empty: none is known
    pushed           the branch that loads chose, whose rank this is; None: not chosen here
    start            the closed position that was looked for to count there; None: as drawn, or not as these loops close
    """

    loops: int
    equations: int
    rank: int
    freedoms: int
    singular_values: tuple[float, ...] = ()
    misfit: Misfit | None = None
    tolerance: float = 0.0  # m
    cutoff: float = SOLVE
    branch_ranks: tuple[int, ...] = ()
    shakes: int = 0
    position: tuple[float, ...] = ()
    pushed: int | None = None
    start: Found | None = None

    @property
    def redundant(self) -> int:
        return self.equations - self.rank

    @property
    def accepted_gap(self) -> float:
        """The gap, m, up to which loops count as closed; 0 where they close to round-off."""
        return self.tolerance if self.misfit is not None and self.misfit.gap <= self.tolerance else 0.0

    @property
    def fit(self) -> Fit:
        """How exactly branches are to be looked for."""
        return EXACTLY if self.accepted_gap == 0.0 else replace(NEARLY, weak=self.cutoff)

    def on_branch(self, number: int) -> "LoopCount":
        """The count of a run that takes a branch, by its number; negative for the opposite way."""
        if not 0 < abs(number) <= len(self.branch_ranks):
            return self
        return self.of_rank(self.branch_ranks[abs(number) - 1])

    def of_rank(self, rank: int) -> "LoopCount":
        """The count of a run whose loops have another rank."""
        return (
            self if rank == self.rank else replace(self, rank=rank, freedoms=self.rank + self.freedoms - rank)
        )


NO_LOOPS = LoopCount(0, 0, 0, 0)


@on_one_thread
def count_loops(tree: Tree, tolerance: float | None = None) -> LoopCount:
    """The count for `tree` as drawn. Deterministic.

    tolerance: the gap, m, that counts as closed; None: `accepted_by_default`."""
    if not tree.cuts:
        return LoopCount(0, 0, 0, len(tree.links))
    geometry = geometry_of(tree)
    return count_at(geometry, np.zeros(len(geometry.names)), tolerance)


def count_at(
    geometry: LoopGeometry, angles: Array, tolerance: float | None = None, way: Array | None = None
) -> LoopCount:
    """The count at a closed position (n,), and along `way` (n,) from there; None: along all branches, if it is
    singular."""
    size = len(geometry.names)
    allowed = accepted_by_default(geometry.size) if tolerance is None else tolerance
    exact = survey(geometry, angles, EXACTLY, EXACT, way)
    # Where loops have a higher rank a little off, the start is singular, and the walk is on one family of many.
    risen = max((_rank(way, size, EXACT) for way in exact.ways), default=0) > size - exact.free
    if exact.free > MOST_FREE and (not exact.places or (risen and not exact.is_singular)):
        if exact.is_singular:
            raise DesignError(
                f"the start is singular, and {exact.free} rates are free there to first order: none of the ways that "
                f"were tried goes on, as the drawing is rounded, or holds itself; {MAY_BEND}"
            )
        raise DesignError(
            f"the start is singular, and {exact.free} rates are free there to first order: of more than {MOST_FREE}, "
            "no branches are looked for; start it a little off, by angles of some hinges"
        )
    misfit, nearly, cutoff = _nearly(geometry, angles, exact, way, allowed)
    accepted = misfit is not None and misfit.gap <= allowed
    taken = nearly if accepted else exact
    ranks = taken.ranks or tuple(_rank(way, size, cutoff if accepted else EXACT) for way in taken.ways)
    rank = max(ranks) if taken.places else size - _free_at_once(geometry, angles, exact)
    best = max(taken.places, key=lambda place: place.clearness(size - rank), default=None)
    position = angles if best is None else best.angles
    linear = geometry.linear(position)
    values = linear.scale * np.append(linear.weak[0], [] if linear.is_small else [1.0])
    return LoopCount(
        geometry.loops,
        6 * geometry.loops,
        rank,
        size - rank,
        tuple(values[::-1].tolist()),
        misfit,
        allowed,
        cutoff if accepted else SOLVE,
        ranks if taken.is_singular else (),
        0 if rank < size else exact.free,
        tuple(position.tolist()),
    )


def _free_at_once(geometry: LoopGeometry, angles: Array, exact: Survey) -> int:
    """How many rates are free where no walk leads on: next to a singular position any step is too long, and what the
    second order lets go, goes."""
    near = LoopPosition(angles, 0.0, geometry.linear(angles).weak[0]).clearness(exact.free) < SMALL
    return exact.free if near and not exact.is_singular else 0


def accepted_by_default(size: float) -> float:
    """The gap, m, that counts as closed in a mechanism of a size, m."""
    return max(TOLERANCE * size, min(ROUNDED, MOST_ROUNDED * size))


def _rank(way: Sequence[LoopPosition], size: int, cutoff: float) -> int:
    return max((size - int((place.weak <= cutoff).sum()) for place in way), default=0)


def _nearly(
    geometry: LoopGeometry, start: Array, exact: Survey, way: Array | None, allowed: float
) -> tuple[Misfit | None, Survey, float]:
    """The misfit of loops that nearly have a lower rank than they have exactly, the walks with this rank, and the
    cutoff that leaves the misfit out."""
    none: tuple[Misfit | None, Survey, float] = None, Survey([], False, 0), SOLVE
    size, best = len(geometry.names), none
    for found, nullity in near_surveys(geometry, start, exact, way):
        if not found.places:
            continue
        clear = max(found.places, key=lambda place: place.clearness(nullity(place)))
        rank = size - nullity(clear)
        if rank == size:
            continue
        if exact.is_singular and _rises(found, start, size - rank):
            continue
        misfit = measure_misfit(geometry, found.places, rank)
        weakest = max(float(place.weak[: size - rank].max(initial=0.0)) for place in found.places)
        cutoff = min(SMALL, math.sqrt(weakest * clear.clearness(size - rank)), MARGIN * weakest)
        best = misfit, found, max(cutoff, SOLVE)
        if misfit.gap <= allowed:
            if size <= DENSE:  # measured over half a turn
                return best
            farther = _farther(geometry, start, best, nullity, allowed)
            is_exact = farther[0].gap <= CLOSED * geometry.size and exact.moves
            return none if is_exact else farther
    # What is nearly so, and is not accepted, is no matter where loops move exactly as well.
    return none if exact.moves and not exact.is_suspect else best


def _farther(
    geometry: LoopGeometry, start: Array, near: tuple[Misfit, Survey, float], nullity: Nullity, allowed: float
) -> tuple[Misfit, Survey, float]:
    """The misfit, walks and cutoff of many loops as they are farther out than the few steps of a survey; those that are
    given where no motion goes on there.

    Near a singular position all that is of the second order is weak, and of hundreds of hinges some of it is as weak as
    a misfit is. What is none is closed by the motion farther out, or stays as it is; what is of the second order comes
    to hold, and loops that are to leave it out are torn. The most equations are left out with which none are.
    """
    misfit, found, _ = near
    size, ways, ranks = len(geometry.names), list(found.ways), dict[int, int]()
    taken: list[tuple[list[LoopPosition], int]] = []
    torn: list[LoopPosition] = []
    clearest = {k: max(way, key=lambda at: at.clearness(nullity(at))) for k, way in enumerate(ways) if way}
    for number in sorted(clearest, key=lambda k: -clearest[k].clearness(nullity(clearest[k])))[:FARTHER]:
        clear = clearest[number]
        weak = nullity(clear)
        while weak > 0:
            places = walk(geometry, clear.angles, clear.angles - start, 0.0, FAR_STEPS, weak)
            if places and measure_misfit(geometry, places, size - weak).gap <= allowed:
                taken.append((places, weak))
                ways[number], ranks[number] = [*ways[number], *places], size - weak
                break
            torn += places
            weak = max((k for k in (places or [clear])[-1].gaps(SMALL) if k < weak), default=0)
    if not taken:
        gap = measure_misfit(geometry, torn, misfit.rank).gap if torn else 0.0
        return replace(misfit, farther=gap), *near[1:]
    places = [place for way, _ in taken for place in way]
    weakest = max(float(place.weak[:weak].max()) for way, weak in taken for place in way)
    clearness = min(max(place.clearness(weak) for place in way) for way, weak in taken)
    cutoff = max(min(SMALL, math.sqrt(weakest * clearness), MARGIN * weakest), SOLVE)
    # Of ways that were not followed, what is weak near by and by this cutoff
    for k, clear in clearest.items():
        ranks.setdefault(k, size - max(1, min(nullity(clear), int((clear.weak <= cutoff).sum()))))
    by_way = tuple(ranks.get(k, 0) for k in range(len(ways)))
    farther = measure_misfit(geometry, places, size - min(weak for _, weak in taken))
    return farther, replace(found, ways=ways, ranks=by_way), cutoff


def _rises(found: Survey, start: Array, nullity: int) -> bool:
    """Whether the strongest of the `nullity` weakest equations holds so much at all places of a walk, by how far these
    are from its singular start, that it is of the second order, and no misfit, which is there from the start."""
    return all(
        place.clearness(nullity - 1) > RISING * float(np.abs(place.angles - start).max())
        for place in found.places
    )


def check_freedom(count: LoopCount) -> None:
    """Raises DesignError for loops that leave nothing to move, with the misfit if that is why."""
    if count.freedoms > 0 or not count.loops:
        return
    if count.misfit is not None:
        raise DesignError(
            f"{count.misfit.text}; taken exactly (rank {count.rank}, not {count.misfit.rank}) nothing moves: align "
            "its axes and lengths, or accept the gap with a closure_tolerance of "
            f"{rounded_up(count.misfit.gap):g} m or more; {MAY_BEND}"
        )
    shaky = (
        f"; to first order {count.shakes} rates are free as drawn, and none of them goes on"
        if count.shakes
        else ""
    )
    raise DesignError(
        f"the mechanism has no degree of freedom: its loops put {count.rank} independent equations on {count.rank} "
        f"hinge angles{shaky}; add a hinge, or remove one that closes a loop; {MAY_BEND}"
    )
