"""What the header says that a step of fixed length takes at most, against what one does: its own C, compiled with
numbers that count their operations."""

import subprocess
from pathlib import Path

import pytest

import lamc
from lamc.export.bound import step_bound
from lamc.export.c import c_source
from lamc.export.driven import simulator_of
from tests.support.exported_folders import KINDS, cc, mechanism_of, needs, scene_of

OWN_TRIG = (
    100  # operations of lamc's own sine and cosine of one angle, which the bound has as one call or two
)

COUNTING = r"""
#include <cfloat>
#include <climits>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstring>
static long long operations, calls;
struct counted {
  double x;
  counted() = default;
  constexpr counted(double value) : x(value) {}
  template <class T> explicit constexpr operator T() const { return static_cast<T>(x); }
};
#define OPERATOR(o) \
  static inline counted operator o(counted a, counted b) { operations++; return counted(a.x o b.x); } \
  static inline counted &operator o##=(counted &a, counted b) { return a = a o b; }
OPERATOR(+) OPERATOR(-) OPERATOR(*) OPERATOR(/)
static inline counted operator-(counted a) { return counted(-a.x); }
#define COMPARISON(o) static inline bool operator o(counted a, counted b) { return a.x o b.x; }
COMPARISON(<) COMPARISON(>) COMPARISON(<=) COMPARISON(>=) COMPARISON(==) COMPARISON(!=)
static inline counted fabs(counted a) { return counted(std::fabs(a.x)); }
static inline counted sqrt(counted a) { operations++; return counted(std::sqrt(a.x)); }
#define CALL(f) static inline counted f(counted a) { calls++; return counted(std::f(a.x)); }
CALL(sin) CALL(cos) CALL(tan) CALL(asin) CALL(acos) CALL(atan) CALL(exp) CALL(log) CALL(tanh) CALL(sinh) CALL(cosh)
static inline counted pow(counted a, counted b) { calls++; return counted(std::pow(a.x, b.x)); }
static inline counted atan2(counted a, counted b) { calls++; return counted(std::atan2(a.x, b.x)); }
static inline counted fmax(counted a, counted b) { return counted(std::fmax(a.x, b.x)); }
static inline counted fmin(counted a, counted b) { return counted(std::fmin(a.x, b.x)); }
#undef __GNUC__ // vectors of two numbers that count are none
#define double counted
#include "NAME.c"
#undef double

int main() {
  static NAME_t it;
  if (NAME_init(&it, nullptr, nullptr) != 0) return 1;
  long long most = 0, most_calls = 0;
  for (int k = 0; k < STEPS; k++) {
    operations = calls = 0;
    if (NAME_step_fixed(&it, counted(LENGTH)) != 0) return 2;
    if (operations > most) most = operations;
    if (calls > most_calls) most_calls = calls;
  }
  std::printf("%lld %lld\n", most, most_calls);
  return 0;
}
"""


@needs("g++")
@pytest.mark.parametrize("integrator", ["auto", "rodas5p"])
@pytest.mark.parametrize("name", [*KINDS, "stiff_triple", "folding_box"])
@pytest.mark.quick("pendulum-auto", others="campaign")
def test_no_step_takes_more(name: str, integrator: str, tmp_path: Path) -> None:
    options = lamc.ExportOptions(real_time=True, integrator=integrator, prefix="model", jacobian=False)
    source = c_source(simulator_of(mechanism_of(name), scene_of(name), options), options)
    steps = 5000
    text = COUNTING.replace("NAME", "model").replace("STEPS", str(steps))
    text = text.replace("LENGTH", "2e-5")  # s, which hard stops bear
    for file, content in {**source.files, "count.cc": text}.items():
        (tmp_path / file).write_text(content)
    cc(tmp_path, "-std=c++17", "-O1", "-ffp-contract=off", "count.cc", "-o", "count", command=["g++"])
    done = subprocess.run([tmp_path / "count"], capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 0, done.stderr
    operations, calls = map(int, done.stdout.split())
    bound = step_bound(source.program, options)
    assert calls <= bound.calls
    assert operations <= bound.operations + OWN_TRIG * bound.calls
    assert f"at most {bound.operations} operations" in source.header
    if not source.program.cuts and not source.program.guards:
        assert (
            operations >= bound.operations
        )  # every step takes them all: a count that is too high is wrong, too
