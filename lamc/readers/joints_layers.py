"""The layers that the plates of a mechanism lie in, as far as plates and masses tell.

In: a mechanism whose bodies have outlines and no drawing behind them. Out: layers for `write_joints`, with the
thicknesses of the plates and the densities that give every body its mass, centre and inertia. It never guesses a
modulus: materials are named after their layer and have none.
"""

from itertools import pairwise

import numpy as np
from scipy.optimize import nnls
from shapely.geometry import MultiPolygon

from lamc.basics.errors import DesignError
from lamc.design.mass import body_properties
from lamc.records.design import Layer, Material
from lamc.records.mechanism import Array, Body, Mechanism

# Relative: heights and masses from one drawing agree to round-off; what was changed by hand does not.
_SAME = 1e-9


def layers_of(mechanism: Mechanism) -> tuple[Layer, ...]:
    """Layers bottom to top, z = 0 at the bottom.

    Raises DesignError where a body has no outline, where the plates do not lie in sheets one upon another, and where
    no densities give the bodies their masses.
    """
    for body in mechanism.bodies:
        if not body.outline:
            raise DesignError(
                f"body {body.name!r} has no outline; a joint definition describes bodies by polygons"
            )
    heights = _heights(mechanism)
    spans = list(pairwise(heights))
    densities = _densities(mechanism, spans)
    return tuple(
        Layer(name, Material(name, density), top - bottom, MultiPolygon())
        for k, ((bottom, top), density) in enumerate(zip(spans, densities, strict=True))
        for name in [f"layer_{k + 1}"]
    )


def _heights(mechanism: Mechanism) -> list[float]:
    """Heights at which sheets meet, m, ascending from zero; nearly equal ones are one."""
    found = sorted({z for b in mechanism.bodies for p in b.outline for z in (p.z_bottom, p.z_top)})
    near = _SAME * max(abs(found[0]), abs(found[-1]))
    heights = [z for k, z in enumerate(found) if k == 0 or z - found[k - 1] > near]
    if abs(heights[0]) > near:
        raise DesignError(
            f"the lowest plate lies at z = {heights[0]:g} m; a joint definition has its lowest layer at zero"
        )
    return [0.0, *heights[1:]]


def _densities(mechanism: Mechanism, spans: list[tuple[float, float]]) -> list[float]:
    """kg/m³ of each layer: the moments of a body are sums over its layers, and linear in their densities."""
    blocks, values = [], []
    for body in mechanism.bodies:
        size = max(1e-300, float(np.abs([p.polygon.bounds for p in body.outline]).max()), spans[-1][1])
        columns = [_unit_moments(body, middle, size) for middle in (sum(span) / 2 for span in spans)]
        scale = sum(float(column[0]) for column in columns)
        blocks.append(np.column_stack(columns) / scale)
        values.append(_moments(body.mass, body.com, body.inertia, size) / scale)
    matrix, wanted = np.vstack(blocks), np.concatenate(values)
    densities, _ = nnls(matrix, wanted)
    gap = float(np.abs(matrix @ densities - wanted).max())
    if gap > _SAME * float(np.abs(wanted).max()):
        raise DesignError(
            "no densities of the layers give the bodies their masses, centres and inertias; a joint definition "
            "cannot say so: write a mechanism file"
        )
    return [float(value) for value in densities]


def _unit_moments(body: Body, middle: float, size: float) -> Array:
    """Moments of the body's plates around the height `middle`, at a density of one."""
    plates = [(p, 1.0) for p in body.outline if p.z_bottom < middle < p.z_top]
    return _moments(*body_properties(plates), size) if plates else np.zeros(10)


def _moments(mass: float, com: Array, inertia: Array, size: float) -> Array:
    """Mass, first and second moments about the origin over powers of `size`, shape (10,), kg."""
    arm = com / size
    turning = inertia / size**2 + mass * (float(arm @ arm) * np.eye(3) - np.outer(arm, arm))
    return np.concatenate([[mass], mass * arm, turning[np.triu_indices(3)]])
