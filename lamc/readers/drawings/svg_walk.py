"""What of an SVG is drawn: groups, links within the file, styles that are inherited, transforms that add up.

In: a document. Out: `Drawn` shapes in the order of the file, and notes of what was left out. Never: runs a script;
follows a link out of the file.
"""

import re
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from lamc.basics.checks import shown
from lamc.readers.drawings.notes import Notes
from lamc.readers.drawings.svg_css import GEOMETRY_OF, Declarations, Sheet
from lamc.readers.drawings.svg_lengths import NUMBER, Viewport, fitted, is_size, length, view_box
from lamc.readers.drawings.svg_shapes import count_of, is_shape, matrix_of
from lamc.readers.drawings.svg_style import Style, styled
from lamc.readers.drawings.svg_tree import Document, Element
from lamc.readers.inert import Limits
from lamc.records.mechanism import Array

_BARE = re.compile(NUMBER)
_PATH = re.compile(r"path\(\s*(['\"])(.*)\1\s*\)", re.DOTALL)
_GROUPS = frozenset(("g", "a", "svg", "switch", "use"))
_SILENT = frozenset(  # that draw nothing where they stand
    (
        *(
            "defs",
            "metadata",
            "title",
            "desc",
            "style",
            "linearGradient",
            "radialGradient",
            "pattern",
            "marker",
            "symbol",
        ),
        *(
            "filter",
            "clipPath",
            "mask",
            "view",
            "cursor",
            "script",
            "font",
            "color-profile",
            "solidcolor",
            "hatch",
            "mesh",
        ),
    )
)
_TOLD = {
    "text": "is text: turn it into paths if it is to be cut",
    "flowRoot": "is text: turn it into paths if it is to be cut",
    "image": "is a picture: draw its lines",
    "foreignObject": "is of another language and is not read",
    "animate": "is animation and is not played",
    "set": "is animation and is not played",
    "animateTransform": "is animation and is not played",
    "animateMotion": "is animation and is not played",
}


@dataclass(frozen=True)
class Drawn:
    """A shape; `matrix` leads from its own user units to those of the root."""

    element: Element
    style: Style
    matrix: Array
    viewport: Viewport
    source: str


