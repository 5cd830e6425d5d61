"""zig as the only compiler: `pip install lamc[cc]` on a machine that has none.

What gcc or clang would make and what zig makes agree to round-off: neither contracts or reorders.
"""

import importlib
import importlib.util
import os
import subprocess
import sys
import zipfile
from pathlib import Path

import numpy as np
import pytest

import lamc
from lamc.basics.errors import BuildError
from lamc.codegen import toolchain, zig
from lamc.codegen.toolchain import find_compiler, machine
from lamc.export import files_of
from lamc.plates.elements.build import element_module
from lamc.plates.elements.triangles import DKT
from tests.support.ctools import needs_cc

needs_zig = pytest.mark.skipif(
    not zig.has_package(), reason="needs the package ziglang: pip install lamc[cc]"
)
PACKAGE = f"{sys.executable} -m ziglang cc"


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A cache of this module's own: zig makes its libraries once."""
    return tmp_path_factory.mktemp("zig") / "cache"


@pytest.fixture
def only_zig(folder: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A machine without any compiler but the package's."""
    for name in ("CC", "LAMC_CC", "ZIG_GLOBAL_CACHE_DIR", "ZIG_LOCAL_CACHE_DIR"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("PATH", "/nonexistent")
    monkeypatch.setenv("LAMC_CACHE_DIR", str(folder))
    return folder


def simulator(name: str, compiler: str | None = None) -> lamc.Simulator:
    from lamc.examples import path

    return lamc.compile(lamc.load(path(name)), options=lamc.CompileOptions(compiler))


@needs_zig
@needs_cc
@pytest.mark.parametrize("name", ["flaps", "four_bar"])
@pytest.mark.slow
@pytest.mark.ci("flaps")
def test_models_by_zig_are_those_of_the_systems_compiler(name: str, only_zig: Path) -> None:
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("PATH", os.defpath)
        theirs = simulator(name, "cc").run(t_end=0.05)
    ours = simulator(name).run(t_end=0.05)
    assert "ziglang cc -target" in ours.provenance.compiler
    # Both compile the same C without contraction; only a libm of another release may differ, in the last digit.
    np.testing.assert_allclose(ours.q, theirs.q, rtol=1e-9, atol=1e-12)


@needs_zig
@pytest.mark.campaign
def test_plates_by_zig_have_elements_plies_and_a_mesher(only_zig: Path) -> None:
    module = element_module(DKT)
    assert "ziglang" in module.compiler
    code = (
        "from shapely.geometry import box; from lamc.plates.meshing.mesher import mesh\n"
        "print(len(mesh(box(0, 0, 2, 1), 0.5).cells))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert int(done.stdout) >= 16


@needs_zig
@pytest.mark.parametrize("target", ["fmu", "wheel"])
@pytest.mark.slow
def test_exports_by_zig_hold_a_library(target: str, only_zig: Path) -> None:
    files = files_of(simulator("flaps").mechanism, target)
    (archive,) = [name for name in files if name.endswith((".fmu", ".whl"))]
    path = only_zig.parent / Path(archive).name
    path.write_bytes(files[archive])
    with zipfile.ZipFile(path) as opened:
        libraries = [name for name in opened.namelist() if name.endswith((".so", ".dll", ".dylib"))]
        assert len(libraries) == 1
        assert len(opened.read(libraries[0])) > 10_000


@needs_zig
@pytest.mark.campaign  # models of zig and of doctor are each in .ci/run
def test_doctor_builds_and_runs_a_model_by_zig_where_no_home_can_be_used(
    only_zig: Path, tmp_path: Path
) -> None:
    """zig hangs there if it is left to choose a folder for its own cache."""
    (tmp_path / "file").write_text("")
    done = subprocess.run(
        [sys.executable, "-m", "lamc", "doctor"],
        env={**os.environ, "HOME": str(tmp_path / "file")},
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert "compiles, loads and runs a model" in done.stdout
    assert (only_zig / "zig").is_dir()


@needs_zig
@pytest.mark.slow
def test_objects_are_made_one_by_one(only_zig: Path, tmp_path: Path) -> None:
    """`zig cc -c a.c b.c` makes a.o only, and exits with 0."""
    for name in "ab":
        (tmp_path / f"{name}.c").write_text(f"int {name}(void);\nint {name}(void) {{ return 1; }}\n")
    made = toolchain.make_objects(find_compiler(None), ["-O2"], ["a.c", "b.c"], tmp_path)
    assert [path.name for path in made if path.is_file()] == ["a.o", "b.o"]


@needs_zig
def test_zig_compiles_for_a_plain_processor_unless_told(only_zig: Path) -> None:
    known = zig.target(machine())
    for wanted in (None, PACKAGE):
        command = find_compiler(wanted).command
        assert command[command.index("-target") + 1] == known
    chosen = find_compiler(f"{PACKAGE} -target x86_64-windows-gnu").command
    assert chosen.count("-target") == 1


@needs_zig
def test_an_update_of_the_package_is_another_compiler(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    package = tmp_path / "ziglang"
    package.mkdir()
    (package / "__init__.py").write_text("")
    (package / "zig").write_text("one")
    spec = importlib.util.spec_from_file_location("ziglang", package / "__init__.py")
    monkeypatch.setattr(zig.importlib.util, "find_spec", lambda _: spec)
    earlier = find_compiler(PACKAGE).identity
    (package / "zig").write_text("another")
    assert find_compiler(PACKAGE).identity != earlier


def test_the_users_own_folders_of_zig_are_kept(tmp_path: Path) -> None:
    given = {"LAMC_CACHE_DIR": str(tmp_path), "ZIG_GLOBAL_CACHE_DIR": "/mine"}
    assert dict(zig.environment(given)) == {"ZIG_LOCAL_CACHE_DIR": str(tmp_path / "zig")}


def test_a_folder_of_zig_that_cannot_be_made_is_reported(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    variables = zig.environment({"LAMC_CACHE_DIR": str(tmp_path / "file" / "cache")})
    with pytest.raises(BuildError, match=r"zig's cache .* cannot be written: .*; set \$LAMC_CACHE_DIR"):
        zig.prepare(variables)


def test_windows_has_no_uname(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delattr(os, "uname")
    monkeypatch.setattr(sys, "platform", "win32")
    monkeypatch.setenv("PROCESSOR_ARCHITECTURE", "AMD64")
    assert machine() == "AMD64"
    assert zig.target(machine()) == "x86_64-windows-gnu"
    assert "-fPIC" not in lamc.CompileOptions().flags
    assert find_compiler(sys.executable).identity  # nothing else asks for it


def test_a_path_of_windows_keeps_its_backslashes(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(toolchain.os, "name", "nt")
    words = toolchain._split('"C:\\Program Files\\gcc.exe" -m64', "--cc")
    monkeypatch.undo()
    assert words == ["C:\\Program Files\\gcc.exe", "-m64"]


@needs_zig
@pytest.mark.slow
def test_the_packages_own_script_is_zig_too(only_zig: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """It was taken for another compiler: its sanitizer was left in, and code was for the very processor it ran on."""
    script = Path(sys.executable).parent / "python-zig"
    if not script.is_file():
        pytest.skip("this release of ziglang has no script")
    compiler = find_compiler(f"{script} cc")
    assert "-target" in compiler.command
    assert "-fno-sanitize=undefined" in compiler.command
    assert str(Path(importlib.import_module("ziglang").__file__ or "").parent / "zig") in compiler.identity
    monkeypatch.setenv("CC", f"{script} cc")
    assert (
        "python-zig" in element_module(DKT).compiler
    )  # it compiles, and loads without a sanitizer's library


@needs_zig
@pytest.mark.parametrize("to", ["fmu", "wheel"])
@pytest.mark.slow
@pytest.mark.ci("wheel")
def test_exports_by_zig_are_the_same_bytes_each_time(to: str, only_zig: Path) -> None:
    """Debug information held the name of the folder in which they were made."""
    from lamc.examples import path

    design = lamc.load(path("pendulum.cad"))
    assert files_of(design, to) == files_of(design, to)
