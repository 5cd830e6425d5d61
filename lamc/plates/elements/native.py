"""A compiled element seen from numpy: its functions, and the assembly of its matrices.

In: the module that `build` loaded, whose C side is `lamc_element` and `lamc_assembly` of lamc_plate.h, and arrays that
have been checked. Out: arrays. Never: checks what a user gives; knows physics.
"""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from lamc.basics.checks import Array
from lamc.basics.errors import DesignError
from lamc.codegen.module import Module

Integers = npt.NDArray[np.int32]

MOST_ENTRIES = np.iinfo(np.int32).max  # sparse matrices index by int32
_TYPES = {
    np.dtype(np.longdouble): "long double[]",
    np.dtype(float): "double[]",
    np.dtype(np.int32): "int32_t[]",
}


class CompiledElement:
    """`lamc_element` with arrays. It never changes; calls leave the GIL to other threads."""

    def __init__(self, module: Module) -> None:
        self.module = module
        self.handle = module.lib.lamc_this_element()

    @property
    def source_dir(self) -> Path:
        """Where its C lies."""
        return self.module.source_dir

    def values(
        self, name: str, inputs: Sequence[npt.NDArray[Any]], outputs: tuple[int, ...], dtype: Any
    ) -> npt.NDArray[Any]:
        """What function `name` gives, shape (m, *outputs), from contiguous inputs (m, size) of `dtype`."""
        extended = np.dtype(dtype) != np.dtype(float)
        function = getattr(self.handle, f"{name}_extended" if extended else name)
        result = np.empty((len(inputs[0]), *outputs), dtype=dtype)
        function(len(result), *map(self.address, inputs), self.address(result))
        return result

    def address(self, array: npt.NDArray[Any]) -> Any:
        """What C gets for a contiguous array. It lives as long as the array does."""
        return self.module.ffi.from_buffer(_TYPES[array.dtype], array)


class CompiledAssembly:
    """`lamc_assembly` of the cells of a mesh: where the entries of a matrix lie, and their sums.

    points  (n, 2), m; cells (m, c), rows of `points`; of_cells (m, d), numbers of unknowns below `count`; the unknowns
            of each of the element's nodes (node_sizes of them) follow one another

    Raises DesignError where the matrix has more entries than an int32 counts.
    """

    def __init__(
        self,
        element: CompiledElement,
        node_sizes: Sequence[int],
        points: Array,
        cells: Integers,
        of_cells: Integers,
        count: int,
    ) -> None:
        nodes = np.ascontiguousarray(of_cells[:, np.cumsum([0, *node_sizes[:-1]])])
        self._element = element
        self._kept: dict[str, npt.NDArray[Any]] = {  # C holds their addresses only
            "node_size": np.array(node_sizes, dtype=np.int32),
            "points": np.ascontiguousarray(points),
            "cells": np.ascontiguousarray(cells),
            "nodes": nodes,
            "begins": np.empty(count + 1, dtype=np.int32),
            "offsets": np.empty((*nodes.shape, nodes.shape[1]), dtype=np.int32),
        }
        self._handle = element.module.ffi.new("lamc_assembly *")
        self._handle.cell_count, self._handle.node_count = nodes.shape
        self._handle.unknown_count = count
        for name, array in self._kept.items():
            setattr(self._handle, name, element.address(array))
        self.begins: Integers = self._kept["begins"]
        self.rows = self._rows()

    def _rows(self) -> Integers:
        element, lib = self._element, self._element.module.lib
        scratch = np.empty(lib.lamc_assembly_scratch(self._handle), dtype=np.int32)
        entries = int(lib.lamc_assembly_begin(self._handle, element.address(scratch)))
        if entries > MOST_ENTRIES:
            raise DesignError(
                f"the matrix of {len(self._kept['cells'])} cells has {entries} entries; at most {MOST_ENTRIES} can be "
                "indexed: mesh coarser"
            )
        rows = np.empty(entries, dtype=np.int32)
        lib.lamc_assembly_rows(self._handle, element.address(rows))
        return rows

    def values(self, name: str, table: Array, row: Integers) -> Array:
        """Entries of the assembled matrix; cell i takes row[i] of the table."""
        element = self._element
        summed = np.zeros(len(self.rows))
        function = getattr(element.handle, f"assemble_{name}")
        function(self._handle, element.address(table), element.address(row), element.address(summed))
        return summed

    def forces(self, sections: Array, row: Integers, d: npt.NDArray[Any]) -> npt.NDArray[Any]:
        """Forces on all unknowns d (N,), in their precision; cell i takes row[i] of the sections."""
        element = self._element
        total = np.zeros_like(d)
        name = "assemble_force" if d.dtype == np.dtype(float) else "assemble_force_extended"
        addresses = [element.address(array) for array in (sections, row, d, total)]
        getattr(element.handle, name)(self._handle, *addresses)
        return total
