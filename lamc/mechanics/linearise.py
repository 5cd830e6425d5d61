"""The equations' derivatives by the state, for implicit integrators, in the residual form.

Goes in: Equations. Comes out: derivatives by q, u and t of the residuals r = M u̇ - f - Jᵀλ and c = J u̇ + γ at given u̇
and λ; the runtime solves M du̇ = Jᵀdλ - dr, J du̇ = -dc with the factors that it has. No inverse is differentiated, and r
comes from inverse dynamics, without a mass matrix: at few joints all derivatives together cost one to four evaluations.
Where q̇ is not u, its derivatives come too.
"""

from collections.abc import Sequence
from dataclasses import dataclass

from lamc.mechanics.equations import Equations
from lamc.symbolic.derivative import derivatives
from lamc.symbolic.program import Space
from lamc.symbolic.scalars import Scalar, Value
from lamc.symbolic.staging import Level, Store
from lamc.symbolic.statements import count_operations

# Beyond these the runtime takes differences, 2n + 2 evaluations: the code grows with the square of the rates, and the C
# compiler's time with it. Measured with rodas5p: time by differences over time with derivatives, and more time of gcc,
#   parallel hinges   13: 1.15, 0.4 s (2200 operations)    16: 1.07, 0.7 s (3300)    20: 0.9, 1.2 s (5100), at rtol 1e-8
#   laminate hinges   8: 1.2 (7500)    10: 1.5 (12 200)    12: 1.5 (18 200), and half as much again of gcc's time
#   links of 6 modes  14 rates: 1.8, 0.7 s (2300)    19: 5.5, 1.5 s (8900)    25: 4.7, 2.9 s (14 900), at rtol 1e-7
# In the last the runtime factors M: differences cost a factorisation each, and their few digits make twice the steps at
# tight tolerances. There operations alone decide.
MAX_RATES = 12
MAX_FLOPS = 4000
MAX_FLOPS_FACTORED = 10_000


@dataclass(frozen=True)
class Linearisation:
    """Rows for r, then c; columns for q, u and t. Entries are scalars of the equations' store."""

    entries: tuple[tuple[Scalar, ...], ...]  # (nu + m, nq + nu + 1)
    flow: tuple[tuple[Scalar, ...], ...] = ()  # (nq, nq + nu): of q̇ by q and u, where q̇ is not u


def linearise(equations: Equations) -> Linearisation | None:
    """The derivatives, or None where they would be too long."""
    count, is_factored = len(equations.rates), not equations.is_plain
    if not count or equations.problem is None:  # accelerations written by hand have none
        return None
    if count > MAX_RATES and not is_factored:
        return None
    most = MAX_FLOPS_FACTORED if is_factored else MAX_FLOPS
    store = equations.store
    names = [rate.name for rate in equations.rates]
    q = [_symbol(store, f"q_{c.name}", Space.ANGLE, i) for i, c in enumerate(equations.coordinates)]
    u = [_symbol(store, f"u_{name}", Space.RATE, i) for i, name in enumerate(names)]
    udot = [_symbol(store, f"udot_{name}", Space.ACCELERATION, i) for i, name in enumerate(names)]
    residuals = equations.problem.residual(udot)
    if equations.closure is not None:
        residuals = [*loaded_residuals(equations, residuals), *second_derivative(equations, udot)]
    flow = equations.coordinate_rates or ()
    with store.section("Derivatives of the residuals", source="for implicit integrators"):
        columns: list[list[Scalar]] = []
        before = len(store)
        for x in (*q, *u, store.symbol("t", Space.TIME, 0)):
            columns.append(derivatives(residuals, {x: 1}))
            if len(store) - before > 2 * most:  # it will be too long: no need to write the rest
                return None
        flow_columns = [derivatives(flow, {x: 1}) for x in (*q, *u)] if flow else []
    entries, flows = tuple(zip(*columns, strict=True)), tuple(zip(*flow_columns, strict=True))
    flops = count_operations(store, [x for row in (*entries, *flows) for x in row], Level.PARAMETER).flops
    return Linearisation(entries, flows) if flops <= most else None


def _symbol(store: Store, name: str, space: Space, index: int) -> Value:
    return store.symbol(name, space, index)


def loaded_residuals(equations: Equations, residuals: Sequence[Scalar]) -> list[Scalar]:
    """r less Jᵀλ."""
    assert equations.closure is not None
    store = equations.store
    rows = equations.closure.jacobian
    multipliers = [store.symbol(f"lambda_{k}", Space.MULTIPLIER, k) for k in range(len(rows))]
    result: list[Scalar] = []
    with store.section("Forces of the closure", source="Jᵀλ"):
        forces: list[Scalar] = [0] * len(residuals)
        for row, multiplier in zip(rows, multipliers, strict=True):
            for j, entry in row:
                forces[j] = forces[j] + entry * multiplier
        result += (residual - force for residual, force in zip(residuals, forces, strict=True))
    return result


def second_derivative(equations: Equations, udot: Sequence[Value]) -> list[Scalar]:
    """c = J u̇ + γ."""
    assert equations.closure is not None
    result: list[Scalar] = []
    with equations.store.section("Accelerations of the closure", source="J u̇ + γ"):
        for row, bias in zip(equations.closure.jacobian, equations.closure.bias, strict=True):
            value = bias
            for j, entry in row:
                value = value + entry * udot[j]
            result.append(value)
    return result
