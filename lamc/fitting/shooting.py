"""Multiple shooting: a run in pieces, each with a start of its own, which in the end meet.

In: a predictor, how many pieces. Out: an optimum of what one run would have, found where one run finds no way: in a
chaotic motion, which forgets its start, or a long one. The starts of pieces are unknowns, and gaps between pieces are
residuals that count ever more, until there are none (Bock 1987; gaps as penalties: Horbelt, Timmer & Voss 2002, Phys.
Lett. A 299, 513-521). At the end the starts of pieces are eliminated: intervals are those of the numbers alone.
"""

from dataclasses import dataclass, replace

import numpy as np

from lamc.basics.errors import LamcError, RequestError
from lamc.fitting.begins import angle_and_rate
from lamc.fitting.flights import Flight, Runs, Task
from lamc.fitting.objective import NOTHING, Objective
from lamc.fitting.predictions import Prediction, Predictor
from lamc.fitting.solve import Solved, box_of
from lamc.fitting.trust import Box, Local, local_of, minimise
from lamc.run.request import Array

GROWTH = 20.0  # of a start's change within a piece: differences that large are still nearly linear
MOST = 100  # pieces
_GAPS = (1e-1, 1e-2, 1e-4, 1e-6)  # of the size of a state: what counts as one standard deviation of a gap
_CLOSED = 1e-4  # of the size of a state: gaps that are told
_GAIN, _CHANGE = 1e-8, 1e-10  # of the cost and of sizes, as in `solve`


class Pieces:
    """Runs in pieces. edges: by recording, (s,) s, where pieces begin behind the first; states: (s, n) there.

    condensed: whether slopes are those of one run through all pieces; else columns behind those of a task are by the
    states of pieces, in the order of recordings and pieces.
    """

    forgets = False  # where pieces begin is no part of a task

    def __init__(self, runs: Runs, edges: list[Array], states: list[Array]) -> None:
        self._runs, self.edges, self.states = runs, edges, states
        self.condensed = False
        self.ends: list[Array] = [np.zeros_like(each) for each in states]  # where the piece before each ends
        self.end_slopes: list[Array] = [np.zeros((0, 0, 0)) for _ in states]

    @property
    def count(self) -> int:
        """Runs of pieces, told as of whole ones."""
        return self._runs.count // max(1, max(len(each) for each in self.edges) + 1)

    @property
    def told(self) -> str:
        return self._runs.told

    @property
    def known_to(self) -> float:
        return self._runs.known_to

    @property
    def notes(self) -> list[str]:
        return self._runs.notes

    @property
    def at_once(self) -> bool:
        return self._runs.at_once

    @property
    def width(self) -> int:
        """Columns by states of pieces."""
        return sum(each.size for each in self.states)

    def flight(self, task: Task) -> Flight:
        return self._flown(task, sloped=False, fine=False)

    def sensitive(self, task: Task, *, fine: bool) -> Flight:
        return self._flown(task, sloped=True, fine=fine)

    def _flown(self, task: Task, *, sloped: bool, fine: bool) -> Flight:
        edges, n = self.edges[task.which], len(task.y0)
        own = task.numbers + task.directions.shape[1]
        width = 0 if not sloped else own + (0 if self.condensed else self.width)
        rows, slopes = np.full((len(task.times), n), np.nan), np.zeros((len(task.times), n, width))
        self.end_slopes[task.which] = np.zeros((len(edges), n, width))
        carried = np.zeros((n, own))  # how the start of a piece follows from the task's columns, condensed
        if sloped:
            starts = [each.start[:, None] for each in task.drawn.values()]
            carried = np.hstack([np.zeros((n, len(task.sizes))), *starts, task.directions])
        motion = None
        for k in range(len(edges) + 1):
            begin = task.t_start if k == 0 else float(edges[k - 1])
            until = float(edges[k]) if k < len(edges) else np.inf
            mine = (task.times >= begin) & (task.times < until) if k else task.times < until
            times = np.unique(np.append(task.times[mine], until if k < len(edges) else []))
            if not len(times):
                continue
            part = self._part(task, k, begin, times)
            found = self._runs.sensitive(part, fine=fine) if sloped else self._runs.flight(part)
            motion = found.motion
            if found.message:
                return Flight(motion, rows, np.zeros((*rows.shape, 0)), found.message)
            at = np.searchsorted(times, task.times[mine])
            rows[mine] = found.rows[at]
            by = self._by(task, k, found, carried, width) if sloped else np.zeros((len(times), n, 0))
            slopes[mine] = by[at]
            if k < len(edges):
                self.ends[task.which][k] = found.rows[-1]
                self.end_slopes[task.which][k] = by[-1]
                carried = by[-1] if sloped and self.condensed else carried
        assert motion is not None
        return Flight(motion, rows, slopes)

    def _part(self, task: Task, k: int, begin: float, times: Array) -> Task:
        """The task of one piece."""
        if k == 0 and not self.condensed:
            return replace(task, times=times)
        n = len(task.y0)
        y0 = task.y0 if k == 0 else self.states[task.which][k - 1]
        drawn = {name: each.begun_at(y0) for name, each in task.drawn.items()}
        return replace(
            task, y0=y0, t_start=begin, times=times, drawn=drawn, directions=np.eye(n), reaches=np.ones(n)
        )

    def _by(self, task: Task, k: int, found: Flight, carried: Array, width: int) -> Array:
        """Slopes (m, n, width) of a piece."""
        p, n = task.numbers, len(task.y0)
        by = np.zeros((*found.rows.shape, width))
        if self.condensed:
            by += np.einsum("mns,se->mne", found.slopes[:, :, p:], carried)
            by[:, :, :p] += found.slopes[:, :, :p]
            return by
        if k == 0:
            by[:, :, : found.slopes.shape[2]] = found.slopes
            return by
        first = (
            p + task.directions.shape[1] + sum(each.size for each in self.states[: task.which]) + (k - 1) * n
        )
        by[:, :, :p] = found.slopes[:, :, :p]
        by[:, :, first : first + n] = found.slopes[:, :, p:]
        return by


