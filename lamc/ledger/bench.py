"""`measure`: what generated C gains over symbolic evaluation, on one design.

In: a mechanism and a scene. Out: a `Bench`, a row for each way to evaluate the same staged equations: sympy's subs
and evalf, lambdified numpy, lamc's interpreter, the generated C. All evaluate at the same state and are compared
there; a way that gives other numbers is an error, not a row. With loops every way but the C leaves the solve to numpy.
It prints nothing; the compiler's cache is left alone.
"""

import math
import platform
import tempfile
import time
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import sympy as sp

from lamc.basics._version import __version__
from lamc.basics.errors import SimulationError, UnsupportedError
from lamc.basics.times import Times
from lamc.codegen.build import build
from lamc.codegen.cache import Cache
from lamc.codegen.options import CompileOptions
from lamc.codegen.toolchain import find_compiler
from lamc.pipeline import effects_of, equations_of, sources_of
from lamc.records.mechanism import Array, Mechanism
from lamc.records.scene import Scene
from lamc.reference.integrate import simulate
from lamc.reference.interpreter import Interpreter
from lamc.reference.staged import StagedValues
from lamc.run.following import series_of
from lamc.run.simulator import Simulator

if TYPE_CHECKING:
    from lamc.mechanics.equations import Equations

RTOL, ATOL = 1e-6, 1e-9
_SPAN = 1.0  # s of simulated time
_LONG_ENOUGH = 0.2  # s that one timing lasts at least, where calls are short
_PATIENCE = 4.0  # s; a simulated second that would take longer is extrapolated
# Largest difference of two ways, relative to the largest acceleration: sympy orders sums as it likes.
_SAME = 1e-8

# What a reader of the table should know where there are loops.
_LOOPS = (
    "Loops: u̇ is numpy's solution of M, f, J and γ, and in the C its own; the flops are without either.",
    "Left out: sympy's KanesMethod, which takes independent closure equations only, chosen by hand.",
)

Evaluation = Callable[[Array, Array, float], Array]
Observer = Callable[[str], None]


@dataclass(frozen=True)
class Row:
    """One way. Times in seconds, but for the evaluation.

    prints       from equations to something that can be evaluated or compiled
    compiles     by a C compiler; None where there is none
    evaluation   ns per right-hand side
    second       per simulated second, RK45 at rtol 1e-6
    extrapolated `second` is a product: evaluations times the time of one
    flops        operations of one right-hand side, without calls of sin and cos
    """

    name: str
    derive: float
    prints: float
    compiles: float | None
    evaluation: float
    second: float
    extrapolated: bool
    flops: int


@dataclass(frozen=True)
class Bench:
    """All rows of one design, slowest first."""

    design: str
    hinges: int
    effects: tuple[str, ...]
    evaluations: int  # of the right-hand side in one simulated second, by the generated C
    rows: tuple[Row, ...]
    compiler: str
    flags: tuple[str, ...]
    notes: tuple[str, ...] = ()

    def to_dict(self) -> dict[str, Any]:
        """Plain data for JSON, with machine and versions."""
        return {
            **asdict(self),
            "machine": platform.machine(),
            "python": platform.python_version(),
            "sympy": sp.__version__,
            "numpy": np.__version__,
            "lamc": __version__,
            "rtol": RTOL,
            "atol": ATOL,
        }


