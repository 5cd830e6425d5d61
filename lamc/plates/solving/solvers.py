"""Symmetric sparse systems: factored once, solved for many right-hand sides.

In: a positive definite matrix in compressed columns, both triangles, and where its unknowns are. Out: a factor that
solves, and that takes new values on the same pattern. Never: knows what the unknowns are.

`auto` takes CHOLMOD where scikit-sparse is installed and its BLAS is a tuned one, and SuperLU, which scipy brings,
otherwise. SuperLU is given an order by nested dissection and told that the matrix is symmetric (pivots from the
diagonal): its own default is for matrices without symmetry, and takes many times the time and memory; its minimum
degree on Aᵀ + A takes twice the time. PARDISO is by choice.
"""

import importlib
import sys
import threading
import weakref
from collections.abc import Callable
from functools import cache
from typing import Any, Protocol

import numpy as np
import scipy.sparse as sp
import scipy.sparse.linalg as sla
from numpy.typing import NDArray

from lamc.basics.checks import Array, shown
from lamc.basics.errors import DesignError, SimulationError, UnsupportedError
from lamc.plates.solving.blas import tuned_blas
from lamc.plates.solving.dissection import nested_dissection

_POSITIVE_DEFINITE = 2  # PARDISO's number for real symmetric matrices of that kind
# Unknowns up to which CHOLMOD orders by minimum degree alone. Left to itself it tries METIS too, and takes the better:
# at 300 000 that is 1.2 s for a factor of 1.3 s, against 0.35 s for one of 1.6 s.
_MINIMUM_DEGREE = 500_000


class SingularError(SimulationError):
    """A matrix is not positive definite to working precision."""


class Factor(Protocol):
    """A factored matrix."""

    name: str

    def solve(self, right: Array) -> Array:
        """The solution for one right-hand side (n,) or several (n, k)."""

    def refactored(self, matrix: sp.csc_array) -> "Factor":
        """Of a matrix with other values on the same pattern, in the same ordering."""


class SuperLU:
    """scipy's own."""

    name = "superlu"

    def __init__(self, matrix: sp.csc_array, order: NDArray[Any]) -> None:
        self._order = order
        matrix = sp.csc_array(matrix[order][:, order])
        try:
            self._lu = sla.splu(
                matrix, permc_spec="NATURAL", diag_pivot_thresh=0.0, options={"SymmetricMode": True}
            )
        except RuntimeError as error:  # "Factor is exactly singular"
            raise SingularError(f"the stiffness matrix is singular: {error}") from error

    @classmethod
    def of(cls, matrix: sp.csc_array, points: Array) -> "SuperLU":
        return cls(matrix, nested_dissection(matrix, points))

    def solve(self, right: Array) -> Array:
        right = np.asarray(right, dtype=float)
        result = np.empty_like(right)
        result[self._order] = self._lu.solve(right[self._order])
        return result

    def refactored(self, matrix: sp.csc_array) -> "SuperLU":
        return SuperLU(matrix, self._order)


class Cholmod:
    """SuiteSparse's supernodal Cholesky factorisation through scikit-sparse, 0.4 or 0.5: two interfaces."""

    name = "cholmod"

    def __init__(self, matrix: sp.csc_array) -> None:
        self._module = _cholmod()
        self._alone = threading.Lock()
        if hasattr(self._module, "CholeskyFactor"):
            self._factor = self._module.CholeskyFactor(matrix, lower=True)
        else:
            small = matrix.shape[0] <= _MINIMUM_DEGREE
            self._factor = self._module.analyze(matrix, ordering_method="amd" if small else "default")
        self._fill(matrix)

    def _fill(self, matrix: sp.csc_array) -> None:
        try:
            if hasattr(self._factor, "factorize"):
                self._factor.factorize(matrix)
            else:
                self._factor.cholesky_inplace(matrix)
        except self._module.CholmodNotPositiveDefiniteError as error:
            raise SingularError(f"the stiffness matrix is not positive definite: {error}") from error

    def solve(self, right: Array) -> Array:
        solve = self._factor.solve if hasattr(self._factor, "factorize") else self._factor
        with self._alone:  # a factor of SuiteSparse's has one work space
            return np.asarray(solve(np.asarray(right, dtype=float)))

    def refactored(self, matrix: sp.csc_array) -> "Cholmod":
        other = object.__new__(Cholmod)
        other._module, other._alone = self._module, threading.Lock()
        with self._alone:
            other._factor = self._factor.copy()
        other._fill(matrix)
        return other


