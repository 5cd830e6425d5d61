"""The geometry of a plate file: outline, regions, and the places where supports and loads are.

In: validated models, lengths in m. Out: shapely polygons, and places as `supports.Where`; every problem is noted at its
place in the file. Never: meshes.
"""

import math
from functools import partial
from pathlib import Path as FilePath

from shapely.geometry import LineString, Point, Polygon
from shapely.geometry.base import BaseGeometry

from lamc.basics.errors import DesignError
from lamc.design import shapes
from lamc.plates.designs.from_design import DesignPlate, plate_of
from lamc.plates.supports import Where
from lamc.readers.checking import Path, Problems, did_you_mean
from lamc.readers.load import load
from lamc.readers.plates.circles import corners_of
from lamc.readers.plates.geometry_schema import (
    FollowModel,
    GeometryModel,
    PlateOutlineModel,
    PlateRegionModel,
)
from lamc.readers.plates.polygons import cut, polygon_of_wkt
from lamc.readers.plates.problem_records import Region
from lamc.readers.plates.problem_schema import PlateFileModel, WhereModel
from lamc.readers.plates.section_file import Sections
from lamc.records.design import Design
from lamc.records.mechanism import checked_name

_ANYWHERE = LineString(
    [(0.0, 0.0), (1.0, 0.0)]
)  # of a plate whose outline is a problem that is noted already
_DOUBLED = (
    7  # times at most: 16 384 corners, with cells of a four-hundredth of a per cent of the radius beside them
)
NEAR = 1e-6  # of the plate's size: a point this close to an edge is on it


