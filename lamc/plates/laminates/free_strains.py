"""What the plies of a laminate would strain by themselves: temperature, moisture and electric fields.

In: plies, and what acts in them. Out: strains in material axes, as they change through the thickness. Never: sums.
"""

from collections.abc import Sequence
from typing import TypeAlias

import numpy as np

from lamc.basics.checks import Array, checked_array
from lamc.plates.laminates.graded import Amount, Graded, gradient_of, level_of, number_of
from lamc.plates.laminates.plies import Ply

Fields: TypeAlias = float | Sequence[float] | Array  # V/m, in all plies or one per ply


def free_strains(
    plies: Sequence[Ply], temperature: float | Graded, moisture: float | Graded, fields: Fields
) -> tuple[Array, Array]:
    """Of each ply what its strain would be at the reference surface, and its slope, 1/m, each of shape (plies, 3).

    Raises DesignError where these are not finite numbers, or not as many fields as plies.
    """
    rise = number_of(temperature, "the rise in temperature of a laminate")
    content = number_of(moisture, "the moisture of a laminate")
    count = len(plies)
    what = f"the electric field in the {count} plies of a laminate"
    each = checked_array(np.full(count, fields) if np.ndim(fields) == 0 else fields, (count,), what)
    level = float(level_of(rise)), float(level_of(content))
    slope = float(gradient_of(rise)), float(gradient_of(content))
    return (
        np.array([ply.material.free_strain(*level, own) for ply, own in zip(plies, each, strict=True)]),
        np.array([ply.material.free_strain(*slope) for ply in plies]),
    )


def free_strains_at(
    plies: Sequence[Ply], temperature: Amount, moisture: Amount, fields: Fields
) -> tuple[Array, Array]:
    """The same at many places, each of shape (..., plies, 3)."""
    units = np.array([[ply.material.free_strain(*unit) for unit in np.eye(3)] for ply in plies])
    found = []
    for part, acting in ((level_of, np.asarray(fields)), (gradient_of, np.zeros(len(plies)))):
        rise, content = np.asarray(part(temperature)), np.asarray(part(moisture))
        causes = np.broadcast_arrays(rise[..., None], content[..., None], acting)
        found.append(np.asarray(np.einsum("...pc,pci->...pi", np.stack(causes, axis=-1), units)))
    return found[0], found[1]
