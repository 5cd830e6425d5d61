"""Assembly: against dense sums, on one pattern, to the bit; hostile unknowns; memory."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
import scipy.sparse as sps
from scipy.sparse.linalg import splu

from lamc.basics.errors import DesignError, UnsupportedError
from lamc.plates.dofs import Dofs
from lamc.plates.elements.kernels import kernels
from lamc.plates.elements.library import ELEMENTS, element
from lamc.plates.memory import available_memory, check_memory, estimate_memory
from lamc.plates.meshing.grid import grid
from lamc.plates.meshing.mesh import Mesh
from lamc.plates.solving.assembly import Assembly
from tests.support.ctools import needs_cc

pytestmark = needs_cc

Array = npt.NDArray[np.float64]
NAMES = (*sorted(ELEMENTS), "dkt+cst", "dkt+lst")  # nodes of five, and of five and two unknowns


def meshed(name: str, count: int = 5) -> Mesh:
    """A rectangle, its right half a region of its own; points and cells shuffled."""
    made = element(name)
    pattern = "one-diagonal" if made.corner_count == 3 else "squares"
    mesh = grid(2e-3, 1e-3, count, count + 1, pattern=pattern)
    rng = np.random.default_rng(7)
    order = rng.permutation(len(mesh.points))
    cells = np.argsort(order)[mesh.cells][rng.permutation(len(mesh.cells))].astype(np.int32)
    right = mesh.points[order][cells].mean(axis=1)[:, 0] > 1e-3
    return Mesh(mesh.points[order], cells, right.astype(np.int32), ("left", "right"))


def sections(name: str) -> Array:
    """Two rows of positive definite sections, as different as hinge and link."""
    made = kernels(name)
    rng = np.random.default_rng(3)
    rows = []
    for scale in (1.0, 1e-3):
        root = rng.standard_normal((made.strain_count, made.strain_count))
        full = scale * (root @ root.T)
        blocks = (
            [full] if made.strain_count == 3 else [full[:3, :3], full[:3, 3:] + full[3:, :3], full[3:, 3:]]
        )
        row = [((b + b.T) / 2)[np.triu_indices(3)] for b in blocks]
        if made.element.shear:
            row += [scale * np.array([1.0, 0.1, 1.2]), row[-1]]  # H, and D about the neutral surface
        rows.append(np.concatenate(row))
    return np.array(rows)


def dense(matrices: Array, dofs: Dofs) -> Array:
    """The textbook's sum, entry by entry."""
    total = np.zeros((dofs.count, dofs.count))
    for matrix, unknowns in zip(matrices, dofs.of_cells, strict=True):
        total[np.ix_(unknowns, unknowns)] += matrix
    return total


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.quick("[!q]*", "q4", "q8", "q9")
def test_assembled_matrices_are_the_sums_of_the_elements(name: str) -> None:
    """1e-15 of the largest entry times the cells around a node: sums in another order."""
    mesh, made = meshed(name), kernels(name)
    dofs = Dofs(mesh, made.element)
    assembly = Assembly(made, mesh, dofs)
    by_region, areal_mass = sections(name), np.array([1.5, 0.2])
    pairs = [
        (assembly.stiffness(by_region), made.stiffness(mesh.corners, by_region[mesh.regions])),
        (assembly.mass(areal_mass), made.mass(mesh.corners, areal_mass[mesh.regions])),
    ]
    if made.element.bends:
        forces = np.random.default_rng(5).standard_normal((len(mesh.cells), 3))
        pairs.append((assembly.geometric(forces), made.geometric(mesh.corners, forces)))
    for found, matrices in pairs:
        expected = dense(matrices, dofs)
        assert np.abs(found.toarray() - expected).max() <= 6e-15 * np.abs(expected).max()


@pytest.mark.parametrize("name", NAMES)
def test_matrices_share_one_pattern_that_cannot_be_written(name: str) -> None:
    mesh, made = meshed(name), kernels(name)
    assembly = Assembly(made, mesh, Dofs(mesh, made.element))
    first, second = assembly.stiffness(sections(name)), assembly.mass(np.array([1.0, 2.0]))
    assert isinstance(first, sps.csc_array)
    assert first.indices is second.indices
    assert first.indptr is second.indptr
    assert first.data is not second.data
    assert first.nnz == assembly.entry_count
    assert first.indices.dtype == first.indptr.dtype == np.int32
    fresh = sps.csc_array((first.data, first.indices.copy(), first.indptr.copy()), shape=first.shape)
    assert fresh.has_canonical_format  # looked at, not believed: ascending rows, each once
    with pytest.raises(ValueError, match="read-only"):
        first.indices[0] = 1
    # Exactly symmetric: both triangles get the same numbers in the same order.
    assert (abs(first - first.T)).max() == 0.0


