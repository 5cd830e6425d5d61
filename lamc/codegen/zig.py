"""What zig needs to serve as C compiler: a target, and a folder for its own cache.

In: a command, this machine, the environment. Out: arguments and variables. Never: runs anything.
"""

import importlib.util
import os
import sys
import sysconfig
from collections.abc import Mapping, Sequence
from pathlib import Path

from lamc.basics.errors import BuildError
from lamc.codegen.cache import cache_root, make_root

_OWN_FOLDERS = ("ZIG_GLOBAL_CACHE_DIR", "ZIG_LOCAL_CACHE_DIR")
_SCRIPT = "python-zig"
_MACHINES = {"AMD64": "x86_64", "x64": "x86_64", "arm64": "aarch64", "ARM64": "aarch64"}


def has_package() -> bool:
    """Whether the package ziglang is installed."""
    return importlib.util.find_spec("ziglang") is not None


def is_zig(program: str, arguments: Sequence[str]) -> bool:
    """Whether the command is `zig cc`, or the same through Python's package, whose own script is python-zig."""
    return "cc" in arguments and (Path(program).stem in ("zig", _SCRIPT) or "ziglang" in arguments)


def target(machine: str) -> str | None:
    """What zig calls this machine; None for a system that it has no libc for, as far as lamc knows."""
    musl = "musl" in (sysconfig.get_config_var("HOST_GNU_TYPE") or "")
    systems = {"linux": "linux-musl" if musl else "linux-gnu", "darwin": "macos", "win32": "windows-gnu"}
    system = systems.get(sys.platform)
    return f"{_MACHINES.get(machine, machine)}-{system}" if system and machine else None


def with_target(arguments: tuple[str, ...], machine: str) -> tuple[str, ...]:
    """Without an explicit target zig compiles for the very processor it runs on, FMA included. Without optimisation it
    adds a sanitizer, whose library a shared object then lacks; and always what debuggers read, the folder's name in it,
    so that no two libraries are the same bytes."""
    if any(word == "-target" or word.startswith("--target") for word in arguments):
        own: tuple[str, ...] = ()
    else:
        known = target(machine)
        own = ("-target", known) if known else ()
    return (*arguments, *own, "-fno-sanitize=undefined", "-g0")


def program_files(program: str, arguments: Sequence[str]) -> list[Path]:
    """The files behind a command that Python runs; an update of the package changes them."""
    by_module = "ziglang" in arguments and Path(program).resolve() == Path(sys.executable).resolve()
    by_script = Path(program).stem == _SCRIPT and Path(program).parent == Path(sys.executable).parent
    if not (by_module or by_script):
        return []
    spec = importlib.util.find_spec("ziglang")
    if spec is None or spec.origin is None:
        return []
    folder = Path(spec.origin).parent
    return [path for path in (folder / "zig", folder / "zig.exe") if path.is_file()]


def environment(given: Mapping[str, str]) -> tuple[tuple[str, str], ...]:
    """Zig's folders in lamc's cache, unless the user has chosen others: where a home cannot be used, zig hangs."""
    folder = str(cache_root(given) / "zig")
    return tuple((name, folder) for name in _OWN_FOLDERS if not given.get(name))


def prepare(variables: Sequence[tuple[str, str]]) -> None:
    """Makes the folders that `environment` names. Raises BuildError where that cannot be."""
    for folder in sorted({Path(value) for name, value in variables if name in _OWN_FOLDERS}):
        try:
            make_root(folder.parent)
            folder.mkdir(mode=0o700, exist_ok=True)
        except OSError as error:
            raise BuildError(
                f"zig's cache {folder} cannot be written: {error.strerror or error}; "
                "set $LAMC_CACHE_DIR to another folder"
            ) from error
        if not os.access(folder, os.W_OK):
            raise BuildError(
                f"zig's cache {folder} may only be read, and zig writes; set $LAMC_CACHE_DIR to another folder"
            )
