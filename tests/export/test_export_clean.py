"""Exported C keeps its promises to the program around it: nothing allocated, nothing shared, nothing out of bounds."""

import re
from collections.abc import Sequence
from pathlib import Path

import pytest

from tests.support.ctools import needs_cc, sanitizer_works
from tests.support.exported_folders import KINDS, STRICT, cc, does, exported, needs, put

pytestmark = needs_cc

# gcc itself emits calls of the last three for copies and zeros; the sources have none.
MATH = {
    *(
        "acos",
        "asin",
        "atan",
        "atan2",
        "cbrt",
        "ceil",
        "copysign",
        "cos",
        "cosh",
        "erf",
        "exp",
        "expm1",
        "fabs",
    ),
    *(
        "floor",
        "fmax",
        "fmin",
        "fmod",
        "hypot",
        "isfinite",
        "ldexp",
        "log",
        "log10",
        "log1p",
        "log2",
        "pow",
        "round",
    ),
    *("scalbn", "sin", "sincos", "sinh", "sqrt", "tan", "tanh", "trunc", "nextafter", "fma", "frexp"),
}
BLOCKS = {"memcpy", "memset", "memmove"}


@needs("nm", "size")
@pytest.mark.parametrize("name", KINDS)
@pytest.mark.quick("pendulum", "limit_stop", others="campaign")
def test_nothing_is_allocated_nothing_is_writable_and_only_the_api_is_seen(name: str, tmp_path: Path) -> None:
    folder = put(exported(name), tmp_path)
    # Code at a fixed address: elsewhere tables of names are filled in by the loader, and then made read-only.
    cc(folder, "-std=c99", "-fno-pic", "-fno-pie", "-c", f"{name}.c", "-o", "it.o")
    symbols = [line.split()[-2:] for line in does(["nm", "it.o"], folder).splitlines()]
    kinds = {symbol: kind for kind, symbol in symbols}
    assert {s for s, kind in kinds.items() if kind in "BbCDdGgSs"} == set()
    assert {s for s, kind in kinds.items() if kind == "U"} <= MATH | BLOCKS
    header = (folder / f"{name}.h").read_text(encoding="utf-8")
    declared = set(re.findall(rf"^{name.upper()}_API .*?(\w+)\(", header, re.MULTILINE))
    assert {s for s, kind in kinds.items() if kind == "T"} == declared
    sections = dict(re.findall(r"^\.(data|bss)\s+(\d+)", does(["size", "-A", "it.o"], folder), re.MULTILINE))
    assert set(sections.values()) <= {"0"}  # clang leaves empty ones out


@pytest.mark.parametrize("name", KINDS)
def test_the_header_is_alone_and_the_source_needs_it_and_math_only(name: str) -> None:
    """Beside headers that have no functions, which compilers bring without a library."""
    files = exported(name)
    included = {
        suffix: re.findall(r"^\s*#\s*include\s*(\S+)", files[f"{name}.{suffix}"].decode(), re.MULTILINE)
        for suffix in "hc"
    }
    assert included["h"] == []
    assert set(included["c"]) <= {
        f'"{name}.h"',
        "<math.h>",
        "<float.h>",
        "<limits.h>",
        "<stddef.h>",
        "<stdint.h>",
    }


# --- sanitizers ---------------------------------------------------------------------------------------------------

