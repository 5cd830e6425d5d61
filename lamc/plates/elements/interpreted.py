"""Runs an `ElementProgram` in Python: the cross-check that tests printer, compiler and binding of finite elements.

An `ElementProgram` and arrays of cells go in, arrays come out. Operations mean what `operations.py` says; no text is
made on the way. Works in any floating type that numpy has, long double included.
"""

from collections.abc import Mapping, Sequence
from fractions import Fraction
from functools import cache
from typing import Any

import numpy as np
import numpy.typing as npt

from lamc.symbolic.listing import Listing, Number, listing_of, run
from lamc.symbolic.operations import BATCHED
from lamc.symbolic.program import ElementProgram, Space

CHUNK = 1000  # cells at once: a long function has thousands of arrays of this length


class InterpretedElement:
    """An `ElementProgram` as Python functions of whole arrays. Raises EmitError for an operation without a meaning."""

    def __init__(self, program: ElementProgram) -> None:
        self.program = program
        self._listing = cache(lambda name: listing_of(program.functions[name], BATCHED))

    def values(
        self, name: str, inputs: Sequence[npt.NDArray[Any]], dtype: Any = np.float64
    ) -> npt.NDArray[Any]:
        """What function `name` gives, shape (m, outputs), from its inputs, shape (m, size) each, all in `dtype`."""
        count = len(inputs[0])
        result = np.empty((count, len(self.program.functions[name].outputs)), dtype=dtype)
        with np.errstate(all="ignore"):
            for first in range(0, count, CHUNK):
                part = slice(first, first + CHUNK)
                columns = {
                    space: list(np.asarray(array[part], dtype=dtype).T)
                    for space, array in zip(self.program.inputs(name), inputs, strict=True)
                }
                result[part] = self._summed(name, columns, np.dtype(dtype).type)
        return result

    def _summed(self, name: str, columns: dict[Space, list[Any]], dtype: Any) -> npt.NDArray[Any]:
        listing: Listing = self._listing(name)
        points = self.program.points.get(name)
        if points is None:
            return _outputs(listing, columns, dtype)
        count = len(next(iter(columns.values()))[0])
        total = np.zeros((count, len(listing.outputs)), dtype=dtype)
        for point in points:
            at = [np.full(count, value, dtype=dtype) for value in point]
            total += _outputs(listing, {**columns, Space.NATURAL: at}, dtype)
        return total


def _outputs(listing: Listing, columns: Mapping[Space, Sequence[Any]], dtype: Any) -> npt.NDArray[Any]:
    memory = run(listing, columns, lambda value: _number(value, dtype))
    count = len(next(iter(columns.values()))[0])
    result = np.empty((count, len(listing.outputs)), dtype=dtype)
    for k, (sign, address) in enumerate(listing.outputs):
        result[:, k] = sign * memory[address]
    return result


def _number(value: Number, dtype: Any) -> Any:
    """A literal, a fraction rounded once."""
    if isinstance(value, Fraction):
        return dtype(value.numerator) / dtype(value.denominator)
    return dtype(value)
