"""DXF files of the patterns of `fold_corpus` and of a laminate, of every version and form; by ezdxf, or by hand."""

import io
import math
from collections.abc import Callable
from typing import Any

import ezdxf

from tests.support.fold_corpus import Data

VERSIONS = ("R12", "R2000", "R2004", "R2007", "R2010", "R2013", "R2018")
FORMS = tuple((version, fmt) for version in VERSIONS for fmt in ("asc", "bin"))
LAYERS = {"B": "border", "M": "mountain", "V": "valley", "U": "undriven", "F": "flat", "C": "cut"}
UNITS = {"mm": 4, "cm": 5, "m": 6, "in": 1, None: 0}
Drawing = Any  # of ezdxf


def drawing(version: str = "R2010", unit: str | None = "mm") -> tuple[Drawing, Any]:
    """A new file and its model space."""
    made = ezdxf.new(version, units=UNITS[unit])
    return made, made.modelspace()


def data_of(made: Drawing, fmt: str = "asc") -> bytes:
    """The file; "asc" or "bin"."""
    if fmt == "bin":
        stream = io.BytesIO()
        made.write(stream, fmt="bin")
        return stream.getvalue()
    text = io.StringIO()
    made.write(text)
    return bytes(made.encode(text.getvalue()))


def layer_of(data: Data, edge: int) -> str:
    """ "mountain", or "valley_90" of an edge with a fold angle."""
    kind = data["edges_assignment"][edge]
    angle = (data.get("edges_foldAngle") or [None] * (edge + 1))[edge]
    return LAYERS[kind] if angle is None else f"{LAYERS[kind]}_{abs(angle):g}"


def pattern(data: Data, version: str = "R2010", fmt: str = "asc") -> bytes:
    """A line for each edge, on layers by what they are for."""
    made, space = drawing(version, data.get("frame_unit"))
    for edge, (a, b) in enumerate(data["edges_vertices"]):
        ends = (data["vertices_coords"][v] for v in (a, b))
        space.add_line(*ends, dxfattribs={"layer": layer_of(data, edge)})
    return data_of(made, fmt)


def four_bar(version: str = "R2010", fmt: str = "asc") -> bytes:
    """Four links in a row, 30 mm by 20 mm, and a tab, as a layer of outlines, one of holes and one of joints; each with
    the entities that its version has."""
    made, space = drawing(version)
    rim = [(0, 0), (120, 0), (120, 5), (130, 5), (130, 15), (120, 15), (120, 20), (0, 20)]
    add = space.add_polyline2d if version == "R12" else space.add_lwpolyline
    add(rim, close=True, dxfattribs={"layer": "body"})
    space.add_circle((15, 10), 3, dxfattribs={"layer": "holes"})
    for x in (30, 60, 90, 120):
        low, high = (0, 20) if x < 120 else (5, 15)
        space.add_line((x, low), (x, high), dxfattribs={"layer": "joints"})
    return data_of(made, fmt)