@dataclass(eq=False)
class _Penalised:
    """Residuals and their Jacobian by (inner, states of all pieces)."""

    objective: Objective
    pieces: Pieces
    sizes: list[Array]  # (n,) by recording
    gap: float = 1.0

    def split(self, z: Array) -> Array:
        """Hands the states to the pieces; the solver's vector of the numbers."""
        p = len(z) - self.pieces.width
        at = p
        for k, each in enumerate(self.pieces.states):
            self.pieces.states[k] = z[at : at + each.size].reshape(each.shape)
            at += each.size
        return z[:p]

    @property
    def known_to(self) -> float:
        return self.pieces.known_to

    @property
    def at_once(self) -> bool:
        return self.objective.predictor.at_once

    def cost(self, z: Array) -> float:
        inner = self.split(z)
        found = self.objective.tried(inner, sloped=False)
        return np.inf if found is None else _half(self._residual(inner, found))

    def local(self, z: Array) -> Local:
        inner = self.split(z)
        found = self.objective.tried(inner, sloped=True)
        if found is None:
            return NOTHING
        residual = self._residual(inner, found)
        return local_of(_half(residual), residual, self._jacobian(inner, found))

    def gaps(self) -> list[Array]:
        """By recording, (s, n): where pieces end less where the next begin, by the size of a state."""
        return [
            (end - state) / size
            for end, state, size in zip(self.pieces.ends, self.pieces.states, self.sizes, strict=True)
        ]

    def _residual(self, inner: Array, found: list[Prediction]) -> Array:
        gaps = [each.ravel() / self.gap for each in self.gaps()]
        return np.concatenate([self.objective.residual(inner, found), *gaps])

    def _jacobian(self, inner: Array, found: list[Prediction]) -> Array:
        by_number, by_state = self.objective.jacobians(inner, found)
        width = len(inner) + self.pieces.width
        unknowns = self.objective.predictor.setting.unknowns
        rates = unknowns.rates(inner)
        rows = []
        first = 0
        for which, (states, size) in enumerate(zip(self.pieces.states, self.sizes, strict=True)):
            movers = self.objective.predictor.movers(which)
            slopes = self.pieces.end_slopes[which]
            for k in range(len(states)):
                row = np.zeros((states.shape[1], width))
                for place, column in movers.items():
                    row[:, place] = slopes[k][:, column] * rates[place]
                row[:, len(inner) :] = slopes[k][:, len(movers) :]
                at = len(inner) + first + k * states.shape[1]
                row[:, at : at + states.shape[1]] -= np.eye(states.shape[1])
                rows.append(row / (self.gap * size)[:, None])
            first += states.size
        return np.concatenate([np.hstack([by_number, by_state]), *rows])


