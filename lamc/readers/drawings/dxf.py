"""DXF files, R12 to 2018, text or binary: the lines of their model space as a `Drawing`.

In: bytes, and what a user says of the drawing. Out: a `Drawing`, its notes telling what was assumed, repaired or left
out. Never: fetches what a file names; runs anything of it; prints ezdxf's own log.
"""

import io
import logging
import math
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import PurePath
from typing import Any

import numpy as np

from lamc.basics.brief import counted
from lamc.basics.errors import DesignError, LamcError, Place
from lamc.readers.drawings.colours import colour_of, family_of
from lamc.readers.drawings.dxf_repair import bare, mended, renamed
from lamc.readers.drawings.dxf_tags import Tag, tags_of
from lamc.readers.drawings.dxf_tags import is_dxf as is_dxf
from lamc.readers.drawings.dxf_units import length_text, scale_of
from lamc.readers.drawings.dxf_walk import Drawn, Walk
from lamc.readers.drawings.roles import (
    angle_note,
    check_roles,
    colour_role,
    counted_note,
    layer_angle,
    layer_name,
    layer_role,
    meant_layer,
    role_of,
    said_role,
)
from lamc.readers.inert import Limits
from lamc.records.card import SheetOptions
from lamc.records.drawing import Drawing, Role, Stroke
from lamc.records.mechanism import Array

_FINEST, _SHARE = (
    1e-5,
    5e-5,
)  # m, and of the drawing's size: how far chords are from a curve at most, as in SVG
_LARGEST = 1e12  # of a coordinate: its square and products stay finite
_LEVEL = 1e-6  # of the drawing's size: heights that differ less are one
_SHORT = 1e-9  # of the drawing's size: what is shorter has no direction


def read_dxf(data: bytes, file: str, options: SheetOptions, limits: Limits) -> Drawing:
    """The lines that a DXF file shows. Raises DesignError with entity, handle and place for what cannot be read."""
    try:
        return _Reader(file, options, limits).drawing(data)
    except LamcError as error:
        raise (type(error)(error.message, Place(file)) if error.place is None else error) from error


