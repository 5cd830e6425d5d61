"""Compiling and running C in tests, and programs made of any staged values."""

import os
import shutil
import subprocess
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

from lamc.codegen.build import build
from lamc.codegen.cache import Cache, cache_root
from lamc.codegen.emit import SourceTree, emit
from lamc.codegen.options import CompileOptions
from lamc.codegen.toolchain import find_compiler
from lamc.mechanics.equations import Equations
from lamc.mechanics.lower import lower
from lamc.mechanism.plan import plan
from lamc.symbolic.program import Program
from lamc.symbolic.scalars import Scalar
from lamc.symbolic.staging import Store
from tests.support.compiling import compiled
from tests.support.mechanisms import Array, chain

STRICT = ("-std=c11", "-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Wshadow", "-Werror")
STRICT_CXX = ("-std=c++17", "-Wall", "-Wextra", "-Wpedantic", "-Wshadow", "-Werror")
CC = os.environ.get("CC", "cc")

SANITIZED = (
    *STRICT,
    "-O0",
    "-ffp-contract=off",
    "-g",
    "-fsanitize=address,undefined",
    "-fno-sanitize-recover=all",
    "-fno-omit-frame-pointer",
)

needs_cc = pytest.mark.skipif(shutil.which(CC.split()[0]) is None, reason="needs a C compiler (set CC)")


def cc(folder: Path, *arguments: str, compiler: str = CC) -> None:
    """Runs the compiler in `folder`; the test fails with what it says."""
    compiled([*compiler.split(), *arguments], folder)


def objects_of(
    tree: SourceTree, folder: Path, *flags: str, machine: Sequence[str] = (), compiler: str = CC
) -> list[str]:
    """Names of the objects of `tree`, compiled in `folder`, where its files are, with lanes and derivatives where it
    has them; the runtime, the same for every model, once with the same flags.

    machine: flags of what is compiled beside the model for a kind of processor"""
    plain = [*compiler.split(), *flags, "-c"]
    runtime = {name for name in tree.files if not name.startswith(tree.prefix) and name != "main.c"}
    beside = (*tree.machine, *tree.beside)
    for command, units, inputs in (
        (plain, [unit for unit in tree.compiled if unit in tree.shared], tree.shared),
        (plain, [unit for unit in tree.compiled if unit not in tree.shared], None),
        ([*plain, *machine], [unit for unit in beside if unit in runtime], runtime),
        ([*plain, *machine], [unit for unit in beside if unit not in runtime], None),
    ):
        if units:
            compiled([*command, *units], folder, inputs)
    return [Path(unit).stem + ".o" for unit in (*tree.compiled, *beside)]


def sanitizer_works(folder: Path, *flags: str) -> bool:
    """Whether a program made with these flags runs here: some kernels do not let the thread sanitizer."""
    (folder / "probe.c").write_text("int main(void) { return 0; }\n")
    command = [*CC.split(), *flags, "probe.c", "-o", "probe"]
    made = subprocess.run(command, cwd=folder, capture_output=True, check=False)
    if made.returncode != 0:
        return False
    return subprocess.run([folder / "probe"], capture_output=True, check=False).returncode == 0


def output_of(program: Path, *arguments: str) -> str:
    """What a program prints; the test fails if it ends otherwise than well."""
    done = subprocess.run(
        [str(program), *arguments], capture_output=True, text=True, timeout=120, check=False
    )
    assert done.returncode == 0, (done.returncode, done.stderr[:3000])
    return done.stdout


def program_of(store: Store, values: Sequence[Scalar]) -> Program:
    """A program whose "accelerations" are any staged values; it has as many joints as there are values."""
    equations = Equations(
        tree=plan(chain(len(values), "parallel")),
        effects=(),
        store=store,
        parameters=(),
        acceleration=tuple(values),
        problem=None,  # type: ignore[arg-type]  nothing here asks for M and f
        energies={},
        poses=(),
        solver="none",
        solver_flops={},
    )
    return lower(equations)


def values_in_c(program: Program, states: Sequence[tuple[float, Array, Array]]) -> Array:
    """Its accelerations by the compiled C at (t, q, u), shape (len(states), n)."""
    tree = emit(program)
    _, module, _ = build(tree, program.digest, find_compiler(None), CompileOptions(), Cache(cache_root()))
    model = module.lib.lamc_this_model()
    constants = module.ffi.new("double[]", max(1, program.constant_count))
    defaults = [p.default for p in program.parameters] or [0.0]
    model.setup(module.ffi.new("double[]", defaults), constants)
    rows = []
    for t, q, u in states:
        out = module.ffi.new("double[]", len(program.joints))
        model.acceleration(
            constants, t, module.ffi.new("double[]", list(q)), module.ffi.new("double[]", list(u)), out
        )
        rows.append(list(out))
    return np.array(rows)
