"""Generated C and runtime under the address and undefined-behaviour sanitizers: not one word from them."""

import subprocess
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from lamc.codegen import layout
from lamc.codegen.build import write_sources
from lamc.effects import Effect, FreeBase, JointLimits, Torque
from lamc.pipeline import equations_of, sources_of
from lamc.records.mechanism import FREE_LIMITS, Body, Joint, Mechanism
from tests.support.ctools import SANITIZED as FLAGS
from tests.support.ctools import cc, needs_cc, objects_of, sanitizer_works
from tests.support.mechanisms import ALL_PASSIVE, chain, random_tree

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
  const int n = m->rate_count, nq = m->coordinate_count, size = nq + n;
  @_parameters *p = malloc(sizeof *p);
  double *c = vector(m->constant_count), *q = vector(nq), *u = vector(n), *udot = vector(n);
  double *energies = vector(m->energy_count), *poses = vector(12 * m->body_count);
  double sum = 0.0;
  if (p == NULL) return 9;
  @_default_parameters(p);
  @_setup(p, c);
  for (int k = 0; k < 20; ++k) {
    for (int i = 0; i < nq; ++i) q[i] += 0.37;
    if (m->acceleration != NULL) m->acceleration(c, 0.1 * k, q, u, udot);
    @_energy(c, 0.1 * k, q, u, energies);
    @_poses(c, 0.1 * k, q, poses);
    for (int i = 0; i < n; ++i) sum += udot[i];
    for (int i = 0; i < m->energy_count; ++i) sum += energies[i];
    for (int i = 0; i < 12 * m->body_count; ++i) sum += poses[i];
  }
  m->setup(m->parameter_defaults, c);
  const lamc_motion motion = {m, c, vector((int)lamc_motion_work_size(m)), 0.0, NULL};
  double *y = vector(size), t = 0.0;
  for (int i = 0; i < size; ++i) y[i] = 0.0;
  if (nq > n) y[nq - 4] = 1.0; /* a quaternion */
  lamc_motion_accelerations(&motion, 1, &t, y, udot);
  lamc_motion_energies(&motion, 1, &t, y, energies);
  lamc_motion_poses(&motion, 1, &t, y, poses);
  double *powers = vector(m->power_count);
  if (lamc_motion_powers(&motion, 1, &t, y, powers) != LAMC_OK) return 6;
  for (int i = 0; i < m->power_count; ++i) sum += powers[i], puts(m->power_names[i]);
  free(powers);
  for (int i = 0; i < nq; ++i) puts(m->coordinate_names[i]);
  for (int i = 0; i < n; ++i) puts(m->rate_names[i]);
  for (int i = 0; i < m->body_count; ++i) puts(m->body_names[i]);
  for (int i = 0; i < m->energy_count; ++i) puts(m->energy_names[i]);
  for (int i = 0; i < m->parameter_count; ++i) printf("%s %s %g\\n", m->parameter_names[i], m->parameter_units[i],
                                                      m->parameter_defaults[i]);
  const lamc_ode ode = lamc_motion_ode(&motion);
  const lamc_options options = {1e-6, 1e-8, 0.0, 0.0, 300};
  const double ends[2] = {0.01, 0.02};
  for (int method = LAMC_AUTO; method <= LAMC_RADAU5; ++method) {
    double *work = vector((int)lamc_run_work_size(&ode, (lamc_method)method)), *out = vector(2 * size), times[2];
    double *work_done = vector(2 * (m->power_count + 1));
    lamc_rows rows = {times, out, 2, 0, NULL, NULL, 0, 0, work_done};
    lamc_run run;
    if (lamc_run_start(&run, &ode, (lamc_method)method, &options, 0.0, y, 0.02, ends, 2, work) != LAMC_OK) return 4;
    const lamc_status status = lamc_run_advance(&run, &rows, 0, NULL);
    if (status != LAMC_OK && status != LAMC_STEP_LIMIT) return 5;
    free(work); free(out); free(work_done);
  }
  free(motion.work);
  free(p); free(c); free(q); free(u); free(udot); free(energies); free(poses); free(y);
  return isfinite(sum) ? 0 : 3;
}
"""


def limited(mechanism: Mechanism) -> Mechanism:
    """The same with narrow limits, so that the run meets them."""
    joints = tuple(replace(joint, limits=(-1e-3, 1e-3)) for joint in mechanism.joints)
    return replace(mechanism, joints=joints)


def ring() -> Mechanism:
    """Four links of a plane loop that is no parallelogram, the first hinge with narrow limits."""
    points = ((0.0, 0.0, 0.0), (0.02, 0.05, 0.0), (0.09, 0.07, 0.0), (0.12, 0.0, 0.0))
    inertia = np.diag([1e-6, 1e-6, 2e-6])
    links = tuple(
        Body(f"link{i}", 0.01, (np.array(points[i]) + np.array(points[i + 1])) / 2, inertia) for i in range(3)
    )
    ends = ("ground", "link0", "link1", "link2", "ground")
    joints = tuple(
        Joint(f"h{i}", ends[i], ends[i + 1], points[i], limits=(-1e-3, 1e-3) if i == 0 else FREE_LIMITS)
        for i in range(4)
    )
    return Mechanism((Body("ground", fixed=True), *links), joints, name="ring")


def floating(mechanism: Mechanism) -> Mechanism:
    """The same with a heavy ground."""
    inertia = np.diag([1e-6, 2e-6, 3e-6])
    bodies = tuple(
        replace(body, mass=0.02, inertia=inertia) if body.fixed else body for body in mechanism.bodies
    )
    return replace(mechanism, bodies=bodies)


LONG = ("loops", "long tree")
MECHANISMS = {
    "straight": chain(4, "space", seed=1),
    "loops": chain(30, "laminate", seed=2),
    "long tree": random_tree(10, seed=3, kind="mixed"),
    "nothing moves": Mechanism((Body("slab", fixed=True),), (), name="slab"),
    "stops": limited(chain(3, "parallel", seed=4)),
    "closed": ring(),
    "floating": floating(ring()),
}
SCENES: Mapping[str, tuple[Effect, ...]] = {
    "stops": (*ALL_PASSIVE, JointLimits(restitution=1.0)),
    "closed": (*ALL_PASSIVE, JointLimits(stiffness=10.0, damping=0.01)),
    "floating": (*ALL_PASSIVE, JointLimits(restitution=1.0), FreeBase(spin=(1.0, 2.0, 3.0))),
}


@pytest.mark.parametrize("name", sorted(MECHANISMS))
@pytest.mark.quick("closed", others="campaign")
def test_generated_c_runs_clean(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    if not sanitizer_works(tmp_path, *FLAGS):
        pytest.skip("this compiler has no address and undefined-behaviour sanitizers")
    if (
        name == "long tree"
    ):  # laid out as one of thirty bodies is, whose C takes the compiler three times as long
        monkeypatch.setattr(layout, "MAX_BLOCK_AT_EVERY_STEP", 400)
        monkeypatch.setattr(layout, "MAX_BLOCK", 100)
    drive = Torque({"h0": "0.3*sin(t) + atan2(angle, 1 + t)"} if name != "nothing moves" else {})
    program, tree = sources_of(
        equations_of(MECHANISMS[name], SCENES.get(name, (*ALL_PASSIVE, drive))), energy_balance=True
    )
    longest = max(len(f.statements) for f in program.functions.values() if f.name in layout.AT_EVERY_STEP)
    assert (name in LONG) == (longest > layout.MAX_BLOCK_AT_EVERY_STEP)
    write_sources(tree, tmp_path)
    (tmp_path / "driver.c").write_text(_DRIVER.replace("@", tree.prefix))
    objects = objects_of(tree, tmp_path, *FLAGS)
    for main in ("main", "driver"):
        cc(tmp_path, *FLAGS, f"{main}.c", *objects, "-lm", "-o", main)
        done = subprocess.run([tmp_path / main], capture_output=True, text=True, timeout=120, check=False)
        assert done.returncode == 0, done.stderr[:3000]
        assert "runtime error" not in done.stderr
        assert "Sanitizer" not in done.stderr
