"""Whether what lies beyond a mirror is the same laminate.

In: the edges of a symmetry, the laminates beside them. Out: nothing, or a refusal. Never: unknowns, equations.

A mirror turns the sign of the shear strain and of the twist in its own axes, and so of the terms 16 and 26 of A, B and
D there. Where these are not zero the other half is another laminate, and no mesh is fine enough to make up for it.
"""

import numpy as np

from lamc.basics.checks import Array
from lamc.basics.errors import DesignError
from lamc.plates.laminates.laminate import Laminate
from lamc.plates.laminates.materials import strain_rotation
from lamc.plates.locator import MeshLocator
from lamc.plates.meshing.checks import place
from lamc.plates.supports import Where

_COUPLED = 1e-6  # of the root of the diagonal terms' product, as a coefficient of correlation
_ONE_LINE = 1.0  # degrees between edges of one straight line, whose points are rounded
_TERMS = ((0, 2, "16"), (1, 2, "26"))


def check_mirror(places: MeshLocator, laminates: tuple[Laminate, ...], where: Where) -> None:
    """Raises DesignError where a symmetry at `where` lies along a laminate that couples across it."""
    element, mesh = places.dofs.element, places.dofs.mesh
    parts = (("A", element.stretches), ("B", element.stretches and element.bends), ("D", element.bends))
    cells, sides = places.edges_on(where).T
    ends = mesh.points[mesh.edges[mesh.cell_edges[cells, sides]]]
    angles = _directions(ends[:, 1] - ends[:, 0])
    regions = mesh.regions[cells]
    _, first = np.unique(np.stack([regions, angles]), axis=1, return_index=True)
    for number in sorted(first.tolist()):
        laminate, angle = laminates[regions[number]], float(angles[number])
        for name, counts in parts:
            term, size = coupling(laminate, name, angle)
            if counts and size > _COUPLED:
                raise DesignError(
                    f"the Symmetry support at {place(ends[number].mean(axis=0))} is along {angle:.4g}°, where the "
                    f"laminate of region {mesh.region_names[regions[number]]!r} has a {name}{term} of {size:.2g} of "
                    f"its diagonal terms: its mirror image is another laminate; model the whole plate, or hold single "
                    "unknowns there with a Support if that is meant"
                )


def coupling(laminate: Laminate, name: str, degrees: float) -> tuple[str, float]:
    """The larger of the terms 16 and 26 of A, B or D in axes along `degrees`, and its size over the root of the
    product of the diagonal terms, those of A and D for B: at most 1."""
    rotation = strain_rotation(-degrees)
    A, B, D = (rotation.T @ matrix @ rotation for matrix in (laminate.A, laminate.B, laminate.D))
    rows, columns = {"A": (A, A), "B": (A, D), "D": (D, D)}[name]
    matrix = {"A": A, "B": B, "D": D}[name]
    sizes = {
        text: max(abs(matrix[i, j]) / np.sqrt(rows[k, k] * columns[m, m]) for k, m in ((i, j), (j, i)))
        for i, j, text in _TERMS
    }
    worst = max(sizes, key=lambda text: sizes[text])
    return worst, float(sizes[worst])


def _directions(along: Array) -> Array:
    """Degrees, -90 to 90, shape (k,); edges that differ by less than `_ONE_LINE` have their mean, so that a laminate is
    not judged by the round-off of short edges."""
    angles = np.degrees(np.arctan2(along[:, 1], along[:, 0])) % 180.0
    order = np.argsort(angles, kind="stable")
    group = np.empty(len(order), dtype=np.intp)
    group[order] = np.cumsum(np.diff(angles[order], prepend=angles[order[0]]) > _ONE_LINE)
    if angles.max() - angles.min() > 180.0 - _ONE_LINE:  # the last are the first, from the other side
        group[group == group.max()] = 0
    twice = (along[:, 0] + 1j * along[:, 1]) ** 2  # a direction and its opposite are one
    total = np.zeros(group.max() + 1, dtype=complex)
    np.add.at(total, group, twice)
    return np.asarray(0.5 * np.degrees(np.angle(total)))[group]
