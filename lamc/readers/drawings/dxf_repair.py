"""What ezdxf would lose or refuse of a DXF file that other programs read, mended before it sees the file.

In: tags. Out: tags, and notes. Never: makes up a coordinate.

Two entities of one handle are one entity to ezdxf, and the other is lost; an entity that a cut-off file leaves half
written would get coordinates that nobody drew; files that say R12, or no version, have entities of later versions,
whose marks of classes (100) ezdxf takes out of R12 and then misses; and a solid or picture that is not as it should be
makes it refuse the whole file: for kinds that are no lines it gets a point, and who counts them the kind. So do a
polyline without its end, and a header, tables or objects in no order, which are done without.
"""

import re
from collections.abc import Iterator
from dataclasses import dataclass

from lamc.readers.drawings.dxf_curves import DRAWN
from lamc.readers.drawings.dxf_tags import Tag

_PARTS = (b"VERTEX", b"SEQEND", b"ATTRIB")
_MARKS = (b"SECTION", b"ENDSEC", b"EOF", b"BLOCK", b"ENDBLK")
_NUMBERED = 1 << 44  # handles from here on are not of the file: they number its entities
_READ = frozenset(kind.encode() for kind in (*DRAWN, "INSERT", "VERTEX", "SEQEND", "ATTRIB", "VIEWPORT"))
_POINT = ((10, b"0.0"), (20, b"0.0"), (30, b"0.0"))
_LATER = {b"LWPOLYLINE": b"AcDbPolyline", b"SPLINE": b"AcDbSpline", b"HATCH": b"AcDbHatch"}  # since R13
_COMMON = (
    5,
    6,
    8,
    48,
    60,
    62,
    67,
    370,
    420,
)  # codes that belong to any entity: they stand before its own class
_SECTIONS = (b"HEADER", b"TABLES", b"BLOCKS", b"ENTITIES")
_TABLES = (b"LAYER", b"BLOCK_RECORD")
_VARIABLES = {b"$ACADVER": 1, b"$DWGCODEPAGE": 3, b"$INSUNITS": 70, b"$MEASUREMENT": 70}  # and their codes
_R12, _R2000 = b"AC1009", b"AC1015"


@dataclass(frozen=True)
class Mended:
    """What ezdxf is given.

    tags   of whole entities, each with a handle of its own and its class's marks
    kinds  of entities that are no lines, and points now, by handle as `key_of` has it
    notes  what was mended
    """

    tags: list[Tag]
    kinds: dict[bytes, str]
    notes: list[str]


def mended(tags: list[Tag]) -> Mended:
    """The tags of a file as ezdxf can read them, with nothing lost that is drawn."""
    notes: list[str] = []
    kinds: dict[bytes, str] = {}
    _cut_whole(tags, notes)
    entities = list(_entities(tags))
    handles = _new_handles(tags, entities, notes)
    found: list[Tag] = []
    done = 0
    later = False
    for start, end, number in entities:
        kind, own = tags[start][1].strip(), tags[start + 1 : end]
        later = later or kind in _LATER
        marked = kind not in _LATER or _marked(own, _LATER[kind])
        if start not in handles and kind in _READ and marked:
            continue
        if start in handles:
            own = [(5, f"{_NUMBERED + number:X}".encode()), *_without_handle(own)]
        if kind not in _READ:
            kinds[key_of(_handle(own))] = _text(kind)
            kind, own = b"POINT", [*(tag for tag in own if tag[0] in (5, 67)), *_POINT]
        elif not marked:
            own = _with_marks(own, _LATER[kind])
        found += [*tags[done:start], (0, kind), *own]
        done = end
    found += tags[done:]
    return Mended(_with_ends(_as_r2000(found) if later else found), kinds, notes)


def bare(tags: list[Tag]) -> list[Tag]:
    """Of a file whose other parts are in no order: layers, blocks and entities, and what the header says of them.

    A broken variable of the header or a lost layout makes ezdxf refuse the whole file.
    """
    starts = [k for k, tag in enumerate(tags) if tag[0] == 0]
    found: list[Tag] = []
    section, inside = b"", False
    for start, end in zip(starts, [*starts[1:], len(tags)], strict=True):
        kind, own = tags[start][1].strip(), tags[start:end]
        if kind == b"SECTION":
            section = own[1][1].strip() if end > start + 1 else b""
            if section == b"HEADER":
                own = own[:2] + [pair for k in range(2, len(own) - 1) for pair in _variable(own[k : k + 2])]
        elif kind in (b"TABLE", b"ENDTAB") and section == b"TABLES":
            inside = kind == b"TABLE" and end > start + 1 and own[1][1].strip() in _TABLES
            if not inside and kind == b"TABLE":
                continue
        elif section == b"TABLES" and kind != b"ENDSEC" and not inside:
            continue
        if section in _SECTIONS or kind == b"EOF":
            found += own
    return found


def _variable(pair: list[Tag]) -> list[Tag]:
    return pair if pair[0][0] == 9 and _VARIABLES.get(pair[0][1].strip()) == pair[1][0] else []


def key_of(handle: bytes | None) -> bytes:
    """One form of a handle, which may have zeros before it or small letters."""
    return (handle or b"").strip().lstrip(b"0").upper()


