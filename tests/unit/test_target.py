"""Flags that name this machine: what the compiler makes of them is part of the cache's keys."""

import os
from pathlib import Path

import pytest

from lamc.codegen import target
from lamc.codegen.cache import Cache
from lamc.codegen.options import CompileOptions
from lamc.codegen.toolchain import find_compiler
from tests.support.ctools import needs_cc
from tests.unit.test_cache import compiled, entries, script

FAST = CompileOptions(fast=True).flags


@pytest.fixture
def root(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    folder = tmp_path / "cache"
    folder.mkdir(mode=0o700)
    monkeypatch.setenv("LAMC_CACHE_DIR", str(folder))
    forget(monkeypatch)
    return folder


def forget(monkeypatch: pytest.MonkeyPatch) -> None:
    target._known_marks.cache_clear()
    target._processor.cache_clear()


def on_processor(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """This process, moved to another machine."""
    (tmp_path / "cpuinfo").write_text(f"model name\t: {name}\nflags\t: {name}\n\nprocessor\t: 1\n")
    monkeypatch.setattr(target, "_CPUINFO", tmp_path / "cpuinfo")
    forget(monkeypatch)


@needs_cc
@pytest.mark.slow
def test_two_processors_share_plain_code_and_not_fast_code(
    root: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A compiler that tells other macros stands for another processor under a home that both share."""
    real = find_compiler(None).command[0]
    # The macros that the compiler resolves -march=native to are those of $MACHINE.
    name = script(
        tmp_path,
        f'case " $* " in *" -dM "*) echo "#define ${{MACHINE}}";; *) exec {real} "$@";; esac',
    )
    for machine, hits in (("avx512", False), ("sse2", False), ("avx512", True), ("sse2", True)):
        monkeypatch.setenv("MACHINE", machine)
        on_processor(machine, tmp_path, monkeypatch)
        assert compiled(compiler=name, fast=True)[1].from_cache is hits
    assert len(entries(root)) == 2
    assert not compiled(compiler=name)[1].from_cache
    on_processor("third", tmp_path, monkeypatch)
    assert compiled(compiler=name)[1].from_cache


@needs_cc
def test_the_compiler_is_asked_once_per_processor(
    root: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[int] = []

    def run(words: object, folder: Path) -> str:
        asked.append(1)
        return "#define __AVX2__ 1"

    for name, count in (("one", 1), ("one", 1), ("two", 2), ("one", 2)):
        on_processor(name, tmp_path, monkeypatch)
        target.mark("cc", FAST, run, Cache(root))
        assert len(asked) == count


@needs_cc
def test_a_processor_that_is_not_described_is_asked_for_in_each_process(
    root: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(target, "_CPUINFO", tmp_path / "none")
    answers = ["#define A", "#define B"]
    marks = set()
    while answers:
        forget(monkeypatch)
        marks.add(target.mark("cc", FAST, lambda *_: answers.pop(), Cache(root)))
    assert len(marks) == 2


@needs_cc
def test_the_users_own_native_flags_are_keyed_as_well(
    root: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    real = find_compiler(None).command[0]
    name = script(tmp_path, f'case " $* " in *" -dM "*) echo "$MACHINE";; *) exec {real} "$@";; esac')
    seen = set()
    for machine in ("one", "two"):
        monkeypatch.setenv("MACHINE", machine)
        on_processor(machine, tmp_path, monkeypatch)
        seen.add(find_compiler(f"{name} -march=native").identity)
    assert len(seen) == 2
    assert "=native" not in find_compiler(name).identity


@needs_cc
def test_real_macros_tell_this_processor_from_a_plain_one(root: Path) -> None:
    plain, native = find_compiler(None), find_compiler(None, flags=FAST)
    assert native.identity.startswith(plain.identity)
    assert native.identity != plain.identity
    assert find_compiler(None, os.environ, FAST).identity == native.identity
