"""How a plate is held.

In: where, and which unknowns. Out: records, checked by themselves. Never: meshes; whether a support touches anything is
the problem's to say.

`where` is "boundary", or a shapely geometry: a node is held if it lies on it, or in it, within a tolerance. An edge
belongs to a support if its ends and its middle do. What depends on a direction (a hard simple support, a symmetry)
takes it from these edges: where two of them meet at a node and turn by less than 30° (simply supported ones by less
than 80°), they are taken for pieces of one smooth curve, and the node has their mean direction; where they turn by
more, it is a corner, and both directions hold.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import shapely
from shapely.geometry.base import BaseGeometry

from lamc.basics.checks import Array, checked_number, shown
from lamc.basics.errors import DesignError
from lamc.plates.elements.definition import DOFS

BOUNDARY = "boundary"
Where: TypeAlias = str | BaseGeometry
Value: TypeAlias = (
    float | Callable[[Array, Array], Array]
)  # or a function of x and y in m, called with arrays


@dataclass(frozen=True, eq=False)
class Support:
    """The named unknowns are `value` there.

    dofs   any of "u", "v", "w", "w_x", "w_y", "w_xy"
    value  a number, or a function of x and y that takes and gives arrays; m, m, m, no unit twice, 1/m

    An element without one of these unknowns makes the problem an error, but for "u" and "v": they bring a membrane.
    Raises DesignError.
    """

    where: Where
    dofs: Sequence[str]
    value: Value = 0.0

    def __post_init__(self) -> None:
        checked_where(self.where, "a Support")
        if isinstance(self.dofs, str):
            raise DesignError(
                f"dofs of a Support are {shown(self.dofs)}; put names into a tuple: ({self.dofs!r},)"
            )
        try:
            names = tuple(self.dofs)
        except TypeError as error:
            raise DesignError(
                f"dofs of a Support are {shown(self.dofs)}; they must be a tuple of names"
            ) from error
        if not names:
            raise DesignError("dofs of a Support are empty; name what it holds, such as ('w',)")
        for name in names:
            if name not in DOFS:
                raise DesignError(f"a Support holds {shown(name)}; it can hold {', '.join(DOFS)}")
        object.__setattr__(self, "dofs", tuple(dict.fromkeys(names)))
        if not callable(self.value):
            object.__setattr__(self, "value", checked_number(self.value, "the value of a Support"))


@dataclass(frozen=True, eq=False)
class Clamped:
    """Neither displacement nor slope: w = w_x = w_y = 0, and u = v = 0 where the element has them.

    Raises DesignError.
    """

    where: Where

    def __post_init__(self) -> None:
        checked_where(self.where, "a Clamped support")


@dataclass(frozen=True, eq=False)
class SimplySupported:
    """No deflection, w = 0; u and v are free.

    kind  "hard": nor any slope along the edge, as when a wall guides every fibre of the edge's face; "soft": free, and
          the edge's nodes are held one by one

    Both agree in thin-plate theory on a straight edge, and for an element whose deflection along an edge is a cubic of
    its ends' unknowns, where w = 0 holds along the whole edge only if it is hard. On a curved edge that the mesh gives
    as a polygon, w = 0 holds on the curve through the polygon's corners (`solving/curves.py`): along the polygon it
    would converge to another, stiffer plate (the paradox of Sapondzhyan and Babuška). Corners that turn by more than
    20°, and single ones, are those of a polygon that is meant; of a regular one of 8 or more a note tells.

    At a point there is no edge, and "hard" is "soft". Raises DesignError.
    """

    where: Where
    kind: str = "hard"

    def __post_init__(self) -> None:
        checked_where(self.where, "a SimplySupported edge")
        if self.kind not in ("hard", "soft"):
            raise DesignError(
                f"the kind of a SimplySupported edge is {shown(self.kind)}; it must be 'hard' (no slope along the "
                "edge) or 'soft'"
            )


@dataclass(frozen=True, eq=False)
class Symmetry:
    """No slope across the edge, and no displacement across it: the mirror image lies beyond.

    The laminate is not mirrored with it: only one that does not couple bending and twisting (D16 = D26 = 0, and the
    same of A and B) in the edge's own axes is symmetric, and others are refused. Raises DesignError.
    """

    where: Where

    def __post_init__(self) -> None:
        checked_where(self.where, "a Symmetry")


@dataclass(frozen=True, eq=False)
class Hinged:
    """Hinged to a body that stands still: no displacement, u = v = w = 0, and no slope along the line.

    stiffness  moment per angle and length of the line, N/rad; 0: turns freely

    Raises DesignError.
    """

    where: Where
    stiffness: float = 0.0

    def __post_init__(self) -> None:
        checked_where(self.where, "a Hinged support")
        value = checked_number(self.stiffness, "the stiffness of a Hinged support", minimum=0.0)
        object.__setattr__(self, "stiffness", value)


SupportRecord: TypeAlias = Support | Clamped | SimplySupported | Symmetry | Hinged
SUPPORTS = (Support, Clamped, SimplySupported, Symmetry, Hinged)


def checked_where(where: object, what: str) -> None:
    """Raises DesignError unless `where` is "boundary" or a geometry that is neither empty nor invalid."""
    if isinstance(where, str):
        if where != BOUNDARY:
            raise DesignError(f"{what} is at {shown(where)}; it must be 'boundary' or a shapely geometry")
        return
    if not isinstance(where, BaseGeometry):
        raise DesignError(f"{what} is at {shown(where)}; it must be 'boundary' or a shapely geometry")
    if where.is_empty:
        raise DesignError(f"{what} is at an empty geometry; give a point, a line or a polygon")
    if not where.is_valid:
        raise DesignError(
            f"{what} is at a geometry that is not valid ({where_text(where)}); repair it, as by shapely.make_valid"
        )


def where_text(where: Where) -> str:
    """A place as a message shows it."""
    if isinstance(where, str):
        return where
    parts = shapely.get_parts(where)
    others = f" and {len(parts) - 1} more" if len(parts) > 1 else ""
    dimension = int(shapely.get_dimensions(where))
    if dimension == 0:
        return f"{_point_text(shapely.get_coordinates(parts[0])[0])}{others}"
    if dimension == 1:
        line = shapely.get_coordinates(parts[0])
        bends = f" by way of {len(line) - 2} more points" if len(line) > 2 else ""
        return f"the line from {_point_text(line[0])} to {_point_text(line[-1])}{bends}{others}"
    low, high = shapely.bounds(where).reshape(2, 2)
    return f"the area between {_point_text(low)} and {_point_text(high)}"


def _point_text(point: Array) -> str:
    return f"({point[0]:.6g}, {point[1]:.6g})"


def support_text(support: SupportRecord) -> str:
    """A support as a message names it."""
    return "the Support" if isinstance(support, Support) else f"the {type(support).__name__} support"
