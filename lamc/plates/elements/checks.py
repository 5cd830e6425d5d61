"""Whether shape functions are those of their nodes: checked on one cell, in exact numbers, before anything is derived.

In: an element. Out: nothing, or a DesignError that names the function or the motion. Never: staged values.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from fractions import Fraction
from typing import TypeAlias

import sympy as sp

from lamc.basics.errors import DesignError
from lamc.plates.elements.cell_map import CellMap, constant, frame
from lamc.plates.elements.definition import SQUARE, TRIANGLE, Element
from lamc.plates.elements.factor import Geometry
from lamc.plates.elements.polynomials import Polynomial, derivative, hats
from lamc.symbolic.scalars import Scalar
from lamc.symbolic.staging import Store

Place: TypeAlias = tuple[Fraction, Fraction]
Motion: TypeAlias = Mapping[str, Callable[[Fraction, Fraction], Fraction | int]]  # unknowns that are not zero

_TOLERANCE = 1e-9  # round-off of coefficients that were given as floats
_CELLS = {  # without right angles or sides along the axes; rectangles are made from the square's first and third corner
    TRIANGLE: (
        (Fraction(1, 5), Fraction(-1, 3)),
        (Fraction(7, 4), Fraction(1, 7)),
        (Fraction(2, 3), Fraction(9, 7)),
    ),
    SQUARE: (
        (Fraction(1, 5), Fraction(-1, 3)),
        (Fraction(7, 4), Fraction(1, 7)),
        (Fraction(8, 5), Fraction(9, 7)),
        (Fraction(-1, 6), Fraction(6, 5)),
    ),
}
_PLACES = tuple((Fraction(a, 7), Fraction(b, 7)) for a, b in ((1, 2), (3, 1), (2, 3), (1, 4), (4, 2), (5, 1)))

_HALF = Fraction(1, 2)
_RIGID: Mapping[str, Motion] = {
    "shifts along x": {"u": lambda _x, _y: 1},
    "shifts along y": {"v": lambda _x, _y: 1},
    "turns in its plane": {"u": lambda _x, y: -y, "v": lambda x, _y: x},
    "is lifted": {"w": lambda _x, _y: 1},
    "tilts along x": {"w": lambda x, _y: x, "w_x": lambda _x, _y: 1},
    "tilts along y": {"w": lambda _x, y: y, "w_y": lambda _x, _y: 1},
}
_STRAINED: Mapping[str, Motion] = {
    "ε_x": {"u": lambda x, _y: x},
    "ε_y": {"v": lambda _x, y: y},
    "γ_xy": {"u": lambda _x, y: y},
    "κ_x": {"w": lambda x, _y: -_HALF * x * x, "w_x": lambda x, _y: -x},
    "κ_y": {"w": lambda _x, y: -_HALF * y * y, "w_y": lambda _x, y: -y},
    "κ_xy": {
        "w": lambda x, y: -_HALF * x * y,
        "w_x": lambda _x, y: -_HALF * y,
        "w_y": lambda x, _y: -_HALF * x,
        "w_xy": lambda _x, _y: -_HALF,
    },
}


def check_element(element: Element) -> None:
    """Raises DesignError unless each shape function is 1 at its own unknown and 0 at all others, all symbols are
    known, and the element moves as a rigid body.
    """
    cell = _SampleCell(element)
    for name in element.fields:
        _check_nodes(cell, name)
    for what, motion in _RIGID.items():
        departure = _departure(cell, motion)
        if departure is not None:
            field, found, expected = departure
            raise DesignError(
                f"element {element.name!r} is strained when it {what} as a rigid body: {field} inside is {found:.6g}, "
                f"not {expected:.6g}; its shape functions must contain this motion"
            )


def missing_strains(element: Element) -> tuple[str, ...]:
    """Constant strains that the element cannot take on exactly; with any, it does not converge."""
    cell = _SampleCell(element)
    return tuple(name for name, motion in _STRAINED.items() if _departure(cell, motion) is not None)


class _SampleCell:
    """One cell in numbers, and the element's functions on it as polynomials."""

    def __init__(self, element: Element) -> None:
        self.element = element
        corners = _CELLS[element.cell]
        if element.is_affine and element.cell == SQUARE:
            (left, low), _, (right, high), _ = corners
            corners = ((left, low), (right, low), (right, high), (left, high))
        self.corners: Sequence[Place] = corners
        self.geometry = Geometry(element, Store(), corners)
        self.frame: CellMap = frame(element, corners)
        self.area = _fraction(
            constant(self.frame.determinant)
        )  # per natural area, where it is the same everywhere
        self.functions = {
            name: [self._polynomial(f) for f in getattr(element, name)] for name in element.fields
        }
        self.slopes = self._slopes()

    def _polynomial(self, expr: sp.Expr) -> Polynomial:
        result: dict[tuple[int, int], Fraction] = {}
        for monomial, part in self.geometry.parts(expr).items():
            weight = self.geometry.staged({monomial: Fraction(1)})
            for powers, c in part.items():
                result[powers] = result.get(powers, Fraction(0)) + _fraction(weight) * c
        return result

    def _slopes(self) -> tuple[list[Polynomial], list[Polynomial]] | None:
        """Of w_x and of w_y, by unknown, where they have shape functions of their own."""
        element = self.element
        if not element.slopes:
            return None
        own = [[self._polynomial(f) for f in part] for part in element.slopes]
        if not element.amounts:
            return own[0], own[1]
        unknowns = element.unknowns
        weights = [[self._polynomial(sp.diff(amount, d)) for d in unknowns] for amount in element.amounts]
        found = [
            [
                _sum((w[j].get((0, 0), Fraction(0)), f) for w, f in zip(weights, functions, strict=True))
                for j in range(len(unknowns))
            ]
            for functions in own
        ]
        return found[0], found[1]

    def gradient(self, polynomial: Polynomial, at: Place) -> Place:
        """By x and y."""
        natural = [value_at(derivative(polynomial, axis), at) for axis in range(2)]
        by_x, by_y = (
            _dot([_fraction(constant(entry)) for entry in rows], natural) / self.area
            for rows in (self.frame.by_x, self.frame.by_y)
        )
        return by_x, by_y

    def coordinates(self, at: Place) -> Place:
        """x and y."""
        shares = [value_at(hat, at) for hat in hats(self.element.cell)]
        x, y = (_dot(shares, [corner[axis] for corner in self.corners]) for axis in range(2))
        return x, y

    def unknown(self, dof: str, polynomial: Polynomial, at: Place) -> Fraction:
        """What an unknown of a node reads from a field."""
        if dof in ("w_x", "w_y"):
            return self.gradient(polynomial, at)[dof == "w_y"]
        if dof == "w_xy":  # of rectangles only
            return value_at(derivative(polynomial, 0, 1), at) / self.area
        return value_at(polynomial, at)


