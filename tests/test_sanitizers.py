"""Generated C and runtime under the address and undefined-behaviour sanitizers: not one word from them."""

import subprocess
from pathlib import Path

import pytest

from lamc.codegen.build import write_sources
from lamc.codegen.layout import MAX_BLOCK_AT_EVERY_STEP
from lamc.effects import Torque
from lamc.mechanism.records import Body, Mechanism
from lamc.pipeline import equations_of, sources_of
from tests.ctools import CC, STRICT, cc, needs_cc
from tests.mechanisms import ALL_PASSIVE, chain, random_tree

FLAGS = (
    *STRICT,
    "-O0",
    "-g",
    "-fsanitize=address,undefined",
    "-fno-sanitize-recover=all",
    "-fno-omit-frame-pointer",
)

pytestmark = needs_cc

# Arrays live on the heap and have exactly the size that the header states, so that one step beyond is seen.
_DRIVER = """
#include "@.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

static double *vector(int count) {
  double *v = malloc(sizeof(double) * (size_t)(count > 0 ? count : 1));
  if (v == NULL) exit(9);
  for (int i = 0; i < count; ++i) v[i] = 0.3 * (i % 7) - 1.0;
  return v;
}

int main(void) {
  const lamc_model *m = @_model();
  const int n = m->joint_count;
  @_parameters *p = malloc(sizeof *p);
  double *c = vector(m->constant_count), *q = vector(n), *u = vector(n), *udot = vector(n);
  double *energies = vector(m->energy_count), *poses = vector(12 * m->body_count);
  double sum = 0.0;
  if (p == NULL) return 9;
  @_default_parameters(p);
  @_setup(p, c);
  for (int k = 0; k < 20; ++k) {
    for (int i = 0; i < n; ++i) q[i] += 0.37;
    @_acceleration(c, 0.1 * k, q, u, udot);
    @_energy(c, 0.1 * k, q, u, energies);
    @_poses(c, q, poses);
    for (int i = 0; i < n; ++i) sum += udot[i];
    for (int i = 0; i < m->energy_count; ++i) sum += energies[i];
    for (int i = 0; i < 12 * m->body_count; ++i) sum += poses[i];
  }
  m->setup(m->parameter_defaults, c);
  const lamc_motion motion = {m, c, NULL};
  double *y = vector(2 * n), t = 0.0;
  lamc_motion_accelerations(&motion, 1, &t, y, udot);
  lamc_motion_energies(&motion, 1, &t, y, energies);
  lamc_motion_poses(&motion, 1, y, poses);
  for (int i = 0; i < n; ++i) puts(m->joint_names[i]);
  for (int i = 0; i < m->body_count; ++i) puts(m->body_names[i]);
  for (int i = 0; i < m->energy_count; ++i) puts(m->energy_names[i]);
  for (int i = 0; i < m->parameter_count; ++i) printf("%s %s %g\\n", m->parameter_names[i], m->parameter_units[i],
                                                      m->parameter_defaults[i]);
  free(p); free(c); free(q); free(u); free(udot); free(energies); free(poses); free(y);
  return isfinite(sum) ? 0 : 3;
}
"""

LONG = ("loops", "long tree")
MECHANISMS = {
    "straight": chain(4, "space", seed=1),
    "loops": chain(30, "laminate", seed=2),
    "long tree": random_tree(30, seed=3, kind="mixed"),
    "nothing moves": Mechanism((Body("slab", fixed=True),), (), name="slab"),
}


def works(folder: Path) -> bool:
    (folder / "probe.c").write_text("int main(void) { return 0; }\n")
    command = [*CC.split(), *FLAGS, "probe.c", "-o", "probe"]
    if subprocess.run(command, cwd=folder, capture_output=True, check=False).returncode != 0:
        return False
    return subprocess.run([folder / "probe"], capture_output=True, check=False).returncode == 0


@pytest.mark.parametrize("name", sorted(MECHANISMS))
def test_generated_c_runs_clean(name: str, tmp_path: Path) -> None:
    if not works(tmp_path):
        pytest.skip("this compiler has no address and undefined-behaviour sanitizers")
    effects = (
        *ALL_PASSIVE,
        Torque({"h0": "0.3*sin(t) + atan2(angle, 1 + t)"} if name != "nothing moves" else {}),
    )
    program, tree = sources_of(equations_of(MECHANISMS[name], effects))
    assert (name in LONG) == (len(program.functions["acceleration"].statements) > MAX_BLOCK_AT_EVERY_STEP)
    write_sources(tree, tmp_path)
    (tmp_path / "driver.c").write_text(_DRIVER.replace("@", tree.prefix))
    cc(tmp_path, *FLAGS, "-c", *tree.compiled)
    objects = [file.replace(".c", ".o") for file in tree.compiled]
    for main in ("main", "driver"):
        cc(tmp_path, *FLAGS, f"{main}.c", *objects, "-lm", "-o", main)
        done = subprocess.run([tmp_path / main], capture_output=True, text=True, timeout=120, check=False)
        assert done.returncode == 0, done.stderr[:3000]
        assert "runtime error" not in done.stderr
        assert "Sanitizer" not in done.stderr
