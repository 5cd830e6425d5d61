"""Inertia as engines ask for it: the mass matrix as drawn, what it says of time steps, moments that are not too thin.

In: pieces of an engine model, stiffness and damping as matrices. Out: numbers and arrays. Never: looks at names.
"""

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from scipy.spatial.transform import Rotation

from lamc.mechanism.tree import WORLD
from lamc.records.mechanism import Array

if TYPE_CHECKING:
    from lamc.export.engine_model import Piece

THINNEST = (
    1e-12  # of the largest moment: engines refuse A + B < C, and a sheet without thickness has A + B = C
)
SLENDEREST = 1e-9  # of the largest moment: a rod without thickness has none about its own axis
STEPS_PER_RADIAN = 20  # of the fastest vibration: RK4's error per period is then some 1e-6
LONGEST_STEP = 1e-3  # s


def robust_inertia(inertia: Array) -> Array:
    """`inertia` (3, 3), kg·m², symmetric, made thicker by what round-off leaves open: A + B > C, and no moment zero."""
    symmetric = np.asarray(0.5 * (inertia + inertia.T))
    low, middle, high = (float(moment) for moment in np.linalg.eigvalsh(symmetric))
    thicker = max(THINNEST * high - (low + middle - high), SLENDEREST * high - low, 0.0)
    return symmetric + thicker * np.eye(3) if thicker else symmetric


def principal_inertia(inertia: Array) -> tuple[Array, Array]:
    """Principal moments (3,), kg·m², and the quaternion (w, x, y, z) that turns to their axes; no turn for a matrix
    that is diagonal."""
    if not np.any(inertia - np.diag(np.diag(inertia))):
        return np.diag(inertia), np.array([1.0, 0.0, 0.0, 0.0])
    moments, axes = np.linalg.eigh(inertia)
    axes[:, 2] *= np.sign(np.linalg.det(axes))
    x, y, z, w = Rotation.from_matrix(axes).as_quat()
    return moments, np.array([w, x, y, z])


def freedoms(pieces: "Sequence[Piece]") -> list[list[int]]:
    """Rates of each piece by their place: one of a hinge; six of a floating base, the velocity of its origin and its
    angular velocity, world axes."""
    places: list[list[int]] = []
    for piece in pieces:
        first = places[-1][-1] + 1 if places else 0
        places.append(list(range(first, first + (1 if piece.joint is not None else 6))))
    return places


def drawn_jacobian(pieces: "Sequence[Piece]", index: int, point: Array) -> tuple[Array, Array]:
    """Velocity of a drawn point, m, world, of a piece and its angular velocity by the rates, both (3, nv), as drawn."""
    places = freedoms(pieces)
    linear, angular = np.zeros((2, 3, places[-1][-1] + 1))
    while index != WORLD:
        piece, where = pieces[index], places[index]
        arm = point - piece.origin
        if piece.joint is not None:
            angular[:, where[0]] = piece.joint.axis
            linear[:, where[0]] = np.cross(piece.joint.axis, arm)
        else:
            linear[:, where[:3]] = angular[:, where[3:]] = np.eye(3)
            linear[:, where[3:]] = np.cross(np.eye(3), arm).T
        index = piece.parent
    return linear, angular


def drawn_mass_matrix(pieces: "Sequence[Piece]") -> Array:
    """Mass matrix (nv, nv) in the drawn configuration."""
    count = freedoms(pieces)[-1][-1] + 1
    total = np.zeros((count, count))
    for index, piece in enumerate(pieces):
        linear, angular = drawn_jacobian(pieces, index, piece.origin + piece.com)
        total += piece.mass * linear.T @ linear + angular.T @ piece.inertia @ angular
    return total


def time_step(mass_matrix: Array, stiffness: Array, damping: Array, gravity: float, size: float) -> float:
    """A step, s, for RK4: 1, 2 or 5 times a power of ten, short against what vibrates and decays as drawn.

    stiffness, damping  (nv, nv), N·m/rad and N·m·s/rad; gravity  m/s²; size  m
    """
    squares, decays = (
        float(np.abs(np.linalg.eigvals(np.linalg.solve(mass_matrix, matrix))).max())
        for matrix in (stiffness, damping)
    )
    fastest = max(math.sqrt(squares), decays, math.sqrt(gravity / size), 1.0)
    wanted = min(LONGEST_STEP, 1.0 / (STEPS_PER_RADIAN * fastest))
    decade = math.floor(math.log10(wanted))
    steps = [float(f"{digit}e{decade + up}") for up in (-1, 0) for digit in (1, 2, 5)]
    return max(step for step in steps if step <= wanted * (1.0 + 1e-9))
