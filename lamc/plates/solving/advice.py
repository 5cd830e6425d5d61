"""What may make an answer worse than its reader expects, said beforehand.

In: a problem, its loads, how exactly it was solved. Out: sentences. Never: raises for it.
"""

from collections.abc import Sequence

import numpy as np

from lamc.basics.checks import Array
from lamc.plates.laminates.laminate import Laminate
from lamc.plates.loads import LoadRecord
from lamc.plates.meshing.mesh import Mesh
from lamc.plates.meshing.report import BCIZ_ON_SLIVERS, share_on_slivers
from lamc.plates.offsets import offset_texts
from lamc.plates.problem import Problem
from lamc.plates.solving.curves import curve_nodes, round_polygons
from lamc.plates.solving.refine import Accuracy
from lamc.plates.supports import Hinged, SimplySupported, Support, Where

_SAME = 1e-6  # of the size of a cell: sides that differ by less are equal
_SLIVER = 40.0  # longest side over height
_FEW_DIGITS = 1e-9
_LINEAR = ("cst", "q4")  # membranes
_REPORTED = 0.01  # of the deflection


def notes(problem: Problem, loads: Sequence[LoadRecord], accuracy: Accuracy) -> tuple[str, ...]:
    """Warnings for `problem` under `loads`."""
    bending = problem.dofs.element.name.partition("+")[0]
    found = []
    if bending == "bciz" and not three_directions(problem.mesh):
        found.append(_bciz_text(problem.mesh))
    found.extend(_sliver_texts(problem.mesh, bending))
    found.extend(_membrane_texts(problem))
    if problem.dofs.element.bends and _held_beside_curves(problem):
        found.append(
            "a Support holds w along a curve that is drawn as a polygon, and the mesh has nodes between the "
            "polygon's corners: held straight there, such a plate is stiffer than the curved one, by up to a "
            "fourth; take SimplySupported, which holds w on the curve"
        )
    found.extend(polygon_texts(problem))
    found.extend(offset_texts(problem))
    if accuracy.forward_error > _FEW_DIGITS:
        found.append(
            f"the unknowns may be wrong by {accuracy.forward_error:.1e} of their size: the condition of the stiffness "
            f"matrix is {accuracy.condition:.1e}"
        )
    return tuple(found)


def three_directions(mesh: Mesh) -> bool:
    """Whether all triangles are one triangle, moved or turned by 180°: then the mesh's lines have three directions and
    equal distances, and BCIZ passes the patch test (B. M. Irons and A. Razzaque, 1972)."""
    if mesh.corner_count != 3:
        return False
    sides = np.roll(mesh.corners, -1, axis=1) - mesh.corners
    sides *= np.where((sides[..., :1] < 0.0) | ((sides[..., :1] == 0.0) & (sides[..., 1:] < 0.0)), -1.0, 1.0)
    size = float(np.sqrt(np.abs(mesh.areas).max()))
    first = sides[0]
    near = (
        np.abs(sides[:, :, None] - first[None, None]).max(axis=3) < _SAME * size
    )  # (m, 3 sides, 3 of the first)
    mirrored = np.abs(sides[:, :, None] + first[None, None]).max(axis=3) < _SAME * size
    return bool((near | mirrored).any(axis=1).all())


def _bciz_text(mesh: Mesh) -> str:
    bias = {
        "criss-cross": "about 3.2 % too flexible on this criss-cross mesh",
        "union-jack": "about 3.2 % too flexible on this union-jack mesh",
    }.get(
        mesh.pattern,
        "some 0.9 to 1.3 % too flexible where triangles are round, 1.6 to 2.4 % where they are not, up to 20 % where "
        "strips are narrow",
    )
    return (
        f"element 'bciz' converges to a wrong answer, {bias}: it is right only where the mesh's lines have three "
        "directions and equal distances; take 'dkt', or plate.grid(…, pattern='one-diagonal')"
    )


