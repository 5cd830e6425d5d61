"""Shapes and hinge lines that a native design takes from drawings beside it.

In: entries {file: top.dxf, layer: body} of a design's file. Out: regions and lines, m; what was assumed and mended is
told at the entry. Never: reads a file from elsewhere than the design's own folder.
"""

from dataclasses import replace
from typing import Any

from shapely.geometry import MultiPolygon

from lamc.basics.errors import DesignError, LamcError, Place, warn
from lamc.readers.popupcad_beside import Beside
from lamc.readers.schema import DrawnModel
from lamc.records.card import SheetOptions
from lamc.records.design import Line
from lamc.records.drawing import Drawing, Mend


class Drawings:
    """The drawings of one design, each read once; `mends` grows as shapes are taken."""

    def __init__(self, beside: Beside) -> None:
        self.beside = beside
        self.mends: list[Mend] = []
        self._read: dict[tuple[Any, ...], Drawing] = {}

    def region(self, entry: DrawnModel, place: Place) -> MultiPolygon:
        """Raises DesignError, naming the drawing and the line in it."""
        from lamc.readers.drawings.layer_shape import shape_of  # few designs need it

        found: MultiPolygon = self._taken(shape_of, entry, place)
        return found

    def lines(self, entry: DrawnModel, place: Place) -> tuple[Line, ...]:
        """Raises as `region` does."""
        from lamc.readers.drawings.layer_shape import lines_of

        found: tuple[Line, ...] = self._taken(lines_of, entry, place)
        return found

    def _taken(self, take: Any, entry: DrawnModel, place: Place) -> Any:
        from lamc.readers.drawings.layer_shape import told_of

        try:
            drawing = self._drawing(entry, place)
            found, mends = take(drawing, entry.layer, entry.heal)
        except LamcError as error:
            said = error.message if error.message.startswith(entry.file) else f"{entry.file}: {error.message}"
            raise DesignError(said) from error
        for note in told_of(mends, entry.heal, drawing):
            warn(f"{entry.file}: {note}", place)
        self.mends += [replace(mend, source=f"{entry.file}: {mend.source}") for mend in mends]
        return found

    def _drawing(self, entry: DrawnModel, place: Place) -> Drawing:
        from lamc.readers.drawings.reading import drawing_in  # svgelements and ezdxf, which few designs need

        options = SheetOptions(units=entry.units, roles=entry.roles, heal=entry.heal)
        key = (entry.file, entry.units, tuple(sorted((entry.roles or {}).items())), entry.heal)
        if key not in self._read:
            data = self.beside.data_of(entry.file)
            drawing = drawing_in(data, entry.file, options, self.beside.limits)
            if drawing is None:
                raise DesignError("it is no drawing; lamc takes shapes from SVG and DXF")
            self._read[key] = drawing
            for note in drawing.notes:
                warn(f"{entry.file}: {note}", place)
        return self._read[key]
