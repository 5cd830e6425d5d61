"""What a DXF file's model space shows: lines of entities and of the blocks that it inserts, with layer and colour.

In: an ezdxf document. Out: `Drawn`s, and notes for what is left out. Never: follows a reference to another file.

Blocks are counted before they are inserted: what a bomb of blocks in blocks would show is known without being made.
"""

import math
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from lamc.basics.errors import DesignError
from lamc.readers.drawings.courses import Course
from lamc.readers.drawings.dxf_curves import DRAWN, courses_of, object_frame
from lamc.readers.drawings.dxf_repair import key_of, named
from lamc.readers.inert import Limits
from lamc.records.mechanism import Array

_WAYS = {
    **dict.fromkeys(("REGION", "BODY", "3DSOLID", "SURFACE"), "solids of ACIS: EXPLODE them to lines in CAD"),
    **dict.fromkeys(("3DFACE", "MESH"), "faces in space: draw their edges as lines"),
    **dict.fromkeys(
        ("IMAGE", "WIPEOUT", "PDFUNDERLAY", "DWFUNDERLAY", "OLE2FRAME"), "pictures, never fetched"
    ),
    **dict.fromkeys(("XLINE", "RAY"), "lines without an end"),
    **dict.fromkeys(("MLINE", "HELIX", "MPOLYGON", "ACAD_PROXY_ENTITY"), "EXPLODE them to lines in CAD"),
}
_BYBLOCK, _BYLAYER = 0, 256
_SHARE = 3  # values of other files cost as much time as one entity that is shown: 45 µs, and what follows


@dataclass(frozen=True)
class Drawn:
    """One line.

    course  in units of the file, world coordinates
    colour  "#rrggbb"
    source  "LINE 2F", "ARC 31 of block 'ARM' (INSERT 4A)"
    """

    course: Course
    layer: str
    colour: str
    source: str


@dataclass(frozen=True)
class _Around:
    """What an inserted block's entities take from their INSERT."""

    matrix: Array
    layer: str = "0"
    colour: str = "#000000"
    source: str = ""


