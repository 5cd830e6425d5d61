"""A FOLD file without faces whose edges cross, touch or run over one another: lines, to be healed as a drawing's are.

In: a frame. Out: whether its edges part facets as they are, and if not, a `Drawing` of them. Never: mends anything.
"""

import numpy as np

from lamc.basics.errors import DesignError
from lamc.readers.drawings.heal import check_crossings
from lamc.readers.fold_faces import check_count, check_planar
from lamc.readers.fold_file import FoldFrame
from lamc.readers.fold_level import is_level
from lamc.readers.fold_sheet import unit_of
from lamc.records.card import SheetOptions
from lamc.records.drawing import Drawing, Role, Stroke

# J joins two facets for good, as F does as long as facets are rigid; a note tells the difference.
_ROLES: dict[str, Role] = {
    "B": "border",
    "C": "cut",
    "M": "mountain",
    "V": "valley",
    "U": "undriven",
    "F": "flat",
    "J": "flat",
}


def lines_of(frame: FoldFrame, options: SheetOptions, stem: str, file: str) -> Drawing | None:
    """The edges as a drawing, m; None where they part facets as they are, or lie in no plane.

    Raises DesignError for more edges than are read.
    """
    if frame.faces is not None or frame.own or not is_level(frame):
        return None
    check_count(len(frame.edges), "edges", large=options.large)
    check_crossings(frame.vertices[np.array(frame.edges, dtype=np.int64).reshape(-1, 2), :2])
    fault = None
    try:
        check_planar(frame.vertices[:, :2], frame.edges, frame.number)
    except DesignError as error:
        fault = error.message
    if fault is None and options.heal is None:
        return None
    notes = list(frame.notes)
    if fault is not None:
        notes.append(f"{fault.partition(':')[0]}: edges are healed as lines of a drawing are")
    points = [k for k, (a, b) in enumerate(frame.edges) if not np.any(frame.vertices[a] - frame.vertices[b])]
    if points:
        notes.append(f"{frame.edges_named(points)} left out: no length")
    joined = [k for k, kind in enumerate(frame.kinds) if kind == "J"]
    if joined:
        notes.append(f"{frame.edges_named(joined)} marked J: read as F, along which facets may bend")
    scale = unit_of(frame, options, notes)
    strokes = tuple(
        Stroke(
            scale * frame.vertices[list(ends), :2], False, _ROLES[kind], angle, "", f"edge {frame.number(k)}"
        )
        for k, (ends, kind, angle) in enumerate(zip(frame.edges, frame.kinds, frame.angles, strict=True))
    )
    return Drawing(frame.title.strip() or stem or "sheet", strokes, scale, tuple(notes), file)
