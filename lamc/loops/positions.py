"""Generic positions of loops: closed, or as near to closed as they come, and away from the drawn one.

In: a `LoopGeometry`. Out: a few `LoopPosition`s. The drawn position is often flat, where the rank of the closure is
smaller than anywhere else. Never: decides on a rank.
"""

from dataclasses import dataclass
from typing import Self

import numpy as np

from lamc.loops.closing import CLOSED, EXACT, SMALL, Mask, directions, settle
from lamc.loops.geometry import LoopGeometry
from lamc.records.mechanism import Array

RAMPS = 4  # ways out of the drawn position that are tried
RAMP = (0.1, 0.2, 0.4)  # rad, of one joint, on each of them
SCATTER, LARGE = (12, 2), 60  # random guesses, and how many where there are more joints than LARGE
SPREAD = 0.4  # rad, of the random guesses
HELD = (0.3, 1.0)  # rad, by which one joint is held away from the drawn position
WALKS, STEPS = 2, 12  # from the drawn position, both ways, and the steps of each
STEP = 0.05  # rad, their length
ADVANCE = 0.5  # of a step's length: a step that comes less far is none
POLISH = 0.1  # rad: a place that closes nearly has a closed one nearer than this, or none that belongs to it
CLEAR = 1e-6  # relative to the largest singular value: nearer to a singular position none can be told from round-off


@dataclass(frozen=True, eq=False)
class LoopPosition:
    """A position. angles (n,), rad; error: largest residual of closure, rad or units; values (n,): singular values of
    its closure matrix, descending."""

    angles: Array
    error: float
    values: Array

    @classmethod
    def at(cls, geometry: LoopGeometry, angles: Array, error: float = 0.0) -> Self:
        return cls(angles, error, directions(geometry, angles)[0])

    def rank(self, cutoff: float) -> int:
        """How many singular values are above `cutoff` times the largest."""
        return int((self.values > cutoff * self.values[0]).sum())

    def clearness(self, cutoff: float) -> float:
        """The smallest of them, relative to the largest."""
        return float(self.values[self.rank(cutoff) - 1] / self.values[0])


def ramped_positions(geometry: LoopGeometry) -> list[LoopPosition]:
    """Out of the drawn position along some of the motions that it allows; where loops fit badly these stay open."""
    drawn = np.zeros(len(geometry.names))
    values, vectors = directions(geometry, drawn)
    motions = vectors[(values > SMALL * values[0]).sum() :]
    random = np.random.default_rng(20260101)
    tangents = random.normal(size=(RAMPS if len(motions) else 0, len(motions))) @ motions
    found = [place for place in (_ramp(geometry, tangent) for tangent in tangents) if place is not None]
    return [place for place in found if place.error > CLOSED or place.clearness(EXACT) > CLEAR]


def scattered_positions(geometry: LoopGeometry) -> list[LoopPosition]:
    """Closed positions near random guesses, with one joint held: on branches of the motion that no ramp may find."""
    count = len(geometry.names)
    random = np.random.default_rng(20260102)
    places: list[LoopPosition] = []
    for _ in range(SCATTER[count > LARGE]):
        guess = random.normal(0.0, SPREAD, count)
        held = int(random.integers(count))
        guess[held] = random.choice([-1.0, 1.0]) * random.uniform(*HELD)
        angles, error = settle(geometry, guess, np.arange(count) != held)
        place = LoopPosition.at(geometry, angles, error)
        if error <= CLOSED and place.clearness(EXACT) > CLEAR:
            places.append(place)
    return places


def walked_positions(geometry: LoopGeometry) -> list[LoopPosition]:
    """Closed positions that small steps from the drawn one reach with the loops closed all the way, and from which it
    goes on: what the mechanism as assembled can do, however little one of its joints may turn."""
    drawn = np.zeros(len(geometry.names))
    values, vectors = directions(geometry, drawn)
    motions = vectors[(values > EXACT * values[0]).sum() :]
    random = np.random.default_rng(20260103)
    tangents = random.normal(size=(WALKS if len(motions) else 0, len(motions))) @ motions
    places = [
        place for tangent in tangents for way in (1.0, -1.0) for place in _walk(geometry, way * tangent)
    ]
    return [place for place in places if place.clearness(EXACT) > CLEAR]


def _walk(geometry: LoopGeometry, tangent: Array) -> list[LoopPosition]:
    """The places of one walk; none where it cannot take its steps, as on a tangent that is no motion."""
    places: list[LoopPosition] = []
    angles = np.zeros(len(tangent))
    for _ in range(STEPS):
        ahead = tangent / np.linalg.norm(tangent)
        following, error = settle(geometry, angles + STEP * ahead)
        if error > CLOSED or (following - angles) @ ahead < ADVANCE * STEP:
            break
        angles = following
        values, vectors = directions(geometry, angles)
        motions = vectors[(values > EXACT * values[0]).sum() :]
        if not len(motions):
            return []
        places.append(LoopPosition(angles, error, values))
        tangent = motions.T @ (motions @ ahead)
    return places


def _ramp(geometry: LoopGeometry, tangent: Array) -> LoopPosition | None:
    """Out of the drawn position in the direction of `tangent`, farther and farther."""
    held = int(np.argmax(np.abs(tangent)))
    free = np.arange(len(tangent)) != held
    angles = tangent
    place: LoopPosition | None = None
    for rotation in RAMP:
        angles = angles * (rotation / abs(angles[held]))
        following = _place(geometry, angles, free)
        if following is None or following.angles[held] == 0.0:
            break
        place, angles = following, following.angles
    return place


def _place(geometry: LoopGeometry, guess: Array, free: Mask) -> LoopPosition | None:
    angles, error = settle(geometry, guess, free, SMALL)
    for held in (free, np.ones_like(free)):  # freed where the joint that was held is out of its reach
        if error > CLOSED:
            angles, error = settle(geometry, angles, held, SMALL)
            polished, rest = settle(geometry, angles, held)
            if rest <= CLOSED and np.abs(polished - angles).max() <= POLISH:
                angles, error = polished, rest
    return LoopPosition.at(geometry, angles, error) if error <= SMALL else None
