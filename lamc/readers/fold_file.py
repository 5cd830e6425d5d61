"""FOLD files, spec 1.0 to 1.2: JSON as a checked record of one frame, lists of a length each, numbers finite.

In: text. Out: a `FoldFrame` in the file's own units. Never: makes a body; follows what a file names outside itself.

Erik D. Demaine, Jason S. Ku, Robert J. Lang, A new file standard to represent folded structures, 2016; spec 1.2, 2023.
"""

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from lamc.basics.checks import shown
from lamc.basics.errors import DesignError, Place
from lamc.readers.fold_frames import Data, chosen_frame, meant, pattern_frame
from lamc.readers.fold_seams import with_seams
from lamc.readers.inert import Limits
from lamc.readers.json_text import parsed
from lamc.records.mechanism import Array
from lamc.records.network import listed_names

KINDS = "MVFUBCJ"  # mountain, valley, flat, unassigned, boundary, cut, join
UNITS = {
    "in": 0.0254,
    "pt": 0.0254 / 72.0,
    "m": 1.0,
    "cm": 0.01,
    "mm": 0.001,
    "um": 1e-6,
    "nm": 1e-9,
}
LARGEST = 1e12  # of a coordinate: squares and products of such numbers stay finite and are told apart

LINK = "a link to a hole"  # the source of an edge that no line draws: it joins a hole to the rim about it

_MARKS = re.compile(
    r'"(?:file_spec|file_frames|frame_classes|vertices_coords|edges_vertices|faces_vertices)"\s*:'
)


@dataclass(frozen=True)
class FoldFrame:
    """One frame of a file.

    vertices  (n, 3), in `unit`
    kinds     a letter of `KINDS` for each edge
    angles    rad, of each edge, positive for a valley; None: not given
    faces     vertices of each; None: the file has none
    unit      m; None: not given
    own       fields that lamc writes, "lamc:…", unchecked
    sources   what a drawing calls the line of each edge; none: edges have numbers only
    numbers   of the edges in the file, where some of its edges are left out; none: as they come
    off       m, by which pieces of one hinge may lie off its line, beside rounding
    """

    title: str
    vertices: Array
    edges: tuple[tuple[int, int], ...]
    kinds: str
    angles: tuple[float | None, ...]
    faces: tuple[tuple[int, ...], ...] | None
    unit: float | None
    own: Data
    notes: tuple[str, ...]
    sources: tuple[str, ...] = ()
    off: float = 0.0
    numbers: tuple[int, ...] = ()

    def number(self, edge: int) -> int:
        """The number that the file gives an edge, by its place here; edges that lamc adds come behind the file's."""
        if not self.numbers:
            return edge
        kept = len(self.numbers)
        return self.numbers[edge] if edge < kept else self.numbers[-1] + edge - kept + 1

    def edges_named(self, numbers: Sequence[int]) -> str:
        """Edges as messages name them."""
        if self.sources:
            return listed_names(list(dict.fromkeys(self.sources[k] for k in numbers)))
        return f"edge{'s' if len(numbers) > 1 else ''} {listed_names([str(self.number(k)) for k in numbers])}"


def is_fold(text: str) -> bool:
    """True for a text that is meant as FOLD."""
    return text.lstrip("\ufeff \t\r\n")[:1] == "{" and _MARKS.search(text) is not None


def read_frame(data: Data, file: str, number: int | None = None) -> FoldFrame:
    """A frame of a file, by its number; None: the key frame, or the first one that has edges or faces. Raises
    DesignError with what is wrong."""
    return _Reader(data, Place(file)).frame(number)


def fold_data(text: str, file: str, limits: Limits) -> Data:
    """A file as data. Raises DesignError where it is no map."""
    data = parsed(text, file, limits)
    if not isinstance(data, dict):
        raise DesignError("the file holds no object; FOLD is a map of lists", Place(file))
    return data


def crease_pattern(data: Data, file: str) -> int | None:
    """The number of a frame, not the key frame, that is a file's crease pattern; None where none says so."""
    return pattern_frame(data, _Reader(data, Place(file)).error)


