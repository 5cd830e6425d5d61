"""Lengths of SVG, view boxes, and how large a user unit is.

In: attributes. Out: numbers in user units, matrices, and m of one user unit. A px is 1/96 inch by the standard;
Illustrator writes points and calls them px, and Inkscape before 0.92 had 90 px in an inch.
"""

import math
import re
from dataclasses import dataclass

import numpy as np

from lamc.basics.units import LENGTH, to_si
from lamc.readers.drawings.svg_tree import Document, Element
from lamc.records.mechanism import Array

INCH = 0.0254  # m
LARGEST = 1e12  # of a coordinate: squares and products of such numbers stay finite and are told apart
_PX = {
    "": 1.0,
    "px": 1.0,
    "in": 96.0,
    "mm": 96 / 25.4,
    "cm": 96 / 2.54,
    "q": 96 / 101.6,
    "pt": 96 / 72,
    "pc": 16.0,
}
NUMBER = r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?"
_NUMBERS = re.compile(NUMBER)
_APART = re.compile(r"[\s,]*")
_LENGTH = re.compile(rf"\s*({NUMBER})\s*([A-Za-z]*|%)\s*\Z")
_OLD_INKSCAPE = re.compile(r"\s*0\.([0-9]+)")


@dataclass(frozen=True)
class Viewport:
    """What per cents are of, in user units; (0, 0) where nobody says."""

    width: float = 0.0
    height: float = 0.0

    def share(self, axis: str) -> float:
        """Of "x", "y", or "" for lengths along neither."""
        if axis:
            return self.width if axis == "x" else self.height
        return math.hypot(self.width, self.height) / math.sqrt(2.0)


def length(element: Element, name: str, viewport: Viewport, axis: str, default: float = 0.0) -> float:
    """An attribute in user units. Raises DesignError for what is no length."""
    text = element.get(name)
    if not text.strip() or text.strip() == "auto":
        return default
    found = _LENGTH.match(text)
    value, unit = (float(found[1]), found[2].lower()) if found else (math.nan, "")
    if not abs(value) < LARGEST:
        raise element.error(
            f"{element.source} has {name}={text[:40]!r}; it must be a length such as 10 or 10mm"
        )
    if unit == "%":
        return value / 100.0 * viewport.share(axis)
    if unit not in _PX:
        raise element.error(f"{element.source} has {name}={text[:40]!r}; write it in mm, cm, in, pt or px")
    return value * _PX[unit]


def numbers(text: str) -> list[float] | None:
    """The numbers of a list with blanks or commas; None for anything else in it, or one that is not finite."""
    if not _APART.fullmatch(_NUMBERS.sub("", text)):
        return None
    found = [float(each) for each in _NUMBERS.findall(text)]
    return found if all(abs(value) < LARGEST for value in found) else None


def is_size(text: str) -> bool:
    """Whether it says how large something is: not in per cents of what nobody knows."""
    found = _LENGTH.match(text)
    return found is not None and found[2].lower() in _PX


def view_box(element: Element) -> tuple[float, float, float, float] | None:
    """x, y, width, height; None for none, or one without a size."""
    found = numbers(element.get("viewBox"))
    if found is None or len(found) != 4 or min(found[2:]) <= 0.0:
        return None
    return found[0], found[1], found[2], found[3]


def fitted(box: tuple[float, float, float, float], width: float, height: float, aspect: str) -> Array:
    """The (3, 3) matrix from a view box to a viewport of that size at (0, 0), by preserveAspectRatio."""
    scales = width / box[2], height / box[3]
    words = aspect.split() or ["xMidYMid"]
    words = words[1:] if words[0] == "defer" else words
    if words and words[0] == "none":
        (sx, sy), shares = scales, (0.0, 0.0)
    else:
        sx = sy = max(scales) if "slice" in words else min(scales)
        align = words[0] if words else "xMidYMid"
        shares = tuple(
            next((share for word, share in (("Min", 0.0), ("Max", 1.0)) if f"{axis}{word}" in align), 0.5)
            for axis in "xY"
        )  # type: ignore[assignment]
    left = shares[0] * (width - sx * box[2]) - sx * box[0]
    top = shares[1] * (height - sy * box[3]) - sy * box[1]
    return np.array([[sx, 0.0, left], [0.0, sy, top], [0.0, 0.0, 1.0]])


