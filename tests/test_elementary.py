"""The functions that programs without <math.h> get, against long double and against what C99 says of special values."""

import ctypes
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import pytest

from lamc.resources import data_dir
from tests.ctools import STRICT, STRICT_CXX, cc, needs_cc

Array = npt.NDArray[np.float64]

pytestmark = [
    needs_cc,
    pytest.mark.skipif(
        np.finfo(np.longdouble).nmant < 60, reason="long double has no more digits than double"
    ),
]

COUNT = 50_000
RANDOM = np.random.default_rng(20)
SPECIAL = np.array(
    [
        s * x
        for x in (
            0.0,
            0.5,
            1.0,
            2.0,
            3.0,
            710.0,
            746.0,
            1e16,
            2.0**53 - 1.0,
            5e-324,
            1e-308,
            1e308,
            np.inf,
            np.nan,
        )
        for s in (1.0, -1.0)
    ]
)
TWO = ("atan2", "pow", "fmin", "fmax")
NUMPY = {"asin": "arcsin", "acos": "arccos", "atan": "arctan", "atan2": "arctan2", "pow": "power"}


def sizes(low: float, high: float) -> Array:
    """Of all magnitudes from 10^low to 10^high"""
    return np.asarray(10.0 ** RANDOM.uniform(low, high, COUNT))


def signed(low: float, high: float) -> Array:
    return sizes(low, high) * RANDOM.choice([-1.0, 1.0], COUNT)


def evenly(low: float, high: float) -> Array:
    return RANDOM.uniform(low, high, COUNT)


@dataclass(frozen=True)
class Case:
    """Units in the last place that the header allows, and arguments that are hard: near zeros, ends and seams."""

    ulps: float
    arguments: tuple[tuple[Callable[[], Array], ...], ...]


def one(*makers: Callable[[], Array]) -> tuple[tuple[Callable[[], Array], ...], ...]:
    return tuple((maker,) for maker in makers)


CASES = {
    "exp": Case(1.0, one(lambda: signed(-20, 2.85), lambda: evenly(-745, -700), lambda: evenly(-1, 1))),
    "log": Case(1.0, one(lambda: sizes(-307, 308), lambda: 1 + signed(-15, -1), lambda: sizes(-323, -300))),
    "atan": Case(1.0, one(lambda: signed(-20, 20), lambda: evenly(-3, 3))),
    "tan": Case(3.0, one(lambda: signed(-10, 18), lambda: evenly(-10, 10))),
    "asin": Case(3.0, one(lambda: evenly(-1, 1), lambda: signed(-12, 0), lambda: 1 - sizes(-15, -1))),
    "acos": Case(3.0, one(lambda: evenly(-1, 1), lambda: signed(-12, 0), lambda: 1 - sizes(-15, -1))),
    "sinh": Case(3.0, one(lambda: signed(-12, 2.85), lambda: evenly(-2, 2), lambda: evenly(700, 710.4))),
    "cosh": Case(3.0, one(lambda: signed(-12, 2.85), lambda: evenly(-2, 2), lambda: evenly(700, 710.4))),
    "tanh": Case(3.0, one(lambda: signed(-12, 2), lambda: evenly(-2, 2))),
    "atan2": Case(3.0, ((lambda: signed(-20, 20), lambda: signed(-20, 20)), (lambda: evenly(-1, 1),) * 2)),
    "pow": Case(
        0.6,
        (
            (lambda: sizes(-5, 5), lambda: evenly(-30, 30)),
            (lambda: sizes(-300, 300), lambda: evenly(-1, 1)),
            (lambda: evenly(0, 1), lambda: np.full(COUNT, 1.5)),
            (lambda: 1 + signed(-12, -3), lambda: signed(2, 7)),
        ),
    ),
}