def measure(mechanism: Mechanism, scene: Scene, options: CompileOptions, observer: Observer) -> Bench:
    """Times every way. Raises LamcError as `lamc.compile` does, and SimulationError if two ways disagree."""
    if series := series_of(scene):
        raise UnsupportedError(
            f"the bench compares evaluations with numbers for inputs, and the input {next(iter(series))!r} follows a "
            "series; give it a number"
        )
    times = Times(observer=observer)
    effects = effects_of(mechanism, scene)
    equations = equations_of(mechanism, effects, times, inputs=scene.inputs)
    program, tree = sources_of(equations, times)
    derive = times.seconds["plan"] + times.seconds["derive"]
    compiler = find_compiler(options.compiler, flags=options.flags)
    with tempfile.TemporaryDirectory(prefix="lamc-bench-") as folder:
        with times.stage("compile"):
            _, module, _ = build(tree, program.structure, compiler, options, Cache(Path(folder) / "cache"))
        simulator = Simulator(mechanism, scene, effects, equations, program, module)
        bench = _Measuring(simulator, equations, derive, observer)
        emitting = times.seconds["lower"] + times.seconds["emit"]
        rows = (
            bench.symbolic(),
            bench.lambdified(),
            bench.interpreted(times.seconds["lower"]),
            bench.generated(emitting, times.seconds["compile"]),
        )
    return Bench(
        design=mechanism.name,
        hinges=len(simulator.joints),
        effects=tuple(effect.name for effect in effects),
        evaluations=bench.evaluations,
        rows=rows,
        compiler=module.compiler,
        flags=module.flags,
        notes=_LOOPS if equations.closure is not None else (),
    )


class _Measuring:
    """The state at which all ways are compared, and how each is timed."""

    def __init__(
        self, simulator: Simulator, equations: "Equations", derive: float, observer: Observer
    ) -> None:
        self.simulator, self.equations, self.derive, self.observer = simulator, equations, derive, observer
        observer("generated C")
        self.t_eval = np.linspace(0.0, _SPAN, 11)
        result = simulator.run(_SPAN, RTOL, ATOL, self.t_eval, "rk45")
        if not result.success:
            raise SimulationError(f"there is nothing to measure: {result.message}")
        self.evaluations = result.nfev
        self.start = np.concatenate([result.q[0], result.u[0]])
        self.t, self.q, self.u = float(result.t[5]), result.q[5], result.u[5]
        self.expected = simulator.acceleration(self.q, self.u, self.t)
        started = time.perf_counter()
        assignments = equations.assignments
        self.values = StagedValues(equations)
        self.staging = time.perf_counter() - started
        self.staged_flops = sum(int(sp.count_ops(a.expression, visual=False)) for a in assignments)

    def symbolic(self) -> Row:
        """subs and evalf, statement by statement: one evaluation, since one takes long."""
        self.observer("sympy subs and evalf")
        assignments = self.equations.assignments
        inputs = {
            sp.Symbol(name): sp.Float(value, 17)
            for name, value in self._inputs(self.q, self.u, self.t).items()
        }

        def evaluate() -> Array:
            known = dict(inputs)
            for a in assignments:
                wanted = {s: known[s] for s in a.expression.free_symbols}
                known[a.symbol] = a.expression.subs(wanted).evalf(17)
            return self.values.acceleration(
                np.array([float(known[sp.Symbol(name)]) for name in self.values.names])
            )

        started = time.perf_counter()
        found = evaluate()
        seconds = time.perf_counter() - started
        self._compare("sympy subs + evalf", found)
        return self._row(
            "sympy subs + evalf",
            self.staging,
            None,
            seconds,
            self.evaluations * seconds,
            True,
            self.staged_flops,
        )

    def lambdified(self) -> Row:
        """sympy.lambdify of the staged equations, statement by statement, on numpy."""
        self.observer("lambdified numpy")
        started = time.perf_counter()
        function = lambdified(self.equations)
        prints = self.staging + time.perf_counter() - started
        parameters = [float(p.default) for p in self.equations.parameters]

        def evaluate(q: Array, u: Array, t: float) -> Array:
            return self.values.acceleration(np.array(function(t, q, u, parameters), dtype=float))

        return self._python_row("lambdified numpy", evaluate, prints, self.staged_flops)

    def interpreted(self, lower: float) -> Row:
        """lamc's interpreter of the program."""
        self.observer("interpreter")
        started = time.perf_counter()
        interpreter = Interpreter(self.simulator.program)
        constants = interpreter.constants()
        prints = lower + time.perf_counter() - started

        def evaluate(q: Array, u: Array, t: float) -> Array:
            return interpreter.acceleration(t, q, u, constants)

        return self._python_row("interpreter", evaluate, prints, self._flops())

    def generated(self, prints: float, compiles: float) -> Row:
        """The generated C, called from C as the integrator does, a thousand states at a time."""
        self.observer("generated C")
        states = 1000
        q, u = np.tile(self.q, (states, 1)), np.tile(self.u, (states, 1))
        evaluation = _seconds(lambda: self.simulator.acceleration(q, u, self.t)) / states
        second = _seconds(lambda: self.simulator.run(_SPAN, RTOL, ATOL, self.t_eval, "rk45")) / _SPAN
        return self._row("generated C", prints, compiles, evaluation, second, False, self._flops())

    def _python_row(self, name: str, evaluate: Evaluation, prints: float, flops: int) -> Row:
        self._compare(name, evaluate(self.q, self.u, self.t))
        evaluation = _seconds(lambda: evaluate(self.q, self.u, self.t))
        second, extrapolated = self.evaluations * evaluation, True
        if (
            second < _PATIENCE and not self.values.is_closed
        ):  # runs of loops need their steps settled on closure
            started = time.perf_counter()
            simulate(evaluate, self.start, self.simulator.joints, self.t_eval, RTOL, ATOL)
            second, extrapolated = (time.perf_counter() - started) / _SPAN, False
        return self._row(name, prints, None, evaluation, second, extrapolated, flops)

    def _row(
        self,
        name: str,
        prints: float,
        compiles: float | None,
        seconds: float,
        second: float,
        guess: bool,
        flops: int,
    ) -> Row:
        return Row(name, self.derive, prints, compiles, seconds * 1e9, second, guess, flops)

    def _flops(self) -> int:
        return self.simulator.program.motion_operations.flops

    def _inputs(self, q: Array, u: Array, t: float) -> Mapping[str, float]:
        joints = self.simulator.joints
        values = {p.name: float(p.default) for p in self.equations.parameters} | {"t": t}
        values |= {f"q_{joint}": float(q[k]) for k, joint in enumerate(joints)}
        return values | {f"u_{joint}": float(u[k]) for k, joint in enumerate(joints)}

    def _compare(self, name: str, found: Array) -> None:
        size = float(np.abs(self.expected).max(initial=0.0)) or 1.0
        gap = float(np.abs(found - self.expected).max(initial=0.0)) / size
        if not gap <= _SAME:
            raise SimulationError(f"{name} and the generated C differ by {gap:.1e}; `lamc check` shows where")