def named(kind: str, handle: str | None) -> str:
    """What messages call an entity: "LINE 2F"; "LINE number 7" where the file gives it no handle of its own."""
    try:
        number = int(handle or "", 16) - _NUMBERED
    except ValueError:
        return kind
    return f"{kind} number {number}" if number > 0 else f"{kind} {handle}"


def renamed(message: str) -> str:
    """ezdxf's words with entities as `named` has them."""
    return re.sub(r"\b(\w+)\(#([0-9A-Fa-f]+)\)", lambda found: named(found[1], found[2]), message)


def _cut_whole(tags: list[Tag], notes: list[str]) -> None:
    """Takes off the entity that a cut-off file leaves half written, and ends the file."""
    if tags and tags[-1][0] == 0 and tags[-1][1].strip() == b"EOF":
        return
    last = next((k for k in range(len(tags) - 1, -1, -1) if tags[k][0] == 0), 0)
    kind = _text(tags[last][1]) if tags else ""
    if kind == "ENDSEC":
        notes.append("the file ends without EOF: it may be cut off, and what followed is lost")
    else:
        what = f"{kind} {_text(_handle(tags[last:]) or b'')}".strip() or "its start"
        del tags[last:]
        notes.append(f"the file is cut off: it ends without EOF, and {what} and all that followed are lost")
        if tags:
            tags.append((0, b"ENDSEC"))
    tags.append((0, b"EOF"))


def _entities(tags: list[Tag]) -> Iterator[tuple[int, int, int]]:
    """Start and end of each entity of the model space and the blocks, and its number; parts of one count on below 0."""
    starts = [k for k, tag in enumerate(tags) if tag[0] == 0]
    section, number, parts = b"", 0, 0
    for start, end in zip(starts, [*starts[1:], len(tags)], strict=True):
        kind = tags[start][1].strip()
        if kind == b"SECTION" and end > start + 1:
            section = tags[start + 1][1].strip()
        elif section in (b"ENTITIES", b"BLOCKS") and kind not in _MARKS:
            part = kind in _PARTS
            number, parts = number + (not part), parts + part
            yield start, end, -parts if part else number


def _new_handles(tags: list[Tag], entities: list[tuple[int, int, int]], notes: list[str]) -> set[int]:
    """Starts of the entities that have no handle, or one that something else has."""
    of_entities = {start for start, _, _ in entities}
    starts = [k for k, tag in enumerate(tags) if tag[0] == 0]
    taken: set[bytes] = set()
    for start, end in zip(starts, [*starts[1:], len(tags)], strict=True):
        if start not in of_entities:
            taken.add(key_of(_handle(tags[start + 1 : end])))
    needed, doubled = set(), []
    for start, end, _ in entities:
        key = key_of(_handle(tags[start + 1 : end]))
        if not key or key in taken:
            needed.add(start)
            if key:
                doubled.append(f"{_text(tags[start][1])} {_text(key)}")
        taken.add(key)
    if doubled:
        notes.append(
            f"{len(doubled)} entities have a handle that something else has too (first {doubled[0]}): all are read, "
            "and messages number these"
        )
    return needed


def _handle(tags: list[Tag]) -> bytes | None:
    return next((value for code, value in tags if code == 5), None)


def _without_handle(tags: list[Tag]) -> list[Tag]:
    at = next((k for k, tag in enumerate(tags) if tag[0] == 5), len(tags))
    return tags[:at] + tags[at + 1 :]


def _marked(tags: list[Tag], name: bytes) -> bool:
    return {b"AcDbEntity", name} <= {value.strip() for code, value in tags if code == 100}


def _with_marks(tags: list[Tag], name: bytes) -> list[Tag]:
    handle = [tag for tag in tags if tag[0] == 5]
    common = [tag for tag in tags if tag[0] in _COMMON]
    rest = [tag for tag in tags if tag[0] not in (5, 100, *_COMMON)]
    return [*handle, (100, b"AcDbEntity"), *common, (100, name), *rest]


def _as_r2000(tags: list[Tag]) -> list[Tag]:
    """The same where it says a later version; R12, or none, becomes R2000."""
    at = next((k for k, tag in enumerate(tags[:-1]) if tag[0] == 9 and tag[1].strip() == b"$ACADVER"), None)
    if at is None:
        header = [(0, b"SECTION"), (2, b"HEADER"), (9, b"$ACADVER"), (1, _R2000), (0, b"ENDSEC")]
        return [*header, *tags]
    if tags[at + 1][1].strip() <= _R12:
        tags[at + 1] = (1, _R2000)
    return tags


def _with_ends(tags: list[Tag]) -> list[Tag]:
    """Ends what has parts, corners or attributes, where the file forgets to (SEQEND)."""
    found: list[Tag] = []
    done, opened, found_kind = 0, False, b""
    for k, (code, value) in enumerate(tags):
        if code == 66 and value.strip() == b"1" and found_kind == b"INSERT":
            opened = True
        if code != 0:
            continue
        found_kind = value.strip()
        if opened and found_kind not in _PARTS:
            found += [*tags[done:k], (0, b"SEQEND"), (5, f"{2 * _NUMBERED + k:X}".encode()), (8, b"0")]
            done = k
        opened = found_kind == b"POLYLINE" or (opened and found_kind in (b"VERTEX", b"ATTRIB"))
    return found + tags[done:]


def _text(value: bytes) -> str:
    return value.decode("ascii", "replace").strip()[:40]
