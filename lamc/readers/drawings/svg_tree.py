"""SVG as a tree of elements that know their lines. Nothing outside the file is read.

In: bytes. Out: an `Element`, the root. Never: fetches what a DOCTYPE, an entity or a link names; expands an entity that
holds markup or other entities.

Illustrator writes namespaces as entities, `<!ENTITY ns_svg "http://www.w3.org/2000/svg">`; such plain texts are
expanded, as far as the file's own limit of bytes.
"""

import re
from dataclasses import dataclass, field
from typing import Any
from xml.parsers import expat

from lamc.basics.errors import DesignError, Place
from lamc.readers.inert import Limits

_LONGEST_ENTITY = 1000  # characters; a namespace has some fifty
_NO_REFERENCES = re.compile(rb"<!--.*?-->|<!\[CDATA\[.*?\]\]>", re.DOTALL)
_REFERENCE = re.compile(rb"&([A-Za-z_:][\w:.-]*);")
_KNOWN = frozenset((b"amp", b"lt", b"gt", b"quot", b"apos"))
_DOUBLED = re.compile(r"_[0-9]+_\Z")  # Illustrator's mark of a second thing of one name
_CODED = re.compile(r"_x([0-9A-Fa-f]{2,4})_")  # and of a character that an id cannot have


def _runs(name: str, value: str) -> bool:
    """Whether an attribute is a program, as onload is, or links to one."""
    is_link = name.rpartition(":")[2] == "href" and value.strip().lower().startswith("javascript:")
    return is_link or (name.startswith("on") and len(name) > len("only") and name.isalpha())


@dataclass(eq=False, slots=True)
class Element:
    """One element.

    tag     its name, without the prefix of SVG's namespace; with its prefix if it is of another one
    number  which of its tag it is in the file, from 1
    text    what stands in it, of styles, titles and metadata
    """

    tag: str
    attributes: dict[str, str]
    place: Place
    number: int
    parent: "Element | None"
    children: list["Element"] = field(default_factory=list)
    text: str = ""

    def get(self, name: str, default: str = "") -> str:
        return self.attributes.get(name, default)

    def error(self, message: str) -> DesignError:
        return DesignError(message, self.place)

    @property
    def href(self) -> str:
        return self.get("href") or self.get("xlink:href")

    @property
    def source(self) -> str:
        """What messages call it: "path #fold3", "path 7 (line 12)"."""
        name = self.get("id")
        if name and name.isprintable():
            return f"{self.tag[:40]} #{name[:60]}"
        return f"{self.tag[:40]} {self.number} (line {self.place.line})"

    @property
    def label(self) -> str:
        """The name of a group as its user wrote it; "" for none."""
        label = self.get("inkscape:label") or self.get("data-name") or self.get("serif:id")
        if label:
            return label.strip()
        coded = _DOUBLED.sub("", self.get("id"))
        return _CODED.sub(lambda found: chr(int(found[1], 16)), coded).strip()


@dataclass(frozen=True)
class Document:
    """What a file holds.

    ids       elements by id; of several of one id, the first
    count     how many elements it has
    comments  the first few, where programs leave their names
    notes     what was left out on the way
    programs  names of scripts, and of attributes that are run in a browser, wherever they stand
    """

    root: Element
    ids: dict[str, Element]
    count: int
    styles: tuple[Element, ...]
    comments: tuple[str, ...]
    notes: tuple[str, ...]
    programs: tuple[str, ...]


def document(data: bytes, file: str, limits: Limits) -> Document:
    """The document in `data`. Raises DesignError with the place for what is no SVG or beyond a limit."""
    if len(data) > limits.bytes:
        raise DesignError(
            f"the file has {len(data)} bytes; at most {limits.bytes} are read (limit 'bytes')", Place(file)
        )
    return _Reader(data, file, limits).document()


