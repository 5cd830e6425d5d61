"""The functions of models whose numbers are float, against numpy in double and what C99 says of special values."""

import ctypes

import numpy as np
import numpy.typing as npt
import pytest

from lamc.basics.resources import data_dir
from tests.support.ctools import needs_cc
from tests.support.elementary import EXACT, Case, check_errors, check_special_values, compiled, mapped, one

Single = npt.NDArray[np.float32]

pytestmark = needs_cc

COUNT = 200_000
RANDOM = np.random.default_rng(21)
SIZES = (0.0, 0.5, 1.0, 2.0, 3.0, 88.9, 104.5, 1e7, 2.0**24 - 1.0, 1e-45, 1e-38, 3e38, np.inf, np.nan)
SPECIAL = np.array([s * x for x in SIZES for s in (1.0, -1.0)], dtype=np.float32)


def single(values: npt.NDArray[np.float64]) -> Single:
    return values.astype(np.float32)


def sizes(low: float, high: float) -> Single:
    """Of all magnitudes from 10^low to 10^high"""
    return single(10.0 ** RANDOM.uniform(low, high, COUNT))


def signed(low: float, high: float) -> Single:
    return sizes(low, high) * RANDOM.choice(np.array([-1.0, 1.0], dtype=np.float32), COUNT)


def evenly(low: float, high: float) -> Single:
    return single(RANDOM.uniform(low, high, COUNT))


def near_quarter_turns() -> Single:
    """Multiples of pi/4 and their neighbours, where digits of the reduced angle are lost"""
    exact = single(RANDOM.integers(1, 2**22, COUNT) * (np.pi / 4.0))
    return single(exact + RANDOM.integers(-2, 3, COUNT) * np.spacing(exact).astype(np.float64))


ANGLES = one(lambda: evenly(-7, 7), lambda: signed(-20, 15), near_quarter_turns)
CASES = {
    "sin": Case(1.0, ANGLES),
    "cos": Case(1.0, ANGLES),
    "tan": Case(3.0, ANGLES),
    "exp": Case(1.0, one(lambda: signed(-20, 2), lambda: evenly(-104, -85), lambda: evenly(-1, 1))),
    "log": Case(1.0, one(lambda: sizes(-38, 38), lambda: 1 + signed(-7, -1), lambda: sizes(-45, -37))),
    "atan": Case(3.0, one(lambda: signed(-20, 20), lambda: evenly(-3, 3))),
    "asin": Case(3.0, one(lambda: evenly(-1, 1), lambda: signed(-12, 0), lambda: 1 - sizes(-7, -1))),
    "acos": Case(3.0, one(lambda: evenly(-1, 1), lambda: signed(-12, 0), lambda: 1 - sizes(-7, -1))),
    "sinh": Case(3.0, one(lambda: signed(-12, 1.9), lambda: evenly(-2, 2), lambda: evenly(85, 90))),
    "cosh": Case(3.0, one(lambda: signed(-12, 1.9), lambda: evenly(-2, 2), lambda: evenly(85, 90))),
    "tanh": Case(3.0, one(lambda: signed(-12, 2), lambda: evenly(-2, 2))),
    "atan2": Case(3.0, ((lambda: signed(-10, 10), lambda: signed(-10, 10)), (lambda: evenly(-1, 1),) * 2)),
    "pow": Case(
        1.0,
        (
            (lambda: sizes(-3, 3), lambda: evenly(-12, 12)),
            (lambda: sizes(-38, 38), lambda: evenly(-1, 1)),
            (lambda: evenly(0, 1), lambda: np.full(COUNT, 1.5, dtype=np.float32)),
            (lambda: 1 + signed(-6, -2), lambda: signed(1, 5)),
        ),
    ),
}


@pytest.fixture(scope="module", params=["c", "c++"])
def library(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> ctypes.CDLL:
    folder, root = tmp_path_factory.mktemp("elementary"), data_dir("runtime_c")
    folders = (f"-I{root / name}" for name in ("src", "bare", "include"))
    flags = ("-Wdouble-promotion", "-DLAMC_REAL_FLOAT", *folders)
    return compiled(folder, [*EXACT, *CASES], "float", request.param, *flags)


@pytest.mark.parametrize("name", CASES)
def test_errors_are_what_the_headers_say(name: str, library: ctypes.CDLL) -> None:
    check_errors(library, name, CASES[name], np.float64)  # 29 bits more than are judged


def test_square_roots_are_rounded_correctly(library: ctypes.CDLL) -> None:
    """As IEEE 754 asks and as the processor's are, which numpy takes; squares and their neighbours are hard."""
    squares = single(RANDOM.integers(1, 2**12, COUNT).astype(np.float64) ** 2)
    for x in (
        sizes(-38, 38),
        sizes(-45, -37),
        squares,
        np.nextafter(squares, np.float32(0.0)),
        np.nextafter(squares, np.float32(1e9)),
    ):
        assert np.array_equal(mapped(library, "sqrt", x), np.sqrt(x))


@pytest.mark.parametrize("name", [*EXACT, *CASES])
def test_special_values_are_those_of_annex_f(name: str, library: ctypes.CDLL) -> None:
    check_special_values(library, name, SPECIAL, np.float64)
