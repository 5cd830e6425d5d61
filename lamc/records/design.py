"""The `Design` record: a laminate as drawn. SI, radians, layers from bottom to top, z = 0 at the bottom.

Front ends (YAML, popupCAD) make it, `split` reads it. Lengths became metres and angles radians where the file
was read, and nowhere later.
"""

import math
import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from shapely.geometry import MultiPolygon, Point

from lamc.basics.brief import brief, counted
from lamc.basics.checks import checked_number
from lamc.basics.drawing import drawer
from lamc.basics.errors import Place
from lamc.basics.places import Places as Places
from lamc.basics.seen import Viewable
from lamc.records.drawing import Mend
from lamc.records.parameters import Origin, Varied
from lamc.records.scene import Scene, checked_scenes

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Line = tuple[tuple[float, float], tuple[float, float]]  # m, world x and y


@dataclass(frozen=True)
class Material:
    """A sheet material of a layer; plies of a plate have `lamc.plate.Material`, of which more has to be known.

    Moduli may be None where the file has none, or a placeholder that means none.
    """

    name: str
    density: float  # kg/m³
    E1: float | None = None  # Pa
    E2: float | None = None  # Pa
    poisson: float | None = None
    is_rigid: bool = False
    is_flexible: bool = False
    is_adhesive: bool = False
    is_conductive: bool = False
    G12: float | None = None  # Pa; with E1 = E2 and none of it, the material is isotropic


@dataclass(frozen=True)
class Layer:
    """One sheet of the laminate and what is left of it after cutting."""

    name: str
    material: Material
    thickness: float  # m
    geometry: MultiPolygon  # m, world x and y
    angle: float = 0.0  # rad, ply angle

    def __repr__(self) -> str:
        return brief("Layer", self.name, self.material.name, f"{self.thickness:g} m")


@dataclass(frozen=True)
class HingeLine:
    """One drawn hinge line; its direction start → end is the joint's axis."""

    line: Line  # m
    name: str | None = None
    place: Place = field(default_factory=Place)


@dataclass(frozen=True)
class HingeSet:
    """Hinge lines that share a flexible layer, a gap and properties (a popupCAD joint definition).

    width          m, half of the gap, popupCAD's number: lines are grown by it into strips, which bend, and holes are
                   cut where strips overlap; a tenth of it to either side is slit
    from_material  the stiffness was computed from the flexible layer, as the file asks for it
    """

    lines: tuple[HingeLine, ...]
    width: float  # m
    layer: int  # index of the flexible layer; the axis lies at its mid-plane
    sublaminate: tuple[int, ...]  # indices of the layers the hinge runs through
    stiffness: float = 0.0  # N·m/rad
    damping: float = 0.0  # N·m·s/rad
    rest_angle: float = 0.0  # rad
    limits: tuple[float, float] = (-math.pi, math.pi)  # rad
    from_material: bool = False

    @property
    def gap(self) -> float:
        """Length of bare film from link to link, across the line, m."""
        return 2.0 * self.width

    def __repr__(self) -> str:
        return brief(
            "HingeSet", "", counted(len(self.lines), "line"), f"layer {self.layer}", f"gap {self.gap:g} m"
        )


@dataclass(frozen=True)
class BodyName:
    """A name that the drawing gives to a body, by a point inside it.

    layer  index of the layer to look in, where sheets above one another hold several bodies; None: any layer
    """

    name: str
    point: Point  # m, world x and y
    layer: int | None = None


@dataclass(frozen=True)
class FacetCreases:
    """Facets bend: every moving one of four corners or more is parted along diagonals by hinges.

    stiffness  N·m/rad, of each; None: from the materials of the facet's layers
    damping    N·m·s/rad, of each
    """

    stiffness: float | None = None
    damping: float = 0.0

    def __post_init__(self) -> None:
        if self.stiffness is not None:
            checked_number(self.stiffness, "the stiffness of facet_creases", minimum=0.0)
        checked_number(self.damping, "the damping of facet_creases", minimum=0.0)


@dataclass(frozen=True)
class Design(Viewable, Varied):
    """A laminate device before splitting.

    fixed         per layer, the region held by the world; a body that overlaps it in any layer is fixed
    scene         what runs call for if nothing else is said; None: what the design itself asks for
    scenes        other scenes by name
    story         what the design is for, a paragraph of plain text; nothing is computed from it
    contact_points  points of the drawing, m, at which bodies may touch something, for scenes that ask for them
    notes         one line for each thing in the file that the design is without
    beside        files beside its own that it was read from too: name and SHA-256
    facet_creases  how facets bend along their diagonals; None: they are rigid
    mends         what healing changed in drawings that shapes and hinge lines were taken from
    origin        what it is made of again with other `parameters`; None: it is a drawing as such

    Designs are equal that have the same drawing and scenes, whatever they are made of.
    """

    name: str
    layers: tuple[Layer, ...]
    hinges: tuple[HingeSet, ...]
    fixed: tuple[MultiPolygon, ...]
    body_names: tuple[BodyName, ...] = ()
    scene: Scene | None = None
    source: str = ""  # the file's name, without its folder
    story: str = ""
    places: Places = field(default=Places(), compare=False, repr=False)
    scenes: Mapping[str, Scene] = field(default_factory=dict, hash=False)
    contact_points: tuple[tuple[float, float], ...] = ()  # m, world x and y
    notes: tuple[str, ...] = field(default=(), compare=False)
    beside: tuple[tuple[str, str], ...] = field(default=(), compare=False)
    facet_creases: FacetCreases | None = None
    mends: tuple[Mend, ...] = field(default=(), compare=False, repr=False)
    origin: Origin | None = field(default=None, compare=False, repr=False)

    _carried = ("name", "scene", "scenes", "story", "source", "places", "notes", "beside", "mends")

    def __post_init__(self) -> None:
        object.__setattr__(self, "scenes", checked_scenes(self.scenes, f"design {self.name!r}"))

    def __repr__(self) -> str:
        lines = sum(len(hinges.lines) for hinges in self.hinges)
        return brief(
            "Design",
            self.name,
            counted(len(self.layers), "layer"),
            counted(lines, "hinge line"),
            counted(len(self.scenes), "scene") if self.scenes else "",
        )

    @property
    def z(self) -> tuple[float, ...]:
        """Heights of the layer boundaries, m, shape (len(layers) + 1,)."""
        heights = [0.0]
        for layer in self.layers:
            heights.append(heights[-1] + layer.thickness)
        return tuple(heights)

    def draw(self, *, axes: "Axes | None" = None, path: "str | os.PathLike[str] | None" = None) -> "Axes":
        """The layers from above, what is held and the hinge lines with their names.

        axes  Matplotlib axes to draw on; None: a new figure
        path  a .png, .svg or .pdf file that the figure is written to, without opening a window

        Returns the axes. Raises LamcError for what cannot be written.
        """
        drawn: Axes = drawer("Design", "draw")(self, axes=axes, path=path)
        return drawn
