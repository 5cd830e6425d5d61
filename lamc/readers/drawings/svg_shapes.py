"""Shapes of SVG as outlines in their own user units: path, line, polyline, polygon, rect, circle, ellipse.

In: elements. Out: `Outline`s. Raises DesignError for what cannot be read to its end; a viewer would draw a part of it.
"""

import re
from collections.abc import Callable, Iterator

import numpy as np
import svgelements

from lamc.basics.checks import shown
from lamc.basics.errors import DesignError
from lamc.readers.drawings.curves import Arc, Bezier, Curve, Outline, Polyline
from lamc.readers.drawings.svg_lengths import LARGEST, NUMBER, Viewport, length, numbers
from lamc.readers.drawings.svg_tree import Element
from lamc.records.mechanism import Array

_ARGUMENTS = {"m": 2, "l": 2, "h": 1, "v": 1, "c": 6, "s": 4, "q": 4, "t": 2, "a": 7, "z": 0}
_COMMAND = re.compile(r"[\s,]*([A-Za-z])")
_NEXT = re.compile(rf"[\s,]*({NUMBER})")
_FLAG = re.compile(r"[\s,]*([01])")
_BLANK = re.compile(r"[\s,]*")


def outlines(element: Element, viewport: Viewport) -> list[Outline]:
    """What an element draws, in its own user units; empty where it draws nothing."""
    return _SHAPES[element.tag](element, viewport)


def is_shape(element: Element) -> bool:
    return element.tag in _SHAPES


def matrix_of(element: Element, text: str) -> Array:
    """The (3, 3) matrix of an element's transform, as an attribute or CSS writes it."""
    text = _UNITS.sub(r"\1", text.strip())
    if not text or text == "none":
        return np.eye(3)
    calls = _CALL.findall(text)
    if not _BLANK.fullmatch(_CALL.sub("", text)):
        raise _unread(element, "transform", text)
    for name, inside in calls:
        found = None if _STRAY.search(inside) else numbers(inside)
        if found is None or len(found) not in _TAKES.get(name, ()):
            raise _unread(element, "transform", f"{name}({inside})")
    m = svgelements.Matrix(text)
    matrix = np.array([[m.a, m.c, m.e], [m.b, m.d, m.f], [0.0, 0.0, 1.0]], dtype=float)
    if not np.all(np.abs(matrix) < LARGEST):
        raise _unread(element, "transform", text)
    return matrix


_UNITS = re.compile(r"([0-9.])(?:px|deg)\b")
_STRAY = re.compile(r"\A\s*,|,\s*,|,\s*\Z")  # a comma: browsers drop a transform that has one
_CALL = re.compile(r"([A-Za-z]+)\s*\(([^()]*)\)")
_TAKES = {
    "translate": (1, 2),
    "scale": (1, 2),
    "rotate": (1, 3),
    "skewX": (1,),
    "skewY": (1,),
    "matrix": (6,),
}


def _unread(element: Element, name: str, value: str) -> DesignError:
    return element.error(
        f"{element.source} has {name}={shown(value)}, which cannot be read; save the file as plain SVG, or draw it anew"
    )


def _line(element: Element, viewport: Viewport) -> list[Outline]:
    ends = [[length(element, f"{axis}{k}", viewport, axis) for axis in "xy"] for k in "12"]
    return [Outline((Polyline(np.array(ends)),), closed=False)]


def _polyline(element: Element, viewport: Viewport) -> list[Outline]:
    found = numbers(element.get("points"))
    if found is None or len(found) % 2:
        raise _unread(element, "points", element.get("points"))
    if len(found) < 4:
        return []
    return [Outline((Polyline(np.array(found).reshape(-1, 2)),), closed=element.tag == "polygon")]


def _rect(element: Element, viewport: Viewport) -> list[Outline]:
    x, y, width, height = (
        length(element, name, viewport, axis)
        for name, axis in (("x", "x"), ("y", "y"), ("width", "x"), ("height", "y"))
    )
    if width <= 0.0 or height <= 0.0:
        return []
    rx, ry = length(element, "rx", viewport, "x", -1.0), length(element, "ry", viewport, "y", -1.0)
    rx, ry = (ry if rx < 0.0 else rx), (rx if ry < 0.0 else ry)
    if rx > 0.0 and ry > 0.0:
        rounded = svgelements.Rect(x, y, width, height, min(rx, 0.5 * width), min(ry, 0.5 * height))
        return _of_segments(svgelements.Path(rounded))
    corners = [(x, y), (x + width, y), (x + width, y + height), (x, y + height)]
    return [Outline((Polyline(np.array(corners)),), closed=True)]


def _circle(element: Element, viewport: Viewport) -> list[Outline]:
    r = length(element, "r", viewport, "")
    return _around(element, viewport, r, r)


def _ellipse(element: Element, viewport: Viewport) -> list[Outline]:
    rx, ry = length(element, "rx", viewport, "x", -1.0), length(element, "ry", viewport, "y", -1.0)
    return _around(element, viewport, ry if rx < 0.0 else rx, rx if ry < 0.0 else ry)


def _around(element: Element, viewport: Viewport, rx: float, ry: float) -> list[Outline]:
    if rx <= 0.0 or ry <= 0.0:
        return []
    centre = [length(element, f"c{axis}", viewport, axis) for axis in "xy"]
    return _of_segments(svgelements.Path(svgelements.Ellipse(*centre, rx, ry)))


