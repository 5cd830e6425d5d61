"""Shape functions factored over the rationals: functions of ξ and η with plain numbers, times weights of geometry.

In: shape functions, linear in the unknowns, whose coefficients depend on the corners. Out: `Factored`: a basis of the
functions' span, pure polynomials, and how much of each the unknowns call for: field = Σ_m basis_m (Σ_j weight_mj d_j).
Never: stiffness, floats.

Of strains, the basis has as many functions as the element can be strained in, so that rigid motions vanish before
anything is multiplied: of BCIZ's nine shape functions six are left, each weighed by the slope of an edge's end relative
to its chord, x21 w_x1 + y21 w_y1 - (w2 - w1). Nothing here knows that element; it is what Gaussian elimination finds.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from typing import TypeAlias, TypeVar

import sympy as sp

from lamc.basics.errors import DesignError, ExpressionError
from lamc.mechanics.sympy_view import from_sympy
from lamc.plates.elements.definition import Element, eta, side, xi
from lamc.plates.elements.polynomials import Polynomial, derivative
from lamc.symbolic.scalars import Scalar
from lamc.symbolic.staging import Store

Rows: TypeAlias = tuple[Polynomial, ...]  # of one function: its values, gradient or strains
Weights: TypeAlias = Mapping[int, Scalar]  # unknown → factor, in ascending order
_Vector: TypeAlias = dict[tuple[int, int, int], Fraction]  # (row, i, j) → coefficient
Key = TypeVar("Key")
_Parts: TypeAlias = dict[sp.Expr, Rows]  # monomial of geometry → polynomials


@dataclass(frozen=True)
class Factored:
    """`basis[m]` times Σ_j `weights[m][j]` d_j, summed over m."""

    basis: tuple[Rows, ...]
    weights: tuple[Weights, ...]


class Geometry:
    """Staged coordinates of one element's corners, and what its shape functions call by name."""

    def __init__(self, element: Element, store: Store, corners: Sequence[tuple[Scalar, Scalar]]) -> None:
        self.element, self.store, self.corners = element, store, tuple(corners)
        self._shift: dict[sp.Symbol, sp.Expr] = {}
        self.known: dict[str, Scalar] = {}
        numbers = range(1, len(self.corners) + 1)
        for axis, name in enumerate("xy"):
            for i in numbers:
                raw = sp.Symbol(f"{name}{i}", real=True)
                self.known[raw.name] = self.corners[i - 1][axis]
                for j in numbers:
                    if i != j:
                        self.known[side(name, i, j).name] = (
                            self.corners[i - 1][axis] - self.corners[j - 1][axis]
                        )
                if i > 1:
                    self._shift[raw] = sp.Symbol(f"{name}1", real=True) + side(name, i, 1)
        for symbol, expr in element.geometry.items():
            try:
                self.known[symbol.name] = from_sympy(expr, self.known, store)
            except ExpressionError as error:
                raise DesignError(
                    f"element {element.name!r} has the geometry {symbol} = {expr}: {error.message}"
                ) from error

    def parts(self, expr: sp.Expr) -> dict[sp.Expr, Polynomial]:
        """`expr` as a sum of monomials of geometry times polynomials in ξ and η."""
        moved = expr.xreplace(self._shift)
        try:
            terms = sp.Poly(moved, xi, eta).terms()
        except sp.PolynomialError as error:
            raise DesignError(
                f"element {self.element.name!r} has the shape function {expr}, which is no polynomial in xi and eta; "
                "only polynomials can be integrated exactly"
            ) from error
        result: dict[sp.Expr, dict[tuple[int, int], Fraction]] = {}
        for powers, coefficient in terms:
            for term in sp.Add.make_args(sp.expand(coefficient)):
                number, monomial = term.as_coeff_Mul()
                self._check(monomial, expr)
                value = (
                    Fraction(int(number.p), int(number.q)) if number.is_Rational else Fraction(float(number))
                )
                part = result.setdefault(monomial, {})
                part[powers] = part.get(powers, Fraction(0)) + value
        return {monomial: {k: c for k, c in sorted(p.items()) if c} for monomial, p in result.items()}

    def _check(self, monomial: sp.Expr, expr: sp.Expr) -> None:
        for symbol in sorted(monomial.free_symbols, key=str):
            if symbol.name in ("x1", "y1"):
                raise DesignError(
                    f"element {self.element.name!r} has the shape function {expr}, which changes as the cell is moved; "
                    "use differences of coordinates only"
                )
            if symbol.name not in self.known:
                raise DesignError(
                    f"element {self.element.name!r} has the unknown symbol {symbol} in a shape function; known are xi, "
                    f"eta, coordinates of the {self.element.corner_count} corners and what `geometry` defines"
                )
        for power in monomial.atoms(sp.Pow):
            if not (power.exp.is_Integer and power.exp > 0):
                raise DesignError(
                    f"element {self.element.name!r} has {power} in a shape function; give it a symbol in `geometry`"
                )

    def staged(self, terms: Mapping[sp.Expr, Fraction]) -> Scalar:
        """Σ coefficient · monomial; x31 - x21 becomes x32, which is exact where corners are close."""
        terms = dict(terms)
        for name in "xy":
            for i in range(3, len(self.corners) + 1):
                for j in range(2, i):
                    far, near = side(name, i, 1), side(name, j, 1)
                    if far in terms and terms.get(near) == -terms[far]:
                        terms[side(name, i, j)] = terms.get(side(name, i, j), Fraction(0)) + terms.pop(far)
                        del terms[near]
        total: Scalar = 0
        for monomial, coefficient in sorted(terms.items(), key=lambda item: sp.default_sort_key(item[0])):
            if coefficient:
                total = total + plain(coefficient) * from_sympy(monomial, self.known, self.store)
        return total


