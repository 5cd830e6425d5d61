"""The `Mechanism` record: rigid bodies and the hinges between them, in the drawn (flat) configuration.

Everything is SI and in world axes. Records are checked when they are made, so a `Mechanism` that exists is
well formed; what needs more than one look (a path to the world, loops) is the business of `tree.py`.
"""

import math
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np
from shapely.geometry import Polygon

from lamc.basics import units
from lamc.basics.brief import brief, counted
from lamc.basics.checks import Array as Array
from lamc.basics.checks import checked_array as checked_array
from lamc.basics.checks import checked_flag, checked_range, checked_records, shown
from lamc.basics.checks import checked_name as checked_name
from lamc.basics.checks import checked_number as checked_number
from lamc.basics.drawing import drawer
from lamc.basics.errors import DesignError, TopologyError
from lamc.basics.given import GivenNumber
from lamc.basics.once import lazy
from lamc.basics.seen import Viewable
from lamc.records.drawing import Mend
from lamc.records.network import faults, listed_names
from lamc.records.parameters import Origin, Varied
from lamc.records.scene import Scene, checked_scenes

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from lamc.records.design import Design

Named = TypeVar("Named", "Body", "Joint")

FREE_LIMITS = (-math.pi, math.pi)


# Sizes of a mechanism by which no point of a body lies aside: mm that are taken for m are 1000 times too large
FAR = 100.0


@dataclass(frozen=True)
class Slab:
    """One flat piece of a body: a polygon (m, world x and y) between two heights (m)."""

    polygon: Polygon
    z_bottom: float  # m
    z_top: float  # m


def same_record(a: Any, b: Any) -> bool:
    """Equality of two dataclass instances by the fields that are compared, which may be arrays."""
    if type(a) is not type(b):
        return False
    compared = (f.name for f in fields(a) if f.compare)
    return all(bool(np.array_equal(getattr(a, name), getattr(b, name))) for name in compared)


@dataclass(frozen=True, eq=False)
class Body:
    """A rigid body in the drawn configuration.

    mass    kg; may be zero for a fixed body only
    com     centre of mass, shape (3,), m, world axes
    inertia about the centre of mass, shape (3, 3), kg·m², world axes, symmetric, positive semi-definite,
            no principal moment above the sum of the other two
    fixed   True if the body is part of the world
    outline the plates the body is made of, for pictures; may be empty
    """

    name: str
    mass: GivenNumber = 0.0  # type: ignore[assignment]  # kg
    com: Array = field(default_factory=lambda: np.zeros(3))  # m
    inertia: Array = field(default_factory=lambda: np.zeros((3, 3)))  # kg·m²
    fixed: bool = False
    outline: tuple[Slab, ...] = ()

    def __post_init__(self) -> None:
        put = _setter(self)
        put("name", checked_name(self.name, "a body"))
        what = f"body {self.name!r}"
        put("mass", checked_number(self.mass, f"the mass of {what}", minimum=0.0, quantity=units.MASS))
        put("com", checked_array(self.com, (3,), f"the centre of mass of {what}", units.LENGTH))
        put("inertia", checked_array(self.inertia, (3, 3), f"the inertia of {what}"))
        put("outline", checked_records(self.outline, Slab, "outline", what))
        put("fixed", checked_flag(self.fixed, f"fixed of {what}"))
        if not self.fixed:
            self._check_inertia(what)

    def __repr__(self) -> str:
        return brief("Body", self.name, "fixed" if self.fixed else "", f"{self.mass:g} kg")

    def _check_inertia(self, what: str) -> None:
        if self.mass == 0.0:
            raise DesignError(f"{what} has zero mass; give it a thickness and a density, or fix it")
        size = float(np.abs(self.inertia).max())
        # 1e-9 relative: files carry inertia with ten digits or more; a wrong sign or axis is far beyond that.
        if (np.abs(self.inertia - self.inertia.T) > 1e-9 * size).any():
            raise DesignError(f"the inertia of {what} is not symmetric")
        moments = np.linalg.eigvalsh(self.inertia)
        if moments.min() < -1e-9 * size:
            raise DesignError(f"the inertia of {what} has a negative principal moment; no real body has")
        if moments[2] - moments[0] - moments[1] > 1e-9 * size:
            raise DesignError(
                f"the inertia of {what} has a principal moment of {moments[2]:g} kg·m², more than the other two "
                "together; no real body has"
            )

    __eq__ = same_record
    __hash__ = None  # type: ignore[assignment]


