"""The sheet that a layer is cut from: its frame, and holes for pins by which layers come to lie over one another.

In: the box around the parts of all layers, m; what the user says of sheets and pins. Out: where the drawing's origin
goes, the same for every layer, and the lines that are the same on all of them.
"""

import math
from dataclasses import dataclass

import numpy as np
from shapely.geometry import box

from lamc.basics.errors import ExportError
from lamc.design import shapes
from lamc.export.cuts.lines import FRAME, HOLES, CutLine, closed
from lamc.records.mechanism import Array

_EDGE = 1.5  # pin diameters from a pin's middle to the edges of the sheet
_STRIP = 3.0  # pin diameters along every edge, which parts keep off


@dataclass(frozen=True, eq=False)
class Stock:
    """shift: m, of every part; page: lowest and highest corner of all drawings, m; lines: frame and pins; note: how
    pins are placed."""

    shift: Array
    page: tuple[Array, Array]
    lines: tuple[CutLine, ...] = ()
    note: str = ""


def stock_of(
    low: Array, high: Array, size: tuple[float, float] | None, pins: float | None, kerf: float
) -> Stock:
    """low, high: corners of the box around all parts. Raises ExportError for sheets that are too small, and pins that
    are narrower than the kerf."""
    if size is None and pins is None:
        return Stock(np.zeros(2), (low, high))
    if pins is not None and pins <= kerf:
        raise ExportError(f"--pins (pins) is {1e3 * pins:g} mm, no wider than the kerf of {1e3 * kerf:g} mm")
    strip = _STRIP * (pins or 0.0) + kerf
    extent = high - low
    width, height = size if size is not None else tuple(float(v) for v in extent + 2.0 * strip)
    needed = extent + 2.0 * strip
    if needed[0] > width or needed[1] > height:
        turned = " (it would fit turned by 90 degrees)" if needed[1] <= width and needed[0] <= height else ""
        raise ExportError(
            f"--sheet (stock) is {1e3 * width:g} mm x {1e3 * height:g} mm; parts, pins and kerf need "
            f"{_up(needed[0])} mm x {_up(needed[1])} mm{turned}"
        )
    shift = 0.5 * (np.array([width, height]) - extent) - low
    page = (np.zeros(2), np.array([width, height]))
    frame = closed(box(0.0, 0.0, width, height).exterior.coords, FRAME)
    if pins is None:
        return Stock(shift, page, (frame,))
    edge = _EDGE * pins
    # One pin stands farther in than the others: a sheet goes on the pins one way only.
    middles = [
        (edge, edge),
        (width - edge, edge),
        (width - edge, height - edge),
        (2.0 * edge, height - edge),
    ]
    radius = 0.5 * (pins - kerf)
    holes = [closed(shapes.circle(x, y, radius).exterior.coords, HOLES) for x, y in middles]
    return Stock(
        shift,
        page,
        (*holes, frame),
        f"4 holes for pins of {1e3 * pins:g} mm; the upper left one stands farther in, so that no sheet is turned over",
    )


def _up(length: float) -> str:
    """mm, rounded up to a micrometre: a sheet of this size is large enough."""
    return f"{math.ceil(1e6 * length - 1e-6) / 1e3:.10g}"
