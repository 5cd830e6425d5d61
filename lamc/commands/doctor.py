"""`lamc doctor`: looks at what lamc needs on this machine, and says what to install.

In: the machine as it is. Out: a line per matter, exit code 4 without a working compiler. It changes nothing: the
compiler builds and runs a small model in a folder that is thrown away. Only zig keeps what it made of its own
libraries, in the folder `zig` of lamc's cache.
"""

import importlib.util
import math
import os
import platform
import shutil
import subprocess
import sys
import tempfile
import time
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

import lamc
from lamc.basics._version import __version__
from lamc.basics.errors import BuildError, LamcError
from lamc.basics.numbers import duration
from lamc.codegen.cache import Cache, cache_root
from lamc.codegen.toolchain import Compiler, find_compiler
from lamc.commands.terminal import Terminal

_OPTIONAL = (
    ("pandas", "Result.to_pandas", "pip install lamc[frames]"),
    ("xarray", "Result.to_xarray", "pip install lamc[frames]"),
    ("ziglang", "a C compiler from PyPI", "pip install lamc[cc]"),
    ("meshio", "mesh files of plates", "pip install lamc[mesh]"),
    ("sksparse", "CHOLMOD for large plates", "pip install scikit-sparse, with SuiteSparse and a tuned BLAS"),
    ("pypardiso", "PARDISO for large plates, by choice", "pip install pypardiso"),
)
# A pendulum hangs a quarter of its period after it was let go: K(sin 45 deg) / sqrt(m g l / (I + m l^2)), in s.
_QUARTER = 1.8540746773013719 * math.sqrt(1.25)
_CLOSE = 1e-6  # rad; at rtol 1e-9 the run is off by 1e-9 or so


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
        _films(),
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
        seconds = _try_compiler(compiler, wanted)
    except LamcError as error:
        return Finding("C compiler", "broken", error.message)
    command = " ".join(compiler.command)
    return Finding(
        "C compiler",
        "ok",
        f"{command} ({_version(compiler)}); compiles, loads and runs a model in {duration(seconds)}",
    )


def _try_compiler(compiler: Compiler, wanted: str | None) -> float:
    """Seconds to compile, load and run a pendulum as any run would. Raises LamcError if that fails."""
    started = time.perf_counter()
    # A library that is loaded cannot be removed on Windows.
    with tempfile.TemporaryDirectory(prefix="lamc-doctor-", ignore_cleanup_errors=True) as name:
        cache = Cache(Path(name) / "cache")
        simulator = lamc.compile(*_pendulum(), lamc.CompileOptions(wanted), cache=cache)
        result = simulator.run(t_end=_QUARTER, rtol=1e-9)
        seconds = time.perf_counter() - started
        missed = abs(float(result.angle("hinge")[-1]) - math.pi / 2)
        if not (result.success and missed < _CLOSE):
            raise BuildError(
                f"what {compiler.command[0]!r} makes gives wrong answers (a pendulum is off by {missed:.1e} rad); "
                "use another compiler"
            )
    return seconds


def _pendulum() -> tuple[lamc.Mechanism, lamc.Scene]:
    """1 kg, 1 m from its hinge, let go from the horizontal under 1 m/s^2; its inertia makes I + m l^2 = 1.25 kg m^2."""
    bob = lamc.Body("bob", 1.0, np.array([1.0, 0.0, 0.0]), 0.25 * np.eye(3))
    hinge = lamc.Joint("hinge", "wall", "bob", axis=np.array([0.0, 1.0, 0.0]))
    mechanism = lamc.Mechanism((lamc.Body("wall", fixed=True), bob), (hinge,), name="pendulum")
    return mechanism, lamc.Scene(effects=(lamc.Gravity((0.0, 0.0, -1.0)),))


def _version(compiler: Compiler) -> str:
    try:
        done = subprocess.run(
            [*compiler.command, "--version"],
            env={**os.environ, **dict(compiler.environment)},
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
        reported = error.strerror or error
        return Finding(
            "cache", "broken", f"{root} cannot be written: {reported}; set $LAMC_CACHE_DIR to another folder"
        )
    count = f"{len(entries)} compiled module{'' if len(entries) == 1 else 's'}"
    return Finding("cache", "ok", f"{root}: {count}, {size / 1e6:.1f} MB; delete the folder to empty it")


def _films() -> Finding:
    """What writes MP4, in the order of `lamc.report.film`."""
    if importlib.util.find_spec("av") is not None:
        return Finding("films", "ok", "MP4, by PyAV")
    found = shutil.which("ffmpeg")
    if found is None:
        way_out = "pip install 'lamc[video]', or ffmpeg, for smaller MP4 files"
        return Finding("films", "missing", f"films are written as GIF; {way_out}")
    return Finding("films", "ok", f"MP4, by {found}")


def _package(name: str, purpose: str, way: str) -> Finding:
    if importlib.util.find_spec(name) is None:
        return Finding(name, "missing", f"optional, for {purpose}: {way}")
    return Finding(name, "ok", f"for {purpose}")
