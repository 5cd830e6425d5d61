"""`lamc doctor`: looks at what lamc needs on this machine, and says what to install.

In: the machine as it is. Out: a line per matter, exit code 4 without a working compiler. It changes nothing: the
compiler is tried in a folder that is thrown away.
"""

import importlib.util
import platform
import shutil
import subprocess
import sys
import tempfile
import time
from dataclasses import asdict, dataclass
from pathlib import Path

import cffi

from lamc._version import __version__
from lamc.codegen.cache import cache_root
from lamc.codegen.toolchain import Compiler, find_compiler, run_compiler
from lamc.commands.terminal import Terminal
from lamc.errors import BuildError, LamcError
from lamc.options import CompileOptions
from lamc.report.run_text import duration

_OPTIONAL = (
    ("pandas", "Result.to_pandas", "pip install lamc[frames]"),
    ("xarray", "Result.to_xarray", "pip install lamc[frames]"),
    ("ziglang", "a C compiler from PyPI", "pip install lamc[cc]"),
    ("meshio", "mesh files of plates", "pip install lamc[mesh]"),
    ("sksparse", "CHOLMOD for large plates", "pip install scikit-sparse, with SuiteSparse and a tuned BLAS"),
    ("pypardiso", "PARDISO for large plates, by choice", "pip install pypardiso"),
)
_ANSWER = 41


@dataclass(frozen=True)
class Finding:
    """One matter: `state` is "ok", "missing" (harmless) or "broken" (lamc cannot work)."""

    matter: str
    state: str
    text: str


def doctor(compiler: str | None, terminal: Terminal) -> int:
    """Prints the findings. Returns 0, or 4 if C cannot be compiled, loaded or kept."""
    findings = [
        Finding("Python", "ok", f"{platform.python_version()} ({platform.machine()}, {sys.platform})"),
        Finding("lamc", "ok", __version__),
        _compiler(compiler),
        _cache(),
        _ffmpeg(),
        *(_package(*each) for each in _OPTIONAL),
    ]
    width = max(len(f.matter) for f in findings)
    terminal.say("\n".join(f"{f.state:<8} {f.matter:<{width}}  {f.text}" for f in findings))
    broken = [f for f in findings if f.state == "broken"]
    terminal.result({"ok": not broken, "findings": [asdict(f) for f in findings]})
    return BuildError.exit_code if broken else 0


def _compiler(wanted: str | None) -> Finding:
    try:
        compiler = find_compiler(wanted)
        seconds = _try_compiler(compiler)
    except LamcError as error:
        return Finding("C compiler", "broken", error.message)
    command = " ".join(compiler.command)
    return Finding(
        "C compiler",
        "ok",
        f"{command} ({_version(compiler)}); compiles and loads a module in {duration(seconds)}",
    )


def _try_compiler(compiler: Compiler) -> float:
    """Seconds to compile and load a function of one line. Raises BuildError if that fails."""
    with tempfile.TemporaryDirectory(prefix="lamc-doctor-") as name:
        folder = Path(name)
        (folder / "one.c").write_text(f"int lamc_answer(void) {{ return {_ANSWER}; }}\n", encoding="ascii")
        started = time.perf_counter()
        run_compiler(compiler, [*CompileOptions().flags, "-shared", "-o", "one.so", "one.c"], folder)
        ffi = cffi.FFI()
        ffi.cdef("int lamc_answer(void);")
        try:
            library = ffi.dlopen(str(folder / "one.so"))
            answer = library.lamc_answer()
            ffi.dlclose(library)
        except OSError as error:
            raise BuildError(
                f"what {compiler.command[0]!r} makes does not load here: {error}; it may compile for another machine"
            ) from error
        if answer != _ANSWER:
            raise BuildError(f"what {compiler.command[0]!r} makes gives wrong answers; use another compiler")
        return time.perf_counter() - started


def _version(compiler: Compiler) -> str:
    try:
        done = subprocess.run(
            [*compiler.command, "--version"],
            capture_output=True,
            text=True,
            errors="replace",
            timeout=20,
            check=False,
        )
    except (OSError, subprocess.TimeoutExpired):
        return "it does not tell its version"
    lines = done.stdout.splitlines()
    return lines[0].strip()[:80] if lines else "it does not tell its version"


def _cache() -> Finding:
    root = cache_root()
    try:
        if not root.exists():
            nearest = next(parent for parent in root.parents if parent.exists())
            with tempfile.TemporaryDirectory(prefix=".lamc-doctor-", dir=nearest):
                pass
            return Finding("cache", "ok", f"{root} (not there yet; it can be made)")
        with tempfile.TemporaryDirectory(prefix=".new-doctor-", dir=root):
            pass
        entries = [entry for entry in root.iterdir() if entry.is_dir() and len(entry.name) == 64]
        size = sum(file.stat().st_size for entry in entries for file in entry.rglob("*") if file.is_file())
    except OSError as error:
        told = error.strerror or error
        return Finding(
            "cache", "broken", f"{root} cannot be written: {told}; set $LAMC_CACHE_DIR to another folder"
        )
    count = f"{len(entries)} compiled module{'' if len(entries) == 1 else 's'}"
    return Finding("cache", "ok", f"{root}: {count}, {size / 1e6:.1f} MB; delete the folder to empty it")


def _ffmpeg() -> Finding:
    found = shutil.which("ffmpeg")
    if found is None:
        return Finding("ffmpeg", "missing", "films are written as GIF; install ffmpeg for smaller MP4 files")
    return Finding("ffmpeg", "ok", found)


def _package(name: str, purpose: str, way: str) -> Finding:
    if importlib.util.find_spec(name) is None:
        return Finding(name, "missing", f"optional, for {purpose}: {way}")
    return Finding(name, "ok", f"for {purpose}")
