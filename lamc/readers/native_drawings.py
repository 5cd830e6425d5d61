"""Shapes and hinge lines that a native design takes from drawings beside it.

In: entries {file: top.dxf, layer: body} of a design's file. Out: regions and lines, m; what was assumed and mended is
told at the entry. Never: reads a file from elsewhere than the design's own folder.
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from shapely.affinity import translate
from shapely.geometry import MultiPolygon
from shapely.geometry.base import BaseGeometry

from lamc.basics.errors import DesignError, LamcError, Place, warn
from lamc.design.shapes import check_coordinates
from lamc.readers.drawings.roles import is_angle_note
from lamc.readers.popupcad_beside import Beside
from lamc.readers.schema import DrawnModel
from lamc.records.card import SheetOptions
from lamc.records.design import Line
from lamc.records.drawing import Drawing, Mend, Role

# Options that messages about drawings name, and how a design's file says the same.
_AS_KEYS = (
    (re.compile(r"--role '(.*?)=([^']+)'"), r"roles: {'\1': \2}"),
    (re.compile(r"--(units|heal)(?: (?=[\w'])|\b)"), r"\1: "),
    (re.compile(r"(units|heal):  ?(says|is)"), r"\1: \2"),
)
# What notes say of lines without a role: of other layers than one whose lines have theirs from the design.
_OTHERS = (" is for nothing (", "neither layer nor colour says what for")

_ANGLES_ARE_NOT_READ = (
    "the drawing says at which angles its creases rest, by layer or opacity, which is not read here: rest_angle says "
    "where a hinge of a design does"
)
_ZERO = (0.0, 0.0)
_Key = tuple[Any, ...]


class Drawings:
    """The drawings of one design, each read once, and what is taken from them, each found and told once."""

    def __init__(self, beside: Beside) -> None:
        self.beside = beside
        self._read: dict[_Key, Drawing] = {}
        self._told: set[_Key] = set()  # those in `_read`, and places of hinge lines
        self._found: dict[_Key, tuple[Any, Sequence[Mend]]] = {}

    def region(self, entry: DrawnModel, place: Place, mends: list[Mend]) -> MultiPolygon:
        """What outlines enclose; what was mended is added to `mends`. Raises DesignError, naming the drawing and the
        line in it."""
        from lamc.readers.drawings.layer_shape import shape_of  # few designs need it

        found: MultiPolygon = self._once(shape_of, "border", entry, place, mends)
        if entry.at == _ZERO:
            return found
        check_coordinates(np.add(found.bounds, entry.at * 2), "the shape")
        return translate(found, *entry.at)

    def lines(self, entry: DrawnModel, place: Place, mends: list[Mend], *, rests: bool) -> tuple[Line, ...]:
        """As `region`, of hinge lines. rests: whether the design says at which angle."""
        from lamc.readers.drawings.layer_shape import in_a_row, lines_of, says_angles, tolerance_of
        from lamc.readers.drawings.telling import millimetres

        found: tuple[Line, ...] = self._once(lines_of, "hinge", entry, place, mends)
        laid = tuple((_laid(start, entry), _laid(end, entry)) for start, end in found)
        if (place, rests) in self._told:
            return laid
        self._told.add((place, rests))
        drawing = self._drawing(entry, "hinge", place)
        row = in_a_row(found, tolerance_of(drawing, entry.heal))
        if row:
            also = " and elsewhere" if len(row) > 1 else ""
            warn(
                f"{entry.file}: hinge lines go on straight where they meet, at {millimetres(row[0])}{also}: each is a "
                "hinge of its own with all that is said of it; draw one line, if they are one",
                place,
            )
        if not rests and says_angles(drawing, entry.layer):
            warn(f"{entry.file}: {_ANGLES_ARE_NOT_READ}", place)
        return laid

    def lengthened(
        self,
        entry: DrawnModel,
        place: Place,
        lines: Sequence[Line],
        material: BaseGeometry,
        mends: list[Mend],
    ) -> Sequence[Line]:
        """Hinge lines of an entry, those that stop short of the edge of the material within its tolerance, drawn on to
        that; what was mended is told, and added to `mends`."""
        from lamc.readers.drawings.layer_shape import lengthened, mend_notes_of, tolerance_of

        drawing = self._drawing(entry, "hinge", place)
        found, made = lengthened(lines, material, tolerance_of(drawing, entry.heal))
        x, y = entry.at
        in_drawing = [replace(mend, at=(mend.at[0] - x, mend.at[1] - y)) for mend in made]
        for note in mend_notes_of(in_drawing, entry.heal, drawing):
            warn(f"{entry.file}: {note}", place)
        mends += [replace(mend, source=f"{entry.file}: {mend.source}") for mend in made]
        return found

    def _once(self, take: Any, role: Role, entry: DrawnModel, place: Place, mends: list[Mend]) -> Any:
        key = (role, entry.layer, place, *_key(entry, entry.roles or {}))
        if key not in self._found:
            self._found[key] = self._taken(take, role, entry, place)
        found, mended = self._found[key]
        mends += [replace(mend, at=_laid(mend.at, entry)) for mend in mended]
        return found

    def _taken(self, take: Any, role: Role, entry: DrawnModel, place: Place) -> tuple[Any, Sequence[Mend]]:
        from lamc.readers.drawings.layer_shape import mend_notes_of

        try:
            drawing = self._drawing(entry, role, place)
            found, mends = take(drawing, entry.layer, entry.heal)
        except LamcError as error:
            said = error.message if error.message.startswith(entry.file) else f"{entry.file}: {error.message}"
            raise DesignError(in_keys(said)) from error
        for note in mend_notes_of(mends, entry.heal, drawing):
            warn(f"{entry.file}: {note}", place)
        return found, [replace(mend, source=f"{entry.file}: {mend.source}") for mend in mends]

    def _drawing(self, entry: DrawnModel, role: Role, place: Place) -> Drawing:
        """The drawing; where nothing says what the lines of the layer are for, this entry does: `role`.

        Notes are told once, at the first entry that takes the drawing so.
        """
        roles: Mapping[str, Role] = entry.roles or {}
        says = entry.layer is not None and "ignore" not in roles.values() and not self._has(entry, roles)
        named = {**roles, str(entry.layer): role}
        says = says and self._has(entry, named)
        roles = named if says else roles
        drawing, key = self._as(entry, roles), _key(entry, roles)
        for note in drawing.notes if key not in self._told else ():
            if not (says and any(words in note for words in _OTHERS)) and not is_angle_note(note):
                warn(f"{entry.file}: {in_keys(note)}", place)
        self._told.add(key)
        return drawing

    def _has(self, entry: DrawnModel, roles: Mapping[str, Role]) -> bool:
        """True where a line of the entry's layer is for something."""
        try:
            drawing = self._as(entry, roles)
        except LamcError:  # told by the reading that counts
            return False
        return any(each.layer == entry.layer and each.role != "ignore" for each in drawing.strokes)

    def _as(self, entry: DrawnModel, roles: Mapping[str, Role]) -> Drawing:
        """The drawing with those roles, read once."""
        from lamc.readers.drawings.reading import drawing_in  # svgelements and ezdxf, which few designs need

        key = _key(entry, roles)
        if key not in self._read:
            options = SheetOptions(units=entry.units, roles=roles or None, heal=entry.heal)
            data = self.beside.data_of(entry.file)
            drawing = drawing_in(data, entry.file, options, self.beside.limits)
            if drawing is None:
                raise DesignError("it is no drawing; lamc takes shapes from SVG and DXF")
            self._read[key] = drawing
        return self._read[key]


def _laid(point: tuple[float, float], entry: DrawnModel) -> tuple[float, float]:
    """A place of the drawing, m, in the design."""
    return point[0] + entry.at[0], point[1] + entry.at[1]


def _key(entry: DrawnModel, roles: Mapping[str, Role]) -> _Key:
    """By what a drawing is read."""
    return (entry.file, entry.units, tuple(sorted(roles.items())), entry.heal)


def in_keys(message: str) -> str:
    """A message with the keys of a design's file in the place of the command line's options."""
    for option, key in _AS_KEYS:
        message = option.sub(key, message)
    return message
