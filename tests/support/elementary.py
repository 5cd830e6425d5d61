"""lamc's own mathematical functions, compiled as they stand and mapped over arrays, and what they are held to."""

import ctypes
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from tests.support.ctools import STRICT, STRICT_CXX, cc

Floats = npt.NDArray[np.floating[Any]]
Makers = tuple[tuple[Callable[[], Floats], ...], ...]

TWO = ("atan2", "pow", "fmin", "fmax")  # functions of two arguments
EXACT = ("sqrt", "fabs", "fmin", "fmax")  # without an error of their own
_NUMPY = {"asin": "arcsin", "acos": "arccos", "atan": "arctan", "atan2": "arctan2", "pow": "power"}


@dataclass(frozen=True)
class Case:
    """Units in the last place that the header allows, and arguments that are hard: near zeros, ends and seams."""

    ulps: float
    arguments: Makers


def one(*makers: Callable[[], Floats]) -> Makers:
    return tuple((maker,) for maker in makers)


def compiled(folder: Path, names: Sequence[str], real: str, language: str, *flags: str) -> ctypes.CDLL:
    """A library with map_NAME(n, x, [z,] y) for each function. real: the type in C; language: c or c++."""
    lines = ['#include "elementary.h"', "#ifdef __cplusplus", 'extern "C" {', "#endif"]
    for name in names:
        given = f"const {real} *x, " + (f"const {real} *z, " if name in TWO else "")
        call = f"lamc_{name}(x[i]{', z[i]' if name in TWO else ''})"
        head = f"void map_{name}(long n, {given}{real} *y)"
        lines.append(f"{head};\n{head} {{ for (long i = 0; i < n; i++) y[i] = {call}; }}")
    lines += ["#ifdef __cplusplus", "}", "#endif"]
    (folder / "maps.c").write_text("\n".join(lines) + "\n")
    dialect = (*STRICT_CXX, "-x", "c++") if language == "c++" else STRICT
    shared = ("-O2", "-ffp-contract=off", "-fPIC", "-shared")
    cc(folder, *dialect, *shared, *flags, "maps.c", "-o", "maps.so")
    return ctypes.CDLL(str(folder / "maps.so"))


def mapped(library: ctypes.CDLL, name: str, *arguments: Floats) -> Floats:
    """The function at all arguments, which have the library's own type of numbers."""
    given = [np.ascontiguousarray(a) for a in arguments]
    out = np.empty_like(given[0])
    pointers = [ctypes.c_void_p(a.ctypes.data) for a in (*given, out)]
    getattr(library, f"map_{name}")(ctypes.c_long(len(out)), *pointers)
    return out


def in_numpy(name: str) -> Callable[..., Floats]:
    found: Callable[..., Floats] = getattr(np, _NUMPY.get(name, name))
    return found


def check_errors(library: ctypes.CDLL, name: str, case: Case, wide: type[np.floating[Any]]) -> None:
    """Against numpy in the type `wide`, which has more digits; infinity is right beyond the range of the function's."""
    for makers in case.arguments:
        arguments = [make() for make in makers]
        real = arguments[0].dtype
        with np.errstate(all="ignore"):
            exact = in_numpy(name)(*(a.astype(wide) for a in arguments))
            values = mapped(library, name, *arguments)
            spacing = np.spacing(np.maximum(np.abs(exact.astype(real)), np.finfo(real).smallest_subnormal))
            error = np.abs(values - exact) / spacing
            reported = np.isfinite(exact.astype(real))
        assert np.array_equal(np.isfinite(values), reported)
        assert np.max(error[reported]) <= case.ulps


def check_special_values(
    library: ctypes.CDLL, name: str, special: Floats, wide: type[np.floating[Any]]
) -> None:
    """What C99 says, as numpy in the type `wide` has it: to 3 units in the last place, the headers' worst, where the
    value is no zero, infinity or NaN."""
    arguments = [m.ravel() for m in np.meshgrid(special, special)] if name in TWO else [special]
    with np.errstate(all="ignore"):
        right = in_numpy(name)(*(a.astype(wide) for a in arguments)).astype(special.dtype)
        if name in ("fmin", "fmax"):
            # Of two zeros numpy gives either; a footnote to F.9.9 asks for the one that their signs order.
            x, z = arguments
            is_minus = (np.logical_or if name == "fmin" else np.logical_and)(np.signbit(x), np.signbit(z))
            zeros = (x == 0.0) & (z == 0.0)
            right[zeros] = np.where(is_minus, -0.0, 0.0)[zeros]
        values = mapped(library, name, *arguments)
        alike = (np.isnan(values) & np.isnan(right)) | (
            (values == right) & (np.signbit(values) == np.signbit(right))
        )
        near = (right != 0.0) & (np.abs(values - right) <= 3.0 * np.spacing(np.abs(right)))
    wrong = [tuple(float(a[k]) for a in arguments) for k in np.flatnonzero(~(alike | near))]
    assert not wrong