def _sliver_texts(mesh: Mesh, bending: str) -> list[str]:
    aspects = slenderness(mesh)
    worst = float(aspects.max())
    if worst <= _SLIVER:
        return []
    cells = f"element '{bending}' on cells up to {worst:.3g} times as long as high"
    if bending == "specht":
        return [f"{cells}: on slivers it is far too stiff; 'dkt' stays within 5 % at 1000"]
    if bending == "bciz":
        part = share_on_slivers(worst, BCIZ_ON_SLIVERS)
        return [
            f"{cells}: on slivers it is too stiff; with all cells like that, four along each side of a plate, it gives "
            f"{part:.2g} of the deflection; 'dkt' stays within 5 %"
        ]
    thin = float(np.sum(mesh.areas[aspects > _SLIVER]))
    if bending == "dkt" and thin > 0.5 * float(mesh.areas.sum()):
        return [
            f"{cells}: it bears them, but is no more exact than on squares with the long side, 4 % off with four along "
            "each side of a plate: more cells that way help, more of them across do not"
        ]
    return []


def _membrane_texts(problem: Problem) -> list[str]:
    """Linear displacements cannot follow strains that change as curvatures do, and hold back the bending that comes
    with them: the stiffness is too large by about 0.1 s (π h / L)², s = mean of the eigenvalues of (D - S)⁻¹ S with
    S = B A⁻¹ B, h the length of edges, L the shorter side of the plate. Measured on squares of 4 to 16 cells a side,
    simply supported, cantilevers (a fifth of it) and clamped ones (two and a half times of it)."""
    chosen, mesh = problem.dofs.element, problem.mesh
    membrane = chosen.name.partition("+")[2]
    if membrane not in _LINEAR:
        return []
    span = float(np.ptp(mesh.points, axis=0).min())
    sides = np.linalg.norm(np.roll(mesh.corners, -1, axis=1) - mesh.corners, axis=2).max(axis=1)
    steps = sides / (np.sqrt(2.0) if mesh.corner_count == 3 else 1.0)
    strength = np.array([_coupling(laminate) for laminate in problem.laminates])[mesh.regions]
    excess = 0.1 * np.average(strength * (np.pi * steps / span) ** 2, weights=mesh.areas)
    lost = float(excess / (1.0 + excess))
    if lost < _REPORTED:
        return []
    out = "take 'dkt+lst', " if mesh.corner_count == 3 else "take triangles and 'dkt+lst', "
    return [
        f"bending and stretching are coupled, and the linear membrane of element {chosen.name!r} makes this mesh too "
        f"stiff, by some {100.0 * lost:.2g} % of the deflection, more at clamped edges: {out}a smaller size, or the "
        "middle of the laminate as its reference"
    ]


def _coupling(laminate: Laminate) -> float:
    """Mean of the eigenvalues of (D - S)⁻¹ S with S = B A⁻¹ B; for a reference off the middle, the square of its
    height over that of the radius of gyration."""
    with_stretch = laminate.B @ np.linalg.solve(laminate.A, laminate.B)
    return float(np.trace(np.linalg.solve(laminate.D - with_stretch, with_stretch))) / 3.0


def _held_by_w(problem: Problem) -> list[Where]:
    """Where a Support holds w, and not both slopes."""
    return [
        support.where
        for support in problem.supports
        if isinstance(support, Support) and "w" in support.dofs and not {"w_x", "w_y"} <= set(support.dofs)
    ]


def _held_beside_curves(problem: Problem) -> bool:
    """Whether w alone is held by a Support at nodes beside a curve."""
    wheres = _held_by_w(problem)
    return bool(wheres) and bool(curve_nodes(problem.places, wheres).height.any())


def polygon_texts(problem: Problem) -> list[str]:
    """Of edges that turn freely, of too few corners to count as circles, should they be meant as such."""
    if not problem.dofs.element.bends:
        return []
    turning = [s.where for s in problem.supports if isinstance(s, SimplySupported | Hinged)]
    found = round_polygons(problem.places, [*turning, *_held_by_w(problem)])
    return [
        f"a supported edge is a regular polygon of {corners} corners, and is held as one: if a circle is meant, draw "
        "it with 24 corners or more; held along straight sides such a plate is stiffer than a round one, by up to a "
        "fourth"
        for corners in dict.fromkeys(found)
    ]


def slenderness(mesh: Mesh) -> Array:
    """Longest side over the height above it, of the cells, shape (m,); of quadrilaterals, squared over the area."""
    sides = np.linalg.norm(np.roll(mesh.corners, -1, axis=1) - mesh.corners, axis=2).max(axis=1)
    half = 2.0 if mesh.corner_count == 3 else 1.0
    return np.asarray(sides**2 / (half * mesh.areas))