# Entities as other programs write them: with the marks of their classes (group 100), or without.
ENTITIES: dict[str, tuple[str, str]] = {
    "LINE": ("AcDbLine", "10\n1\n20\n2\n30\n0\n11\n3\n21\n4\n31\n0\n"),
    "CIRCLE": ("AcDbCircle", "10\n1\n20\n2\n30\n0\n40\n5\n"),
    "ARC": ("AcDbCircle", "10\n1\n20\n2\n30\n0\n40\n5\n100\nAcDbArc\n50\n0\n51\n90\n"),
    "SOLID": ("AcDbTrace", "10\n1\n20\n2\n30\n0\n11\n3\n21\n0\n31\n0\n12\n3\n22\n4\n32\n0\n"),
    "ELLIPSE": ("AcDbEllipse", "10\n1\n20\n2\n30\n0\n11\n3\n21\n0\n31\n0\n40\n0.5\n41\n0\n42\n6.283\n"),
    "LWPOLYLINE": ("AcDbPolyline", "90\n2\n70\n1\n10\n1\n20\n2\n42\n0.5\n10\n2\n20\n5\n"),
    "SPLINE": (
        "AcDbSpline",
        "70\n8\n71\n1\n72\n4\n73\n2\n74\n0\n40\n0\n40\n0\n40\n1\n40\n1\n10\n0\n20\n0\n30\n0\n10\n1\n20\n1\n30\n0\n",
    ),
    "HATCH": (
        "AcDbHatch",
        "10\n0\n20\n0\n30\n0\n210\n0\n220\n0\n230\n1\n2\nSOLID\n70\n1\n71\n0\n91\n1\n92\n2\n72\n0\n73\n1\n93\n3\n"
        "10\n0\n20\n0\n10\n1\n20\n0\n10\n1\n20\n1\n97\n0\n75\n0\n76\n1\n98\n0\n",
    ),
    "INSERT": ("AcDbBlockReference", "2\nA\n10\n0\n20\n0\n30\n0\n"),
}


def entity(kind: str, handle: str = "2F", layer: str = "body", *, marks: bool = True) -> str:
    """One of `ENTITIES`; handle "": it has none."""
    name, body = ENTITIES[kind]
    if not marks:
        body = body.replace("100\nAcDbArc\n", "")
    own = f"5\n{handle}\n" if handle else ""
    first, second = ("100\nAcDbEntity\n", f"100\n{name}\n") if marks else ("", "")
    return f"0\n{kind}\n{own}{first}8\n{layer}\n{second}{body}"


def line(x1: float, y1: float, x2: float, y2: float, handle: str = "2F", layer: str = "body") -> str:
    return f"0\nLINE\n5\n{handle}\n8\n{layer}\n10\n{x1!r}\n20\n{y1!r}\n30\n0.0\n11\n{x2!r}\n21\n{y2!r}\n31\n0.0\n"


def insert(block: str, more: str = "") -> str:
    return f"0\nINSERT\n8\n0\n2\n{block}\n10\n0\n20\n0\n{more}"


def block(name: str, body: str, flags: int = 0) -> str:
    return f"0\nBLOCK\n8\n0\n2\n{name}\n70\n{flags}\n10\n0\n20\n0\n3\n{name}\n1\n\n{body}0\nENDBLK\n8\n0\n"


def text(entities: str, *, blocks: str = "", header: str = "", version: str = "AC1015") -> bytes:
    """A file by hand. version "": it has no header."""
    head = (
        f"0\nSECTION\n2\nHEADER\n9\n$ACADVER\n1\n{version}\n{header}0\nENDSEC\n" if version or header else ""
    )
    body = f"0\nSECTION\n2\nBLOCKS\n{blocks}0\nENDSEC\n" if blocks else ""
    return f"{head}{body}0\nSECTION\n2\nENTITIES\n{entities}0\nENDSEC\n0\nEOF\n".encode("cp1252")


def claims(unit: int) -> str:
    """Of a header, $INSUNITS."""
    return f"9\n$INSUNITS\n70\n{unit}\n"


def bomb(depth: int) -> str:
    """Blocks that insert two others each: 2^depth lines, and as many ways for who looks for rings."""
    pair = "".join(
        block(f"{side}{k}", insert(f"A{k + 1}") + insert(f"B{k + 1}")) for k in range(depth) for side in "AB"
    )
    return pair + "".join(block(f"{side}{depth}", line(0, 0, 10, 0, "")) for side in "AB")


def moved(
    at: complex, turn: float, across: float, up: float, base: complex = 0j
) -> Callable[[complex], complex]:
    """What an INSERT does to a point, x + iy; degrees."""
    turned = complex(math.cos(math.radians(turn)), math.sin(math.radians(turn)))

    def place(z: complex) -> complex:
        z -= base
        return at + turned * complex(across * z.real, up * z.imag)

    return place
