"""lamc's own sine and cosine (`trig.h`): half a unit in the last place anywhere, and the same bits however compiled."""

import ctypes
import re
import shutil
import subprocess
from pathlib import Path

import mpmath
import numpy as np
import pytest

from lamc.codegen import zig
from lamc.codegen.options import CompileOptions
from lamc.codegen.toolchain import find_compiler
from tests.support.ctools import STRICT_CXX, cc
from tests.support.paths import RUNTIME

Array = np.ndarray
SOURCES = RUNTIME / "src"
STRICT = ("-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Wshadow", "-Werror")
EXACT = ("-std=c99", "-ffp-contract=off", "-fPIC", *STRICT)
# Units in the last place. A half is the final rounding; what trig.h rounds before it is 2^-11 of the result, some three
# times, and the polynomials are cut at 2^-8 of a unit.
PLACES = 0.51
HAS_LONG_DOUBLE = np.finfo(np.longdouble).nmant >= 63

_ROWS = """#include "trig.h"
void ones(const double *x, double *s, double *c, long n);
void twos(const double *x, double *s, double *c, long n);
void plain(const double *x, double *s, double *c, long n);
void ones(const double *x, double *s, double *c, long n) { for (long i = 0; i < n; i++) lamc_turn(x[i], s + i, c + i); }
void twos(const double *x, double *s, double *c, long n) {
  for (long i = 0; i + 1 < n; i += 2) lamc_turn_two(x[i], x[i + 1], s + i, c + i);
}
void plain(const double *x, double *s, double *c, long n) {
  for (long i = 0; i < n; i++) {
    s[i] = lamc_sin(x[i]);
    c[i] = lamc_cos(x[i]);
  }
}
"""


