"""Lines as DXF of AutoCAD 2000, which cutters' programs read: LWPOLYLINEs in mm, a layer for each pen.

In: lines, m. Out: bytes, the same for the same lines: no clock and no random number is in them. A crease's angle is
the number at the end of its layer's name, degrees.
"""

import io
import math
from collections.abc import Iterator, Sequence
from contextlib import contextmanager

import numpy as np
from ezdxf import options, units  # type: ignore[attr-defined]  # `options` is public, and not told to be
from ezdxf.filemanagement import new

from lamc.export.cuts.lines import CutLine

_MM = 1e3


def dxf_bytes(lines: Sequence[CutLine]) -> bytes:
    """The drawing: model space, in mm ($INSUNITS 4)."""
    with _pinned():
        document = new("R2000", units=units.MM)
        space = document.modelspace()
        for line in lines:
            name = layer_name(line)
            if name not in document.layers:
                layer = document.layers.add(name, color=line.pen.index)
                if line.pen.about:
                    layer.description = line.pen.about
            places = [(_MM * x, _MM * y) for x, y in line.points.tolist()]
            space.add_lwpolyline(places, close=line.closed, dxfattribs={"layer": name})
        text = io.StringIO()
        document.write(text)
        return bytes(document.encode(text.getvalue()))


def layer_name(line: CutLine) -> str:
    """The pen's name; of a crease that rests at an angle, with it, degrees: valley_+90."""
    if not line.angle:
        return line.pen.name
    sign = "-" if line.pen.name == "mountain" else "+"
    exact, short = math.degrees(line.angle), float(f"{math.degrees(line.angle):.12g}")
    degrees = short if math.radians(short) == line.angle else exact
    return f"{line.pen.name}_{sign}{np.format_float_positional(degrees, trim='-')}"


@contextmanager
def _pinned() -> Iterator[None]:
    """ezdxf stamps date and random identifiers on each document, unless this is set."""
    before = options.write_fixed_meta_data_for_testing
    options.write_fixed_meta_data_for_testing = True
    try:
        yield
    finally:
        options.write_fixed_meta_data_for_testing = before
