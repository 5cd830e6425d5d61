"""A compiled element seen from numpy: its functions on arrays that have been checked.

In: the module that `build` loaded; its C side is `lamc_element` of lamc_plate.h. Out: arrays. Never: checks what a user
gives; knows physics.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from lamc.codegen.module import Module


class CompiledElement:
    """`lamc_element` with arrays. It never changes; calls leave the GIL to other threads."""

    def __init__(self, module: Module) -> None:
        self.module = module
        self.ffi = module.ffi
        self.handle = module.lib.lamc_this_element()

    def values(
        self, name: str, inputs: Sequence[npt.NDArray[Any]], outputs: tuple[int, ...], dtype: Any
    ) -> npt.NDArray[Any]:
        """What function `name` gives, shape (m, *outputs), from contiguous inputs (m, size) of `dtype`."""
        extended = np.dtype(dtype) != np.dtype(float)
        function = getattr(self.handle, f"{name}_extended" if extended else name)
        result = np.empty((len(inputs[0]), *outputs), dtype=dtype)
        if not len(result):
            return result
        kind = "long double[]" if extended else "double[]"
        read = [self.ffi.from_buffer(kind, array) for array in inputs]
        function(len(result), *read, self.ffi.from_buffer(kind, result, require_writable=True))
        return result
