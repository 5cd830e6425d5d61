"""The cache of compiled modules: a folder of the user's own, entries named by content, verified before use.

An entry is written in a fresh folder beside its place and moved there by one rename, so neither a crash nor a
second process leaves a half-written one. Every file of an entry is in its manifest with a digest; an entry that
does not match is thrown away and built again.
"""

import contextlib
import errno
import hashlib
import json
import os
import shutil
import stat
import tempfile
import time
from collections.abc import Callable, Hashable, Mapping
from functools import partial
from pathlib import Path
from typing import Any, TypeVar

from lamc.basics.errors import BuildError

MANIFEST = "manifest.json"
STALE = 86_400.0  # s; nothing is under way for longer than this
MOST_KNOWN = 16  # things that are kept at hand, modules among them
T = TypeVar("T")


def cache_root(environment: Mapping[str, str] | None = None) -> Path:
    """$LAMC_CACHE_DIR, else $XDG_CACHE_HOME/lamc, else ~/.cache/lamc. Raises BuildError for a user without a home."""
    environment = os.environ if environment is None else environment
    if chosen := environment.get("LAMC_CACHE_DIR"):
        return Path(chosen).absolute()
    if base := environment.get("XDG_CACHE_HOME"):
        return Path(base).absolute() / "lamc"
    try:
        home = Path(environment.get("HOME") or "~").expanduser()
    except RuntimeError as error:
        raise BuildError("there is no home folder; set $LAMC_CACHE_DIR to a folder of your own") from error
    return home.absolute() / ".cache" / "lamc"


def make_root(root: Path) -> None:
    """The folder of a cache, the user's own. Raises OSError."""
    root.mkdir(mode=0o700, parents=True, exist_ok=True)


