"""Finite elements, derived by sympy from their shape functions.

In: shape functions in ξ and η, from the library or a user's own. Out: staged equations, which `lamc/codegen` turns
into C. Never: meshes, materials, numbers of a plate.

    definition.py   the records; symbols ξ, η, L1, L2, L3, x1, y1, x21, …
    triangles.py, squares.py, library.py   the elements that there are
    checks.py       whether shape functions fit their nodes
    cells.py        whether cells of a mesh fit the element
    factor.py, strains.py, affine.py, frame.py   what makes the equations short: see `factor.py`
    derive.py       all functions of an element
    description.py  an element in words and formulas

A user's own element, here a square membrane of four nodes:

    from lamc import plate
    from lamc.plates.elements import eta, xi

    N = [(1 + a * xi) * (1 + b * eta) / 4 for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    mine = plate.Element("mine", "square", plate.corners("square", ("u", "v")), u=N, v=N)
    print(plate.describe(mine))
"""

from lamc.plates.elements.cells import check_cells
from lamc.plates.elements.definition import (
    L1,
    L2,
    L3,
    Element,
    Node,
    corners,
    edges,
    eta,
    side,
    x1,
    x2,
    x3,
    x4,
    xi,
    y1,
    y2,
    y3,
    y4,
)
from lamc.plates.elements.derive import ElementEquations, ElementFunction, derive
from lamc.plates.elements.description import describe
from lamc.plates.elements.library import ELEMENTS, combine, element

__all__ = [
    "ELEMENTS",
    "L1",
    "L2",
    "L3",
    "Element",
    "ElementEquations",
    "ElementFunction",
    "Node",
    "check_cells",
    "combine",
    "corners",
    "derive",
    "describe",
    "edges",
    "element",
    "eta",
    "side",
    "x1",
    "x2",
    "x3",
    "x4",
    "xi",
    "y1",
    "y2",
    "y3",
    "y4",
]