def shoot(
    objective: Objective, begin: Array, count: int | None, max_steps: int = 60
) -> tuple[Solved, Pieces]:
    """The best fit that pieces lead to, and the pieces; its objective is that of one run through them.

    count: of pieces; None: as many as the motion asks for. Raises RequestError where states cannot be chosen freely.
    """
    predictor = objective.predictor
    pieces = _cut(predictor, begin, count)
    parted = Objective(Predictor(predictor.setting, pieces), objective.sigmas)
    sizes = [_size_of(each) for each in pieces.states]
    problem = _Penalised(parted, pieces, sizes)
    numbers, wide = box_of(predictor.setting.unknowns), np.full(pieces.width, np.inf)
    by_state = [np.tile(size, len(each)) for size, each in zip(sizes, pieces.states, strict=True)]
    box = Box(
        np.append(numbers.low, -wide),
        np.append(numbers.high, wide),
        np.concatenate([numbers.sizes, *by_state]),
    )
    z = np.concatenate([begin, *(each.ravel() for each in pieces.states)])
    steps, message, ended = 0, "steps and gains vanish", False
    for gap in _GAPS:
        problem.gap = gap
        try:
            found = minimise(problem, z, box, _GAIN, _CHANGE, max_steps)
        except LamcError as error:
            message = error.message
            break
        z, ended = found.x, found.converged
        steps += found.steps
    inner = problem.split(z)
    parted.tried(inner, sloped=False)
    widest = max((float(np.abs(each).max(initial=0.0)) for each in problem.gaps()), default=0.0)
    whole = max(len(each) for each in pieces.edges) + 1
    notes = [f"found by multiple shooting, in {whole} pieces; a run through all of it forgets its start"]
    if not widest < _CLOSED:
        ended, message = False, f"pieces do not meet: gaps of {widest:.2g} of a state's size are left"
    pieces.condensed = True
    final = Objective(parted.predictor, objective.sigmas)
    through = final.tried(inner, sloped=False)
    cost = np.inf if through is None else _half(final.residual(inner, through))
    return Solved(inner, cost, ended, message, final, tuple(notes), steps), pieces


def _half(residual: Array) -> float:
    return 0.5 * float(residual @ residual)


def growth(predictor: Predictor, begin: Array) -> list[float]:
    """By recording: how much larger than at its start a change of it becomes, at most."""
    at = predictor.numbers(predictor.setting.unknowns.values(begin))
    found = []
    for which in range(len(predictor.setting.runs)):
        task = predictor.task(which, at, sloped=False)
        n = len(task.y0)
        flight = predictor.runs.sensitive(replace(task, directions=np.eye(n), reaches=np.ones(n)), fine=False)
        sizes = _size_of(flight.rows)
        scaled = flight.slopes / sizes[:, None] * sizes if not flight.message else np.zeros((1, n, n))
        found.append(float(np.max(np.abs(scaled))))
    return found


def _cut(predictor: Predictor, begin: Array, count: int | None) -> Pieces:
    """Where pieces begin, evenly in time, and the states there: as the columns have them, else as the run has them."""
    setting = predictor.setting
    simulator = setting.simulators.usual
    if simulator.cut_joints or len(simulator.coordinates) > len(simulator.joints):
        raise RequestError(
            "multiple shooting takes starts of pieces that are free to choose, and this model has loops, or "
            "coordinates "
            "that effects add; fit shorter recordings, each with its own start"
        )
    at = predictor.numbers(setting.unknowns.values(begin))
    grown = growth(predictor, begin) if count is None else []
    edges, states = [], []
    for which, run in enumerate(setting.runs):
        pieces = count or int(np.clip(np.ceil(np.log(max(grown[which], 1.0)) / np.log(GROWTH)) * 3, 8, MOST))
        task = predictor.task(which, at, sloped=False)
        end = float(task.times[-1])
        inner = np.linspace(task.t_start, end, pieces + 1)[1:-1]
        flight = predictor.runs.flight(replace(task, times=np.append(inner, end)))
        rows = np.nan_to_num(flight.rows[:-1])
        delay = at.get(f"{run.name}.delay", run.numbers[f"{run.name}.delay"])
        for k, time in enumerate(inner):
            for j, joint in enumerate(simulator.joints):
                for kind, place in (("angle", j), ("rate", len(simulator.coordinates) + j)):
                    guess = angle_and_rate(run.recording, joint, kind, float(time) + delay)
                    rows[k, place] = rows[k, place] if guess is None else guess
        edges.append(inner)
        states.append(rows)
    return Pieces(predictor.runs, edges, states)


def _size_of(states: Array) -> Array:
    """(n,): what counts as one of each coordinate and rate."""
    n = states.shape[1] // 2
    root = np.sqrt(np.mean(states**2, axis=0))
    return np.append(np.maximum(root[:n], 1.0), np.maximum(root[n:], 1.0))