class _Reader:
    """One file; every method raises DesignError with the place."""

    def __init__(self, data: Data, place: Place) -> None:
        self.data, self.place = data, place
        self.notes: list[str] = []

    def error(self, message: str) -> DesignError:
        return DesignError(message, self.place)

    def frame(self, number: int | None = None) -> FoldFrame:
        self._check_spec()
        data = chosen_frame(self.data, self.error, self.notes, number)
        vertices = self._vertices(data)
        faces = self._faces(data, len(vertices))
        edges = self._edges(data, len(vertices), faces)
        if faces is not None and any(len(set(face)) < len(face) for face in faces):
            self._tell_slits(faces, vertices)
            faces = None
        if data.get("faceOrders") or data.get("edgeOrders"):
            self.notes.append("the order of layers (faceOrders) is not used: facets pass through one another")
        angles = self._angles(data, len(edges))
        kinds = self._kinds(data, angles)
        kept = self._once(edges, kinds, angles)
        edges, faces, kept = with_seams(vertices, edges, kinds, angles, faces, kept, self.notes)
        title = next((t for t in (data.get("frame_title"), data.get("file_title")) if isinstance(t, str)), "")
        own = {key: value for key, value in data.items() if key.startswith("lamc:")}
        return FoldFrame(
            title,
            vertices,
            tuple(edges[k] for k in kept),
            "".join(kinds[k] for k in kept),
            tuple(angles[k] for k in kept),
            faces,
            self._unit(data),
            own,
            tuple(self.notes),
            numbers=tuple(kept) if len(kept) < len(edges) else (),
        )

    def _once(
        self, edges: Sequence[tuple[int, int]], kinds: str, angles: Sequence[float | None]
    ) -> list[int]:
        """Places of the edges, those that are drawn twice with the same fold once. Which of two folds is meant only the
        user knows."""
        seen: dict[tuple[int, int], int] = {}
        for index, ends in enumerate(edges):
            first = seen.setdefault((min(ends), max(ends)), index)
            if first == index:
                continue
            if (kinds[first], angles[first]) != (kinds[index], angles[index]):
                raise self.error(
                    f"edges {first} and {index} both join vertices {min(ends)} and {max(ends)}, and fold otherwise; "
                    "keep one"
                )
            self.notes.append(f"edge {index} is drawn as edge {first} is, and is left out")
        return sorted(seen.values())

    def _check_spec(self) -> None:
        spec = self.data.get("file_spec")
        if spec is not None and not (_is_number(spec) or isinstance(spec, str)):
            raise self.error(f"file_spec is {shown(spec)}; it must be a number such as 1.2")
        if isinstance(spec, int | float) and not 1.0 <= spec < 2.0:
            self.notes.append(f"the file says spec {spec:g}; it is read as 1.2")

    def _list(self, data: Data, key: str, length: int | None = None, of: str = "") -> list[Any]:
        found = data.get(key, [])
        if not isinstance(found, list):
            raise self.error(f"{key} is {shown(found)}; it must be a list")
        if length is not None and len(found) != length:
            raise self.error(f"{key} has {len(found)} entries for {length} {of}; each needs one")
        return found

    def _vertices(self, data: Data) -> Array:
        rows = self._list(data, "vertices_coords")
        if not rows:
            near = next((key for key in data if meant(key) == "vertices_coords"), None)
            also = f"; {near!r} is none of FOLD's keys: is that meant?" if near else ""
            raise self.error(
                f"the frame has no vertices_coords; lamc needs places, not only their order{also}"
            )
        found = np.zeros((len(rows), 3))
        for index, row in enumerate(rows):
            right = isinstance(row, list) and len(row) in (2, 3) and all(_is_number(v) for v in row)
            if not right:
                raise self.error(f"vertex {index} is {shown(row)}; it must be two or three numbers")
            for axis, value in enumerate(row):
                number = _float(value)
                if not abs(number) < LARGEST:
                    raise self.error(
                        f"vertex {index} has the coordinate {value:.6g}; less than {LARGEST:g} is read"
                        if math.isfinite(number)
                        else f"vertex {index} has a coordinate that is not finite"
                    )
                found[index, axis] = number
        return found

    def _faces(self, data: Data, count: int) -> tuple[tuple[int, ...], ...] | None:
        if not data.get("faces_vertices"):
            return None
        faces = []
        for index, face in enumerate(self._list(data, "faces_vertices")):
            corners = self._indices(face, count, f"face {index}")
            if len(set(corners)) < 3:
                raise self.error(
                    f"face {index} has the vertices {shown(list(corners))}; it needs three or more"
                )
            faces.append(corners)
        return tuple(faces)

    def _tell_slits(self, faces: tuple[tuple[int, ...], ...], vertices: Array) -> None:
        """Of faces that pass a vertex twice, around a slit or to a hole and back: edges of a flat sheet say as much."""
        index, face = next((k, face) for k, face in enumerate(faces) if len(set(face)) < len(face))
        passes = f"face {index} passes a vertex twice, {shown(list(face))}"
        if np.ptp(vertices[:, 2]) > 0.0:
            raise self.error(
                f"{passes}, as around a slit: that is read of flat sheets, not of folded ones; part the face by edges F"
            )
        self.notes.append(
            f"{passes}: faces are found from the edges and numbered anew; slits that end amid one are left out"
        )

    def _edges(
        self, data: Data, count: int, faces: tuple[tuple[int, ...], ...] | None
    ) -> tuple[tuple[int, int], ...]:
        if not data.get("edges_vertices"):
            if faces is None:
                raise self.error("the frame has neither edges_vertices nor faces_vertices; draw its edges")
            sides = ((min(a, b), max(a, b)) for face in faces for a, b in sides_of(face))
            return tuple(dict.fromkeys(sides))
        edges: list[tuple[int, int]] = []
        for index, edge in enumerate(self._list(data, "edges_vertices")):
            ends = self._indices(edge, count, f"edge {index}")
            if len(ends) != 2 or ends[0] == ends[1]:
                raise self.error(
                    f"edge {index} has the vertices {shown(list(ends))}; it needs two that differ"
                )
            edges.append((ends[0], ends[1]))
        return tuple(edges)

    def _indices(self, value: Any, count: int, what: str) -> tuple[int, ...]:
        if not isinstance(value, list):
            raise self.error(f"{what} is {shown(value)}; it must be a list of vertices")
        for each in value:
            if isinstance(each, bool) or not isinstance(each, int) or not 0 <= each < count:
                raise self.error(f"{what} names vertex {shown(each)}; vertices are 0 to {count - 1}")
        return tuple(value)

    def _kinds(self, data: Data, angles: Sequence[float | None]) -> str:
        if not data.get("edges_assignment"):
            if not any(angle is not None for angle in angles):
                self.notes.append(
                    "the file has no edges_assignment: every edge between two facets is a hinge without a spring (U)"
                )
            return "U" * len(angles)
        kinds = []
        for index, kind in enumerate(self._list(data, "edges_assignment", len(angles), "edges")):
            if not isinstance(kind, str) or len(kind) != 1 or kind.upper() not in KINDS:
                raise self.error(
                    f"edge {index} has the assignment {shown(kind)}; it must be one of {', '.join(KINDS)}"
                )
            kinds.append(kind.upper())
        return "".join(kinds)

    def _angles(self, data: Data, count: int) -> tuple[float | None, ...]:
        if not data.get("edges_foldAngle"):
            return (None,) * count
        angles: list[float | None] = []
        for index, angle in enumerate(self._list(data, "edges_foldAngle", count, "edges")):
            if angle is not None and not (_is_number(angle) and abs(_float(angle)) <= 180.0 + 1e-6):
                raise self.error(
                    f"edge {index} has the fold angle {shown(angle)}; it must be null or -180 to 180 degrees"
                )
            angles.append(None if angle is None else math.radians(float(angle)))
        return tuple(angles)

    def _unit(self, data: Data) -> float | None:
        unit = data.get("frame_unit", "unit")
        if unit == "unit":
            return None
        if not isinstance(unit, str) or unit not in UNITS:
            raise self.error(f"frame_unit is {shown(unit)}; it must be one of unit, {', '.join(UNITS)}")
        return UNITS[unit]


def sides_of(face: tuple[int, ...]) -> list[tuple[int, int]]:
    """Directed sides of a face."""
    return list(zip(face, (*face[1:], face[0]), strict=True))


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _float(value: int | float) -> float:
    try:
        return float(value)
    except OverflowError:
        return math.inf
