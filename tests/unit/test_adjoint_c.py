"""The C of gradients: no warning, no undefined behaviour, the rows of a run by itself, whatever the slices and
tapes."""

from dataclasses import replace
from pathlib import Path

import pytest

import lamc
from lamc.codegen.emit import SourceTree, emit
from lamc.codegen.emit_pullbacks import emit_pullbacks
from lamc.mechanics.lower import lower
from tests.support.ctools import SANITIZED, STRICT, cc, needs_cc, objects_of, output_of
from tests.support.every_effect import SAMPLES
from tests.support.every_effect import mechanism as two_links

# A run by itself, one with one tape, and one in slices with little room on each of its tapes; then the ways back
MAIN = """
#include "lamc_adjoint.h"
#include "{prefix}.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum {{
  ROWS = 40,
  N = {prefix}_coordinate_count + {prefix}_rate_count,
  INPUTS = {prefix}_parameter_count + {prefix}_geometry_count,
  TAPES = 4000
}};

static const double start[N] = {{{start}}};
static double t[3][ROWS], y[3][ROWS * N], times[ROWS], seeds[ROWS * N], found[3][N + INPUTS + 1];
static long long at[3][ROWS];
static lamc_tape tapes[TAPES];

static double *numbers(long long count) {{
  return (double *)calloc((size_t)count, sizeof(double)); /* ends where its size says */
}}

static int back(const lamc_motion *motion, int which, int count) {{
  const lamc_pullbacks *pullbacks = lamc_this_pullbacks();
  const lamc_model *model = motion->model;
  double *work = numbers(lamc_adjoint_work_size(model, pullbacks));
  double *weights = numbers(12 * model->body_count + model->energy_count);
  for (int i = 0; i < 12 * model->body_count + model->energy_count; i++) weights[i] = 1;
  lamc_adjoint a;
  lamc_adjoint_start(&a, motion, pullbacks, t[which], y[which], at[which], seeds, ROWS, 1e-8, work);
  lamc_status status = lamc_adjoint_outputs(&a, 1, t[which], y[which], weights,
                                            weights + 12 * model->body_count, found[0]);
  long long first = 0;
  for (int k = 0; k < count; k++) first += tapes[k].count;
  for (int k = count - 1; k >= 0 && status == LAMC_OK; k--) {{
    first -= tapes[k].count;
    status = lamc_adjoint_back(&a, &tapes[k], first);
  }}
  if (status == LAMC_OK) status = lamc_adjoint_end(&a, 0, start);
  memcpy(found[which], a.state, sizeof start);
  pullbacks->setup(motion->constants, a.sources, found[which] + N);
  free(work);
  free(weights);
  return status != LAMC_OK;
}}

static int run(int which, lamc_method method) {{
  const lamc_model *model = {prefix}_model();
  const lamc_options options = {{1e-8, 1e-10, 0, 0, 100000}};
  double *constants = numbers(model->constant_count), *work = numbers(lamc_motion_work_size(model) + 1);
  model->setup(model->parameter_defaults, constants);
  lamc_motion motion = {{model, constants, work, 0, NULL}};
  lamc_rows rows;
  memset(&rows, 0, sizeof rows);
  rows.capacity = ROWS;
  const lamc_ode ode = lamc_motion_ode(&motion);
  double *run_work = numbers(lamc_run_work_size(&ode, method));
  lamc_status status;
  int used = 0, failed = 0;
  if (which == 0) {{
    lamc_run r;
    rows.t = t[0];
    rows.y = y[0];
    status = lamc_run_start(&r, &ode, method, &options, 0, start, 0.2, times, ROWS, run_work);
    if (status == LAMC_OK) status = lamc_run_advance(&r, &rows, 0, NULL);
  }} else {{
    lamc_taped s;
    const long long size = lamc_tape_entry_size(model);
    status = lamc_taped_start(&s, &motion, method, &options, 0, start, 0.2, times, ROWS, run_work);
    long long done = 0;
    while (status >= 0 && done < ROWS && used < TAPES) {{
      if (used == 0 || tapes[used - 1].capacity - tapes[used - 1].count < lamc_tape_margin()) {{
        tapes[used].capacity = which == 1 ? 10000 : lamc_tape_margin() + 3;
        tapes[used].count = 0;
        tapes[used].entries = numbers(tapes[used].capacity * size);
        used++;
      }}
      rows.t = t[which] + done;
      rows.y = y[which] + done * N;
      rows.capacity = which == 1 ? ROWS : 1;
      rows.count = 0;
      status = lamc_taped_advance(&s, &tapes[used - 1], &rows, at[which] + done, which == 1 ? 0 : 7, NULL);
      done += rows.count;
      failed |= s.overflow;
      if (status == LAMC_OK && done < ROWS) break;
    }}
    model->setup(model->parameter_defaults, constants);
    failed |= back(&motion, which, used);
    for (int k = 0; k < used; k++) free(tapes[k].entries);
  }}
  free(constants);
  free(work);
  free(run_work);
  return failed || status < 0;
}}

int main(void) {{
  int failed = 0, same = 1, finite = 1, moves = 0;
  for (int i = 0; i < ROWS; i++) times[i] = 0.2 * i / (ROWS - 1);
  for (int i = 0; i < ROWS * N; i++) seeds[i] = 0.1 * (i % 7) - 0.25;
  for (int which = 0; which < 3; which++) failed |= run(which, LAMC_{method});
  for (int which = 1; which < 3; which++)
    same &= memcmp(t[0], t[which], sizeof t[0]) == 0 && memcmp(y[0], y[which], sizeof y[0]) == 0;
  same &= memcmp(found[1], found[2], sizeof found[1]) == 0;
  for (int i = 0; i < N + INPUTS; i++) {{
    finite &= isfinite(found[1][i]);
    moves |= found[1][i] != 0;
  }}
  printf("%d %d %d %d\\n", failed, same, finite, moves);
  return 0;
}}
"""


