"""Sheets that lie flat, in the plane of x and y or in another one.

In: a frame, its places. Out: places in x and y. Never: takes a sheet that says how it is folded for flat.
"""

import math

import numpy as np

from lamc.readers.fold_bending import CREASED
from lamc.readers.fold_file import FoldFrame
from lamc.readers.fold_flat import normals_of
from lamc.records.mechanism import Array

LEVEL = 1e-6  # of the sheet's size: heights by which a flat drawing may differ
SIDED = 1e-2  # rad: less does not tell one side from the other, where coordinates have four digits


def is_level(frame: FoldFrame) -> bool:
    """Whether the frame lies in a plane of constant z."""
    return _height(frame, frame.vertices) <= LEVEL


def levelled(frame: FoldFrame, points: Array, size: float, notes: list[str]) -> Array | None:
    """Places (n, 3) turned to z = 0, what is above upwards, of a frame whose faces lie side by side in one plane in
    space; None for any other. Where no fold angle is given they may miss the plane by more than round-off, as those of
    few digits do, which is told."""
    assert frame.faces is not None
    normals = normals_of(points, frame.faces, size)
    normal = normals.mean(axis=0)
    if not (normals @ normal).min() > math.cos(SIDED):
        return None
    normal /= np.linalg.norm(normal)
    first, second = points[list(frame.faces[0][:2])]
    x = (second - first) - ((second - first) @ normal) * normal
    x /= np.linalg.norm(x)
    turned = np.asarray((points - first) @ np.array([x, np.cross(normal, x), normal]).T)
    height = _height(frame, turned)
    folds = any(angle for kind, angle in zip(frame.kinds, frame.angles, strict=True) if kind in CREASED)
    if height > (LEVEL if folds else SIDED):
        return None
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
