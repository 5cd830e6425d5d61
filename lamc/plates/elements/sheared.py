"""Elements with shear through the thickness: what of an edge's bow is bending, and what is shear.

In: a staged cell whose element says `shear`. Out: its strains of bending and of shear. Never: shape functions.

Along an edge of length L from corner i to j the slopes turn linearly and by a parabola, and the deflection departs from
them: the bow α = w_j - w_i - (edge)·(slopes at i + slopes at j)/2 is what shear and parabola have to make up between
them. A beam whose moment is linear there shares it as its softness is,

    parabola  6 L_i L_j α / (1 + φ) per length,     γ L = α φ / (1 + φ),     φ = 12 D_s / (H_s L²),

with D_s and H_s the section's stiffness against bending and shear along the edge. Thin cells have φ = 0 and are DKT's;
no shear is left to lock them. In thick ones the slopes are linear. Inside, γ is linear with these values along the
edges as its components there. φ decides how fast a mesh converges, not to what: it vanishes beside 1 or 1 beside it
as cells grow or shrink. Source: I. Katili, A new discrete Kirchhoff-Mindlin element based on Mindlin-Reissner plate
theory and assumed shear strain fields, part I, Int. J. Numer. Meth. Engng 36, 1993.
"""

from fractions import Fraction
from typing import TYPE_CHECKING

from lamc.plates.elements.cell_map import ONE
from lamc.plates.elements.polynomials import Polynomial
from lamc.plates.elements.strains import Chain, Part, Strain, bending
from lamc.symbolic.scalars import Scalar, reciprocal

if TYPE_CHECKING:
    from lamc.plates.elements.cell import Cell

_EDGES = ((0, 1), (1, 2), (2, 0))
_XI: Polynomial = {(1, 0): Fraction(1)}
_ETA: Polynomial = {(0, 1): Fraction(1)}
_MINUS_ETA: Polynomial = {(0, 1): Fraction(-1)}
# (γ_ξ, γ_η) of γ · edge = 1 along one edge and 0 along the others
_FIELDS: tuple[tuple[Polynomial, Polynomial], ...] = (
    ({**ONE, **_MINUS_ETA}, _XI),
    (_MINUS_ETA, _XI),
    (_MINUS_ETA, {(0, 0): Fraction(-1), **_XI}),
)


def sheared(cell: "Cell") -> tuple[Strain, Strain]:
    """Of bending and of shear, (γ_x, γ_y); both by what `edge_shares` leaves them of the bows."""
    bent = bending(cell.element, cell.geometry, cell.frame)
    inner, outer = bent.part.chain.links
    first = len(outer) - len(_EDGES)
    shares = edge_shares(cell)
    scaled = [{j: (w * shares[j - first][0] if j >= first else w) for j, w in row.items()} for row in inner]
    widths = bent.part.chain.widths
    kept = Strain(Part(bent.part.basis, Chain((scaled, outer), widths)), bent.rows, bent.power)
    slid = [{first + k: share} for k, (_, share) in enumerate(shares)]
    frame = cell.frame
    return kept, Strain(Part(_FIELDS, Chain((slid, outer), widths)), (frame.by_x, frame.by_y), 1)


def edge_shares(cell: "Cell") -> list[tuple[Scalar, Scalar]]:
    """1 / (1 + φ) and φ / (1 + φ) of each edge."""
    (D11, D12, D16, D22, D26, D66), (H11, H12, H22) = cell.neutral, cell.shear
    found = []
    for i, j in _EDGES:
        x, y = (b - a for a, b in zip(cell.corners[i], cell.corners[j], strict=True))
        xx, yy, xy = x * x, y * y, x * y
        square = xx + yy
        straight = D11 * xx * xx + D22 * yy * yy + 2 * (D12 + 2 * D66) * xx * yy
        bend = 12 * (straight + 4 * xy * (D16 * xx + D26 * yy))  # 12 D_s L⁴
        slide = (H11 * xx + H22 * yy + 2 * H12 * xy) * square * square  # H_s L⁶
        share = reciprocal(slide + bend)
        found.append((slide * share, bend * share))
    return found
