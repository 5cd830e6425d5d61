"""Where the text that lamc ships lives: C templates and the C runtime.

In a wheel they lie in `lamc/_data/`; in a checkout (a folder with `pyproject.toml`) in place.
"""

import os
from collections.abc import Iterable
from functools import cache
from pathlib import Path

from lamc.basics.errors import LamcError


@cache
def data_dir(name: str) -> Path:
    """Folder `name` ("templates" or "runtime_c"). Raises LamcError when the installation is incomplete."""
    package = Path(__file__).resolve().parent.parent
    installed = package / "_data" / name
    if installed.is_dir():
        return installed
    checkout = package.parent
    if (checkout / "pyproject.toml").is_file() and (checkout / name).is_dir():
        return checkout / name
    raise LamcError(f"lamc's own folder {name!r} is missing from this installation: reinstall lamc")


def stamps(folders: Iterable[Path]) -> str:
    """Names, sizes and times of the files in `folders`: another text once one of them has changed."""
    parts = []
    for folder in folders:
        # Not Path.iterdir: paths made, sorted and asked for 400 files are a third of a compile from the cache.
        with os.scandir(folder) as entries:
            files = [(entry.name, entry.stat()) for entry in entries if entry.is_file()]
        files.sort(key=lambda file: file[0])
        parts += [f"{name} {status.st_size} {status.st_mtime_ns}" for name, status in files]
    return "\n".join(parts)


def own_stamps(*packages: str) -> str:
    """Stamps of the sources of these packages of lamc, with the packages in them: work on lamc itself changes them."""
    package = Path(__file__).resolve().parent.parent
    folders = sorted(
        folder for name in packages for folder, _, files in os.walk(package / name) if "__init__.py" in files
    )
    return stamps(map(Path, folders))
