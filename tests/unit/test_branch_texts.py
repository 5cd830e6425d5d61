"""What is told of the branches of sheets of many joints: by which joints they differ, and no round-off."""

import re

import numpy as np
import pytest

from lamc.loops.branches import Branch
from lamc.loops.texts import listed, pushed_note, telling
from lamc.report.loops_text import branch_lines

COUNT = 40
NOISE = 1e-13 * np.random.default_rng(5).normal(size=COUNT)


def branch(**rates: float) -> Branch:
    """All joints but those given are at rest, but for round-off."""
    return Branch({f"E{k}": rates.get(f"E{k}", float(NOISE[k])) for k in range(COUNT)})


SOME = (branch(E30=1.0, E12=0.25), branch(E31=1.0, E12=0.25), branch(E30=1.0, E12=0.25, E39=0.125))


@pytest.mark.parametrize("text", [listed(SOME), pushed_note(1, SOME)])
def test_branches_are_told_by_the_joints_in_which_they_differ(text: str) -> None:
    told = re.findall(r"\(([^)]*)\)", text)
    assert told == [
        "E30 1, E39 0, E31 0, E12 0.25, …",
        "E30 0, E39 0, E31 1, E12 0.25, …",
        "E30 1, E39 0.125, E31 0, E12 0.25, …",
    ]


def test_of_one_branch_the_joints_that_move_most_come_first() -> None:
    one = branch(E5=-0.5, E20=1.0, E30=0.001)
    assert telling([one], 8) == ["E20", "E5", "E30"]


def test_only_what_is_above_round_off_moves() -> None:
    lines = branch_lines(SOME)
    assert [line.split(": ")[1] for line in lines[1:]] == [
        "E12 +0.25, E30 +1",
        "E12 +0.25, E31 +1",
        "E12 +0.25, E30 +1, E39 +0.125",
    ]
    many = [
        branch(**{f"E{k}": 0.01 * k for k in range(1, 35)}, E39=1.0),
        branch(**{f"E{k}": 0.01 * k for k in range(1, 35)}, E38=1.0),
    ]
    first, second = branch_lines(many)[1:]
    assert first.startswith("  branch 1: E39 +1, E34 +0.34, E33 +0.33")
    assert second.startswith("  branch 2: E38 +1, E34 +0.34, E33 +0.33")
    assert first.endswith("… (35 joints move)")
