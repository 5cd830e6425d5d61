"""The gradient of a number that a run gives, by as many parameters as there are: a discrete adjoint.

In: a taped result, and what the number weighs each row with: derivatives by its state, by poses and by energies. Out:
derivatives by parameters, dimensions of the design, angles and rates of the start. The way back along the tape costs
some evaluations for each stage of the run, however many names there are; each name costs a product, a dimension what
`sensitivities` takes for it. Never: integrates anew; leaves a derivative out in silence.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from lamc.basics.errors import RequestError, SimulationError
from lamc.basics.readonly import ReadOnlyDict
from lamc.run.derivatives import ANGLES, RATES
from lamc.run.following import Recorded
from lamc.run.request import Array
from lamc.run.sensitivities import WHY, checked_names, pace_of
from lamc.run.start_slopes import slope_of_start
from lamc.run.taping import Tape

if TYPE_CHECKING:
    from lamc.run.result import Result

IMPACT = 5
_TICKS = "there is no derivative by {!r}: it moves the times at which a servo samples"
REASONS = {**WHY, IMPACT: "an impact drives others within the instant"}


@dataclass(frozen=True)
class Gradient(Mapping[str, float]):
    """Derivatives of a measure by names, in its unit over the SI unit of each.

    value    of the measure, in `unit`
    """

    value: float
    unit: str
    derivatives: Mapping[str, float] = field(default_factory=lambda: ReadOnlyDict({}))

    def __getitem__(self, name: str) -> float:
        return self.derivatives[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self.derivatives)

    def __len__(self) -> int:
        return len(self.derivatives)


@dataclass(frozen=True, eq=False)
class Weights:
    """What a number weighs the rows of a run with: its derivatives by them.

    states    (m, nq + nu)
    poses     (m, bodies, 12), by those of moving bodies; None: it asks for none
    energies  (m, energies); None: it asks for none
    positions (m,) each, by positions of bodies and points, by name, which a dimension moves beside the motion
    """

    states: Array
    poses: Array | None = None
    energies: Array | None = None
    positions: Mapping[str, Array] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class Pulled:
    """Derivatives of a number of a run.

    inputs  (inputs,): by what `setup` is given, parameters, then numbers of the drawing
    start   (nq + nu,): by the state where the run begins
    """

    inputs: Array
    start: Array


def pulled_back(result: "Result", weights: Weights) -> Pulled:
    """The way back. Raises RequestError for a result without a tape, SimulationError where there is no gradient."""
    tape = checked_tape(result)
    model, motion = tape.motion.model, tape.motion
    ffi, lib = model.ffi, model.lib
    pullbacks = lib.lamc_this_pullbacks()
    t, y = np.ascontiguousarray(result.t), np.ascontiguousarray(result.y.T)
    seeds = np.array(weights.states, dtype=np.float64, order="C")
    work = np.zeros(max(int(lib.lamc_adjoint_work_size(model.handle, pullbacks)), 1))
    adjoint: Any = ffi.new("lamc_adjoint *")
    at = ffi.from_buffer("long long[]", tape.at)
    kept = [
        None if each is None else np.ascontiguousarray(each) for each in (weights.poses, weights.energies)
    ]
    outputs = [ffi.NULL if each is None else model.read(each) for each in kept]
    recorded = _recorded(tape)
    with motion.opened() as handle:
        if recorded is not None:
            handle.recording = recorded.handle
        rows = (model.read(t), model.read(y), at, model.read(seeds), len(t))
        lib.lamc_adjoint_start(adjoint, handle, pullbacks, *rows, result.stats.rtol, model.write(work))
        if any(each is not None for each in kept):
            lib.lamc_adjoint_outputs(
                adjoint, len(t), model.read(t), model.read(y), *outputs, model.write(seeds)
            )
        _back(tape, adjoint, result)
    state = np.array([adjoint.state[i] for i in range(model.state_size)])
    inputs = np.zeros(max(len(motion.parameters), 1))
    pullbacks.setup(model.read(motion.constants), adjoint.sources, model.write(inputs))
    found = Pulled(inputs, state)
    if not (np.isfinite(inputs).all() and np.isfinite(state).all()):
        raise SimulationError("there is no gradient: derivatives grow beyond all numbers")
    return found


def _recorded(tape: Tape) -> Recorded | None:
    """What inputs follow, with the breaks at which steps ended."""
    following, request = tape.motion.following, tape.request
    if not following.series or request is None:
        return None
    breaks = following.breaks(request.rtol, request.t_start, request.t_end)
    return Recorded(tape.motion.model.ffi, following, breaks)


def _back(tape: Tape, adjoint: Any, result: "Result") -> None:
    model = tape.motion.model
    record: Any = model.ffi.new("lamc_tape *")
    first = sum(count for _, count in tape.chunks)
    for entries, count in reversed(tape.chunks):
        first -= count
        record.entries = model.write(entries.reshape(-1))
        record.capacity, record.count = len(entries), count
        model.lib.lamc_adjoint_back(adjoint, record, first)
        if adjoint.lost:
            guard = f" ({model.guards[adjoint.lost_guard]!r})" if adjoint.lost_guard >= 0 else ""
            raise SimulationError(
                f"there is no gradient: at t = {float(adjoint.t_lost):.9g} s, {REASONS[int(adjoint.lost)]}{guard}"
            )
    start = np.ascontiguousarray(tape.request.y0) if tape.request else result.y[:, 0].copy()
    model.lib.lamc_adjoint_end(adjoint, 0.0, model.read(start))


def _ticking(tape: Tape, result: "Result") -> npt.NDArray[np.bool_]:
    """(inputs,): which of what `setup` is given move the times at which clocks sample."""
    model, motion = tape.motion.model, tape.motion
    found = np.zeros(max(len(motion.parameters), 1), dtype=bool)
    pullbacks = model.lib.lamc_this_pullbacks()
    clocks, held = int(model.handle.clock_count), int(model.handle.held_count)
    start, nq = np.ascontiguousarray(result.y[:, 0]), len(model.coordinates)
    for clock in range(clocks):
        weights = np.zeros(clocks + held)
        weights[clock] = 1.0
        out, inputs = np.zeros(model.state_size + int(pullbacks.source_count) + held), np.zeros(len(found))
        place = (0.0, model.read(start[:nq]), model.read(start[nq:]))
        pullbacks.samples(model.read(motion.constants), *place, model.read(weights), model.write(out))
        pullbacks.setup(
            model.read(motion.constants), model.read(out[model.state_size :]), model.write(inputs)
        )
        found |= inputs != 0.0
    return found


def checked_tape(result: "Result") -> Tape:
    if result.tape is None:
        raise RequestError(result.tape_lost or "the run was not taped: run it with taped=True")
    if not result.success:
        raise SimulationError(f"there is no gradient of a run that did not reach its end: {result.message}")
    return result.tape


def by_names(result: "Result", names: Sequence[str] | None, pulled: Pulled) -> dict[str, float]:
    """Derivatives by names, SI; None: by all parameters of the model but times at which servos sample. Of dimensions
    without what they do to outputs beside the motion (`moved_beside`)."""
    tape = checked_tape(result)
    simulator, model = tape.simulator, tape.motion.model
    ticking = _ticking(tape, result)
    silent = {name for name, moves in zip(model.parameters, ticking, strict=False) if moves}
    usual = tuple(name for name in model.parameters if name not in silent)
    asked = usual if names is None else checked_names(simulator, names, "names")
    place = {name: k for k, name in enumerate(model.parameters)}
    given = [place[name] for name in tape.parameters if name in place]
    found: dict[str, float] = {}
    for name in asked:
        if name in silent:
            raise RequestError(_TICKS.format(name))
        if name in place:
            found[name] = float(pulled.inputs[place[name]])
        elif name.startswith((ANGLES, RATES)):
            found[name] = float(pulled.start @ slope_of_start(simulator, name))
        else:
            pace = pace_of(simulator, name, lambda each: each.with_pullbacks)
            inputs = pace.inputs.copy()
            inputs[given] = 0.0  # what is given does not follow from the drawing
            if np.any(ticking[: len(inputs)] & (inputs != 0.0)):
                raise RequestError(_TICKS.format(name))
            found[name] = float(pulled.inputs[: len(inputs)] @ inputs + pulled.start @ pace.start)
    return found