class Walk:
    """One document. Raises DesignError for blocks that never end, and for what is beyond the limits.

    left  kinds of entities that are not read, by handle
    """

    def __init__(self, document: Any, left: Mapping[bytes, str], limits: Limits) -> None:
        self.document, self.left, self.limits = document, left, limits
        self.notes: list[str] = []
        self.kinds: Counter[str] = Counter()
        self.unseen: Counter[str] = Counter()
        self.flawed: list[str] = []
        self.hatches = 0
        self.counts: dict[str, int] = {}

    def drawn(self) -> list[Drawn]:
        """All lines, in the order of the file."""
        space = self.document.modelspace()
        count = self._count(space, [])
        most = self.limits.values // _SHARE
        if count > most:
            raise DesignError(
                f"the drawing shows {count:.6g} entities with all blocks inserted; the limit 'values' of "
                f"{self.limits.values} lets {most} through (lamc.Limits)"
            )
        found = list(self._layout(space, _Around(np.eye(4))))
        self._tell(len(space))
        return found

    def _count(self, entities: Any, above: list[str]) -> int:
        """How many entities there are with all blocks inserted."""
        total = 0
        for entity in entities:
            total += 1
            if entity.dxftype() != "INSERT":
                continue
            block, name = entity.block(), self._key(entity)
            if block is None or entity.is_xref():
                continue
            if name in above:
                ring = " in ".join(repr(each) for each in [name, *reversed(above[above.index(name) :])])
                raise DesignError(
                    f"{_called(entity)} inserts block {ring}: a block within itself has no end; take that INSERT out"
                )
            if len(above) >= self.limits.depth:
                raise DesignError(
                    f"blocks are nested more than the limit 'depth' of {self.limits.depth} deep"
                )
            if name not in self.counts:
                self.counts[name] = self._count(block, [*above, name])
            columns, rows, _, _ = _grid(entity)
            total += (self.counts[name] + 1) * columns * rows
        return total

    def _key(self, insert: Any) -> str:
        return str(insert.dxf.get("name", "")).lower()

    def _layout(self, entities: Any, around: _Around) -> Iterator[Drawn]:
        for entity in entities:
            kind = entity.dxftype()
            if kind != "INSERT" and kind not in DRAWN:
                kind = self.left.get(key_of(str(entity.dxf.handle).encode()), kind)
                self.kinds["SURFACE" if kind.endswith("SURFACE") else kind] += 1
                continue
            layer = entity.dxf.layer
            if layer == "0" and around.source:
                layer = around.layer
            source = _called(entity) + around.source
            hidden = self._hidden(entity, layer)
            if kind == "INSERT":
                yield from self._inserted(entity, layer, source, around, hidden)
            elif hidden:
                self.unseen[hidden] += 1
            else:
                self.hatches += kind == "HATCH"
                colour = self._colour(entity, layer, around)
                for course in self._courses(entity, source):
                    yield Drawn(course.moved(around.matrix), layer, colour, source)

    def _courses(self, entity: Any, source: str) -> list[Course]:
        try:
            return courses_of(entity)
        except DesignError as error:
            self.flawed.append(f"{source}: {error.message}")
        except Exception as error:  # whatever ezdxf makes of an entity that is not as its kind should be
            self.flawed.append(f"{source}: it cannot be read ({type(error).__name__}: {str(error)[:80]})")
        return []

    def _inserted(
        self, insert: Any, layer: str, source: str, around: _Around, hidden: str
    ) -> Iterator[Drawn]:
        name, block = insert.dxf.get("name", ""), insert.block()
        if block is None:
            self.flawed.append(f"{source}: it inserts block {name[:40]!r}, which is not in the file")
        elif insert.is_xref():
            path = str(block.block_record.block.dxf.get("xref_path", ""))[:80]
            self.notes.append(
                f"{source} is a reference to another file, {path!r}, which is not fetched: insert it as a block (BIND)"
            )
        elif hidden.endswith("frozen") or hidden == "invisible entities":
            self.unseen[hidden] += 1
        else:
            self.kinds["ATTRIB"] += len(insert.attribs)
            if insert.has_extension_dict and "ACAD_FILTER" in insert.get_extension_dict().dictionary:
                self.notes.append(f"{source} is clipped in CAD; its block is read whole")
            at = f" of block {name[:40]!r} ({_called(insert)}){around.source}"
            colour = self._colour(insert, layer, around)
            own = np.array(list(insert.matrix44())).reshape(4, 4)
            axes = object_frame(insert.dxf.extrusion)[:2, :3]
            for across, up in _offsets(insert):
                matrix = own.copy()
                matrix[3, :3] += np.array([across, up]) @ axes
                yield from self._layout(block, _Around(matrix @ around.matrix, layer, colour, at))

    def _hidden(self, entity: Any, layer: str) -> str:
        """Why an entity is not shown; "" for one that is."""
        if entity.dxf.get("invisible", 0):
            return "invisible entities"
        found = self._layer(layer)
        if found is None:
            return ""
        if found.is_frozen():
            return f"layer {layer[:60]!r}, frozen"
        if found.is_off():
            return f"layer {layer[:60]!r}, off"
        return ""

    def _layer(self, name: str) -> Any:
        return self.document.layers.get(name) if self.document.layers.has_entry(name) else None

    def _colour(self, entity: Any, layer: str, around: _Around) -> str:
        number = entity.dxf.get("color", _BYLAYER)
        if entity.dxf.hasattr("true_color"):
            value = entity.dxf.true_color
            return _shown((value >> 16 & 255, value >> 8 & 255, value & 255))
        if number == _BYBLOCK:
            return around.colour
        found = self._layer(layer)
        if number == _BYLAYER:
            if found is not None and found.rgb is not None:
                return _shown(found.rgb)
            number = abs(found.dxf.get("color", 7)) if found is not None else 7
        return _indexed(number)

    def _tell(self, count: int) -> None:
        plain = {kind: number for kind, number in sorted(self.kinds.items()) if number and kind not in _WAYS}
        if plain:
            listed = ", ".join(f"{number} {kind[:40]}" for kind, number in list(plain.items())[:12])
            self.notes.append(f"left out, for they are no lines of the part: {listed}")
        for way in dict.fromkeys(_WAYS.values()):
            listed = ", ".join(f"{self.kinds[k]} {k}" for k in _WAYS if _WAYS[k] == way and self.kinds[k])
            if listed:
                self.notes.append(f"left out: {listed} ({way})")
        for why, number in sorted(self.unseen.items()):
            self.notes.append(
                f"left out, for CAD does not show them: {number} on {why}".replace("on inv", "inv")
            )
        for flaw in self.flawed[:3]:
            self.notes.append(f"left out: {flaw}")
        if len(self.flawed) > 3:
            self.notes.append(f"left out: {len(self.flawed) - 3} entities more that cannot be read")
        if self.hatches:
            self.notes.append(
                f"the outlines of {self.hatches} HATCH are read as lines; what fills them is not"
            )
        for layout in self.document.layouts:
            lines = sum(entity.dxftype() != "VIEWPORT" for entity in layout)
            if layout.name != "Model" and lines:
                what = "the model space is empty" if not count else "the model space alone is read"
                self.notes.append(
                    f"{what}; paper space {layout.name[:40]!r} has {lines} entities (CHSPACE moves them)"
                )


def _called(entity: Any) -> str:
    return named(entity.dxftype()[:40], entity.dxf.handle)


def _grid(insert: Any) -> tuple[int, int, float, float]:
    """Columns, rows and how far apart they are; a spacing of 0 puts all of them on one another."""
    dxf = insert.dxf
    across, up = float(dxf.column_spacing), float(dxf.row_spacing)
    return (dxf.column_count if across else 1), (dxf.row_count if up else 1), across, up


def _offsets(insert: Any) -> Iterator[tuple[float, float]]:
    """In the INSERT's object coordinates: turned with it, not scaled."""
    columns, rows, across, up = _grid(insert)
    angle = math.radians(insert.dxf.rotation)
    cosine, sine = math.cos(angle), math.sin(angle)
    for row in range(rows):
        for column in range(columns):
            x, y = column * across, row * up
            yield cosine * x - sine * y, sine * x + cosine * y


def _indexed(number: int) -> str:
    """AutoCAD's colour index; 7 is what shows on the background, black on paper."""
    from ezdxf.colors import aci2rgb

    return "#000000" if number == 7 or not 0 < number < 256 else _shown(tuple(aci2rgb(number)))


def _shown(rgb: tuple[int, ...]) -> str:
    """ "#rrggbb"; white, which is meant for a dark screen, is black."""
    return "#000000" if min(rgb) >= 250 else "#" + "".join(f"{channel:02x}" for channel in rgb)
