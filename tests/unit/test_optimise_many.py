"""Optimisation of many numbers: slopes by runs backwards, against differences of runs, and what is said of the end."""

import numpy as np
import pytest

import lamc
from lamc.examples import path
from lamc.studies import derivatives, search, strategy, verdict
from lamc.studies.optimisers import local
from lamc.studies.problem import Problem
from lamc.studies.search import Search, search_of

GOAL = "(max(left) - 20 deg)^2 + (last(right) / 2)^2"
VARY = {"left.stiffness": "log:5e-4:5e-3", "right.stiffness": (5e-4, 5e-3), "angles.left": (-0.1, 0.1)}


def patched(patch: pytest.MonkeyPatch) -> None:
    for module in (derivatives, search, strategy, local):
        patch.setattr(module, "MANY", 2)


@pytest.fixture
def few_are_many(monkeypatch: pytest.MonkeyPatch) -> None:
    patched(monkeypatch)


def problem_of(found: Search) -> Problem:
    trier = found._trier()
    made = Problem(found.space, found.goals, found.constraints, trier.row, found.max_runs)
    made.slopes_at = trier.slopes
    return made


def flaps(**given: object) -> Search:
    design = lamc.load(path("flaps"))
    run = search.RunOptions(t_end=0.5, rtol=1e-11, atol=1e-13)
    return search_of(design, VARY, given.pop("goal", GOAL), given.pop("subject_to", ()), run=run)


def test_slopes_are_those_of_differences(few_are_many: None, monkeypatch: pytest.MonkeyPatch) -> None:
    """What differences of two points leave out falls with the square of their distance: from 2.7e-6 to 1.7e-7 of a
    slope here. Below, the noise of runs shows."""
    monkeypatch.setattr(derivatives, "COARSE", 2.5e-5)
    problem = problem_of(flaps(subject_to=["max(right) + last(left) * 2 < 60 deg"]))
    places = np.array([0.4, 0.6, 0.3])
    problem.at(places)
    problem.at(np.array([0.5, 0.5, 0.5]))
    problem.settle_sizes()
    edges = problem.space.real
    before = len(problem.trials)
    exact = derivatives.gradients(problem, places, edges)
    assert len(problem.trials) == before  # no run of another place
    problem.slopes_at = lambda _: None
    for found, expected in zip(exact, derivatives.gradients(problem, places, edges), strict=True):
        # As scipy's SLSQP reads them, in version 1.17, whatever their strides say
        assert found.flags.c_contiguous
        assert expected.flags.c_contiguous
        assert np.abs(found - expected).max() <= 1e-6 * np.abs(expected).max()


@pytest.mark.slow
def test_many_numbers_are_walked_by_few_runs() -> None:
    """To where the same method leads by differences of runs, of which it takes hundreds."""
    design = lamc.load(path("flaps"))
    asked = {"t_end": 0.5, "starts": 1, "workers": 1}
    usual = lamc.optimise(design, VARY, GOAL, method="slsqp", **asked)
    with pytest.MonkeyPatch.context() as patch:
        patched(patch)
        best = lamc.optimise(design, VARY, GOAL, **asked)
    assert best.converged, best.message
    assert best.method == "slsqp"
    assert "whether the value bends upwards is not looked at" in best.message
    assert best.value == pytest.approx(usual.value, rel=1e-6)  # flat there: slopes of 1e-4 leave less
    assert len(best.problem.trials) < 30 < len(usual.problem.trials)


def test_functions_are_differentiated_by_runs(few_are_many: None) -> None:
    problem = problem_of(flaps(goal=lambda result: float(result.angle("left")[-1])))
    places = np.array([0.4, 0.6, 0.3])
    problem.at(places)
    gradient, _ = derivatives.gradients(problem, places, problem.space.real)
    assert np.all(gradient != 0.0)
    assert len(problem.trials) == 7  # two beside it for each
    assert verdict.verdict_of_many(problem, places).converged is False


def at_a_constraint_that_it_should_leave(goal: str) -> tuple[Problem, np.ndarray]:
    """Held where it is by a bound on its own goal, which is lower elsewhere."""
    places = np.array([0.4, 0.6, 0.3])
    here = problem_of(flaps(goal=goal)).at(places).goals[0]
    problem = problem_of(flaps(goal=goal, subject_to=[f"{goal} < {here!r} rad"]))
    for edge in range(3):
        for place in (0.0, 1.0):
            problem.at(np.where(np.arange(3) == edge, place, places))
    problem.at(places)
    problem.settle_sizes()
    return problem, places


def test_a_constraint_that_pulls_the_wrong_way_holds_nothing(few_are_many: None) -> None:
    problem, places = at_a_constraint_that_it_should_leave("max(left)")
    assert not verdict.verdict_of_many(problem, places).converged


def test_nothing_converges_where_points_beside_make_no_run(
    few_are_many: None, monkeypatch: pytest.MonkeyPatch
) -> None:
    problem, places = at_a_constraint_that_it_should_leave("max(left)")
    problem.slopes_at = lambda _: None
    monkeypatch.setattr(derivatives, "_along", lambda *_: (np.zeros(0), np.zeros((0, 2))))
    found = verdict.verdict_of_many(problem, places)
    assert not found.converged
    assert "make no run" in found.message
