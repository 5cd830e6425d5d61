"""Runs that end after so much counted work of their loops, wherever and whenever they run."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import lamc
from lamc.basics.errors import RequestError
from lamc.run.defaults import ATOL, RTOL
from lamc.run.length import LOOSE, LOOSE_ATOL, TRIAL, Length, length_of
from lamc.run.request import Status
from tests.support import fold_corpus
from tests.support.ctools import needs_cc
from tests.support.mechanisms import chain

pytestmark = needs_cc


@pytest.fixture(scope="module")
def sheet(tmp_path_factory: pytest.TempPathFactory) -> lamc.Simulator:
    path = fold_corpus.write(tmp_path_factory.mktemp("sheet") / "sheet.fold", fold_corpus.miura(4, 4))
    return lamc.compile(lamc.load(path, card=lamc.Card(), crease=1e-3))


def test_twice_the_work_goes_farther_and_as_much_ends_alike(sheet: lamc.Simulator) -> None:
    less, same, more = (sheet.run(10.0, max_work=work) for work in (1e6, 1e6, 2e6))
    assert (less.t == same.t).all()
    assert (less.q == same.q).all()
    assert less.t[-1] < more.t[-1] < 10.0
    for result in (less, more):
        assert result.status == Status.STEP_LIMIT
        assert "max_work" in result.message
        assert "steps were tried" not in result.message
    # What goes on is the same motion: its steps are those of the shorter run, but for the last of it.
    assert (more.t[: len(less.t) - 1] == less.t[:-1]).all()


@pytest.mark.slow
def test_rows_and_the_energy_balance_change_nothing_of_where_it_ends(sheet: lamc.Simulator) -> None:
    """They are evaluated between steps, and settled there, which is work that the motion does not need."""
    plain = sheet.run(10.0, max_work=1e6)
    rows = sheet.run(10.0, max_work=1e6, t_eval=np.linspace(0.0, float(plain.t[-1]), 301))
    balanced = sheet.run(10.0, max_work=1e6, energy_balance=True)
    assert plain.status == rows.status == balanced.status == Status.STEP_LIMIT
    assert plain.t[-1] == rows.t[-1] == balanced.t[-1]
    both = sheet.run(10.0, max_work=1e6, energy_balance=True, sensitivities=[f"{sheet.joints[0]}.stiffness"])
    assert both.t[-1] == plain.t[-1]


def test_a_run_to_an_accuracy_has_no_limit(sheet: lamc.Simulator) -> None:
    assert sheet.run(1e-3, accuracy=1e-2, max_work=1.0).success


def test_a_tree_has_no_such_work() -> None:
    result = lamc.compile(chain(2)).run(0.1, max_work=1.0)
    assert result.success


@pytest.mark.parametrize("work", [0.0, -1.0, float("nan"), "much"])
def test_work_that_is_none_is_refused(sheet: lamc.Simulator, work: object) -> None:
    with pytest.raises(RequestError, match="max_work"):
        sheet.run(1.0, max_work=work)  # type: ignore[arg-type]


def test_a_run_of_the_command_line_has_a_limit_where_nobody_says_how_long(sheet: lamc.Simulator) -> None:
    assert length_of(None, None, sheet).work is not None
    assert length_of(10.0, None, sheet).work is None
    assert length_of(None, 100, sheet).work is None


@pytest.fixture(scope="module")
def large(tmp_path_factory: pytest.TempPathFactory) -> lamc.Simulator:
    """A sheet of so many hinges that lamc says how many steps a run has."""
    path = fold_corpus.write(tmp_path_factory.mktemp("large") / "sheet.fold", fold_corpus.miura(9, 9))
    return lamc.compile(lamc.load(path, card=lamc.Card(), crease=1e-3))


@pytest.mark.slow
def test_the_remark_has_the_steps_that_were_taken(
    large: lamc.Simulator, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("lamc.run.length.MOST_WORK", 3e6)
    length = length_of(None, None, large)
    assert length.is_own
    ran = length.run(large, 0, rtol=1e-9)
    result = ran.result
    tried = result.stats.accepted + (result.stats.rejected or 0)
    assert 0 < tried < length.steps
    assert f"and {tried} steps of" in ran.remark
    assert "a looser --rtol takes longer steps" in ran.remark


def test_where_work_ends_a_run_a_looser_tolerance_is_tried_and_told(
    large: lamc.Simulator, monkeypatch: pytest.MonkeyPatch
) -> None:
    """If nobody gives one, and it gets farther by far: a sheet that is seen to fold, to six digits, in place of one
    that has hardly moved, to nine."""
    monkeypatch.setattr("lamc.run.length.MOST_WORK", 12e6)
    length = length_of(None, None, large)
    exact, ran = length.run(large, 0, rtol=1e-9).result, length.run(large, 0)
    taken = ran.result
    assert taken.stats.rtol == 1e-6
    assert taken.t[-1] > 2.0 * exact.t[-1]
    assert "at rtol 1e-06 it gets farther" in ran.remark
    monkeypatch.setattr("lamc.run.length.FARTHER", 1e6)
    assert length.run(large, 0).result.t[-1] == exact.t[-1]
    monkeypatch.setattr("lamc.run.length.MOST_WORK", 1e12)
    whole = length_of(None, None, large).run(large, 0)
    assert whole.result.stats.rtol == 1e-9  # nothing ended it before
    assert "1e-06" not in whole.remark


def test_of_a_looser_run_that_comes_to_its_end_the_tolerance_is_told(large: lamc.Simulator) -> None:
    exact = large.run(10.0, max_work=1e8)
    assert exact.status == Status.STEP_LIMIT
    end = 1.5 * float(exact.t[-1])
    for folds in (False, True):
        ran = Length(end, 4000, is_own=True, until_folded=folds, work=1e8).run(large, 0)
        assert ran.result.success
        assert ran.result.stats.rtol == 1e-6
        assert "at rtol 1e-06 it gets farther" in ran.remark
    asked = Length(end, 4000, is_own=True, work=1e8).run(large, 0, rtol=1e-6)
    assert "at rtol" not in asked.remark


def test_what_comes_to_its_end_by_all_of_the_work_is_exact(large: lamc.Simulator) -> None:
    """A quarter of the work is not enough for that, and at a looser tolerance it is."""
    exact = large.run(10.0, max_work=TRIAL * 1e8)
    assert exact.status == Status.STEP_LIMIT
    ran = Length(1.05 * float(exact.t[-1]), 4000, is_own=True, work=1e8).run(large, 0)
    assert ran.result.status == Status.REACHED_END
    assert ran.result.stats.rtol == 1e-9
    assert ran.remark == ""


def test_rows_show_what_work_ended(large: lamc.Simulator) -> None:
    """Rows over 10 s would have one of it. Where there are fewer steps than rows were asked for, they are the rows."""
    length = Length(10.0, 4000, is_own=True, work=12e6)
    each, even, few = (length.run(large, rows, rtol=1e-9).result for rows in (0, 3, 1001))
    assert 4 < each.stats.accepted < 1001
    assert len(even.t) in (3, 4)
    assert even.t[-1] == each.t[-1]
    assert (few.t == each.t).all()


class Counted:
    """A simulator that counts its runs."""

    def __init__(self, simulator: lamc.Simulator) -> None:
        self.simulator, self.runs = simulator, 0

    def __getattr__(self, name: str) -> Any:
        return getattr(self.simulator, name)

    def run(self, *given: Any, **named: Any) -> Any:
        self.runs += 1
        return self.simulator.run(*given, **named)


def test_what_few_steps_end_has_them_as_rows_and_is_run_once(
    large: lamc.Simulator, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Rows between steps are settled, each with more evaluations than a step near a singular position takes."""
    monkeypatch.setattr("lamc.run.length.STUCK", 0.0)  # it need not be seen whether it is
    counted = Counted(large)
    length = Length(10.0, 4000, is_own=True, work=12e6)
    result = length.run(counted, 1001).result  # type: ignore[arg-type]
    assert result.status == Status.STEP_LIMIT
    assert counted.runs == 3  # a part of the work at both tolerances, and all of it at one
    assert len(result.t) == result.stats.accepted + 1
    alone = large.run(10.0, max_steps=4000, max_work=12e6, rtol=result.stats.rtol, atol=result.stats.atol)
    assert result.t[-1] == alone.t[-1]


