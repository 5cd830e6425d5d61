"""Tapes of runs: every accepted step and every event, from which gradients are taken on the way back.

In: a model with pullbacks, and the rows that a run writes. Out: entries as C wrote them, and for each row how many
there were before it. Never: changes a step; interprets an entry.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from lamc.basics.errors import RequestError, SimulationError
from lamc.run.model import Model, Motion
from lamc.run.request import Array, Request

if TYPE_CHECKING:
    from lamc.run.simulator import Simulator
    from lamc.symbolic.staging import DrawnKey

CHUNK = 2**18  # numbers in a chunk of entries, 2 MiB
MOST = 2**28  # numbers of a tape, 2 GiB: some 10^6 steps of ten hinges


@dataclass(eq=False)
class Tape:
    """The way of one run.

    motion      with pullbacks, as the run began with it; keys: of its numbers of the drawing
    simulator, parameters  whose run it is, and what it was given
    request     what was asked for
    chunks      entries, as C has them, and how many count
    at          (m,): for each row of the run the number of entries before it
    """

    motion: Motion
    keys: "tuple[DrawnKey, ...]"
    simulator: "Simulator"
    parameters: Mapping[str, float | str]
    request: Request | None = None
    chunks: list[tuple[Array, int]] = field(default_factory=list)
    at: npt.NDArray[np.int64] = field(default_factory=lambda: np.zeros(0, dtype=np.int64))

    def emptied(self) -> "Tape":
        """For another run of the same."""
        return Tape(self.motion, self.keys, self.simulator, self.parameters)


def check_taped(integrator: str, is_more: bool, baumgarte: float) -> None:
    """Raises RequestError for runs that leave no tape."""
    if integrator.startswith("scipy:"):
        raise RequestError(f"integrator {integrator!r} leaves no tape; use one of lamc's own, such as 'auto'")
    if is_more:
        raise RequestError(
            "a taped run keeps no energy balance, has no accuracy and no sensitivities; run it once more for them"
        )
    if baumgarte != 0.0:
        raise RequestError("a run with baumgarte= leaves no tape; leave it out, or take sensitivities")


def tape_of(simulator: "Simulator", parameters: Mapping[str, float | str]) -> Tape:
    """An empty tape."""
    model, keys = simulator.with_pullbacks
    return Tape(model.motion(parameters), keys, simulator, dict(parameters))


class TapedRun:
    """A `lamc_taped`: a run that leaves a tape, as `native` drives runs."""

    lost = None

    def __init__(self, model: Model, rows: Any, tape: Tape) -> None:
        self._model, self._lib, self.rows, self._tape = model, model.lib, rows, tape
        self._handle: Any = model.ffi.new("lamc_taped *")
        self._record: Any = model.ffi.new("lamc_tape *")
        self._size = int(self._lib.lamc_tape_entry_size(model.handle))
        self._margin = int(self._lib.lamc_tape_margin())
        self._arrays: list[Array] = []
        self._counts: list[int] = []
        self._at: list[tuple[Any, npt.NDArray[np.int64]]] = []

    @property
    def run(self) -> Any:
        return self._handle.run

    def start(self, motion: Any, *given: Any) -> int:
        return int(self._lib.lamc_taped_start(self._handle, motion, *given))

    def advance(self, budget: int) -> int:
        record, handle = self._record, self.rows.handle
        if not self._arrays or record.capacity - record.count < self._margin:
            self._grow()
        if not self._at or self._at[-1][0] != handle:
            self._at.append((handle, np.empty(int(handle.capacity), dtype=np.int64)))
        at = self._model.ffi.from_buffer("long long[]", self._at[-1][1], require_writable=True)
        status = int(
            self._lib.lamc_taped_advance(self._handle, record, handle, at, budget, self._model.ffi.NULL)
        )
        if self._handle.overflow:
            raise SimulationError(
                "a step left more events than a tape has room for; please report this as a bug"
            )
        return status

    def _grow(self) -> None:
        if self._arrays:
            self._counts.append(int(self._record.count))
        if sum(array.size for array in self._arrays) > MOST:
            raise SimulationError(
                f"the tape of this run, at t = {float(self.run.t):.6g} s, takes more than "
                f"{MOST * 8 / 2**30:.0f} GiB; run shorter, or with a larger rtol, or take sensitivities"
            )
        capacity = max(CHUNK // self._size, 4 * self._margin)
        self._arrays.append(np.empty((capacity, self._size)))
        self._record.entries = self._model.write(self._arrays[-1].reshape(-1))
        self._record.capacity, self._record.count = capacity, 0

    def close(self) -> None:
        """Puts what there is into the tape."""
        counts = [*self._counts, int(self._record.count)]
        self._tape.chunks = list(zip(self._arrays, counts, strict=True)) if self._arrays else []
        parts = [at[: int(handle.count)] for handle, at in self._at]
        self._tape.at = np.concatenate(parts) if parts else np.zeros(0, dtype=np.int64)
