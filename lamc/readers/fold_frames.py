"""Frames of a FOLD file: which one is read, what it inherits, and what of the file is not read.

In: JSON as data. Out: the fields of one frame, and notes. Never: looks into vertices, edges or faces.
"""

from collections.abc import Callable, Mapping
from difflib import get_close_matches
from typing import Any

from lamc.basics.checks import shown
from lamc.basics.errors import DesignError
from lamc.records.network import listed_names

KEYS = (  # of spec 1.2
    *(f"file_{key}" for key in ("spec", "creator", "author", "title", "description", "classes", "frames")),
    *(f"frame_{key}" for key in ("author", "title", "description", "classes", "attributes", "unit")),
    *("frame_parent", "frame_inherit"),
    *(f"vertices_{key}" for key in ("coords", "vertices", "edges", "faces")),
    *(f"edges_{key}" for key in ("vertices", "faces", "assignment", "foldAngle", "length")),
    *(f"faces_{key}" for key in ("vertices", "edges", "faces")),
    *("faceOrders", "edgeOrders"),
)
RENAMED = {"edges_foldAngles": "edges_foldAngle", "edges_lengths": "edges_length"}  # of spec 1.0, by spec 1.1
_NEARLY = (
    0.85  # of 1, by difflib: a letter or two of a key; `faces_layer` of other programs is a key of its own
)
_DRAWN = {"edges_vertices", "faces_vertices"}
_MOST_FRAMES = 10_000  # of a chain of parents
Data = Mapping[str, Any]
Errors = Callable[[str], DesignError]


def chosen_frame(data: Data, error: Errors, notes: list[str], number: int | None = None) -> dict[str, Any]:
    """The frame that is read, with what it inherits: by its number, or the key frame, or the first one that has edges
    or faces.

    notes takes what is not read: other frames that draw a sheet, and keys that are nearly those of FOLD. error makes
    what is raised from a message.
    """
    every = _frames(data, error)
    key = every[0]
    for index in range(len(every)) if number is None else [number]:
        merged = _inherited(every, index, error)
        if not merged.keys() & _DRAWN:
            continue
        if index and number is None:
            notes.append(f"the key frame has no edges: frame {index} is read")
        others = [str(k) for k, frame in enumerate(every) if k != index and frame.keys() & _DRAWN]
        if others:
            notes.append(
                f"only frame {index} is read, and {listed_names(others)} draw sheets of their own: to run one, put it "
                "at the top of the file, as the key frame"
            )
        for name in merged:
            near = meant(name)
            if near is not None and near not in merged:
                notes.append(f"the key {name!r} is none of FOLD's, and is not read; is {near!r} meant?")
        if "frame_unit" in key and "frame_unit" not in merged:
            notes.append(
                f"frame {index} says no unit: that of the key frame, {shown(key['frame_unit'])}, is taken"
            )
        return {**{k: v for k, v in key.items() if k in ("file_title", "frame_unit")}, **merged}
    raise error("no frame has edges_vertices or faces_vertices; draw the sheet's edges")


def pattern_frame(data: Data, error: Errors) -> int | None:
    """The number of the first frame behind the key frame that says it is a crease pattern, and draws one; None where
    there is none."""
    every = _frames(data, error)
    for index, frame in enumerate(every[1:], 1):
        classes = frame.get("frame_classes")
        if (
            isinstance(classes, list)
            and "creasePattern" in classes
            and _inherited(every, index, error).keys() & _DRAWN
        ):
            return index
    return None


def _frames(data: Data, error: Errors) -> list[dict[str, Any]]:
    frames = data.get("file_frames", [])
    if not isinstance(frames, list) or not all(isinstance(frame, dict) for frame in frames):
        raise error("file_frames must be a list of maps")
    key = {name: value for name, value in data.items() if name != "file_frames"}
    return [_renamed(frame) for frame in (key, *frames)]


def _renamed(frame: Mapping[str, Any]) -> dict[str, Any]:
    """With the names of today; what stands there by one of them already stays."""
    return {
        RENAMED.get(name, name): value for name, value in frame.items() if RENAMED.get(name, "") not in frame
    }


def meant(key: str) -> str | None:
    """The key of FOLD that another one, which is nobody's own (`NAME:KEY`), is nearly; None where there is none."""
    if key in KEYS or ":" in key:
        return None
    return next(iter(get_close_matches(key, KEYS, n=1, cutoff=_NEARLY)), None)


def _inherited(every: list[dict[str, Any]], index: int, error: Errors) -> dict[str, Any]:
    chain = [every[index]]
    seen = {index: None}  # in their order
    while chain[-1].get("frame_inherit") is True:
        parent = chain[-1].get("frame_parent", 0)
        if isinstance(parent, bool) or not isinstance(parent, int) or not 0 <= parent < len(every):
            raise error(f"frame {index} has frame_parent {shown(parent)}; frames are 0 to {len(every) - 1}")
        if parent in seen:
            ring = listed_names([str(k) for k in sorted(list(seen)[list(seen).index(parent) :])])
            raise error(
                f"frame {index} has no end of parents: {ring} inherit from one another, or from themselves"
            )
        if len(seen) > _MOST_FRAMES:
            raise error(
                f"frame {index} has more than {_MOST_FRAMES} parents, one behind the other: write it out"
            )
        seen[parent] = None
        chain.append(every[parent])
    merged: dict[str, Any] = {}
    for frame in reversed(chain):
        merged.update(frame)
    return merged
