"""A compiled mechanism written by hand in the form that lamc generates, to test the runtime without the
compiler.

A uniform rod on a hinge about the y axis, whose angle 0 is hanging straight down. Three parameters make
trouble: `growth` (rad/s² per (rad/s)²) drives the rod to infinite speed in finite time, and after
`nan_after` (s) the acceleration is NaN.
"""

import importlib.util
import shutil
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import Any

import cffi
import pytest

from lamc.codegen.emit import declarations_of
from tests.support.paths import RUNTIME
from tests.support.quick import LEVEL

LENGTH, GRAVITY, MASS = 0.3, 9.81, 0.02  # m, m/s², kg

_SOURCE = """
#include <math.h>
#include "lamc.h"
static void setup(const double *p, double *c) {
  c[0] = 1.5 * p[1] / p[0];
  c[1] = p[2] * p[0] * p[0] / 6.0;
  c[2] = 0.5 * p[2] * p[1] * p[0];
  c[3] = 0.5 * p[0];
  c[4] = p[3];
  c[5] = p[4];
}
static void acceleration(const double *c, double t, const double *q, const double *u, double *udot) {
  udot[0] = t > c[5] ? NAN : -c[0] * sin(q[0]) + c[4] * u[0] * u[0];
}
static void energy(const double *c, double t, const double *q, const double *u, double *e) {
  (void)t;
  e[0] = c[1] * u[0] * u[0];
  e[1] = -c[2] * cos(q[0]);
}
static void poses(const double *c, double t, const double *q, double *p) {
  (void)t;
  const double k = cos(q[0]), s = sin(q[0]);
  p[0] = -c[3] * s; p[1] = 0.0; p[2] = -c[3] * k;
  p[3] = k; p[4] = 0.0; p[5] = s; p[6] = 0.0; p[7] = 1.0; p[8] = 0.0; p[9] = -s; p[10] = 0.0; p[11] = k;
}
static const char *const joints[] = {"hip"}, *const bodies[] = {"rod"};
static const char *const energies[] = {"kinetic", "gravity"};
static const char *const names[] = {"length", "gravity", "rod.mass", "growth", "nan_after"};
static const char *const units[] = {"m", "m/s\\xc2\\xb2", "kg", "1", "s"};
static const double defaults[] = {@DEFAULTS@, 0.0, 1e300};
static const lamc_model model = {
  .name = "rod", .digest = "00ff", .joint_count = @JOINTS@, .coordinate_count = @JOINTS@,
  .rate_count = @JOINTS@, .body_count = @JOINTS@, .parameter_count = 5, .constant_count = 6,
  .energy_count = @ENERGIES@, .joint_names = joints, .coordinate_names = joints, .rate_names = joints,
  .body_names = bodies, .parameter_names = names, .parameter_units = units, .energy_names = energies,
  .parameter_defaults = defaults, .setup = setup, .acceleration = acceleration, .energy = energy, .poses = poses
};
static const lamc_model *lamc_this_model(void) { return &model; }
"""


@dataclass(frozen=True)
class HandmadeModule:
    """Stands in for `lamc.codegen.build.Module`."""

    ffi: Any
    lib: Any
    source_dir: Path
    compiler: str = "cc of the test"
    flags: tuple[str, ...] = (LEVEL, "-ffp-contract=off")


def build(folder: Path, *, hinges: int = 1) -> HandmadeModule:
    """Compiles the rod (hinges=1), or a mechanism in which nothing moves (hinges=0)."""
    headers = ((RUNTIME / "include" / name).read_text(encoding="utf-8") for name in ("lamc_real.h", "lamc.h"))
    source = _SOURCE.replace("@DEFAULTS@", f"{LENGTH!r}, {GRAVITY!r}, {MASS!r}")
    source = source.replace("@JOINTS@", str(hinges)).replace("@ENERGIES@", "2" if hinges else "0")
    if shutil.which("cc") is None:
        pytest.skip("cffi, which makes this module, needs cc")
    ffi = cffi.FFI()
    ffi.cdef("".join(map(declarations_of, headers)) + "const lamc_model *lamc_this_model(void);")
    name = f"handmade_{hinges}"
    ffi.set_source(
        name,
        source,
        sources=[str(path) for path in sorted((RUNTIME / "src").glob("*.c"))],
        include_dirs=[str(RUNTIME / "include")],
        extra_compile_args=[LEVEL, "-ffp-contract=off"],
        libraries=["m"],
    )
    module = _load(name, Path(ffi.compile(tmpdir=str(folder))))
    return HandmadeModule(module.ffi, module.lib, folder)


def _load(name: str, path: Path) -> ModuleType:
    spec = importlib.util.spec_from_file_location(name, path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module
