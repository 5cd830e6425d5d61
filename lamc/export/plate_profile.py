"""How large an exported plate may be, and the ordering that keeps the factors of its matrix short.

In: a mesh, a matrix. Out: an ordering, or a refusal that says which length of edges would do. Never: values.

The ordering is the reversed one of E. Cuthill and J. McKee, Proc. 24th Nat. Conf. ACM, 1969.
"""

import math

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import reverse_cuthill_mckee

from lamc.basics.errors import ExportError
from lamc.plates.meshing.mesh import Integers
from lamc.plates.problem import Problem

MOST_CELLS = 20_000  # beyond it the C is longer than some 10 MB, which compilers take many seconds over
MOST_PROFILE = 8_000_000  # numbers of the factored matrix: 64 MB of the caller's memory
_SPARE = 1.03  # longer edges than it takes: meshes of other edges have some more cells


def profile_of(matrix: sp.csc_array) -> tuple[Integers, Integers]:
    """Rows in a new order, and where each begins among all entries from its first to its diagonal."""
    order = reverse_cuthill_mckee(sp.csr_matrix(matrix), symmetric_mode=True).astype(np.int32)
    place = np.empty_like(order)
    place[order] = np.arange(len(order), dtype=np.int32)
    columns = place[matrix.indices]
    first = np.minimum.reduceat(columns, matrix.indptr[:-1])[order]
    lengths = np.arange(len(order), dtype=np.int64) - first + 1
    return order, np.concatenate([[0], np.cumsum(lengths)])


def check_cells(problem: Problem) -> None:
    """Raises ExportError where the mesh has too many cells."""
    count = len(problem.mesh.cells)
    if count > MOST_CELLS:
        raise ExportError(
            f"the mesh has {count} cells; {MOST_CELLS} at most are exported as tables in C: {_coarser(problem)}"
        )


def check_profile(problem: Problem, entries: int) -> None:
    """Raises ExportError where the factors have too many `entries`."""
    if entries > MOST_PROFILE:
        raise ExportError(
            f"the factored matrix has {entries} entries within its profile, {8e-6 * entries:.0f} MB; {MOST_PROFILE} at "
            f"most are exported: {_coarser(problem, entries)}"
        )


def _coarser(problem: Problem, entries: int | None = None) -> str:
    """The way out: edges so long that both limits are kept. Cells are as 1/edge², entries of the profile as 1/edge³."""
    mesh = problem.mesh
    entries = _guessed(problem) if entries is None else entries
    longer = max(math.sqrt(len(mesh.cells) / MOST_CELLS), (entries / MOST_PROFILE) ** (1 / 3))
    # Of the edges along x or y where most are, as in a grid: that is what --size counts there.
    along = np.abs(np.diff(mesh.points[mesh.edges], axis=1)[:, 0])
    edge = float(np.median(np.hypot(*along.T)))
    size = _rounded_up(edge * longer * _SPARE)
    return (
        f"mesh coarser, by --size '{1000 * size:g} mm', by size: or grid: in the file's geometry, or in Python by "
        f"edge_length={size:g} or a Problem of such a mesh"
    )


def _guessed(problem: Problem) -> int:
    """Entries of the profile by the ordering of the mesh's points, as many unknowns at each as there are on average."""
    mesh = problem.mesh
    ones = np.ones(len(mesh.edges), dtype=np.int8)
    lower = sp.coo_array((ones, mesh.edges.T), shape=(len(mesh.points),) * 2)
    both = sp.csc_array(lower + lower.T + sp.eye_array(len(mesh.points), dtype=np.int8))
    return int(profile_of(both)[1][-1] * (problem.dofs.count / len(mesh.points)) ** 2)


def _rounded_up(length: float) -> float:
    """To two digits."""
    step = 10.0 ** (math.floor(math.log10(length)) - 1)
    return round(math.ceil(length / step) * step, 12)
