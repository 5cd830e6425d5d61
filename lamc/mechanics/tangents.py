"""Derivatives of the equations by the state and by parameters, for sensitivities of a run.

Goes in: Equations, names. Comes out: derivatives by q, u and each column of the residuals r = M u̇ - f - Jᵀλ and
c = J u̇ + γ at given u̇ and λ, as in `linearise`, of closure and of guards. A column is a parameter, or a dimension of
the drawing: along it the numbers of the drawing move at paces that `setup` is given beside them, so that one program
serves every dimension. What depends on parameters only is worked out once, by `setup`. Of a tree the factors of M come
with them. Where a matrix of all states is longer than derivatives along a few directions, these stand in its place.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from lamc.basics.errors import RequestError
from lamc.mechanics.equations import Equations
from lamc.mechanics.linearise import loaded_residuals, second_derivative
from lamc.mechanics.mass_matrix import factors
from lamc.symbolic.derivative import derivatives
from lamc.symbolic.program import Space
from lamc.symbolic.scalars import Scalar, Value
from lamc.symbolic.staging import DrawnKey, Level
from lamc.symbolic.statements import count_operations

PACE = "pace"  # begins the keys of numbers by which those of the drawing move along a dimension
# gcc takes some 10 s for so many; the code grows with the square of the rates.
MAX_FLOPS = 200_000
# Columns of S are taken four at a time, and so are stages where all derivatives by the state are written down.
AT_ONCE = 4
# gcc takes some 2 s for so many, once and once more in vectors.
MAX_MATRIX = 6000


@dataclass(frozen=True)
class Columns:
    """What is differentiated by: parameters of the equations, and dimensions of the drawing, by name."""

    parameters: tuple[str, ...]
    dimensions: tuple[str, ...] = ()

    @property
    def names(self) -> tuple[str, ...]:
        return (*self.parameters, *self.dimensions)


@dataclass(frozen=True)
class Tangents:
    """Rows of scalars of the equations' store, for k columns.

    residuals  (nu + m, nq + nu + k): of r, then of c; (nu + m, k) where `along` stands for those by q and u
    along      (nu + m,): of r, then of c, along a direction (nq + nu,) of q and u; empty where `residuals` has all
    flow       (nq, nq + nu): of q̇ by q and u, where q̇ is not u; else empty
    closure    (m, nq + k + nq + nu + k): of φ by q and the columns, then of J u by q, u and the columns; empty
               for a tree
    guards     (guards, nq + nu + 1 + k): by q, u, t and the columns
    samples    (held, nq + nu + k): of what clocks hold
    factors    of M = LᵀDL, by rows: L below its diagonal of ones, then 1 / D; empty where the runtime solves

    Where clocks hold samples, their number follows in `residuals`, `guards` and `samples`: derivatives by what is held.
    """

    residuals: tuple[tuple[Scalar, ...], ...]
    along: tuple[Scalar, ...]
    flow: tuple[tuple[Scalar, ...], ...]
    closure: tuple[tuple[Scalar, ...], ...]
    guards: tuple[tuple[Scalar, ...], ...]
    samples: tuple[tuple[Scalar, ...], ...]
    factors: tuple[tuple[Scalar, ...], ...]


def tangents(equations: Equations, columns: Columns) -> Tangents:
    """The derivatives. Raises RequestError for a name that is no parameter, and where the code would be too long."""
    store = equations.store
    q = [store.symbol(f"q_{c.name}", Space.ANGLE, i) for i, c in enumerate(equations.coordinates)]
    u = [store.symbol(f"u_{c.name}", Space.RATE, i) for i, c in enumerate(equations.rates)]
    udot = [store.symbol(f"udot_{c.name}", Space.ACCELERATION, i) for i, c in enumerate(equations.rates)]
    state = [{x: 1} for x in (*q, *u)]
    positions, time = state[: len(q)], [{store.symbol("t", Space.TIME, 0): 1}]
    residuals = equations.problem.residual(udot)
    if equations.closure is not None:
        residuals = [*loaded_residuals(equations, residuals), *second_derivative(equations, udot)]
    closed = [] if equations.closure is None else equations.closure.residual
    drifts = [] if equations.closure is None else drifts_of(equations, u)
    guards = [terms.guard.value for terms in equations.guards]
    moves = _moves(equations, columns)
    clocks = [terms.guard.clock for terms in equations.guards if terms.guard.clock is not None]
    held = [{symbol: 1} for clock in clocks for symbol in clock.held]
    sampled = [value for clock in clocks for value in clock.held.values()]
    for name, move in zip(columns.names, moves, strict=True):
        if any(isinstance(d, Value) or d != 0 for d in derivatives([clock.period for clock in clocks], move)):
            raise RequestError(
                f"there is no derivative by {name!r}: it moves the times at which a servo samples"
            )
    with store.section("Derivatives by state and parameters", source="for sensitivities of a run"):
        along, by_state = _by_state(residuals, state, -(-len(moves) // AT_ONCE))
        others = [derivatives(residuals, direction) for direction in (*moves, *held)]
        found = Tangents(
            residuals=tuple(zip(*by_state, *others, strict=True))
            if by_state or others
            else ((),) * len(residuals),
            along=along,
            flow=_rows(equations.coordinate_rates or (), state),
            closure=tuple(
                of_gaps + of_drifts
                for of_gaps, of_drifts in zip(
                    _rows(closed, [*positions, *moves]), _rows(drifts, [*state, *moves]), strict=True
                )
            ),
            guards=_rows(guards, [*state, *time, *moves, *held]),
            samples=_rows(sampled, [*state, *moves, *held]),
            factors=_factors(equations),
        )
    parts = (found.residuals, (found.along,), found.flow, found.closure, found.factors)
    values = [value for rows in parts for row in rows for value in row]
    flops = count_operations(store, values, Level.PARAMETER).flops
    if flops > MAX_FLOPS:
        raise RequestError(
            f"derivatives of {equations.tree.mechanism.name!r}, which has {len(u)} rates, would take {flops} "
            f"operations an evaluation, more than {MAX_FLOPS}; take differences of runs instead"
        )
    return found


def _by_state(
    residuals: Sequence[Scalar], state: Sequence[Mapping[Value, Scalar]], packs: int
) -> tuple[tuple[Scalar, ...], list[list[Scalar]]]:
    """Derivatives along a direction, or by each component of the state, whichever costs less for so many packs of
    columns; the other is empty."""
    components = [x for each in state for x in each]
    if not components:
        return (), []
    store = components[0].store
    direction = {x: store.symbol(f"direction_{i}", Space.WEIGHT, i) for i, x in enumerate(components)}
    along = tuple(derivatives(residuals, direction))
    limit = min(MAX_MATRIX, AT_ONCE * max(packs, 1) * count_operations(store, along, Level.PARAMETER).flops)
    columns: list[list[Scalar]] = []
    before = len(store)
    for each in state:
        columns.append(derivatives(residuals, each))
        if len(store) - before > 2 * limit:  # it will be too long: no need to write the rest
            return along, []
    entries = [value for column in columns for value in column]
    if count_operations(store, entries, Level.PARAMETER).flops > limit:
        return along, []
    return (), columns


def _moves(equations: Equations, columns: Columns) -> list[Mapping[Value, Scalar]]:
    """What moves at which pace, by column."""
    store = equations.store
    places = {parameter.name: k for k, parameter in enumerate(equations.parameters)}
    moves: list[Mapping[Value, Scalar]] = []
    for name in columns.parameters:
        if name not in places:
            raise RequestError(f"{name!r} is no parameter of the equations; there are {', '.join(places)}")
        moves.append({store.symbol(name, Space.PARAMETER, places[name]): 1})
    # Parameters such as masses have their defaults of the drawing too.
    drawn = {key: Value(store, index, 1) for key, index in store.drawn.items()}
    drawn |= {parameter_key(name): store.symbol(name, Space.PARAMETER, k) for name, k in places.items()}
    for dimension in columns.dimensions:
        paces = {key: store.drawn_number(0.0, (PACE, dimension, *key)) for key in drawn}
        moves.append({drawn[key]: pace for key, pace in paces.items()})
    return moves


def parameter_key(name: str) -> DrawnKey:
    """The key of a parameter among the numbers that follow from the drawing."""
    return ("parameter", name)


def drifts_of(equations: Equations, u: Sequence[Value]) -> list[Scalar]:
    """J u, by equation."""
    assert equations.closure is not None
    result: list[Scalar] = []
    with equations.store.section("Rates of the closure", source="J u"):
        for row in equations.closure.jacobian:
            value: Scalar = 0
            for j, entry in row:
                value = value + entry * u[j]
            result.append(value)
    return result


def _factors(equations: Equations) -> tuple[tuple[Scalar, ...], ...]:
    if equations.closure is not None or not equations.is_plain:
        return ()
    count = len(equations.rates)
    lower, inverse = factors(count, {at: value for at, value in equations.inertia.items() if at[0] >= at[1]})
    return tuple((*(lower.get((k, i), 0) for i in range(k)), inverse[k]) for k in range(count))


def _rows(
    values: Sequence[Scalar], directions: Sequence[Mapping[Value, Scalar]]
) -> tuple[tuple[Scalar, ...], ...]:
    columns = [derivatives(values, direction) for direction in directions]
    return tuple(tuple(column[i] for column in columns) for i in range(len(values)))
