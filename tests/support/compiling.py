"""Calls of the C compiler, each made once for all workers of a run: the same command on the same files gives the same.

In: a command, a folder. Out: in this folder, what the compiler makes of its files. Only success is kept, beside the
session's cache (`tests/conftest.py`); a failure is the test's own.
"""

import hashlib
import os
import shutil
import subprocess
import tempfile
from collections.abc import Iterable, Sequence
from pathlib import Path

_KEPT = Path(os.environ["LAMC_CACHE_DIR"]).parent / "compiled"
_READ = (".c", ".h", ".cpp", ".hpp", ".o")  # what compilers read of a folder
_SOURCES = (".c", ".cpp")


def compiled(command: Sequence[str], folder: Path, inputs: Iterable[str] | None = None) -> None:
    """Runs the compiler in `folder`; the test fails with what it says. inputs: names of all files there that it reads;
    None: it may read any."""
    words = list(map(str, command))
    made = _made_by(words)
    if not made or any("/" in word for word in words[1:]):  # files elsewhere are not looked at
        _run(words, folder)
        return
    entry = _KEPT / _key(words, folder, inputs)
    if not entry.is_dir():
        _run(words, folder)
        _keep(entry, [folder / name for name in made])
        return
    for name in made:
        shutil.copy(entry / name, folder / name)


def _run(words: Sequence[str], folder: Path) -> None:
    done = subprocess.run(words, cwd=folder, capture_output=True, text=True, timeout=600, check=False)
    assert done.returncode == 0, done.stderr[:3000]


def _made_by(words: Sequence[str]) -> list[str]:
    """Names of the files that a command makes; none where that is not plain."""
    if "-o" in words:
        return [words[words.index("-o") + 1]]
    sources = [Path(word) for word in words if word.endswith(_SOURCES)]
    return [source.stem + ".o" for source in sources] if "-c" in words else []


def _key(words: Sequence[str], folder: Path, inputs: Iterable[str] | None) -> str:
    files = [path for path in folder.rglob("*") if path.suffix in _READ] if inputs is None else []
    names = sorted(inputs if inputs is not None else (str(path.relative_to(folder)) for path in files))
    known = hashlib.sha256("\0".join(words).encode())
    for name in names:
        content = (folder / name).read_bytes()
        known.update(f"\0{name}\0{len(content)}\0".encode())
        known.update(content)
    return known.hexdigest()


def _keep(entry: Path, made: Iterable[Path]) -> None:
    """Under its name by one rename; where another worker was first, its files are the same."""
    entry.parent.mkdir(exist_ok=True)
    fresh = Path(tempfile.mkdtemp(dir=entry.parent))
    for path in made:
        shutil.copy(path, fresh / path.name)
    try:
        fresh.rename(entry)
    except OSError:
        shutil.rmtree(fresh)
