"""The cache and the compiler's run: warm loads, several processes, damage, full and foreign folders, broken compilers.

Whatever happens, the answer is right or a BuildError of one line, and nothing half-written stays.
"""

import errno
import os
import re
import shutil
import stat
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import lamc
from lamc.basics.errors import BuildError
from lamc.basics.times import Times
from lamc.codegen import build, toolchain
from lamc.codegen import cache as cache_module
from lamc.codegen.cache import Cache, cache_root, intact
from lamc.codegen.module import BINDING, LIBRARY
from lamc.codegen.options import CompileOptions
from lamc.effects import Gravity, HingeStiffness
from lamc.records.scene import Scene
from tests.support.ctools import needs_cc
from tests.support.mechanisms import chain, random_state
from tests.support.paths import ROOT
from tests.support.quick import QUICKLY, with_runtime

pytestmark = needs_cc

MECHANISM = chain(2, "space", seed=31)
SCENE = Scene(effects=(Gravity((0.0, 0.0, -9.81)), HingeStiffness()))


@pytest.fixture
def root(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A cache of this test's own, not there yet."""
    folder = tmp_path / "cache"
    monkeypatch.setenv("LAMC_CACHE_DIR", str(folder))
    return folder


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A cache that has the mechanism."""
    folder = tmp_path_factory.mktemp("built") / "cache"
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("LAMC_CACHE_DIR", str(folder))
        compiled()
    return folder


@pytest.fixture
def warm(root: Path, built: Path) -> Path:
    """A cache of this test's own that has the mechanism."""
    shutil.copytree(built, root)
    return root


def compiled(**options: object) -> tuple[lamc.Simulator, Times]:
    times = Times()
    return lamc.compile(MECHANISM, SCENE, CompileOptions(**options), times), times  # type: ignore[arg-type]


def acceleration() -> np.ndarray:
    q, u = random_state(2, 1)
    return compiled()[0].acceleration(q, u)


def entries(root: Path) -> list[Path]:
    """Of models; the objects of the runtime are an entry of their own."""
    return sorted(p for p in root.iterdir() if p.is_dir() and not p.name.startswith((".", "runtime-")))


def no_debris(root: Path) -> None:
    assert [p.name for p in root.iterdir() if p.name.startswith(".")] == []
    for folder in entries(root):
        assert intact(folder)


def refused(words: str, **options: object) -> str:
    with pytest.raises(BuildError, match=words) as caught:
        compiled(**options)
    assert "\n" not in str(caught.value)
    return str(caught.value)


# ---- warm loads -----------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_a_warm_load_skips_the_derivation(root: Path) -> None:
    first, cold = compiled()
    assert {"plan", "derive", "lower", "emit", "compile"} <= set(cold.seconds)
    assert not cold.from_cache
    second, warm = compiled()
    assert warm.from_cache
    assert set(warm.seconds) == {"load from cache"}
    q, u = random_state(2, 1)
    assert (first.acceleration(q, u) == second.acceleration(q, u)).all()
    assert second.equations.joints == second.joints  # derived now that it is asked for
    assert second.program.digest == first.program.digest
    no_debris(root)


@pytest.mark.slow
def test_what_changes_the_binary_changes_the_entry_and_what_does_not_does_not(root: Path) -> None:
    compiled()
    compiled(fast=True)
    assert len(entries(root)) == 2
    lamc.compile(MECHANISM, Scene(effects=SCENE.effects, angles={"h0": 0.3}))  # a start is no part of the C
    assert len(entries(root)) == 2
    lamc.compile(MECHANISM, Scene(effects=(Gravity(),)))
    assert len(entries(root)) == 3


def test_the_cache_is_the_users_own(built: Path) -> None:
    assert stat.S_IMODE(built.stat().st_mode) == 0o700


def test_where_the_cache_lies() -> None:
    assert cache_root({"LAMC_CACHE_DIR": "/a/b", "XDG_CACHE_HOME": "/c"}) == Path("/a/b")
    assert cache_root({"XDG_CACHE_HOME": "/c", "HOME": "/h"}) == Path("/c/lamc")
    assert cache_root({"HOME": "/h"}) == Path("/h/.cache/lamc")


_BUILD = """
import sys, numpy as np, lamc
from tests.support.mechanisms import chain, random_state
sys.stdin.readline()
q, u = random_state(2, 1)
scene = lamc.Scene(effects=(lamc.Gravity((0.0, 0.0, -9.81)), lamc.HingeStiffness()))
print(lamc.compile(chain(2, "space", seed=31), scene).acceleration(q, u).tobytes().hex())
"""


@pytest.mark.slow
def test_processes_that_build_the_same_design_at_once_all_get_it(
    root: Path, cache_of_the_session: Path
) -> None:
    """The runtime, too: test_three_processes_that_find_nothing_build_once_each_at_most."""
    with_runtime(root, cache_of_the_session)
    checkout = ROOT
    environment = {**os.environ, "PYTHONPATH": str(checkout)}
    processes = [
        subprocess.Popen(
            [sys.executable, "-c", QUICKLY + _BUILD],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            env=environment,
            cwd=checkout,
        )
        for _ in range(2)
    ]
    for process in processes:
        assert process.stdin is not None
        process.stdin.write("go\n")
        process.stdin.flush()
    answers = [process.communicate(timeout=120) for process in processes]
    assert [process.returncode for process in processes] == [0] * 2, answers
    assert {out.strip() for out, _ in answers} == {acceleration().tobytes().hex()}
    assert len(entries(root)) == 1
    no_debris(root)


# ---- damage ---------------------------------------------------------------------------------------------------


def flip(path: Path) -> None:
    data = bytearray(path.read_bytes())
    data[len(data) // 2] ^= 0x55
    path.write_bytes(data)


def truncate(path: Path) -> None:
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])