def test_the_same_input_gives_the_same_bits() -> None:
    mesh, made = meshed("dkt"), kernels("dkt")
    dofs, by_region = Dofs(mesh, made.element), sections("dkt")
    once, again = (Assembly(made, mesh, dofs).stiffness(by_region) for _ in range(2))
    assert np.array_equal(once.data, again.data)
    assembly = Assembly(made, mesh, dofs)
    soft = assembly.stiffness(1e-3 * by_region)
    assert np.array_equal(assembly.stiffness(by_region).data, once.data)
    assert not np.array_equal(soft.data, once.data)


@pytest.mark.parametrize("dtype", [float, np.longdouble])
@pytest.mark.parametrize("name", NAMES)
@pytest.mark.quick("bciz-*", "cst-*", "dkt-*", "lst-*", "q4-*", "dkt+cst-*")
@pytest.mark.ci(
    "bciz-*",
    "cst-*",
    "dkt-*",
    "lst-*",
    "q4-*",
    "dkt+cst-*",
    "specht-longdouble",
    "dkmt-float",
    "q9-longdouble",
)
def test_forces_of_all_cells_are_those_of_each(name: str, dtype: type) -> None:
    """Round-off of sums over the cells around a node, in the precision asked for."""
    mesh, made = meshed(name), kernels(name)
    dofs, by_region = Dofs(mesh, made.element), sections(name)
    d = np.random.default_rng(4).standard_normal(dofs.count).astype(dtype)
    found = Assembly(made, mesh, dofs).force(by_region, d)
    each = made.force(mesh.corners, by_region[mesh.regions], d[dofs.of_cells], dtype=dtype)
    expected = np.zeros_like(d)
    np.add.at(expected, dofs.of_cells, each)
    assert found.dtype == np.dtype(dtype)
    assert np.abs(found - expected).max() <= 20 * np.finfo(dtype).eps * np.abs(expected).max()
    interpreted = Assembly(kernels(name, "interpreted"), mesh, dofs).force(by_region, d)
    assert np.abs(interpreted - expected).max() <= 20 * np.finfo(dtype).eps * np.abs(expected).max()


@pytest.mark.parametrize("name", ["bciz", "lst", "q9", "bfs"])
@pytest.mark.quick("bciz", "lst")
def test_interpreted_kernels_give_the_same_matrix(name: str) -> None:
    """1e-15 times the cells around a node: numpy sums in another order."""
    mesh = meshed(name)
    dofs = Dofs(mesh, ELEMENTS[name])
    compiled, interpreted = (Assembly(kernels(name, b), mesh, dofs) for b in ("c", "interpreted"))
    found, expected = compiled.stiffness(sections(name)), interpreted.stiffness(sections(name))
    assert np.array_equal(found.indices, expected.indices)
    assert np.array_equal(found.indptr, expected.indptr)
    assert np.abs(found.data - expected.data).max() <= 6e-15 * np.abs(expected.data).max()


def test_a_node_of_many_cells_has_them_all() -> None:
    """A fan of 200 triangles: its centre meets more neighbours than are sorted by insertion."""
    angle = np.linspace(0.0, 2 * np.pi, 200, endpoint=False)
    points = np.vstack([np.zeros((1, 2)), np.stack([np.cos(angle), np.sin(angle)], axis=1)])
    rim = np.arange(200)
    cells = np.stack([np.zeros(200, dtype=int), 1 + rim, 1 + (rim + 1) % 200], axis=1)
    mesh, made = Mesh(points, cells.astype(np.int32)), kernels("dkt")
    dofs = Dofs(mesh, made.element)
    found = Assembly(made, mesh, dofs).stiffness([[1.0, 0.3, 0.0, 1.0, 0.0, 0.35]])
    expected = dense(made.stiffness(mesh.corners, np.tile([1.0, 0.3, 0.0, 1.0, 0.0, 0.35], (200, 1))), dofs)
    assert found.indptr[3] == 3 * 3 * 201
    # 200 terms at the centre, each rounded at 1e-16
    assert np.abs(found.toarray() - expected).max() <= 200 * 1.2e-16 * np.abs(expected).max()


@dataclass(frozen=True)
class Numbers:
    """What stands in for Dofs here."""

    count: int
    of_cells: Any


def hostile_unknowns(mesh: Mesh) -> dict[str, Numbers]:
    dofs = Dofs(mesh, ELEMENTS["dkt"])
    good, count = np.array(dofs.of_cells), dofs.count
    beyond, negative, torn, shifted = good.copy(), good.copy(), good.copy(), good.copy()
    beyond[3, 4] = count
    negative[0, 0] = -1
    torn[2, 1] = torn[2, 4]
    shifted[1, 3:6] = shifted[1, :3] + 1  # overlaps with the node before
    return {
        "beyond": Numbers(count, beyond),
        "negative": Numbers(count, negative),
        "torn": Numbers(count, torn),
        "shifted": Numbers(count, shifted),
        "of another element": Numbers(count, good[:, :6]),
        "of another mesh": Numbers(count, good[:-1]),
        "int64": Numbers(count, good.astype(np.int64)),
        "no array": Numbers(count, None),
    }


