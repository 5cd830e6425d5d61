"""Processor times of a ledger where the clock counts in coarse steps, as some systems' do."""

import time

import pytest

from lamc.ledger.clock import processor_seconds, shortest


def test_a_job_within_a_tick_of_the_clock_takes_a_time_to_divide_by(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(time, "process_time", lambda: 1.0)
    assert processor_seconds(lambda: None) > 0.0
    (best, turns), *_ = shortest([lambda: None], [processor_seconds(lambda: None)], 0.01)
    assert best > 0.0
    assert turns > 1
