"""Laminates moved: other layers, other places, as popupCAD's shift, transform and placement operations have them.

In: laminates, layer by layer from the bottom, and lines (m). Out: laminates. Never: grows beyond a bound on corners,
however often a file places a laminate that it has placed before.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import shapely
from shapely.affinity import affine_transform
from shapely.geometry.base import BaseGeometry

from lamc.basics.errors import DesignError
from lamc.design.shapes import FARTHEST
from lamc.design.work import MOST_CORNERS, Account
from lamc.readers import popupcad_sheets as sheets
from lamc.readers.popupcad_sheets import Sheet

Laminate = tuple[Sheet, ...]
Line = tuple[tuple[float, float], tuple[float, float]]


@dataclass(frozen=True)
class Placing:
    """How a laminate is placed. A scale of None is that of the lines: their lengths' ratio."""

    shift: int
    flip: bool
    scale_x: float | None
    scale_y: float | None


def each_sheet(make: Callable[..., Sheet], *laminates: Laminate) -> Laminate:
    """`make` of the sheets of each layer; layers are mostly alike, and are made once."""
    made: dict[tuple[int, ...], Sheet] = {}
    for group in zip(*laminates, strict=True):
        key = tuple(map(id, group))
        if key not in made:
            made[key] = make(*group)
    return tuple(made[tuple(map(id, group))] for group in zip(*laminates, strict=True))


def shifted(laminate: Laminate, shift: int, *, flip: bool, rotate: bool) -> Laminate:
    """Layer i goes to layer i + shift; with `flip` the stack is turned over first. What leaves the stack is gone, or
    with `rotate` comes back at its other end."""
    count = len(laminate)
    source = laminate[::-1] if flip else laminate
    if rotate:
        places = [*range(count)][shift:] + [*range(count)][:shift]
        result = [Sheet()] * count
        for place, sheet in zip(places, source, strict=True):
            result[place] = sheet
        return tuple(result)
    return _moved(source, shift, count)


def placed(
    laminate: Laminate, count: int, start: Line, ends: Sequence[Line], how: Placing, account: Account
) -> Laminate:
    """The laminate in a stack of `count` layers, once for each line of `ends`: moved, turned and scaled so that `start`
    comes to lie on it. Raises DesignError for a line without length and for results too large."""
    source = _moved(laminate[::-1] if how.flip else laminate, how.shift, count)
    corners = sum(
        int(shapely.get_num_coordinates(part)) for sheet in source for part in sheets.parts_of(sheet)
    )
    if corners * len(ends) > MOST_CORNERS:
        raise DesignError(
            f"{corners} corners placed {len(ends)} times are more than {MOST_CORNERS}; place less, or less often"
        )
    matrices = [_matrix(start, end, how) for end in ends]
    return each_sheet(lambda sheet: _copies(sheet, matrices, account), source)


def _moved(source: Sequence[Sheet], shift: int, count: int) -> Laminate:
    return tuple(source[i - shift] if 0 <= i - shift < len(source) else Sheet() for i in range(count))


def _matrix(start: Line, end: Line, how: Placing) -> list[float]:
    """[a, b, d, e, xoff, yoff] of shapely: to the start's frame, scaled along and across it, to the end's frame."""
    (x0, y0), (x1, y1) = start
    (u0, v0), (u1, v1) = end
    length, angle = math.hypot(x1 - x0, y1 - y0), math.atan2(y1 - y0, x1 - x0)
    goal, to = math.hypot(u1 - u0, v1 - v0), math.atan2(v1 - v0, u1 - u0)
    if not (length > 0.0 and goal > 0.0):
        raise DesignError("a line by which a laminate is placed has no length; draw it between two points")
    sx = goal / length if how.scale_x is None else how.scale_x
    sy = goal / length if how.scale_y is None else how.scale_y
    c, s, cc, ss = math.cos(angle), math.sin(angle), math.cos(to), math.sin(to)
    a, b = cc * sx * c + ss * sy * s, cc * sx * s - ss * sy * c
    d, e = ss * sx * c - cc * sy * s, ss * sx * s + cc * sy * c
    return [a, b, d, e, u0 - a * x0 - b * y0, v0 - d * x0 - e * y0]


def _copies(sheet: Sheet, matrices: Sequence[list[float]], account: Account) -> Sheet:
    parts: list[BaseGeometry] = []
    for matrix in matrices:
        for part in sheets.parts_of(sheet):
            copy = affine_transform(part, matrix)
            if not copy.is_empty and not max(map(abs, copy.bounds)) <= FARTHEST:
                raise DesignError(f"a laminate is placed beyond {FARTHEST:g} m; see the lines and scales")
            parts += [g for g in copy.geoms if not g.is_empty]
    return sheets.sheet_of(parts, account)