class Walk:
    """One document; `notes` grows.

    root  of it, with what styles give it
    """

    def __init__(self, document: Document, limits: Limits, notes: Notes) -> None:
        self.document, self.limits, self.notes = document, limits, notes
        self.sheet = Sheet(document.styles, limits)
        self._visited = 0
        self._following: list[Element] = []
        self._declared = self.sheet.declarations(document.root)
        self.root = self._sized(document.root)

    def shapes(self) -> Iterator[Drawn]:
        root = self.root
        box = view_box(root)
        sides = box[2:] if box else [length(root, n, Viewport(), "") for n in ("width", "height")]
        yield from self._children(
            root,
            styled(root, Style(), self._declared, self.notes),
            np.eye(3),
            Viewport(*sides),
            0,
        )
        for note in self.sheet.notes:
            self.notes.say(note)

    def _children(
        self, element: Element, style: Style | None, matrix: Array, viewport: Viewport, depth: int
    ) -> Iterator[Drawn]:
        if style is not None:
            for child in element.children:
                yield from self._drawn(child, style, matrix, viewport, depth + 1)

    def _drawn(
        self, element: Element, above: Style, matrix: Array, viewport: Viewport, depth: int
    ) -> Iterator[Drawn]:
        tag = element.tag
        if tag in _SILENT or ":" in tag:
            return
        if tag in _TOLD:
            self.notes.add(_TOLD[tag], element.source)
            return
        if not is_shape(element) and tag not in _GROUPS:
            self.notes.add("is no shape that lamc knows", element.source)
            return
        self._count(element, depth)
        declared = self.sheet.declarations(element)
        style = styled(element, above, declared, self.notes)
        if style is None:
            return
        transform = declared.get("transform", "")
        if transform and declared.get("transform-origin", ""):
            raise element.error(
                f"{element.source} turns about a transform-origin; write it as a transform alone"
            )
        own = matrix @ matrix_of(element, transform)
        if is_shape(element):
            for child in element.children:
                if child.tag in _TOLD:
                    self.notes.add(_TOLD[child.tag], child.source)
            if style.is_visible:
                yield Drawn(self._measured(element, declared), style, own, viewport, element.source)
            else:
                self.notes.add("is hidden (visibility)", element.source)
        elif tag == "use":
            yield from self._used(element, style, own, viewport, depth)
        elif tag == "switch":
            chosen = next((child for child in element.children if _is_understood(child)), None)
            if chosen is not None:
                yield from self._drawn(chosen, style, own, viewport, depth + 1)
        elif tag == "svg":
            measured = self._measured(element, declared)
            overflows = declared.get("overflow", "hidden").strip().lower() in ("visible", "auto")
            if not overflows and {"width", "height"} & measured.attributes.keys():
                self.notes.add("is drawn whole, and not clipped to its width and height", element.source)
            inner, view = self._viewed(measured, viewport, {})
            yield from self._children(element, style, own @ inner, view, depth)
        else:
            yield from self._children(element, style, own, viewport, depth)

    def _measured(self, element: Element, declared: Declarations) -> Element:
        """The element with the geometry that CSS gives it, before its own attributes."""
        given = {}
        for name in GEOMETRY_OF.get(element.tag, ()):
            value = declared.get(name, "auto").strip()
            if _BARE.fullmatch(value) and float(value) != 0.0:
                self.notes.add(
                    f"has {name}: {value[:20]} in a style, which without a unit is none", element.source
                )
            elif (
                element.tag == "svg"
                and value.lower() != "auto"
                and not (is_size(value) or value.endswith("%"))
            ):
                self.notes.add(
                    f"has {name}: {value[:20]} in a style, which is of a page and not read", element.source
                )
            elif value.lower() not in ("auto", "none"):
                path = _PATH.fullmatch(value)
                given[name] = path[2] if path is not None else value
        return replace(element, attributes=element.attributes | given) if given else element

    def _sized(self, root: Element) -> Element:
        """The root with the size that CSS gives it, where its attributes give none: programs that draw read these, and
        pages are told to fill a window by the others."""
        given = self._measured(root, self._declared)
        for name in ("width", "height"):
            own, other = (each.get(name).strip() for each in (root, given))
            if own == other or not is_size(own):
                continue
            if is_size(other):
                self.notes.add(
                    f"has {name}: {other[:20]} in a style and {own[:20]} as its own, which is taken",
                    root.source,
                )
            given.attributes[name] = own
        return given

    def _count(self, element: Element, depth: int) -> None:
        self._visited += count_of(element)
        if self._visited > self.limits.values:
            raise element.error(
                f"the drawing has more numbers than the limit 'values' of {self.limits.values}, what <use> repeats "
                "counted each time; draw with fewer corners, or allow more in Python: load(path, "
                "limits=Limits(values=…))",
            )
        if depth > self.limits.depth:
            raise element.error(
                f"{element.source} lies deeper in groups and links than the limit 'depth', {self.limits.depth}",
            )

    def _used(
        self, element: Element, style: Style, matrix: Array, viewport: Viewport, depth: int
    ) -> Iterator[Drawn]:
        href = element.href.strip()
        if not href.startswith("#"):
            self.notes.add(
                f"links to {shown(href[:40])}, which is not in the file and is not fetched", element.source
            )
            return
        target = self.document.ids.get(href[1:])
        if target is None:
            self.notes.add(f"links to {shown(href[:40])}, which the file does not have", element.source)
            return
        if target in self._following or any(target is above for above in _chain(element)):
            raise element.error(
                f"{element.source} links to {shown(href[:40])}, which it lies in; take it out"
            )
        x, y = (length(element, axis, viewport, axis) for axis in "xy")
        placed = matrix @ np.array([[1.0, 0.0, x], [0.0, 1.0, y], [0.0, 0.0, 1.0]])
        self._following.append(target)
        if target.tag == "symbol":
            self._count(target, depth)
            below = styled(target, style, self.sheet.declarations(target), self.notes)
            inner, view = self._viewed(target, viewport, element.attributes)
            found = self._children(target, below, placed @ inner, view, depth + 1)
        else:
            found = self._drawn(target, style, placed, viewport, depth + 1)
        for each in found:
            yield replace(each, source=f"{each.source} by {element.source}"[:200])
        self._following.pop()

    def _viewed(self, element: Element, viewport: Viewport, given: dict[str, str]) -> tuple[Array, Viewport]:
        """A nested drawing's or symbol's own matrix and viewport; `given`: width and height by a <use>."""
        sized = _resized(element, given)
        x, y = (length(element, axis, viewport, axis) for axis in "xy")
        width = length(sized, "width", viewport, "x", viewport.width)
        height = length(sized, "height", viewport, "y", viewport.height)
        placed = np.array([[1.0, 0.0, x], [0.0, 1.0, y], [0.0, 0.0, 1.0]])
        box = view_box(element)
        if box is None or width <= 0.0 or height <= 0.0:
            return placed, Viewport(width, height)
        inner = fitted(box, width, height, element.get("preserveAspectRatio"))
        return placed @ inner, Viewport(box[2], box[3])


def _resized(element: Element, given: dict[str, str]) -> Element:
    """The element as if its width and height were those given."""
    sizes: dict[str, str] = {name: given[name] for name in ("width", "height") if name in given}
    return replace(element, attributes=element.attributes | sizes) if sizes else element


def _chain(element: Element) -> Iterator[Element]:
    above: Element | None = element
    while above is not None:
        yield above
        above = above.parent


def _is_understood(child: Element) -> bool:
    """Whether a <switch> takes this child."""
    language = child.get("systemLanguage", "en")
    english = any(word.strip().lower().startswith("en") for word in language.split(","))
    return english and not child.get("requiredExtensions").strip() and ":" not in child.tag
