"""The C of sensitivities: no warning, no undefined behaviour, the rows of a run by itself, whatever its slices."""

from pathlib import Path

import pytest

import lamc
from lamc.codegen.emit import SourceTree, emit
from lamc.codegen.emit_tangents import emit_tangents
from lamc.mechanics import tangents
from lamc.mechanics.lower import lower
from lamc.mechanics.tangents import Columns
from tests.support.ctools import SANITIZED, STRICT, cc, needs_cc, objects_of, output_of
from tests.support.every_effect import SAMPLES
from tests.support.every_effect import mechanism as two_links

# A run by itself, one with derivatives in one piece, and one in slices with little room for rows
MAIN = """
#include "lamc_sensitivity.h"
#include "{prefix}.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum {{
  ROWS = 40,
  N = {prefix}_coordinate_count + {prefix}_rate_count,
  INPUTS = {prefix}_parameter_count + {prefix}_geometry_count,
  K = 3,
  S = K + N
}};

static const double start[N] = {{{start}}};
static double t[3][ROWS], y[3][ROWS * N], along[3][ROWS * N * S], times[ROWS];
static double directions[K * INPUTS], s0[N * S];

static double *numbers(long long count) {{
  return (double *)calloc((size_t)count, sizeof(double)); /* ends where its size says */
}}

static int run(int which, lamc_method method) {{
  const lamc_model *model = {prefix}_model();
  const lamc_options options = {{1e-8, 1e-10, 0, 0, 100000}};
  double *constants = numbers(model->constant_count), *work = numbers(lamc_motion_work_size(model) + 1);
  model->setup(model->parameter_defaults, constants);
  lamc_motion motion = {{model, constants, work, 0, NULL}};
  lamc_rows rows;
  memset(&rows, 0, sizeof rows);
  const lamc_ode ode = lamc_motion_ode(&motion);
  double *run_work = numbers(lamc_run_work_size(&ode, method));
  lamc_status status;
  if (which == 0) {{
    lamc_run r;
    rows.t = t[0];
    rows.y = y[0];
    rows.capacity = ROWS;
    status = lamc_run_start(&r, &ode, method, &options, 0, start, 0.2, times, ROWS, run_work);
    if (status == LAMC_OK) status = lamc_run_advance(&r, &rows, 0, NULL);
  }} else {{
    lamc_sensitivity s;
    const lamc_tangents *tangents = lamc_this_tangents();
    double *own = numbers(lamc_sensitivity_work_size(model, tangents, S));
    status = lamc_sensitivity_start(&s, &motion, tangents, model->parameter_defaults, directions, S, method,
                                    &options, 0, start, s0, 0.2, times, ROWS, run_work, own);
    long long done = 0;
    while (status >= 0 && done < ROWS) {{
      rows.t = t[which] + done;
      rows.y = y[which] + done * N;
      rows.capacity = which == 1 ? ROWS : 1;
      rows.count = 0;
      status = lamc_sensitivity_advance(&s, &rows, along[which] + done * N * S, which == 1 ? 0 : 7, NULL);
      done += rows.count;
      if (status == LAMC_OK && done < ROWS) break;
    }}
    free(own);
  }}
  free(constants);
  free(work);
  free(run_work);
  return status < 0 ? (int)status : 0;
}}

int main(void) {{
  int failed = 0, same = 1, finite = 1;
  for (int i = 0; i < ROWS; i++) times[i] = 0.2 * i / (ROWS - 1);
  for (int k = 0; k < K; k++) directions[k * INPUTS + k] = 1;
  for (int i = 0; i < N; i++) s0[i * S + K + i] = 1;
  for (int which = 0; which < 3; which++) failed |= run(which, LAMC_{method}) != 0;
  for (int which = 1; which < 3; which++)
    same &= memcmp(t[0], t[which], sizeof t[0]) == 0 && memcmp(y[0], y[which], sizeof y[0]) == 0;
  same &= memcmp(along[1], along[2], sizeof along[1]) == 0;
  for (int i = 0; i < ROWS * N * S; i++) finite &= isfinite(along[1][i]);
  printf("%d %d %d\\n", failed, same, finite);
  return 0;
}}
"""


def made(folder: Path, name: str, method: str) -> SourceTree:
    """The files of a model with derivatives in `folder`, with `try.c`, the program above."""
    if name == "loop":
        sim = lamc.compile(lamc.load(Path(lamc.__file__).parent / "examples" / "four_bar.yaml"))
    else:
        effects = (SAMPLES["gravity"], *((SAMPLES[name],) if name != "gravity" else ()))
        sim = lamc.compile(two_links(), lamc.Scene(effects=effects))
    program = lower(sim.equations, columns=Columns(tuple(sim.parameters)[:3]))
    tree = emit_tangents(program, emit(program))
    for file, text in tree.files.items():
        (folder / file).write_text(text)
    start = ", ".join(map(repr, sim.start.tolist()))
    (folder / "try.c").write_text(MAIN.format(prefix=tree.prefix, method=method, start=start))
    return tree


@needs_cc
@pytest.mark.quick("loop-DOP853", others="campaign")
@pytest.mark.parametrize(
    ("name", "method"),
    [
        ("gravity", "RK45"),
        ("loop", "DOP853"),
        ("loop", "RADAU5"),
        ("joint_limits", "DOP853"),
        ("free_base", "RODAS5P"),
        ("ground_contact", "DOP853"),
        ("servo", "RADAU5"),
    ],
)
def test_sanitizers_find_nothing_and_slices_do_not_matter(name: str, method: str, tmp_path: Path) -> None:
    tree = made(tmp_path, name, method)
    cc(tmp_path, *SANITIZED, "try.c", *objects_of(tree, tmp_path, *SANITIZED), "-o", "try", "-lm")
    assert output_of(tmp_path / "try").split() == ["0", "1", "1"]


@pytest.mark.slow
@needs_cc
def test_its_c_has_no_warnings(tmp_path: Path) -> None:
    tree = made(tmp_path, "joint_limits", "AUTO")
    flags = (*STRICT, "-O2", "-ffp-contract=off")
    cc(tmp_path, *flags, "try.c", *objects_of(tree, tmp_path, *flags), "-o", "try", "-lm")


@needs_cc
@pytest.mark.parametrize("flags", ["", "-DLAMC_ONE_LANE"])
def test_derivatives_by_the_start_only_have_no_warnings_either(
    flags: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Along directions, by no column: there is nothing to add, neither to rows nor to goals."""
    monkeypatch.setattr(tangents, "MAX_MATRIX", -1)
    sim = lamc.compile(lamc.load(Path(lamc.__file__).parent / "examples" / "four_bar.yaml"))
    program = lower(sim.equations, columns=Columns(()))
    assert "directional_tangents" in program.functions
    tree = emit_tangents(program, emit(program))
    for file, text in tree.files.items():
        (tmp_path / file).write_text(text)
    cc(tmp_path, *STRICT, *flags.split(), "-fsyntax-only", f"{tree.prefix}_tangents.c")


def test_the_c_of_a_model_is_the_same_beside_it() -> None:
    sim = lamc.compile(two_links(), lamc.Scene(effects=(SAMPLES["gravity"],)))
    program = lower(sim.equations, columns=Columns(("gravity.x",)))
    plain = emit(program)
    tree = emit_tangents(program, plain)
    assert {name: tree.files[name] for name in plain.files} == plain.files