class Cache:
    """Entries by key. Reading needs no right to write.

    passing  as one study uses it: notes of single designs go nowhere, as of a thousand of them nobody asks again; and
             what all of them have in common is looked for once (`once`)
    """

    def __init__(self, root: Path, *, passing: bool = False) -> None:
        self.root = root
        self.passing = passing
        self._known: dict[Hashable, Any] = {}

    def __reduce__(self) -> Any:
        return partial(Cache, passing=self.passing), (self.root,)

    def once(self, key: Hashable, find: Callable[[], T]) -> T:
        """What `find` finds; in passing kept by `key` for the designs to come, unless it is None."""
        found: T = self._known.get(key)  # type: ignore[assignment]
        if found is None:
            found = find()
            if self.passing and found is not None:
                if len(self._known) >= MOST_KNOWN:
                    self._known.clear()
                self._known[key] = found
        return found

    def find(self, key: str) -> Path | None:
        """Folder of a complete and unchanged entry, or None."""
        folder = self.root / key
        if not folder.is_dir():
            return None
        self.check_owner(self.root)
        return folder if intact(folder) else None

    def put(self, key: str, fill: Callable[[Path], None], facts: Mapping[str, str]) -> Path:
        """Makes an entry: `fill` writes its files into an empty folder. Returns the entry's folder.

        Raises BuildError if the cache cannot be written. Whatever `fill` raises passes, and leaves nothing behind.
        """
        self._prepare()
        self._sweep()
        try:
            fresh = Path(tempfile.mkdtemp(prefix=".new-", dir=self.root))
        except OSError as error:
            raise self._unwritable(error) from error
        try:
            fill(fresh)
            manifest = {"facts": dict(facts), "files": _digests(fresh)}
            (fresh / MANIFEST).write_text(json.dumps(manifest, indent=1, sort_keys=True), encoding="utf-8")
            return self._move_in(fresh, key)
        except OSError as error:
            raise self._unwritable(error) from error
        finally:
            shutil.rmtree(fresh, ignore_errors=True)

    def recall(self, alias: str) -> str | None:
        """The key that an alias stands for, or None."""
        try:
            text = (self.root / f"{alias}.key").read_text(encoding="ascii")
        except (OSError, UnicodeDecodeError):
            return None
        return text if len(text) == 64 and set(text) <= set("0123456789abcdef") else None

    def remember(self, alias: str, key: str) -> None:
        """Lets `alias` stand for `key`; a cache that cannot be written forgets it without harm."""
        self._write(f"{alias}.key", key)

    def noted(self, alias: str) -> str | None:
        """The text that `note` kept, or None."""
        try:
            return (self.root / f"{alias}.note").read_text(encoding="ascii")
        except (OSError, UnicodeDecodeError):
            return None

    def note(self, alias: str, text: str) -> None:
        """Keeps an ASCII text that costs more to find out than to read; without harm where nothing can be written."""
        with contextlib.suppress(BuildError):
            self._prepare()
            self._write(f"{alias}.note", text)

    def keep(self, alias: str, value: object, *, of_one_design: bool = True) -> None:
        """Keeps what JSON can hold, with its digest; without harm where nothing can be written."""
        if self.passing and of_one_design:
            return
        text = json.dumps(value)
        self.note(alias, f"{hashlib.sha256(text.encode()).hexdigest()}\n{text}")

    def kept(self, alias: str) -> Any:
        """What `keep` kept, or None; a note that is damaged is none."""
        digest, _, text = (self.noted(alias) or "").partition("\n")
        if not text or digest != hashlib.sha256(text.encode()).hexdigest():
            return None
        try:
            return json.loads(text)
        except ValueError:
            return None

    def _write(self, file: str, text: str) -> None:
        with contextlib.suppress(OSError):
            handle, name = tempfile.mkstemp(prefix=".new-", dir=self.root)
            try:
                with os.fdopen(handle, "w", encoding="ascii") as stream:
                    stream.write(text)
                os.replace(name, self.root / file)
            except OSError:
                os.unlink(name)

    def _prepare(self) -> None:
        try:
            make_root(self.root)
        except OSError as error:
            raise self._unwritable(error) from error
        self.check_owner(self.root)

    def _sweep(self) -> None:
        """Removes what processes left that were killed on the way."""
        latest = time.time() - STALE
        with os.scandir(self.root) as entries:
            left = [Path(entry.path) for entry in entries if entry.name.startswith((".new-", ".old-"))]
        for path in left:
            with contextlib.suppress(OSError):
                if path.lstat().st_mtime < latest:
                    shutil.rmtree(path) if path.is_dir() else path.unlink()

    def check_owner(self, folder: Path) -> None:
        """Code is loaded from here, so nobody else may write here."""
        status = folder.stat()
        if hasattr(os, "getuid") and status.st_uid != os.getuid():
            raise BuildError(
                f"the cache {folder} belongs to another user; set $LAMC_CACHE_DIR to a folder of your own"
            )
        if status.st_mode & (stat.S_IWGRP | stat.S_IWOTH):
            raise BuildError(f"others may write to the cache {folder}; `chmod 700` it or set $LAMC_CACHE_DIR")

    def _move_in(self, fresh: Path, key: str) -> Path:
        """One rename; if an entry is already there, it stays if it is intact, and gives way if it is not."""
        place = self.root / key
        for _ in range(10):
            try:
                os.rename(fresh, place)
                return place
            except OSError as error:
                # Taken a moment ago and free by now: another process is moving a damaged entry aside.
                if not place.exists() and error.errno not in (errno.ENOTEMPTY, errno.EEXIST):
                    raise
                if intact(place):
                    return place
                if not place.exists():
                    continue
                aside = Path(tempfile.mkdtemp(prefix=".old-", dir=self.root))
                with contextlib.suppress(OSError):
                    os.rename(place, aside / "entry")
                shutil.rmtree(aside, ignore_errors=True)
        raise BuildError(f"the cache entry {place} is damaged and cannot be replaced; delete it")

    def _unwritable(self, error: OSError) -> BuildError:
        return BuildError(
            f"the cache {self.root} cannot be written: {error.strerror or error}; set $LAMC_CACHE_DIR to another folder"
        )


def _digests(folder: Path) -> dict[str, str]:
    """Digest of each file by its path in the folder; without paths as objects, which take as long as the digests."""
    digests = {}
    start = len(os.path.join(folder, ""))
    for place, _, names in os.walk(folder):
        for name in names:
            path = os.path.join(place, name)
            if name != MANIFEST and os.path.isfile(path):
                with open(path, "rb") as stream:
                    digests[path[start:]] = hashlib.sha256(stream.read()).hexdigest()
    return digests


def intact(folder: Path) -> bool:
    """True if the entry holds exactly the files of its manifest, unchanged."""
    try:
        manifest = json.loads((folder / MANIFEST).read_text(encoding="utf-8"))
        return bool(manifest["files"] == _digests(folder))
    except (OSError, ValueError, KeyError, TypeError):
        return False


def stamps(folder: Path) -> tuple[tuple[str, int, int], ...]:
    """Name, size and time of each file of an entry: what a change of it changes, but for a change that hides."""
    found, folders = [], [os.fspath(folder)]
    while folders:
        try:
            entries = list(os.scandir(folders.pop()))
        except OSError:
            continue  # as nothing
        for entry in entries:
            if entry.is_dir(follow_symlinks=False):
                folders.append(entry.path)
            else:
                status = entry.stat()
                found.append((entry.path, status.st_size, status.st_mtime_ns))
    return tuple(sorted(found))


def facts(folder: Path) -> Mapping[str, str]:
    """What was noted of an entry when it was made."""
    noted: Mapping[str, str] = json.loads((folder / MANIFEST).read_text(encoding="utf-8"))["facts"]
    return noted
