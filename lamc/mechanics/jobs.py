"""What a program is to compute: its functions by name, what each is for and reads, and the expressions it gives.

In: staged equations. Out: jobs, which `lower` turns into straight-line functions. Never: orders statements.
"""

from collections.abc import Sequence

from lamc.mechanics.equations import Equations
from lamc.mechanics.linearise import linearise
from lamc.mechanics.tangents import Columns, tangents
from lamc.symbolic.program import Space
from lamc.symbolic.scalars import Scalar, Value

Job = tuple[tuple[str, str, tuple[Space, ...]], Sequence[Scalar]]
_STATE = (Space.CONSTANT, Space.TIME, Space.ANGLE, Space.RATE)

# name, purpose, what it reads; the outputs come from the equations
ACCELERATION = ("acceleration", "accelerations of the joints, rad/s^2", _STATE)
RATES = ("rates", "derivatives of the coordinates by time", (Space.CONSTANT, Space.ANGLE, Space.RATE))
ENERGY = ("energy", "energies by effect, J; kinetic first", _STATE)
POSES = (
    "poses",
    "per moving body: centre of mass (3), m, and rotation (9, by rows), world axes",
    (Space.CONSTANT, Space.TIME, Space.ANGLE),
)


SYSTEM = ("system", "mass matrix, lower triangle by rows, then forces", _STATE)
CLOSURE = (
    "closure",
    "residuals of the loops (m), rad or parts of the size, then the entries of their Jacobian by rates",
    (Space.CONSTANT, Space.ANGLE),
)
DYNAMICS = (
    "dynamics",
    "mass matrix and forces as system gives them, then entries of the loops' Jacobian and their bias (m), 1/s^2",
    _STATE,
)
CONSTRAINTS = (
    "constraints",
    "entries of the loops' Jacobian by rates, then their bias (m), 1/s^2",
    (Space.CONSTANT, Space.ANGLE, Space.RATE),
)
RESIDUAL = ("residual", "M udot - f, without the loops", (*_STATE, Space.ACCELERATION))
MOMENTA = ("momenta", "M udot", (Space.CONSTANT, Space.ANGLE, Space.ACCELERATION))
INERTIA = ("inertia", "mass matrix, lower triangle by rows", (Space.CONSTANT, Space.ANGLE))
JACOBIAN = (
    "jacobian",
    "derivatives by q, u and t of M udot - f - J^T lambda, then of J udot + gamma",
    (*_STATE, Space.ACCELERATION, Space.MULTIPLIER),
)
GUARDS = ("guards", "guards, then their rates", _STATE)
GUARD_CHANGES = (
    "guard_changes",
    "what accelerations add to the rates of guards",
    (*_STATE, Space.ACCELERATION),
)
SAMPLES = ("samples", "periods of the clocks, s, then samples of what they hold", _STATE)
IMPACTS = (
    "impacts",
    "restitutions of the guards, then derivatives of their rates by u",
    (Space.CONSTANT, Space.TIME, Space.ANGLE),
)
TANGENTS = (
    "tangents",
    "derivatives by q, u and columns of M udot - f - J^T lambda, then of J udot + gamma; of dq/dt; factors of M",
    (*_STATE, Space.ACCELERATION, Space.MULTIPLIER),
)
DIRECTIONAL_TANGENTS = (
    "directional_tangents",
    "derivatives along a direction of q and u of M udot - f - J^T lambda, then of J udot + gamma",
    (*_STATE, Space.ACCELERATION, Space.MULTIPLIER, Space.WEIGHT),
)
CLOSURE_TANGENTS = (
    "closure_tangents",
    "derivatives of the residuals of the loops by q and columns, then of their rates by q, u and columns",
    (Space.CONSTANT, Space.ANGLE, Space.RATE),
)
SAMPLE_TANGENTS = (
    "sample_tangents",
    "derivatives of what clocks sample by q, u, columns and what is held",
    _STATE,
)
GUARD_TANGENTS = ("guard_tangents", "derivatives of the guards by q, u, t and columns", _STATE)
POWER = ("power", "power of the loads of each effect, W", (*_STATE, Space.ACCELERATION))


def motion_jobs(equations: Equations) -> list[Job]:
    """What moves the mechanism: accelerations, or what the runtime solves them from."""
    closure, flow = equations.closure, equations.coordinate_rates
    rates = [] if flow is None else [(RATES, flow)]
    if closure is None and equations.is_plain:
        return [*rates, (ACCELERATION, equations.acceleration)]
    jacobian = [] if closure is None else [value for row in closure.jacobian for _, value in row]
    if closure is not None and equations.is_recursive:
        residual, momenta = equations.passes
        return [
            (CLOSURE, [*closure.residual, *jacobian]),
            (CONSTRAINTS, [*jacobian, *closure.bias]),
            (RESIDUAL, residual),
            (MOMENTA, momenta),
        ]
    lower_triangle = _lower_triangle(equations)
    system = (SYSTEM, [*lower_triangle, *equations.forces])
    if closure is None:
        return [*rates, system]
    return [
        *rates,
        system,
        (CLOSURE, [*closure.residual, *jacobian]),
        (DYNAMICS, [*lower_triangle, *equations.forces, *jacobian, *closure.bias]),
    ]


def event_jobs(equations: Equations) -> list[Job]:
    """Derivatives for implicit integrators, guards, and what a tree's impacts need besides."""
    jobs: list[Job] = []
    linearisation = linearise(equations)
    terms = equations.guards
    impacts = any(t.guard.restitution is not None for t in terms)
    if equations.closure is None and equations.is_plain and (impacts or linearisation is not None):
        jobs.append((INERTIA, _lower_triangle(equations)))
    if linearisation is not None:
        rows = (*linearisation.entries, *linearisation.flow)
        jobs.append((JACOBIAN, [value for row in rows for value in row]))
    if terms:
        jobs.append((GUARDS, [*(t.guard.value for t in terms), *(t.rate for t in terms)]))
    if any(isinstance(t.by_rates, Value) or t.by_rates for t in terms):
        jobs.append((GUARD_CHANGES, [t.by_rates for t in terms]))
    clocks = [t.guard.clock for t in terms if t.guard.clock is not None]
    if clocks:
        values = [value for clock in clocks for value in clock.held.values()]
        jobs.append((SAMPLES, [*(clock.period for clock in clocks), *values]))
    if impacts:
        nothing = (0,) * len(equations.rates)
        restitutions = [0 if t.guard.restitution is None else t.guard.restitution for t in terms]
        jobs.append((IMPACTS, [*restitutions, *(v for t in terms for v in (t.gradient or nothing))]))
    return jobs


def tangent_jobs(equations: Equations, columns: Columns) -> list[Job]:
    found = tangents(equations, columns)
    jobs = [
        (TANGENTS, (*found.residuals, *found.flow, *found.factors)),
        *([(DIRECTIONAL_TANGENTS, (found.along,))] if found.along else []),
        *([(CLOSURE_TANGENTS, found.closure)] if found.closure else []),
        *([(GUARD_TANGENTS, found.guards)] if found.guards else []),
        *([(SAMPLE_TANGENTS, found.samples)] if found.samples else []),
    ]
    return [(job, [value for row in rows for value in row]) for job, rows in jobs]


def _lower_triangle(equations: Equations) -> list[Scalar]:
    count = len(equations.rates)
    return [equations.inertia.get((i, j), 0) for i in range(count) for j in range(i + 1)]
