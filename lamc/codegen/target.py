"""What a compiler makes of flags that name this machine, such as -march=native: a mark for the keys of the cache.

In: a compiler's identity, its command and flags. Out: a digest of the macros that it predefines under them, which tell
every instruction set that it may use, and for gcc what it tunes for. *Invariant*: two processors share an entry of the
cache only where the compiler would make the same of both; else a home that several machines share holds code that ends
with an illegal instruction on some of them.
"""

import hashlib
import os
import tempfile
from collections.abc import Callable, Sequence
from functools import cache
from pathlib import Path

from lamc.codegen.cache import Cache

_CPUINFO = Path("/proc/cpuinfo")
Run = Callable[[Sequence[str], Path], str]  # arguments and a folder to what the compiler prints


def names_this_machine(arguments: Sequence[str]) -> bool:
    """Whether some argument asks for the processor that it meets, as -march=native and -mtune=native do."""
    return any(word.endswith("=native") for word in arguments)


def mark(identity: str, flags: Sequence[str], run: Run, store: Cache) -> str:
    """The digest. It is asked for once per compiler, flags and processor, and remembered in `store`.

    Raises BuildError where the compiler does not tell its macros."""
    processor = _processor()
    parts = ("target", identity, *flags, processor)
    alias = hashlib.sha256("\0".join(parts).encode()).hexdigest()
    # A processor that the system does not describe may be another one next time.
    known = store.recall(alias) if processor else None
    if known is None:
        known = _asked(identity, tuple(flags), run)
        if processor:
            store.remember(alias, known)
    return known


def _asked(identity: str, flags: tuple[str, ...], run: Run) -> str:
    key = (identity, flags)
    if key not in _known_marks():
        macros = run([*flags, "-dM", "-E", "-x", "c", os.devnull], Path(tempfile.gettempdir()))
        _known_marks()[key] = hashlib.sha256(macros.encode()).hexdigest()
    return _known_marks()[key]


@cache
def _known_marks() -> dict[tuple[str, tuple[str, ...]], str]:
    """What compilers told this process, which stays on one processor."""
    return {}


@cache
def _processor() -> str:
    """All that Linux says of its first processor but its momentary clock; "" on other systems."""
    lines = []
    try:
        with _CPUINFO.open(encoding="utf-8", errors="replace") as stream:
            for line in stream:
                if not line.strip():
                    break
                if not line.startswith(("cpu MHz", "bogomips", "BogoMIPS")):
                    lines.append(line.strip())
    except OSError:
        return ""
    return "\n".join(lines)