class _Reader:
    def __init__(self, file: str, options: SheetOptions, limits: Limits) -> None:
        self.file, self.options, self.limits = file, options, limits
        self.notes: list[str] = []

    def drawing(self, data: bytes) -> Drawing:
        given = mended(tags_of(data, self.file, self.limits))
        self.notes += given.notes
        with _quiet(), np.errstate(all="ignore"):  # what is not finite is refused below
            document, flaws = _document(given.tags)
            walk = Walk(document, given.kinds, self.limits)
            drawn = walk.drawn()
        self._tell_flaws(flaws)
        self.notes += walk.notes
        if not drawn:
            why = "; ".join(self.notes)
            raise DesignError(
                f"the model space shows no line{': ' + why if why else '; draw LINE, LWPOLYLINE, ARC, …'}"
            )
        roles = self._roles(drawn)
        boxes = [_box(each) for each in drawn]
        used = [k for k, role in enumerate(roles) if role != "ignore"] or list(range(len(drawn)))
        extent = np.ptp(np.concatenate([boxes[k] for k in used]), axis=0)
        size = float(np.linalg.norm(extent[:2])) or 1.0
        scale = scale_of(document.header, self.options.units, extent[:2], self.notes)
        self._check_level([(drawn[k], boxes[k]) for k in used], size, scale)
        tolerance = min(_SHARE * size, _FINEST / scale)
        strokes = self._strokes(drawn, roles, tolerance, size, scale)
        return Drawing(PurePath(self.file).stem, tuple(strokes), scale, tuple(self.notes), self.file)

    def _roles(self, drawn: list[Drawn]) -> list[Role]:
        check_roles(self.options)
        counts = Counter((each.layer, each.colour) for each in drawn)
        roles = {(layer, colour): role_of(colour, layer, self.options) for layer, colour in counts}
        unknown = sorted(key for key, role in roles.items() if role is None)
        for layer, colour in unknown:
            shared = any(key[0] == layer and role is not None for key, role in roles.items())
            # The role of a layer is that of all its lines.
            named = colour if shared or layer == "0" else layer[:60]
            self.notes.append(
                f"left out, neither layer nor colour says what for: {counted(counts[layer, colour], 'line')} on layer "
                f"{layer[:60]!r}, colour {colour} (--role '{named}=cut', or another role)"
            )
        for (layer, colour), role in sorted(roles.items(), key=lambda each: each[0]):
            if role is not None and said_role(colour, layer, self.options) is None:
                self._tell_role(layer, colour, role, counts[layer, colour])
        for name, given in (self.options.roles or {}).items():
            alone = SheetOptions(roles={name: given})
            if not any(said_role(colour, layer, alone) for layer, colour in counts):
                self.notes.append(f"no line is of the colour or layer {name[:40]!r} that a role is given for")
        return [roles[each.layer, each.colour] or "ignore" for each in drawn]

    def _tell_role(self, layer: str, colour: str, role: Role, count: int) -> None:
        """Where layer and colour say different things, or a layer's name is nearly one that says something."""
        lines = f"{count} line{'s' if count > 1 else ''} on layer {layer[:60]!r}, colour {colour}"
        meant = meant_layer(layer)
        if role == "ignore":
            self.notes.append(
                f"{lines}: left out, as the layer is for nothing (--role '{layer[:60]}=cut' says what for)"
            )
        elif meant is not None:
            self.notes.append(f"{lines}: {role}, by the colour; if the layer is to be {meant!r}, name it so")
        elif layer_role(layer) is not None and colour_role(colour) not in (None, role, "border"):
            self.notes.append(f"{lines}: {role}, whatever the colour (--role '{layer[:60]}=…' says another)")
        elif role == "border" and layer_role(layer) is None and layer != "0" and layer_name(layer):
            # Black and white are what lines have whose colour nobody chose.
            self.notes.append(
                f"{lines}: {role}, by the colour (--role '{layer[:60]}=hinge', '…=ignore' or another says what for)"
            )
        elif role == colour_role(colour) and role != layer_role(layer):
            taken = colour_of(colour)
            family = family_of(taken[0]) if taken is not None else None
            if family is not None and not family[1]:
                self.notes.append(
                    f"{lines}, taken for {family[0]}: {role} (--role '{colour}=…' says another)"
                )

    def _strokes(
        self, drawn: list[Drawn], roles: list[Role], tolerance: float, size: float, scale: float
    ) -> Iterator[Stroke]:
        short: list[str] = []
        angled: dict[str, float] = {}
        count = 0
        angles = {layer: layer_angle(layer) for layer in {each.layer for each in drawn}}
        for each, role in zip(drawn, roles, strict=True):
            rows = each.course.points(tolerance)[:, :2]
            count += len(rows)
            if count > self.limits.values:
                raise DesignError(
                    f"its curves take more than {self.limits.values} points, the limit 'values' (lamc.Limits)"
                )
            if len(rows) < 2 or float(np.ptp(rows, axis=0).max()) <= _SHORT * size:
                short.append(f"{each.source} at {_at(rows[0], scale)}")
                continue
            angle = angles[each.layer] if role in ("mountain", "valley", "hinge") else None
            if angle is not None:
                if role == "hinge" or not angle:
                    role = "valley" if angle > 0.0 else "mountain" if angle < 0.0 else "hinge"
                angle = math.copysign(angle, -1.0 if role == "mountain" else 1.0)
                angled[each.layer] = angle
            yield Stroke(rows * scale, each.course.closed, role, angle, each.layer, each.source)
        self.notes += [angle_note(layer, angle) for layer, angle in sorted(angled.items())]
        hinges = {each.layer for each, role in zip(drawn, roles, strict=True) if role == "hinge"}
        self.notes += [note for note in map(counted_note, sorted(hinges)) if note is not None]
        if short:
            self.notes.append(f"left out: {len(short)} lines without a length (first {short[0]})")

    def _check_level(self, lines: list[tuple[Drawn, Array]], size: float, scale: float) -> None:
        """Raises DesignError for a line that leaves the plane; lines at several heights are told, and laid in one."""
        near = _LEVEL * size
        for each, box in lines:
            if box[1, 2] - box[0, 2] > near:
                rows = each.course.points()
                low, high = rows[rows[:, 2].argmin()], rows[rows[:, 2].argmax()]
                raise DesignError(
                    f"{each.source} on layer {each.layer[:60]!r} goes from z = {low[2]:.6g} at {_at(low, scale)} to "
                    f"z = {high[2]:.6g}; a drawing lies in a plane of one z: draw it flat (FLATTEN), seen from above"
                )
        lowest = min(lines, key=lambda line: float(line[1][0, 2]))
        highest = max(lines, key=lambda line: float(line[1][0, 2]))
        if highest[1][0, 2] - lowest[1][0, 2] > near:
            ends = (f"{length_text(box[0, 2] * scale)} ({each.source})" for each, box in (lowest, highest))
            self.notes.append(f"lines at several heights are laid in one plane: z from {' to '.join(ends)}")

    def _tell_flaws(self, flaws: list[str]) -> None:
        if flaws:
            more = f"; and {len(flaws) - 2} more" if len(flaws) > 2 else ""
            listed = "; ".join(" ".join(flaw.split())[:160] for flaw in flaws[:2])
            self.notes.append(f"the file has flaws, which were repaired or passed over: {listed}{more}")


