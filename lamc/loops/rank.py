"""What the loops of a mechanism come to: equations, rank, freedoms, misfit.

In: a `Tree` and the gap that its user allows. Out: a `LoopCount`. It looks at generic closed positions, never at the
drawn one alone, which is often flat and of smaller rank; and never at masses, forces or a scene's start.

A loop whose axes do not meet, or whose lengths do not close, has a singular value that is small and not zero. With the
rank that leaves it out the mechanism moves, and its loops stay open by a misfit; with the rank that takes it in it is
locked. Which of the two is meant cannot be known from the drawing; the misfit is measured, and the user's tolerance
decides.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from lamc.basics.errors import DesignError
from lamc.loops.closing import CLOSED, EXACT, SMALL
from lamc.loops.geometry import LoopGeometry
from lamc.loops.misfit import Misfit, measure_misfit, rounded_up
from lamc.loops.positions import LoopPosition, ramped_positions, scattered_positions, walked_positions
from lamc.mechanism.tree import Tree
from lamc.records.mechanism import Array

TOLERANCE = 1e-6  # of the size: gaps that are accepted unless the user says otherwise


@dataclass(frozen=True)
class LoopCount:
    """What the loops of a mechanism come to, counted as in the field: six equations for each, all joints unknown.

    rank             of the equations at a generic closed position: the one that a run uses
    singular_values  of the closure matrix there, descending; rotations in rad, lengths in units of the mechanism's
                     size, displacements at the middle of its hinges
    misfit           how far loops stay open that nearly have a lower rank; None where they close
    tolerance        m, the gap that was allowed; a misfit within it is accepted, and `rank` is then the lower one
    position         closed angles, rad, of all joints, at which the rank shows most clearly; empty: none is known
    """

    loops: int
    equations: int
    rank: int
    freedoms: int
    singular_values: tuple[float, ...] = ()
    misfit: Misfit | None = None
    tolerance: float = 0.0  # m
    position: tuple[float, ...] = ()

    @property
    def redundant(self) -> int:
        return self.equations - self.rank

    @property
    def accepted_gap(self) -> float:
        """The gap, m, up to which loops count as closed; 0 where they close to round-off."""
        return self.tolerance if self.misfit is not None and self.misfit.rank == self.rank else 0.0


NO_LOOPS = LoopCount(0, 0, 0, 0)


def count_loops(tree: Tree, tolerance: float | None = None, known: Sequence[Array] = ()) -> LoopCount:
    """The count for `tree`: the largest rank at closed positions found from random places. Deterministic.

    tolerance  the gap, m, that counts as closed; None: 1e-6 of the size
    known      closed positions (n,), rad, of all joints as in `LoopGeometry`, to be looked at besides
    """
    if not tree.cuts:
        return LoopCount(0, 0, 0, len(tree.links))
    geometry = LoopGeometry(tree)
    allowed = TOLERANCE * geometry.size if tolerance is None else tolerance
    ramped = ramped_positions(geometry)
    closed = [LoopPosition.at(geometry, angles) for angles in (np.zeros(len(geometry.names)), *known)]
    closed += [place for place in ramped if place.error <= CLOSED] + scattered_positions(geometry)
    judged = closed + _open_ramps(geometry, ramped)
    rank = max(place.rank(EXACT) for place in judged)
    # Closed places of smaller rank are other branches of the motion, and no misfit.
    clearest = max(
        (place for place in judged if place.rank(EXACT) == rank or place.error > CLOSED),
        key=lambda place: (place.rank(SMALL), place.clearness(SMALL)),
    )
    misfit = None
    if clearest.rank(SMALL) < rank:
        misfit = measure_misfit(geometry, clearest.angles, clearest.rank(SMALL))
        if misfit is not None and misfit.gap <= allowed:
            rank = misfit.rank
    best = max(judged, key=lambda place: place.values[rank - 1] / place.values[0])
    count = len(geometry.names)
    values = tuple(float(value) for value in best.values)
    position = tuple(best.angles.tolist())
    return LoopCount(
        geometry.loops, 6 * geometry.loops, rank, count - rank, values, misfit, allowed, position
    )


def _open_ramps(geometry: LoopGeometry, ramped: Sequence[LoopPosition]) -> list[LoopPosition]:
    """Places of ramps that stay open, where most do and small steps do not close either: these loops fit badly.

    Where small steps close, the ramps asked a joint to turn farther than it can; then come the places of the steps."""
    nearly = [place for place in ramped if place.error > CLOSED]
    return (walked_positions(geometry) or nearly) if len(nearly) > len(ramped) / 2 else []


def check_freedom(count: LoopCount) -> None:
    """Raises DesignError for loops that leave nothing to move, with the misfit if that is why."""
    if count.freedoms > 0 or not count.loops:
        return
    if count.misfit is not None:
        raise DesignError(
            f"{count.misfit.text}; taken exactly (rank {count.rank}, not {count.misfit.rank}) nothing moves: align "
            "its axes and lengths, or accept the gap with a closure_tolerance of "
            f"{rounded_up(count.misfit.gap):g} m or more"
        )
    raise DesignError(
        f"the mechanism has no degree of freedom: its loops put {count.rank} independent equations on {count.rank} "
        "hinge angles; add a hinge, or remove one that closes a loop"
    )
