"""Of all ways out of a singular position the one that loads take from rest, where there is a family of them.

In: the second order there (`tangents`), the inertia of its free rates, and what loads do along each. Out: rates that
the second order allows. Never: knows what loads there are; follows a motion.

From rest a mechanism accelerates as near to what loads ask for, by kinetic energy, as its joints allow (C. F. Gauss,
"On a new general principle of mechanics", 1829). Here they allow a cone, the zeros of the forms, and the nearest of it
is where loads do most work: p / √I of `pushed`. Nearest in a neighbourhood are very many, as each vertex has folds of
its own. So the forms are springs at first, as if the sheet stretched, which get stiffer until they hold: all creases of
a Miura sheet fold as they rest then, though a fold along a straight line may have a little more work done on it
(graduated optimisation: A. Blake and A. Zisserman, "Visual reconstruction", 1987).
"""

from collections.abc import Iterator, Sequence

import numpy as np

from lamc.loops.tangents import Fit, Tangents
from lamc.loops.zeros import arrivals
from lamc.records.mechanism import Array

SOFTEST, STIFFEST = 1.0, 1e6  # of the springs, where inertia counts one: the last leaves forms at some 1e-4
STAGES = 8  # from one to the other
ROUNDS = 4  # of Newton's method at each
MOST_ROUNDS = 16  # of the ascent along the cone
GAIN = 1e-4  # of the work: a round that gains less is the last
MANY_ROUNDS, NO_GAIN = 200, 1e-12  # the same of few free rates: rates have the root of that
NOTHING = 1e-9  # of the largest form
SAMPLES = 4  # rows by which the sizes of forms are told
SINGULAR = 1e-14  # of the largest: forms that depend on one another are solved for all the same
DAMPED = 1e-3  # of the mean of the diagonal: where Newton's method begins
SHORTEST = 1e-3  # of a step along the cone
FEW = 40  # free rates: of more, each way to the cone takes a tenth of a second and more
# Of the size of what is asked for, where that itself leads to a corner: what is alike in two creases does not stay so.
BESIDE = (0.0, 0.1, 0.1, 0.3, 0.3)
# The same of few free rates besides: the work has several tops along the cone.
FARTHER = (0.6, 0.6, 1.0, 1.0, 1.0, 1.0)


def least_constrained(
    tangents: Tangents, inertia: Array, pull: Array, fit: Fit, *, by_work: bool = False
) -> Iterator[Array]:
    """Zeros (d,) of length one of all forms, near to where loads pull: by their work `pull` (d,) for each free rate and
    the inertia (d, d) of these. First where what loads ask for leads, and then where rates a little beside it do.
    by_work: of few free rates, from farther about as well, those on which most work is done first. Yields nothing
    where the inertia is singular, or nothing pulls."""
    try:
        upper = np.linalg.cholesky(inertia).T
    except np.linalg.LinAlgError:
        return
    by_energy = np.linalg.inv(upper)  # rates are by_energy @ y, and |y|² is twice the kinetic energy
    wanted = by_energy.T @ pull
    size = float(np.linalg.norm(wanted))
    if not 0.0 < size < np.inf:
        return
    wanted = wanted / size
    cone = _Cone(tangents, np.asarray(upper), np.asarray(by_energy), fit)
    few = by_work and len(wanted) <= FEW
    found = _arrivals(cone, wanted, BESIDE + FARTHER if few else BESIDE)
    tops = (_raised(cone, wanted, y, MOST_ROUNDS, GAIN) for y in found)
    for y in _by_work(cone, wanted, list(tops)) if few else tops:
        rates = by_energy @ y
        yield rates / np.linalg.norm(rates)


def _by_work(cone: "_Cone", wanted: Array, tops: list[Array]) -> Iterator[Array]:
    """The one of most work first, and exactly; of those alike the first, as round-off tells them apart."""
    works = [float(wanted @ y) for y in tops]
    least = (1.0 - GAIN) * max(works, default=0.0)
    order = sorted(range(len(tops)), key=lambda k: -min(works[k], least))
    for place, k in enumerate(order):
        yield tops[k] if place else _raised(cone, wanted, tops[k], MANY_ROUNDS, NO_GAIN)


def _arrivals(cone: "_Cone", wanted: Array, beside: Sequence[float]) -> Iterator[Array]:
    """Points of the cone, from starts so far beside what is wanted."""
    random = np.random.default_rng(20261128)
    for share in beside:
        found = cone.arrived(_softly(cone, wanted + share * cone.drawn(random)))
        if found is not None:
            yield found