class _Reader:
    def __init__(self, data: bytes, file: str, limits: Limits) -> None:
        self.data, self.file, self.limits = data, file, limits
        self.root: Element | None = None
        self.ids: dict[str, Element] = {}
        self.styles: list[Element] = []
        self.comments: list[str] = []
        self.notes: list[str] = []
        self.programs: list[str] = []
        self._open: list[Element] = []
        self._counts: dict[str, int] = {}
        self._total = 0
        self._entities: dict[str, str] = {}
        self._prefix = ""
        self._parser: Any = None

    def document(self) -> Document:
        parser = self._parser = expat.ParserCreate()
        parser.buffer_text = True
        parser.specified_attributes = True  # defaults of a DTD could be long, and stand at every element
        parser.StartElementHandler = self._start
        parser.EndElementHandler = self._end
        parser.CharacterDataHandler = self._characters
        parser.CommentHandler = self._comment
        parser.EntityDeclHandler = self._entity
        parser.EndDoctypeDeclHandler = self._check_entities
        parser.ProcessingInstructionHandler = self._instruction
        try:
            parser.Parse(self.data, True)
        except expat.ExpatError as error:
            raise self._malformed(error) from error
        except (ValueError, LookupError) as error:  # an encoding that Python does not know
            raise DesignError(
                f"the file cannot be read: {str(error)[:120]}; save it as UTF-8", Place(self.file)
            ) from error
        assert self.root is not None
        self._check_references()
        return Document(
            self.root,
            self.ids,
            self._total,
            tuple(self.styles),
            tuple(self.comments),
            tuple(self.notes),
            tuple(self.programs),
        )

    def _error(self, message: str) -> DesignError:
        return DesignError(message, Place(self.file, *self._where()))

    def _where(self) -> tuple[int, int]:
        return self._parser.CurrentLineNumber, self._parser.CurrentColumnNumber + 1

    def _malformed(self, error: expat.ExpatError) -> DesignError:
        place = Place(self.file, error.lineno, error.offset + 1)
        problem = expat.ErrorString(error.code) or "it cannot be parsed"
        if self._open and problem in ("no element found", "unclosed token"):
            within = self._open[-1].source
            return DesignError(f"the file ends within {within}: it was cut short; save it again", place)
        return DesignError(f"this is not XML: {problem}; open and save it in a program that draws", place)

    def _start(self, name: str, attributes: dict[str, str]) -> None:
        if self.root is None:
            prefix, _, local = name.rpartition(":")
            if local != "svg":
                raise self._error(f"the file is XML of <{name[:40]}>, not a drawing; lamc reads SVG")
            self._prefix = f"{prefix}:" if prefix else ""
        tag = name.removeprefix(self._prefix)
        self._total += 1
        if self._total > self.limits.values:
            raise self._error(
                f"the file has more elements than the limit 'values' of {self.limits.values}; leave out what is no "
                "line, or allow more in Python: load(path, limits=Limits(values=…))"
            )
        if len(self._open) >= self.limits.depth:
            raise self._error(
                f"groups lie in one another deeper than the limit 'depth' of {self.limits.depth} levels; ungroup them"
            )
        number = self._counts[tag] = self._counts.get(tag, 0) + 1
        parent = self._open[-1] if self._open else None
        made = Element(tag, attributes, Place(self.file, *self._where()), number, parent)
        if parent is None:
            self.root = made
        else:
            parent.children.append(made)
        self._open.append(made)
        if made.get("id"):
            self.ids.setdefault(made.get("id"), made)
        if tag == "style":
            self.styles.append(made)
        if tag == "script":
            self.programs.append(made.source)
        self.programs += (
            f"{key[:40]} of {made.source}" for key, value in attributes.items() if _runs(key, value)
        )

    def _end(self, name: str) -> None:
        self._open.pop()

    def _characters(self, text: str) -> None:
        if self._open and self._open[-1].tag in ("style", "title"):
            self._open[-1].text += text

    def _comment(self, text: str) -> None:
        if len(self.comments) < 10:
            self.comments.append(text[:200])

    def _instruction(self, target: str, data: str) -> None:
        if target == "xml-stylesheet":
            self.notes.append("a stylesheet outside the file is not fetched: put its text into <style>")

    def _entity(
        self,
        name: str,
        is_parameter: bool,
        value: str | None,
        base: str | None,
        system: str | None,
        public: str | None,
        notation: str | None,
    ) -> None:
        called = f"the entity {name[:40]!r}"
        way_out = "save the file as plain SVG"
        if is_parameter or value is None:
            raise self._error(
                f"{called} stands for a file or for declarations, which are not read; {way_out}"
            )
        if "&" in value or "%" in value or "<" in value:
            raise self._error(f"{called} holds other entities or markup, which is not expanded; {way_out}")
        if len(value) > _LONGEST_ENTITY:
            raise self._error(
                f"{called} has {len(value)} characters; at most {_LONGEST_ENTITY} are expanded; {way_out}"
            )
        self._entities[name] = value

    def _check_entities(self) -> None:
        """Before anything is expanded: all of it together stays within the limit of bytes."""
        longest = max((len(value) for value in self._entities.values()), default=0)
        expanded = longest * self.data.count(b"&")
        if expanded > self.limits.bytes:
            raise self._error(
                f"entities, written out, may come to {expanded} bytes; at most {self.limits.bytes} are read (limit "
                "'bytes'): save the file as plain SVG"
            )

    def _check_references(self) -> None:
        """Entities of a DTD that is not fetched are not known; the parser drops those in attributes."""
        known = _KNOWN | {name.encode() for name in self._entities}
        for found in _REFERENCE.finditer(_NO_REFERENCES.sub(b"", self.data)):
            if found[1] not in known:
                name = found[1].decode("utf-8", "replace")[:40]
                at = self.data.find(found[0])
                raise DesignError(
                    f"the file uses the entity &{name}; without saying what it stands for; write the character itself",
                    Place(self.file, self.data.count(b"\n", 0, at) + 1),
                )