@pytest.mark.parametrize(
    ("name", "spoil"),
    [
        (LIBRARY, flip),
        (LIBRARY, truncate),
        (BINDING, flip),
        (BINDING, Path.unlink),
        ("manifest.json", truncate),
        ("source/lamc.h", Path.unlink),
    ],
)
def test_a_damaged_entry_is_built_again_silently_and_right(
    warm: Path, name: str, spoil: Callable[[Path], None], capfd: pytest.CaptureFixture[str]
) -> None:
    expected = acceleration()
    (folder,) = entries(warm)
    replace_file(folder / name)  # the loaded library keeps its own bytes
    spoil(folder / name)
    assert (acceleration() == expected).all()
    assert intact(folder)
    assert compiled()[1].from_cache
    assert capfd.readouterr() == ("", "")


def replace_file(path: Path) -> None:
    """The same bytes in a new file: a library that is mapped must not change under the process."""
    data = path.read_bytes()
    path.unlink()
    path.write_bytes(data)


def test_an_entry_with_a_stranger_in_it_is_not_loaded(warm: Path) -> None:
    acceleration()
    (folder,) = entries(warm)
    (folder / "extra.py").write_text("raise SystemExit")
    assert not compiled()[1].from_cache
    assert not (entries(warm)[0] / "extra.py").exists()


@pytest.mark.parametrize("text", ["", "0" * 64, "../../etc/passwd", "\udcff\xff", "x" * 64, "0" * 10_000])
def test_a_damaged_alias_is_ignored(warm: Path, text: str) -> None:
    expected = acceleration()
    for alias in warm.glob("*.note"):
        alias.write_bytes(text.encode("latin-1", "replace"))
    assert (acceleration() == expected).all()
    assert compiled()[1].seconds.keys() == {"load from cache"}  # and mended


def test_an_alias_that_is_a_folder_is_ignored(warm: Path) -> None:
    expected = acceleration()
    for alias in list(warm.glob("*.note")):
        alias.unlink()
        alias.mkdir()
    assert (acceleration() == expected).all()


def test_a_manifest_of_nonsense_is_no_entry(tmp_path: Path) -> None:
    for text in ("", "[]", "{}", '{"files": 3}', "null", "{" * 5000, '"files"'):
        (tmp_path / "manifest.json").write_text(text)
        assert not intact(tmp_path)


# ---- folders that cannot be used ------------------------------------------------------------------------------


