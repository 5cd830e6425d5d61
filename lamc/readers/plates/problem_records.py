"""What a plate file says, as records: SI, geometry in shapely.

In: values that `problem_file` has checked. Out: a `PlateFile`. Never: YAML, units, meshes; `problem_make` makes a
`Problem` of it.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace

from shapely.geometry.base import BaseGeometry

from lamc.plates.foundations import ElasticFoundation
from lamc.plates.hinge_lines import HingeLine
from lamc.plates.laminates.laminate import Laminate
from lamc.plates.loads import LoadRecord
from lamc.plates.supports import SupportRecord
from lamc.readers.plates.origins import Origins

CELLS_ALONG = 40  # of the longer side, where a file gives neither a grid nor a size


@dataclass(frozen=True, eq=False)
class Region:
    """A part of the plate by name; None: as the rest of the plate."""

    polygon: BaseGeometry  # m
    laminate: Laminate | None = None
    size: float | None = None  # m, of the mesh's edges


@dataclass(frozen=True, eq=False)
class Geometry:
    """An outline and how it is meshed.

    grid     cells along x and y of a regular mesh of a rectangle; None: a mesh that follows the outline
    size     m, of the mesh's edges without a grid; None: the longer side over CELLS_ALONG
    regions  parts by name, in the order of the file
    follow   lines and points inside, m, on which edges and corners of a mesh without a grid shall be
    """

    outline: BaseGeometry  # m
    grid: tuple[int, int] | None = None
    pattern: str = "one-diagonal"
    size: float | None = None
    regions: Mapping[str, Region] = field(default_factory=dict)
    follow: Sequence[BaseGeometry] = ()


@dataclass(frozen=True)
class Output:
    """A value that is asked for at a point; `expected` in the value's unit, None where the file does not say."""

    name: str
    at: tuple[float, float]  # m
    value: str = "w"
    expected: float | None = None


@dataclass(frozen=True, eq=False)
class PlateFile:
    """A plate problem as it was written.

    laminate   of the plate where no region has its own; None where all have
    cases      loads by the name of the case; one of the name "" where the file has no cases
    story      what the problem is about, a paragraph; nothing is computed from it
    origins    where the file says what
    hinges     lines inside the plate that fold, those of a design's joints first
    foundations  elastic ground under the plate
    notes      what was done to make a plate of a design and its drawing did not ask for
    drawing    how to draw its circles with more corners; None: it has none
    """

    name: str
    geometry: Geometry
    laminate: Laminate | None
    element: str = "dkt"
    supports: Sequence[SupportRecord] = ()
    cases: Mapping[str, Sequence[LoadRecord]] = field(default_factory=dict)
    outputs: Sequence[Output] = ()
    modes: int = 0
    buckling: int = 0
    story: str = ""
    origins: Origins = field(default_factory=Origins)
    hinges: Sequence[HingeLine] = ()
    foundations: Sequence[ElasticFoundation] = ()
    notes: Sequence[str] = ()
    drawing: "Drawing | None" = None

    def size_of(self, size: float | None = None) -> float:
        """Length of the mesh's edges where regions have none of their own, m; `size` in place of the file's."""
        x0, y0, x1, y1 = self.geometry.outline.bounds
        return size or self.geometry.size or float(max(x1 - x0, y1 - y0)) / CELLS_ALONG

    def drawn_for(self, size: float | None = None, finer: int = 1) -> "PlateFile":
        """The same with circles of as many corners as edges of `size` m call for, and `finer` times as many. On a grid,
        without circles, and where places were changed since the file was read: the same."""
        drawing = self.drawing
        if drawing is None or self.geometry.grid is not None or not drawing.is_of(self):
            return self
        wanted = (self.size_of(size), finer)
        if wanted == drawing.drawn:
            return self
        other = drawing.make(*wanted)
        return replace(
            self,
            geometry=other.geometry,
            supports=other.supports,
            cases={name: other.cases[name] for name in self.cases},
            hinges=other.hinges,
            outputs=other.outputs,
            origins=other.origins,
            drawing=other.drawing,
        )


@dataclass(frozen=True, eq=False)
class Drawing:
    """How a file is read once more for another mesh.

    make       the file whose circles are drawn for edges of so many m, with so many times their corners
    drawn      what it was drawn for; None: 128 corners each
    geometry, supports, cases, hinges, outputs  as they were read
    """

    make: Callable[[float, int], PlateFile]
    drawn: tuple[float, int] | None
    geometry: Geometry
    supports: Sequence[SupportRecord]
    cases: Mapping[str, Sequence[LoadRecord]]
    hinges: Sequence[HingeLine]
    outputs: Sequence[Output]

    def is_of(self, file: PlateFile) -> bool:
        """Whether the places of `file` are still those that were read; it may have fewer cases."""
        return all(
            getattr(file, name) is getattr(self, name)
            for name in ("geometry", "supports", "hinges", "outputs")
        ) and all(self.cases.get(name) is own for name, own in file.cases.items())