def _path(element: Element, viewport: Viewport) -> list[Outline]:
    text = element.get("d").strip()
    if not text or text == "none":
        return []
    commands = _commands(element, text)
    if any(command in "aA" and not (values[0] and values[1]) for command, values in commands):
        text = " ".join(_straight(*command) for command in commands)  # an arc without a radius is a line
    try:
        return _of_segments(svgelements.Path(text))
    except (ValueError, TypeError, ArithmeticError, IndexError) as error:
        raise _unread(element, "d", text) from error


def count_of(element: Element) -> int:
    """About how many numbers an element's geometry has; quickly."""
    text = element.get("d") or element.get("points")
    if not text:
        return 4
    return 4 + max(sum(map(text.count, " ,-mMlLhHvVcCsSqQtTaAzZ")), text.count("."))


def _commands(element: Element, text: str) -> list[tuple[str, list[float]]]:
    """Commands with their numbers, repeated ones apart. Raises DesignError where the grammar of paths ends."""
    found: list[tuple[str, list[float]]] = []
    at = 0
    while at < len(text):
        command = _COMMAND.match(text, at)
        if command is None or command[1].lower() not in _ARGUMENTS or (not found and command[1] not in "mM"):
            raise _path_error(element, text, at)
        at, letter = command.end(), command[1]
        takes, first = _ARGUMENTS[letter.lower()], True
        while first or (takes and _NEXT.match(text, at)):
            values: list[float] = []
            for k in range(takes):
                is_flag = letter in "aA" and k in (3, 4)
                number = (_FLAG if is_flag else _NEXT).match(text, at)
                if number is None or not abs(float(number[1])) < LARGEST:
                    raise _path_error(element, text, at)
                values.append(float(number[1]))
                at = number.end()
            found.append((letter, values))
            first, letter = False, {"m": "l", "M": "L"}.get(letter, letter)
        blank = _BLANK.match(text, at)
        at = blank.end() if blank else at
    return found


def _path_error(element: Element, text: str, at: int) -> DesignError:
    return element.error(
        f"{element.source}: its d cannot be read at character {at + 1}, {shown(text[at : at + 24])}; a path is "
        "commands such as M 0 0 L 10 0 with finite numbers: draw it anew, or take it out"
    )


def _straight(command: str, values: list[float]) -> str:
    if command in "aA" and not (values[0] and values[1]):
        return f"{'l' if command == 'a' else 'L'} {values[5]!r} {values[6]!r}"
    if command in "aA":
        return " ".join(
            [command, *map(repr, values[:3]), *(str(int(v)) for v in values[3:5]), *map(repr, values[5:])]
        )
    return " ".join([command, *map(repr, values)])


def _of_segments(path: svgelements.Path) -> list[Outline]:
    """Sub-paths of a path."""
    return [outline for part in _parts(path) if (outline := _outline(part)) is not None]


def _parts(path: svgelements.Path) -> Iterator[list[svgelements.PathSegment]]:
    part: list[svgelements.PathSegment] = []
    for segment in path:
        if isinstance(segment, svgelements.Move) and part:
            yield part
            part = []
        part.append(segment)
        if isinstance(segment, svgelements.Close):
            yield part
            part = []
    if part:
        yield part


def _outline(part: list[svgelements.PathSegment]) -> Outline | None:
    curves: list[Curve] = []
    run: list[tuple[float, float]] = []
    closed = False
    for segment in part:
        if isinstance(segment, svgelements.Close):
            closed = True
            if not curves and not run:
                return None
        elif isinstance(segment, svgelements.Line | svgelements.Move):
            if isinstance(segment, svgelements.Line) and not run:
                run.append(_point(segment.start))
            run.append(_point(segment.end))
        else:
            if len(run) > 1:
                curves.append(Polyline(np.array(run)))
            curves.append(_curve(segment))
            run = [_point(segment.end)]
    if len(run) > 1:
        curves.append(Polyline(np.array(run)))
    return Outline(tuple(curves), closed) if curves else None


def _curve(segment: svgelements.PathSegment) -> Curve:
    if isinstance(segment, svgelements.QuadraticBezier):
        return Bezier(np.array([_point(p) for p in (segment.start, segment.control, segment.end)]))
    if isinstance(segment, svgelements.CubicBezier):
        return Bezier(
            np.array([_point(p) for p in (segment.start, segment.control1, segment.control2, segment.end)])
        )
    ends = np.array([_point(segment.start), _point(segment.end)])
    if np.all(ends[0] == ends[1]) and not segment.sweep:
        return Polyline(ends)
    centre, u, v = (np.array(_point(p)) for p in (segment.center, segment.prx, segment.pry))
    return Arc(centre, u - centre, v - centre, float(segment.get_start_t()), float(segment.sweep), ends)


def _point(point: svgelements.Point) -> tuple[float, float]:
    return float(point.x), float(point.y)


_SHAPES: dict[str, Callable[[Element, Viewport], list[Outline]]] = {
    "path": _path,
    "line": _line,
    "polyline": _polyline,
    "polygon": _polyline,
    "rect": _rect,
    "circle": _circle,
    "ellipse": _ellipse,
}
