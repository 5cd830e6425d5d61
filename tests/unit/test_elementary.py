"""The functions that programs without <math.h> get, against long double and against what C99 says of special values."""

import ctypes

import numpy as np
import numpy.typing as npt
import pytest

from lamc.basics.resources import data_dir
from tests.support.ctools import needs_cc
from tests.support.elementary import EXACT, Case, check_errors, check_special_values, compiled, mapped, one

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


def sizes(low: float, high: float) -> Array:
    """Of all magnitudes from 10^low to 10^high"""
    return np.asarray(10.0 ** RANDOM.uniform(low, high, COUNT))


def signed(low: float, high: float) -> Array:
    return sizes(low, high) * RANDOM.choice([-1.0, 1.0], COUNT)


def evenly(low: float, high: float) -> Array:
    return RANDOM.uniform(low, high, COUNT)


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
    root = data_dir("runtime_c")
    folders = tuple(f"-I{root / name}" for name in ("bare", "src", "include"))
    return compiled(
        tmp_path_factory.mktemp("elementary"), [*EXACT, *CASES], "double", request.param, *folders
    )


@pytest.mark.parametrize("name", CASES)
def test_errors_are_what_the_header_says(name: str, library: ctypes.CDLL) -> None:
    check_errors(library, name, CASES[name], np.longdouble)


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


@pytest.mark.parametrize("name", [*EXACT, *CASES])
def test_special_values_are_those_of_annex_f(name: str, library: ctypes.CDLL) -> None:
    check_special_values(library, name, SPECIAL, np.float64)