@pytest.fixture(scope="module", params=["c", "c++"])
def library(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> ctypes.CDLL:
    folder = tmp_path_factory.mktemp("elementary")
    lines = ['#include "elementary.h"', "#ifdef __cplusplus", 'extern "C" {', "#endif"]
    for name in ("sqrt", "fabs", *CASES, "fmin", "fmax"):
        given = "const double *x, " + ("const double *z, " if name in TWO else "")
        call = f"lamc_{name}(x[i]{', z[i]' if name in TWO else ''})"
        head = f"void map_{name}(long n, {given}double *y)"
        lines.append(f"{head};\n{head} {{ for (long i = 0; i < n; i++) y[i] = {call}; }}")
    lines += ["#ifdef __cplusplus", "}", "#endif"]
    (folder / "maps.c").write_text("\n".join(lines) + "\n")
    root = data_dir("runtime_c")
    dialect = STRICT_CXX if request.param == "c++" else STRICT
    cc(folder, *dialect, "-O2", "-ffp-contract=off", "-fPIC", "-shared", f"-I{root / 'bare'}", f"-I{root / 'src'}",
       *(["-x", "c++"] if request.param == "c++" else []), "maps.c", "-o", "maps.so")  # fmt: skip
    return ctypes.CDLL(str(folder / "maps.so"))


def mapped(library: ctypes.CDLL, name: str, *arguments: Array) -> Array:
    given = [np.ascontiguousarray(a) for a in arguments]
    out = np.empty_like(given[0])
    pointers = [ctypes.c_void_p(a.ctypes.data) for a in (*given, out)]
    getattr(library, f"map_{name}")(ctypes.c_long(len(out)), *pointers)
    return out


def in_numpy(name: str) -> Callable[..., npt.NDArray[np.floating]]:
    found: Callable[..., npt.NDArray[np.floating]] = getattr(np, NUMPY.get(name, name))
    return found


@pytest.mark.parametrize("name", CASES)
def test_errors_are_what_the_header_says(name: str, library: ctypes.CDLL) -> None:
    for makers in CASES[name].arguments:
        arguments = [make() for make in makers]
        with np.errstate(all="ignore"):
            exact = in_numpy(name)(*(a.astype(np.longdouble) for a in arguments))
            values = mapped(library, name, *arguments)
            spacing = np.spacing(np.maximum(np.abs(exact.astype(np.float64)), 5e-324))
            error = np.abs(values - exact) / spacing
            told = np.isfinite(exact.astype(np.float64))  # beyond the range of doubles infinity is right
        assert np.array_equal(np.isfinite(values), told)
        assert np.max(error[told]) <= CASES[name].ulps


def test_square_roots_are_rounded_correctly(library: ctypes.CDLL) -> None:
    """As IEEE 754 asks and as the processor's are, which numpy takes; squares and their neighbours are hard."""
    squares = RANDOM.integers(1, 2**26, COUNT).astype(np.float64) ** 2
    for x in (
        sizes(-307, 308),
        sizes(-323, -300),
        squares,
        np.nextafter(squares, 0.0),
        np.nextafter(squares, 1e9 * squares),
    ):
        assert np.array_equal(mapped(library, "sqrt", x), np.sqrt(x))


@pytest.mark.parametrize("name", ["sqrt", "fabs", *CASES, "fmin", "fmax"])
def test_special_values_are_those_of_annex_f(name: str, library: ctypes.CDLL) -> None:
    pairs = [m.ravel() for m in np.meshgrid(SPECIAL, SPECIAL)] if name in TWO else [SPECIAL]
    with np.errstate(all="ignore"):
        right = in_numpy(name)(*pairs)
    values = mapped(library, name, *pairs)
    alike = (np.isnan(values) & np.isnan(right)) | (
        (values == right) & (np.signbit(values) == np.signbit(right))
    )
    with np.errstate(all="ignore"):
        near = np.abs(values - right) <= 3.0 * np.spacing(np.abs(right))  # the header's worst
    wrong = [tuple(float(p[k]) for p in pairs) for k in np.flatnonzero(~(alike | near))]
    assert not wrong
