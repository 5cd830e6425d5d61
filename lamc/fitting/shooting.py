"""Multiple shooting: a run in pieces, each with a start of its own, which in the end meet.

In: a predictor, how many pieces. Out: an optimum of what one run would have, found where one run finds no way: in a
chaotic motion, which forgets its start, or a long one. The starts of pieces are unknowns, and gaps between pieces are
residuals that count ever more, until there are none (Bock 1987; gaps as penalties: Horbelt, Timmer & Voss 2002, Phys.
Lett. A 299, 513-521). At the end the starts of pieces are eliminated: intervals are those of the numbers alone.
"""

from dataclasses import dataclass, replace

import numpy as np

from lamc.basics.errors import DesignError, LamcError, RequestError
from lamc.fitting.begins import angle_and_rate
from lamc.fitting.charts import Chart
from lamc.fitting.flights import Task
from lamc.fitting.objective import NOTHING, Objective
from lamc.fitting.pieces import Pieces
from lamc.fitting.predictions import Prediction, Predictor
from lamc.fitting.recorded import Run
from lamc.fitting.solve import Solved, box_of
from lamc.fitting.trust import Box, Local, local_of, minimise
from lamc.run.request import Array

GROWTH = 20.0  # of a start's change within a piece: differences that large are still nearly linear
MOST = 100  # pieces
_GAPS = (1e-1, 1e-2, 1e-4, 1e-6)  # of the size of a state: what counts as one standard deviation of a gap
_CLOSED = 1e-4  # of the size of a state: gaps that are told
_MOST_NUMBERS = 5e7  # 400 MB, of which a few copies are held
_GAIN, _CHANGE = 1e-8, 1e-10  # of the cost and of sizes, as in `solve`


@dataclass(eq=False)
class _Penalised:
    """Residuals and their Jacobian by (inner, numbers of all pieces)."""

    objective: Objective
    pieces: Pieces
    sizes: list[Array]  # (n,) by recording
    gap: float = 1.0

    def split(self, z: Array) -> Array:
        """Hands their numbers to the pieces; the solver's vector of the fit's own."""
        p = len(z) - self.pieces.width
        at = p
        for k, each in enumerate(self.pieces.numbers):
            self.pieces.numbers[k] = z[at : at + each.size].reshape(each.shape)
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
        pieces = self.pieces
        return [
            (end - begin) / size
            for end, begin, size in zip(pieces.ends, pieces.begins, self.sizes, strict=True)
        ]

    def _residual(self, inner: Array, found: list[Prediction]) -> Array:
        gaps = [each.ravel() / self.gap for each in self.gaps()]
        return np.concatenate([self.objective.residual(inner, found), *gaps])

    def _jacobian(self, inner: Array, found: list[Prediction]) -> Array:
        by_number, by_state = self.objective.jacobians(inner, found)
        unknowns = self.objective.predictor.setting.unknowns
        rates = unknowns.rates(inner)
        rows = [np.hstack([by_number, by_state])]
        for which, (slopes, size) in enumerate(zip(self.pieces.gap_slopes, self.sizes, strict=True)):
            movers = self.objective.predictor.movers(which)
            row = np.zeros((*slopes.shape[:2], len(inner) + self.pieces.width))
            for place, column in movers.items():
                row[:, :, place] = slopes[:, :, column] * rates[place]
            row[:, :, len(inner) :] = slopes[:, :, len(movers) :]
            rows.append((row / (self.gap * size)[:, None]).reshape(-1, row.shape[2]))
        return np.concatenate(rows)


def shoot(
    objective: Objective, begin: Array, count: int | None, max_steps: int = 60
) -> tuple[Solved, Pieces]:
    """The best fit that pieces lead to, and the pieces; its objective is that of one run through them.

    count: of pieces; None: as many as the motion asks for. Raises RequestError where states cannot be chosen freely.
    """
    predictor = objective.predictor
    pieces = _cut(predictor, begin, count)
    _check_size(pieces, [len(run.times) for run in predictor.setting.runs])
    parted = Objective(Predictor(predictor.setting, pieces), objective.sigmas)
    sizes = [_size_of(each) for each in pieces.begins]
    problem = _Penalised(parted, pieces, sizes)
    numbers, wide = box_of(predictor.setting.unknowns), np.full(pieces.width, np.inf)
    by_state = [
        size[chart.places] for size, charts in zip(sizes, pieces.charts, strict=True) for chart in charts
    ]
    box = Box(
        np.append(numbers.low, -wide),
        np.append(numbers.high, wide),
        np.concatenate([numbers.sizes, *by_state]),
    )
    z = np.concatenate([begin, *(each.ravel() for each in pieces.numbers)])
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