@dataclass(frozen=True, eq=False)
class Joint:
    """A hinge between two bodies.

    The joint angle is zero in the drawn configuration and positive by the right-hand rule about `axis`, child
    relative to parent. Hinge torque on the child about `axis`: -stiffness (angle - rest_angle) - damping rate.

    Numbers are SI; text has its unit, as in stiffness="3 N*mm/deg".

    point      a point on the hinge line, shape (3,), m, world, drawn configuration
    axis       direction of the hinge line, shape (3,), world; made a unit vector
    limits     (lower, upper) angle, rad; (-π, π) means none were given
    """

    name: str
    parent: str
    child: str
    point: Array = field(default_factory=lambda: np.zeros(3))  # m
    axis: Array = field(default_factory=lambda: np.array([0.0, 0.0, 1.0]))
    stiffness: GivenNumber = 0.0  # type: ignore[assignment]  # N·m/rad
    damping: GivenNumber = 0.0  # type: ignore[assignment]  # N·m·s/rad
    rest_angle: GivenNumber = 0.0  # type: ignore[assignment]  # rad
    limits: tuple[float, float] = FREE_LIMITS  # rad

    def __post_init__(self) -> None:
        put = _setter(self)
        put("name", checked_name(self.name, "a joint"))
        what = f"joint {self.name!r}"
        put("parent", checked_name(self.parent, f"the parent of {what}"))
        put("child", checked_name(self.child, f"the child of {what}"))
        put("point", checked_array(self.point, (3,), f"the point of {what}", units.LENGTH))
        axis = checked_array(self.axis, (3,), f"the axis of {what}")
        length = float(np.linalg.norm(axis))
        if length == 0.0 or not math.isfinite(length):
            raise DesignError(f"the axis of {what} is {axis.tolist()}; it must have a direction")
        # A unit vector stays as it is: dividing once more by 1 ± 1 ulp would change what a file wrote and reads.
        unit = axis if abs(length - 1.0) < 1e-15 else axis / length
        unit.flags.writeable = False
        put("axis", unit)
        put(
            "stiffness",
            checked_number(self.stiffness, f"the stiffness of {what}", minimum=0.0, quantity=units.STIFFNESS),
        )
        put(
            "damping",
            checked_number(self.damping, f"the damping of {what}", minimum=0.0, quantity=units.DAMPING),
        )
        put("rest_angle", checked_number(self.rest_angle, f"the rest angle of {what}", quantity=units.ANGLE))
        put("limits", checked_range(self.limits, what))
        if self.parent == self.child:
            raise TopologyError(f"{what} joins {self.parent!r} to itself; a hinge needs two different bodies")

    __eq__ = same_record
    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        return brief("Joint", self.name, f"{self.child!r} on {self.parent!r}", f"{self.stiffness:g} N·m/rad")

    @property
    def is_limited(self) -> bool:
        """True if the drawn limits are narrower than ±180°."""
        return self.limits[0] > FREE_LIMITS[0] + 1e-12 or self.limits[1] < FREE_LIMITS[1] - 1e-12


