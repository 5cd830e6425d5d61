"""Finds the C compiler, tells one from another, and runs it: an argument list, never a shell."""

import importlib.util
import os
import shlex
import shutil
import subprocess
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from lamc.errors import BuildError

TIMEOUT = 600  # s; a compiler that takes longer on lamc's output hangs
INSTALL_HINT = "install gcc or clang, or `pip install lamc[cc]`, or name one with --cc or $LAMC_CC"


@dataclass(frozen=True)
class Compiler:
    """A command, and an identity that changes when the program behind it does."""

    command: tuple[str, ...]
    identity: str


def find_compiler(wanted: str | None, environment: Mapping[str, str] | None = None) -> Compiler:
    """The compiler to use. Raises BuildError if a named one is not there, or if there is none at all."""
    environment = os.environ if environment is None else environment
    for origin, text in (
        ("--cc", wanted),
        ("$LAMC_CC", environment.get("LAMC_CC")),
        ("$CC", environment.get("CC")),
    ):
        if text:
            command = _split(text, origin)
            program = shutil.which(command[0], path=environment.get("PATH"))
            if program is None:
                raise BuildError(
                    f"the C compiler {command[0]!r} named by {origin} is not there; {INSTALL_HINT}"
                )
            return _compiler(program, command[1:])
    for name in ("cc", "gcc", "clang"):
        program = shutil.which(name, path=environment.get("PATH"))
        if program is not None:
            return _compiler(program, [])
    zig = _zig()
    if zig is not None:
        return zig
    raise BuildError(f"no C compiler found; {INSTALL_HINT}")


def _split(text: str, origin: str) -> list[str]:
    try:
        command = shlex.split(text)
    except ValueError as error:
        raise BuildError(f"{origin} is {text!r}, which is no command: {error}") from error
    if not command:
        raise BuildError(f"{origin} is {text!r}, which is no command; {INSTALL_HINT}")
    return command


def _compiler(program: str, arguments: Sequence[str]) -> Compiler:
    """Identity by file, size and time of change: asking `--version` would cost more than loading from the cache."""
    path = Path(program).resolve()
    try:
        status = path.stat()
    except OSError as error:
        raise BuildError(f"the C compiler {program!r} cannot be read: {error.strerror}") from error
    return Compiler(
        (program, *arguments), f"{path} {status.st_size} {status.st_mtime_ns} {' '.join(arguments)}"
    )


def _zig() -> Compiler | None:
    """The compiler of the ziglang package. Without an explicit target zig enables FMA by itself."""
    if importlib.util.find_spec("ziglang") is None:
        return None
    system = {"linux": "linux-gnu", "darwin": "macos", "win32": "windows-gnu"}.get(sys.platform)
    machine = {"AMD64": "x86_64", "arm64": "aarch64"}.get(os.uname().machine, os.uname().machine)
    if system is None:
        return None
    command = (sys.executable, "-m", "ziglang", "cc", "-target", f"{machine}-{system}")
    spec = importlib.util.find_spec("ziglang")
    return Compiler(command, f"ziglang {spec.origin if spec else ''} {machine}-{system}")


def run_compiler(compiler: Compiler, arguments: Sequence[str], folder: Path) -> None:
    """Runs the compiler in `folder`. Raises BuildError with its first error."""
    try:
        done = subprocess.run(
            [*compiler.command, *arguments],
            cwd=folder,
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            errors="replace",
            timeout=TIMEOUT,
            check=False,
        )
    except OSError as error:
        raise BuildError(
            f"the C compiler {compiler.command[0]!r} does not run: {error.strerror or error}"
        ) from error
    except subprocess.TimeoutExpired as error:
        raise BuildError(f"the C compiler {compiler.command[0]!r} was stopped after {TIMEOUT} s") from error
    if done.returncode != 0:
        lines = [line.strip() for line in done.stderr.splitlines() if line.strip()]
        told = next(
            (line for line in lines if "error" in line.lower()), lines[0] if lines else "it says nothing"
        )
        raise BuildError(
            f"the C compiler {compiler.command[0]!r} failed with exit code {done.returncode}: {told[:300]}; "
            "`lamc doctor` tests it on one line"
        )
