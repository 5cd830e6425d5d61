"""Exported folders as somebody without lamc has them: what compiles them, and models of every kind."""

import importlib.util
import os
import pickle
import shutil
import subprocess
import sys
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path

import pytest
from _pytest.mark.structures import ParameterSet

import lamc
from lamc.export import files_of
from tests.support.compiling import compiled
from tests.support.ctools import CC
from tests.support.quick import unpainted_figures

STRICT = ("-pedantic", "-Wall", "-Wextra", "-Wconversion", "-Wshadow", "-Werror")
_MADE = Path(os.environ["LAMC_CACHE_DIR"]).parent / "exports"  # of the session: tests/conftest.py
EXAMPLES = Path(lamc.__file__).parent / "examples"

# A tree; loops; impacts and stops, which are events; a floating base on the ground.
KINDS = ("pendulum", "four_bar", "limit_stop", "crawler")
DURATION = {
    "pendulum": 1.0,
    "four_bar": 1.0,
    "limit_stop": 0.5,
    "crawler": 0.1,
    "stiff_triple": 0.1,
    "folding_box": 0.2,
}  # s


def clang() -> list[str] | None:
    """clang, or the one inside the ziglang package; None without either."""
    if shutil.which("clang"):
        return ["clang"]
    if importlib.util.find_spec("ziglang"):
        return [sys.executable, "-m", "ziglang", "cc"]
    return None


def compilers() -> list[ParameterSet]:
    """Commands of C compilers as parameters of a test; those that are not here are skipped with the reason."""
    has_gcc, found = shutil.which("gcc") is not None, clang()
    no_gcc = pytest.mark.skipif(not has_gcc, reason="gcc is not installed")
    no_clang = pytest.mark.skipif(found is None, reason="clang is not installed, nor the ziglang package")
    return [
        pytest.param(["gcc"], id="gcc", marks=no_gcc),
        pytest.param(found or ["clang"], id="clang", marks=no_clang),
    ]


def needs(*programs: str) -> pytest.MarkDecorator:
    missing = [program for program in programs if shutil.which(program) is None]
    return pytest.mark.skipif(bool(missing), reason=f"needs {', '.join(missing)}")


def mechanism_of(name: str) -> lamc.Mechanism:
    design = lamc.load(EXAMPLES / f"{name}.yaml")
    return design if isinstance(design, lamc.Mechanism) else lamc.split(design)


def scene_of(name: str) -> lamc.Scene:
    """The example's own scene, over a time that a test can wait for."""
    from dataclasses import replace

    return replace(mechanism_of(name).scene or lamc.Scene(), duration=DURATION[name])


@cache
def exported(name: str, **options: object) -> Mapping[str, bytes]:
    """Files of an example's export, without its picture's content; the example's name is also their prefix.

    They are made once for all workers, who find them beside the session's cache.
    """
    chosen = lamc.ExportOptions(**options)  # type: ignore[arg-type]
    made = _MADE / f"{name} {sorted(options.items())}.pickle"
    if made.is_file():
        return pickle.loads(made.read_bytes())
    with unpainted_figures():
        files = files_of(mechanism_of(name), "c", scene_of(name), chosen)
    made.parent.mkdir(exist_ok=True)
    unfinished = made.with_suffix(f".{os.getpid()}")
    unfinished.write_bytes(pickle.dumps(dict(files)))
    unfinished.replace(made)
    return files


def put(files: Mapping[str, bytes], folder: Path) -> Path:
    """Writes the files, as they are, into a folder anywhere."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, content in files.items():
        (folder / name).write_bytes(content)
    return folder


def does(command: Sequence[str | Path], folder: Path, **environment: str) -> str:
    """What a command prints; the test fails, with what it says, if it does not end well."""
    done = subprocess.run(
        list(map(str, command)),
        cwd=folder,
        capture_output=True,
        text=True,
        timeout=600,
        check=False,
        env={**os.environ, **environment},
    )
    assert done.returncode == 0, (done.returncode, done.stdout[-3000:], done.stderr[-3000:])
    return done.stdout


def cc(folder: Path, *arguments: str, command: Sequence[str] = (CC,)) -> None:
    """Runs the compiler in `folder`. Programs of the clang in ziglang are linked by the system's compiler: zig would
    first build a C library of its own, 45 s of processor time. What checks run in its programs without being asked for
    is in that library too; the sanitizers' tests have their own."""
    words = " ".join(command).split()
    if "ziglang" not in words or "-c" in arguments:
        compiled([*words, *arguments], folder)
        return
    sources = [word for word in arguments if word.endswith(".c")]
    ends = [word for word in arguments if word.startswith("-l")]
    output = list(arguments[(place := arguments.index("-o")) : place + 2])
    flags = [word for word in arguments if word not in (*sources, *ends, *output)]
    objects = [Path(source).stem + ".o" for source in sources]
    for source, made in zip(sources, objects, strict=True):  # of several at once zig makes one object only
        compiled([*words, *flags, "-fno-sanitize=undefined", "-c", source, "-o", made], folder)
    compiled([*CC.split(), *flags, *objects, *output, *ends], folder)
