"""Files beside a design: read from the same folder, and from nowhere else.

popupCAD stores designs inside designs; a file may also only name one, by its file. In: nodes that name a design, and
the folder of the file that they stand in. Out: the design's nodes. Of a name only the last part counts, whatever
folders it had where it was written; a link that leads out of the folder is refused, and so are files that need each
other. Texts are read as data, as every file is. A native design names drawings, plainly: see `Beside.data_of`.
"""

import hashlib
import re
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

from lamc.basics.errors import DesignError
from lamc.basics.files import read_bytes
from lamc.readers.inert import DEFAULT_LIMITS, Limits, compose
from lamc.readers.nodes import MapNode, Node, ScalarNode
from lamc.readers.objects import optional, refuse_stored_code, word

MOST_FILES = 100  # beside one design; the largest of popupCAD's gallery places nine designs
DEEPEST = 20  # files that rest on one another; Python's own stack holds five times as many

Decode = Callable[[bytes, str], str]


def _utf8(data: bytes, file: str) -> str:
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise DesignError(f"{file}: byte {error.start} is not text") from error


@dataclass(eq=False)
class Beside:
    """The folder of a design's file, and what was read from it.

    file     the design's own; None for a text that is in no file, and so has no folder
    limits   of all files together: their bytes; of each: the rest
    decode   bytes of a file, and its name, to text
    digests  SHA-256 of each file read, by its name
    given    bytes of drawings that are in no file yet, by the names that they will have
    """

    file: Path | None = None
    limits: Limits = DEFAULT_LIMITS
    decode: Decode = _utf8
    digests: dict[str, str] = field(default_factory=dict)
    given: Mapping[str, bytes] = field(default_factory=dict)
    _designs: dict[Path, Node] = field(default_factory=dict)
    _open: list[Path] = field(default_factory=list)  # files in whose designs laminates are being made
    _bytes: int = 0

    def design_of(self, key: Node, stored: Node | None) -> Node:
        """The design that `key` names: `stored`, or in the file that `stored` or `key` itself names.

        stored  what this design has under that id: a design, the name of a file, a design that has only the name of
                its file (`_basename`) left; None for nothing

        Raises DesignError where there is none, or it may not be read.
        """
        if isinstance(stored, MapNode) and optional(stored, "operations", "the design inside") is not None:
            return stored
        named = stored
        if isinstance(stored, MapNode):
            named = optional(stored, "_basename", "the design inside")
        elif stored is None and word(key, "a design's id").lower().endswith(".cad"):
            named = key
        if not isinstance(named, ScalarNode) or named.value is None:
            raise key.error(
                f"no design {word(key, 'the id')[:40]!r} is stored inside this one; save it in popupCAD again"
            )
        return self._read(named)

    @contextmanager
    def entered(self, design: Node, link: Node) -> Iterator[None]:
        """For the time in which laminates of `design` are made for the operation that `link` stands in.

        Raises DesignError where that time has begun already, for a file that needs itself through others."""
        file = next((path for path, node in self._designs.items() if node is design), None)
        if file is None:
            yield
            return
        chain = [self.file.resolve(), *self._open] if self.file is not None else self._open
        if file in chain:
            names = " → ".join([*(path.name for path in chain[chain.index(file) :]), file.name])
            raise link.error(f"these files place each other's laminates: {names}; take one of them out")
        if len(self._open) >= DEEPEST:
            raise link.error(f"more than {DEEPEST} files rest on one another; store designs inside designs")
        self._open.append(file)
        try:
            yield
        finally:
            self._open.pop()

    def data_of(self, name: str) -> bytes:
        """The bytes of a file of that name in the design's folder.

        Raises DesignError where there is none, where the name has folders, and where all files together are too large.
        """
        if not name or name in (".", "..") or not name.isprintable() or re.search(r"[\\/:]", name):
            raise DesignError("name a file that lies beside this one, without folders")
        if name in self.given:
            self.digests[name] = hashlib.sha256(self.given[name]).hexdigest()
            return self.given[name]
        if self.file is None:
            raise DesignError(
                "this text is in no file that a drawing could lie beside; load the file by its path"
            )
        path = self._path(name, "put that file beside this one")
        data = self._data(path)
        self.digests[name] = hashlib.sha256(data).hexdigest()
        return data

    def _path(self, name: str, way_out: str) -> Path:
        assert self.file is not None
        folder = self.file.parent
        try:
            path = (folder / name).resolve()
            is_outside = not path.is_relative_to(folder.resolve())
        except (OSError, RuntimeError, ValueError) as error:  # a link to itself
            raise DesignError(f"the file {name[:80]!r} beside this one cannot be found; {way_out}") from error
        if is_outside:
            raise DesignError(
                f"the file {name[:80]!r} beside this one is a link that leads out of its folder; {way_out}"
            )
        return path

    def _data(self, path: Path) -> bytes:
        if len(self.digests) >= MOST_FILES:
            raise DesignError(f"more than {MOST_FILES} files beside this design")
        data = read_bytes(path, max(0, self.limits.bytes - self._bytes))
        self._bytes += len(data)
        return data

    def _read(self, named: ScalarNode) -> Node:
        name = re.split(r"[\\/]", named.text)[-1].strip()
        way_out = "put that file beside this one, or save this one in popupCAD again with the design inside"
        if name in ("", ".", "..") or not name.isprintable():
            raise named.error(f"the design inside this one is named {named.text[:80]!r}, which names no file")
        if self.file is None:
            raise named.error(
                f"the design {name[:80]!r} is not stored inside this one, and this text is in no file that it could "
                "lie beside; load the file by its path"
            )
        try:
            path = self._path(name, way_out)
        except DesignError as error:
            raise named.error(error.message) from error
        if path not in self._designs:
            self._designs[path] = self._loaded(self.file.parent / name, path, named, way_out)
        return self._designs[path]

    def _loaded(self, shown: Path, path: Path, named: ScalarNode, way_out: str) -> Node:
        if len(self._designs) >= MOST_FILES:
            raise named.error(
                f"more than {MOST_FILES} files beside this design; store designs inside designs"
            )
        try:
            data = self._data(path)
        except DesignError as error:
            raise named.error(
                f"the design {shown.name[:80]!r} is not stored inside this one, and of the file beside it: "
                f"{error.message}; {way_out}"
            ) from error
        node = compose(self.decode(data, str(shown)), str(shown), limits=self.limits)
        if not (node.tag.startswith("python/") and node.class_name == "Design"):
            raise named.error(
                f"the file {shown.name[:80]!r} beside this one is no popupCAD design; {way_out}"
            )
        refuse_stored_code(node)
        self.digests[shown.name] = hashlib.sha256(data).hexdigest()
        return node
