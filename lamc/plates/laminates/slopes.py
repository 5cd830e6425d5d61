"""A laminate's section and how it changes with each of its plies.

In: a laminate, and the climate that it is in. Out: its terms (A, B, D, expansion, mass; see `ply_terms.TERMS`) and
their derivatives by the angle, thickness and material of every ply. Never: meshes.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from lamc.basics.checks import Array
from lamc.plates.laminates.climate import Climate
from lamc.plates.laminates.graded import level_of
from lamc.plates.laminates.laminate import Laminate
from lamc.plates.laminates.ply_kernel import PlyKernel, ply_kernel
from lamc.plates.laminates.ply_terms import PLY_NUMBERS

# What a gradient can be asked for, with the unit that it is per.
VARIABLES: Mapping[str, str] = {
    "angle": "deg",
    "thickness": "m",
    "E1": "Pa",
    "E2": "Pa",
    "nu12": "1",
    "G12": "Pa",
    "density": "kg/m³",
    "alpha1": "1/K",
    "alpha2": "1/K",
    "beta1": "1",
    "beta2": "1",
    "d31": "m/V",
    "d32": "m/V",
}


@dataclass(frozen=True, eq=False)
class LaminateTerms:
    """`values` (25,) in the order of `ply_terms.TERMS`; `slopes[variable]` (plies, 25) of all by one ply's variable."""

    values: Array
    slopes: Mapping[str, Array]


def laminate_terms(laminate: Laminate, climate: Climate, kernel: PlyKernel | None = None) -> LaminateTerms:
    """The terms of `laminate` and their derivatives; `kernel` gives those of its plies, None: the compiled one.

    A ply that grows thicker also moves plies: those above it by what is left of its growth below the reference surface,
    those below it likewise. Gaps and the reference (a named surface, or its height above the middle) stay.
    """
    values, slopes = (kernel or ply_kernel())(_numbers(laminate, climate))
    by = {name: slopes[:, :, PLY_NUMBERS.index(name)] for name in VARIABLES if name in PLY_NUMBERS}
    by["thickness"] = by["thickness"] + _height_slopes(laminate).T @ slopes[:, :, PLY_NUMBERS.index("height")]
    causes: dict[str, float | Array] = {
        "alpha": level_of(climate.temperature),  # `gradient` refuses what changes through the thickness
        "beta": level_of(climate.moisture),
        "d3": climate.fields[:, None],
    }
    for axis in ("1", "2"):
        for symbol, cause in causes.items():
            by[symbol + axis] = cause * slopes[:, :, PLY_NUMBERS.index(f"free{axis}")]
    return LaminateTerms(values.sum(axis=0), by)


def _numbers(laminate: Laminate, climate: Climate) -> Array:
    """Of every ply the values of `PLY_NUMBERS`, (plies, 10)."""
    rows = []
    warmth, wetness = float(level_of(climate.temperature)), float(level_of(climate.moisture))
    for ply, middle, field in zip(laminate.plies, laminate.heights.mean(axis=1), climate.fields, strict=True):
        free = ply.material.free_strain(warmth, wetness, field)
        own = {
            "angle": ply.angle,
            "thickness": ply.thickness,
            "height": middle,
            "free1": free[0],
            "free2": free[1],
        }
        rows.append([own[name] if name in own else getattr(ply.material, name) for name in PLY_NUMBERS])
    return np.array(rows, dtype=float)


def _height_slopes(laminate: Laminate) -> Array:
    """Derivative of the height of ply i's middle by the thickness of ply j, (plies, plies).

    z_i = Σ_{j<i} t_j + t_i/2 - (1/2 + k) Σ t and gaps, where the reference surface is k thicknesses above the middle.
    """
    count = len(laminate.plies)
    k = laminate.reference_height / laminate.thickness if isinstance(laminate.reference, str) else 0.0
    return np.tri(count, k=-1) + 0.5 * np.eye(count) - (0.5 + k)
