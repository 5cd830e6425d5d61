"""Which files are drawings, and their reading; what cannot be read is told apart by its first bytes.

In: bytes. Out: a `Drawing`, or None for a file of another kind. The content decides, not the name; the name
says only what a file was meant as that is none of them.
"""

import codecs
from pathlib import PurePath

from lamc.basics.errors import DesignError, Place, UnsupportedError
from lamc.readers.drawings.dxf_tags import is_dxf
from lamc.readers.drawings.kinds import looks_like_xml
from lamc.readers.inert import Limits, Progress
from lamc.readers.json_text import parsed
from lamc.records.card import SheetOptions
from lamc.records.drawing import Drawing

_FOREIGN = (
    (
        b"\x1f\x8b",
        "is packed by gzip, as .svgz is",
        "unpack it, gunzip -c A.svgz > A.svg, or save it plain",
    ),
    (b"%PDF", "is PDF, or of Illustrator (.ai)", "save it as SVG or DXF in the program that made it"),
    (b"%!PS", "is PostScript", "save it as SVG or DXF in the program that made it"),
    (b"\xc5\xd0\xd3\xc6", "is PostScript", "save it as SVG or DXF in the program that made it"),
    (b"AC10", "is DWG", "save it as DXF in the program that made it"),
    (b"PK\x03\x04", "is an archive (zip)", "unpack it and name the drawing in it"),
    (b"\x89PNG", "is a picture", "draw its lines over it, as SVG or DXF"),
    (b"\xff\xd8\xff", "is a picture", "draw its lines over it, as SVG or DXF"),
    (b"GIF8", "is a picture", "draw its lines over it, as SVG or DXF"),
)


def is_drawing(data: bytes) -> bool:
    """True for a file that is meant as SVG or DXF. Quick; reads its first bytes."""
    return looks_like_xml(data) or is_dxf(data)


def drawing_in(
    data: bytes, file: str, options: SheetOptions, limits: Limits, progress: Progress | None = None
) -> Drawing | None:
    """The drawing in a file; None for a file of another kind.

    Raises DesignError with element or entity and place for what cannot be read, UnsupportedError for pictures, PDF,
    DWG and packed files.
    """
    for mark, what, way_out in _FOREIGN:
        if data.startswith(mark):
            raise UnsupportedError(f"the file {what}, which lamc does not read: {way_out}", Place(file))
    if looks_like_xml(data):
        from lamc.readers.drawings.svg import read_svg  # svgelements, which files of other kinds do without

        return read_svg(data, file, options, limits, progress)
    if is_dxf(data):
        from lamc.readers.drawings.dxf import read_dxf

        return read_dxf(data, file, options, limits)
    if file.lower().endswith(".dxf"):
        _check_text(data, file)
    return None


def _check_text(data: bytes, file: str) -> None:
    """Raises DesignError for a DXF file in a text that no reader of DXF takes."""
    if data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        raise DesignError("the file is in UTF-16; DXF is in UTF-8 or a code page: save it so", Place(file))
    if b"\r" in data and b"\n" not in data:
        raise DesignError("its lines end by CR alone; they must end by LF or CR LF: save it so", Place(file))


def check_meant(text: str, file: str, options: SheetOptions, limits: Limits) -> None:
    """Raises DesignError, of the format that the name says, for a text that is no sheet and is named as one."""
    place = Place(file)
    suffix = PurePath(file).suffix.lower()
    if suffix == ".svg":
        from lamc.readers.drawings.svg import read_svg  # as above

        read_svg(text.encode(), file, options, limits)
        raise DesignError("this is no SVG file: its first character must be '<'", place)
    if suffix == ".dxf":
        raise DesignError("this is no DXF file: it must begin with the lines 0, SECTION, 2", place)
    if suffix not in (".fold", ".json"):
        return
    data = parsed(text, file, limits)
    if not isinstance(data, dict):
        found = "a list" if isinstance(data, list) else "a single value"
        raise DesignError(f"this is no FOLD file: it holds {found}; FOLD is a map of lists", place)
    if suffix == ".fold" or not {"kind", "layers", "joints", "shapes", "materials"} & data.keys():
        raise DesignError(
            "this is no FOLD file: it has none of vertices_coords, edges_vertices and faces_vertices", place
        )