def test_rows_are_even_where_all_of_the_work_is_enough(large: lamc.Simulator) -> None:
    """Though a part of it was not, and its steps were few."""
    exact = large.run(10.0, max_work=TRIAL * 1e8)
    end = 1.05 * float(exact.t[-1])
    result = Length(end, 4000, is_own=True, work=1e8).run(large, 301).result
    assert result.status == Status.REACHED_END
    assert result.t == pytest.approx(np.linspace(0.0, end, 301))


@pytest.mark.parametrize("rows", [0, 1001])
def test_what_is_stuck_ends_after_a_part_of_the_work(
    large: lamc.Simulator, rows: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("lamc.run.length.GROWS", 1e9)  # whatever its steps are
    monkeypatch.setattr("lamc.run.length._SEEN", 2)
    length = Length(10.0, 4000, is_own=True, work=12e6)
    ran = length.run(large, rows)
    part = large.run(
        10.0, max_steps=4000, max_work=TRIAL * 12e6, rtol=ran.result.stats.rtol, atol=ran.result.stats.atol
    )
    assert ran.result.status == Status.STEP_LIMIT
    assert (ran.result.t == part.t).all()  # its steps
    turned = np.abs(part.q[-1] - part.q[0]).max()
    assert (
        f"have turned them by {turned:.1g} rad at most: it is stuck next to a singular position" in ran.remark
    )
    assert "--t-end 10" in ran.remark


class Paced:
    """A simulator whose runs have so many steps of a growth, of angles that hardly move: as those next to a singular
    position are, or as those from rest."""

    def __init__(self, simulator: lamc.Simulator, steps: int, growth: float) -> None:
        self.simulator, self.steps, self.growth = simulator, steps, growth

    def __getattr__(self, name: str) -> Any:
        return getattr(self.simulator, name)

    def run(self, *given: Any, **named: Any) -> Any:
        result = self.simulator.run(*given, **named)
        t = 1e-4 * np.concatenate(([0.0], np.cumsum(self.growth ** np.arange(self.steps))))
        q = np.repeat(result.q[:1], len(t), axis=0)
        return replace(result, t=t, q=q, u=0.0 * q, stats=replace(result.stats, accepted=self.steps))


@pytest.mark.parametrize(
    ("steps", "growth", "is_stuck"), [(40, 0.8, True), (40, 1.0, False), (1, 1.0, False), (4, 0.8, False)]
)
def test_steps_that_shrink_are_those_of_what_is_stuck(
    large: lamc.Simulator, steps: int, growth: float, is_stuck: bool
) -> None:
    """And neither as many of one length, nor a few, which are the first from rest."""
    paced = Paced(large, steps, growth)
    ran = Length(10.0, 4000, is_own=True, work=12e6).run(paced, 0)  # type: ignore[arg-type]
    assert ran.result.status == Status.STEP_LIMIT
    assert ("stuck" in ran.remark) == is_stuck


def test_what_speeds_up_is_not_stuck(large: lamc.Simulator) -> None:
    """Steps from rest begin short and grow."""
    ran = Length(10.0, 4000, is_own=True, work=12e6).run(large, 0)
    assert "stuck" not in ran.remark
    assert "as much work as a run does by itself" in ran.remark


@pytest.mark.parametrize(("interrupted", "rtol", "atol"), [(2, RTOL, ATOL), (3, LOOSE, LOOSE_ATOL)])
def test_ctrl_c_while_another_run_is_made_keeps_what_there_is(
    large: lamc.Simulator, interrupted: int, rtol: float, atol: float
) -> None:
    """Of the exact one, after a part of the work, or of the looser one, which got farther by as much."""
    kept = Length(10.0, 4000, is_own=True, work=TRIAL * 12e6).run(large, 0, rtol=rtol, atol=atol).result

    class Impatient:
        def __init__(self) -> None:
            self.calls = 0

        def __getattr__(self, name: str) -> Any:
            return getattr(large, name)

        def run(self, *given: Any, **named: Any) -> Any:
            self.calls += 1
            if self.calls == interrupted:
                raise KeyboardInterrupt
            return large.run(*given, **named)

    impatient: lamc.Simulator = Impatient()  # type: ignore[assignment]
    ran = Length(10.0, 4000, is_own=True, work=12e6).run(impatient, 0)
    assert ran.result.status == Status.CANCELLED
    assert ran.result.t[-1] == kept.t[-1]
    assert "cancelled" in ran.result.message


def test_progress_is_that_of_the_work_where_that_ends_a_run(
    sheet: lamc.Simulator, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("lamc.run.native.SLICE", 0.0)  # told after each step
    told: list[tuple[float, float]] = []
    result = sheet.run(10.0, max_work=1e6, progress=lambda t, end: told.append((t, end)))
    assert result.t[-1] < 1.0
    assert 8.0 < told[-1][0] <= 10.0 == told[-1][1]
    assert [t for t, _ in told] == sorted(t for t, _ in told)
