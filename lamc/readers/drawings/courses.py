"""Lines and curves in space, moved by matrices, and as points on them within a tolerance.

In: corners, arcs, control points. Out: arrays of points. Never: knows what a line is for, or the file that it is of.

An arc of a circle or an ellipse is c + u cos t + v sin t: an affine map moves c, u and v, so that mirrored extrusions
and uneven scales need nothing of their own, and corners stay what the file says to the last digit. Matrices act on
rows: (x, y, z, 1) @ M.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from lamc.records.mechanism import Array

_ROUGH = 0.2  # rad, between the points that say how large a drawing is: 0.5 % of a radius
_MOST = 100_000  # points of one curve
SAME = 1e-12  # of a curve's size: closer points are one
_ROUNDS = 16  # halvings of a spline's pieces: chords of a smooth curve are 4^16 times nearer then


@dataclass(frozen=True)
class Points:
    """Corners, (n, 3)."""

    rows: Array

    def moved(self, matrix: Array) -> "Points":
        return Points(self.rows @ matrix[:3, :3] + matrix[3, :3])

    def flat(self, tolerance: float | None) -> Array:
        return self.rows


@dataclass(frozen=True)
class Arc:
    """centre + along cos t + across sin t between two t, its ends left out; rad."""

    centre: Array
    along: Array
    across: Array
    start: float
    end: float

    def at(self, t: Array) -> Array:
        found: Array = self.centre + np.outer(np.cos(t), self.along) + np.outer(np.sin(t), self.across)
        return found

    def moved(self, matrix: Array) -> "Arc":
        turned = matrix[:3, :3]
        centre = self.centre @ turned + matrix[3, :3]
        return Arc(centre, self.along @ turned, self.across @ turned, self.start, self.end)

    def flat(self, tolerance: float | None) -> Array:
        """Points between the ends; a chord of angle h is off by 1 - cos(h/2) of the larger radius at most."""
        step = _ROUGH
        if tolerance is not None:
            radius = float(np.linalg.norm(np.array([self.along, self.across]), 2))
            step = 2.0 * math.acos(max(1.0 - tolerance / radius, 0.5)) if radius > 0.0 else math.pi
        turns = abs(self.end - self.start) / step
        if not math.isfinite(turns):
            return np.full((1, 3), math.nan)
        count = min(max(math.ceil(turns), 2), _MOST)
        return self.at(np.linspace(self.start, self.end, count + 1)[1:-1])


@dataclass(frozen=True)
class Spline:
    """A rational B-spline: control points times weights, and weights, (n, 4); its ends included."""

    control: Array
    knots: Array
    degree: int

    def moved(self, matrix: Array) -> "Spline":
        return Spline(self.control @ matrix, self.knots, self.degree)

    def flat(self, tolerance: float | None) -> Array:
        """Pieces between knots, halved until their chords are near at three places within."""
        from scipy.interpolate import BSpline

        curve = BSpline(self.knots, self.control, self.degree)

        def at(t: Array) -> Array:
            found = curve(t)
            return np.asarray(found[:, :3] / found[:, 3:])

        spans = np.unique(self.knots[self.degree : len(self.knots) - self.degree])
        shares = np.arange(self.degree + 1) / (self.degree + 1)
        t = np.append((spans[:-1, None] + np.diff(spans)[:, None] * shares).ravel(), spans[-1])
        if tolerance is None:
            return at(t)
        for _ in range(_ROUNDS):
            far = _off(at, t) > tolerance
            if not far.any() or len(t) > _MOST:
                break
            t = np.sort(np.concatenate([t, (0.5 * (t[:-1] + t[1:]))[far]]))
        return at(t)


@dataclass(frozen=True)
class Course:
    """One line as its parts, in their order; closed: from the last point back to the first."""

    parts: tuple[Points | Arc | Spline, ...]
    closed: bool = False

    def moved(self, matrix: Array) -> "Course":
        return Course(tuple(part.moved(matrix) for part in self.parts), self.closed)

    def points(self, tolerance: float | None = None) -> Array:
        """(n, 3), on the curve, chords within the tolerance; None: roughly. Points that are one stand once."""
        if not self.closed and len(self.parts) == 1 and len(rows := self.parts[0].flat(tolerance)) == 2:
            return rows
        with np.errstate(all="ignore"):
            rows = np.concatenate([part.flat(tolerance) for part in self.parts])
            near = SAME * float(np.ptp(rows, axis=0).max())
            # Not "> near": what is not finite stays, for who asks to refuse.
            kept: Array = rows[~np.append(False, np.abs(np.diff(rows, axis=0)).max(axis=1) <= near)]
            closes = self.closed and len(kept) > 1 and np.abs(kept[-1] - kept[0]).max() <= near
        return kept[:-1] if closes else kept


def _off(at: Callable[[Array], Array], t: Array) -> Array:
    """How far the curve is from the chord of each piece: at a quarter, half and three quarters of it."""
    ends = at(t)
    start, chord = ends[:-1], np.diff(ends, axis=0)
    length = np.maximum((chord**2).sum(axis=1), 1e-300)
    worst = np.zeros(len(chord))
    for share in (0.25, 0.5, 0.75):
        away = at(t[:-1] + share * np.diff(t)) - start
        foot = np.clip((away * chord).sum(axis=1) / length, 0.0, 1.0)
        worst = np.maximum(worst, np.linalg.norm(away - foot[:, None] * chord, axis=1))
    return worst