# All structs on the heap, of their own size, so that a step beyond is seen. @ is the prefix, & in capitals.
_ALL_FUNCTIONS = """
#include "@.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define CHECK(call, wanted) do { const @_status s = (call); if (s != (wanted)) { \\
  printf("line %d: %s\\n", __LINE__, @_status_message(s)); return 1; } } while (0)

enum { nq = @_coordinate_count, nu = @_rate_count };

static double *doubles(int count) { return (double *)calloc((size_t)(count > 0 ? count : 1), sizeof(double)); }

int main(void) {
  @_t *it = (@_t *)malloc(sizeof *it), *other = (@_t *)malloc(sizeof *other), *copy = (@_t *)malloc(sizeof *copy);
  @_parameters *p = (@_parameters *)malloc(sizeof *p);
  @_inputs *in = (@_inputs *)malloc(sizeof *in);
  @_settings *set = (@_settings *)malloc(sizeof *set);
  @_outputs *out = (@_outputs *)malloc(sizeof *out);
  @_state *state = (@_state *)malloc(sizeof *state);
  double *y = doubles(nq + nu), *dydt = doubles(nq + nu), *energies = doubles(@_energy_count);
  double *by_q = doubles(nu * nq), *by_u = doubles(nu * nu), *by_inputs = doubles(nu * @_input_count);
  memset(it, 0xa5, sizeof *it);
  CHECK(@_step(it, 1.0), &_BAD_DIGEST); /* never initialised */
  @_default_parameters(p);
  @_default_inputs(in);
  @_default_settings(set);
  CHECK(@_init(it, p, set), &_OK);
  CHECK(@_init(other, NULL, NULL), &_OK);
  CHECK(@_set_inputs(it, in), &_OK);
  for (int k = 1; k <= 30; k++) {
    CHECK(@_step(it, 0.003 * k), &_OK);
    CHECK(@_get_outputs(it, out), &_OK);
    CHECK(@_energy(it, energies), &_OK);
  }
  CHECK(@_step(it, 0.0), &_IN_PAST);
  CHECK(@_step(it, NAN), &_BAD_ARGUMENT);
  CHECK(@_step_fixed(it, -1e-3), &_BAD_ARGUMENT);
  CHECK(@_step_fixed(it, 0.0), &_BAD_ARGUMENT);
  CHECK(@_step_fixed(it, NAN), &_BAD_ARGUMENT);
  for (int k = 0; k < nq; k++) y[k] = it->q[k];
  for (int k = 0; k < nu; k++) y[nq + k] = it->u[k];
  CHECK(@_rhs(it, it->t, y, dydt), &_OK);
  CHECK(@_jacobian(it, by_q, by_u, by_inputs), &_OK);
  CHECK(@_jacobian(it, by_q, by_u, NULL), &_OK);
  CHECK(@_get_state(it, state), &_OK);
  CHECK(@_set_state(other, state), &_OK);
  *copy = *it;
  for (int k = 1; k <= 10; k++) {
    const double t = it->t + 0.002;
    CHECK(@_step(it, t), &_OK);
    CHECK(@_step(other, t), &_OK);
    CHECK(@_step(copy, t), &_OK);
    if (memcmp(it->q, other->q, sizeof it->q) || memcmp(it->u, copy->u, sizeof it->u)) return 2;
  }
  CHECK(@_set_parameters(it, p), &_OK);
  for (int k = 0; k < 10; k++) CHECK(@_step_fixed(it, 1e-4), &_OK);
  CHECK(@_start(it, 0.0, y, y + nq), &_OK);
  CHECK(@_step(it, 0.01), &_OK);
  if (nq > 0) {
    y[0] = INFINITY;
    CHECK(@_start(it, 0.0, y, y + nq), &_BAD_STATE);
    CHECK(@_rhs(it, 0.0, y, dydt), &_BAD_STATE);
  }
  CHECK(@_step(NULL, 1.0), &_BAD_ARGUMENT);
  CHECK(@_init(NULL, NULL, NULL), &_BAD_ARGUMENT);
  CHECK(@_get_outputs(it, NULL), &_BAD_ARGUMENT);
  CHECK(@_get_state(it, NULL), &_BAD_ARGUMENT);
  memset(state, 0x5a, sizeof *state);
  CHECK(@_set_state(it, state), &_BAD_DIGEST);
  memset(p, 0, sizeof *p);
  CHECK(@_set_parameters(it, p), &_BAD_DIGEST);
  CHECK(@_init(it, p, NULL), &_BAD_DIGEST);
  for (int i = -1; i < 200; i++) {
    const char *names[] = {@_joint_name(i), @_coordinate_name(i), @_coordinate_unit(i), @_rate_name(i), @_rate_unit(i),
                           @_parameter_name(i), @_parameter_unit(i), @_input_name(i), @_input_unit(i), @_body_name(i),
                           @_energy_name(i), @_status_message((@_status)(i - 100))};
    for (int k = 0; k < 12; k++) if (names[k] != NULL) energies[0] += (double)strlen(names[k]);
  }
  free(it); free(other); free(copy); free(p); free(in); free(set); free(out); free(state);
  free(y); free(dydt); free(energies); free(by_q); free(by_u); free(by_inputs);
  puts("clean");
  return 0;
}
"""


