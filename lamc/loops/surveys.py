"""Walks from a position of loops: what moves there exactly, and what nearly moves.

In: a `LoopGeometry`, a position. Out: `Survey`s of the places that small steps reach. Never: decides on a rank.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from lamc.loops.branches import find_branches, moved_out
from lamc.loops.closing import SMALL, SOLVE
from lamc.loops.geometry import LoopGeometry
from lamc.loops.linear import DENSE, EXACT
from lamc.loops.tangents import NEARLY, Fit, tangents
from lamc.loops.walks import LoopPosition, walk
from lamc.records.mechanism import Array

WALKS, STEPS = 2, 4  # random motions from a regular position, and the steps that tell the rank along each
ROUND = 32  # steps along which a misfit is measured, each way: half a turn of the joint that leads
CLEAR = 30.0  # times what may be a misfit's is what is not, where loops move exactly as well
LARGE, FEW = DENSE, 2  # joints: of more, one motion is looked at, by so many steps

Nullity = Callable[
    [LoopPosition], int
]  # how many of the singular values at a place are none but for a misfit


@dataclass(frozen=True, eq=False)
class Survey:
    """Walks from a position: those of each way together, one way for each branch; rates that are free there to first
    order; whether there may be more branches if the drawing is rounded; and the rank on each way, where its places do
    not tell it by themselves."""

    ways: list[list[LoopPosition]]
    is_singular: bool
    free: int
    may_be_rounded: bool = False
    ranks: tuple[int, ...] = ()

    @property
    def places(self) -> list[LoopPosition]:
        return [place for way in self.ways for place in way]

    @property
    def moves(self) -> bool:
        """Whether some walk goes on beyond its first step."""
        return any(len(way) > 1 for way in self.ways)

    @property
    def is_suspect(self) -> bool:
        """Whether equations that hold the motion are so weak, beside others, that they may be a misfit's."""
        clear = self.clearest(SMALL)
        lesser = clear.lesser(SMALL)
        weakest = float(clear.weak[lesser - 1]) if lesser else 0.0
        return weakest > EXACT and clear.clearness(lesser) > CLEAR * weakest

    def clearest(self, most: float) -> LoopPosition:
        """The place that is farthest from singular; values below `most` may be a misfit's."""
        return max(self.places, key=lambda place: place.clearness(place.lesser(most)))


def survey(
    geometry: LoopGeometry,
    start: Array,
    fit: Fit,
    cutoff: float,
    way: Array | None = None,
    count: int | None = None,
) -> Survey:
    """Walks from `start` (n,): along a way, or along branches, or along some motions where none part."""
    local = tangents(geometry, start, fit)
    steps = count or (FEW if len(start) > LARGE else STEPS)
    free = local.basis.shape[1]
    if way is not None:
        return Survey([_both(geometry, start, way, cutoff, steps)], local.count > 0, free)
    if local.count:
        branches = find_branches(geometry, start, fit, local)
        rows = [branch.row(geometry.names) for branch in branches]
        steps = steps if len(rows) <= WALKS else max(steps // 2, FEW)
        ways = [
            _both(geometry, start, row, cutoff, steps) or _near(geometry, start, row, fit) for row in rows
        ]
        # Fewer equations than unknowns have zeros whatever the rounding, and what rounding leaves is not several.
        # So it is of all that some form holds, whatever else is free.
        alone = sum(branch.freedoms == local.loose + 1 for branch in branches)
        generic = local.count < free - local.loose or alone > 1
        return Survey(ways, True, free, not generic)
    random = np.random.default_rng(20260101)
    count_of_ways = min(free, 1 if len(start) > LARGE else WALKS)
    motions = _among(random, count_of_ways, local.basis)
    return Survey([_both(geometry, start, row, cutoff, steps) for row in motions], False, free)


def _among(random: np.random.Generator, count: int, basis: Array) -> Array:
    """Random motions (count, n) of a space, the same whichever orthonormal basis (n, d) is given of it: a decomposition
    gives one or another by its round-off."""
    return np.asarray(random.normal(size=(count, len(basis))) @ basis @ basis.T)


def _both(geometry: LoopGeometry, start: Array, way: Array, cutoff: float, steps: int) -> list[LoopPosition]:
    """The places of a walk, and of the opposite one where it leads nowhere, or farther than a rank asks for."""
    places = walk(geometry, start, way, cutoff, steps)
    if not places or steps > STEPS:
        places = places + walk(geometry, start, -way, cutoff, steps)
    return places


def _near(geometry: LoopGeometry, start: Array, way: Array, fit: Fit) -> list[LoopPosition]:
    """The place next to a singular one, where no step is as short as a branch that turns back."""
    place = moved_out(geometry, start, way, fit)
    return [] if place is None else [LoopPosition(place, 0.0, geometry.linear(place).weak[0])]


def near_surveys(
    geometry: LoopGeometry, start: Array, exact: Survey, way: Array | None
) -> Iterator[tuple[Survey, Nullity]]:
    """Walks of loops that fit badly, and which singular values along them are a misfit's; the likeliest first."""
    place = LoopPosition(start, 0.0, geometry.linear(start).weak[0])
    steps = 2 * FEW if len(start) > LARGE else ROUND
    if exact.is_singular or not place.weak[place.weak < SMALL].max(initial=0.0) > EXACT:
        if place.lesser(SMALL) and (not exact.moves or exact.is_suspect or exact.may_be_rounded):
            coarse = 0.25 * SMALL
            fit = replace(NEARLY, weak=coarse)
            yield survey(geometry, start, fit, coarse, way, steps), lambda at: at.lesser(SMALL)
    elif not exact.moves:
        for nullity in place.gaps(SMALL):
            yield _drift(geometry, place, nullity, steps), lambda _, k=nullity: k  # type: ignore[misc]
    elif exact.is_suspect:
        clear = exact.clearest(SMALL)
        nullity = clear.lesser(SMALL)
        yield _drift(geometry, clear, nullity, steps), lambda _: nullity


def _drift(geometry: LoopGeometry, place: LoopPosition, nullity: int, steps: int) -> Survey:
    """Walks along motions that leave the `nullity` weakest equations open."""
    weakest = geometry.linear(place.angles).weak[1][:nullity]
    random = np.random.default_rng(20260101)
    motions = _among(random, min(nullity, WALKS), weakest.T)
    ways = [
        walk(geometry, place.angles, sign * row, SOLVE, steps, nullity)
        for row in motions
        for sign in (1.0, -1.0)
    ]
    return Survey([way for way in ways if way], False, nullity)