def plain(number: Fraction) -> Scalar:
    """Whole numbers as integers, which fold and print as such."""
    return int(number) if number.denominator == 1 else number


def gradient(p: Polynomial) -> Rows:
    """By ξ and η."""
    return derivative(p, 0), derivative(p, 1)


def hessian(p: Polynomial) -> Rows:
    """Second derivatives: ξξ, ηη, ξη."""
    return derivative(p, 0, 0), derivative(p, 1, 1), derivative(p, 0, 1)


def value(p: Polynomial) -> Rows:
    return (p,)


def factored(
    geometry: Geometry,
    functions: Sequence[Sequence[sp.Expr]],
    operator: Callable[[Polynomial], Rows],
) -> Factored:
    """Factors of `operator` applied to `functions`: one sequence of components per unknown."""
    columns = [_column(geometry, components, operator) for components in functions]
    # Functions that geometry multiplies first: what plain numbers multiply is then told by them. The first corner's
    # last, so that it is the others' differences from it that count.
    order = [(j, m) for j, column in enumerate(columns) for m in column if m != 1]
    order += [(j, m) for j, column in reversed(list(enumerate(columns))) for m in column if m == 1]
    elimination = _Elimination()
    shares: dict[tuple[int, sp.Expr], dict[int, Fraction]] = {}
    first: list[int] = []  # unknown that brought each basis function
    for j, m in order:
        shares[j, m] = elimination.express(_vector(columns[j][m]))
        first += [j] * (len(elimination.basis) - len(first))
    weights: list[dict[int, Scalar]] = [{} for _ in elimination.basis]
    for j, column in enumerate(columns):
        terms: dict[int, dict[sp.Expr, Fraction]] = {}
        for monomial in column:
            for k, share in shares[j, monomial].items():
                terms.setdefault(k, {})[monomial] = share
        for k in sorted(terms):
            weight = geometry.staged(terms[k])
            if weight != 0:
                weights[k][j] = weight
    count = len(functions[0]) * len(operator({})) if functions else 0
    places = sorted(range(len(first)), key=first.__getitem__)
    basis = tuple(_rows(elimination.basis[k], count) for k in places)
    return Factored(basis, tuple(weights[k] for k in places))


def _column(
    geometry: Geometry, components: Sequence[sp.Expr], operator: Callable[[Polynomial], Rows]
) -> _Parts:
    parts = [geometry.parts(component) for component in components]
    monomials = sorted({m for part in parts for m in part}, key=sp.default_sort_key)
    return {m: tuple(row for part in parts for row in operator(part.get(m, {}))) for m in monomials}


def _vector(rows: Rows) -> _Vector:
    return {(r, i, j): c for r, row in enumerate(rows) for (i, j), c in row.items() if c}


def _rows(vector: _Vector, count: int) -> Rows:
    return tuple({(i, j): c for (r, i, j), c in sorted(vector.items()) if r == row} for row in range(count))


@dataclass
class _Elimination:
    """Vectors over the rationals told by the first independent ones among them."""

    basis: list[_Vector] = field(default_factory=list)
    _steps: list[tuple[tuple[int, int, int], _Vector, dict[int, Fraction]]] = field(default_factory=list)

    def express(self, vector: _Vector) -> dict[int, Fraction]:
        """`vector` as {position in `basis`: factor}; one that is independent joins the basis."""
        rest, shares = dict(vector), dict[int, Fraction]()
        for pivot, reduced, parts in self._steps:
            factor = rest.get(pivot, Fraction(0))
            if factor:
                _add(rest, reduced, -factor)
                _add(shares, parts, factor)
        if not rest:
            return shares
        pivot = min(rest)
        scale, position = 1 / rest[pivot], len(self.basis)
        self.basis.append(dict(vector))
        parts = {position: scale}
        _add(parts, shares, -scale)
        self._steps.append((pivot, {key: c * scale for key, c in rest.items()}, parts))
        return {position: Fraction(1)}


def _add(target: dict[Key, Fraction], other: Mapping[Key, Fraction], factor: Fraction) -> None:
    for key, c in other.items():
        total = target.get(key, Fraction(0)) + factor * c
        if total:
            target[key] = total
        else:
            target.pop(key, None)