@dataclass(frozen=True, eq=False)
class Mechanism(Viewable, Varied):
    """Bodies and joints; what `split` gives, or written by hand.

    scene   what runs call for if nothing else is said; None: what the joints ask for, and gravity
    scenes  other scenes by name
    story   what the mechanism is for, a paragraph of plain text; nothing is computed from it; without
            white space at its ends
    contact_points  points of the drawing, m, world x and y, at which bodies may touch something; effects of contact
            take them where a scene says so
    design  the drawing that it was split from, for effects that ask what bodies and hinges are made of; None: none, as
            in files of mechanisms. It takes no part in comparisons
    facet_creases  names of joints along which facets bend; a start leaves them flat where it can
    mends  what healing changed in the drawing that it was read from
    origin  what it is made of again with other `parameters`; None: its file, or whoever made it by hand, has none

    Raises DesignError for duplicate names and wrong types, and TopologyError for a joint to a body that is not
    there, for one hinge given twice, and where nothing is fixed.
    """

    bodies: tuple[Body, ...]
    joints: tuple[Joint, ...]
    name: str = "mechanism"
    scene: Scene | None = None
    story: str = ""
    scenes: Mapping[str, Scene] = field(default_factory=dict)
    contact_points: tuple[tuple[float, float], ...] = ()  # m
    design: "Design | None" = field(default=None, compare=False, repr=False)
    facet_creases: tuple[str, ...] = ()
    mends: tuple[Mend, ...] = field(default=(), compare=False, repr=False)
    origin: Origin | None = field(default=None, compare=False, repr=False)

    _carried = ("name", "scene", "scenes", "story", "design", "mends")

    def __post_init__(self) -> None:
        put = _setter(self)
        put("name", checked_name(self.name, "the mechanism"))
        what = f"mechanism {self.name!r}"
        put("bodies", checked_records(self.bodies, Body, "bodies", what))
        put("joints", checked_records(self.joints, Joint, "joints", what))
        if self.scene is not None and not isinstance(self.scene, Scene):
            raise DesignError(f"scene of {what} is {shown(self.scene)}; it must be a Scene, or None")
        put("scenes", checked_scenes(self.scenes, what))
        if not isinstance(self.story, str):
            raise DesignError(f"story of {what} is {shown(self.story)}; it must be text")
        put("story", self.story.strip())
        drawn = checked_array(
            np.reshape(self.contact_points, (-1, 2))
            if len(self.contact_points) == 0
            else self.contact_points,
            (len(self.contact_points), 2),
            f"contact_points of {what}",
        )
        put("contact_points", tuple((float(x), float(y)) for x, y in drawn))
        fault = next(faults(self.bodies, self.joints), None)
        if fault is not None:
            raise fault.error

    __eq__ = same_record
    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        return brief(
            "Mechanism",
            self.name,
            counted(len(self.bodies), "body", "bodies"),
            counted(len(self.joints), "joint"),
        )

    def body(self, name: str) -> Body:
        """The body of that name. Raises KeyError with the names there are."""
        return _named(self._bodies_by_name, name, "body")

    def joint(self, name: str) -> Joint:
        """The joint of that name. Raises KeyError with the names there are."""
        return _named(self._joints_by_name, name, "joint")

    @lazy
    def _bodies_by_name(self) -> dict[str, Body]:
        return {body.name: body for body in self.bodies}

    @lazy
    def _joints_by_name(self) -> dict[str, Joint]:
        return {joint.name: joint for joint in self.joints}

    @lazy
    def size(self) -> float:
        """Length scale, m: the diagonal of the box around centres of mass and hinge points (1 if that is nil)."""
        points = np.array([*(b.com for b in self.bodies if not b.fixed), *(j.point for j in self.joints)])
        diagonal = float(np.linalg.norm(np.ptp(points, axis=0))) if len(points) else 0.0
        return diagonal or 1.0

    def apart(self, body: str, point: Sequence[float]) -> float:
        """How many times its size a point (3,), m, lies from a body's centre of mass, as drawn."""
        return math.dist(point, self.body(body).com) / self.size

    def draw(
        self,
        angles: Mapping[str, float] | None = None,
        *,
        axes: "Axes | None" = None,
        path: "str | os.PathLike[str] | None" = None,
        camera: str | Sequence[float] | None = None,
        size: int | None = None,
    ) -> "Axes":
        """The bodies in space.

        angles  rad, by joint, as in a `Scene`; those left out follow from closure, or are zero
        axes    Matplotlib axes to draw on; None: a new figure
        path    a .png, .svg or .pdf file that the figure is written to, without opening a window
        camera  "front", "top", "corner", … or (azimuth, elevation), degrees; None: where faces are seen best
        size    pixels of the longer side

        Returns the axes. Raises DesignError for angles at which loops do not close, RequestError for a camera or a
        size that there is not, LamcError for what cannot be written.
        """
        drawn: Axes = drawer("Mechanism", "draw")(
            self, angles, axes=axes, path=path, camera=camera, size=size
        )
        return drawn


def _setter(record: object) -> Any:
    return lambda name, value: object.__setattr__(record, name, value)


def _named(items: Mapping[str, Named], name: str, what: str) -> Named:
    if name in items:
        return items[name]
    raise KeyError(f"no {what} is named {name!r}; there are {listed_names(list(items))}")