def library(folder: Path, *flags: str) -> ctypes.CDLL:
    """Rows of lamc's sines and cosines, compiled with `flags` and without the mathematical library."""
    folder.mkdir(exist_ok=True)
    (folder / "rows.c").write_text(_ROWS, encoding="utf-8")
    command = find_compiler(None).command
    alone = () if zig.is_zig(command[0], command) else ("-nostdlib",)  # with it zig has no <string.h> either
    words = [*command, *flags, f"-I{SOURCES}", f"-I{RUNTIME / 'include'}", "-shared", *alone]
    done = subprocess.run(
        [*words, "-o", "rows.so", "rows.c"], cwd=folder, check=False, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr[:2000]
    return ctypes.CDLL(str(folder / "rows.so"))


@pytest.fixture(scope="module")
def own(tmp_path_factory: pytest.TempPathFactory) -> ctypes.CDLL:
    return library(tmp_path_factory.mktemp("trig"), *EXACT, "-O2")


def turned(own: ctypes.CDLL, x: Array, function: str = "ones") -> tuple[Array, Array]:
    s, c = np.full_like(x, np.nan), np.full_like(x, np.nan)
    places = [ctypes.c_void_p(a.ctypes.data) for a in (x, s, c)]
    getattr(own, function)(*places, ctypes.c_long(len(x)))
    return s, c


def angles(count: int) -> dict[str, Array]:
    """Angles of every size, and beside multiples of π/2 and of π/64, where digits cancel and rows of the table meet;
    fixed seed; even in number."""
    rng = np.random.default_rng(7)
    quarters, rows = rng.integers(-4000, 4000, count), rng.integers(-130_000, 130_000, count)
    return {
        "a turn": rng.uniform(-2 * np.pi, 2 * np.pi, count),
        "thousands": rng.uniform(-6500.0, 6500.0, count),
        "small": np.exp(rng.uniform(-40.0, 0.0, count)),
        "any size": np.exp(rng.uniform(np.log(1e-300), np.log(1e300), count)),
        "multiples of pi/2": quarters * (np.pi / 2),
        "near multiples of pi/2": quarters * (np.pi / 2) + np.exp(rng.uniform(-30.0, -3.0, count)),
        "large multiples of pi/2": rng.integers(-(10**15), 10**15, count) * (np.pi / 2),
        "multiples of pi/64": rows * (np.pi / 64),
        "between rows": (rows + 0.5) * (np.pi / 64) * (1 + rng.uniform(-1e-13, 1e-13, count)),
    }


def places_off(value: Array, exact: Array) -> float:
    """Largest error in units in the last place of what is exact."""
    return float((np.abs(value - exact) / np.spacing(np.abs(exact).astype(np.float64))).max())


@pytest.mark.skipif(not HAS_LONG_DOUBLE, reason="needs a long double of 64 bits")
@pytest.mark.parametrize("where", sorted(angles(2)))
def test_a_million_sines_and_cosines_are_right_to_half_a_place(own: ctypes.CDLL, where: str) -> None:
    x = angles(112_000)[where]  # nine kinds: a million angles
    s, c = turned(own, x)
    wide = x.astype(np.longdouble)
    # 64 bits instead of 53: the reference is itself wrong by 2^-11 of a place or so
    assert places_off(s, np.sin(wide)) < PLACES
    assert places_off(c, np.cos(wide)) < PLACES


@pytest.mark.parametrize("where", sorted(angles(2)))
def test_sines_and_cosines_are_those_of_arbitrary_precision(own: ctypes.CDLL, where: str) -> None:
    x = angles(300)[where]
    worst = 0.0
    with mpmath.workprec(1300):  # an angle of 1e300 is some 1000 bits before its point
        for angle, *values in zip(x.tolist(), *turned(own, x), strict=True):
            for value, exact in zip(values, (mpmath.sin(angle), mpmath.cos(angle)), strict=True):
                worst = max(worst, float(abs(value - exact)) / np.spacing(abs(float(exact))))
    assert worst < PLACES


def test_the_doubles_nearest_to_multiples_of_a_quarter_turn(own: ctypes.CDLL) -> None:
    # J.-M. Muller, Elementary Functions, 3rd ed. (2016), section 11.3: 6381956970095103 · 2^797 is within 2^-61 of one
    x = np.array([6381956970095103.0 * 2.0**797, 5.319372648326541e255, 1.7976931348623157e308, 1e22])
    s, c = turned(own, x)
    assert abs(c[0]) < 1e-18
    with mpmath.workprec(1300):
        for angle, sine, cosine in zip(x.tolist(), s.tolist(), c.tolist(), strict=True):
            assert sine == float(mpmath.sin(angle))
            assert cosine == float(mpmath.cos(angle))


def test_small_angles_and_what_is_no_number(own: ctypes.CDLL) -> None:
    x = np.array([0.0, -0.0, 5e-324, -1e-310, 1e-9, np.nan, np.inf, -np.inf])
    for function in ("ones", "twos", "plain"):
        s, c = turned(own, x, function)
        assert s[:5].tobytes() == x[:5].tobytes()  # the sign of zero, too
        assert (c[:5] == 1.0).all()
        assert np.isnan(s[5:]).all()
        assert np.isnan(c[5:]).all()


def test_sine_is_odd_and_cosine_even_to_the_last_bit(own: ctypes.CDLL) -> None:
    for x in angles(2000).values():
        s, c = turned(own, x)
        minus_s, even_c = turned(own, -x)
        assert (-minus_s).tobytes() == s.tobytes()
        assert even_c.tobytes() == c.tobytes()


@pytest.mark.parametrize(
    "flags",
    [
        ("-O0",),
        ("-O3",),
        ("-O2", "-DLAMC_PLAIN_TRIG"),
        ("-O1", "-DLAMC_PLAIN_TRIG"),
        ("-O2", "-march=native"),
    ],
    ids=" ".join,
)
def test_bits_do_not_depend_on_vectors_or_optimisation(
    own: ctypes.CDLL, tmp_path: Path, flags: tuple[str, ...]
) -> None:
    other = library(tmp_path, *EXACT, *flags)
    for x in angles(20_000).values():
        bits = {b"".join(a.tobytes() for a in turned(own, x, f)) for f in ("ones", "twos", "plain")}
        bits |= {b"".join(a.tobytes() for a in turned(other, x, f)) for f in ("ones", "twos", "plain")}
        assert len(bits) == 1


@pytest.mark.skipif(not HAS_LONG_DOUBLE, reason="needs a long double of 64 bits")
def test_fast_modules_keep_the_digits(tmp_path: Path) -> None:
    fast = library(tmp_path, *CompileOptions(fast=True).flags, *STRICT)
    for x in angles(20_000).values():
        s, c = turned(fast, x, "twos")
        assert places_off(s, np.sin(x.astype(np.longdouble))) < PLACES
        assert places_off(c, np.cos(x.astype(np.longdouble))) < PLACES


@pytest.mark.skipif(shutil.which("c++") is None, reason="needs a C++ compiler")
def test_the_header_is_strict_c_plus_plus_too(tmp_path: Path) -> None:
    (tmp_path / "rows.cpp").write_text(_ROWS, encoding="utf-8")
    for plain in ((), ("-DLAMC_PLAIN_TRIG",)):
        cc(
            tmp_path,
            *STRICT_CXX,
            *plain,
            f"-I{SOURCES}",
            f"-I{RUNTIME / 'include'}",
            "-c",
            "rows.cpp",
            compiler="c++",
        )


def test_machines_with_half_precision_take_the_same_sines(tmp_path: Path) -> None:
    """gcc -march=sapphirerapids says FLT_EVAL_METHOD = 16, where doubles are doubles: nothing is left to libm."""
    text = '#include <float.h>\n#undef FLT_EVAL_METHOD\n#define FLT_EVAL_METHOD {}\n#include "trig.h"\n'
    for method, own in ((0, True), (16, True), (2, False)):
        (tmp_path / "half.c").write_text(
            text.format(method) + f"#if {int(own)} != defined(LAMC_TRIG_TO_WHOLE)\n#error\n#endif\n",
            encoding="utf-8",
        )
        cc(tmp_path, f"-I{SOURCES}", f"-I{RUNTIME / 'include'}", "-fsyntax-only", "half.c")


def test_rows_are_sines_and_the_turn_is_a_turn() -> None:
    text = (SOURCES / "trig_rows.h").read_text(encoding="utf-8")
    rows = [tuple(map(float, row)) for row in re.findall(r"\{(\S+), (\S+)\}", text)]
    words = [int(word, 16) for word in re.findall(r"0x([0-9a-f]{8})u", text)]
    assert len(rows) == 160
    with mpmath.workprec(2000):
        for k, (first, rest) in enumerate(rows):
            exact = mpmath.sinpi(mpmath.mpf(k) / 64)
            assert first == round(exact * 2**26) / 2**26
            assert rest == float(exact - first)
        value = sum(mpmath.mpf(word) / mpmath.mpf(2) ** (32 * k + 32) for k, word in enumerate(words))
        # the last words' error, and two words of zeros before
        assert abs(value * 2**64 - 1 / (2 * mpmath.pi)) < mpmath.mpf(2) ** (64 - 32 * len(words))
