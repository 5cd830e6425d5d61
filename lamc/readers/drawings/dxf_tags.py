"""DXF files, text or binary, as group codes with raw values.

In: bytes. Out: tags, in the order of the file. Never: knows what an entity means.
"""

import re
import struct
from collections.abc import Iterator

from lamc.basics.errors import DesignError, Place
from lamc.readers.inert import Limits

Tag = tuple[int, bytes]

_BINARY = b"AutoCAD Binary DXF\r\n\x1a\x00"
_TEXT = re.compile(
    rb"(?:\xef\xbb\xbf)?(?:\s*999[ \t]*\r?\n[^\n]*\n)*\s*0[ \t]*\r?\n[ \t]*SECTION[ \t]*\r?\n[ \t]*2[ \t]*\r?\n"
)
_GROUPS = (
    3  # of a DXF file cost as much time as a value of other files: some 12 µs each, measured with 240 000
)


def is_dxf(data: bytes) -> bool:
    """True for bytes that are meant as DXF, text or binary."""
    return data.startswith(_BINARY) or _TEXT.match(data[:20_000]) is not None


def tags_of(data: bytes, file: str, limits: Limits) -> list[Tag]:
    """Group codes and values, up to EOF or where the file is cut off.

    Raises DesignError for what is not DXF or beyond the limits.
    """
    most = _GROUPS * limits.values
    if data.startswith(_BINARY):
        return _taken(_binary(data), most, file)
    text = data if b"\n" in data else data.replace(b"\r", b"\n")
    count = text.count(b"\n") // 2
    if count > most:
        raise _too_many(count, most, file)
    return _taken(_ascii(text, file), most, file)


def _too_many(count: int, most: int, file: str) -> DesignError:
    return DesignError(
        f"the file has {count} groups (a code and a value); the limit 'values' of {most // _GROUPS} lets {most} "
        "through: leave out what is not cut or folded, or read it with larger limits (lamc.Limits)",
        Place(file),
    )


def _taken(tags: Iterator[Tag], most: int, file: str) -> list[Tag]:
    found: list[Tag] = []
    for tag in tags:
        found.append(tag)
        if len(found) > most:
            raise _too_many(len(found), most, file)
    return found


def _ascii(data: bytes, file: str) -> Iterator[Tag]:
    lines = data.removeprefix(b"\xef\xbb\xbf").split(b"\n")
    for index in range(0, len(lines) - 1, 2):
        try:
            code = int(lines[index])
        except ValueError:
            wrong = lines[index][:40].decode("ascii", "replace").strip()
            if not wrong and not b"".join(lines[index:]).strip():
                return
            raise DesignError(
                f"there is {wrong!r} where a group code should be, a number; save the file again with the program "
                "that made it",
                Place(file, index + 1),
            ) from None
        value = lines[index + 1].rstrip(b"\r")
        if code != 999:
            yield code, value
        if code == 0 and value.strip() == b"EOF":
            return


def _binary(data: bytes) -> Iterator[Tag]:
    """Group codes are a byte each until R12 (255: two more follow), and two bytes since; values by their codes."""
    start = data.find(b"$ACADVER\x00", 0, 2048)
    # "$ACADVER" ends in 0, then comes group code 1, in one byte or two, and "AC1009".
    short = start < 0 or data[start + 10 : start + 12] == b"AC"
    at = len(_BINARY)
    try:
        while at < len(data):
            if short:
                code, at = data[at], at + 1
                if code == 255:
                    (code,), at = struct.unpack_from("<H", data, at), at + 2
            else:
                (code,), at = struct.unpack_from("<H", data, at), at + 2
            form = _form(code)
            if form == "s":
                end = data.index(b"\x00", at)
                value, at = data[at:end].replace(b"\r", b" ").replace(b"\n", b" "), end + 1
            elif form == "b":
                end = at + 1 + data[at]
                value, at = data[at + 1 : end].hex().upper().encode(), end
            else:
                number = struct.unpack_from(form, data, at)[0]
                value, at = repr(number).encode(), at + struct.calcsize(form)
            if code != 999:
                yield code, value
            if code == 0 and value == b"EOF":
                return
    except (struct.error, IndexError, ValueError):
        return  # cut off: the last entity goes, as with text


def _form(code: int) -> str:
    """The struct format of a group code's value; "s" of a text that ends in 0, "b" of bytes behind their number.

    AutoCAD, DXF Reference, "Group Code Value Types".
    """
    if 10 <= code < 60 or 110 <= code < 150 or 210 <= code < 240 or 460 <= code < 470 or 1010 <= code < 1060:
        return "<d"
    if 290 <= code < 300:
        return "<B"
    if 310 <= code < 320 or code == 1004:
        return "b"
    if 90 <= code < 100 or 420 <= code < 430 or 440 <= code < 460 or code == 1071:
        return "<i"
    if 160 <= code < 170:
        return "<q"
    if 60 <= code < 80 or 170 <= code < 180 or 270 <= code < 290 or 370 <= code < 390 or 400 <= code < 410:
        return "<h"
    return "<h" if 1060 <= code <= 1070 else "s"
