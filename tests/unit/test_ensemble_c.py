"""The C of ensembles: no warning, no undefined behaviour, as many lanes as a compiler has, and the bits of one."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

import lamc
from lamc.codegen.emit import SourceTree, emit
from lamc.codegen.emit_lanes import emit_lanes
from lamc.codegen.options import MACHINE, MOST_RATES_IN_LOOPS
from lamc.commands.examples import mechanism_of_example
from lamc.examples import find
from lamc.export.series import recording_of
from lamc.run.request import Array
from lamc.run.simulator import Simulator
from tests.support.ctools import SANITIZED, STRICT, cc, needs_cc, objects_of, output_of
from tests.support.every_effect import SAMPLES
from tests.support.every_effect import mechanism as two_links
from tests.support.mechanisms import ALL_PASSIVE, chain
from tests.support.paths import RUNTIME

INSTANCES = 13
LOOPS = (
    "four_bar",
    "two_loops",
    "waterbomb",
    "n_four_bar",
)  # the second and the last come near singular positions

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

static const double starts[COUNT * N] = {{{starts}}};
static double y[2][COUNT * ROWS * N], reached[COUNT], parameters[COUNT * STRIDE];
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
  for (int k = 0; k < COUNT; k++)
    for (int i = 0; i < STRIDE - 1; i++)
      parameters[k * STRIDE + i] =
          model->parameter_defaults[i] * (i < model->parameter_count ? 1.0 + 0.01 * k : 1.0);
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
    recording = None
    if name == "series":
        sim = lamc.compile(chain(3), driven())
        recording = recording_of(sim, lamc.ExportOptions())
    elif name in LOOPS:
        mechanism = mechanism_of_example(find(name))
        sim = lamc.compile(mechanism, mechanism.scene or lamc.Scene())
    elif name == "tree":
        sim = lamc.compile(chain(4), lamc.Scene(effects=ALL_PASSIVE))
    elif name == "long":
        sim = lamc.compile(chain(30), lamc.Scene(effects=ALL_PASSIVE))
    else:
        effects = (SAMPLES["gravity"], *((SAMPLES[name],) if name != "gravity" else ()))
        sim = lamc.compile(two_links(), lamc.Scene(effects=effects))
    tree = emit_lanes(sim.program, emit(sim.program, recording=recording))
    for file, text in tree.files.items():
        (folder / file).write_text(text)
    starts = ", ".join(map(repr, starts_of(sim).ravel().tolist()))
    (folder / "try.c").write_text(MAIN.format(prefix=tree.prefix, method=method, starts=starts))
    return tree


def driven() -> lamc.Scene:
    """A torque that follows a series with kinks and jumps."""
    series = lamc.Series([0.0, 0.03, 0.11, 0.12, 0.19, 0.3], [0.0, 0.1, -0.2, 0.1, 0.0, 0.2], "previous")
    torque = lamc.Torque({chain(3).joints[0].name: "command"})
    return lamc.Scene(
        effects=(*ALL_PASSIVE, torque), inputs={"command": lamc.Input(unit="N*m", series=series)}
    )


def starts_of(sim: Simulator) -> Array:
    """A start for each instance, (13, nq + nu): of a tree, angles beside that of the scene; of loops, states that a run
    comes through, which are closed."""
    if sim.cut_joints:
        run = sim.run(1.2, 1e-7, t_eval=np.linspace(0.0, 1.2, INSTANCES))
        return np.hstack([run.q, run.u])
    starts = np.tile(sim.start, (INSTANCES, 1))
    of_joints = np.arange(len(sim.joints))
    starts[:, of_joints] += 0.1 * (of_joints + 1.0) - 0.02 * np.arange(INSTANCES)[:, None]
    return starts


def printed(tree: SourceTree, folder: Path, flags: Sequence[str], machine: Sequence[str]) -> list[str]:
    """What `try.c` prints; `machine`: flags of the ensemble alone, as `lamc.codegen.build` has them."""
    objects = objects_of(tree, folder, *flags, machine=machine)
    cc(folder, *flags, *machine, "try.c", *objects, "-o", "try", "-lm")
    return output_of(folder / "try").split()


@needs_cc
@pytest.mark.quick("DOP853-ground_contact", others="campaign")
@pytest.mark.parametrize(
    "name", ["tree", "ground_contact", "nonlinear_stiffness", "free_base", "joint_limits", "series", *LOOPS]
)
@pytest.mark.parametrize("method", ["DOP853", "RK45"])
def test_sanitizers_find_nothing_and_lanes_give_the_bits_of_one(
    name: str, method: str, tmp_path: Path
) -> None:
    tree = made(tmp_path, name, method)
    width, ended, same = map(int, printed(tree, tmp_path, (*SANITIZED, "-ffp-contract=off"), MACHINE))
    assert width in (2, 4, 8) or (width == 1 and name in LOOPS)
    assert ended == 13
    assert same


@needs_cc
@pytest.mark.parametrize(
    ("flags", "width"), [((), 2), (("-mavx",), 4), (("-mavx2", "-mfma"), 4), (("-DLAMC_ONE_LANE",), 1)]
)
@pytest.mark.parametrize("name", ["tree", "two_loops"])
@pytest.mark.slow
@pytest.mark.ci("two_loops-*", "tree-flags1-4")
def test_other_machines_have_other_lanes_and_the_same_bits(
    flags: tuple[str, ...], width: int, name: str, tmp_path: Path
) -> None:
    """Of generic x86-64, of those with AVX, and of a compiler without vectors. (Run on a machine that has AVX2.)"""
    if flags and flags[0].startswith("-m") and "avx2" not in Path("/proc/cpuinfo").read_text():
        pytest.skip("this machine has no AVX2")
    tree = made(tmp_path, name, "DOP853")
    if name in LOOPS and width == 2:
        width = 1  # two lanes cost loops more than they save
    assert printed(tree, tmp_path, (*STRICT, "-O2", "-ffp-contract=off"), flags) == [str(width), "13", "1"]


@pytest.mark.slow
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
        "ensemble_work.h",
        "lane_loops.h",
        "lane_numbers.h",
        "lane_pivots.h",
        "lane_slopes.h",
        "lane_steps.h",
        "lanes.h",
    }


def test_small_loops_are_those_that_the_runtime_solves_as_one_array_of_largest_pivots() -> None:
    text = (RUNTIME / "src" / "loop_dense.h").read_text(encoding="utf-8")
    assert f"LARGE = {MOST_RATES_IN_LOOPS}\n" in text
