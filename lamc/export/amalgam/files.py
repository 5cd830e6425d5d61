"""Several C files as one, with nothing in it that is not needed and no name that could meet another's.

In: files by name, the order of the sources, the names that stay as they are. Out: the declarations that the public ones
reach, in an order in which each stands before its use, all others static under a prefix; the system headers that they
need. Never: compiles, or changes an expression.

Files see each other's names as a linker would let them: a name of a header or with external linkage is one for all, a
static one, a type or a macro of a source is its own. Members of structs keep their names.
"""

import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

from lamc.export.amalgam.tokens import QUIET, Item, Token, head_comment, items, tokens

_WORD = re.compile(r"[A-Za-z_]\w*")


@dataclass(frozen=True)
class Unit:
    """One file, without its includes and guards."""

    name: str  # without suffix
    is_header: bool
    head: str  # the comment it opens with
    items: tuple[Item, ...]


@dataclass(frozen=True)
class Amalgam:
    text: str
    system_headers: tuple[str, ...]  # that the files include, in order of their names


@dataclass(frozen=True)
class _Parsed:
    """A file by itself."""

    head: str
    includes: tuple[str, ...]  # as they are written, in their order
    items: tuple[Item, ...]


class _Reader:
    """Files in the order in which a compiler would meet them, each once."""

    def __init__(
        self, files: Mapping[str, str], replaced: Mapping[str, str], defined: Collection[str]
    ) -> None:
        self._files, self._replaced, self._defined = files, replaced, frozenset(defined)
        self.units: dict[str, Unit] = {}
        self.system: set[str] = set()

    def read(self, file: str) -> None:
        if file in self.units or file not in self._files:
            return
        name, _, suffix = file.rpartition(".")
        parsed = _parsed(file, self._files[file], self._defined)
        for subject in parsed.includes:
            self._include(subject)
        found = tuple(self._put_in_place(item) for item in parsed.items)
        self.units[file] = Unit(name, suffix == "h", parsed.head, found)

    def _put_in_place(self, item: Item) -> Item:
        """An item, or what stands in its place."""
        for name in item.declares:
            key = f"{item.unit}.{name}"
            if key in self._replaced:
                (other,) = items(item.unit, tokens(self._replaced[key]))
                return replace(other, gap=item.gap)
        return item

    def _include(self, subject: str) -> None:
        file = subject.strip('<>"')
        if subject.startswith("<") and file not in self._files:
            self.system.add(file)
        else:
            self.read(file)


@lru_cache(maxsize=256)  # the runtime has fifty files, which every export of a process reads
def _parsed(file: str, text: str, defined: frozenset[str]) -> _Parsed:
    head = head_comment(text)
    stream = tokens(text)
    if head:
        stream = stream[next(i for i, t in enumerate(stream) if t.kind == "comment") + 1 :]
    includes: list[str] = []
    kept = list(_without_guards(stream, defined, includes))
    return _Parsed(head, tuple(includes), tuple(items(file.rpartition(".")[0], kept)))


def _without_guards(
    stream: Sequence[Token], defined: Collection[str], includes: list[str]
) -> Iterator[Token]:
    """Includes are left out and listed in `includes`; include guards, extern "C" and groups that `defined` decides are
    left out too."""
    groups: list[bool | None] = []  # open ones: whether the text counts; None: the compiler decides
    for position, token in enumerate(stream):
        if token.kind != "directive":
            if False not in groups:
                yield token
            continue
        word, _, rest = token.text[1:].strip().partition(" ")
        subject = rest.strip().split(" ")[0]
        is_decided = False
        if word in ("if", "ifdef", "ifndef"):
            groups.append(_decide(word, subject, stream, position, defined))
            is_decided = groups[-1] is not None
        elif word == "endif":
            is_decided = groups.pop() is not None
        elif word == "else" and groups[-1] is not None:
            groups[-1] = not groups[-1]
            is_decided = True
        if is_decided or False in groups:
            continue
        if word == "include":
            includes.append(subject)
        elif not (word == "define" and subject.endswith("_H")):
            yield token


def _decide(
    word: str, subject: str, stream: Sequence[Token], position: int, defined: Collection[str]
) -> bool | None:
    """Whether the text of a group counts; None: the compiler decides."""
    if word == "ifndef" and subject.endswith("_H"):
        return True
    if subject == "__cplusplus":
        after = [token for token in stream[position + 1 : position + 4] if token.kind not in QUIET]
        return False if after and after[0].text in ("extern", "}") else None
    if word in ("ifdef", "ifndef") and subject.startswith("LAMC_"):
        return (subject in defined) == (word == "ifdef")
    return None


def public_functions(header: str, prefix: str) -> list[str]:
    """Functions that an export's header declares."""
    lines = [line for line in header.splitlines() if line.startswith(f"{prefix.upper()}_API ")]
    return [line.split("(")[0].split()[-1].lstrip("*") for line in lines]


