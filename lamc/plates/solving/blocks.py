"""Many small dense blocks as one sparse matrix, and the numbers that such work needs.

In: blocks, and the columns that each is about; labels. Out: a matrix, made at once: a sparse matrix for each block and
their stack take fifty times as long. Never: knows what the blocks are.
"""

from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from lamc.basics.checks import Array

Indices = NDArray[np.int64]


def runs(starts: Indices, counts: Indices) -> Indices:
    """start, start + 1, … for each start, `counts` of each, one after the other."""
    begins = np.cumsum(counts) - counts
    return np.asarray(np.repeat(starts - begins, counts) + np.arange(int(counts.sum())))


def groups(label: NDArray[np.integer], count: int) -> list[NDArray[Any]]:
    """For each label, 0 to `count`, where it stands, ascending."""
    order = np.argsort(label, kind="stable")
    ends = np.searchsorted(label[order], np.arange(count + 1)).tolist()
    return [order[begin:end] for begin, end in pairwise(ends)]


def placed(blocks: Sequence[Array], columns: NDArray[np.integer], count: int) -> sp.csr_array:
    """Blocks (k, s), one below the other, each at its own s of `columns` (Σs,), of `count`; zeros are left out."""
    heights, widths = np.array([block.shape for block in blocks], dtype=np.int64).reshape(-1, 2).T
    starts = np.cumsum(widths) - widths
    row_widths = np.repeat(widths, heights)
    column = columns[runs(np.repeat(starts, heights), row_widths)]
    row = np.repeat(np.arange(len(row_widths)), row_widths)
    data = np.concatenate([np.zeros(0), *(block.ravel() for block in blocks)])
    there = data != 0.0
    return sp.csr_array((data[there], (row[there], column[there])), shape=(len(row_widths), count))