def _seconds(work: Callable[[], object]) -> float:
    """Seconds per call: the best of three turns, each of enough calls to be measured."""
    work()
    started = time.perf_counter()
    work()
    once = max(time.perf_counter() - started, 1e-9)
    calls = max(1, math.ceil(_LONG_ENOUGH / 3 / once))
    best = math.inf
    for _ in range(3):
        started = time.perf_counter()
        for _ in range(calls):
            work()
        best = min(best, (time.perf_counter() - started) / calls)
    return best


def lambdified(equations: "Equations") -> Callable[..., Any]:
    """function(t, q, u, parameters) → the values that `StagedValues` names, by sympy.lambdify on numpy.

    The stages are handed over as lambdify's common subexpressions, which is the form that suits it best.
    """
    joints = equations.joints
    q = [sp.Symbol(f"q{k}") for k in range(len(joints))]
    u = [sp.Symbol(f"u{k}") for k in range(len(joints))]
    p = [sp.Symbol(f"p{k}") for k in range(len(equations.parameters))]
    plain = {sp.Symbol(f"q_{joint}"): symbol for joint, symbol in zip(joints, q, strict=True)}
    plain |= {sp.Symbol(f"u_{joint}"): symbol for joint, symbol in zip(joints, u, strict=True)}
    plain |= {sp.Symbol(each.name): symbol for each, symbol in zip(equations.parameters, p, strict=True)}
    stages = [(a.symbol, a.expression.xreplace(plain)) for a in equations.assignments]
    names = StagedValues(equations).names
    last = {str(symbol): expression for symbol, expression in stages if str(symbol) in set(names)}
    inner = [stage for stage in stages if str(stage[0]) not in last]
    outputs = [last[name] for name in names]
    function: Callable[..., Any] = sp.lambdify(
        [sp.Symbol("t"), q, u, p], outputs, modules="numpy", cse=lambda _: (inner, outputs)
    )
    return function