def amalgamate(
    files: Mapping[str, str],
    sources: Sequence[str],
    public: Collection[str],
    prefix: str,
    *,
    replaced: Mapping[str, str] | None = None,
    defined: Collection[str] = (),
    aliases: Mapping[str, str] | None = None,
) -> Amalgam:
    """One text of `sources` and the headers that they include.

    files     name → text, flat; one under the name of a system header takes its place, and what is not among them and
              included by "" is left to the caller
    sources   in an order in which objects stand before their use
    public    names of the functions that stay as they are; what they do not reach is left out
    prefix    of all other names: prefix_rt_…
    replaced  "unit.name" → declaration that takes the place of the one of that name
    defined   macros that groups of directives may ask for; all other LAMC_… are not
    aliases   names that stand for others, such as sqrt for a square root among the files
    """
    reader = _Reader(files, replaced or {}, defined)
    for source in sources:
        reader.read(source)
    units = sorted(reader.units.values(), key=lambda unit: not unit.is_header)
    names = _Names(units, public, prefix, aliases or {})
    reached = _reached(units, names, public)
    parts = []
    for unit in units:
        texts = [
            ("\n" if item.gap else "") + _printed(item, names, public)
            for item in unit.items
            if id(item) in reached
        ]
        if texts:
            head = "" if unit.is_header else names.renamed_words(unit.head, unit.name) + "\n"
            parts.append(head + "\n".join(texts).strip("\n") + "\n")
    return Amalgam("\n".join(parts), tuple(sorted(reader.system)))


class _Names:
    """Which names there are, and what they become."""

    def __init__(
        self, units: Sequence[Unit], public: Collection[str], prefix: str, aliases: Mapping[str, str]
    ) -> None:
        self._aliases = aliases
        self._own: dict[str, dict[str, str]] = {unit.name: {} for unit in units}
        self._shared: dict[str, str] = {}
        self._prefix = prefix
        taken: set[str] = set(public)
        for unit in units:
            for item in unit.items:
                is_shared = unit.is_header or (
                    item.kind in ("function", "prototype", "object", "extern") and not item.is_static
                )
                table = self._shared if is_shared else self._own[unit.name]
                for name in item.declares:
                    if name in table or name in public:
                        continue
                    table[name] = self._fresh(name, "" if is_shared else unit.name, taken)

    def _fresh(self, name: str, unit: str, taken: set[str]) -> str:
        core = name.removeprefix("lamc_").removeprefix("LAMC_")
        is_said = not unit or core.lower().startswith(f"{unit}_")
        whole = f"{self._prefix}_rt_{core}" if is_said else f"{self._prefix}_rt_{unit}_{core}"
        if core.isupper():
            whole = whole.upper()
        candidate, number = whole, 1
        while candidate in taken:
            number += 1
            candidate = f"{whole}_{number}"
        taken.add(candidate)
        return candidate

    def key(self, name: str, unit: str) -> str | None:
        """What a name means in a unit: "unit.name" for its own, the name for a shared one, None for any other."""
        if name in self._own[unit]:
            return f"{unit}.{name}"
        name = self._aliases.get(name, name)
        return name if name in self._shared else None

    def renamed(self, name: str, unit: str) -> str:
        own = self._own[unit].get(name)
        return own or self._shared.get(self._aliases.get(name, name), name)

    def renamed_words(self, text: str, unit: str) -> str:
        """Comments: only names that say that they are lamc's, since others are English words too."""

        def word(match: re.Match[str]) -> str:
            is_ours = match.group().startswith(("lamc_", "LAMC_"))
            return self.renamed(match.group(), unit) if is_ours else match.group()

        return _WORD.sub(word, text)


def _reached(units: Sequence[Unit], names: _Names, public: Collection[str]) -> set[int]:
    """Identities of the items that the public ones reach."""
    by_key: dict[str, list[Item]] = {}
    waiting: list[Item] = []
    for unit in units:
        for item in unit.items:
            for name in item.declares:
                if name in public:
                    waiting.append(item)
                key = names.key(name, unit.name)
                if key is not None and item.kind != "extern":
                    by_key.setdefault(key, []).append(item)
    reached: set[int] = set()
    while waiting:
        item = waiting.pop()
        if id(item) in reached:
            continue
        reached.add(id(item))
        for name in item.names:
            key = names.key(name, item.unit)
            waiting += by_key.get(key, []) if key is not None else []
    return reached


def _printed(item: Item, names: _Names, public: Collection[str]) -> str:
    """The text of an item under its new names; static unless it is public."""
    out: list[str] = []
    is_struct = item.kind == "type" and any(token.text == "struct" for token in item.significant[:2])
    needs_static = item.kind in ("function", "prototype", "object") and not item.is_static
    if needs_static and any(name in public for name in item.declares):
        needs_static = False
    depth = 0
    before, behind = "", _followers(item.tokens)
    for token, after in zip(item.tokens, behind, strict=True):
        text = token.text
        if token.kind == "comment":
            text = names.renamed_words(text, item.unit)
        elif token.kind == "directive":
            text = _WORD.sub(lambda match: names.renamed(match.group(), item.unit), text)
        elif token.kind == "name" and not _is_member(before, after, is_struct and depth > 0):
            text = names.renamed(text, item.unit)
        if token.kind not in QUIET:
            before = token.text
            if needs_static:
                text, needs_static = f"static {text}", False
        depth += (token.text == "{") - (token.text == "}")
        out.append(text)
    return "".join(out)


def _followers(stream: Sequence[Token]) -> list[str]:
    """For each token the text of the next one that is neither space nor comment; empty behind the last."""
    found, after = [], ""
    for token in reversed(stream):
        found.append(after)
        if token.kind not in QUIET:
            after = token.text
    return found[::-1]


def _is_member(before: str, after: str, is_in_struct: bool) -> bool:
    """Whether a name between two tokens is that of a member: after . or ->, or where a struct declares it."""
    return before in (".", "->") or (is_in_struct and after in (";", "[", ",", ")", ":"))
