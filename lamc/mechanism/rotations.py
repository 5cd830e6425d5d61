"""Rotations as turns about z, x and z, and geometric numbers without round-off.

In: rotation matrices and arrays. Out: cosines, sines and angles that are exact where they vanish, so that zeros of a
drawing are zeros of the equations.
"""

import math

import numpy as np

from lamc.records.mechanism import Array

# Relative size under which a geometric number is round-off of a zero: a few hundred ulps, far below any drawing.
ROUND_OFF = 1e-13


def constant_rotations(
    rotation: Array,
) -> tuple[tuple[float, float], tuple[float, float], float, bool]:
    """(twist, fold, angle, parallel) with rotation = Rz(twist) Rx(fold) Rz(angle)."""
    sine = math.hypot(rotation[0, 2], rotation[1, 2])
    if sine < 10 * ROUND_OFF and rotation[2, 2] > 0:
        return (1.0, 0.0), (1.0, 0.0), _snap_angle(math.atan2(rotation[1, 0], rotation[0, 0])), True
    if sine < 10 * ROUND_OFF:
        return (1.0, 0.0), (-1.0, 0.0), _snap_angle(math.atan2(-rotation[1, 0], rotation[0, 0])), False
    # z of the child in the parent's frame is (sin β sin α, -cos β sin α, cos α); the sign of α keeps |β| ≤ 90°.
    side = 1.0 if rotation[1, 2] <= 0 else -1.0
    twist = _snap_angle(math.atan2(side * rotation[0, 2], -side * rotation[1, 2]))
    angle = _snap_angle(math.atan2(side * rotation[2, 0], side * rotation[2, 1]))
    return _pair(twist), _pair(math.atan2(side * sine, rotation[2, 2])), angle, False


def _snap_angle(angle: float) -> float:
    return 0.0 if abs(angle) < 10 * ROUND_OFF else angle


def _pair(angle: float) -> tuple[float, float]:
    """(cos, sin), exact where one of them vanishes."""
    c, s = math.cos(angle), math.sin(angle)
    if abs(s) < 10 * ROUND_OFF:
        return math.copysign(1.0, c), 0.0
    if abs(c) < 10 * ROUND_OFF:
        return 0.0, math.copysign(1.0, s)
    return c, s


def snap(values: Array, size: float) -> Array:
    """`values` with what is round-off relative to `size` set to zero."""
    return np.where(np.abs(values) <= ROUND_OFF * size, 0.0, values)
