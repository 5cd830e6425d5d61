"""Sheets that lie flat, in the plane of x and y or in another one.

In: a frame, its places. Out: places in x and y. Never: takes a sheet that says how it is folded for flat.
"""

import math

import numpy as np

from lamc.readers.fold_bending import CREASED
from lamc.readers.fold_faces import counterclockwise, overlap, polygons_of
from lamc.readers.fold_file import FoldFrame
from lamc.readers.fold_flat import normals_of
from lamc.records.mechanism import Array

LEVEL = 1e-6  # of the sheet's size: heights by which a flat drawing may differ
SIDED = 1e-2  # rad: less does not tell one side from the other, where coordinates have four digits
_TILTED = 0.1  # rad: a small facet of few digits is by no more out of the plane


def is_level(frame: FoldFrame) -> bool:
    """Whether the frame lies in a plane of constant z."""
    return _height(frame, frame.vertices) <= LEVEL


def levelled(frame: FoldFrame, points: Array, size: float, notes: list[str]) -> Array | None:
    """Places (n, 3) turned to z = 0 of a frame whose faces lie side by side in one plane in space; None for any other.
    What most faces have above is upwards. Where no fold angle is given they may miss the plane by more than round-off,
    as those of few digits do, which is told."""
    assert frame.faces is not None
    normals = normals_of(points, frame.faces, size)
    signs = np.sign(normals @ normals[0])
    normal = (signs[:, None] * normals).mean(axis=0) * (1.0 if signs.sum() >= 0.0 else -1.0)
    if not np.abs(normals @ normal).min() > math.cos(_TILTED):
        return None
    normal /= np.linalg.norm(normal)
    ring = points[list(frame.faces[0])]
    sides = np.roll(ring, -1, axis=0) - ring
    side = sides[int(np.argmax(np.linalg.norm(sides, axis=1)))]
    x = side - (side @ normal) * normal
    x /= np.linalg.norm(x)
    turned = np.asarray((points - ring[0]) @ np.array([x, np.cross(normal, x), normal]).T)
    height = _height(frame, turned)
    folds = any(angle for kind, angle in zip(frame.kinds, frame.angles, strict=True) if kind in CREASED)
    if not height <= (LEVEL if folds else SIDED):
        return None
    side_by_side = [counterclockwise(turned[:, :2], face) for face in frame.faces]
    if overlap(polygons_of(turned[:, :2], side_by_side)) is not None:
        return None  # pieces in two planes, or one that is folded flat
    if height > LEVEL:
        notes.append(
            f"the vertices miss a plane by {height * size:.2g} m, and no crease has a fold angle: the sheet is taken "
            "as flat"
        )
    return turned * [1.0, 1.0, 0.0]


def _height(frame: FoldFrame, points: Array) -> float:
    """How far places (n, 3) of the frame's edges differ in z, of its size."""
    spread = np.ptp(points[np.unique(np.array(frame.edges))], axis=0)
    return float(spread[2]) / (float(np.linalg.norm(spread)) or 1.0)
