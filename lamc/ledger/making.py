"""Variants of a scene, made from nothing and measured: compile time, operations, time per evaluation, time per run.

In: a mechanism, scenes, compile options. Out: a `Made` for each. Compiled modules go to a cache of the ledger's own, so
that compile times mean the same for all; the runtime, which does not depend on the model, is compiled before.
"""

import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from lamc.codegen.cache import Cache
from lamc.codegen.options import CompileOptions
from lamc.ledger.clock import processor_seconds
from lamc.ledger.runners import ATOL, MOST_STEPS, uncancelled
from lamc.pipeline import compile as compile_design
from lamc.records.mechanism import Body, Joint, Mechanism
from lamc.records.scene import Scene
from lamc.run.result import Result
from lamc.run.simulator import Simulator

_STATES = 256  # evaluated in one call: few enough to stay in the cache, enough to hide the call
_TURNS = 60  # of some 0.1 ms: spread over enough time that a busy machine lets some pass undisturbed


@dataclass(frozen=True, eq=False)
class Made:
    """A simulator, and what making it took, s: wall time from mechanism to loaded module."""

    simulator: Simulator
    seconds: float

    @property
    def operations(self) -> int:
        """Flops of one evaluation: + - * and reciprocals, without sine, cosine and what the runtime solves."""
        program = self.simulator.program
        rates = program.functions["rates"].operations.flops if "rates" in program.functions else 0
        return program.motion_operations.flops + rates


class Workshop:
    """Makes variants of one mechanism. folder: of a cache of its own; None: the user's, where times mean nothing."""

    def __init__(self, mechanism: Mechanism, options: CompileOptions, folder: Path | None) -> None:
        self.mechanism, self.options = mechanism, options
        self._cache = None if folder is None else Cache(folder / "cache")
        self._ready: set[CompileOptions] = set()
        self._seconds: dict[str, float] = {}  # of the first making, by digest and flags

    def make(self, scene: Scene, options: CompileOptions | None = None) -> Made:
        """A scene that was made before is loaded, and has the time of then. Raises LamcError where the scene or the
        options cannot be compiled."""
        options = options or self.options
        if self._cache is not None and options not in self._ready:
            compile_design(_flap(), Scene(effects=()), options, cache=self._cache)
            self._ready.add(options)
        started = time.perf_counter()
        simulator = compile_design(self.mechanism, scene, options, cache=self._cache)
        key = " ".join([str(simulator.program.digest), *options.flags])
        return Made(simulator, self._seconds.setdefault(key, time.perf_counter() - started))


def _flap() -> Mechanism:
    """One link on one hinge: the least that brings the runtime into the cache."""
    link = Body("link", 1.0, np.array([1.0, 0.0, 0.0]), np.eye(3))
    hinge = Joint("h", "ground", "link", point=np.zeros(3), axis=np.array([0.0, 1.0, 0.0]))
    return Mechanism((Body("ground", fixed=True), link), (hinge,), name="flap")


def evaluation_ns(result: Result) -> float:
    """ns of processor time per evaluation of the accelerations, from C, at states of the run; the shortest of some."""
    rows = np.linspace(0, len(result.t) - 1, _STATES).astype(int)
    t, y = np.ascontiguousarray(result.t[rows]), np.hstack([result.q[rows], result.u[rows]])
    motion = result.motion
    best = min(processor_seconds(lambda: motion.accelerations(t, y)) for _ in range(_TURNS))
    return best / _STATES * 1e9


def end_run(simulator: Simulator, t_end: float, rtol: float, integrator: str) -> Callable[[], Result]:
    """The run as it is timed: the state at the end is all that is kept."""
    return lambda: uncancelled(
        simulator.run(t_end, rtol, ATOL * rtol, [t_end], integrator, max_steps=MOST_STEPS)
    )
