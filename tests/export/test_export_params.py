"""NAME_params.h: the numbers of one design, which the exported C of another design of its structure takes."""

import subprocess
from dataclasses import replace
from pathlib import Path

import pytest

import lamc
from lamc import examples
from lamc.export.options import ExportOptions
from lamc.export.package import files
from lamc.records.mechanism import Mechanism
from lamc.records.scene import Scene
from tests.support.ctools import CC
from tests.support.exported import C99, CXX17

MAIN = """#include "{p}_params.h"
#include <stdio.h>
int main(void) {{
  static {p}_t it;
  if ({p}_init(&it, {which}, NULL) != 0 || {step} != 0) return 1;
  for (int i = 0; i < {p}_coordinate_count; i++) printf("%a ", (double)it.q[i]);
  return 0;
}}
"""


def drawn(name: str, length: float) -> Mechanism:
    """An example, all of whose lengths are multiplied."""
    made = lamc.split(lamc.load(examples.path(name)))
    bodies = tuple(replace(b, com=length * b.com, inertia=length**2 * b.inertia) for b in made.bodies)
    joints = tuple(replace(j, point=length * j.point) for j in made.joints)
    return replace(made, bodies=bodies, joints=joints, design=None)


def exported(mechanism: Mechanism, folder: Path, options: ExportOptions) -> Path:
    folder.mkdir()
    for name, content in files(mechanism, mechanism.scene or Scene(), options).items():
        (folder / name).write_bytes(content)
    return folder


def moved(folder: Path, which: str, step: str = "step(&it, 0.2)") -> str:
    """Angles after a step, to the last bit."""
    (prefix,) = (path.name.removesuffix("_params.h") for path in folder.glob("*_params.h"))
    (folder / "try.c").write_text(
        MAIN.format(p=prefix, which=which.format(p=prefix), step=f"{prefix}_{step}")
    )
    sources = ["try.c", f"{prefix}.c"]
    subprocess.run([*CC.split(), *C99, *sources, "-lm", "-o", "try"], cwd=folder, check=True, timeout=300)
    return subprocess.run(
        ["./try"], cwd=folder, capture_output=True, text=True, check=True, timeout=60
    ).stdout


@pytest.mark.parametrize("precision", ["double", "float"])
@pytest.mark.parametrize("name", ["four_bar", "flaps"])
@pytest.mark.quick("flaps-float", others="campaign")
def test_the_c_of_one_design_runs_another(name: str, precision: str, tmp_path: Path) -> None:
    options = ExportOptions(precision=precision, real_time=precision == "float")
    step = "step_fixed(&it, 0.001F)" if options.real_time else "step(&it, 0.2)"
    first = exported(drawn(name, 0.9), tmp_path / "first", options)
    other = exported(drawn(name, 1.2), tmp_path / "other", options)
    expected = moved(other, "NULL", step)
    assert expected == moved(other, "&{p}_params", step)
    (own,) = first.glob("*_params.h")
    assert moved(first, "NULL", step) != expected
    own.write_bytes((other / own.name).read_bytes())
    assert moved(first, "&{p}_params", step) == expected  # with the start of the other, too


def test_numbers_that_are_not_finite_are_refused(tmp_path: Path) -> None:
    folder = exported(drawn("flaps", 1.1), tmp_path / "flaps", ExportOptions())
    (header,) = folder.glob("*_params.h")
    text = header.read_text()
    begin = text.rindex("{") + 1
    header.write_text(f"#include <math.h>\n{text[:begin]} NAN, {text[begin:].split(',', 1)[1]}")
    with pytest.raises(subprocess.CalledProcessError):
        moved(folder, "&{p}_params")


def test_it_is_c_plus_plus_too(tmp_path: Path) -> None:
    folder = exported(drawn("flaps", 1.1), tmp_path / "flaps", ExportOptions())
    (header,) = folder.glob("*_params.h")
    (folder / "try.cpp").write_text(f'#include "{header.name}"\nint main() {{ return 0; }}\n')
    subprocess.run([*CC.split(), *CXX17, "-fsyntax-only", "try.cpp"], cwd=folder, check=True, timeout=60)