def _check_nodes(cell: _SampleCell, field: str) -> None:
    element = cell.element
    places = [(node.at, dof) for node in element.nodes for dof in node.dofs]
    names = element.unknowns
    for j, polynomial in enumerate(cell.functions[field]):
        for k, (at, dof) in enumerate(places):
            if dof[0] != field:
                continue
            own = element.shear and dof in ("w_x", "w_y")  # of the cross-section, not of w
            readings = [] if own else [cell.unknown(dof, polynomial, at)]
            if cell.slopes is not None and dof in ("w_x", "w_y"):
                readings.append(value_at(cell.slopes[dof == "w_y"][j], at))
            for reading in readings:
                if abs(reading - (j == k)) > _TOLERANCE:
                    raise DesignError(
                        f"element {element.name!r}: the shape function of {names[j]} in {field} gives {names[k]} = "
                        f"{float(reading):.6g}; each must give 1 for its own unknown and 0 for all others"
                    )


def _departure(cell: _SampleCell, motion: Motion) -> tuple[str, float, float] | None:
    """Where the cell does not follow its nodes in `motion`: field, its value, and the one that it should have."""
    amounts: list[Fraction | int] = []
    for node in cell.element.nodes:
        moves = _moves(motion, *cell.coordinates(node.at))
        amounts += [moves.get(dof, 0) for dof in node.dofs]
    functions = dict(cell.functions)
    if cell.slopes is not None:
        functions |= {"w_x": cell.slopes[0], "w_y": cell.slopes[1]}
    for at in _PLACES:
        moves = _moves(motion, *cell.coordinates(at))
        for field, of_unknowns in functions.items():
            found, expected = _dot(amounts, [value_at(f, at) for f in of_unknowns]), moves.get(field, 0)
            if abs(found - expected) > _TOLERANCE:
                return field, float(found), float(expected)
    return None


def _moves(motion: Motion, x: Fraction, y: Fraction) -> dict[str, Fraction | int]:
    return {name: move(x, y) for name, move in motion.items()}


def value_at(polynomial: Polynomial, at: Place) -> Fraction:
    """Of a polynomial at (ξ, η)."""
    return sum((c * at[0] ** i * at[1] ** j for (i, j), c in polynomial.items()), start=Fraction(0))


def _dot(weights: Sequence[Fraction | int], values: Sequence[Fraction]) -> Fraction:
    return sum((w * v for w, v in zip(weights, values, strict=True)), start=Fraction(0))


def _sum(terms: Iterable[tuple[Fraction, Polynomial]]) -> Polynomial:
    result: dict[tuple[int, int], Fraction] = {}
    for weight, polynomial in terms:
        for key, c in polynomial.items():
            result[key] = result.get(key, Fraction(0)) + weight * c
    return result


def _fraction(number: Scalar) -> Fraction:
    assert isinstance(number, int | float | Fraction), "corners are numbers here"
    return Fraction(number)
