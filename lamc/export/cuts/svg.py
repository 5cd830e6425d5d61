"""Lines as SVG 1.1 in real size, a group for each layer.

In: lines, m. Out: text. The page is the box about the lines, or a given one, so that drawings of layers lie over one
another; y runs down it, and 1 is 1 mm. A crease's angle is 180 degrees times its opacity, as readers of origami
drawings take it.
"""

import math
from collections.abc import Sequence
from xml.sax.saxutils import escape, quoteattr

from lamc.export.cuts.lines import CutLine, bounds_of, pens_of
from lamc.records.mechanism import Array

_MM = 1e3
_STROKE = 0.02  # mm: cutters take wider lines for engravings


def svg_text(
    lines: Sequence[CutLine], title: str, about: str = "", page: tuple[Array, Array] | None = None
) -> str:
    """The drawing. about: a description that programs show; page: its lowest and highest corner, m."""
    low, high = page or bounds_of(lines)
    width, height = (_number(_MM * size) for size in (high - low))
    text = [
        '<?xml version="1.0" encoding="UTF-8"?>',
        '<svg xmlns="http://www.w3.org/2000/svg" xmlns:inkscape="http://www.inkscape.org/namespaces/inkscape" '
        f'version="1.1" width="{width}mm" height="{height}mm" viewBox="0 0 {width} {height}">',
        f"<title>{_words(title)}</title>",
        *([f"<desc>{_words(about)}</desc>"] if about else []),
    ]
    corner = (float(low[0]), float(high[1]))
    for pen in pens_of(lines):
        name = quoteattr(pen.name)
        text.append(
            f'<g id={name} inkscape:groupmode="layer" inkscape:label={name} fill="none" stroke="{pen.colour}" '
            f'stroke-width="{_STROKE}">'
        )
        text += [f"<desc>{_words(pen.about)}</desc>"] if pen.about else []
        text += [_path(line, corner) for line in lines if line.pen == pen]
        text.append("</g>")
    return "\n".join([*text, "</svg>"]) + "\n"


def _path(line: CutLine, corner: tuple[float, float]) -> str:
    places = " L ".join(_place(point, corner) for point in line.points)
    opacity = "" if line.angle is None else f' stroke-opacity="{_number(line.angle / math.pi)}"'
    return f'<path d="M {places}{" Z" if line.closed else ""}"{opacity}/>'


def _place(point: Array, corner: tuple[float, float]) -> str:
    return f"{_number(_MM * (float(point[0]) - corner[0]))} {_number(_MM * (corner[1] - float(point[1])))}"


def _number(value: float) -> str:
    """Digits that read back to the last bit; 10 for 10.0."""
    value = float(value) + 0.0  # no -0
    return str(int(value)) if value == int(value) and abs(value) < 1e15 else repr(value)


def _words(text: str) -> str:
    return escape("".join(c for c in text if c.isprintable()))
