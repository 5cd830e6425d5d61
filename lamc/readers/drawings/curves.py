"""Outlines of straight lines, Bézier curves and arcs, flattened to polylines within a tolerance.

In: control points. Out: points. A polyline's corners lie on the curve; it is off by the sagitta of its chords at most.
"""

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from lamc.records.mechanism import Array


@dataclass(frozen=True)
class Polyline:
    """points: (n, 2)."""

    points: Array

    def moved(self, matrix: Array) -> "Polyline":
        return Polyline(_moved(self.points, matrix))

    def count(self, tolerance: float) -> int:
        return len(self.points)

    def flat(self, count: int) -> Array:
        return self.points

    @property
    def reach(self) -> Array:
        """(n, 2) points about which the curve lies."""
        return self.points


@dataclass(frozen=True)
class Bezier:
    """points: (3, 2) of a quadratic curve, (4, 2) of a cubic one."""

    points: Array

    def moved(self, matrix: Array) -> "Bezier":
        return Bezier(_moved(self.points, matrix))

    def count(self, tolerance: float) -> int:
        """Of n equal steps of the parameter each is off by |B''| / (8 n²) at most."""
        degree = len(self.points) - 1
        bends = np.diff(self.points, 2, axis=0)
        second = degree * (degree - 1) * float(np.max(np.hypot(bends[:, 0], bends[:, 1])))
        return 1 + _steps(second, tolerance)

    def flat(self, count: int) -> Array:
        t = np.linspace(0.0, 1.0, count)[:, None]
        rows = self.points[:, None, :]
        while len(rows) > 1:
            rows = (1.0 - t) * rows[:-1] + t * rows[1:]  # de Casteljau
        return _between(rows[0], self.points[0], self.points[-1])

    @property
    def reach(self) -> Array:
        return self.points


@dataclass(frozen=True)
class Arc:
    """c + u cos t + v sin t, t from `begin` over `sweep`, rad; ends are (2, 2), where it is known to begin and end."""

    centre: Array
    u: Array
    v: Array
    begin: float
    sweep: float
    ends: Array

    def moved(self, matrix: Array) -> "Arc":
        linear = matrix[:2, :2]
        return Arc(
            _moved(self.centre, matrix),
            linear @ self.u,
            linear @ self.v,
            self.begin,
            self.sweep,
            _moved(self.ends, matrix),
        )

    def count(self, tolerance: float) -> int:
        radius = float(np.linalg.norm(np.column_stack([self.u, self.v]), 2))
        quarters = math.ceil(abs(self.sweep) / (0.5 * math.pi) - 1e-9)  # a circle is no line, however small
        return 1 + max(_steps(radius * self.sweep**2, tolerance), quarters)

    def flat(self, count: int) -> Array:
        t = self.begin + self.sweep * np.linspace(0.0, 1.0, count)
        return _between(self.centre + np.outer(np.cos(t), self.u) + np.outer(np.sin(t), self.v), *self.ends)

    @property
    def reach(self) -> Array:
        corners = np.array([[1, 1], [1, -1], [-1, 1], [-1, -1]]) @ np.array([self.u, self.v])
        return self.centre + corners if abs(self.sweep) > 1.6 else self.ends


Curve = Polyline | Bezier | Arc


@dataclass(frozen=True)
class Outline:
    """Curves, each beginning where the one before ends; closed by a straight line from its end to its start."""

    curves: tuple[Curve, ...]
    closed: bool

    def moved(self, matrix: Array) -> "Outline":
        return Outline(tuple(curve.moved(matrix) for curve in self.curves), self.closed)

    def count(self, tolerance: float) -> int:
        """How many points it has when flattened."""
        return sum(curve.count(tolerance) for curve in self.curves)

    def flat(self, tolerance: float) -> tuple[Array, bool]:
        """(n, 2) points, no two equal ones in a row, and whether they close; a closed one does not repeat its first."""
        every = np.concatenate([curve.flat(curve.count(tolerance)) for curve in self.curves])
        kept = np.concatenate([[True], np.any(every[1:] != every[:-1], axis=1)])
        points = every[kept]
        ends_meet = len(points) > 1 and bool(np.all(points[0] == points[-1]))
        if ends_meet:
            points = points[:-1]
        closed = (self.closed or ends_meet) and len(points) > 2
        return points, closed


def size_of(outlines: Iterable[Outline]) -> float:
    """The diagonal of the box about all of them; 0 for none."""
    low, high = np.full(2, math.inf), np.full(2, -math.inf)
    for outline in outlines:
        for curve in outline.curves:
            reach = curve.reach
            low, high = np.minimum(low, reach.min(axis=0)), np.maximum(high, reach.max(axis=0))
    return float(np.linalg.norm(high - low)) if np.all(high >= low) else 0.0


def _moved(points: Array, matrix: Array) -> Array:
    return points @ matrix[:2, :2].T + matrix[:2, 2]


def _steps(second: float, tolerance: float) -> int:
    return max(1, math.ceil(math.sqrt(second / (8.0 * tolerance))))


def _between(points: Array, start: Array, end: Array) -> Array:
    """The points with these ends, which rounding would move a little off the lines that they meet."""
    points[0], points[-1] = start, end
    return points