@pytest.mark.parametrize("name", [*KINDS, "folding_box"])
@pytest.mark.quick("limit_stop", others="campaign")
def test_every_function_runs_clean_under_the_address_and_undefined_behaviour_sanitizers(
    name: str, tmp_path: Path
) -> None:
    flags = ("-std=c99", "-g", "-fsanitize=address,undefined", "-fno-sanitize-recover=all")
    if not sanitizer_works(tmp_path, *flags):
        pytest.skip("this compiler has no address and undefined-behaviour sanitizers")
    folder = put(exported(name), tmp_path)
    (folder / "driver.c").write_text(_ALL_FUNCTIONS.replace("@", name).replace("&_", f"{name.upper()}_"))
    cc(folder, *flags, *STRICT, "driver.c", f"{name}.c", "-lm", "-o", "driver")
    assert does([folder / "driver"], folder) == "clean\n"


# @includes, @run one function per model, @table of them
_THREADS = """
#include <pthread.h>
#include <stdio.h>
#include <string.h>
@includes

enum { threads = 8, models = @models, most = 64 };

typedef struct result { double values[models][most]; int status; } result;

@functions

static int (*const run[models])(double *) = {@table};

static void *work(void *where) {
  result *r = (result *)where;
  for (int k = 0; k < models; k++) r->status |= run[k](r->values[k]);
  return NULL;
}

int main(void) {
  static result alone, together[threads];
  pthread_t thread[threads];
  work(&alone);
  for (int k = 0; k < threads; k++) if (pthread_create(&thread[k], NULL, work, &together[k])) return 3;
  for (int k = 0; k < threads; k++) pthread_join(thread[k], NULL);
  for (int k = 0; k < threads; k++) {
    if (together[k].status || alone.status) return 4;
    if (memcmp(&together[k], &alone, sizeof alone)) return 5;
  }
  puts("alike");
  return 0;
}
"""
_ONE_RUN = """
static int run_@(double *values) {
  @_t it;
  int status = @_init(&it, NULL, NULL);
  for (int k = 1; k <= 10 && !status; k++) status = @_step(&it, 0.005 * k);
  memcpy(values, it.q, sizeof it.q);
  memcpy(values + @_coordinate_count, it.u, sizeof it.u);
  return status;
}
"""


def with_threads(folder: Path, names: Sequence[str], *flags: str) -> str:
    for name in names:
        put(exported(name), folder)
        cc(folder, *flags, "-c", f"{name}.c")
    text = _THREADS.replace("@includes", "\n".join(f'#include "{name}.h"' for name in names))
    text = text.replace("@functions", "".join(_ONE_RUN.replace("@", name) for name in names))
    text = text.replace("@models", str(len(names))).replace(
        "@table", ", ".join(f"run_{name}" for name in names)
    )
    (folder / "threads.c").write_text(text)
    objects = [f"{name}.o" for name in names]
    cc(folder, *flags, "threads.c", *objects, "-lm", "-lpthread", "-o", "threads")
    return does([folder / "threads"], folder)


@pytest.mark.slow
def test_eight_threads_run_four_models_and_get_the_bits_of_one(tmp_path: Path) -> None:
    assert with_threads(tmp_path, KINDS, "-std=c99") == "alike\n"


@pytest.mark.slow
def test_eight_threads_are_clean_under_the_thread_sanitizer(tmp_path: Path) -> None:
    flags = ("-std=c99", "-g", "-fsanitize=thread")
    if not sanitizer_works(tmp_path, *flags):
        pytest.skip("this compiler, or this kernel, has no thread sanitizer")
    assert with_threads(tmp_path, KINDS, *flags) == "alike\n"