class _Cone:
    """The zeros of the forms in coordinates y (d,) whose square is the kinetic energy; forms are of one size there."""

    def __init__(self, tangents: Tangents, upper: Array, by_energy: Array, fit: Fit) -> None:
        self.tangents, self.fit = tangents, fit
        self.upper, self.by_energy = upper, by_energy
        random = np.random.default_rng(20261127)
        samples = [np.sqrt(len(by_energy)) * self.drawn(random) for _ in range(SAMPLES)]
        squares = [np.square(self._raw(y)).sum(axis=1) for y in samples]
        sizes = np.sqrt(np.mean(squares, axis=0))
        # A form of a vertex that holds nothing on this space is round-off, and not to be made as large as the others.
        least = NOTHING * sizes.max(initial=0.0)
        self.scale = np.where(sizes > least, 1.0 / np.maximum(sizes, max(least, np.finfo(float).tiny)), 0.0)

    def drawn(self, random: np.random.Generator) -> Array:
        """A random point (d,) of length one; the same rates, whichever basis there is of them."""
        y = self.upper @ (self.tangents.basis.T @ random.normal(size=len(self.tangents.basis)))
        return np.asarray(y / np.linalg.norm(y))

    def _raw(self, y: Array) -> Array:
        return np.asarray(self.tangents.slopes(self.by_energy @ y) @ self.by_energy)

    def slopes(self, y: Array) -> Array:
        """(k, d)."""
        return np.asarray(self.scale[:, None] * self._raw(y))

    def values(self, y: Array) -> Array:
        """(k,)."""
        return np.asarray(self.scale * self.tangents.values(self.by_energy @ y))

    def arrived(self, y: Array) -> Array | None:
        """The zero of length one near y, if there is one."""
        points = arrivals(self.tangents, (self.by_energy @ y)[None], self.fit)
        if not len(points):
            return None
        found = self.upper @ points[0]
        return np.asarray(found / np.linalg.norm(found))


def _softly(cone: _Cone, wanted: Array) -> Array:
    """Where springs that get stiffer pull what is wanted to: Levenberg's and Marquardt's method at each stiffness."""
    y = wanted
    for stiffness in np.geomspace(SOFTEST, STIFFEST, STAGES):
        damping, left = DAMPED, _energy(cone, y, wanted, stiffness)
        for _ in range(ROUNDS):
            slopes = cone.slopes(y)
            matrix = np.eye(len(y)) + stiffness * (slopes.T @ slopes)
            usual = np.trace(matrix) / len(matrix)  # of the diagonal, which is another in another basis
            pull = y - wanted + stiffness * (slopes.T @ cone.values(y))
            while damping < 1.0 / DAMPED:
                tried = y - np.linalg.solve(matrix + damping * usual * np.eye(len(y)), pull)
                now = _energy(cone, tried, wanted, stiffness)
                if now < left:
                    y, left, damping = tried, now, 0.1 * damping
                    break
                damping *= 10.0
            else:
                break
    return y


def _energy(cone: _Cone, y: Array, wanted: Array, stiffness: float) -> float:
    return float(np.square(y - wanted).sum() + stiffness * np.square(cone.values(y)).sum())


def _raised(cone: _Cone, wanted: Array, y: Array, rounds: int, gain: float) -> Array:
    """The point of length one on the cone that is reached by going where the work rises most; a round that gains less
    than a share of it is the last."""
    y = y if wanted @ y >= 0.0 else -y
    step = 1.0
    for _ in range(rounds):
        work = float(wanted @ y)
        slopes = cone.slopes(y)
        squares = slopes @ slopes.T
        squares[np.diag_indices_from(squares)] += SINGULAR * np.trace(squares) + np.finfo(float).tiny
        uphill = wanted - slopes.T @ np.linalg.solve(squares, slopes @ wanted)
        uphill = (uphill - (uphill @ y) * y) / max(work, SHORTEST)
        while step > SHORTEST:
            tried = cone.arrived(y + step * uphill)
            if tried is not None and float(wanted @ tried) > work:
                break
            step *= 0.5
        else:
            return y
        y, step = tried, min(1.0, 2.0 * step)
        if float(wanted @ y) < (1.0 + gain) * work:
            return y
    return y