class DrawnGeometry:
    """What a file draws.

    outline  empty after a problem was noted
    regions  by name, those without problems; of a design's body, one for each of its stacks of layers
    body     the body of a design, where it is the plate
    """

    def __init__(
        self,
        model: PlateFileModel,
        sections: Sections,
        problems: Problems,
        step: float,
        drawn: tuple[float, int] | None = None,
    ) -> None:
        """drawn: circles have corners for edges of so many m, times so many."""
        self._problems = problems
        self._sections = sections
        self._step = step
        self._drawn = drawn
        self._share = 1.0 if drawn is None or model.geometry.size is None else drawn[0] / model.geometry.size
        self.has_circles = False
        self.body: DesignPlate | None = None
        self.regions: dict[str, Region] = {}
        self.outline: BaseGeometry = self._draw(model.geometry)
        for name, entry in model.regions.items():
            self._region(name, entry)

    @property
    def size(self) -> float:
        """Diagonal of the outline's box, m."""
        x0, y0, x1, y1 = self.outline.bounds
        return math.hypot(x1 - x0, y1 - y0)

    def covered(self) -> bool:
        """Whether regions with laminates of their own cover the plate."""
        own = sum(region.polygon.area for region in self.regions.values() if region.laminate is not None)
        return bool(self.outline.is_empty or self.outline.area - own < 1e-9 * self.outline.area)

    def holds(self, x: float, y: float) -> bool:
        """Whether a point is on the plate."""
        return self.outline.is_empty or self.distance(x, y) <= NEAR * self.size

    def distance(self, x: float, y: float) -> float:
        """Of a point from the plate, m."""
        return float(self.outline.distance(Point(x, y)))

    def named(self, name: str) -> Region:
        """The region of that name. Raises DesignError."""
        if name not in self.regions:
            raise DesignError(f"no region is named {name[:40]!r}; {did_you_mean(name, sorted(self.regions))}")
        return self.regions[name]

    def where(self, model: WhereModel, path: Path) -> Where | None:
        """The place as a problem takes it, or None after a problem was noted."""
        return self._problems.attempt(path, lambda: self._place(model))

    def followed(self, model: GeometryModel) -> list[BaseGeometry]:
        """Lines and points for the mesher; problems are noted."""
        found = []
        for index, entry in enumerate(model.follow):
            path: Path = ("geometry", "follow", index)
            place = self._problems.attempt(path, partial(self._line_or_point, entry))
            if place is not None:
                found.append(place)
        return found

    def edge_length(self, where: Where) -> float:
        """Length of the plate's edge at `where`, m. Raises DesignError where it has none there."""
        if self.outline.is_empty:
            return 1.0  # the problem with the outline is noted already
        edge, near = self.outline.boundary, NEAR * self.size
        length = float((edge if isinstance(where, str) else edge.intersection(where.buffer(near))).length)
        if isinstance(where, LineString):
            length = min(length, float(where.length))  # the buffer reaches around corners
        if not length > 10.0 * near:
            raise DesignError(
                "the plate has no edge there to spread a force along; give the force per length"
            )
        return length

    def _draw(self, model: GeometryModel) -> BaseGeometry:
        problems = self._problems
        if model.design is not None:
            return self._design(model)
        outer = problems.attempt(("geometry",), lambda: self._shape(model))
        holes = [
            problems.attempt(("geometry", "holes", index), partial(self._shape, hole))
            for index, hole in enumerate(model.holes)
        ]
        if outer is None:
            return Polygon()
        left = problems.attempt(("geometry", "holes"), lambda: cut(outer, holes))
        return left if left is not None else Polygon()

    def _design(self, model: GeometryModel) -> BaseGeometry:
        """The outline and the regions of a design's body."""
        self.body = self._problems.attempt(("geometry",), lambda: self._plate_of(model))
        if self.body is None:
            return Polygon()
        sizes = self.body.sizes
        for name, polygon in self.body.regions.items():
            self.regions[name] = Region(polygon, self.body.laminates[name], sizes.get(name))
        return self.body.outline

    def _plate_of(self, model: GeometryModel) -> DesignPlate:
        """Raises DesignError as `load` and `plate_of` do."""
        file = FilePath(self._problems.place(()).file).parent / (model.design or "")
        record = load(file)
        if not isinstance(record, Design):
            raise DesignError(
                f"{model.design!r} holds a mechanism, whose bodies have no layers; name a design"
            )
        return plate_of(record, model.body or (), hinges=model.hinges, materials=self._sections.materials)

    def _region(self, name: str, entry: PlateRegionModel) -> None:
        path: Path = ("regions", name)
        self._problems.attempt(path, lambda: checked_name(name, "a region"))
        laminate = (
            self._sections.laminate(entry.laminate, (*path, "laminate"))
            if entry.laminate is not None
            else None
        )
        shape = self._problems.attempt(path, lambda: self._shape(entry, entry.size))
        if shape is None or self.outline.is_empty:
            return
        inside = shape.intersection(self.outline)
        if not inside.area > 0.0:
            self._problems.add(path, "the region does not overlap the plate; move it, or leave it out")
            return
        for other, region in self.regions.items():
            if inside.intersection(region.polygon).area > 1e-9 * min(inside.area, region.polygon.area):
                self._problems.add(
                    path,
                    f"the region overlaps region {other!r}; a place has one region: cut one at the other",
                )
        self.regions[name] = Region(inside, laminate, entry.size)

    def _shape(
        self, model: PlateOutlineModel | GeometryModel | WhereModel, size: float | None = None
    ) -> BaseGeometry:
        """The drawn polygon, of a region with the file's own `size` for it, m. Raises DesignError."""
        if model.rect is not None:
            return shapes.rectangle(*model.rect)
        if model.circle is not None:
            self.has_circles = True
            radius = model.circle.radius
            return shapes.circle(*model.circle.center, radius, self._corners(radius, size))
        if model.polygon is not None:
            return shapes.polygon(model.polygon)
        text = getattr(model, "wkt", None)
        if text is not None:
            return polygon_of_wkt(text, self._step)
        raise DesignError("the shape has no outline")

    def _corners(self, radius: float, size: float | None) -> int:
        """Of a circle, with the file's own `size` for its region, m."""
        if self._drawn is None:
            return shapes.CIRCLE_SEGMENTS
        general, finer = self._drawn
        return corners_of(radius, general if size is None else min(general, size * self._share), finer)

    def _place(self, model: WhereModel) -> Where:
        if model.named == "boundary":
            return "boundary"
        if model.named == "fixed":
            return self._fixed()
        if model.named is not None:
            return self._side(model.named)
        if model.hinge is not None:
            return self._hinge(model.hinge)
        if model.point is not None or model.line is not None:
            return self._line_or_point(model)
        if model.region is not None:
            return self.named(model.region).polygon
        return self._shape(model)

    def _line_or_point(self, model: WhereModel | FollowModel) -> BaseGeometry:
        if model.point is not None:
            shapes.check_coordinates(model.point, "the point")
            return Point(model.point)
        line = model.line or []
        shapes.check_coordinates(line, "the line")
        if len(set(line)) < 2:
            raise DesignError("the points of the line are one point; it needs two that differ")
        return LineString(line)

    def _hinge(self, name: str) -> BaseGeometry:
        """The plate's edge along a hinge of the design, or the line of a hinge between its bodies."""
        if self.outline.is_empty:
            return _ANYWHERE
        if self.body is None:
            raise DesignError("only a plate of a design has hinges; name the place another way")
        if name in self.body.lines:
            return self.body.lines[name].where
        if name not in self.body.hinges:
            known = sorted([*self.body.hinges, *self.body.lines])
            raise DesignError(
                f"no hinge {name[:40]!r} joins the body to another; {did_you_mean(name, known)}"
            )
        line = self.body.hinges[name].line
        if line.is_empty:
            raise DesignError(
                f"nothing of the plate's edge lies along hinge {name!r}; set hinges: lines or strips"
            )
        return line

    def _fixed(self) -> BaseGeometry:
        """What the design holds of the plate."""
        if self.outline.is_empty:
            return _ANYWHERE
        if self.body is None or self.body.fixed.is_empty:
            raise DesignError("nothing of the plate is fixed by a design; name the place another way")
        return self.body.fixed

    def _side(self, side: str) -> LineString:
        """A side of the box around the outline."""
        if self.outline.is_empty:
            return _ANYWHERE
        x0, y0, x1, y1 = self.outline.bounds
        ends = {
            "left": ((x0, y0), (x0, y1)),
            "right": ((x1, y0), (x1, y1)),
            "bottom": ((x0, y0), (x1, y0)),
            "top": ((x0, y1), (x1, y1)),
        }
        return LineString(ends[side])