def _document(tags: list[Tag]) -> tuple[Any, list[str]]:
    """ezdxf's document, and what it repaired. Raises DesignError where it cannot read the file.

    As `ezdxf.recover.read` does it, but for its search for blocks within themselves, which takes for ever where blocks
    are nested by twos: `Walk` counts them.
    """
    from ezdxf.audit import Auditor
    from ezdxf.document import Drawing as Document
    from ezdxf.lldxf.types import DXFTag
    from ezdxf.recover import Recover

    class Patient(Auditor):
        def check_block_reference_cycles(self) -> None:
            pass

    def read(given: list[Tag]) -> tuple[Any, list[str]]:
        tool = Recover.run(io.BytesIO(), loader=lambda _: (DXFTag(code, value) for code, value in given))
        document = Document()
        document._load_section_dict(tool.section_dict)
        auditor = Patient(document)
        auditor.run()
        entries = [message for _, message in (*tool.errors, *tool.fixes)]
        entries += [entry.message for entry in (*auditor.errors, *auditor.fixes)]
        return document, [renamed(message) for message in entries]

    # ezdxf meets what no rule of DXF allows with whatever error comes.
    try:
        return read(tags)
    except Exception as first:
        why = f"{renamed(str(first))[:200] or 'it has no order'} ({type(first).__name__})"
    try:
        document, flaws = read(bare(tags))
    except Exception as error:
        raise DesignError(
            f"this is not DXF that can be read: {why}; save it again with the program that made it, as R2000 or later"
        ) from error
    return document, [f"{why}: layers, blocks and entities alone are read", *flaws]


@contextmanager
def _quiet() -> Iterator[None]:
    """ezdxf's log goes nowhere: what it repairs is told by us."""
    log = logging.getLogger("ezdxf")
    before, log.disabled = log.disabled, True
    try:
        yield
    finally:
        log.disabled = before


def _at(row: Array, scale: float) -> str:
    """A place in the drawing, in its own units where these are not mm too."""
    x, y = row[0], row[1]
    own = "" if scale == 1e-3 else f", ({x:.6g}, {y:.6g}) in the file's units"
    return f"({1e3 * scale * x:.6g}, {1e3 * scale * y:.6g}) mm{own}"


def _box(drawn: Drawn) -> Array:
    """Its lowest and highest coordinates, (2, 3). Raises DesignError for what is no number, or too large."""
    rows = drawn.course.points()
    box = np.array([rows.min(axis=0), rows.max(axis=0)])
    if not np.isfinite(box).all():
        raise DesignError(f"{drawn.source} on layer {drawn.layer[:60]!r} has a coordinate that is not finite")
    if np.abs(box).max() > _LARGEST:
        raise DesignError(
            f"{drawn.source} on layer {drawn.layer[:60]!r} has the coordinate {np.abs(box).max():.6g}; up to "
            f"{_LARGEST:g} is read"
        )
    return box
