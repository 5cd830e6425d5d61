"""The equations' derivatives by the state, for implicit integrators, in the residual form.

Goes in: Equations. Comes out: derivatives by q, u and t of the residuals r = M u̇ - f - Jᵀλ and c = J u̇ + γ at given u̇
and λ; the runtime solves M du̇ = Jᵀdλ - dr, J du̇ = -dc with the factors that it has. No inverse is differentiated, and r
comes from inverse dynamics, without a mass matrix: at few joints all derivatives together cost one to four evaluations.
"""

from collections.abc import Sequence
from dataclasses import dataclass

from lamc.codegen.program import Space
from lamc.mechanics.derivative import derivatives
from lamc.mechanics.equations import Equations
from lamc.mechanics.staging import Level, Scalar, Store, Value
from lamc.mechanics.statements import count_operations

# Beyond these the code grows with the square of the joints and the C compiler's time with it; the runtime then takes
# differences, 2n + 2 evaluations (measured: 12 000 operations for 10 laminate hinges, 50 000 for 20).
MAX_JOINTS = 12
MAX_FLOPS = 4000


@dataclass(frozen=True)
class Linearisation:
    """Rows for r, then c; columns for q, u and t. Entries are scalars of the equations' store."""

    entries: tuple[tuple[Scalar, ...], ...]  # (n + m, 2 n + 1)


def linearise(equations: Equations) -> Linearisation | None:
    """The derivatives, or None where they would be too long."""
    count = len(equations.joints)
    if not 0 < count <= MAX_JOINTS or equations.problem is None:  # accelerations written by hand have none
        return None
    store = equations.store
    names = equations.joints
    q = [_symbol(store, f"q_{name}", Space.ANGLE, i) for i, name in enumerate(names)]
    u = [_symbol(store, f"u_{name}", Space.RATE, i) for i, name in enumerate(names)]
    udot = [_symbol(store, f"udot_{name}", Space.ACCELERATION, i) for i, name in enumerate(names)]
    residuals = equations.problem.residual(udot)
    if equations.closure is not None:
        residuals = [*_with_multipliers(equations, q, residuals), *_second_derivative(equations, q, u, udot)]
    with store.section("Derivatives of the residuals", source="for implicit integrators"):
        columns: list[list[Scalar]] = []
        before = len(store)
        for x in (*q, *u, store.symbol("t", Space.TIME, 0)):
            columns.append(derivatives(residuals, {x: 1}))
            if len(store) - before > 2 * MAX_FLOPS:  # it will be too long: no need to write the rest
                return None
    entries = tuple(zip(*columns, strict=True))
    flops = count_operations(store, [x for row in entries for x in row], Level.PARAMETER).flops
    return Linearisation(entries) if flops <= MAX_FLOPS else None


def _symbol(store: Store, name: str, space: Space, index: int) -> Value:
    return store.symbol(name, space, index)


def _with_multipliers(equations: Equations, q: Sequence[Value], residuals: Sequence[Scalar]) -> list[Scalar]:
    """r less Jᵀλ."""
    assert equations.closure is not None
    store = equations.store
    rows = equations.closure.jacobian
    multipliers = [store.symbol(f"lambda_{k}", Space.MULTIPLIER, k) for k in range(len(rows))]
    result: list[Scalar] = []
    with store.section("Forces of the closure", source="Jᵀλ"):
        for j in range(len(q)):
            force: Scalar = 0
            for row, multiplier in zip(rows, multipliers, strict=True):
                force = force + row[j] * multiplier
            result.append(residuals[j] - force)
    return result


def _second_derivative(
    equations: Equations, q: Sequence[Value], u: Sequence[Value], udot: Sequence[Value]
) -> list[Scalar]:
    """c = J u̇ + γ."""
    assert equations.closure is not None
    result: list[Scalar] = []
    with equations.store.section("Accelerations of the closure", source="J u̇ + γ"):
        for row, bias in zip(equations.closure.jacobian, equations.closure.bias, strict=True):
            value = bias
            for entry, acceleration in zip(row, udot, strict=True):
                value = value + entry * acceleration
            result.append(value)
    return result
