"""`lamc.optimise` by several processes: the same runs, in the same order, to the last bit."""

import pickle
import threading

import numpy as np
import pytest

import lamc
from lamc.studies.bench import ERROR, RunOptions
from lamc.studies.crew import Crew
from lamc.studies.goals import goal_of
from lamc.studies.measures import Outputs
from lamc.studies.search import Search, search_of
from lamc.studies.trier import Tried
from tests.support import studied
from tests.support.ctools import needs_cc

pytestmark = needs_cc

RUN = RunOptions(t_end=0.05, rtol=1e-9, atol=1e-11, rows=11)
VARY = {"length": (0.05, 0.34), "hip.stiffness": (1e-3, 1e-1)}
GOAL = "rms(hip - 0.3)"


def search(method: str, starts: int = 3, most: int = 400, goal: object = GOAL, vary: object = VARY) -> Search:
    found = search_of(studied.rod, vary, goal, run=RUN)  # type: ignore[arg-type]
    return found.asked(method, None, starts, 3, most)


def runs(of: Search, workers: int) -> list[tuple[object, ...]]:
    best = of.run(None, workers, alone=0.0)
    return [
        (
            t.point,
            t.status,
            t.goals,
            t.stage,
            t.structure,
            None if t.residual is None else t.residual.tobytes(),
        )
        for t in best.problem.trials
    ]


@pytest.mark.parametrize("method", ["least-squares", "slsqp", "nelder-mead", "evolution", "cma-es"])
@pytest.mark.slow
@pytest.mark.ci("nelder-mead", "evolution")
def test_runs_do_not_depend_on_how_many_processes_made_them(method: str) -> None:
    if method == "cma-es":
        pytest.importorskip("cma")
    one, three = (runs(search(method), workers) for workers in (1, 3))
    assert len(one) > 40
    assert one == three


@pytest.mark.slow
def test_a_front_does_not_depend_on_it() -> None:
    pytest.importorskip("pymoo")
    goals = [GOAL, "max(abs(hip.rate))"]
    one, two = (search("auto", most=200, goal=goals).run(None, n, alone=0.0) for n in (1, 2))
    assert one.on_front == two.on_front
    assert [t.point for t in one.problem.trials] == [t.point for t in two.problem.trials]


@pytest.mark.slow
def test_starts_are_gone_through_side_by_side_and_few_runs_are_left_to_this_process(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """All that the methods ask for from each start was answered before."""
    here: list[str] = []
    of = search("nelder-mead", starts=3)
    whole = Search.run

    from lamc.studies.trier import Trier

    row = Trier.row

    def told(self: Trier, index: int, point: tuple[float, ...]) -> Tried:
        here.append("run")
        return row(self, index, point)

    monkeypatch.setattr(Trier, "row", told)
    best = whole(of, None, 2, alone=0.0)
    stages = [trial.stage for trial in best.problem.trials]
    assert sum(stage.startswith("start ") for stage in stages) > 60
    assert len(here) < 0.3 * len(stages)  # the start, and what nothing can be asked ahead of


@pytest.mark.slow
def test_a_folder_goes_on_with_other_workers(tmp_path) -> None:  # type: ignore[no-untyped-def]
    whole = search("evolution", most=150)
    short = search("evolution", most=60)
    assert whole.manifest() == short.manifest()
    short.run(tmp_path, 2, alone=0.0)
    again = whole.run(tmp_path, 1, resume=True)
    alone = whole.run(None, 1)
    assert [t.point for t in again.problem.trials] == [t.point for t in alone.problem.trials]


@pytest.mark.slow
def test_runs_are_not_more_than_granted() -> None:
    best = search("slsqp", most=30).run(None, 2, alone=0.0)
    assert best.runs == 30
    assert "after 30 runs" in best.message


def test_what_cannot_travel_is_the_work_of_one() -> None:
    of = search_of(studied.rod, VARY, lambda result: result.angle("hip")[-1], run=RUN)
    assert of.workers(None) == 1
    with pytest.raises(lamc.RequestError, match=r"cannot be given to other processes.*take workers=1"):
        of.workers(2)
    assert of.workers(1) == 1


@pytest.mark.slow
def test_functions_that_fail_are_trials_wherever_they_ran() -> None:
    of = search_of(studied.rod, VARY, studied.broken, run=RUN).asked("slsqp", None, 1, 0, 200)
    with pytest.raises(lamc.SimulationError, match=r"error \(\d+\): ZeroDivisionError: of the user's"):
        of.run(None, 2, alone=0.0)


def test_a_goal_travels_with_its_squares() -> None:
    goal = goal_of("rms(h - 3 deg)", Outputs({"h": "rad", "t": "s"}))
    again = pickle.loads(pickle.dumps(goal))
    assert (again.text, again.unit, again.is_root, len(again.parts)) == (goal.text, "rad", True, 1)


@pytest.mark.slow
def test_a_crew_answers_many_who_ask_and_a_process_that_dies_costs_one_point() -> None:
    of = search_of(studied.rod, {"hip.stiffness": (1.0, 4.0)}, studied.deadly, run=RUN)
    trier = of._trier()
    crew = Crew(pickle.dumps(trier), trier.width, 2)
    try:
        found: dict[int, list[str]] = {}

        def ask(who: int) -> None:
            found[who] = [row.status for row in crew.rows([(1.0 + who,), (2.0,), (3.5,)])]

        threads = [threading.Thread(target=ask, args=(k,)) for k in range(3)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join(timeout=60.0)
        assert found == {
            0: ["ok", "died", "ok"],
            1: ["died", "died", "ok"],
            2: ["ok", "died", "ok"],
        }
    finally:
        crew.stop()
    with pytest.raises(lamc.SimulationError, match="stopped"):
        crew.rows([(1.0,)])


def test_a_residual_comes_back_with_its_row() -> None:
    trier = search("least-squares")._trier()
    own = trier.row(0, (0.2, 0.01))
    crew = Crew(pickle.dumps(trier), trier.width, 1)
    try:
        (row,) = crew.rows([(0.2, 0.01)])
    finally:
        crew.stop()
    assert isinstance(row, Tried)
    assert row.status != ERROR
    assert row.residual is not None
    assert own.residual is not None
    assert np.array_equal(row.residual, own.residual)
