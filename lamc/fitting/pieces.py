"""Runs in pieces, each with a start of its own, and how all of it follows from these starts.

In: tasks, charts of the states where pieces begin, numbers in these charts. Out: flights, where pieces end and begin,
and slopes of both. A piece begins where loops close, whatever its numbers are. Never: closes the gaps between pieces.
"""

from dataclasses import replace

import numpy as np

from lamc.fitting.charts import Chart
from lamc.fitting.drawn import Drawn
from lamc.fitting.flights import Flight, Runs, Task
from lamc.run.request import Array


class Pieces:
    """edges: by recording, (s,) s, where pieces begin behind the first; charts: of the states there; numbers: (s, 2f)
    in them.

    begins, ends: (s, n) by recording: where pieces begin, and where those before end. condensed: whether slopes are
    those of one run through all pieces; else columns behind those of a task are by the numbers of pieces, in the order
    of recordings and pieces.
    """

    forgets = False  # where pieces begin is no part of a task

    def __init__(
        self, runs: Runs, edges: list[Array], charts: list[list[Chart]], numbers: list[Array]
    ) -> None:
        self._runs, self.edges, self.charts, self.numbers = runs, edges, charts, numbers
        self.condensed = False
        self.begins = [np.array([chart.near for chart in each]) for each in charts]
        self.ends = [each.copy() for each in self.begins]
        self.gap_slopes: list[Array] = [
            np.zeros((0, 0, 0)) for _ in charts
        ]  # of ends less begins, (s, n, width)

    @property
    def count(self) -> int:
        """Runs of pieces, told as of whole ones."""
        return self._runs.count // max(1, max(len(each) for each in self.edges) + 1)

    @property
    def derivatives_by(self) -> str:
        return self._runs.derivatives_by

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
        """Columns by numbers of pieces."""
        return sum(each.size for each in self.numbers)

    def flight(self, task: Task) -> Flight:
        return self._flown(task, sloped=False, fine=False)

    def sensitive(self, task: Task, *, fine: bool) -> Flight:
        return self._flown(task, sloped=True, fine=fine)

    def _flown(self, task: Task, *, sloped: bool, fine: bool) -> Flight:
        which, n = task.which, len(task.y0)
        edges = self.edges[which]
        own = task.numbers + task.directions.shape[1]
        width = 0 if not sloped else own + (0 if self.condensed else self.width)
        rows, slopes = np.full((len(task.times), n), np.nan), np.zeros((len(task.times), n, width))
        self.gap_slopes[which] = np.zeros((len(edges), n, width))
        begun = np.zeros((n, width))  # how the start of a piece follows from the columns
        carried = begun  # how the end of the piece before does
        motion = task.simulator.model.motion(task.parameters)
        for k in range(len(edges) + 1):
            begin = task.t_start if k == 0 else float(edges[k - 1])
            until = float(edges[k]) if k < len(edges) else np.inf
            mine = (task.times >= begin) & (task.times < until) if k else task.times < until
            times = np.unique(np.append(task.times[mine], until if k < len(edges) else []))
            part = replace(task, times=times)
            if k:
                chart, x = self.charts[which][k - 1], self.numbers[which][k - 1]
                y0 = self.begins[which][k - 1] = chart.state(motion, x)
                basis = chart.slopes(motion, y0) if sloped else np.zeros((n, 0))
                drawn = {name: _begun(each, chart, task, x) for name, each in task.drawn.items()}
                part = replace(
                    part, y0=y0, t_start=begin, drawn=drawn, directions=basis, reaches=np.ones(basis.shape[1])
                )
                if sloped:
                    by_chart = self._by_chart(task, k - 1, carried, width)
                    begun = basis @ by_chart
                    for column, each in enumerate(drawn.values(), len(task.sizes)):
                        begun[:, column] += each.start
                    self.gap_slopes[which][k - 1] -= begun
            if not len(times):
                continue
            found = self._runs.sensitive(part, fine=fine) if sloped else self._runs.flight(part)
            if found.message:
                return Flight(motion, rows, np.zeros((*rows.shape, 0)), found.message)
            at = np.searchsorted(times, task.times[mine])
            rows[mine] = found.rows[at]
            by = np.zeros((len(times), n, width))
            if sloped:
                by[:, :, : task.numbers] = found.slopes[:, :, : task.numbers]
                turned = by_chart if k else np.eye(task.directions.shape[1], width, task.numbers)
                by += found.slopes[:, :, task.numbers :] @ turned
            slopes[mine] = by[at]
            if k < len(edges):
                self.ends[which][k] = found.rows[-1]
                self.gap_slopes[which][k] += by[-1]
                carried = by[-1]
        return Flight(motion, rows, slopes)

    def _by_chart(self, task: Task, k: int, carried: Array, width: int) -> Array:
        """How the numbers (2f,) of the start behind edge k follow from the columns: (2f, width)."""
        places = self.charts[task.which][k].places
        if self.condensed:
            return np.asarray(carried[places])
        first = task.numbers + task.directions.shape[1]
        first += sum(each.size for each in self.numbers[: task.which]) + k * len(places)
        return np.eye(len(places), width, first)


def _begun(drawn: Drawn, chart: Chart, task: Task, x: Array) -> Drawn:
    """A dimension, of runs that start at numbers x of a chart: the other coordinates follow from the drawing."""
    motions = [each.model.motion(task.parameters) for each in drawn.simulators]
    return replace(drawn, starts=np.stack([chart.state(motion, x) for motion in motions]))
