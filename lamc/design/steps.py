"""Records of the splitting, step by step: what the picture, the tables and the joint-definition writer read.

They hold results and compute nothing. Lengths in metres, layers from bottom to top; every tuple has an order
that depends on geometry alone.
"""

from dataclasses import dataclass

from shapely.geometry import LineString, MultiPolygon, Polygon

from lamc.basics.errors import Place
from lamc.records.design import Design, HingeSet
from lamc.records.mechanism import Mechanism


@dataclass(frozen=True, eq=False)
class Hinge:
    """One hinge line, named, with the properties of its set."""

    name: str
    line: LineString  # m, from the drawn start to the drawn end
    z: float  # m, mid-plane of the flexible layer
    properties: HingeSet
    layers: tuple[int, ...]  # layers that the hinge runs through: sublaminate and flexible layer, ascending
    place: Place


@dataclass(frozen=True, eq=False)
class SplitBody:
    """One body as cut: its polygons in each layer of the design."""

    name: str
    fixed: bool
    polygons: tuple[tuple[Polygon, ...], ...]  # per layer


@dataclass(frozen=True, eq=False)
class Connection:
    """A hinge and the names of the two bodies that it joins; the parent is the one nearer to the world."""

    hinge: Hinge
    parent: str
    child: str


@dataclass(frozen=True, eq=False)
class Scrap:
    """A piece too small to be a body, left out of the mechanism: its polygons per layer."""

    polygons: tuple[tuple[Polygon, ...], ...]
    area: float  # m², of the layer where it is largest
    at: tuple[float, float]  # m, a point inside it


@dataclass(frozen=True, eq=False)
class SplitSteps:
    """Everything between a design and its mechanism.

    design       as drawn
    holes        per layer, what is removed where hinge lines meet
    slits        per layer, what is removed along hinge lines
    cut          per layer, the material that is left
    bodies       fixed ones first, then from left to right
    connections  one per hinge line, from left to right
    scraps       pieces too small to be bodies
    mechanism    what `split` gives
    facet_notes  what became of facets that bend
    """

    design: Design
    holes: tuple[MultiPolygon, ...]
    slits: tuple[MultiPolygon, ...]
    cut: tuple[MultiPolygon, ...]
    bodies: tuple[SplitBody, ...]
    connections: tuple[Connection, ...]
    scraps: tuple[Scrap, ...]
    mechanism: Mechanism
    facet_notes: tuple[str, ...] = ()

    @property
    def hinges(self) -> tuple[Hinge, ...]:
        return tuple(c.hinge for c in self.connections)

    @property
    def notes(self) -> tuple[str, ...]:
        """One line for each thing that was done and that the drawing did not ask for."""
        return (
            self.design.notes
            + self.facet_notes
            + tuple(
                f"left out a scrap of {s.area * 1e6:.3g} mm² at ({s.at[0] * 1e3:.6g}, {s.at[1] * 1e3:.6g}) mm: "
                "smaller than the square of half a gap, it is no body"
                for s in self.scraps
            )
        )
