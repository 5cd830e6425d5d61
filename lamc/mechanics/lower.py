"""`lower`: from Equations to a Program of straight-line functions.

Goes in: staged equations. Comes out: `setup`, which computes once what depends on parameters only, and the functions
that run at every step and read what it left. No sympy, no text, no file.
"""

import hashlib
from collections.abc import Iterable, Sequence
from dataclasses import replace
from types import MappingProxyType

from lamc.codegen.lowering import Lowering, canonical
from lamc.mechanics.equations import Equations
from lamc.mechanics.jobs import ENERGY, POSES, POWER, event_jobs, motion_jobs, tangent_jobs
from lamc.mechanics.pullbacks import Pullbacks
from lamc.mechanics.tangents import Columns
from lamc.records.series import ORDERS
from lamc.symbolic.allocation import collector_paused
from lamc.symbolic.piecewise import Piecewise
from lamc.symbolic.program import (
    TICKS,
    Clock,
    DrawnNumber,
    Function,
    Guard,
    Program,
    SeriesInput,
    Space,
    design_digest,
)
from lamc.symbolic.scalars import Scalar, Value
from lamc.symbolic.staging import TABLE, DrawnKey, Level, Store, Symbol, table_place

INPUT = "from outside"


@collector_paused
def lower(
    equations: Equations,
    *,
    energy_balance: bool = False,
    columns: Columns | None = None,
    pullbacks: bool = False,
) -> Program:
    """The program of `equations`; with the power of every effect where the `energy_balance` is to be kept, with
    derivatives by `columns`, where there are any, and with those of weighted sums. Raises RequestError where these
    would be too long."""
    equations = equations.forked()
    store = equations.store
    motion = motion_jobs(equations)
    jobs = [
        *motion,
        (ENERGY, tuple(equations.energies.values())),
        (POSES, equations.poses),
        *event_jobs(equations),
        *([] if columns is None else tangent_jobs(equations, columns)),
        *([(POWER, tuple(equations.powers.values()))] if energy_balance else []),
    ]
    pulled = Pullbacks(equations) if pullbacks else None
    jobs += [] if pulled is None else pulled.jobs
    modes = [terms.guard.mode for terms in equations.guards if terms.guard.mode is not None]
    clocks = [terms.guard.clock for terms in equations.guards if terms.guard.clock is not None]
    modes += [
        symbol for clock in clocks for symbol in (clock.tick, *clock.held)
    ]  # the runtime's, as modes are
    # node → slot; first what the runtime keeps, zero at first: values and derivatives of series, then modes
    constants: dict[int, int] = {
        index: k for k, index in enumerate((*_series_nodes(store), *(m.index for m in modes)))
    }
    kept = len(constants)
    functions = [
        Lowering(store, Level.PARAMETER, constants).function(name, purpose, reads, outputs)
        for (name, purpose, reads), outputs in jobs
    ]
    last = _last_numbers(equations)
    drawn = _drawn_numbers(store, (*constants, *last))
    if pulled is not None:
        (name, purpose, reads), outputs = pulled.setup(tuple(drawn))
        functions.append(Lowering(store, Level.PARAMETER, constants).function(name, purpose, reads, outputs))
    for index in last:
        constants[index] = len(constants)
    places = {index: len(equations.parameters) + place for place, index in enumerate(drawn.values())}
    setup = Lowering(store, Level.NUMBER, {}, places).function(
        "setup",
        "everything that depends on parameters only; once per change of parameters",
        (Space.PARAMETER,),
        [0 if slot < kept else Value(store, index, 1) for index, slot in constants.items()],
    )
    program = Program(
        name=equations.tree.mechanism.name,
        joints=equations.joints,
        coordinates=equations.coordinates,
        rates=equations.rates,
        bodies=equations.bodies,
        parameters=equations.parameters,
        geometry=tuple(DrawnNumber(key, float(store.payloads[index])) for key, index in drawn.items()),  # type: ignore[arg-type]
        constant_count=len(constants),
        energies=tuple(equations.energies),
        cuts=equations.cut_joints,
        closure_count=len(equations.closure.residual) if equations.closure else 0,
        guards=tuple(
            Guard(g.name, constants[g.mode.index] if g.mode is not None else -1 if g.clock is None else TICKS)
            for g in (terms.guard for terms in equations.guards)
        ),
        clocks=tuple(
            Clock(place, constants[c.tick.index], tuple(constants[each.index] for each in c.held))
            for place, c in ((k, terms.guard.clock) for k, terms in enumerate(equations.guards))
            if c is not None
        ),
        drawn=() if equations.arrangement is None else equations.arrangement.displaced,
        series=_series(equations, store, [value for _, outputs in motion for value in outputs]),
        powers=tuple(equations.powers) if energy_balance else (),
        columns=() if columns is None else columns.names,
        source_count=0 if pulled is None else len(pulled.sources),
        jacobian_cost=_jacobian_cost(functions),
        rank=equations.loops.rank,
        pattern=equations.pattern,
        functions=MappingProxyType({f.name: f for f in (setup, *functions)}),
        notes=(_solver_note(equations),),
        tables=MappingProxyType(_tables(store, (setup, *functions))),
    )
    return _with_digests(program)