def test_a_cache_under_a_file_is_refused_with_the_way_out(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("LAMC_CACHE_DIR", str(tmp_path / "file" / "cache"))
    refused(r"the cache .*file/cache cannot be written: Not a directory; set \$LAMC_CACHE_DIR")
    assert (tmp_path / "file").read_text() == ""


@pytest.mark.skipif(not Path("/proc/self").is_dir(), reason="needs /proc, which nobody can write")
def test_a_cache_where_nobody_can_write_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("LAMC_CACHE_DIR", "/proc/self/lamc")
    refused("the cache /proc/self/lamc cannot be written")


def test_a_read_only_cache_still_serves_what_it_has(warm: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    expected = acceleration()
    with monkeypatch.context() as patch:
        patch.setattr(cache_module.tempfile, "mkdtemp", failing(errno.EROFS))
        patch.setattr(cache_module.tempfile, "mkstemp", failing(errno.EROFS))
        assert (acceleration() == expected).all()
        refused("cannot be written: Read-only file system", fast=True)
    no_debris(warm)


def failing(code: int) -> Callable[..., object]:
    def fail(*_: object, **__: object) -> object:
        raise OSError(code, os.strerror(code))

    return fail


def failing_into(root: Path, code: int) -> Callable[..., object]:
    """A rename that fails for entries of the cache, and works for the tools that make them."""
    rename = os.rename

    def fail(source: object, target: object) -> object:
        if Path(str(target)).parent in (root, *root.glob(".old-*")):
            raise OSError(code, os.strerror(code))
        return rename(str(source), str(target))

    return fail


@pytest.mark.parametrize("where", ["mkdtemp", "write", "rename"])
def test_a_full_disk_is_reported_and_leaves_nothing(
    root: Path, where: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    with monkeypatch.context() as patch:
        full = failing(errno.ENOSPC)
        if where == "mkdtemp":
            patch.setattr(cache_module.tempfile, "mkdtemp", full)
        elif where == "write":
            patch.setattr(Path, "write_text", full)
        else:
            patch.setattr(cache_module.os, "rename", failing_into(root, errno.ENOSPC))
        refused("cannot be written: No space left on device; set")
    assert list(root.iterdir()) == []


@pytest.mark.parametrize("mode", [0o777, 0o770, 0o720])
def test_a_cache_that_others_may_write_is_refused(root: Path, mode: int) -> None:
    root.mkdir()
    root.chmod(mode)
    refused(f"others may write to the cache {re.escape(str(root))}; `chmod 700` it")
    assert list(root.iterdir()) == []


def test_an_entry_is_not_loaded_from_a_cache_that_others_may_write(warm: Path) -> None:
    acceleration()
    warm.chmod(0o777)
    refused("others may write")


def test_a_cache_of_someone_else_is_refused(root: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    root.mkdir(mode=0o700)
    monkeypatch.setattr(cache_module.os, "getuid", lambda: root.stat().st_uid + 1)
    refused("belongs to another user")


def test_an_entry_that_cannot_be_replaced_is_named(warm: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    acceleration()
    (folder,) = entries(warm)
    (folder / BINDING).unlink()
    monkeypatch.setattr(cache_module.os, "rename", failing_into(warm, errno.EBUSY))
    refused(f"the cache entry .*{folder.name} is damaged and cannot be replaced; delete it")


def test_a_fill_that_is_interrupted_leaves_nothing(tmp_path: Path) -> None:
    def interrupted(folder: Path) -> None:
        (folder / "half").write_text("half")
        raise KeyboardInterrupt

    cache = Cache(tmp_path)
    tmp_path.chmod(0o700)
    with pytest.raises(KeyboardInterrupt):
        cache.put("0" * 64, interrupted, {})
    assert list(tmp_path.iterdir()) == []


# ---- compilers ------------------------------------------------------------------------------------------------


def script(folder: Path, body: str) -> str:
    path = folder / "cc-of-the-test"
    path.write_text(f"#!/bin/sh\n{body}\n")
    path.chmod(0o755)
    return str(path)


@pytest.fixture
def runtime_by_another_name(monkeypatch: pytest.MonkeyPatch) -> None:
    """The runtime's objects come of the usual compiler, whichever is asked for."""
    usual, make = toolchain.find_compiler(None), build.make_objects
    monkeypatch.setattr(build, "make_objects", lambda _compiler, *others: make(usual, *others))


@pytest.mark.parametrize(
    ("body", "words"),
    [
        ("exit 1", "failed with exit code 1: it says nothing; `lamc doctor` tests it"),
        ("echo 'x.c:1: error: no such thing' >&2; exit 3", "exit code 3: x.c:1: error: no such thing"),
        ("echo garbage; echo more >&2; exit 0", "made no .* and gave no error"),
        ("exit 0", "made no .* and gave no error"),
        ("kill -9 $$", "failed with exit code -9"),
        ("head -c 3000 /dev/urandom >&2; exit 1", "failed with exit code 1"),
        (
            'while [ "$1" != -o ]; do shift; done; echo garbage > "$2"',
            "does not load",
        ),
    ],
    ids=["silent", "told", "garbage", "nothing", "killed", "noise", "no library"],
)
def test_a_broken_compiler_is_reported_in_one_line_and_leaves_nothing(
    root: Path, tmp_path: Path, body: str, words: str
) -> None:
    message = refused(words, compiler=script(tmp_path, body))
    assert len(message) < 1000
    assert [path.name for path in root.iterdir() if not path.name.startswith("runtime-")] == []


def test_a_compiler_that_hangs_is_stopped(
    root: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(toolchain, "TIMEOUT", 0.3)
    refused(r"was stopped after 0\.3 s", compiler=script(tmp_path, "exec sleep 60"))
    assert list(root.iterdir()) == []


def test_a_compiler_that_is_no_program_is_reported(root: Path, tmp_path: Path) -> None:
    path = tmp_path / "cc-of-the-test"
    path.write_bytes(b"\x7fELF nothing")
    path.chmod(0o755)
    refused("does not run", compiler=str(path))
    assert list(root.iterdir()) == []


@pytest.mark.parametrize(
    ("wanted", "words"),
    [
        ("no-such-compiler", "'no-such-compiler' named by --cc is not there; install gcc or clang"),
        ("cc -ffast-math", "--cc has -ffast-math, which gives up the arithmetic"),
        ("cc 'unbalanced", '--cc is "cc \'unbalanced", which is no command'),
        (" ", "which is no command"),
        ("cc; touch /tmp/hacked", "'cc;' named by --cc is not there"),
    ],
)
def test_a_compiler_that_is_not_there_is_named(root: Path, wanted: str, words: str) -> None:
    refused(re.escape(words), compiler=wanted)
    assert not Path("/tmp/hacked").exists()


def test_without_any_compiler_the_error_says_what_to_install(
    root: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PATH", "")
    monkeypatch.delenv("CC", raising=False)
    monkeypatch.delenv("LAMC_CC", raising=False)
    monkeypatch.setattr(toolchain, "_zig", lambda: None)
    refused(r"no C compiler found; install gcc or clang, or `pip install lamc\[cc\]`")
    assert not root.exists()


def test_environment_names_the_compiler_and_its_arguments(
    root: Path, monkeypatch: pytest.MonkeyPatch, runtime_by_another_name: None
) -> None:
    monkeypatch.setenv("LAMC_CC", "cc -DLAMC_TEST=1")
    assert compiled()[0].run(t_end=0.01).provenance.compiler.endswith("cc -DLAMC_TEST=1")
    monkeypatch.setenv("LAMC_CC", "nowhere")
    refused(r"'nowhere' named by \$LAMC_CC is not there")


def test_a_compiler_that_changed_is_another_compiler(
    root: Path, tmp_path: Path, runtime_by_another_name: None
) -> None:
    real = toolchain.find_compiler(None).command[0]
    name = script(tmp_path, f'exec {real} "$@"')
    assert not compiled(compiler=name)[1].from_cache
    assert compiled(compiler=name)[1].from_cache
    script(tmp_path, f'exec {real} -fno-inline "$@"')
    assert not compiled(compiler=name)[1].from_cache


@pytest.mark.slow
def test_a_killed_build_leaves_nothing_that_counts(root: Path, tmp_path: Path) -> None:
    """The whole process dies while the compiler runs; the next one builds as if nothing had been."""
    checkout = ROOT
    name = script(tmp_path, "kill -9 $PPID; exit 1")
    code = (
        "import lamc; from tests.unit.test_cache import MECHANISM, SCENE\n"
        f"lamc.compile(MECHANISM, SCENE, lamc.CompileOptions(compiler={name!r}))"
    )
    environment = {**os.environ, "PYTHONPATH": str(checkout)}
    done = subprocess.run(
        [sys.executable, "-c", code], env=environment, cwd=checkout, capture_output=True, check=False
    )
    assert done.returncode == -9
    assert entries(root) == []
    (left,) = root.iterdir()
    os.utime(left, (0.0, 0.0))  # long ago
    acceleration()
    assert len(entries(root)) == 1
    no_debris(root)  # what the dead one left is swept up


def test_the_source_dir_is_complete_c(warm: Path, tmp_path: Path) -> None:
    source = compiled()[0].source_dir
    names = sorted(p.name for p in source.iterdir())
    assert {"main.c", "lamc.h", "rk45.c"} <= set(names)
    assert source.is_relative_to(warm)
