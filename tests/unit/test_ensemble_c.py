"""The C of ensembles: no warning, no undefined behaviour, as many lanes as a compiler has, and the bits of one."""

from collections.abc import Sequence
from pathlib import Path

import pytest

import lamc
from lamc.codegen.emit import SourceTree, emit
from lamc.codegen.emit_lanes import emit_lanes
from lamc.codegen.options import MACHINE
from tests.support.ctools import SANITIZED, STRICT, cc, needs_cc, objects_of, output_of
from tests.support.every_effect import SAMPLES
from tests.support.every_effect import mechanism as two_links
from tests.support.mechanisms import ALL_PASSIVE, chain

# Instances of a model by lanes, then one after the other: all bytes of their rows, and what is told of them
MAIN = """
#include "lamc_ensemble.h"
#include "{prefix}.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum {{
  COUNT = 13,
  ROWS = 5,
  N = {prefix}_coordinate_count + {prefix}_rate_count,
  STRIDE = {prefix}_parameter_count + {prefix}_geometry_count + 1
}};

static const double start[N] = {{{start}}};
static double y[2][COUNT * ROWS * N], reached[COUNT], parameters[COUNT * STRIDE];
static double starts[COUNT * N];
static int status[2][COUNT];
static long long told[2][COUNT * LAMC_TOLD];

static int run(lamc_ensemble *e, int which) {{
  long long next = 0;
  e->next = &next;
  e->use_lanes = which == 0;
  e->y = y[which];
  e->status = status[which];
  e->told = told[which];
  double *work = (double *)malloc((size_t)lamc_ensemble_work_size(e) * sizeof *work); /* ends where its size says */
  const lamc_status done = lamc_ensemble_run(e, work);
  free(work);
  return done == LAMC_OK ? lamc_ensemble_width(e) : -1;
}}

int main(void) {{
  const lamc_model *model = {prefix}_model();
  static const double rows[ROWS] = {{0.0, 0.05, 0.1, 0.15, 0.2}};
  const lamc_options options = {{1e-7, 1e-9, 0.0, 0.0, 20000}};
  lamc_ensemble e;
  memset(&e, 0, sizeof e);
  for (int k = 0; k < COUNT; k++) {{
    for (int i = 0; i < STRIDE - 1; i++)
      parameters[k * STRIDE + i] =
          model->parameter_defaults[i] * (i < model->parameter_count ? 1.0 + 0.01 * k : 1.0);
    for (int i = 0; i < N; i++)
      starts[k * N + i] = start[i] + (i < {prefix}_joint_count ? 0.1 * (i + 1) - 0.02 * k : 0.0);
  }}
  e.model = model;
  e.method = LAMC_{method};
  e.options = options;
  e.t_end = 0.2;
  e.t_eval = rows;
  e.row_count = ROWS;
  e.count = COUNT;
  e.parameters = parameters;
  e.parameter_stride = STRIDE;
  e.starts = starts;
  e.start_stride = N;
  e.t_reached = reached;
  const int width = run(&e, 0);
  if (width < 0 || run(&e, 1) != 1) return 1;
  int ended = 0;
  for (int k = 0; k < COUNT; k++) ended += status[0][k] == LAMC_OK;
  printf("%d %d %d\\n", width, ended,
         memcmp(y[0], y[1], sizeof y[0]) == 0 && memcmp(told[0], told[1], sizeof told[0]) == 0 &&
             memcmp(status[0], status[1], sizeof status[0]) == 0);
  return 0;
}}
"""


def made(folder: Path, name: str, method: str) -> SourceTree:
    """The files of an ensemble in `folder`, with `try.c`, the program above."""
    if name == "tree":
        sim = lamc.compile(chain(4), lamc.Scene(effects=ALL_PASSIVE))
    elif name == "long":
        sim = lamc.compile(chain(30), lamc.Scene(effects=ALL_PASSIVE))
    else:
        effects = (SAMPLES["gravity"], *((SAMPLES[name],) if name != "gravity" else ()))
        sim = lamc.compile(two_links(), lamc.Scene(effects=effects))
    tree = emit_lanes(sim.program, emit(sim.program))
    for file, text in tree.files.items():
        (folder / file).write_text(text)
    start = ", ".join(map(repr, sim.start.tolist()))
    (folder / "try.c").write_text(MAIN.format(prefix=tree.prefix, method=method, start=start))
    return tree


def printed(tree: SourceTree, folder: Path, flags: Sequence[str], machine: Sequence[str]) -> list[str]:
    """What `try.c` prints; `machine`: flags of the ensemble alone, as `lamc.codegen.build` has them."""
    objects = objects_of(tree, folder, *flags, machine=machine)
    cc(folder, *flags, *machine, "try.c", *objects, "-o", "try", "-lm")
    return output_of(folder / "try").split()


@needs_cc
@pytest.mark.quick("DOP853-ground_contact")
@pytest.mark.parametrize(
    "name", ["tree", "ground_contact", "nonlinear_stiffness", "free_base", "joint_limits"]
)
@pytest.mark.parametrize("method", ["DOP853", "RK45"])
def test_sanitizers_find_nothing_and_lanes_give_the_bits_of_one(
    name: str, method: str, tmp_path: Path
) -> None:
    tree = made(tmp_path, name, method)
    width, ended, same = map(int, printed(tree, tmp_path, SANITIZED, MACHINE))
    assert width in (2, 4, 8)
    assert ended == 13
    assert same


@needs_cc
@pytest.mark.parametrize(
    ("flags", "width"), [((), 2), (("-mavx",), 4), (("-mavx2", "-mfma"), 4), (("-DLAMC_ONE_LANE",), 1)]
)
def test_other_machines_have_other_lanes_and_the_same_bits(
    flags: tuple[str, ...], width: int, tmp_path: Path
) -> None:
    """Of generic x86-64, of those with AVX, and of a compiler without vectors. (Run on a machine that has AVX2.)"""
    if flags and flags[0].startswith("-m") and "avx2" not in Path("/proc/cpuinfo").read_text():
        pytest.skip("this machine has no AVX2")
    tree = made(tmp_path, "tree", "DOP853")
    assert printed(tree, tmp_path, (*STRICT, "-O2", "-ffp-contract=off"), flags) == [str(width), "13", "1"]


@needs_cc
def test_long_equations_have_lanes_too(tmp_path: Path) -> None:
    """Thirty hinges are more statements than a block: kernels and tables of indices."""
    tree = made(tmp_path, "long", "RK45")
    assert "acceleration_kernel_" in tree.files[tree.machine[0]]
    assert printed(tree, tmp_path, (*STRICT, "-O1", "-ffp-contract=off"), MACHINE)[1:] == ["13", "1"]


def test_the_c_of_a_model_is_the_same_with_lanes_beside_it() -> None:
    program = lamc.compile(chain(2), lamc.Scene(effects=ALL_PASSIVE)).program
    plain = emit(program)
    tree = emit_lanes(program, plain)
    assert {name: tree.files[name] for name in plain.files} == plain.files
    assert set(tree.files) - set(plain.files) == {
        f"{tree.prefix}_lanes.c",
        "ensemble.c",
        "lamc_ensemble.h",
        "lane_numbers.h",
        "lane_steps.h",
        "lanes.h",
    }
