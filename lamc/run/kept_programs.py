"""What the cache knows of programs that were compiled: by the digest of a design, and by that of a structure.

In: a cache, digests. Out: the entry of a compiled module, and the numbers that a design gives it, so that nothing is
derived again. A note that is damaged or cannot be written costs a derivation, and nothing else.
"""

import hashlib
from collections import deque
from dataclasses import dataclass
from typing import Any
from weakref import WeakKeyDictionary, WeakValueDictionary

from lamc.basics._version import __version__
from lamc.codegen.cache import Cache, stamps
from lamc.codegen.module import Module, load_module
from lamc.codegen.options import CompileOptions
from lamc.codegen.toolchain import Compiler
from lamc.mechanics.survey import Survey
from lamc.run.extended import Extras
from lamc.run.input_digest import own_sources
from lamc.run.model import DesignNumbers
from lamc.symbolic.program import Program
from lamc.symbolic.staging import DrawnKey

_opened: "WeakValueDictionary[str, Module]" = WeakValueDictionary()  # by folder, verified
# A module of derivatives is asked for anew by each fit and each run with sensitivities, whose models do not hold it; to
# verify and load it takes a quarter of a short fit.
_latest: "deque[Module]" = deque(maxlen=8)
_stamps: "WeakKeyDictionary[Module, tuple[tuple[str, int, int], ...]]" = (
    WeakKeyDictionary()
)  # of their files, then


@dataclass(frozen=True)
class KeptDesign:
    """entry: the key of its module in the cache. numbers: of the design. keys: what `setup` takes of the drawing."""

    entry: str
    numbers: DesignNumbers
    keys: tuple[DrawnKey, ...]


@dataclass(frozen=True)
class KeptStructure:
    """entry: the key of the module in the cache. parameters, keys: names, and numbers of the drawing, that `setup`
    takes, in order."""

    entry: str
    parameters: tuple[str, ...]
    keys: tuple[DrawnKey, ...]


def numbers_of(program: Program) -> DesignNumbers:
    """The numbers of the design that a program was made of."""
    return DesignNumbers(tuple(program.inputs), program.drawn)


def structure_alias(structure: str, compiler: Compiler, options: CompileOptions, extras: Extras) -> str:
    """Under what the cache keeps what is known of a structure (the digest of a `Survey`)."""
    parts = (structure, __version__, own_sources(), compiler.identity, *options.flags, options.precision)
    text = "\0".join((*parts, str(extras)))
    return hashlib.sha256(text.encode()).hexdigest()


def kept_design(cache: Cache, alias: str) -> KeptDesign | None:
    found = cache.kept(alias)
    try:
        numbers = (tuple(map(float.fromhex, found[name])) for name in ("inputs", "drawn"))
        return KeptDesign(_entry(found), DesignNumbers(*numbers), _keys(found))
    except (ValueError, TypeError, KeyError):
        return None


def keep_design(cache: Cache, alias: str, design: KeptDesign) -> None:
    inputs, drawn = (list(map(float.hex, part)) for part in (design.numbers.inputs, design.numbers.drawn))
    keys = [list(key) for key in design.keys]
    cache.keep(alias, {"entry": design.entry, "inputs": inputs, "drawn": drawn, "keys": keys})


def kept_structure(cache: Cache, alias: str) -> KeptStructure | None:
    found = cache.kept(alias)
    try:
        return KeptStructure(_entry(found), tuple(map(str, found["parameters"])), _keys(found))
    except (ValueError, TypeError, KeyError):
        return None


def keep_structure(cache: Cache, alias: str, entry: str, program: Program) -> None:
    keys = [list(number.key) for number in program.geometry]
    names = [p.name for p in program.parameters]
    cache.keep(alias, {"entry": entry, "parameters": names, "keys": keys}, of_one_design=False)


def opened_entry(cache: Cache, entry: str) -> Module | None:
    """The module of an entry of the cache, verified and loaded; None where there is none, or it was changed. One that
    somebody has is not opened again, unless its files changed."""
    folder = cache.root / entry
    module = _opened.get(str(folder))
    if module is not None:
        cache.check_owner(cache.root)
    if module is not None and stamps(folder) == _stamps[module]:
        return module
    found = cache.find(entry)
    if found is None:
        return None
    module = load_module(found)
    keep_opened(cache, entry, module)
    return module


def keep_opened(cache: Cache, entry: str, module: Module) -> None:
    """The module of an entry that was verified or made just now is not opened again while somebody has it, or it is one
    of the latest."""
    folder = cache.root / entry
    _opened[str(folder)] = module
    _stamps[module] = stamps(folder)
    _latest.append(module)


def design_of_structure(cache: Cache, alias: str, survey: Survey) -> tuple[Module, KeptDesign] | None:
    """The module of a structure, and what is to be known of the design that was surveyed; None where there is none."""
    found = cache.once(alias, lambda: _opened_structure(cache, alias))
    if found is None:
        return None
    known, module = found
    if known.parameters != tuple(p.name for p in survey.parameters) or not survey.knows(known.keys):
        return None
    numbers = DesignNumbers(survey.inputs(known.keys), survey.drawn)
    return module, KeptDesign(known.entry, numbers, known.keys)


def _opened_structure(cache: Cache, alias: str) -> tuple[KeptStructure, Module] | None:
    known = kept_structure(cache, alias)
    module = opened_entry(cache, known.entry) if known is not None else None
    return None if known is None or module is None else (known, module)


def _keys(found: dict[str, Any]) -> tuple[DrawnKey, ...]:
    return tuple(tuple(key) for key in found["keys"])


def _entry(found: dict[str, object]) -> str:
    """Raises ValueError for what is no key of an entry."""
    entry = str(found["entry"])
    if len(entry) != 64 or not set(entry) <= set("0123456789abcdef"):
        raise ValueError(entry)
    return entry
