"""Many dense blocks as one sparse matrix, beside the same sums written one entry at a time."""

import numpy as np

from lamc.plates.solving.blocks import groups, placed, runs


def test_blocks_stand_below_each_other_at_their_own_columns() -> None:
    random = np.random.default_rng(5)
    shapes, count = [(2, 3), (0, 4), (1, 2), (3, 1)], 12
    blocks = [random.normal(size=shape) for shape in shapes]
    blocks[0][1, 2] = 0.0
    columns = np.array([7, 0, 3, 1, 2, 4, 5, 11, 6, 9])  # three, four, two and one of them
    wanted, row, first = np.zeros((6, count)), 0, 0
    for block in blocks:
        for line in block:
            for k, value in enumerate(line):
                wanted[row, columns[first + k]] = value
            row += 1
        first += block.shape[1]
    found = placed(blocks, columns, count)
    assert np.array_equal(found.toarray(), wanted)  # exactly: nothing is added up
    assert found.nnz == 10  # of 11 entries, one is zero


def test_no_blocks_have_no_rows() -> None:
    assert placed([], np.zeros(0, dtype=np.int64), 3).shape == (0, 3)


def test_runs_follow_each_other_and_may_be_empty() -> None:
    assert runs(np.array([5, 2, 9]), np.array([2, 0, 3])).tolist() == [5, 6, 9, 10, 11]


def test_groups_tell_where_each_label_stands() -> None:
    found = groups(np.array([2, 0, 2, 3, 0]), 5)
    assert [each.tolist() for each in found] == [[1, 4], [], [0, 2], [3], []]