def _last_numbers(equations: Equations) -> tuple[int, ...]:
    """Nodes of the last two constants of what has loops: its size, and the gap that they may keep."""
    if equations.closure is None:
        return ()
    numbers = (("size", equations.tree.mechanism.size), ("gap", equations.loops.accepted_gap))
    return tuple(equations.store.drawn_number(value, (key,)).index for key, value in numbers)


def on_branch(program: Program, equations: Equations) -> Program:
    """The program of `equations`, from that of the same ones before `Equations.on_branch`: functions are alike, and the
    gap that loops may keep too; how the runtime eliminates their closure is not."""
    return _with_digests(replace(program, rank=equations.loops.rank, pattern=equations.pattern))


def _series_nodes(store: Store) -> list[int]:
    """Symbols of the series and of their derivatives, in the order of their constants."""
    nodes = {*store.flows, *store.flows.values()}
    return sorted(nodes, key=lambda index: _symbol(store, index).index)


def _symbol(store: Store, index: int) -> Symbol:
    symbol = store.payloads[index]
    assert isinstance(symbol, Symbol)
    return symbol


def _series(equations: Equations, store: Store, motion: Sequence[Scalar]) -> tuple[SeriesInput, ...]:
    """Inputs that follow a series, with the highest derivative of each that the values of `motion` hold."""
    if not store.flows:
        return ()
    live = set(store.live(motion))
    needed = {_symbol(store, index).index for index in _series_nodes(store) if index in live}
    names = sorted(name for name, each in equations.inputs.items() if each.series is not None)
    return tuple(
        SeriesInput(
            name,
            equations.inputs[name].unit,
            equations.inputs[name].meaning or "input",
            max((k for k in range(ORDERS) if ORDERS * place + k in needed), default=0),
        )
        for place, name in enumerate(names)
    )


def _drawn_numbers(store: Store, constants: Iterable[int]) -> dict[DrawnKey, int]:
    """The numbers of the drawing that `setup` needs for its constants, in the order in which they were asked for."""
    live = set(store.live([Value(store, index, 1) for index in constants]))
    return {key: index for key, index in store.drawn.items() if index in live}


def _tables(store: Store, functions: Sequence[Function]) -> dict[int, Piecewise]:
    """The tables that the functions look up, by number; a look-up is a statement of its own."""
    operations = {s.shape[0] for f in functions for s in f.statements if isinstance(s.shape, tuple)}
    numbers = {table_place(o)[0] for o in operations if isinstance(o, str) and o.startswith(TABLE)}
    return {number: store.tables[number] for number in sorted(numbers)}


def _jacobian_cost(functions: Sequence[Function]) -> float:
    """Operations of the Jacobian over those of an acceleration; library calls count ten."""
    work = {f.name: f.operations.flops + 10 * f.operations.calls for f in functions}
    passes = sum(work.get(name, 0) for name in ("constraints", "residual", "momenta"))
    once = work.get("acceleration", work.get("dynamics", work.get("system", passes)))
    return round((work.get("jacobian", 0) + work.get("inertia", 0)) / max(once, 1), 2)


def _solver_note(equations: Equations) -> str:
    if equations.closure is not None:
        rows = len(equations.closure.residual)
        return f"{len(equations.cut_joints)} loops, held by {rows} closure equations; lamc's runtime solves with them."
    if not equations.is_plain:
        return f"Accelerations by {equations.solver}; lamc's runtime solves M udot = f."
    flops = ", ".join(f"{way} {count}" for way, count in sorted(equations.solver_flops.items()))
    return f"Accelerations by {equations.solver} (operations: {flops})."


def _with_digests(program: Program) -> Program:
    text = "".join(f"{part}\n" for part in _canonical(program))
    structure = hashlib.sha256(text.encode()).hexdigest()
    return replace(
        program, structure=structure, digest=design_digest(structure, program.inputs, program.drawn)
    )


def _canonical(program: Program) -> Iterable[str]:
    """Every fact of the program but numbers of its design, as text, one line each, in a fixed order."""
    yield repr(
        (
            program.name,
            program.joints,
            program.coordinates,
            program.rates,
            program.bodies,
            program.energies,
            program.constant_count,
            program.notes,
            program.cuts,
            program.closure_count,
            program.rank,
            program.guards,
            *([program.clocks] if program.clocks else []),
            program.powers,
            *([program.columns] if program.columns else []),
            *([program.source_count] if program.source_count else []),
            program.jacobian_cost,
            [number.key for number in program.geometry],
        )
    )
    if program.pattern is not None:
        yield repr(program.pattern)
    for parameter in program.parameters:
        unnumbered = replace(parameter, default=0.0)
        yield f"{unnumbered!r} {INPUT}" if parameter.is_input else repr(unnumbered)
    for number, table in program.tables.items():
        yield f"{number} {table!r}"
    for series in program.series:
        yield repr(series)
    for function in program.functions.values():
        yield from canonical(function)