def _check_size(pieces: Pieces, rows: list[int]) -> None:
    """Raises RequestError for derivatives of rows by pieces that no memory should be asked for."""
    most = max(count * each.shape[1] for count, each in zip(rows, pieces.begins, strict=True)) * pieces.width
    if most > _MOST_NUMBERS:
        raise RequestError(
            f"{max(rows)} rows in {pieces.width} numbers of pieces have {most:.2g} derivatives, more than "
            f"{_MOST_NUMBERS:.0g}; leave rows out (every tenth often tells as much), or take fewer segments"
        )


def _half(residual: Array) -> float:
    return 0.5 * float(residual @ residual)


def growth(predictor: Predictor, begin: Array) -> list[float]:
    """By recording: how much larger than at its start a change of it becomes, at most."""
    at = predictor.numbers(predictor.setting.unknowns.values(begin))
    found = []
    for which in range(len(predictor.setting.runs)):
        task = predictor.task(which, at, sloped=False)
        motion = task.simulator.model.motion(task.parameters)
        chart = Chart.around(motion, task.y0)
        basis = chart.slopes(motion, task.y0)
        reaches = np.ones(basis.shape[1])
        flight = predictor.runs.sensitive(replace(task, directions=basis, reaches=reaches), fine=False)
        sizes = _size_of(flight.rows)
        scaled = flight.slopes / sizes[:, None] * sizes[chart.places] if not flight.message else np.zeros(1)
        found.append(float(np.max(np.abs(scaled))))
    return found


def _cut(predictor: Predictor, begin: Array, count: int | None) -> Pieces:
    """Where pieces begin, evenly in time, and the states there: as the columns have them, else as the run has them."""
    setting = predictor.setting
    simulator = setting.simulators.usual
    if len(simulator.coordinates) > len(simulator.joints):
        raise RequestError(
            "multiple shooting takes starts of pieces that are free to choose, and effects add coordinates to this "
            "model; fit shorter recordings, each with its own start"
        )
    at = predictor.numbers(setting.unknowns.values(begin))
    grown = growth(predictor, begin) if count is None else []
    edges, charts, numbers = [], [], []
    for which, run in enumerate(setting.runs):
        pieces = count or int(np.clip(np.ceil(np.log(max(grown[which], 1.0)) / np.log(GROWTH)) * 3, 8, MOST))
        task = predictor.task(which, at, sloped=False)
        end = float(task.times[-1])
        inner = np.linspace(task.t_start, end, pieces + 1)[1:-1]
        flight = predictor.runs.flight(replace(task, times=np.append(inner, end)))
        rows = flight.rows[:-1] if not flight.message else np.tile(task.y0, (len(inner), 1))
        delay = at.get(f"{run.name}.delay", run.numbers[f"{run.name}.delay"])
        begun = _begun(run, task, rows, inner, delay)
        edges.append(inner)
        charts.append(begun)
        numbers.append(np.array([chart.near[chart.places] for chart in begun]).reshape(len(inner), -1))
    return Pieces(predictor.runs, edges, charts, numbers)


def _begun(run: Run, task: Task, rows: Array, inner: Array, delay: float) -> list[Chart]:
    """Charts of where pieces begin, at times (s,): as the columns have it, else as rows (s, n) of the run have. What
    loops make of the others follows from piece to piece, so that all count the same turns and stand on one branch."""
    simulator, motion = task.simulator, task.simulator.model.motion(task.parameters)
    nu = len(simulator.coordinates)
    told = [
        _as_recorded(run, simulator.joints, y, float(t) + delay) for y, t in zip(rows, inner, strict=True)
    ]
    recorded = [j for j, joint in enumerate(simulator.joints) if joint in run.recording.values]
    if not simulator.cut_joints:
        return [Chart(y, tuple(range(nu))) for y in told]
    found: list[Chart] = []
    chart = Chart.around(motion, task.y0, recorded)
    for y, as_run in zip(told, rows, strict=True):
        try:
            near = chart.state(motion, y[chart.places])
        except DesignError:  # of columns that are off by more than the mechanism reaches
            near = as_run
        chart = Chart.around(motion, near, recorded)
        found.append(chart)
    return found


def _as_recorded(run: Run, joints: tuple[str, ...], y: Array, time: float) -> Array:
    """A state (n,), in which what columns tell at a time of their clock is as they have it."""
    found = y.copy()
    for j, joint in enumerate(joints):
        for kind, place in (("angle", j), ("rate", len(y) // 2 + j)):
            guess = angle_and_rate(run.recording, joint, kind, time)
            found[place] = found[place] if guess is None else guess
    return found


def _size_of(states: Array) -> Array:
    """(n,): what counts as one of each coordinate and rate."""
    n = states.shape[1] // 2
    root = np.sqrt(np.mean(states**2, axis=0))
    return np.append(np.maximum(root[:n], 1.0), np.maximum(root[n:], 1.0))
