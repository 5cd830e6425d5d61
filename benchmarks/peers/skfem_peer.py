"""Plate bending in scikit-fem: Morley triangles, assembled by numpy.

In: points and triangles, and an isotropic plate. Out: its stiffness matrix, once from nothing and again on the same
basis. It shares nothing with lamc but the mesh.
"""

from typing import Any

import numpy as np
import numpy.typing as npt
import scipy.sparse as sps
from skfem import Basis, BilinearForm, ElementTriMorley, MeshTri
from skfem.helpers import dd, ddot, eye, trace

Array = npt.NDArray[np.float64]


class MorleyPlate:
    """An isotropic plate with D = 1 on points (n, 2) and cells (m, 3). Making it makes the basis."""

    def __init__(self, points: Array, cells: npt.NDArray[np.int32], poisson: float) -> None:
        mesh = MeshTri(np.ascontiguousarray(points.T), np.ascontiguousarray(cells.T.astype(np.int64)))
        self.basis = Basis(mesh, ElementTriMorley())

        @BilinearForm
        def bending(w: Any, v: Any, _: Any) -> Any:
            curvature = dd(w)
            return ddot((1 - poisson) * curvature + poisson * eye(trace(curvature), 2), dd(v))

        self._bending = bending

    def assemble(self) -> sps.csr_matrix:
        """∫ (1 - ν) w_ij v_ij + ν w_ii v_jj dA."""
        return self._bending.assemble(self.basis)
