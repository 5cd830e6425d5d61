"""The `Tree` record: links in an order in which parents precede children, and the hinges that close loops.

Each link has the frame of its hinge in the drawn configuration and the constant rotation from its parent's frame.
Numbers only; `plan` makes it.
"""

from dataclasses import dataclass

from lamc.basics.once import lazy
from lamc.records.mechanism import Array, Body, Joint, Mechanism

WORLD = -1


@dataclass(frozen=True, eq=False)
class Link:
    """A moving body with the hinge that carries it.

    The hinge's own turn is about z by angle_sign·q + angle_offset, after the constant turns `twist` (about z) and
    `fold` (about x), each as (cosine, sine), from the parent's frame. A `parallel` link has neither.
    """

    body: Body
    joint: Joint
    parent: int  # index of the parent link, WORLD for a hinge on a fixed body
    angle_sign: int
    angle_offset: float  # rad
    twist: tuple[float, float]
    fold: tuple[float, float]
    parallel: bool
    origin: Array  # (3,), m, world, drawn configuration: a point on the hinge line
    frame: Array  # (3, 3), world from link frame, drawn configuration; columns are the axes
    offset: Array  # (3,), m, origin from the parent's origin, in the parent's frame
    com: Array  # (3,), m, from the origin, in the link's frame
    inertia: Array  # (3, 3), kg·m², about the centre of mass, in the link's frame


@dataclass(frozen=True, eq=False)
class Side:
    """One side of a cut hinge: a point on its line and its directions, in the frame of the link that holds it."""

    link: int  # index of the link, WORLD for a fixed body; then the frame is the world's
    point: Array  # (3,), m
    axes: Array  # (3, 3): columns x, y across the hinge and z along it, equal on both sides as drawn


@dataclass(frozen=True, eq=False)
class Cut:
    """A hinge that closes a loop: it is no edge of the tree, and its two sides are held together by equations."""

    joint: Joint
    parent: Side
    child: Side


@dataclass(frozen=True, eq=False)
class Tree:
    """Links, parents before children; q[i] is the angle of links[i].joint. `cuts` close its loops."""

    mechanism: Mechanism
    links: tuple[Link, ...]
    cuts: tuple[Cut, ...] = ()

    @property
    def joint_names(self) -> tuple[str, ...]:
        return tuple(link.joint.name for link in self.links)

    @lazy
    def hinges(self) -> tuple[Joint, ...]:
        """All joints: the tree's in its order, then those that close loops. Angles q and rates u are in this order."""
        return (*(link.joint for link in self.links), *(cut.joint for cut in self.cuts))

    @property
    def depth(self) -> int:
        """Number of hinges on the longest way to the world."""
        depths: list[int] = []
        for link in self.links:
            depths.append(1 if link.parent == WORLD else depths[link.parent] + 1)
        return max(depths, default=0)

    def children(self, index: int) -> list[int]:
        return [i for i, link in enumerate(self.links) if link.parent == index]