REPORTED = {
    "beyond": r"run from 0 to \d+; there are \d+",
    "negative": "run from -1",
    "torn": "must follow one another",
    "shifted": "must follow one another",
    "of another element": "have shape",
    "of another mesh": "have shape",
    "int64": "int64",
    "no array": "have shape",
}


@pytest.mark.parametrize("case", sorted(REPORTED))
def test_numbers_that_c_could_not_follow_are_refused(case: str) -> None:
    mesh = meshed("dkt")
    with pytest.raises(DesignError, match=REPORTED[case]):
        Assembly(kernels("dkt"), mesh, hostile_unknowns(mesh)[case])


def test_other_refusals() -> None:
    mesh, made = meshed("dkt"), kernels("dkt")
    dofs = Dofs(mesh, made.element)
    assembly = Assembly(made, mesh, dofs)
    with pytest.raises(
        DesignError, match=r"sections have shape \(1, 6\).*one row per region \('left', 'right'\)"
    ):
        assembly.stiffness(np.ones((1, 6)))
    with pytest.raises(DesignError, match=r"areal_mass have shape \(3,\)"):
        assembly.mass(np.ones(3))
    with pytest.raises(DesignError, match="forces have shape"):
        assembly.geometric(np.ones((3, 3)))
    with pytest.raises(
        DesignError, match=r"d have shape \(3,\); it must be \(\d+,\), one number per unknown"
    ):
        assembly.force(np.ones((2, 6)), np.ones(3))
    with pytest.raises(DesignError, match="element 'q4' has 4 corners and the cells of the mesh 3"):
        Assembly(kernels("q4"), mesh, dofs)
    with pytest.raises(DesignError, match="it must be a Mesh"):
        Assembly(made, mesh.points, dofs)  # type: ignore[arg-type]
    flat = meshed("cst")
    with pytest.raises(UnsupportedError, match="no deflection"):
        Assembly(kernels("cst"), flat, Dofs(flat, element("cst"))).geometric(np.ones((len(flat.cells), 3)))


def test_numbers_that_are_none_stay_numbers() -> None:
    mesh, made = meshed("dkt"), kernels("dkt")
    found = Assembly(made, mesh, Dofs(mesh, made.element)).stiffness([[np.nan] * 6, [np.inf] * 6])
    assert not np.isfinite(found.data).any()


@pytest.mark.parametrize("name", NAMES)
def test_memory_is_estimated_before_it_is_taken(name: str) -> None:
    """A grid of 60 by 61 squares: half of the rim of 4/60 is points and edges that the formula leaves out."""
    mesh = meshed(name, 60)
    made = kernels(name)
    dofs = Dofs(mesh, made.element)
    assembly = Assembly(made, mesh, dofs)
    guessed = estimate_memory(made.element, len(mesh.cells))
    matrix = assembly.stiffness(sections(name))
    assert guessed.unknowns == pytest.approx(dofs.count, rel=0.04)
    assert guessed.entries == pytest.approx(assembly.entry_count, rel=0.04)
    taken = matrix.data.nbytes + matrix.indices.nbytes + matrix.indptr.nbytes
    assert guessed.matrix == pytest.approx(taken, rel=0.04)


@pytest.mark.parametrize("name", ["bciz", "dkt+cst", "lst", "q8", "bfs"])
def test_the_factor_is_guessed_within_a_half(name: str) -> None:
    """Against one of SuperLU's two triangles. 3700 points fill in less than the many for which the guess is made."""
    made = kernels(name)
    mesh = meshed(name, 60)
    assembly = Assembly(made, mesh, Dofs(mesh, made.element))
    matrix = assembly.stiffness(sections(name))
    matrix.setdiag(2.0 * matrix.diagonal())  # holds it in place of supports
    options = {"SymmetricMode": True}
    lu = splu(matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options=options)
    guessed = estimate_memory(made.element, len(mesh.cells)).factor
    assert guessed == pytest.approx(8 * lu.L.nnz, rel=0.5)


def test_a_problem_that_does_not_fit_is_refused_before_it_is_made() -> None:
    """Ten million triangles take some tens of gigabytes; CHOLMOD's factor has half the size of SuperLU's."""
    dkt = ELEMENTS["dkt"]
    text = "10000000 cells of element 'dkt' have 15000000 unknowns and take some .* GiB to solve with superlu; 4 GiB"
    with pytest.raises(DesignError, match=text):
        check_memory(dkt, 10_000_000, "superlu", 4 * 2**30)
    check_memory(dkt, 10_000_000, "cholmod", 64 * 2**30)
    check_memory(dkt, 100_000, "superlu", 2**30)
    free = available_memory()
    assert free is None or free > 2**20


def test_ten_million_triangles_are_counted_without_being_made() -> None:
    """Five million points; each meets seven, in blocks of three by three."""
    guessed = estimate_memory(ELEMENTS["dkt"], 10_000_000)
    assert guessed.unknowns == 15_000_000
    assert guessed.entries == 5_000_000 * 7 * 9
    assert guessed.matrix == 12 * guessed.entries + 4 * guessed.unknowns
