"""The stiffness of a hinge from its geometry and material: moment per angle of a strip that joins two rigid links.

In: the laminate of the strip, its width L from link to link and its length b along the axis. Out: N·m/rad by two
formulas and by finite elements. Never: geometry of designs.

The links turn by the angle φ against each other about the strip's long direction, y, and do nothing else; the strip
bends in x with κ_x = φ/L, and no force pulls at it (N_x = 0). Between the clamped edges it would curl across, as a bent
rubber does:

    plate   the links keep it from curling: κ_y = κ_xy = 0 and ε_y = γ_xy = 0, which is right for b >> L
                k = (D11 - B11²/A11) b / L
    beam    it curls as it likes: M_y = M_xy = 0 and N_y = N_xy = 0, which is right for b << L
                k = b / (d11 L),  d11 from the inverse of [[A, B], [B, D]]

An isotropic layer of thickness t has E t³ b / (12 L) as a beam and 1/(1 - ν²) times that as a plate. Finite elements
lie between: for ν = 0.3, 0.35 L/b of the way from plate to beam where b > 2 L, and half-way at b = 0.7 L. Source:
S. P. Timoshenko and S. Woinowsky-Krieger, Theory of Plates and Shells, 2nd ed. 1959, chapters 1 and 2.

The elements see the strip with both ends at w = 0 and turned by ±φ/2: half a turn about its middle changes nothing, so
no force across is needed, as there is none in a hinge that bends alone.
"""

from dataclasses import dataclass

import numpy as np
from shapely.geometry import LineString

from lamc.basics.checks import checked_kind, checked_number, shown
from lamc.basics.errors import DesignError
from lamc.plates.answers.model import FactoredPlate
from lamc.plates.laminates.laminate import Laminate
from lamc.plates.laminates.sections import couples
from lamc.plates.meshing.grid import grid_of_lines
from lamc.plates.meshing.mesh import Mesh
from lamc.plates.problem import Problem
from lamc.plates.supports import Support

CELLS = 16  # across the strip; the elements then err by some 0.2 % of the difference between plate and beam
_MOST_CELLS = 200
_EDGE = 3.0  # widths of strip at each end that are meshed finely: beyond, it bends as a cylinder


@dataclass(frozen=True)
class FilmStiffness:
    """N·m/rad, by each way."""

    plate_formula: float
    beam_formula: float
    finite_element: float | None  # None where it was not asked for
    width: float  # m, L
    length: float  # m, b

    @property
    def value(self) -> float:
        """By the formula that is nearer: the plate's from b = L on, the beam's for narrower strips.

        A formula, for it has the same digits on every machine; elements depend on the solver in the last ones.
        """
        return self.plate_formula if self.length >= self.width else self.beam_formula

    @property
    def formula(self) -> str:
        """ "plate" or "beam": where `value` comes from."""
        return "plate" if self.length >= self.width else "beam"


def hinge_stiffness(laminate: Laminate, width: float, length: float, *, cells: int = CELLS) -> FilmStiffness:
    """Of a strip `width` m from link to link (laminate axis x) and `length` m along the hinge's axis (y).

    cells  across the strip, for the finite elements; 0: formulas only

    Raises DesignError where these are not positive, and BuildError without a C compiler where there are cells.
    """
    checked_kind(laminate, Laminate, "the laminate of a hinge", "make one of plies, or by Laminate.layer")
    L, b = _checked(width, "width"), _checked(length, "length")
    if not isinstance(cells, int) or not 0 <= cells <= _MOST_CELLS:
        raise DesignError(
            f"the cells across a hinge are {shown(cells)}; give a whole number from 0 to {_MOST_CELLS}"
        )
    A, B, D = laminate.A, laminate.B, laminate.D
    # In units of the thickness, as for a deformation: the inverse does not depend on the unit of length.
    h = laminate.thickness
    compliance = np.linalg.inv(np.block([[A, B / h], [B / h, D / h**2]]))[3, 3] / h**2
    return FilmStiffness(
        plate_formula=float((D[0, 0] - B[0, 0] ** 2 / A[0, 0]) * b / L),
        beam_formula=float(b / (L * compliance)),
        finite_element=_by_elements(laminate, _strip(L, b, cells)) if cells else None,
        width=L,
        length=b,
    )


def _checked(value: float, what: str) -> float:
    number = checked_number(value, f"the {what} of a hinge")
    if number <= 0.0:
        raise DesignError(f"the {what} of a hinge is {number:g} m; it must be positive")
    return number


def _strip(L: float, b: float, cells: int) -> Mesh:
    """Square cells near the free ends, long ones between them."""
    near = min(_EDGE * L, 0.5 * b)
    low = np.linspace(0.0, near, max(2, round(cells * near / L)) + 1)
    between = np.linspace(near, b - near, 5) if near < 0.5 * b else np.array([near])
    lines = np.concatenate([low[:-1], between, (b - low[::-1])[1:]])
    return grid_of_lines(np.linspace(0.0, L, cells + 1), lines)


def _by_elements(laminate: Laminate, mesh: Mesh) -> float:
    """Twice the energy per squared angle, with no force along x."""
    # About the surface where bending in x makes no force: what couples then is small, and nothing for one material.
    neutral = laminate.reference_height + laminate.B[0, 0] / laminate.A[0, 0]
    laminate = Laminate(laminate.plies, neutral)
    if not couples(laminate):
        return 2.0 * _energy(laminate, mesh, 1.0)
    pull = laminate.thickness  # a length of a size that keeps all three energies alike
    bent, pulled, both = (2.0 * _energy(laminate, mesh, *m) for m in ((1.0, 0.0), (0.0, pull), (1.0, pull)))
    mixed = 0.5 * (both - bent - pulled)
    return bent - mixed * mixed / pulled


def _energy(laminate: Laminate, mesh: Mesh, angle: float, pull: float | None = None) -> float:
    """Of the strip whose ends turn by `angle` and part by `pull` m; None: they are free in the plane."""
    low, high = mesh.points.min(axis=0), mesh.points.max(axis=0)
    supports = []
    for sign, x in ((1.0, low[0]), (-1.0, high[0])):
        end = LineString([(x, low[1]), (x, high[1])])
        supports += [Support(end, ("w", "w_y")), Support(end, ("w_x",), 0.5 * sign * angle)]
        if pull is not None:
            supports += [Support(end, ("v",)), Support(end, ("u",), -0.5 * sign * pull)]
    element = "dkt" if pull is None else "dkt+lst"
    return FactoredPlate(Problem(mesh, laminate, element=element, supports=supports)).solve().strain_energy