class Pardiso:
    """MKL's, through pypardiso. Told that the matrix is positive definite, it reads the upper triangle by rows."""

    name = "pardiso"

    def __init__(self, matrix: sp.csc_array) -> None:
        wrapper = _pardiso()
        self._alone = threading.Lock()
        try:
            self._solver = wrapper.PyPardisoSolver(mtype=_POSITIVE_DEFINITE)
        except ImportError as error:  # the wrapper is there, MKL is not
            raise UnsupportedError(f"solver 'pardiso' cannot be used: {error}") from error
        weakref.finalize(self, self._solver.free_memory, everything=True)
        self._matrix = sp.csr_matrix(sp.tril(matrix, format="csc").T)
        try:
            self._solver.factorize(self._matrix)
        except wrapper.PyPardisoError as error:
            raise SingularError(f"the stiffness matrix is not positive definite: {error}") from error

    def solve(self, right: Array) -> Array:
        with self._alone:  # MKL keeps the factor and its phase behind one handle
            return np.asarray(self._solver.solve(self._matrix, np.asarray(right, dtype=float)))

    def refactored(self, matrix: sp.csc_array) -> "Pardiso":
        return Pardiso(matrix)


SOLVERS: dict[str, Callable[[sp.csc_array, Array], Factor]] = {
    "cholmod": lambda matrix, _: Cholmod(matrix),
    "pardiso": lambda matrix, _: Pardiso(matrix),
    "superlu": SuperLU.of,
}


def checked_solver(name: object) -> str:
    """The name of a solver that can be used here; "auto" becomes one. Raises DesignError or UnsupportedError."""
    if name == "auto":
        return "cholmod" if cholmod_is_fast() else "superlu"
    if not isinstance(name, str) or name not in SOLVERS:
        raise DesignError(
            f"the solver is {shown(name)}; it must be one of auto, {', '.join(sorted(SOLVERS))}"
        )
    if name == "cholmod":
        _cholmod()
    if name == "pardiso":
        _pardiso()
    return name


def factor(matrix: sp.csc_array, points: Array, solver: str) -> Factor:
    """`matrix`, of unknowns at `points` (n, 2), factored by the solver of that name, of `SOLVERS`.

    Raises SingularError.
    """
    return SOLVERS[solver](matrix, points)


@cache
def cholmod_is_fast() -> bool:
    """Whether scikit-sparse is there and linked to a tuned BLAS.

    CHOLMOD spends its time in BLAS, and distributions link it to whichever libblas is installed: with the reference
    one it is slower than SuperLU, which has kernels of its own. The library is told by its symbols and not by its
    speed, so that the same plate is solved by the same solver however busy the machine is.
    """
    try:
        _cholmod()
    except UnsupportedError:
        return False
    own = [module for name, module in sorted(sys.modules.items()) if name.startswith("sksparse")]
    files = [getattr(module, "__file__", None) or "" for module in own]
    return tuned_blas(file for file in files if file.endswith((".so", ".pyd"))) is not None


def _cholmod() -> Any:
    return _imported(
        "cholmod",
        "sksparse.cholmod",
        "CHOLMOD needs scikit-sparse: pip install scikit-sparse (and SuiteSparse)",
    )


def _pardiso() -> Any:
    return _imported(
        "pardiso", "pypardiso.pardiso_wrapper", "PARDISO needs the package pypardiso: pip install pypardiso"
    )


def _imported(solver: str, module: str, way_out: str) -> Any:
    try:
        return importlib.import_module(module)
    except ImportError as error:
        raise UnsupportedError(f"solver {solver!r} cannot be used: {error}; {way_out}") from error
