"""SVG: a drawing of lines becomes strokes with a role each, in m, y up.

In: bytes, and what a user says of colours, layers and units. Out: a `Drawing`. Never: runs or fetches anything that the
file names; leaves a line out without a note.

A point (X, Y) of the root's user units is (s X, -s Y), s the size of a user unit: coordinates are those of the file,
with y up. An opacity of 1 is a fold of 180 degrees: the convention of Origami Simulator (Amanda Ghassaei, 2017).
"""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import PurePath

import numpy as np

from lamc.basics.errors import DesignError, LamcError, Place
from lamc.readers.drawings.curves import Outline, size_of
from lamc.readers.drawings.kinds import looks_like_xml
from lamc.readers.drawings.notes import Notes
from lamc.readers.drawings.roles import layer_angle
from lamc.readers.drawings.svg_lengths import LARGEST, Scale, scale_of
from lamc.readers.drawings.svg_roles import ShapeRoles
from lamc.readers.drawings.svg_shapes import outlines
from lamc.readers.drawings.svg_tree import Document, document
from lamc.readers.drawings.svg_walk import Drawn, Walk
from lamc.readers.inert import Limits, Progress
from lamc.records.card import SheetOptions
from lamc.records.drawing import Drawing, Role, Stroke
from lamc.records.mechanism import Array

# Chords of curves: within what a laser leaves, and half of what healing bridges by default (`heal.DEFAULT`), so that
# lines that end on a curve still do.
_FINEST, _SHARE = 1e-5, 5e-5  # m; of the drawing's size
_SMALL, _LARGE = 5e-4, 5.0  # m: a drawing beyond these has a unit of its own, probably
_PER_REPORT = 1000
_NO_POINTS = np.zeros((0, 2))


def is_svg(data: bytes) -> bool:
    """True for a file that is meant as SVG, or is other XML."""
    return looks_like_xml(data)


def read_svg(
    data: bytes, file: str, options: SheetOptions, limits: Limits, progress: Progress | None = None
) -> Drawing:
    """The drawing in a file. Raises DesignError with element, line and way out for what cannot be read, for a limit
    that is passed, and where no line is left."""
    try:
        return _Reader(document(data, file, limits), file, options, limits).drawing(progress)
    except LamcError as error:
        raise (type(error)(error.message, Place(file)) if error.place is None else error) from error


class _Reader:
    def __init__(self, found: Document, file: str, options: SheetOptions, limits: Limits) -> None:
        self.document, self.file, self.options, self.limits = found, file, options, limits
        self.notes = Notes()
        for note in found.notes:
            self.notes.say(note)
        for program in found.programs:
            self.notes.add("is a program and is not run", program)
        self.roles = ShapeRoles(options, self.notes)

    def drawing(self, progress: Progress | None) -> Drawing:
        walk = Walk(self.document, self.limits, self.notes)
        scale = scale_of(self.document, walk.root, self.options.units)
        lines = self._lines(walk, scale, progress)
        if not lines:
            raise DesignError(f"the drawing has no line that is for anything{self._left_out()}")
        outlines = [outline for _, outline in lines]
        size = size_of(outlines)
        self._tell_size(scale, size)
        tolerance = min(_FINEST, _SHARE * size)
        strokes = self._flat(lines, tolerance) if size > 0.0 else ()
        if not strokes:
            raise DesignError(f"the drawing has no line of any length{self._left_out()}")
        self.roles.tell()
        return Drawing(self._name(), strokes, scale.x, self.notes.lines, self.file)

    def _lines(self, walk: Walk, scale: Scale, progress: Progress | None) -> list[tuple[Stroke, Outline]]:
        """Strokes without points yet, and their outlines in m."""
        to_metres = np.diag([scale.x, -scale.y, 1.0])
        found: list[tuple[Stroke, Outline]] = []
        filled: list[Drawn] = []
        for count, drawn in enumerate(walk.shapes()):
            if progress is not None and count % _PER_REPORT == 0:
                progress("reading", min(1.0, count / self.document.count))
            if drawn.style.stroke is None:
                filled.append(drawn)
                continue
            role, layer = self.roles.of_stroke(drawn.style, drawn.source)
            if role is not None:
                found += self._placed(drawn, role, layer, drawn.style.strength, to_metres)
        is_silhouette = not found
        for drawn in filled:
            is_line = drawn.element.tag == "line"  # which has nothing to fill
            style = replace(drawn.style, fill=None) if is_line else drawn.style
            role, layer = self.roles.of_fill(style, drawn.source, is_silhouette=is_silhouette and not is_line)
            if role is not None:
                found += self._placed(drawn, role, layer, 1.0, to_metres)
        return found

    def _placed(
        self, drawn: Drawn, role: Role, layer: str, opacity: float, to_metres: Array
    ) -> list[tuple[Stroke, Outline]]:
        """What one element draws."""
        parts = outlines(drawn.element, drawn.viewport)
        if not parts:
            self.notes.add("draws nothing", drawn.source)
        found = []
        groups = tuple(name for name, _ in drawn.style.layers)
        for k, part in enumerate(parts, 1):
            placed = part.moved(to_metres @ drawn.matrix)
            if not all(bool(np.all(np.abs(curve.reach) < LARGEST)) for curve in placed.curves):
                raise drawn.element.error(
                    f"{drawn.element.source} reaches beyond {LARGEST:g} m, or to no number; draw it anew"
                )
            source = f"{drawn.source}, part {k}" if len(parts) > 1 else drawn.source
            angle = self.roles.angle(role, layer, opacity)
            rests: Role = "hinge" if angle == 0.0 else role  # neither mountain nor valley
            full = opacity == 1.0 and angle is not None and layer_angle(layer) is None
            stroke = Stroke(_NO_POINTS, part.closed, rests, angle, layer, source, full, groups)
            found.append((stroke, placed))
        return found

    def _flat(self, lines: Sequence[tuple[Stroke, Outline]], tolerance: float) -> tuple[Stroke, ...]:
        """Strokes with their points, m, off by `tolerance` at most."""
        total = sum(outline.count(tolerance) for _, outline in lines)
        if total > self.limits.values:
            raise DesignError(
                f"curves within {tolerance:g} m come to {total} points; at most {self.limits.values} are read (limit "
                "'values'): check the drawing's size (--units), or draw with fewer curves"
            )
        strokes = []
        for stroke, outline in lines:
            points, closed = outline.flat(tolerance)
            if len(points) < 2:
                self.notes.add("draws nothing: its length is 0", stroke.source)
                continue
            strokes.append(replace(stroke, points=points, closed=closed))
        return tuple(strokes)

    def _tell_size(self, scale: Scale, size: float) -> None:
        if scale.note:
            self.notes.say(
                f"{scale.note}, and the drawing is {1e3 * size:.4g} mm from corner to corner (--units says another)"
            )
        elif self.options.units is None and size > 0.0 and not _SMALL < size < _LARGE:
            self.notes.say(
                f"the drawing is {1e3 * size:.4g} mm from corner to corner, by its width and viewBox; --units says "
                "what a user unit is, if that cannot be"
            )

    def _left_out(self) -> str:
        lines = self.notes.lines
        more = f"; and {len(lines) - 5} more notes" if len(lines) > 5 else ""
        return ": " + "; ".join(lines[:5]) + more if lines else ": it draws nothing"

    def _name(self) -> str:
        title = next((each.text.strip() for each in self.document.root.children if each.tag == "title"), "")
        return title or PurePath(self.file).stem
