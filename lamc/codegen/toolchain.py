"""Finds the C compiler, tells one from another, and runs it: an argument list, never a shell.

What zig needs beside its arguments is in `zig.py`, what flags such as -march=native come to in `target.py`.
"""

import os
import shlex
import shutil
import subprocess
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from lamc.basics.errors import BuildError
from lamc.codegen import target, zig
from lamc.codegen.cache import Cache, cache_root
from lamc.codegen.options import MACHINE, CompileOptions

TIMEOUT = 600  # s; a compiler that takes longer on lamc's output hangs
# They give up IEEE arithmetic, for the whole process where they link: loops, events and error control rest on it.
INEXACT = ("-ffast-math", "-Ofast", "-funsafe-math-optimizations", "-ffinite-math-only")
INSTALL_HINT = "install gcc or clang, or `pip install lamc[cc]`, or name one with --cc or $LAMC_CC"


@dataclass(frozen=True)
class Compiler:
    """A command, an identity that changes when the program behind it does, and what it needs in its environment."""

    command: tuple[str, ...]
    identity: str
    environment: tuple[tuple[str, str], ...] = ()


def find_compiler(
    wanted: str | None, environment: Mapping[str, str] | None = None, flags: Sequence[str] = ()
) -> Compiler:
    """The compiler to use. Raises BuildError if a named one is not there, or if there is none at all.

    flags  that it will be given: where they or its own arguments name this machine, so does its identity
    """
    environment = os.environ if environment is None else environment
    found = _found(wanted, environment)
    if not target.names_this_machine([*found.command, *flags]):
        return found
    store = Cache(cache_root(environment))
    reported = target.mark(
        found.identity, flags, lambda command, folder: run_compiler(found, command, folder), store
    )
    return replace(found, identity=f"{found.identity} {reported}")


def find_machine_compiler(options: CompileOptions) -> Compiler:
    """The compiler as it is for lanes, with an identity that tells them and this machine. Raises BuildError if there is
    none."""
    try:
        found = find_compiler(options.compiler, flags=(*options.flags, *MACHINE))
    except BuildError:  # it does not know its machine
        found = find_compiler(options.compiler, flags=options.flags)
    return replace(found, identity=f"{found.identity} lanes")


def _found(wanted: str | None, environment: Mapping[str, str]) -> Compiler:
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
            return _compiler(program, command[1:], environment)
    for name in ("cc", "gcc", "clang"):
        program = shutil.which(name, path=environment.get("PATH"))
        if program is not None:
            return _compiler(program, [], environment)
    command_of_zig = _zig()
    if command_of_zig is not None:
        return _compiler(command_of_zig[0], command_of_zig[1:], environment)
    raise BuildError(f"no C compiler found; {INSTALL_HINT}")


def _split(text: str, origin: str) -> list[str]:
    try:
        # To a POSIX shell the backslashes of a path on Windows are escapes.
        command = (
            [word.strip('"') for word in shlex.split(text, posix=False)]
            if os.name == "nt"
            else shlex.split(text)
        )
    except ValueError as error:
        raise BuildError(f"{origin} is {text!r}, which is no command: {error}") from error
    if not command:
        raise BuildError(f"{origin} is {text!r}, which is no command; {INSTALL_HINT}")
    inexact = next((word for word in command[1:] if word in INEXACT), None)
    if inexact is not None:
        raise BuildError(
            f"{origin} has {inexact}, which gives up the arithmetic that results rest on; leave it out, and take "
            "fast=True (--fast) for speed"
        )
    return command


def _compiler(program: str, arguments: Sequence[str], environment: Mapping[str, str]) -> Compiler:
    """Identity by file, size and time of change: asking `--version` would cost more than loading from the cache.

    The machine's kind is part of it: one program may compile for two, as Apple's does."""
    arguments = tuple(arguments)
    own: tuple[tuple[str, str], ...] = ()
    parts = [_stamp(Path(program)), machine()]
    if zig.is_zig(program, arguments):
        arguments = zig.with_target(arguments, machine())
        own = zig.environment(environment)
        parts += [_stamp(path) for path in zig.program_files(program, arguments)]
    return Compiler((program, *arguments), " ".join([*parts, *arguments]), own)


def _stamp(program: Path) -> str:
    path = program.resolve()
    try:
        status = path.stat()
    except OSError as error:
        raise BuildError(f"the C compiler {str(program)!r} cannot be read: {error.strerror}") from error
    return f"{path} {status.st_size} {status.st_mtime_ns}"


def machine() -> str:
    """The kind of this machine's processor, such as "x86_64" or "AMD64"; Windows has no uname."""
    if hasattr(os, "uname"):
        return os.uname().machine
    return os.environ.get("PROCESSOR_ARCHITECTURE", "")


def _zig() -> tuple[str, ...] | None:
    """The command of the ziglang package, if it is there."""
    return (sys.executable, "-m", "ziglang", "cc") if zig.has_package() and zig.target(machine()) else None


def make_objects(compiler: Compiler, flags: Sequence[str], units: Sequence[str], folder: Path) -> list[Path]:
    """Objects of `units`, C files relative to `folder`, in `folder` itself; returned in their order. As many are
    compiled at a time as there are processors.

    One unit per call: zig's `cc -c a.c b.c` makes an object of the first alone, and gives no error. Raises BuildError.
    """

    def make(unit: str) -> Path:
        made = folder / f"{Path(unit).stem}.o"
        run_compiler(compiler, [*flags, "-c", unit, "-o", made.name], folder)
        _check_made(compiler, made)
        return made

    if len(units) < 2:
        return [make(unit) for unit in units]
    # Imported here: a tenth of what importing lamc takes, and rarely needed
    from concurrent.futures import ThreadPoolExecutor

    with ThreadPoolExecutor(min(len(units), os.cpu_count() or 1)) as pool:
        return list(pool.map(make, units))


def make_library(
    compiler: Compiler,
    flags: Sequence[str],
    units: Sequence[str],
    library: str,
    folder: Path,
    objects: Sequence[Path] = (),
) -> None:
    """The shared library `library` in `folder`, of `units` and of `objects` made earlier. Raises BuildError."""
    own = make_objects(compiler, flags, units, folder)
    linked = [path.name for path in own] + [str(path) for path in objects]
    run_compiler(compiler, [*flags, "-shared", "-o", library, *linked, "-lm"], folder)
    _check_made(compiler, folder / library)
    for path in own:
        path.unlink()


def _check_made(compiler: Compiler, path: Path) -> None:
    if not path.is_file():
        raise BuildError(f"the C compiler {compiler.command[0]!r} made no {path.name} and gave no error")


def run_compiler(compiler: Compiler, arguments: Sequence[str], folder: Path) -> str:
    """Runs the compiler in `folder`. Returns what it prints. Raises BuildError with its first error."""
    zig.prepare(compiler.environment)
    try:
        done = subprocess.run(
            [*compiler.command, *arguments],
            cwd=folder,
            env={**os.environ, **dict(compiler.environment)},
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
        reported = next(
            (line for line in lines if "error" in line.lower()), lines[0] if lines else "it says nothing"
        )
        raise BuildError(
            f"the C compiler {compiler.command[0]!r} failed with exit code {done.returncode}: {reported[:300]}; "
            "`lamc doctor` tests it on a small model"
        )
    return done.stdout