@dataclass(frozen=True)
class Scale:
    """m of one user unit of the root, along x and y; how it was found, for a note; "" where the file says it."""

    x: float
    y: float
    note: str


def scale_of(document: Document, sized: Element, units: str | None) -> Scale:
    """How large a user unit is: as the user says, else as width, height and viewBox of the root do, else a
    px. sized: the root with what styles give it.

    Raises DesignError for a width or height that is no length.
    """
    if units is not None:
        unit = to_si(f"1 {units}", LENGTH)
        return Scale(unit, unit, "")
    box = view_box(sized)
    if box is None and sized.get("viewBox").strip():
        raise sized.error(
            f"{sized.source} has viewBox={sized.get('viewBox')[:40]!r}; it must be four numbers, the last two above 0 "
            "(--units mm takes a number for a millimetre without it)"
        )
    sizes = [_size(sized, name) for name in ("width", "height")]
    px, note = _px(document)
    metres = [
        None if size is None else size[0] * (px if size[1] in ("", "px") else INCH / 96.0 * _PX[size[1]])
        for size in sizes
    ]
    said = all(size is None or size[1] not in ("", "px") for size in sizes) and any(sizes)
    if box is None:
        # Without a box a user unit is a px of 1/96 inch, whatever the width is written in.
        return Scale(px, px, note)
    scales = [None if m is None or m <= 0.0 else m / side for m, side in zip(metres, box[2:], strict=True)]
    given = [scale for scale in scales if scale is not None]
    if not given:
        return Scale(px, px, note)
    x, y = scales[0] or given[0], scales[1] or given[0]
    if sized.get("preserveAspectRatio").split()[:1] != ["none"]:
        x = y = max(x, y) if "slice" in sized.get("preserveAspectRatio") else min(x, y)
    return Scale(x, y, "" if said else note)


def _size(root: Element, name: str) -> tuple[float, str] | None:
    """A number and its unit; None for none, and for per cents of a window that nobody knows."""
    text = root.get(name)
    found = _LENGTH.match(text)
    if not text.strip() or text.strip() == "auto" or (found and found[2] == "%"):
        return None
    if not found or found[2].lower() not in _PX or not 0.0 <= float(found[1]) < LARGEST:
        raise root.error(f"{root.source} has {name}={text[:40]!r}; it must be a length such as 10 or 10mm")
    return float(found[1]), found[2].lower()


def _px(document: Document) -> tuple[float, str]:
    """m of what this file's program calls a px, and a note of it."""
    root = document.root
    is_adobe = any("Adobe Illustrator" in comment for comment in document.comments) or any(
        value.startswith("http://ns.adobe.com/AdobeIllustrator") for value in root.attributes.values()
    )
    is_adobe |= _is_exported_by_illustrator(document)
    if is_adobe:
        return INCH / 72.0, "the file says no unit, and is Illustrator's: 1 is taken for a point, 1/72 inch"
    found = _OLD_INKSCAPE.match(root.get("inkscape:version"))
    if found and int(found[1][:2].ljust(2, "0")) < 92:
        return INCH / 90.0, "the file says no unit, and is of Inkscape before 0.92: 1 is taken for 1/90 inch"
    return INCH / 96.0, "the file says no unit: 1 is taken for a px, 1/96 inch"


def _is_exported_by_illustrator(document: Document) -> bool:
    """By its marks, as newer versions leave no name: layers with data-name, classes .cls-1."""
    named = any("data-name" in layer.attributes for layer in (document.root, *document.root.children))
    return named or any(".cls-1" in style.text for style in document.styles)