def made(folder: Path, name: str, method: str) -> SourceTree:
    """The files of a model with pullbacks in `folder`, with `try.c`, the program above."""
    examples = Path(lamc.__file__).parent / "examples"
    if name == "loop":
        sim = lamc.compile(lamc.load(examples / "four_bar.yaml"))
    elif name == "impacts":
        design = lamc.load(examples / "limit_stop.yaml")
        effects = (lamc.Gravity(), lamc.HingeStiffness(), lamc.JointLimits(restitution=0.6))
        sim = lamc.compile(design, replace(design.scene, effects=effects))
    elif name == "samples":
        servo = replace(SAMPLES["servo"], period=0.013)
        sim = lamc.compile(two_links(), lamc.Scene(effects=(SAMPLES["gravity"], servo)))
    else:
        effects = (SAMPLES["gravity"], *((SAMPLES[name],) if name != "gravity" else ()))
        sim = lamc.compile(two_links(), lamc.Scene(effects=effects))
    program = lower(sim.equations, pullbacks=True)
    tree = emit_pullbacks(program, emit(program))
    for file, text in tree.files.items():
        (folder / file).write_text(text)
    start = ", ".join(map(repr, sim.start.tolist()))
    (folder / "try.c").write_text(MAIN.format(prefix=tree.prefix, method=method, start=start))
    return tree


@needs_cc
@pytest.mark.quick("gravity-RK45", others="campaign")
@pytest.mark.parametrize(
    ("name", "method"),
    [
        ("gravity", "RK45"),
        ("loop", "DOP853"),
        ("loop", "RADAU5"),
        ("joint_limits", "DOP853"),
        ("free_base", "RODAS5P"),
        ("ground_contact", "RK45"),
        ("impacts", "DOP853"),
        ("samples", "RADAU5"),
    ],
)
def test_sanitizers_find_nothing_and_tapes_do_not_matter(name: str, method: str, tmp_path: Path) -> None:
    tree = made(tmp_path, name, method)
    flags = (*SANITIZED, "-ffp-contract=off")
    cc(tmp_path, *flags, "try.c", *objects_of(tree, tmp_path, *flags), "-o", "try", "-lm")
    assert output_of(tmp_path / "try").split() == ["0", "1", "1", "1"]


@needs_cc
@pytest.mark.slow
def test_its_c_has_no_warnings(tmp_path: Path) -> None:
    tree = made(tmp_path, "joint_limits", "AUTO")
    cc(tmp_path, *STRICT, "-O2", *tree.compiled, *tree.machine, *tree.beside, "try.c", "-o", "try", "-lm")


def test_the_c_of_a_model_is_the_same_beside_it() -> None:
    sim = lamc.compile(two_links(), lamc.Scene(effects=(SAMPLES["gravity"],)))
    program = lower(sim.equations, pullbacks=True)
    plain = emit(program)
    tree = emit_pullbacks(program, plain)
    assert {name: tree.files[name] for name in plain.files} == plain.files
